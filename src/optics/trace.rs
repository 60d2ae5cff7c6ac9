//! Exact sequential tracing through a lens, in both directions.
//!
//! Surface by surface: to the vertex tangent plane, to the surface, through its aperture, and on
//! by Snell's law. The intersection is relative to the vertex and divides by a sum of numbers of
//! one sign, so nothing cancels for radii from a fraction of a millimeter to 1e9 mm, and planes
//! need no case of their own (Spencer and Murty, "General Ray-Tracing Procedure", J. Opt. Soc. Am.
//! 52(6), 1962; the form of Welford, *Aberrations of Optical Systems*, 1986, §4.3).
//!
//! Lens coordinates: millimeters, origin at the vertex of the first (scene-side) surface, z toward
//! the film. Light runs toward +z; rays from the film run toward −z.

use super::element::{Crossing, Element, Split, Toward};
use super::real::{Dual, Index, Mask, Number, Plain, Real};
use super::stop_shape::StopPolygon;
use super::surface::Surface;
use std::fmt;
use std::ops::Range;

/// A ray in lens coordinates. Tracing wants a direction of unit length; [`LensRay::new`] and
/// [`LensRay::through`] see to it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LensRay<T> {
    /// A point of the ray, mm.
    pub o: [T; 3],
    /// Unit direction.
    pub d: [T; 3],
}

impl<T: Number> LensRay<T> {
    /// From a point in a direction of any length. A direction that has none gives a ray that
    /// tracing blocks.
    #[inline(always)]
    pub fn new(o: [T; 3], d: [T; 3]) -> LensRay<T> {
        LensRay { o, d }.normalized().0
    }

    /// From the point `from` through the point `to`.
    #[inline(always)]
    pub fn through(from: [T; 3], to: [T; 3]) -> LensRay<T> {
        LensRay::new(from, [to[0] - from[0], to[1] - from[1], to[2] - from[2]])
    }

    /// This ray with other numbers.
    #[inline(always)]
    pub fn map<U>(self, f: impl Fn(T) -> U) -> LensRay<U> {
        LensRay {
            o: self.o.map(&f),
            d: self.d.map(&f),
        }
    }

    /// This ray with its origin moved along z.
    fn shifted(self, by: T::Base) -> LensRay<T> {
        let [x, y, z] = self.o;
        LensRay {
            o: [x, y, z.plus(by)],
            ..self
        }
    }

    /// This ray with a direction of length 1, and whether there is such a ray: a direction whose
    /// squared length overflows, or that has none, and a point that is not finite, give none.
    #[inline(always)]
    fn normalized(&self) -> (LensRay<T>, T::Mask) {
        let d = self.d;
        let length = (d[0] * d[0] + d[1] * d[1] + d[2] * d[2]).sqrt();
        let ray = LensRay {
            o: self.o,
            d: [d[0] / length, d[1] / length, d[2] / length],
        };
        (ray, ray.finite() & length.finite())
    }

    /// Returns `true` if all its numbers are finite.
    #[inline(always)]
    pub(super) fn finite(&self) -> T::Mask {
        let ([x, y, z], [l, m, n]) = (self.o, self.d);
        let o = x.finite() & y.finite() & z.finite();
        o & l.finite() & m.finite() & n.finite()
    }
}

/// Why a ray ends in the lens.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Cause {
    /// It passes the sphere, meets it beyond its equator, runs the wrong way, or is not
    /// finite.
    Missed,
    /// It meets the surface outside the clear aperture.
    Vignetted,
    /// It is totally reflected.
    TotalReflection,
}

/// Where and why a ray ends in the lens.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Blocked {
    /// Index of the surface, from 0 at the scene.
    pub surface: usize,
    /// What happened there.
    pub cause: Cause,
}

impl fmt::Display for Blocked {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let what = match self.cause {
            Cause::Missed => "misses",
            Cause::Vignetted => "is blocked by the aperture of",
            Cause::TotalReflection => "is totally reflected at",
        };
        write!(f, "the ray {what} surface {}", self.surface + 1)
    }
}

/// A lens ready to be traced in precision `B` (f64 is the truth, f32 the fast path).
#[derive(Clone, Debug)]
pub struct LensTracer<B> {
    elements: Vec<Element<B>>,
    /// z of the last vertex.
    length: B,
}

impl<B: Plain> LensTracer<B> {
    /// Prepares `surfaces` (scene to film; air in front of the first).
    pub fn new(surfaces: &[Surface]) -> LensTracer<B> {
        let mut before = 1.0;
        let element = |s: &Surface| Element::new(s, std::mem::replace(&mut before, s.index));
        let inner = &surfaces[..surfaces.len().saturating_sub(1)];
        LensTracer {
            elements: surfaces.iter().map(element).collect(),
            length: B::round_from(inner.iter().map(|s| s.thickness).sum()),
        }
    }

    /// Makes the stops among `surfaces`, of which this tracer was made, polygons.
    pub fn with_blades(mut self, surfaces: &[Surface], polygon: &StopPolygon) -> LensTracer<B> {
        for (element, s) in self.elements.iter_mut().zip(surfaces) {
            if s.is_stop {
                element.set_blades(polygon, 0.5 * s.aperture);
            }
        }
        self
    }

    /// Takes `ray` across these surfaces, one after the other; z is relative to the vertex at hand, to begin with to that
    /// beside the first surface that is met. `continues` sees each crossing; with `false` the ray ends in front of it.
    #[inline(always)]
    fn walk<T: Number<Base = B>>(
        &self,
        surfaces: Range<usize>,
        toward: Toward,
        clip: bool,
        mut ray: LensRay<T>,
        mut continues: impl FnMut(usize, &Crossing<T>) -> bool,
    ) -> LensRay<T> {
        let ends = surfaces.start + surfaces.end;
        for k in surfaces {
            let i = match toward {
                Toward::Film => k,
                Toward::Scene => ends - 1 - k,
            };
            self.approach(i, toward, &mut ray);
            let crossing = self.elements[i].cross(&ray, toward, clip);
            if !continues(i, &crossing) {
                break;
            }
            ray = crossing.ray;
        }
        ray
    }

    /// The same for one ray, which ends where it is blocked.
    #[inline(always)]
    fn walk_alone<T: Real<Base = B>>(
        &self,
        surfaces: Range<usize>,
        toward: Toward,
        clip: bool,
        ray: LensRay<T>,
    ) -> Result<LensRay<T>, Blocked> {
        let mut blocked = None;
        let ray = self.walk(surfaces, toward, clip, ray, |i, crossing| {
            blocked = crossing.blocked(i);
            blocked.is_none()
        });
        blocked.map_or(Ok(ray), Err)
    }

    /// Makes z relative to the vertex of surface `i`, of a ray on its way there whose z is relative to the vertex before it; where there is
    /// none before it, to that of the surface itself.
    #[inline(always)]
    fn approach<T: Number<Base = B>>(&self, i: usize, toward: Toward, ray: &mut LensRay<T>) {
        let last = self.elements.len().saturating_sub(1);
        // The surface whose thickness is the way.
        let gap = match toward {
            Toward::Film => i.checked_sub(1),
            Toward::Scene => Some(i).filter(|i| *i < last),
        };
        if let Some(gap) = gap {
            let thickness = self.elements[gap].thickness;
            ray.o[2] = ray.o[2].plus(-thickness * toward.sign());
        }
    }

    /// Both ways on from surface `i` of a ray on its way there, z relative to the vertex before it and then to that of the surface; `None`
    /// where the ray ends in front of it. One that `enters` comes from the scene, z relative to the first vertex, and may come from behind that.
    pub(super) fn split<T: Real<Base = B>>(
        &self,
        i: usize,
        toward: Toward,
        enters: bool,
        mut ray: LensRay<T>,
    ) -> Option<Split<T>> {
        let element = self.elements.get(i)?;
        if enters && ray.d[2].at_most(B::ZERO) {
            return element.split(&element.enter_from_behind(&ray), ray.d, toward);
        }
        self.approach(i, toward, &mut ray);
        element.split(&element.cross(&ray, toward, true), ray.d, toward)
    }

    /// Unit normal of the first surface at its point `p`, leaning toward the film.
    pub(super) fn front_normal(&self, p: [B; 3]) -> Option<[B; 3]> {
        Some(self.elements.first()?.normal(p))
    }

    /// Where a ray from the film meets surface `target`, (x, y) mm; `None` where it ends before or there, by apertures too if `clip`.
    pub fn point_from_film(&self, ray: &LensRay<B>, target: usize, clip: bool) -> Option<[B; 2]> {
        let surfaces = target..self.elements.len();
        let ray = ray.shifted(-self.length);
        let ray = self.walk_alone(surfaces, Toward::Scene, clip, ray).ok()?;
        Some([ray.o[0], ray.o[1]])
    }

    /// How far from the axis along y a ray meets each of `surfaces`, in the order that it meets them, as far as it gets, apertures not
    /// blocking; and the ray behind them where it gets through, z relative to the last vertex met. At first z is relative to the vertex
    /// that the ray passed before, or to the first surface's where there is none.
    pub(super) fn heights(
        &self,
        surfaces: Range<usize>,
        toward: Toward,
        ray: LensRay<B>,
    ) -> (Vec<B>, Option<LensRay<B>>) {
        let mut heights = Vec::with_capacity(surfaces.len());
        let count = surfaces.len();
        let ray = self.walk(surfaces, toward, false, ray, |i, crossing| {
            let continues = crossing.blocked(i).is_none() && crossing.ray.finite();
            if continues {
                heights.push(crossing.ray.o[1]);
            }
            continues
        });
        let passes = heights.len() == count;
        (heights, Some(ray).filter(|_| passes))
    }

    /// Traces a ray from the film through the lens: where it leaves the first surface, and where
    /// it goes. The direction's z must be negative.
    pub fn to_scene<T: Real<Base = B>>(&self, ray: &LensRay<T>) -> Result<LensRay<T>, Blocked> {
        let ray = ray.shifted(-self.length);
        finished(self.walk_alone(self.all(), Toward::Scene, true, ray)?, 0)
    }

    /// As [`LensTracer::to_scene`], but apertures do not block.
    pub fn to_scene_unclipped<T: Real<Base = B>>(
        &self,
        ray: &LensRay<T>,
    ) -> Result<LensRay<T>, Blocked> {
        let ray = ray.shifted(-self.length);
        finished(self.walk_alone(self.all(), Toward::Scene, false, ray)?, 0)
    }

    /// Traces a ray from the scene through the lens: where it leaves the last surface, and where
    /// it goes. A direction whose z is not positive comes from behind the front vertex, as a fisheye's may.
    pub fn to_film<T: Real<Base = B>>(&self, ray: &LensRay<T>) -> Result<LensRay<T>, Blocked> {
        self.forward(ray, true, |_, _| ())
    }

    /// As [`LensTracer::to_film`], but apertures do not block.
    pub fn to_film_unclipped<T: Real<Base = B>>(
        &self,
        ray: &LensRay<T>,
    ) -> Result<LensRay<T>, Blocked> {
        self.forward(ray, false, |_, _| ())
    }

    /// As [`LensTracer::to_film`]; `visit` sees each surface's number and where it is met, in lens coordinates.
    pub(super) fn visit_to_film<T: Real<Base = B>>(
        &self,
        ray: &LensRay<T>,
        mut visit: impl FnMut(usize, [T; 3]),
    ) -> Result<LensRay<T>, Blocked> {
        let mut z = B::ZERO;
        let mut next = 0;
        self.forward(ray, true, |i, [x, y, dz]| {
            while next < i {
                z = z + self.elements[next].thickness;
                next += 1;
            }
            visit(i, [x, y, dz.plus(z)]);
        })
    }

    /// Toward the film; `visit` sees where surfaces are met, relative to their vertices.
    #[inline(always)]
    fn forward<T: Real<Base = B>>(
        &self,
        ray: &LensRay<T>,
        clip: bool,
        mut visit: impl FnMut(usize, [T; 3]),
    ) -> Result<LensRay<T>, Blocked> {
        let (mut ray, mut surfaces) = (*ray, self.all());
        if let (Some(front), true) = (self.elements.first(), ray.d[2].at_most(B::ZERO)) {
            let crossing = front.enter_from_behind(&ray);
            crossing.blocked(0).map_or(Ok(()), Err)?;
            visit(0, crossing.ray.o);
            (ray, surfaces.start) = (crossing.ray, 1);
        }
        let mut blocked = None;
        let ray = self.walk(surfaces, Toward::Film, clip, ray, |i, crossing| {
            blocked = crossing.blocked(i);
            if blocked.is_none() {
                visit(i, crossing.ray.o);
            }
            blocked.is_none()
        });
        blocked.map_or(Ok(()), Err)?;
        let last = self.elements.len().saturating_sub(1);
        finished(ray.shifted(self.length), last)
    }

    /// The farthest from the axis that rays meet any surface, relative to its clear radius, squared: at most 1 for a ray that
    /// passes; the rays behind the lens, and which end nowhere else than at an aperture, which does not block here. z is relative to
    /// the vertex on the side that the rays come from, and then to that on the other.
    #[inline(always)]
    pub(super) fn largest_relative_height2<T: Index<Base = B>>(
        &self,
        ray: &LensRay<T>,
        toward: Toward,
    ) -> (T, LensRay<T>, T::Mask) {
        let mut largest = T::constant(B::ZERO);
        let mut passes = T::Mask::YES;
        let ray = self.walk(self.all(), toward, false, *ray, |i, crossing| {
            passes = passes & crossing.passes();
            let [x, y, _] = crossing.ray.o;
            let height2 = (x * x + y * y) / T::constant(self.elements[i].radius2);
            largest = T::select((height2 - largest).greater(B::ZERO), height2, largest);
            passes.any()
        });
        (largest, ray, passes)
    }

    /// Traces rays from behind the last surface to the scene, apertures blocking: where they
    /// leave the first surface, and which of them do. z is relative to the *last* vertex on the way in and
    /// to the first on the way out. A ray alone or a bundle of them, side by side and without a branch
    /// between them; the arithmetic is that of [`LensTracer::to_scene`], in the same order.
    #[inline(always)]
    pub fn to_scene_masked<T: Number<Base = B>>(&self, ray: &LensRay<T>) -> (LensRay<T>, T::Mask) {
        self.masked(ray, Toward::Scene)
    }

    /// The same for rays from the scene that run toward the film, z relative to the *first* vertex on the way in and to the last on
    /// the way out; the arithmetic is that of [`LensTracer::to_film`].
    #[inline(always)]
    pub fn to_film_masked<T: Number<Base = B>>(&self, ray: &LensRay<T>) -> (LensRay<T>, T::Mask) {
        self.masked(ray, Toward::Film)
    }

    #[inline(always)]
    fn masked<T: Number<Base = B>>(
        &self,
        ray: &LensRay<T>,
        toward: Toward,
    ) -> (LensRay<T>, T::Mask) {
        let mut passes = T::Mask::YES;
        let ray = self.walk(self.all(), toward, true, *ray, |_, crossing| {
            passes = passes & crossing.passes();
            passes.any()
        });
        let (ray, finite) = ray.normalized();
        (ray, passes & finite)
    }

    /// Where a ray from the scene meets the first surface within its aperture, and the surface's unit normal there, which leans toward the
    /// film; `None` where it does not.
    pub fn front<T: Real<Base = B>>(&self, ray: &LensRay<T>) -> Option<[[T; 3]; 2]> {
        let front = self.elements.first()?;
        let crossing = if ray.d[2].greater(B::ZERO) {
            front.cross(ray, Toward::Film, true)
        } else {
            front.enter_from_behind(ray)
        };
        let p = crossing.ray.o;
        crossing.blocked(0).is_none().then(|| [p, front.normal(p)])
    }

    fn all(&self) -> Range<usize> {
        0..self.elements.len()
    }
}

impl LensTracer<f64> {
    /// Traces the ray from the film point `film` through the point `pupil`, with the derivatives
    /// of where it leaves and where it goes by the film point's x and y, `pupil` held fixed.
    /// Exact derivatives of this very ray: no neighboring ray is traced, so none can be blocked.
    pub fn to_scene_with_derivatives(
        &self,
        film: [f64; 3],
        pupil: [f64; 3],
    ) -> Result<LensRay<Dual>, Blocked> {
        let from = [
            Dual::parameter(film[0], 0),
            Dual::parameter(film[1], 1),
            Dual::fixed(film[2]),
        ];
        let mut ray = LensRay::through(from, pupil.map(Dual::fixed));
        // The line is the same whichever side of the film the pupil lies.
        if ray.d[2].value > 0.0 {
            ray.d = ray.d.map(|x| -x);
        }
        self.to_scene(&ray)
    }
}

/// Makes the direction's length 1 again, and makes sure that what is handed out is finite.
fn finished<T: Real>(ray: LensRay<T>, surface: usize) -> Result<LensRay<T>, Blocked> {
    let (ray, finite) = ray.normalized();
    if finite {
        Ok(ray)
    } else {
        Err(Blocked {
            surface,
            cause: Cause::Missed,
        })
    }
}
