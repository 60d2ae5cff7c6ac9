//! `Integrator "path"`: unidirectional path tracing with next-event estimation, multiple
//! importance sampling (Veach 1997, §9.2) and Russian roulette.
//!
//! The expectation is pbrt-v3's (scene-language 4.2). Where pbrt traces one ray for direct light
//! sampled by the BSDF and another to continue the path, one ray serves both here: the emission it
//! meets is weighted by the power heuristic against the light's own sampling.
//!
//! `volpath` is the same walk with participating media, see [`volpath`](super::volpath).

use super::MAX_NULL_SURFACES;
use super::subsurface::find_exit;
use super::vertex::{MediumVertex, SurfaceVertex, Vertex, receiver};
use super::volpath::transmittance;
use super::witness::{Met, Place, Witness};
use crate::accel::GeometryHit;
use crate::handles::LightId;
use crate::lights::{LightSelector, SelectionStrategy};
use crate::materials::beneath::Beneath;
use crate::math::ray::{Ray, RayDifferentials};
use crate::math::sampling::power_heuristic;
use crate::math::{Rgb, Vec2, color::is_black};
use crate::params::{Dialect, ParamReader};
use crate::samplers::SampleStream;
use crate::surface::ReferencePoint;
use crate::world::World;

/// The number of scattering events after which Russian roulette is played for all that a path is worth (pbrt-v3: bounce
/// counter > 3).
const ROULETTE_AFTER: u32 = 3;

/// Before, a path counts for so many times its worth: only those end that dark surfaces have left little of, as in foliage,
/// where their bounces cost two fifths of the time and bring no noise (docs/performance.md).
const EARLY_WORTH: f32 = 4.0;

/// Parameters of `Integrator "path"`.
#[derive(Clone, Debug, PartialEq)]
pub struct Path {
    /// `maxdepth` (5): largest number of scattering events; 0 shows only what emits.
    pub max_depth: u32,
    /// `rrthreshold` (1): roulette is played only where the throughput's largest channel is below.
    pub rr_threshold: f32,
    /// `lightsamplestrategy` ("spatial"): noise only.
    pub light_strategy: SelectionStrategy,
    /// For `sppm`: mirrors and glass between the camera and the first other surface are counted
    /// apart, as many as `max_depth` − 1 of them, because its photons end at that surface.
    pub mirrors_apart: bool,
}

impl Default for Path {
    fn default() -> Self {
        Path {
            max_depth: 5,
            rr_threshold: 1.0,
            light_strategy: SelectionStrategy::Spatial,
            mirrors_apart: false,
        }
    }
}

/// How the path came to its present vertex: decides what emission met there counts for.
#[derive(Clone, Copy)]
enum Arrival {
    /// From the camera or by a mirror: no light sampling competes.
    Direct,
    /// Scattered with this density at this point: weigh against light sampling, of every light there or of one.
    Scattered {
        from: ReferencePoint,
        pdf: f32,
        every: bool,
    },
    /// Scattered and then passed a surface without material, which blocks shadow rays:
    /// as in pbrt-v3 the light behind it is not seen (scene-language 4.3).
    Veiled,
}

impl Path {
    /// Reads the parameters; v2 counts one scattering event more (scene-language A.3).
    pub fn from_params(reader: &ParamReader) -> Path {
        let extra = u32::from(reader.dialect() == Dialect::V2);
        Path {
            max_depth: super::max_depth(reader) + extra,
            rr_threshold: reader.float("rrthreshold", 1.0) as f32,
            light_strategy: match reader
                .choice("lightsamplestrategy", &["spatial", "power", "uniform"])
            {
                "power" => SelectionStrategy::Power,
                "uniform" => SelectionStrategy::Uniform,
                _ => SelectionStrategy::Spatial,
            },
            mirrors_apart: false,
        }
    }

    /// Radiance along a camera ray. `MEDIA`: as `volpath`, which sees participating media and lets
    /// light through surfaces without material; a constant, so that `path` pays nothing for it.
    pub fn radiance<const MEDIA: bool>(
        &self,
        world: &World,
        selector: &LightSelector,
        mut ray: Ray,
        differentials: Option<&RayDifferentials>,
        stream: &mut SampleStream,
        witness: &mut impl Witness,
    ) -> Rgb {
        let mut radiance = Rgb::ZERO;
        let mut throughput = Rgb::ONE;
        // Undoes the radiance scaling inside dielectrics when roulette judges a path's worth.
        let mut eta_scale = 1.0;
        let mut differentials = differentials;
        let mut arrival = Arrival::Direct;
        let mut depth = 0;
        let mut max_depth = self.max_depth;
        let mut apart = self.mirrors_apart;
        let mut nulls = 0;
        let mut medium = if MEDIA { world.media.camera } else { None };
        loop {
            let hit = world.intersect(&ray);
            if MEDIA && let Some(id) = medium {
                let t_max = hit.as_ref().map_or(f32::INFINITY, |hit| hit.t);
                let flight = world
                    .media
                    .medium(id)
                    .sample(&ray, t_max, throughput, stream);
                throughput *= flight.weight;
                if is_black(throughput) {
                    return radiance;
                }
                if let Some(t) = flight.scattered {
                    let vertex = MediumVertex::new(world, id, &ray, t);
                    let met = Met::Medium;
                    witness.arrive(Place { depth, met }, radiance);
                    if depth >= max_depth || !vertex.p.is_finite() {
                        return radiance;
                    }
                    let light;
                    (light, ray, arrival) = scattered_in_medium(world, selector, &vertex, stream);
                    radiance += throughput * light;
                    differentials = None;
                    if !self.survives(depth, eta_scale, &mut throughput, stream) {
                        return radiance;
                    }
                    depth += 1;
                    continue;
                }
            }
            let Some(mut hit) = hit else {
                let met = Met::Background;
                witness.arrive(Place { depth, met }, radiance);
                return radiance + throughput * escaped(world, selector, &ray, &arrival);
            };
            let met = Met::Surface(hit.material);
            witness.arrive(Place { depth, met }, radiance);
            radiance += throughput * emitted(world, selector, &ray, &hit, &arrival);
            if depth >= max_depth {
                return radiance;
            }
            let surface = &hit.surface;
            let Some(material) = world.material(hit.material) else {
                nulls += 1;
                if nulls > MAX_NULL_SURFACES {
                    return radiance;
                }
                if MEDIA {
                    medium = world.medium_beyond(&hit, ray.d, medium);
                } else if let Arrival::Scattered { .. } = arrival {
                    arrival = Arrival::Veiled;
                }
                ray = surface.spawn_ray(ray.d);
                differentials = None;
                continue;
            };
            let mut bsdf = world.bsdf(material, surface, differentials);
            let (choice, light_u) = (stream.next_1d(), stream.next_2d());
            // What the camera sees is lit by every light where there are a few: shadows are most of its noise.
            let every = if depth == 0 { selector.few() } else { None };
            if bsdf.has_non_specular() {
                let vertex = SurfaceVertex {
                    hit: &hit,
                    bsdf: &bsdf,
                    medium,
                };
                let light = match every {
                    Some(count) => every_light::<MEDIA>(world, count, &vertex, light_u, stream),
                    None => {
                        sampled_light::<MEDIA>(world, selector, &vertex, choice, light_u, stream)
                    }
                };
                radiance += throughput * light;
            }
            let (lobe, direction_u) = (stream.next_1d(), stream.next_2d());
            let Some(mut sample) = bsdf.sample(surface.wo, lobe, direction_u) else {
                return radiance;
            };
            throughput *= sample.f * (sample.wi.dot(bsdf.shading_normal()).abs() / sample.pdf);
            if is_black(throughput) || !throughput.is_finite() {
                return radiance;
            }
            if sample.specular && sample.transmission {
                let entering = surface.wo.dot(surface.n) > 0.0;
                let eta2 = sample.eta * sample.eta;
                eta_scale *= if entering { eta2 } else { 1.0 / eta2 };
            }
            let beneath = if sample.transmission {
                let (scattered, choice) = ((&bsdf, &sample), || stream.next_1d());
                world.beneath(hit.material, surface, scattered, differentials, choice)
            } else {
                Beneath::STRAIGHT_ON
            };
            throughput *= beneath.share;
            let mut every = every.is_some();
            if let Some(bssrdf) = beneath.bssrdf {
                if !sample.specular {
                    let arrival = Arrival::Scattered {
                        from: receiver(surface, &bsdf),
                        pdf: sample.pdf,
                        every,
                    };
                    let ray = surface.spawn_ray(sample.wi);
                    radiance += throughput * straight_on(world, selector, &ray, &arrival);
                }
                every = false;
                let Some(exit) = find_exit(world, &bssrdf, &hit, stream) else {
                    return radiance;
                };
                throughput *= exit.weight;
                (hit, bsdf) = (exit.hit, exit.bsdf);
                let (choice, light_u) = (stream.next_1d(), stream.next_2d());
                let vertex = SurfaceVertex {
                    hit: &hit,
                    bsdf: &bsdf,
                    medium,
                };
                let light =
                    sampled_light::<MEDIA>(world, selector, &vertex, choice, light_u, stream);
                radiance += throughput * light;
                let (lobe, direction_u) = (stream.next_1d(), stream.next_2d());
                let Some(outside) = bsdf.sample(hit.surface.wo, lobe, direction_u) else {
                    return radiance;
                };
                sample = outside;
                throughput *= sample.f * (sample.wi.dot(bsdf.shading_normal()).abs() / sample.pdf);
                if is_black(throughput) || !throughput.is_finite() {
                    return radiance;
                }
            }
            differentials = None;
            apart &= sample.specular;
            if apart {
                if depth + 1 >= self.max_depth {
                    return radiance;
                }
                max_depth += 1;
            }
            arrival = if sample.specular {
                Arrival::Direct
            } else {
                Arrival::Scattered {
                    from: receiver(&hit.surface, &bsdf),
                    pdf: sample.pdf,
                    every,
                }
            };
            ray = hit.surface.spawn_ray(sample.wi);
            if MEDIA {
                medium = world.medium_beyond(&hit, sample.wi, medium);
            }
            if !self.survives(depth, eta_scale, &mut throughput, stream) {
                return radiance;
            }
            depth += 1;
        }
    }

    /// Russian roulette: ends paths that are worth little, and weighs the others up.
    fn survives(
        &self,
        depth: u32,
        eta_scale: f32,
        throughput: &mut Rgb,
        stream: &mut SampleStream,
    ) -> bool {
        let early = if depth <= ROULETTE_AFTER {
            EARLY_WORTH
        } else {
            1.0
        };
        let worth = early * (*throughput * eta_scale).max_element();
        if worth >= self.rr_threshold {
            return true;
        }
        let stop = (1.0 - worth).max(0.05);
        *throughput /= 1.0 - stop;
        stream.next_1d() >= stop
    }
}

/// Lights that a sampled direction meets at once, although the path goes on elsewhere: what light
/// sampling at a rough boundary is weighed against, as in pbrt-v3.
fn straight_on(world: &World, selector: &LightSelector, ray: &Ray, arrival: &Arrival) -> Rgb {
    match world.intersect(ray) {
        Some(hit) => emitted(world, selector, ray, &hit, arrival),
        None => escaped(world, selector, ray, arrival),
    }
}

/// Direct light by a sample of each of `count` lights, the first one by `u`.
fn every_light<const MEDIA: bool>(
    world: &World,
    count: u32,
    vertex: &impl Vertex,
    mut u: Vec2,
    stream: &mut SampleStream,
) -> Rgb {
    let mut sum = Rgb::ZERO;
    for id in 0..count {
        if id > 0 {
            u = stream.next_2d();
        }
        sum += light_from::<MEDIA>(world, (LightId(id), 1.0), vertex, u, stream);
    }
    sum
}

/// Direct light by sampling one light, weighted against meeting it by the scattered ray.
fn sampled_light<const MEDIA: bool>(
    world: &World,
    selector: &LightSelector,
    vertex: &impl Vertex,
    choice: f32,
    u: Vec2,
    stream: &mut SampleStream,
) -> Rgb {
    match selector.sample(&vertex.reference_point(), choice) {
        Some(chosen) => light_from::<MEDIA>(world, chosen, vertex, u, stream),
        None => Rgb::ZERO,
    }
}

/// Direct light by sampling the light that was chosen with a probability, weighted against meeting it by the scattered ray.
fn light_from<const MEDIA: bool>(
    world: &World,
    (id, probability): (LightId, f32),
    vertex: &impl Vertex,
    u: Vec2,
    stream: &mut SampleStream,
) -> Rgb {
    let from = vertex.reference_point();
    let Some(light) = world.light(id).sample(&from, u) else {
        return Rgb::ZERO;
    };
    let mut contribution = vertex.scattered(light.wi) * light.radiance;
    if is_black(contribution) {
        return Rgb::ZERO;
    }
    if MEDIA {
        let medium = vertex.medium_toward(world, light.wi);
        contribution *= transmittance(world, &light.shadow, medium, stream);
        if is_black(contribution) {
            return Rgb::ZERO;
        }
    } else if world.occluded(&light.shadow) {
        return Rgb::ZERO;
    }
    let pdf = probability * light.pdf;
    let weight = if light.delta {
        1.0
    } else {
        power_heuristic(pdf, vertex.pdf(light.wi))
    };
    contribution * (weight / pdf)
}

/// Direct light at a point of a medium, the ray that goes on from there, and how it does.
fn scattered_in_medium(
    world: &World,
    selector: &LightSelector,
    vertex: &MediumVertex,
    stream: &mut SampleStream,
) -> (Rgb, Ray, Arrival) {
    let (choice, light_u) = (stream.next_1d(), stream.next_2d());
    let light = sampled_light::<true>(world, selector, vertex, choice, light_u, stream);
    let (wi, pdf) = vertex.phase.sample(vertex.wo, stream.next_2d());
    let from = vertex.reference_point();
    let ray = Ray::new(vertex.p, wi, from.time);
    let every = false;
    (light, ray, Arrival::Scattered { from, pdf, every })
}

/// Emission of the surface hit, weighted by how the path arrived.
fn emitted(
    world: &World,
    selector: &LightSelector,
    ray: &Ray,
    hit: &GeometryHit,
    arrival: &Arrival,
) -> Rgb {
    let Some(id) = hit.light else {
        return Rgb::ZERO;
    };
    let light = world.light(id);
    let radiance = light.emitted(&hit.surface);
    if is_black(radiance) {
        return Rgb::ZERO;
    }
    match arrival {
        Arrival::Direct => radiance,
        Arrival::Veiled => Rgb::ZERO,
        Arrival::Scattered { from, pdf, every } => {
            let probability = chance(selector, from, id, *every);
            let light_pdf = probability * light.pdf(from, ray.d, Some(&hit.surface));
            // A light that is never chosen (an instanced emitter) glows but lights nothing, as in pbrt-v3.
            if light_pdf > 0.0 {
                radiance * power_heuristic(*pdf, light_pdf)
            } else {
                Rgb::ZERO
            }
        }
    }
}

/// With which probability light from `id` was sought at `from`, where `every` light was sampled or one was chosen.
fn chance(selector: &LightSelector, from: &ReferencePoint, id: LightId, every: bool) -> f32 {
    if !every {
        return selector.pmf(from, id);
    }
    let sampled = selector.few().is_some_and(|count| id.0 < count);
    f32::from(u8::from(sampled))
}

/// Light from beyond the scene, weighted by how the path arrived.
fn escaped(world: &World, selector: &LightSelector, ray: &Ray, arrival: &Arrival) -> Rgb {
    match arrival {
        Arrival::Direct => world.escaped_radiance(ray),
        Arrival::Veiled => Rgb::ZERO,
        Arrival::Scattered { from, pdf, every } => world
            .infinite_lights
            .iter()
            .map(|&id| {
                let (radiance, light_pdf) = world.light(id).escaped_and_pdf(from, ray.d);
                let probability = chance(selector, from, id, *every);
                radiance * power_heuristic(*pdf, probability * light_pdf)
            })
            .sum(),
    }
}
