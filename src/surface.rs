//! Surface interactions: a point on a surface, with everything needed for shading and light sampling.
//!
//! All in *render space*: world space translated so that the camera is at the origin, which keeps single precision
//! where the image needs it, however far from the world's origin.

use crate::math::float::offset_ray_origin;
use crate::math::ray::{Ray, RayDifferentials};
use crate::math::{Vec2, Vec3};

/// A point on a surface.
#[derive(Clone, Copy, Debug)]
pub struct SurfaceHit {
    /// Position.
    pub p: Vec3,
    /// Half-widths of the box around `p` that contains the exact point.
    pub p_error: Vec3,
    /// Unit geometric normal, oriented by the rules of docs/scene-language.md §4.4 (it defines inside and outside).
    pub n: Vec3,
    /// Surface parameters.
    pub uv: Vec2,
    /// ∂p/∂u and ∂p/∂v of the true surface.
    pub dpdu: Vec3,
    /// See `dpdu`.
    pub dpdv: Vec3,
    /// The geometry used for shading instead of the true one.
    pub shading: ShadingGeometry,
    /// Unit direction back along the incoming ray.
    pub wo: Vec3,
    /// Time of the ray.
    pub time: f32,
    /// Face index in the original mesh, for Ptex; 0 if there is none.
    pub face: u32,
}

/// The shading geometry, which interpolated normals and tangents and bump mapping change.
#[derive(Clone, Copy, Debug)]
pub struct ShadingGeometry {
    /// Unit shading normal.
    pub n: Vec3,
    /// Shading ∂p/∂u and ∂p/∂v.
    pub dpdu: Vec3,
    /// See `dpdu`.
    pub dpdv: Vec3,
    /// Change of the shading normal with u.
    pub dndu: Vec3,
    /// See `dndu`.
    pub dndv: Vec3,
}

impl SurfaceHit {
    /// A ray leaving this point in unit direction `d`, starting outside the error box.
    #[inline]
    pub fn spawn_ray(&self, d: Vec3) -> Ray {
        self.reference_point().shadow_ray_toward(d)
    }

    /// The point for texture lookups, with a footprint.
    #[inline]
    pub fn texture_point(&self, footprint: &Footprint) -> TexturePoint {
        TexturePoint {
            p: self.p,
            uv: self.uv,
            footprint: *footprint,
            face: self.face,
        }
    }

    /// A normal, turned to where the ray came from.
    #[inline]
    pub fn turned(&self, n: Vec3) -> Vec3 {
        n * 1_f32.copysign(n.dot(self.wo))
    }

    /// The properties of this point that light sampling needs.
    #[inline]
    pub fn reference_point(&self) -> ReferencePoint {
        ReferencePoint {
            p: self.p,
            p_error: self.p_error,
            n: self.n,
            shading_n: self.turned(self.n),
            time: self.time,
            receiver_side: ReceiverSide::NoMis,
        }
    }

    /// The texture footprint of one film sample here, from the intersections of the differential rays with the tangent
    /// plane (Pharr, Jakob and Humphreys 2016, §10.1.1). Zero if it is undefined.
    pub fn footprint(&self, differentials: Option<&RayDifferentials>) -> Footprint {
        let Some(rd) = differentials else {
            return Footprint::default();
        };
        let d = self.n.dot(self.p);
        let tx = (d - self.n.dot(rd.rx_o)) / self.n.dot(rd.rx_d);
        let ty = (d - self.n.dot(rd.ry_o)) / self.n.dot(rd.ry_d);
        if !tx.is_finite() || !ty.is_finite() {
            return Footprint::default();
        }
        let dpdx = rd.rx_o + tx * rd.rx_d - self.p;
        let dpdy = rd.ry_o + ty * rd.ry_d - self.p;
        // Solve dpd? = du dpdu + dv dpdv in the two dimensions other than the normal's dominant one.
        let a = self.n.abs();
        let (i, j) = if a.x > a.y && a.x > a.z {
            (1, 2)
        } else if a.y > a.z {
            (0, 2)
        } else {
            (0, 1)
        };
        let det = self.dpdu[i] * self.dpdv[j] - self.dpdv[i] * self.dpdu[j];
        let solve = |b: Vec3| {
            let du = (self.dpdv[j] * b[i] - self.dpdv[i] * b[j]) / det;
            let dv = (self.dpdu[i] * b[j] - self.dpdu[j] * b[i]) / det;
            if du.is_finite() && dv.is_finite() {
                Vec2::new(du, dv)
            } else {
                Vec2::ZERO
            }
        };
        Footprint {
            dpdx,
            dpdy,
            duvdx: solve(dpdx),
            duvdy: solve(dpdy),
        }
    }
}

/// Texture footprint: the change of position and (u, v) from one film sample to the next, in x and in y.
#[derive(Clone, Copy, Debug, Default)]
pub struct Footprint {
    /// ∂p/∂x on the film.
    pub dpdx: Vec3,
    /// ∂p/∂y on the film.
    pub dpdy: Vec3,
    /// ∂(u,v)/∂x.
    pub duvdx: Vec2,
    /// ∂(u,v)/∂y.
    pub duvdy: Vec2,
}

/// A point at which a texture is evaluated.
#[derive(Clone, Copy, Debug)]
pub struct TexturePoint {
    /// Position in render space.
    pub p: Vec3,
    /// Surface parameters.
    pub uv: Vec2,
    /// Filter footprint; zero selects the finest level.
    pub footprint: Footprint,
    /// See [`SurfaceHit::face`].
    pub face: u32,
}

/// A point that receives light.
#[derive(Clone, Copy, Debug, Default)]
pub struct ReferencePoint {
    /// Position.
    pub p: Vec3,
    /// See [`SurfaceHit::p_error`].
    pub p_error: Vec3,
    /// Unit geometric normal; zero for a point in a medium.
    pub n: Vec3,
    /// Unit shading normal, turned to where the scattered light goes; zero in a medium. Not looked at where there is no MIS.
    pub shading_n: Vec3,
    /// Time of the ray.
    pub time: f32,
    /// Which hemisphere contributes.
    pub receiver_side: ReceiverSide,
}

/// Which hemisphere contributes at this point, and whether BSDF sampling competes (MIS). It guides where samples are
/// taken; all directions may be sampled regardless of it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ReceiverSide {
    /// All directions, by light sampling only.
    #[default]
    NoMis,
    /// All directions; BSDF sampling finds the light too (multiple importance sampling).
    BothSides,
    /// The side that the normal points to; BSDF sampling finds the light too.
    Front,
    /// The opposite side; BSDF sampling finds the light too.
    Back,
}

impl ReferencePoint {
    /// A shadow ray from here to the point `target` (with its error box and normal, zero for none), ending just before
    /// it. Both ends are first offset from their surfaces.
    #[inline(always)]
    pub fn shadow_ray_to(&self, target: Vec3, target_error: Vec3, target_n: Vec3) -> Ray {
        let o = offset_ray_origin(self.p, self.p_error, self.n, target - self.p);
        // Not as seen from `o`, whose computation would have to finish first.
        let t = offset_ray_origin(target, target_error, target_n, self.p - target);
        let d = t - o;
        let distance = d.length();
        // Ends a ten-thousandth before the target, as in pbrt: the light itself does not occlude.
        Ray {
            o,
            d: d / distance,
            t_max: distance * (1.0 - 1e-4),
            time: self.time,
        }
    }

    /// An infinite shadow ray from here in unit direction `d`.
    #[inline]
    pub fn shadow_ray_toward(&self, d: Vec3) -> Ray {
        let o = offset_ray_origin(self.p, self.p_error, self.n, d);
        Ray::new(o, d, self.time)
    }
}
