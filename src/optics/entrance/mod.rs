//! Where to aim from the scene: through which part of the lens light from a point in front of it reaches the film.
//!
//! The other way round than [`super::pupil`], and a question of three dimensions, not two: a point has an angle to the axis and a
//! distance. Lines from a point x are told apart by where they meet the plane through C *perpendicular* to x–C, where C is the middle of
//! the paraxial entrance pupil: there the lines that pass the lens hardly move with x. They are held by an ellipse,
//! its center in x's meridional plane, tabulated by angle and inverse distance (`survey`) and turned to x's azimuth (`view`). The plane is no
//! surface of the lens, and need not be: étendue is that of lines (for any surface that every line meets once).
//!
//! The first surface itself never misses a line, and serves points nearer than the table and what it cannot hold (`cap`); but of lines to a wide-angle lens'
//! first surface one in ten passes, of a fisheye's one in two hundred.

mod cap;
mod sight;
mod survey;
mod table;
#[cfg(test)]
mod tests;
mod view;

pub use self::cap::Cap;
use self::survey::Survey;
use self::table::{Region, Slab};
use self::view::View;
use super::lens::Lens;
use super::pupil::ExitPupil;
use super::trace::LensRay;
use crate::math::sampling::concentric_disk;
use crate::math::{DVec2, DVec3, Vec2};

/// The part of the film where light counts: a rectangle, mm.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FilmWindow {
    /// Its lowest corner.
    pub low: [f64; 2],
    /// Its highest corner.
    pub high: [f64; 2],
}

impl FilmWindow {
    /// Returns `true` if the film point lies in it.
    pub fn holds(&self, p: [f64; 2]) -> bool {
        (0..2).all(|i| p[i] >= self.low[i] && p[i] <= self.high[i])
    }

    /// The farthest that any of its points lies from the axis, mm.
    pub fn radius(&self) -> f64 {
        let farthest = |i: usize| self.low[i].abs().max(self.high[i].abs());
        farthest(0).hypot(farthest(1))
    }

    /// The squared distance of `p` from it.
    fn distance2(&self, p: DVec2) -> f64 {
        let nearest = p.clamp(DVec2::from(self.low), DVec2::from(self.high));
        p.distance_squared(nearest)
    }
}

/// One lens that is to be aimed at, and the exit pupil of its film.
pub type Seen<'a> = (&'a Lens, &'a ExitPupil);

/// For every point in front of a lens the directions that may reach its film.
#[derive(Clone, Debug)]
pub struct EntrancePupil {
    /// z of C.
    center_z: f64,
    /// Points nearer to C are in no table.
    near: f64,
    /// By inverse distance, from 0 on.
    slabs: Vec<Slab>,
    cap: Cap,
    window: FilmWindow,
}

/// A direction that was drawn.
#[derive(Clone, Copy, Debug)]
pub struct Drawn {
    /// From the point toward the lens, unit length, in lens coordinates.
    pub d: DVec3,
    /// Its density per solid angle at the point.
    pub density: f64,
}

impl EntrancePupil {
    /// For light that lands in `window`. The first of `lenses` is surveyed; of the others, which differ little from it (in other colors),
    /// no light is missed either. At least one.
    pub fn new(lenses: &[Seen<'_>], window: FilmWindow) -> Option<EntrancePupil> {
        let survey = Survey::new(lenses, window)?;
        let mut pupil = EntrancePupil {
            center_z: survey.center_z(),
            near: survey.near(),
            slabs: survey.slabs(),
            cap: Cap::new(lenses.first()?.0)?,
            window,
        };
        for seen in lenses {
            pupil.make_room(*seen);
        }
        Some(pupil)
    }

    /// Draws a direction from the point `x` (lens coordinates, mm) for `u` in the unit square; `None` where no light from there reaches the
    /// window.
    pub fn draw(&self, x: DVec3, u: Vec2) -> Option<Drawn> {
        let view = View::new(x, self.center_z)?;
        match self.region(&view)? {
            Region::Ellipse(e) => {
                let p = e.point(concentric_disk(u).as_dvec2());
                let d = view.toward(p);
                Some(Drawn {
                    d,
                    density: view.density(d) / e.area(),
                })
            }
            Region::Cap => {
                let d = self.cap.direction(x, concentric_disk(u).as_dvec2())?;
                let density = self.cap.density(x, d)?;
                Some(Drawn { d, density })
            }
        }
    }

    /// The density per solid angle with which [`EntrancePupil::draw`] finds the unit direction `d` from `x`; 0 where it does not.
    pub fn density(&self, x: DVec3, d: DVec3) -> f64 {
        self.find(x, d).unwrap_or(0.0)
    }

    fn find(&self, x: DVec3, d: DVec3) -> Option<f64> {
        let view = View::new(x, self.center_z)?;
        match self.region(&view)? {
            Region::Ellipse(e) => {
                let holds = e.radius2(view.point(d)?) <= 1.0;
                holds.then(|| view.density(d) / e.area())
            }
            Region::Cap => self.cap.density(x, d),
        }
    }

    /// The region for a point.
    fn region(&self, view: &View) -> Option<Region> {
        let v = self.near / view.distance;
        if v > 1.0 {
            return Some(Region::Cap);
        }
        let at = self.slabs.partition_point(|slab| slab.v[1] < v);
        let (region, image) = self.slabs.get(at)?.region(view.t, v)?;
        // Light that lands far from the window.
        let lands = image.is_none_or(|image| {
            let middle = image.height * view.azimuth;
            self.window.distance2(middle) <= image.radius * image.radius
        });
        lands.then_some(region)
    }

    /// Rays of the camera show whether any is missed; if so, the region is made larger, until none or hardly any is.
    fn make_room(&mut self, seen: Seen<'_>) {
        /// Rays of a round, and rounds at most. Only lenses of odd pupils take more than two.
        const PROBES: usize = 8192;
        const ROUNDS: usize = 5;
        for round in 0..ROUNDS {
            let probes = round * PROBES..(round + 1) * PROBES;
            let missed = probes.filter(|i| self.probe(seen, *i)).count();
            if missed * 10_000 < PROBES {
                return;
            }
        }
    }

    /// Sends ray number `i` of a camera into the scene. Returns `true` if the region has been made larger for it.
    fn probe(&mut self, (lens, pupil): Seen<'_>, i: usize) -> bool {
        // Five coordinates of the R sequence (Roberts 2018).
        let r = |k: i32| (0.5 + (i + 1) as f64 / 1.134_724_138_401_519_5f64.powi(k)).fract();
        let FilmWindow { low, high } = self.window;
        let film = [0, 1].map(|k| low[k] + r(1 + k as i32) * (high[k] - low[k]));
        let sample = pupil.sample(film, Vec2::new(r(3) as f32, r(4) as f32));
        let ray = sample.and_then(|s| lens.trace_from_film(film, s.point).ok());
        // Inverse distances are more often small, as in scenes.
        ray.is_some_and(|ray| self.include(&ray, film, r(5).powi(2)))
    }

    /// Makes the region hold this ray from the film for the point on it at the inverse distance `v`. Returns `true` if it has become larger.
    fn include(&mut self, ray: &LensRay<f64>, film: [f64; 2], v: f64) -> bool {
        let (o, d) = (DVec3::from(ray.o), DVec3::from(ray.d));
        let center = DVec3::new(0.0, 0.0, self.center_z);
        // |o + s d − C| = near/v.
        let (to, reach) = (o - center, self.near / v);
        let along = to.dot(d);
        let root = (along * along - to.length_squared() + reach * reach).sqrt();
        // Not a number where the lens is larger than that.
        let x = o + (root - along) * d;
        let at = self.slabs.partition_point(|slab| slab.v[1] < v);
        let (Some(view), Some(slab)) = (View::new(x, self.center_z), self.slabs.get_mut(at)) else {
            return false;
        };
        let Some(p) = view.point(-d).filter(|_| root > along) else {
            return false;
        };
        // The film point along and across x's azimuth.
        let film = DVec2::from(film);
        let film = DVec2::new(view.azimuth.dot(film), view.azimuth.perp_dot(film));
        slab.include(view.t, v, p, film)
    }
}
