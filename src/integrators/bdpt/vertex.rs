//! A vertex of a subpath: how it scatters, seen from either end of the path.

use crate::accel::GeometryHit;
use crate::bsdf::Bsdf;
use crate::handles::MediumId;
use crate::integrators::vertex::{MediumVertex, Vertex as _, receiver};
use crate::math::{Rgb, Vec3};
use crate::surface::ReferencePoint;
use crate::world::World;

/// A scattering event, as seen from where it is kept. Directions are unit vectors away from it; `wo` is toward the previous vertex
/// of its subpath.
#[derive(Clone, Copy)]
pub(super) enum Vertex<'v, 'a> {
    /// On a surface with a material.
    Surface {
        /// The surface.
        hit: &'v GeometryHit,
        /// How it scatters.
        bsdf: &'v Bsdf<'a>,
        /// The medium that the subpath arrived through.
        medium: Option<MediumId>,
    },
    /// In a medium.
    Medium(&'v MediumVertex),
}

/// What scattering does to a subpath that arrives along `wo` and continues along `wi`.
#[derive(Clone, Copy, Debug)]
pub(super) struct Scattered {
    /// The BSDF or phase function, times the cosine that the subpath's throughput takes up.
    pub value: Rgb,
    /// Density per solid angle with which the subpath continues along `wi`.
    pub forward: f32,
    /// Density per solid angle with which a subpath that arrives along `wi` continues along `wo`.
    pub reverse: f32,
}

impl Vertex<'_, '_> {
    /// The point, for rays and emitter sampling.
    pub(super) fn reference_point(&self) -> ReferencePoint {
        match self {
            Vertex::Surface { hit, bsdf, .. } => receiver(&hit.surface, bsdf),
            Vertex::Medium(at) => at.reference_point(),
        }
    }

    /// The cosine of `w` to the geometric normal, by which densities per solid angle become those per area; 1 in a medium.
    pub(super) fn cosine(&self, w: Vec3) -> f32 {
        match self {
            Vertex::Surface { hit, .. } => hit.surface.n.dot(w).abs(),
            Vertex::Medium(_) => 1.0,
        }
    }

    /// `true` if it can be joined to other vertices: not all of its scattering is perfectly specular.
    pub(super) fn connects(&self) -> bool {
        match self {
            Vertex::Surface { bsdf, .. } => bsdf.has_non_specular(),
            Vertex::Medium(_) => true,
        }
    }

    /// The medium that a ray along `w` enters.
    pub(super) fn medium_toward(&self, world: &World, w: Vec3) -> Option<MediumId> {
        match self {
            Vertex::Surface { hit, medium, .. } => world.medium_beyond(hit, w, *medium),
            Vertex::Medium(at) => Some(at.medium),
        }
    }

    /// Radiance from `wi` that is scattered to `wo`: for subpaths from the camera.
    pub(super) fn radiance(&self, wi: Vec3) -> Option<Scattered> {
        match self {
            Vertex::Surface { hit, bsdf, .. } => {
                let wo = hit.surface.wo;
                let (f, forward) = bsdf.f_and_pdf(wo, wi);
                let value = f * bsdf.shading_normal().dot(wi).abs();
                (value != Rgb::ZERO).then(|| Scattered {
                    value,
                    forward,
                    reverse: bsdf.f_and_pdf(wi, wo).1,
                })
            }
            Vertex::Medium(at) => Some(at.scattered(wi)),
        }
    }

    /// The adjoint (Veach 1997, §3.7 and §5.3): importance from `wi` that is scattered to `wo`, for subpaths from a light. By its
    /// definition it is the BSDF with its directions exchanged, as it would be seen from the camera's side; so is the
    /// cosine of shading normals, which is that to `wo`.
    pub(super) fn importance(&self, wi: Vec3) -> Option<Scattered> {
        match self {
            Vertex::Surface { hit, bsdf, .. } => {
                let wo = hit.surface.wo;
                let (f, reverse) = bsdf.f_and_pdf(wi, wo);
                let value = f * importance_cosine(hit, bsdf, wi);
                (value != Rgb::ZERO).then(|| Scattered {
                    value,
                    forward: bsdf.f_and_pdf(wo, wi).1,
                    reverse,
                })
            }
            Vertex::Medium(at) => Some(at.scattered(wi)),
        }
    }
}

impl MediumVertex {
    /// The phase function is reciprocal, and its own density.
    fn scattered(&self, wi: Vec3) -> Scattered {
        let value = self.phase.value(self.wo, wi);
        Scattered {
            value: Rgb::splat(value),
            forward: value,
            reverse: value,
        }
    }
}

/// What takes the place of |cos θ| toward `wi` for importance (Veach 1997, equation 5.19): a path from the camera would take up
/// the cosine of the shading normal toward the light, `wo`, and areas are seen under those of the geometric normal.
pub(super) fn importance_cosine(hit: &GeometryHit, bsdf: &Bsdf, wi: Vec3) -> f32 {
    let (n, wo) = (hit.surface.n, hit.surface.wo);
    let seen = n.dot(wo).abs();
    if seen == 0.0 {
        return 0.0;
    }
    bsdf.shading_normal().dot(wo).abs() * n.dot(wi).abs() / seen
}
