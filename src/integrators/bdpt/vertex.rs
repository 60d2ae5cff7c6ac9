//! A vertex of a subpath: how it scatters, seen from either end of the path.

use crate::accel::GeometryHit;
use crate::bsdf::{Bsdf, Matte, Scatterer};
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
        /// All light that it transmits is scattered below ([`World::scatters_below`]): no subpath continues straight.
        below: bool,
    },
    /// On a flat triangle that is matte everywhere, and no interface between media.
    Flat(&'v FlatVertex),
    /// In a medium.
    Medium(&'v MediumVertex),
}

/// A point on a flat matte triangle.
#[derive(Clone, Copy)]
pub(super) struct FlatVertex {
    pub from: ReferencePoint,
    pub matte: Matte,
    pub wo: Vec3,
    /// |cos θ| of `wo` to the geometric normal.
    pub cosine: f32,
    /// The medium around it.
    pub medium: Option<MediumId>,
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
            Vertex::Flat(at) => at.from,
            Vertex::Medium(at) => at.reference_point(),
        }
    }

    /// The cosine of `w` to the geometric normal, by which densities per solid angle become those per area; 1 in a medium.
    pub(super) fn cosine(&self, w: Vec3) -> f32 {
        match self {
            Vertex::Surface { hit, .. } => hit.surface.n.dot(w).abs(),
            Vertex::Flat(at) => at.from.n.dot(w).abs(),
            Vertex::Medium(_) => 1.0,
        }
    }

    /// `true` if it can be joined to other vertices: not all of its scattering is perfectly specular.
    pub(super) fn connects(&self) -> bool {
        match self {
            Vertex::Surface { bsdf, .. } => bsdf.has_non_specular(),
            Vertex::Flat(_) | Vertex::Medium(_) => true,
        }
    }

    /// Returns `true` if `w` is on the other side of a surface below which all light is scattered. A path sees emission through it, as
    /// through glass, but nothing else, and does not continue there.
    pub(super) fn ends_toward(&self, w: Vec3) -> bool {
        match self {
            Vertex::Surface { below: false, .. } | Vertex::Flat(_) | Vertex::Medium(_) => false,
            Vertex::Surface { hit, .. } => {
                let surface = &hit.surface;
                surface.n.dot(w) * surface.n.dot(surface.wo) < 0.0
            }
        }
    }

    /// The medium that a ray along `w` enters.
    pub(super) fn medium_toward(&self, world: &World, w: Vec3) -> Option<MediumId> {
        match self {
            Vertex::Surface { hit, medium, .. } => world.medium_beyond(hit, w, *medium),
            Vertex::Flat(at) => at.medium,
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
                    reverse: bsdf.pdf(wi, wo),
                })
            }
            Vertex::Flat(at) => {
                let (value, forward) = at.matte.scattered_and_pdf(wi);
                (value != Rgb::ZERO).then(|| Scattered {
                    value,
                    forward,
                    reverse: at.reverse(wi),
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
                let value = f * importance_cosine(normals(hit, bsdf), wo, wi);
                (value != Rgb::ZERO).then(|| Scattered {
                    value,
                    forward: bsdf.pdf(wo, wi),
                    reverse,
                })
            }
            Vertex::Flat(at) => at.importance(wi),
            Vertex::Medium(at) => Some(at.scattered(wi)),
        }
    }
}

impl FlatVertex {
    /// Density per solid angle with which a subpath that arrives along `wi` continues along `wo`.
    pub(super) fn reverse(&self, wi: Vec3) -> f32 {
        self.seen_from(wi).f_and_pdf(self.wo).1
    }

    /// How the surface scatters toward `wi`.
    fn seen_from(&self, wi: Vec3) -> Matte {
        let matte = &self.matte;
        let (ng, n) = (matte.geometric_normal(), matte.shading_normal());
        Matte::new(matte.reflectance(), ng, n, wi)
    }

    /// Importance from `wi` that is scattered to `wo`: see [`Vertex::importance`].
    fn importance(&self, wi: Vec3) -> Option<Scattered> {
        let (f, reverse) = self.seen_from(wi).f_and_pdf(self.wo);
        let value = f * self.importance_cosine(wi);
        (value != Rgb::ZERO).then(|| Scattered {
            value,
            forward: self.matte.f_and_pdf(wi).1,
            reverse,
        })
    }

    fn importance_cosine(&self, wi: Vec3) -> f32 {
        importance_cosine((self.from.n, self.matte.shading_normal()), self.wo, wi)
    }

    /// What importance is multiplied by that continues along `wi`, which the BSDF chose with the density `pdf`; and the density of the
    /// opposite direction.
    pub(super) fn importance_factor(&self, wi: Vec3, pdf: f32) -> (Rgb, f32) {
        let (f, reverse) = self.seen_from(wi).f_and_pdf(self.wo);
        (f * (self.importance_cosine(wi) / pdf), reverse)
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
pub(super) fn importance_cosine((n, shading): (Vec3, Vec3), wo: Vec3, wi: Vec3) -> f32 {
    let seen = n.dot(wo).abs();
    if seen == 0.0 {
        return 0.0;
    }
    shading.dot(wo).abs() * n.dot(wi).abs() / seen
}

/// The geometric and the shading normal.
pub(super) fn normals(hit: &GeometryHit, bsdf: &Bsdf) -> (Vec3, Vec3) {
    (hit.surface.n, bsdf.shading_normal())
}
