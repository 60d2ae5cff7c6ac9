//! Vertices of a path, on a surface or in a medium, as emitter sampling needs them.

use crate::accel::GeometryHit;
use crate::bsdf::{Bsdf, Scatterer};
use crate::handles::MediumId;
use crate::math::{Rgb, Vec3};
use crate::media::HenyeyGreenstein;
use crate::surface::{ReceiverSide, ReferencePoint, SurfaceHit};
use crate::world::World;

/// A scattering event. Directions are unit vectors away from it.
pub(super) trait Vertex {
    /// The point that receives light.
    fn reference_point(&self) -> ReferencePoint;

    /// The BSDF times the cosine, or the phase function, for radiance from `wi`, and the density per steradian with
    /// which the path samples `wi`.
    fn scattered_and_pdf(&self, wi: Vec3) -> (Rgb, f32);

    /// The medium that a ray along `wi` enters.
    fn medium_toward(&self, world: &World, wi: Vec3) -> Option<MediumId>;
}

/// A point on a surface where emitter sampling and BSDF sampling are combined.
pub(super) fn receiver(surface: &SurfaceHit, bsdf: &Bsdf) -> ReferencePoint {
    ReferencePoint {
        shading_n: surface.turned(bsdf.shading_normal()),
        receiver_side: bsdf.receiver_side(surface.wo),
        ..surface.reference_point()
    }
}

/// A point on a surface.
pub(super) struct SurfaceVertex<'a> {
    /// The surface.
    pub hit: &'a GeometryHit,
    /// How it scatters.
    pub bsdf: &'a Bsdf<'a>,
    /// The medium that the path arrived through.
    pub medium: Option<MediumId>,
}

impl Vertex for SurfaceVertex<'_> {
    fn reference_point(&self) -> ReferencePoint {
        receiver(&self.hit.surface, self.bsdf)
    }

    #[inline]
    fn scattered_and_pdf(&self, wi: Vec3) -> (Rgb, f32) {
        let (f, pdf) = self.bsdf.f_and_pdf(self.hit.surface.wo, wi);
        (f * wi.dot(self.bsdf.shading_normal()).abs(), pdf)
    }

    fn medium_toward(&self, world: &World, wi: Vec3) -> Option<MediumId> {
        world.medium_beyond(self.hit, wi, self.medium)
    }
}

/// A point on a surface that bounds no medium.
pub(super) struct LeanVertex<S> {
    pub from: ReferencePoint,
    /// How the surface scatters.
    pub scatterer: S,
}

impl<S: Scatterer> Vertex for LeanVertex<S> {
    fn reference_point(&self) -> ReferencePoint {
        self.from
    }

    #[inline(always)]
    fn scattered_and_pdf(&self, wi: Vec3) -> (Rgb, f32) {
        self.scatterer.scattered_and_pdf(wi)
    }

    fn medium_toward(&self, _: &World, _: Vec3) -> Option<MediumId> {
        None
    }
}

/// A point in a medium.
#[derive(Clone, Copy)]
pub(super) struct MediumVertex {
    /// Position; rounding errors do not matter, as no surface is there.
    pub p: Vec3,
    /// Toward the previous vertex.
    pub wo: Vec3,
    /// The phase function.
    pub phase: HenyeyGreenstein,
    /// The medium.
    pub medium: MediumId,
    /// When.
    pub time: f32,
}

impl Vertex for MediumVertex {
    fn reference_point(&self) -> ReferencePoint {
        ReferencePoint {
            p: self.p,
            p_error: Vec3::ZERO,
            n: Vec3::ZERO,
            shading_n: Vec3::ZERO,
            time: self.time,
            receiver_side: ReceiverSide::BothSides,
        }
    }

    fn scattered_and_pdf(&self, wi: Vec3) -> (Rgb, f32) {
        let value = self.phase.value(self.wo, wi);
        (Rgb::splat(value), value)
    }

    fn medium_toward(&self, _: &World, _: Vec3) -> Option<MediumId> {
        Some(self.medium)
    }
}
