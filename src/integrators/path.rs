//! `Integrator "path"`: unidirectional path tracing with next-event estimation, multiple
//! importance sampling (Veach 1997, §9.2) and Russian roulette.
//!
//! The expectation is pbrt-v3's (scene-language 4.2). Where pbrt traces one ray for direct light
//! sampled by the BSDF and another to continue the path, one ray serves both here: the emission it
//! meets is weighted by the power heuristic against the light's own sampling.

use super::MAX_NULL_SURFACES;
use super::subsurface::find_exit;
use crate::accel::GeometryHit;
use crate::bsdf::{Bsdf, BsdfSample};
use crate::lights::{LightSelector, SelectionStrategy};
use crate::math::ray::{Ray, RayDifferentials};
use crate::math::sampling::power_heuristic;
use crate::math::{Rgb, color::is_black};
use crate::params::{Dialect, ParamReader};
use crate::samplers::SampleStream;
use crate::surface::{ReferencePoint, SurfaceHit};
use crate::world::World;

/// The number of scattering events after which Russian roulette starts (pbrt-v3: bounce counter > 3).
const ROULETTE_AFTER: u32 = 3;

/// Parameters of `Integrator "path"`.
#[derive(Clone, Debug, PartialEq)]
pub struct Path {
    /// `maxdepth` (5): largest number of scattering events; 0 shows only what emits.
    pub max_depth: u32,
    /// `rrthreshold` (1): roulette is played only where the throughput's largest channel is below.
    pub rr_threshold: f32,
    /// `lightsamplestrategy` ("spatial"): noise only.
    pub light_strategy: SelectionStrategy,
}

impl Default for Path {
    fn default() -> Self {
        Path {
            max_depth: 5,
            rr_threshold: 1.0,
            light_strategy: SelectionStrategy::Spatial,
        }
    }
}

/// How the path came to its present vertex: decides what emission met there counts for.
#[derive(Clone, Copy)]
enum Arrival {
    /// From the camera or by a mirror: no light sampling competes.
    Direct,
    /// Scattered with this density at this point: weigh against light sampling.
    Scattered { from: ReferencePoint, pdf: f32 },
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
        }
    }

    /// Radiance along a camera ray.
    pub fn radiance(
        &self,
        world: &World,
        selector: &LightSelector,
        mut ray: Ray,
        differentials: Option<&RayDifferentials>,
        stream: &mut SampleStream,
    ) -> Rgb {
        let mut radiance = Rgb::ZERO;
        let mut throughput = Rgb::ONE;
        // Undoes the radiance scaling inside dielectrics when roulette judges a path's worth.
        let mut eta_scale = 1.0;
        let mut differentials = differentials;
        let mut arrival = Arrival::Direct;
        let mut depth = 0;
        let mut nulls = 0;
        loop {
            let Some(mut hit) = world.intersect(&ray) else {
                return radiance + throughput * escaped(world, selector, &ray, &arrival);
            };
            radiance += throughput * emitted(world, selector, &ray, &hit, &arrival);
            if depth >= self.max_depth {
                return radiance;
            }
            let surface = &hit.surface;
            let Some(mut bsdf) = world.bsdf(hit.material, surface, differentials) else {
                nulls += 1;
                if nulls > MAX_NULL_SURFACES {
                    return radiance;
                }
                if let Arrival::Scattered { .. } = arrival {
                    arrival = Arrival::Veiled;
                }
                ray = surface.spawn_ray(ray.d);
                differentials = None;
                continue;
            };
            let (choice, light_u) = (stream.next_1d(), stream.next_2d());
            if bsdf.has_non_specular() {
                radiance +=
                    throughput * sampled_light(world, selector, surface, &bsdf, choice, light_u);
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
            if sample.transmission
                && let Some(bssrdf) = world.bssrdf(hit.material, surface, &bsdf, differentials)
            {
                if !sample.specular {
                    radiance += throughput * straight_on(world, selector, surface, &sample);
                }
                let Some(exit) = find_exit(world, &bssrdf, &hit, stream) else {
                    return radiance;
                };
                throughput *= exit.weight;
                (hit, bsdf) = (exit.hit, exit.bsdf);
                let surface = &hit.surface;
                let (choice, light_u) = (stream.next_1d(), stream.next_2d());
                radiance +=
                    throughput * sampled_light(world, selector, surface, &bsdf, choice, light_u);
                let (lobe, direction_u) = (stream.next_1d(), stream.next_2d());
                let Some(outside) = bsdf.sample(surface.wo, lobe, direction_u) else {
                    return radiance;
                };
                sample = outside;
                throughput *= sample.f * (sample.wi.dot(bsdf.shading_normal()).abs() / sample.pdf);
                if is_black(throughput) || !throughput.is_finite() {
                    return radiance;
                }
            }
            let surface = &hit.surface;
            differentials = None;
            arrival = if sample.specular {
                Arrival::Direct
            } else {
                Arrival::Scattered {
                    from: surface.reference_point(),
                    pdf: sample.pdf,
                }
            };
            ray = surface.spawn_ray(sample.wi);
            if depth > ROULETTE_AFTER {
                let worth = (throughput * eta_scale).max_element();
                if worth < self.rr_threshold {
                    let stop = (1.0 - worth).max(0.05);
                    if stream.next_1d() < stop {
                        return radiance;
                    }
                    throughput /= 1.0 - stop;
                }
            }
            depth += 1;
        }
    }
}

/// Lights that a sampled direction meets at once, although the path goes on elsewhere: what light
/// sampling at a rough boundary is weighed against, as in pbrt-v3.
fn straight_on(
    world: &World,
    selector: &LightSelector,
    surface: &SurfaceHit,
    sample: &BsdfSample,
) -> Rgb {
    let arrival = Arrival::Scattered {
        from: surface.reference_point(),
        pdf: sample.pdf,
    };
    let ray = surface.spawn_ray(sample.wi);
    match world.intersect(&ray) {
        Some(hit) => emitted(world, selector, &ray, &hit, &arrival),
        None => escaped(world, selector, &ray, &arrival),
    }
}

/// Direct light by sampling one light, weighted against meeting it by the BSDF.
fn sampled_light(
    world: &World,
    selector: &LightSelector,
    surface: &SurfaceHit,
    bsdf: &Bsdf,
    choice: f32,
    u: crate::math::Vec2,
) -> Rgb {
    let from = surface.reference_point();
    let Some((id, probability)) = selector.sample(&from, choice) else {
        return Rgb::ZERO;
    };
    let Some(light) = world.light(id).sample(&from, u) else {
        return Rgb::ZERO;
    };
    let f = bsdf.f(surface.wo, light.wi) * light.wi.dot(bsdf.shading_normal()).abs();
    let contribution = f * light.radiance;
    if is_black(contribution) || world.occluded(&light.shadow) {
        return Rgb::ZERO;
    }
    let pdf = probability * light.pdf;
    let weight = if light.delta {
        1.0
    } else {
        power_heuristic(pdf, bsdf.pdf(surface.wo, light.wi))
    };
    contribution * (weight / pdf)
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
        Arrival::Scattered { from, pdf } => {
            let light_pdf = selector.pmf(from, id) * light.pdf(from, ray.d, Some(&hit.surface));
            // A light that is never chosen (an instanced emitter) glows but lights nothing, as in pbrt-v3.
            if light_pdf > 0.0 {
                radiance * power_heuristic(*pdf, light_pdf)
            } else {
                Rgb::ZERO
            }
        }
    }
}

/// Light from beyond the scene, weighted by how the path arrived.
fn escaped(world: &World, selector: &LightSelector, ray: &Ray, arrival: &Arrival) -> Rgb {
    match arrival {
        Arrival::Direct => world.escaped_radiance(ray),
        Arrival::Veiled => Rgb::ZERO,
        Arrival::Scattered { from, pdf } => world
            .infinite_lights
            .iter()
            .map(|&id| {
                let light = world.light(id);
                let light_pdf = selector.pmf(from, id) * light.pdf(from, ray.d, None);
                light.escaped(ray.d) * power_heuristic(*pdf, light_pdf)
            })
            .sum(),
    }
}
