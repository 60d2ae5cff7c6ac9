//! The table: ellipses by angle and inverse distance.

use crate::math::DVec2;

/// An ellipse of the plane across the line from a point to C: symmetric about the meridional plane.
#[derive(Clone, Copy, Debug)]
pub(super) struct Ellipse {
    /// Of its center, away from the axis, mm.
    pub center: f64,
    /// Half axes in the meridional plane and across it, mm.
    pub axes: DVec2,
}

impl Ellipse {
    pub(super) fn area(&self) -> f64 {
        std::f64::consts::PI * self.axes.x * self.axes.y
    }

    /// From the unit disk.
    pub(super) fn point(&self, p: DVec2) -> DVec2 {
        DVec2::new(self.center, 0.0) + self.axes * p
    }

    /// The squared distance of a point from the center, 1 on the ellipse.
    pub(super) fn radius2(&self, p: DVec2) -> f64 {
        ((p - DVec2::new(self.center, 0.0)) / self.axes).length_squared()
    }
}

/// Where light through an ellipse lands on the film: in a circle.
#[derive(Clone, Copy, Debug)]
pub(super) struct Image {
    /// Of its center, mm from the axis in the direction of the point's azimuth (as a rule negative: images are upside down).
    pub height: f64,
    pub radius: f64,
}

/// What to draw from.
#[derive(Clone, Copy, Debug)]
pub(super) enum Region {
    Ellipse(Ellipse),
    /// The first surface.
    Cap,
}

/// Center and half axes of an ellipse, height and radius of its image.
pub(super) type Fit = [f64; 5];

/// The ellipses of a range of angles and inverse distances.
#[derive(Clone, Copy, Debug)]
pub(super) enum Patch {
    /// No light.
    Dark,
    /// Between `fits` at the low and high end in angle, of these at the low and high end in inverse distance, all made larger
    /// by a factor; images by a length, mm.
    Ellipses {
        fits: [[Fit; 2]; 2],
        grown: f64,
        image_grown: f64,
    },
    /// There is light that is held by no ellipse.
    Astray,
}

impl Patch {
    /// At these fractions of the way through angles and inverse distances.
    pub(super) fn at(&self, s: f64, r: f64) -> Option<(Region, Option<Image>)> {
        match self {
            Patch::Dark => None,
            Patch::Astray => Some((Region::Cap, None)),
            Patch::Ellipses {
                fits,
                grown,
                image_grown,
            } => {
                let [center, along, across, height, radius] = between(fits, s, r);
                let ellipse = Ellipse {
                    center,
                    axes: *grown * DVec2::new(along, across),
                };
                let image = Image {
                    height,
                    radius: radius + image_grown,
                };
                Some((Region::Ellipse(ellipse), Some(image)))
            }
        }
    }
}

/// Linear in both.
fn between(fits: &[[Fit; 2]; 2], s: f64, r: f64) -> Fit {
    std::array::from_fn(|i| {
        let at = |fits: &[Fit; 2]| fits[0][i] + r * (fits[1][i] - fits[0][i]);
        let (low, high) = (at(&fits[0]), at(&fits[1]));
        low + s * (high - low)
    })
}

/// A range of inverse distances.
#[derive(Clone, Debug)]
pub(super) struct Slab {
    /// Its ends, in units of one over the nearest distance.
    pub v: [f64; 2],
    /// What angles ([`super::view::View::t`]) are relative to at both ends: where light ends. Linear in between.
    pub edges: [f64; 2],
    /// Relative angles at which patches end, the first beginning at 0. Beyond the last it is dark ...
    pub ends: Vec<f64>,
    pub patches: Vec<Patch>,
    /// ... unless light reaches farther from the axis than tables do.
    pub open: bool,
}

impl Slab {
    /// For a point at angle `t` and inverse distance `v`, and where its light lands; `None` where no light passes.
    pub(super) fn region(&self, t: f64, v: f64) -> Option<(Region, Option<Image>)> {
        let (w, r) = self.relative(t, v);
        let i = self.ends.partition_point(|end| *end < w);
        match self.patches.get(i) {
            Some(patch) => patch.at(self.fraction(i, w), r),
            None => self.open.then_some((Region::Cap, None)),
        }
    }

    /// The relative angle and the fraction of the slab.
    fn relative(&self, t: f64, v: f64) -> (f64, f64) {
        let r = (v - self.v[0]) / (self.v[1] - self.v[0]);
        (t / (self.edges[0] + r * (self.edges[1] - self.edges[0])), r)
    }

    /// How far through patch `i` the relative angle `w` is.
    fn fraction(&self, i: usize, w: f64) -> f64 {
        let start = i.checked_sub(1).map_or(0.0, |before| self.ends[before]);
        (w - start) / (self.ends[i] - start)
    }

    /// Makes the region of a point at `t` and `v` hold the point `p`, and its image the film point, along and across. Returns `true` if either
    /// has become larger.
    pub(super) fn include(&mut self, t: f64, v: f64, p: DVec2, film: DVec2) -> bool {
        let (w, r) = self.relative(t, v);
        let i = self.ends.partition_point(|end| *end < w);
        let Some(s) = self.patches.get(i).map(|_| self.fraction(i, w)) else {
            return !std::mem::replace(&mut self.open, true);
        };
        self.patches[i].include(s, r, p, film)
    }
}

impl Patch {
    /// See [`Slab::include`].
    fn include(&mut self, s: f64, r: f64, p: DVec2, film: DVec2) -> bool {
        /// What was met is hardly the farthest.
        const MORE: f64 = 1.02;
        let found = self.at(s, r);
        match (found, &mut *self) {
            (
                Some((Region::Ellipse(e), Some(image))),
                Patch::Ellipses {
                    grown, image_grown, ..
                },
            ) => {
                let radius = e.radius2(p).sqrt();
                let beyond = film.distance(DVec2::new(image.height, 0.0)) - image.radius;
                *grown *= if radius > 1.0 { MORE * radius } else { 1.0 };
                *image_grown += (MORE * beyond).max(0.0);
                radius > 1.0 || beyond > 0.0
            }
            (_, Patch::Astray) => false,
            (_, patch) => {
                *patch = Patch::Astray;
                true
            }
        }
    }
}
