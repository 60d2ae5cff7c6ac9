//! Rays through the lens, from the film and from the scene.

use super::lane::Lanes;
use crate::optics::element::Toward;
use crate::optics::lens::Lens;
use crate::optics::real::{Index, Number, Plain};
use crate::optics::trace::{LensRay, LensTracer};

/// A lens to be traced from its film in precision `B`, a ray or a bundle of them at a time; all rays are aimed
/// at points of one plane (the pupil's). Lens coordinates, mm.
///
/// Error of f32 against f64: below 0.02 pixels of a 6000 × 4000 full-frame sensor for every lens in
/// `tests/golden` (`docs/generated/lens-precision.md`).
#[derive(Clone, Debug)]
pub struct FilmTracer<B = f32> {
    tracer: LensTracer<B>,
    /// From the last vertex to the film.
    film_distance: B,
    /// From the film to the plane aimed at, along z; rounded once, from double precision.
    to_plane: B,
}

/// Rays side by side in the scene, and which of them are any: what a lane without an answer
/// holds means nothing.
#[derive(Clone, Copy, Debug)]
pub struct Traced<T: Number> {
    /// Where the rays leave the first surface, and their unit directions.
    pub ray: LensRay<T>,
    /// Which rays passed the lens.
    pub passed: T::Mask,
}

impl<B: Plain> FilmTracer<B> {
    /// For rays from the film of `lens` through points of the plane at `plane_z`, which may lie on
    /// either side of the film but not in it.
    pub fn new(lens: &Lens, plane_z: f64) -> FilmTracer<B> {
        FilmTracer {
            tracer: lens.tracer_in(),
            film_distance: B::round_from(lens.film_distance()),
            to_plane: B::round_from(plane_z - lens.film_z()),
        }
    }

    /// The same for rays from the plane at `film_z`, which is not where the lens has its film.
    pub(in crate::optics) fn from_plane(lens: &Lens, film_z: f64, plane_z: f64) -> FilmTracer<B> {
        FilmTracer {
            tracer: lens.tracer_in(),
            film_distance: B::round_from(film_z - lens.length()),
            to_plane: B::round_from(plane_z - film_z),
        }
    }

    /// Traces the rays from the film points (x, y) mm along the lines through the points (x, y) mm of the plane. With the
    /// vector instructions of the function around it: in a `crate::math::instruction_set::Kernel` those of the processor.
    #[inline(always)]
    pub fn trace<T: Number<Base = B>>(&self, film: &[T; 2], pupil: &[T; 2]) -> Traced<T> {
        let (ray, passed) = self.tracer.to_scene_masked(&self.ray(film, pupil));
        Traced { ray, passed }
    }

    /// How far from the axis the rays meet the surfaces: the largest height relative to the clear radius, squared, at most 1 for
    /// a ray that passes; and which rays end at no other obstacle than a rim.
    #[inline(always)]
    pub(in crate::optics) fn largest_relative_height2<T: Index<Base = B>>(
        &self,
        film: &[T; 2],
        pupil: &[T; 2],
    ) -> (T, T::Mask) {
        let ray = self.ray(film, pupil);
        let (height2, _, passes) = self.tracer.largest_relative_height2(&ray, Toward::Scene);
        (height2, passes)
    }

    #[inline(always)]
    fn ray<T: Number<Base = B>>(&self, film: &[T; 2], pupil: &[T; 2]) -> LensRay<T> {
        // The line is the same whichever side of the film the plane lies.
        let toward = if self.to_plane > B::ZERO {
            -B::ONE
        } else {
            B::ONE
        };
        let d = [
            (pupil[0] - film[0]).times(toward),
            (pupil[1] - film[1]).times(toward),
            T::constant(self.to_plane * toward),
        ];
        LensRay::new([film[0], film[1], T::constant(self.film_distance)], d)
    }
}

/// The other way round: a lens to be traced from the scene, in precision `B`, to its film and to the plane that a [`FilmTracer`] aims at.
/// Lens coordinates, mm.
#[derive(Clone, Debug)]
pub struct SceneTracer<B = f32> {
    tracer: LensTracer<B>,
    /// From the last vertex to the film.
    film_distance: B,
    /// From the film to the plane, along z.
    to_plane: B,
    film_z: B,
}

/// Where rays from the scene end; what a lane without an answer holds means nothing.
#[derive(Clone, Copy, Debug)]
pub struct Landed<T: Number> {
    /// Where they meet the film, (x, y) mm.
    pub film: [T; 2],
    /// Where their lines behind the lens meet the plane, (x, y) mm.
    pub pupil: [T; 2],
    /// Which rays passed the lens.
    pub passed: T::Mask,
}

impl<B: Plain> SceneTracer<B> {
    /// For the film of `lens` and the plane at `plane_z`.
    pub fn new(lens: &Lens, plane_z: f64) -> SceneTracer<B> {
        SceneTracer {
            tracer: lens.tracer_in(),
            film_distance: B::round_from(lens.film_distance()),
            to_plane: B::round_from(plane_z - lens.film_z()),
            film_z: B::round_from(lens.film_z()),
        }
    }

    /// Traces one ray, which may also come from behind the front vertex; `None` where it ends in the lens.
    pub fn trace_alone(&self, ray: &LensRay<B>) -> Option<Landed<B>> {
        let ray = self.tracer.to_film(ray).ok()?;
        let landed = self.landed(&ray, self.film_z, true);
        landed.passed.then_some(landed)
    }

    /// Traces rays that run toward the film, in lens coordinates. With the vector instructions of the function around it, as
    /// [`FilmTracer::trace`].
    #[inline(always)]
    pub fn trace<T: Number<Base = B>>(&self, ray: &LensRay<T>) -> Landed<T> {
        let (ray, passed) = self.tracer.to_film_masked(ray);
        self.landed(&ray, self.film_distance, passed)
    }

    /// Where rays behind the lens go, of those that `passed`, for a film at this z.
    #[inline(always)]
    fn landed<T: Number<Base = B>>(
        &self,
        ray: &LensRay<T>,
        film_z: B,
        passed: T::Mask,
    ) -> Landed<T> {
        let film = film_point(ray, film_z);
        let pupil = [0, 1].map(|i| film[i] + (ray.d[i] / ray.d[2]).times(self.to_plane));
        Landed {
            film,
            pupil,
            passed: passed & pupil[0].finite() & pupil[1].finite(),
        }
    }

    /// How far from the axis the rays meet the surfaces: the largest height relative to the clear radius, squared, at most 1 for a ray
    /// that passes; where they meet the film, and which rays end at no other obstacle than a rim.
    #[inline(always)]
    pub(in crate::optics) fn largest_relative_height2<T: Index<Base = B>>(
        &self,
        ray: &LensRay<T>,
    ) -> (T, [T; 2], T::Mask) {
        let (height2, ray, passes) = self.tracer.largest_relative_height2(ray, Toward::Film);
        (height2, film_point(&ray, self.film_distance), passes)
    }
}

/// Where rays meet the film.
#[inline(always)]
fn film_point<T: Number>(ray: &LensRay<T>, film_z: T::Base) -> [T; 2] {
    let t = (-ray.o[2]).plus(film_z) / ray.d[2];
    [0, 1].map(|i| ray.o[i] + t * ray.d[i])
}

impl<const N: usize> Traced<Lanes<N>> {
    /// The ray in lane `i`; `None` where it did not pass.
    pub fn get(&self, i: usize) -> Option<LensRay<f32>> {
        self.passed.at(i).then(|| self.ray.map(|x| x.0[i]))
    }
}
