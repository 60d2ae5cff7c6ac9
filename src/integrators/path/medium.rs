//! Paths through participating media, and through the surfaces without material that bound them.

use super::emission::MisState;
use super::{Branch, MAX_NULL_SURFACES, PathState, Trail};
use crate::accel::GeometryHit;
use crate::handles::MediumId;
use crate::integrators::Sight;
use crate::integrators::vertex::{MediumVertex, Vertex};
use crate::integrators::witness::Met;
use crate::math::Rgb;
use crate::math::ray::Ray;
use crate::media::{BothWays, HenyeyGreenstein};
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

/// Before so many scattering events a path takes both ways through a medium.
const BOTH_WAYS_IN_MEDIA: u32 = 2;

impl<const MEDIA: bool, const WATCHED: bool> PathState<'_, MEDIA, WATCHED> {
    /// Crosses a medium up to `t_max`, where the path has `hit` something or nothing; or to the scattering event before it that is returned. The
    /// throughput may become black.
    ///
    /// Early in a path it takes both ways where the medium knows them ([`Medium::both_ways`](crate::media::Medium::both_ways)): the brighter one
    /// always, the other with the square root of the ratio of what they carry, as at [glass](crate::bsdf::Ways::both). What scatters then begins a
    /// branch. Where there is nothing behind the medium no path is lost to it.
    pub(super) fn cross_medium(
        &mut self,
        (id, t_max): (MediumId, f32),
        hit: Option<&GeometryHit>,
    ) -> Option<MediumVertex> {
        let Some((ways, vertex)) = self.ways_through_medium(id, t_max) else {
            return self.sample_medium(id, t_max);
        };
        let before = self.trail.throughput;
        let (scattered, passed) = (before * ways.scattered, before * ways.passed);
        if hit.is_none() && self.context.world.infinite_lights.is_empty() {
            self.trail.throughput = scattered;
            return Some(vertex);
        }
        let ratio = passed.element_sum() / scattered.element_sum();
        let chance_of_scattering = (1.0 / ratio).sqrt().min(1.0);
        let chance_of_passing = ratio.sqrt().min(1.0);
        let u = self.context.stream.next_1d();
        let numbers_of_passing = self.context.stream.fork();
        let scattered = scattered / chance_of_scattering;
        if u >= chance_of_passing {
            self.trail.throughput = scattered;
            return Some(vertex);
        }
        if u < chance_of_scattering {
            self.branch_off(scattered, &vertex);
        }
        *self.context.stream = numbers_of_passing;
        self.trail.throughput = passed / chance_of_passing;
        None
    }

    /// Both ways through a medium, and the point where it may scatter, where the path is to take them.
    fn ways_through_medium(
        &mut self,
        id: MediumId,
        t_max: f32,
    ) -> Option<(BothWays, MediumVertex)> {
        let is_early = self.trail.depth < self.trail.max_depth.min(BOTH_WAYS_IN_MEDIA);
        if !is_early || !self.may_branch() || self.path.media != MediaSeen::All {
            return None;
        }
        let medium = self.context.world.media.medium(id);
        let (throughput, stream) = (self.trail.throughput, &mut *self.context.stream);
        let (ways, phase) = medium.both_ways(t_max, throughput, stream)?;
        let vertex = self.medium_vertex(ways.t, id, phase);
        Some((ways, vertex))
    }

    /// Begins a branch that scatters at a point of a medium, which it comes to with this throughput.
    fn branch_off(&mut self, throughput: Rgb, vertex: &MediumVertex) {
        let (before, differentials) = (*self.trail, self.differentials);
        self.arrive(Met::Medium);
        // Layers look along the way that passes.
        self.trail.is_seen = false;
        self.trail.throughput = throughput;
        let left = self.scatter_in_medium(vertex);
        let left = left.and_then(|()| self.russian_roulette());
        let (trail, stream) = (*self.trail, *self.context.stream);
        self.branches
            .extend(left.map(|()| Branch { trail, stream }));
        let passing = Trail {
            radiance: self.trail.radiance,
            ..before
        };
        (*self.trail, self.differentials) = (passing, differentials);
    }

    /// Crosses a medium one way, which is chosen by chance: see [`PathState::cross_medium`].
    fn sample_medium(&mut self, id: MediumId, t_max: f32) -> Option<MediumVertex> {
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
        Some(self.medium_vertex(t, id, phase))
    }

    /// The point of a medium at the distance `t`, as a vertex.
    fn medium_vertex(&self, t: f32, medium: MediumId, phase: HenyeyGreenstein) -> MediumVertex {
        let ray = &self.trail.ray;
        MediumVertex {
            p: ray.at(t),
            wo: -ray.d,
            phase,
            medium,
            time: ray.time,
        }
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
        if self.trail.null_surfaces > MAX_NULL_SURFACES {
            self.look(Sight::escape);
            return None;
        }
        if too_deep {
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
