//! Paths through participating media, and through the surfaces without material that bound them.

use super::emission::MisState;
use super::{MAX_NULL_SURFACES, PathState};
use crate::accel::GeometryHit;
use crate::handles::MediumId;
use crate::integrators::vertex::{MediumVertex, Vertex};
use crate::math::ray::Ray;
use crate::params::ParamReader;

/// Which light transport in media is simulated.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum MediaSeen {
    /// All of it.
    #[default]
    All,
    /// pbrt-v2's `VolumeIntegrator "single"`: emission and single scattering in the media that the camera sees, directly or
    /// by perfectly specular bounces; after other surfaces media only attenuate.
    Single,
    /// pbrt-v2's `VolumeIntegrator "emission"`: the same without scattering.
    Emission,
}

impl MediaSeen {
    /// Reads a `VolumeIntegrator`. `stepsize` (1): noise only, and none here, where nothing marches.
    pub fn from_params(reader: &ParamReader) -> MediaSeen {
        reader.accept("stepsize");
        match reader.kind() {
            "single" => MediaSeen::Single,
            "emission" => MediaSeen::Emission,
            _ => {
                reader.unknown_kind(&["emission", "single"]);
                MediaSeen::Emission
            }
        }
    }
}

impl<const MEDIA: bool, const WATCHED: bool> PathState<'_, MEDIA, WATCHED> {
    /// Crosses a medium up to `t_max`, or to the scattering event before it that is returned. The throughput may
    /// become black.
    pub(super) fn sample_medium(&mut self, id: MediumId, t_max: f32) -> Option<MediumVertex> {
        let medium = self.context.world.media.medium(id);
        let (emits, scatters) = match self.path.media {
            MediaSeen::All => (true, true),
            MediaSeen::Single => (self.trail.specular_only, self.trail.specular_only),
            MediaSeen::Emission => (self.trail.specular_only, false),
        };
        if emits {
            let light = self.trail.throughput
                * medium.emission(&self.trail.ray, t_max, self.context.stream);
            self.trail.radiance += light;
            self.context.part(None, light);
        }
        if !scatters {
            self.trail.throughput *=
                medium.transmittance(&self.trail.ray, t_max, self.context.stream);
            return None;
        }
        let (flight, phase) = medium.sample(
            &self.trail.ray,
            t_max,
            self.trail.throughput,
            self.context.stream,
        );
        self.trail.throughput *= flight.weight;
        let t = flight.scattered?;
        Some(MediumVertex {
            p: self.trail.ray.at(t),
            wo: -self.trail.ray.d,
            phase,
            medium: id,
            time: self.trail.ray.time,
        })
    }

    /// Emitter sampling and phase function sampling at a point of a medium.
    pub(super) fn scatter_in_medium(&mut self, vertex: &MediumVertex) -> Option<()> {
        if self.trail.depth >= self.trail.max_depth || !vertex.p.is_finite() {
            return None;
        }
        self.sample_direct(vertex);
        let u = self.context.stream.next_2d();
        let (wi, pdf) = vertex.phase.sample(vertex.wo, u);
        let from = vertex.reference_point();
        self.trail.ray = Ray::new(vertex.p, wi, from.time);
        self.trail.mis = self.sampled(from, pdf);
        self.differentials = None;
        self.trail.specular_only = false;
        if self.path.media == MediaSeen::Single {
            self.trail.max_depth = self.trail.depth + 1;
        }
        Some(())
    }

    /// Continues through a surface without material, which is not a scattering event.
    ///
    /// At the last depth only scattered paths of `volpath` do: they find the BSDF-sampled half of their last vertex's
    /// direct light, and the emitter-sampled half passes these surfaces too.
    /// A path from the camera or a mirror ends there as in pbrt-v3.
    pub(super) fn skip_null_surface(&mut self, hit: &GeometryHit) -> Option<()> {
        let sampled = matches!(self.trail.mis, MisState::Sampled(_));
        self.trail.null_surfaces += 1;
        let too_deep = self.trail.depth >= self.trail.max_depth && !(MEDIA && sampled);
        if self.trail.null_surfaces > MAX_NULL_SURFACES || too_deep {
            return None;
        }
        if MEDIA {
            let world = self.context.world;
            self.trail.medium = world.medium_beyond(hit, self.trail.ray.d, self.trail.medium);
        } else if sampled {
            self.trail.mis = MisState::Blocked;
        }
        self.trail.ray = hit.surface.spawn_ray(self.trail.ray.d);
        self.differentials = None;
        Some(())
    }
}
