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

use super::asphere::AsphericSurface;
use super::real::{Dual, Index, Mask, Number, Plain, Real};
use super::stop_shape::{StopEdges, StopPolygon};
use super::surface::Surface;
use std::fmt;

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
        let o = ray.o[0].finite().and(ray.o[1].finite());
        let d = ray.d[0].finite().and(ray.d[1].finite());
        let z = ray.o[2].finite().and(ray.d[2].finite());
        (ray, o.and(d).and(z).and(length.finite()))
    }
}

/// Why a ray ends in the lens.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Cause {
    /// It passes the sphere, meets it beyond its equator, runs the wrong way, or is no ray at all
    /// (not a number).
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

/// One surface, with everything that can be computed beforehand.
#[derive(Clone, Debug)]
struct Element<B> {
    curvature: B,
    /// Square of the clear radius.
    radius2: B,
    /// To the next vertex, film side.
    thickness: B,
    /// For rays from the scene.
    to_film: Refraction<B>,
    /// For rays from the film.
    to_scene: Refraction<B>,
    /// For an aspheric surface; `curvature` is not used then.
    asphere: Option<AsphericSurface<B>>,
    /// For a stop of straight blades; its corners lie in the clear aperture.
    edges: Option<StopEdges<B>>,
}

/// What Snell's law needs of two media.
#[derive(Clone, Copy, Debug)]
struct Refraction<B> {
    /// n/n', the index a ray comes from over the one it goes into.
    ratio: B,
    /// Its square.
    square: B,
    /// 1 less its square: rounded once, so that rays that graze the boundary of nearly equal media keep their digits.
    rest: B,
}

impl<B: Plain> Refraction<B> {
    fn new(from: f64, into: f64) -> Refraction<B> {
        let ratio = from / into;
        Refraction {
            ratio: B::round_from(ratio),
            square: B::round_from(ratio * ratio),
            rest: B::round_from((into - from) * (into + from) / (into * into)),
        }
    }

    /// The squared cosine of refraction, for that of incidence; negative where light is totally reflected.
    #[inline(always)]
    fn cosine2<T: Number<Base = B>>(&self, incidence2: T) -> T {
        incidence2.times(self.square).plus(self.rest)
    }
}

/// A lens ready to be traced in precision `B` (f64 is the truth, f32 the fast path).
#[derive(Clone, Debug)]
pub struct LensTracer<B> {
    elements: Vec<Element<B>>,
    /// z of the last vertex.
    length: B,
}

/// Everything that tells one direction of tracing from the other.
struct Pass<B> {
    /// Sign of the direction's z.
    sign: B,
    to_film: bool,
    /// Do apertures block?
    clip: bool,
}

impl<B: Plain> LensTracer<B> {
    /// Prepares `surfaces` (scene to film; air in front of the first).
    pub fn new(surfaces: &[Surface]) -> LensTracer<B> {
        let mut before = 1.0;
        let elements = surfaces
            .iter()
            .map(|s| {
                let in_front = std::mem::replace(&mut before, s.index);
                let radius = 0.5 * s.aperture;
                Element {
                    curvature: B::round_from(s.curvature()),
                    radius2: B::round_from(radius * radius),
                    thickness: B::round_from(s.thickness),
                    to_film: Refraction::new(in_front, s.index),
                    to_scene: Refraction::new(s.index, in_front),
                    asphere: s
                        .asphere
                        .map(|a| AsphericSurface::new(s.radius, &a, s.clear_radius())),
                    edges: None,
                }
            })
            .collect();
        let inner = &surfaces[..surfaces.len().saturating_sub(1)];
        LensTracer {
            elements,
            length: B::round_from(inner.iter().map(|s| s.thickness).sum()),
        }
    }

    /// Makes the stops among `surfaces`, of which this tracer was made, polygons.
    pub fn with_blades(mut self, surfaces: &[Surface], polygon: &StopPolygon) -> LensTracer<B> {
        for (element, s) in self.elements.iter_mut().zip(surfaces) {
            if s.is_stop {
                element.edges = Some(polygon.edges(0.5 * s.aperture));
            }
        }
        self
    }

    /// Where a ray from the film meets surface `target`, (x, y) mm; `None` where it ends before or there. Do apertures block it?
    pub fn point_from_film(&self, ray: &LensRay<B>, target: usize, clip: bool) -> Option<[B; 2]> {
        let pass = Pass {
            sign: -B::ONE,
            to_film: false,
            clip,
        };
        let mut r = *ray;
        r.o[2] = r.o[2].plus(-self.length);
        for i in (target..self.elements.len()).rev() {
            if i + 1 < self.elements.len() {
                r.o[2] = r.o[2].plus(self.elements[i].thickness);
            }
            self.cross(i, &mut r, &pass).ok()?;
        }
        Some([r.o[0], r.o[1]])
    }

    /// Traces a ray from the film through the lens: where it leaves the first surface, and where
    /// it goes. The direction's z must be negative.
    pub fn to_scene<T: Real<Base = B>>(&self, ray: &LensRay<T>) -> Result<LensRay<T>, Blocked> {
        self.trace_to_scene(ray, true)
    }

    /// As [`LensTracer::to_scene`], but apertures do not block.
    pub fn to_scene_unclipped<T: Real<Base = B>>(
        &self,
        ray: &LensRay<T>,
    ) -> Result<LensRay<T>, Blocked> {
        self.trace_to_scene(ray, false)
    }

    fn trace_to_scene<T: Real<Base = B>>(
        &self,
        ray: &LensRay<T>,
        clip: bool,
    ) -> Result<LensRay<T>, Blocked> {
        let pass = Pass {
            sign: -B::ONE,
            to_film: false,
            clip,
        };
        let mut r = *ray;
        // z is kept relative to the vertex of the current surface.
        r.o[2] = r.o[2].plus(-self.length);
        for i in (0..self.elements.len()).rev() {
            if i + 1 < self.elements.len() {
                r.o[2] = r.o[2].plus(self.elements[i].thickness);
            }
            self.cross(i, &mut r, &pass)?;
        }
        finished(r, 0)
    }

    /// Traces a ray from the scene through the lens: where it leaves the last surface, and where
    /// it goes. A direction whose z is not positive comes from behind the front vertex, as a fisheye's may.
    pub fn to_film<T: Real<Base = B>>(&self, ray: &LensRay<T>) -> Result<LensRay<T>, Blocked> {
        let pass = Pass {
            sign: B::ONE,
            to_film: true,
            clip: true,
        };
        let mut r = *ray;
        let last = self.elements.len().saturating_sub(1);
        for (i, element) in self.elements.iter().enumerate() {
            if i == 0 && r.d[2].value() <= B::ZERO {
                r = element.enter_from_behind(&r)?;
            } else {
                self.cross(i, &mut r, &pass)?;
            }
            if i < last {
                r.o[2] = r.o[2].plus(-self.elements[i].thickness);
            }
        }
        r.o[2] = r.o[2].plus(self.length);
        finished(r, last)
    }

    /// The farthest from the axis that rays from the film meet any surface, relative to its clear radius,
    /// squared: at most 1 for a ray that passes. Apertures do not block; which rays end nowhere else. z is relative
    /// to the last vertex.
    #[inline(always)]
    pub(super) fn largest_relative_height2<T: Index<Base = B>>(
        &self,
        ray: &LensRay<T>,
    ) -> (T, T::Mask) {
        let pass = Pass {
            sign: -B::ONE,
            to_film: false,
            clip: false,
        };
        let mut r = *ray;
        let mut largest = T::constant(B::ZERO);
        let mut passes = T::Mask::YES;
        for i in (0..self.elements.len()).rev() {
            if i + 1 < self.elements.len() {
                r.o[2] = r.o[2].plus(self.elements[i].thickness);
            }
            let crossing = self.elements[i].cross(&r, &pass);
            passes = passes.and(crossing.all());
            if !passes.any() {
                break;
            }
            r = crossing.ray;
            let height2 = r.o[0] * r.o[0] + r.o[1] * r.o[1];
            let height2 = height2 / T::constant(self.elements[i].radius2);
            largest = T::select((height2 - largest).greater(B::ZERO), height2, largest);
        }
        (largest, passes)
    }

    /// Traces rays from behind the last surface to the scene, apertures blocking: where they
    /// leave the first surface, and which of them do. z is relative to the *last* vertex on the way in and
    /// to the first on the way out. A ray alone or a bundle of them, side by side and without a branch
    /// between them; the arithmetic is that of [`LensTracer::to_scene`], in the same order.
    #[inline(always)]
    pub fn to_scene_masked<T: Number<Base = B>>(&self, ray: &LensRay<T>) -> (LensRay<T>, T::Mask) {
        let pass = Pass {
            sign: -B::ONE,
            to_film: false,
            clip: true,
        };
        let mut r = *ray;
        let mut passes = T::Mask::YES;
        for i in (0..self.elements.len()).rev() {
            if i + 1 < self.elements.len() {
                r.o[2] = r.o[2].plus(self.elements[i].thickness);
            }
            let crossing = self.elements[i].cross(&r, &pass);
            passes = passes.and(crossing.all());
            if !passes.any() {
                break;
            }
            r = crossing.ray;
        }
        let (r, finite) = r.normalized();
        (r, passes.and(finite))
    }

    /// Takes the ray across surface `i`, with z relative to its vertex.
    #[inline(always)]
    fn cross<T: Real<Base = B>>(
        &self,
        i: usize,
        ray: &mut LensRay<T>,
        pass: &Pass<B>,
    ) -> Result<(), Blocked> {
        let crossing = self.elements[i].cross(ray, pass);
        let cause = if !crossing.met {
            Cause::Missed
        } else if !crossing.inside {
            Cause::Vignetted
        } else if !crossing.refracted {
            Cause::TotalReflection
        } else {
            *ray = crossing.ray;
            return Ok(());
        };
        Err(Blocked { surface: i, cause })
    }
}

/// Behind one surface; the ray means something where all conditions hold.
struct Crossing<T: Number> {
    ray: LensRay<T>,
    /// It runs toward the surface and meets its near half.
    met: T::Mask,
    /// Inside the clear aperture.
    inside: T::Mask,
    /// And is not totally reflected.
    refracted: T::Mask,
}

impl<T: Number> Crossing<T> {
    #[inline(always)]
    fn all(&self) -> T::Mask {
        self.met.and(self.inside).and(self.refracted)
    }
}

impl<B: Plain> Element<B> {
    /// Takes a ray across the surface, with z relative to its vertex. Nothing branches on the ray, so
    /// that rays can go side by side; every comparison is written so that a NaN blocks.
    #[inline(always)]
    fn cross<T: Number<Base = B>>(&self, ray: &LensRay<T>, pass: &Pass<B>) -> Crossing<T> {
        let [x, y, z] = ray.o;
        let [l, m, n] = ray.d;
        let (s, c) = (pass.sign, self.curvature);
        // A ray that runs parallel to the vertex plane, or away from the next surface, has missed it.
        let ahead = n.times(s).greater(B::ZERO);
        if let Some(asphere) = &self.asphere {
            return self.cross_asphere(asphere, ray, pass, ahead);
        }
        // To the vertex tangent plane: keeps the digits of all that follows.
        let t = -z / n;
        let (x, y) = (x + t * l, y + t * m);
        // To the sphere.
        let f = (x * x + y * y).times(c);
        let along = (x * l + y * m).times(c);
        let g = n - along;
        // g² − cf; the squares of the way to a plane that the ray meets far away are left out of both.
        let across = (x * m - y * l).times(c);
        let discriminant = n * (g - along - n * f.times(c)) - across * across;
        let reached = discriminant.at_least(B::ZERO);
        // The cosine of incidence, signed as the direction.
        let q = discriminant.sqrt().times(s);
        let t = f / (g + q);
        let (x, y, z) = (x + t * l, y + t * m, t * n);
        let axial = -z.times(c);
        // On the near half of the sphere, the normal (−cx, −cy, 1 − cz) leans along the axis.
        let near = axial.greater(-B::ONE);
        let mut crossing = Crossing {
            ray: LensRay {
                o: [x, y, z],
                d: ray.d,
            },
            met: ahead.and(reached).and(near),
            inside: T::Mask::YES,
            refracted: T::Mask::YES,
        };
        if pass.clip {
            crossing.inside = (x * x + y * y).at_most(self.radius2);
            if let Some(edges) = &self.edges {
                crossing.inside = crossing.inside.and(edges.hold(x, y));
            }
        }
        let refraction = self.refraction(pass);
        let mu = refraction.ratio;
        if mu == B::ONE {
            return crossing;
        }
        let k = refraction.cosine2(discriminant);
        crossing.refracted = k.at_least(B::ZERO);
        let g = k.sqrt().times(s) - q.times(mu);
        let gc = g.times(c);
        crossing.ray.d = [
            l.times(mu) - gc * x,
            m.times(mu) - gc * y,
            n.times(mu) + g + g * axial,
        ];
        crossing
    }

    /// Takes a ray into the front surface that runs away from the film, as light from behind a fisheye does: its first
    /// meeting with the sphere, on the half in front of the center. Concave, plane and aspheric fronts are missed.
    #[expect(clippy::neg_cmp_op_on_partial_ord, reason = "NaN is blocked")]
    fn enter_from_behind<T: Real<Base = B>>(
        &self,
        ray: &LensRay<T>,
    ) -> Result<LensRay<T>, Blocked> {
        let blocked = |cause| Blocked { surface: 0, cause };
        let (c, [x, y, z], d) = (self.curvature, ray.o, ray.d);
        if c <= B::ZERO || self.asphere.is_some() {
            return Err(blocked(Cause::Missed));
        }
        // Lengths in radii: (o − center)/R, whose product with the direction and square make the quadratic equation.
        let to = [x.times(c), y.times(c), z.times(c).plus(-B::ONE)];
        let along = to[0] * d[0] + to[1] * d[1] + to[2] * d[2];
        let outside = to[0] * to[0] + to[1] * to[1] + to[2] * to[2];
        let discriminant = along * along - outside.plus(-B::ONE);
        // The first meeting: the cosine of incidence is the root itself.
        let q = discriminant.sqrt();
        let p: [T; 3] = std::array::from_fn(|i| to[i] - (along + q) * d[i]);
        if !(discriminant.value() >= B::ZERO && p[2].value() < B::ZERO) {
            return Err(blocked(Cause::Missed));
        }
        let o = [
            p[0] / T::constant(c),
            p[1] / T::constant(c),
            p[2].plus(B::ONE) / T::constant(c),
        ];
        if !((o[0] * o[0] + o[1] * o[1]).value() <= self.radius2) {
            return Err(blocked(Cause::Vignetted));
        }
        let k = self.to_film.cosine2(discriminant);
        if !(k.value() >= B::ZERO) {
            return Err(blocked(Cause::TotalReflection));
        }
        let g = k.sqrt() - q.times(self.to_film.ratio);
        // The normal points to the center.
        let d = std::array::from_fn(|i| d[i].times(self.to_film.ratio) - g * p[i]);
        Ok(LensRay { o, d })
    }

    #[inline(always)]
    fn refraction(&self, pass: &Pass<B>) -> &Refraction<B> {
        if pass.to_film {
            &self.to_film
        } else {
            &self.to_scene
        }
    }

    /// As [`Element::cross`], for an aspheric surface and rays of which those run `ahead`.
    #[inline(always)]
    fn cross_asphere<T: Number<Base = B>>(
        &self,
        asphere: &AsphericSurface<B>,
        ray: &LensRay<T>,
        pass: &Pass<B>,
        ahead: T::Mask,
    ) -> Crossing<T> {
        let meeting = asphere.meet(ray.o, ray.d, pass.sign);
        let ([x, y, _], d, normal) = (meeting.point, ray.d, meeting.normal);
        let q = d[0] * normal[0] + d[1] * normal[1] + d[2] * normal[2];
        let tolerance = asphere.tolerance();
        let on = (meeting.residual * meeting.residual).at_most(tolerance * tolerance);
        let forward = q.times(pass.sign).greater(B::ZERO);
        let mut crossing = Crossing {
            ray: LensRay {
                o: meeting.point,
                d,
            },
            met: ahead
                .and(on)
                .and(meeting.inside.greater(B::ZERO))
                .and(forward),
            inside: T::Mask::YES,
            refracted: T::Mask::YES,
        };
        if pass.clip {
            crossing.inside = (x * x + y * y).at_most(self.radius2);
        }
        let refraction = self.refraction(pass);
        let mu = refraction.ratio;
        let k = refraction.cosine2(q * q);
        crossing.refracted = k.at_least(B::ZERO);
        let g = k.sqrt().times(pass.sign) - q.times(mu);
        crossing.ray.d = [0, 1, 2].map(|axis| d[axis].times(mu) + g * normal[axis]);
        crossing
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
