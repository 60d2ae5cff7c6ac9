//! What passes the lens from one point of the scene, found with real rays.

use crate::math::instruction_set::{Instructions, Kernel, vectorize};
use crate::optics::lanes::{Doubles, SceneTracer};
use crate::optics::pupil::outline::{LANES, excess, reaches, valley};
use crate::optics::real::{Index, Number, Plain};
use crate::optics::trace::LensRay;
use std::array::from_fn;

/// Directions in which the outline is sought over half a turn.
const DIRECTIONS: usize = 24;

/// The lens from the point at angle `t` and a distance, with azimuth 0.
#[derive(Clone, Copy)]
pub(super) struct Sight<'a> {
    tracer: &'a SceneTracer<f64>,
    /// One over the squared largest film radius that counts.
    per_film2: f64,
    /// z of C.
    center_z: f64,
    /// Of the first surface: radius and z of its rim.
    rim: [f64; 2],
    /// Sine and cosine of the angle to the axis.
    sin: f64,
    cos: f64,
    /// One over the distance, 1/mm.
    near: f64,
}

/// What passes: points just outside, half of it, the other being its mirror image; and where on the film their light lands.
#[derive(Clone, Debug, Default)]
pub(super) struct Outline {
    /// Along and across the meridional plane.
    pub points: Vec<[f64; 2]>,
    /// From the azimuth's direction and across it, mm.
    pub film: Vec<[f64; 2]>,
}

/// What [`Sight`]s of one lens have in common.
#[derive(Clone, Copy)]
pub(super) struct Scope<'a> {
    pub tracer: &'a SceneTracer<f64>,
    pub film_radius: f64,
    pub center_z: f64,
    /// Of the first surface: radius and z of its rim.
    pub rim: [f64; 2],
}

impl<'a> Scope<'a> {
    /// From half the angle's tangent and one over the distance.
    pub(super) fn sight(&self, t: f64, near: f64) -> Sight<'a> {
        Sight {
            tracer: self.tracer,
            per_film2: 1.0 / (self.film_radius * self.film_radius),
            center_z: self.center_z,
            rim: self.rim,
            sin: 2.0 * t / (1.0 + t * t),
            cos: (1.0 - t * t) / (1.0 + t * t),
            near,
        }
    }
}

impl Sight<'_> {
    /// The ray through the point (a, b) of the plane.
    #[inline(always)]
    fn ray<T: Number<Base = f64>>(&self, [a, b]: [T; 2]) -> LensRay<T> {
        let o = [a.times(self.cos), b, a.times(self.sin).plus(self.center_z)];
        let (a, b) = (a.times(self.near), b.times(self.near));
        let d = [
            a.times(self.cos).plus(-self.sin),
            b,
            a.times(self.sin).plus(self.cos),
        ];
        LensRay::new(o, d)
    }

    /// How far beyond the worst aperture, or the edge of the film, rays pass, squared and so on as
    /// [`crate::optics::lanes::FilmTracer`] has it.
    #[inline(always)]
    fn height2<T: Index<Base = f64>>(&self, p: [T; 2]) -> (T, T::Mask) {
        let (height2, [x, y], passes) = self.tracer.largest_relative_height2(&self.ray(p));
        let film2 = (x * x + y * y).times(self.per_film2);
        let larger = (film2 - height2).greater(f64::ZERO);
        (T::select(larger, film2, height2), passes)
    }

    fn excesses(&self, p: [Doubles<LANES>; 2]) -> [f64; LANES] {
        vectorize::<LANES, _>(Excess { sight: *self, p })
    }

    fn excess(&self, a: f64) -> f64 {
        let (height2, passes) = self.height2([a, 0.0]);
        excess(height2, passes)
    }

    /// Where the line to a point of the meridional plane's rim, at `height` of its radius, meets the plane.
    fn on_plane(&self, height: f64) -> f64 {
        let [radius, sag] = self.rim;
        // The cap is taken for a cone; only its rim and middle matter.
        let (x, z) = (height * radius, height.abs() * sag - self.center_z);
        let (along, ahead) = (x * self.cos + z * self.sin, z * self.cos - x * self.sin);
        along / (1.0 + self.near * ahead)
    }

    /// A ray in the meridional plane that passes, `hint` tried first.
    pub(super) fn inside(&self, hint: Option<f64>) -> Option<f64> {
        let passes = |a: &f64| self.excess(*a) <= 0.0;
        hint.filter(passes).or_else(|| self.search().filter(passes))
    }

    /// As [`crate::optics::pupil`] does from the film: the excess has one valley between the ends of the first surface.
    fn search(&self) -> Option<f64> {
        let scan = 4 * LANES;
        let at = |i: usize| self.on_plane(2.0 * i as f64 / scan as f64 - 1.0);
        let bundles = (0..scan).step_by(LANES).flat_map(|first| {
            let a = Doubles(from_fn(|i| at(first + i)));
            self.excesses([a, Doubles::splat(0.0)])
        });
        let (best, value) = bundles.enumerate().min_by(|a, b| a.1.total_cmp(&b.1))?;
        if !value.is_finite() || value <= 0.0 {
            return value.is_finite().then(|| at(best));
        }
        let bracket = [at(best.saturating_sub(1)), at(best), at(best + 1)];
        Some(valley(|a| self.excess(a), bracket))
    }

    /// All that passes; `None` where nothing in the meridional plane does.
    pub(super) fn outline(&self, hint: Option<f64>) -> Option<Outline> {
        let inside = self.inside(hint)?;
        let find = |p| self.excesses(p);
        let size = 1e-3 * self.rim[0];
        let [right, left] = reaches(find, inside, [[1.0, 0.0], [-1.0, 0.0]], size);
        let (center, along) = (inside + 0.5 * (right - left), 0.5 * (right + left));
        let [across] = reaches(find, center, [[0.0, 1.0]], along);
        let directions: [[f64; 2]; DIRECTIONS + 1] = from_fn(|i| {
            let (sin, cos) = (std::f64::consts::PI * i as f64 / DIRECTIONS as f64).sin_cos();
            [along * cos, across * sin.max(0.0)]
        });
        let reaches = reaches(find, center, directions, 1.0);
        let points: Vec<[f64; 2]> = (0..=DIRECTIONS)
            .map(|i| {
                [
                    center + reaches[i] * directions[i][0],
                    reaches[i] * directions[i][1],
                ]
            })
            .collect();
        let sound = along * across > 0.0 && points.iter().flatten().all(|x| x.is_finite());
        sound.then(|| Outline {
            film: self.landings(&points, center),
            points,
        })
    }

    /// Where light lands through these points and between them and the middle.
    fn landings(&self, points: &[[f64; 2]], center: f64) -> Vec<[f64; 2]> {
        let toward = |s: f64| move |p: &[f64; 2]| [center + s * (p[0] - center), s * p[1]];
        // Just inside the outline, half-way and in the middle.
        let all = points
            .iter()
            .map(toward(0.9999))
            .chain(points.iter().map(toward(0.5)));
        all.chain([[center, 0.0]])
            .filter_map(|p| {
                let landed = self.tracer.trace(&self.ray(p));
                landed.passed.then_some(landed.film)
            })
            .collect()
    }
}

/// A bundle of [`Sight::excess`].
struct Excess<'a> {
    sight: Sight<'a>,
    p: [Doubles<LANES>; 2],
}

impl Kernel for Excess<'_> {
    type Output = [f64; LANES];
    #[inline(always)]
    fn run(self, _: impl Instructions) -> [f64; LANES] {
        let (height2, passes) = self.sight.height2(self.p);
        from_fn(|i| excess(height2.0[i], passes.at(i)))
    }
}
