//! Connections of a camera path's vertices: to a point of a light (s = 1, emitter sampling), and to the vertices of a light path (s ≥ 2).

use super::camera_path::CameraPath;
use super::kept::LightPath;
use super::light_end::Lit;
use super::vertex::Vertex;
use super::weights::{History, square, weight, weight_of_joint};
use crate::accel::Passage;
use crate::handles::{LightId, MediumId};
use crate::integrators::volpath::{dimmed_along, shadow_segment, transmittance};
use crate::math::Rgb;
use crate::math::color::is_black;
use crate::math::ray::Ray;

/// Light that a path gains if nothing blocks a shadow ray.
#[derive(Clone, Copy)]
pub(super) struct Gain {
    /// The number of the path.
    pub path: u32,
    /// Where it comes from.
    from: Option<LightId>,
    /// Scattering events of the whole path, and its vertices from the light.
    strategy: (u32, u32),
    /// The medium where the shadow ray begins.
    medium: Option<MediumId>,
    /// Without and with its weight.
    light: Rgb,
    weighted: Rgb,
}

impl<'a> CameraPath<'_, 'a> {
    /// Joins a vertex to points of lights and to the vertices of the light path.
    pub(super) fn join(&mut self, vertex: Vertex<'_, 'a>, history: &History) {
        self.sample_light(vertex, history);
        self.connect(vertex, history);
    }

    /// s = 1: emitter sampling.
    fn sample_light(&mut self, vertex: Vertex<'_, 'a>, history: &History) {
        let (world, lights) = (self.context.world, self.context.lights);
        let from = vertex.reference_point();
        let numbers = self.context.stream.next_choice(lights.selector.chooses());
        let Some(selected) = lights.selector.sample(&from, numbers.choice) else {
            return;
        };
        let (id, pmf) = (selected.light, selected.pmf);
        let u = numbers.point(pmf, selected.rest);
        let Some((arriving, end)) = world.light(id).sample_with_end(&from, u) else {
            return;
        };
        let Some(scattered) = vertex.radiance(arriving.wi) else {
            return;
        };
        // No light path continues through a surface below which light is scattered.
        let reverse = match vertex.ends_toward(arriving.wi) {
            true => 0.0,
            false => f64::from(scattered.reverse),
        };
        let contribution = scattered.value * arriving.radiance / (pmf * arriving.pdf);
        if is_black(contribution) {
            return;
        }
        // The light is met by chance with the density `forward`, where emitter sampling has pmf · pdf; both per solid angle.
        let met = match arriving.delta {
            true => 0.0,
            false => {
                square(f64::from(scattered.forward) / (f64::from(pmf) * f64::from(arriving.pdf)))
            }
        };
        let camera = match history.is_alone() {
            true => 0.0,
            false => {
                let lit = Lit {
                    id,
                    end,
                    from: &from,
                    cosine: vertex.cosine(arriving.wi),
                    wi: arriving.wi,
                    pdf: arriving.pdf,
                };
                let densities = lit.densities(world, lights, pmf);
                let begun = densities.onward * densities.emitted / densities.direct;
                history.earlier(begun, reverse)
            }
        };
        let weight = weight(met, camera);
        let light = self.trail.walk.throughput * contribution;
        self.context.shadow(id, false);
        let gain = Gain {
            path: 0,
            from: Some(id),
            strategy: (self.trail.walk.depth + 1, 1),
            medium: vertex.medium_toward(world, arriving.wi),
            light,
            weighted: light * weight,
        };
        self.trace_shadow(&arriving.shadow, gain);
    }

    /// Adds what arrives along a shadow ray, at once or when it is traced together with others.
    fn trace_shadow(&mut self, shadow: &Ray, gain: Gain) {
        let world = self.context.world;
        match &mut self.waiting {
            Some((shadows, path)) => {
                let path = *path;
                let shadow = shadow_segment(world, shadow, gain.medium);
                // There is room: see `max_shadow_rays`.
                shadows.push(&shadow, Gain { path, ..gain });
            }
            None => {
                let left = transmittance(world, self.context.stream, shadow, gain.medium);
                self.gain(&gain, left);
            }
        }
    }

    /// The most shadow rays of one step, where no path comes to two vertices in one.
    pub(super) fn max_shadow_rays(light_path: LightPath) -> usize {
        1 + light_path.len()
    }

    /// Adds the light of a shadow ray that nothing has blocked: see [`dimmed_along`].
    pub(super) fn gain_unblocked(
        &mut self,
        shadow: &Ray,
        gain: &Gain,
        passage: Option<&mut Passage>,
    ) {
        let (world, stream) = (self.context.world, &mut *self.context.stream);
        let left = dimmed_along(world, stream, gain.medium, shadow, passage);
        self.gain(gain, left);
    }

    /// Adds light of which so much is `left` along a shadow ray.
    fn gain(&mut self, gain: &Gain, left: Rgb) {
        if is_black(left) {
            return;
        }
        let weighted = gain.weighted * left;
        self.show(gain.from, gain.strategy, gain.light * left, weighted);
        match gain.strategy {
            (_, 1) => {
                if let Some(id) = gain.from {
                    self.context.shadow(id, true);
                }
                self.trail.radiance += weighted;
            }
            _ => self.trail.joined += weighted,
        }
    }

    /// s ≥ 2: every vertex of the light path, as far as the path does not become too long.
    fn connect(&mut self, vertex: Vertex<'_, 'a>, history: &History) {
        let from = vertex.reference_point();
        let left = self.bdpt.max_depth - self.trail.walk.depth;
        for end in self.light_path.vertices() {
            // Scattering events: those before the camera's vertex, and it; `end.depth` before the light's, and it. After one that is too deep
            // there may be others: see `Walk::cross_both_ways`.
            if end.depth + 1 > left.saturating_sub(1) {
                continue;
            }
            let to = end.vertex.reference_point();
            let distance2 = (to.p - from.p).length_squared();
            if distance2 == 0.0 {
                continue;
            }
            let shadow = from.shadow_ray_to(to.p, to.p_error, to.n);
            let w = (to.p - from.p) / distance2.sqrt();
            if vertex.ends_toward(w) {
                continue;
            }
            let Some(here) = vertex.radiance(w) else {
                continue;
            };
            let Some(there) = end.importance(-w) else {
                continue;
            };
            // The cosine at either vertex is in its value: `importance` has the geometric one toward the camera's vertex.
            let joined =
                self.trail.walk.throughput * here.value * there.value * end.throughput / distance2;
            if is_black(joined) {
                continue;
            }
            let (cosine, other) = (vertex.cosine(w), end.vertex.cosine(w));
            let onto =
                |pdf: f32, cosine: f32| f64::from(pdf) * f64::from(cosine) / f64::from(distance2);
            let camera = history.earlier(onto(there.forward, cosine), here.reverse.into());
            let light = end
                .history
                .earlier(onto(here.forward, other), there.reverse.into());
            let share = self.bdpt.connections;
            let gain = Gain {
                path: 0,
                from: self.light_path.light(),
                strategy: (self.trail.walk.depth + end.depth + 2, end.depth + 2),
                medium: vertex.medium_toward(self.context.world, w),
                light: joined / share,
                weighted: joined * (weight_of_joint(light, camera, share) / share),
            };
            self.trace_shadow(&shadow, gain);
        }
    }
}
