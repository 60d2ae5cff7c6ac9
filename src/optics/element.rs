//! One surface of a lens, ready to be traced: where a ray meets it, whether its rim lets the ray pass, and where it goes.

use super::asphere::AsphericSurface;
use super::real::{Mask, Number, Plain, Real};
use super::stop_shape::{StopEdges, StopPolygon};
use super::surface::Surface;
use super::trace::{Blocked, Cause, LensRay};

/// A surface, with everything that can be computed beforehand.
#[derive(Clone, Debug)]
pub(super) struct Element<B> {
    curvature: B,
    /// Square of the clear radius.
    pub radius2: B,
    /// To the next vertex, film side.
    pub thickness: B,
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

/// Which way rays go through a lens.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Toward {
    Film,
    Scene,
}

impl Toward {
    /// Of the direction's z.
    #[inline(always)]
    pub(super) fn sign<B: Plain>(self) -> B {
        match self {
            Toward::Film => B::ONE,
            Toward::Scene => -B::ONE,
        }
    }
}

/// Behind one surface; the ray means something where all conditions hold.
pub(super) struct Crossing<T: Number> {
    pub ray: LensRay<T>,
    /// It runs toward the surface and meets its near half.
    met: T::Mask,
    /// Inside the clear aperture.
    inside: T::Mask,
    /// And is not totally reflected.
    refracted: T::Mask,
}

impl<T: Number> Crossing<T> {
    /// Which rays continue.
    #[inline(always)]
    pub(super) fn passes(&self) -> T::Mask {
        self.met & self.inside & self.refracted
    }
}

impl<T: Real> Crossing<T> {
    /// Why the ray ends at this surface, number `surface`, if it does.
    #[inline(always)]
    pub(super) fn blocked(&self, surface: usize) -> Option<Blocked> {
        let cause = if !self.met {
            Cause::Missed
        } else if !self.inside {
            Cause::Vignetted
        } else if !self.refracted {
            Cause::TotalReflection
        } else {
            return None;
        };
        Some(Blocked { surface, cause })
    }
}

/// Where light goes at a surface.
pub(super) struct Split<T> {
    /// Cosine of the angle of incidence.
    pub cosine: T,
    /// Back.
    pub reflected: LensRay<T>,
    /// On; `None` where everything is reflected.
    pub refracted: Option<LensRay<T>>,
}

impl<B: Plain> Element<B> {
    /// `s`, with a medium of index `in_front` on its scene side.
    pub(super) fn new(s: &Surface, in_front: f64) -> Element<B> {
        let radius = 0.5 * s.aperture;
        let asphere = s.asphere.as_ref();
        Element {
            curvature: B::round_from(s.curvature()),
            radius2: B::round_from(radius * radius),
            thickness: B::round_from(s.thickness),
            to_film: Refraction::new(in_front, s.index),
            to_scene: Refraction::new(s.index, in_front),
            asphere: asphere.map(|a| AsphericSurface::new(s.radius, a, s.clear_radius())),
            edges: None,
        }
    }

    /// Makes the stop that this is a polygon, which lies in its circle of `radius` mm.
    pub(super) fn set_blades(&mut self, polygon: &StopPolygon, radius: f64) {
        self.edges = Some(polygon.edges(radius));
    }

    /// Takes a ray across the surface, with z relative to its vertex; with `clip`, its aperture blocks.
    /// Nothing branches on the ray, so that rays can go side by side; every comparison is written so that a NaN blocks.
    #[inline(always)]
    pub(super) fn cross<T: Number<Base = B>>(
        &self,
        ray: &LensRay<T>,
        toward: Toward,
        clip: bool,
    ) -> Crossing<T> {
        let [x, y, z] = ray.o;
        let [l, m, n] = ray.d;
        let (s, c) = (toward.sign(), self.curvature);
        // A ray that runs parallel to the vertex plane, or away from the next surface, has missed it.
        let ahead = n.times(s).greater(B::ZERO);
        if let Some(asphere) = &self.asphere {
            return self.cross_asphere(asphere, ray, toward, clip, ahead);
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
            met: ahead & reached & near,
            inside: self.within(x, y, clip),
            refracted: T::Mask::YES,
        };
        let refraction = self.refraction(toward);
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
    pub(super) fn enter_from_behind<T: Real<Base = B>>(&self, ray: &LensRay<T>) -> Crossing<T> {
        let (c, [x, y, z], d) = (self.curvature, ray.o, ray.d);
        // Lengths in radii: (o − center)/R, whose product with the direction and square make the quadratic equation.
        let to = [x.times(c), y.times(c), z.times(c).plus(-B::ONE)];
        let along = to[0] * d[0] + to[1] * d[1] + to[2] * d[2];
        let outside = to[0] * to[0] + to[1] * to[1] + to[2] * to[2];
        let discriminant = along * along - outside.plus(-B::ONE);
        // The first meeting: the cosine of incidence is the root itself.
        let q = discriminant.sqrt();
        let p: [T; 3] = std::array::from_fn(|i| to[i] - (along + q) * d[i]);
        let o = [
            p[0] / T::constant(c),
            p[1] / T::constant(c),
            p[2].plus(B::ONE) / T::constant(c),
        ];
        let convex = c > B::ZERO && self.asphere.is_none();
        let k = self.to_film.cosine2(discriminant);
        let g = k.sqrt() - q.times(self.to_film.ratio);
        // The normal points to the center.
        let d = std::array::from_fn(|i| d[i].times(self.to_film.ratio) - g * p[i]);
        Crossing {
            ray: LensRay { o, d },
            met: convex && discriminant.at_least(B::ZERO) && (-p[2]).greater(B::ZERO),
            inside: (o[0] * o[0] + o[1] * o[1]).at_most(self.radius2),
            refracted: k.at_least(B::ZERO),
        }
    }

    /// Both ways that light of the direction `d` goes from where it meets the surface; `None` where it does not, or the rim blocks.
    pub(super) fn split<T: Real<Base = B>>(
        &self,
        crossing: &Crossing<T>,
        d: [T; 3],
        toward: Toward,
    ) -> Option<Split<T>> {
        if !(crossing.met && crossing.inside) {
            return None;
        }
        let o = crossing.ray.o;
        let normal = self.normal(o);
        let along = d[0] * normal[0] + d[1] * normal[1] + d[2] * normal[2];
        let back = std::array::from_fn(|axis| d[axis] - (along + along) * normal[axis]);
        Some(Split {
            cosine: along.times(toward.sign()),
            reflected: LensRay { o, d: back },
            refracted: crossing.refracted.then_some(crossing.ray),
        })
    }

    /// Unit normal at the point `p` of the surface, leaning toward the film.
    pub(super) fn normal<T: Number<Base = B>>(&self, [x, y, z]: [T; 3]) -> [T; 3] {
        let Some(asphere) = &self.asphere else {
            let c = -self.curvature;
            return [x.times(c), y.times(c), z.times(c).plus(B::ONE)];
        };
        asphere.normal(x, y)
    }

    /// Returns `true` if the aperture, if it blocks, lets light pass at (x, y).
    #[inline(always)]
    fn within<T: Number<Base = B>>(&self, x: T, y: T, clip: bool) -> T::Mask {
        if !clip {
            return T::Mask::YES;
        }
        let round = (x * x + y * y).at_most(self.radius2);
        match &self.edges {
            Some(edges) => round & edges.hold(x, y),
            None => round,
        }
    }

    #[inline(always)]
    fn refraction(&self, toward: Toward) -> &Refraction<B> {
        match toward {
            Toward::Film => &self.to_film,
            Toward::Scene => &self.to_scene,
        }
    }

    /// As [`Element::cross`], for an aspheric surface and rays of which those run `ahead`.
    #[inline(always)]
    fn cross_asphere<T: Number<Base = B>>(
        &self,
        asphere: &AsphericSurface<B>,
        ray: &LensRay<T>,
        toward: Toward,
        clip: bool,
        ahead: T::Mask,
    ) -> Crossing<T> {
        let meeting = asphere.meet(ray.o, ray.d, toward.sign());
        let ([x, y, _], d, normal) = (meeting.point, ray.d, meeting.normal);
        let q = d[0] * normal[0] + d[1] * normal[1] + d[2] * normal[2];
        let tolerance = asphere.tolerance();
        let on = (meeting.residual * meeting.residual).at_most(tolerance * tolerance);
        let forward = q.times(toward.sign()).greater(B::ZERO);
        let mut crossing = Crossing {
            ray: LensRay {
                o: meeting.point,
                d,
            },
            met: ahead & on & meeting.inside.greater(B::ZERO) & forward,
            inside: self.within(x, y, clip),
            refracted: T::Mask::YES,
        };
        let refraction = self.refraction(toward);
        let mu = refraction.ratio;
        let k = refraction.cosine2(q * q);
        crossing.refracted = k.at_least(B::ZERO);
        let g = k.sqrt().times(toward.sign()) - q.times(mu);
        crossing.ray.d = [0, 1, 2].map(|axis| d[axis].times(mu) + g * normal[axis]);
        crossing
    }
}
