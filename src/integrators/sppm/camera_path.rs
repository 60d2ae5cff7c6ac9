//! Paths from the camera: through mirrors, glass and narrow highlights to a surface that scatters widely, where photons are
//! gathered.

use super::disc::Disc;
use super::photon_map::PhotonMap;
use super::{PhotonMapper, has_gone};
use crate::accel::{EmitterHit, GeometryHit};
use crate::bsdf::Bsdf;
use crate::handles::LightId;
use crate::integrators::MAX_NULL_SURFACES;
use crate::integrators::subsurface::find_exit;
use crate::integrators::vertex::receiver;
use crate::integrators::witness::{Met, Place, Watch};
use crate::math::color::{is_black, luminance};
use crate::math::ray::{Ray, RayDifferentials};
use crate::math::sampling::power_heuristic;
use crate::math::{DVec3, Rgb};
use crate::samplers::SampleStream;
use crate::surface::ReferencePoint;
use std::f64::consts::PI;

/// Throughput below which Russian roulette applies.
const FAINT: f32 = 0.25;

/// The photons of an iteration and the disc of the pixel that gathers them.
pub struct Gather<'a> {
    /// The photons.
    pub map: &'a PhotonMap,
    /// Number of light paths that have left them.
    pub paths: f64,
    /// Changed once the path has ended.
    pub disc: &'a mut Disc,
}

/// A path from the camera while it is traced. Methods return `None` where it ends.
pub(super) struct CameraPath<'c, 'a> {
    pub mapper: PhotonMapper<'a>,
    pub stream: &'c mut SampleStream,
    pub watch: Option<&'c mut Watch>,
    /// To the next vertex.
    pub ray: Ray,
    /// Those of the camera ray, up to its hit.
    pub differentials: Option<&'c RayDifferentials>,
    pub throughput: Rgb,
    /// Light collected so far.
    pub radiance: Rgb,
    /// The last vertex was the camera or a perfectly specular surface, for which lights are not sampled.
    pub after_delta: bool,
    /// Scattering events so far.
    pub depth: u32,
    pub null_surfaces: u32,
    /// Photons found.
    pub found: u64,
}

impl CameraPath<'_, '_> {
    /// The path's light, and the disc's next radius.
    pub(super) fn trace(mut self, gather: &mut Gather) -> Rgb {
        while self.depth < self.mapper.sppm.max_depth && self.extend(gather).is_some() {}
        gather.disc.shrink(self.found);
        self.radiance
    }

    /// Extends the path by a vertex.
    fn extend(&mut self, gather: &Gather) -> Option<()> {
        let world = self.mapper.world;
        let Some(hit) = world.intersect(&self.ray) else {
            self.arrive(Met::Background);
            if self.after_delta {
                self.radiance += self.throughput * world.escaped_radiance(&self.ray);
            }
            return None;
        };
        self.arrive(Met::Surface(hit.material));
        if self.after_delta {
            self.radiance += self.throughput * world.emitted_radiance(&hit);
        }
        let differentials = self.differentials.take();
        let Some(material) = world.material(hit.material) else {
            self.null_surfaces += 1;
            self.ray = hit.surface.spawn_ray(self.ray.d);
            return (self.null_surfaces < MAX_NULL_SURFACES).then_some(());
        };
        let mut bsdf = Bsdf::empty();
        world.fill_bsdf(material, &hit.surface, differentials, &mut bsdf);
        let is_last = self.depth + 1 == self.mapper.sppm.max_depth;
        let gathers = bsdf.has_diffuse() || (is_last && bsdf.has_non_specular());
        self.add_light(&hit, &bsdf, gather, gathers);
        if gathers && !bsdf.has_specular() {
            return None;
        }
        self.depth += 1;
        self.scatter(&hit, &bsdf, differentials, (gathers, gather))
    }

    /// Adds direct light, unless all lobes are perfectly specular, and that of photons.
    fn add_light(&mut self, hit: &GeometryHit, bsdf: &Bsdf, gather: &Gather, gathers: bool) {
        if bsdf.has_non_specular() {
            let light = self.direct_light(hit, bsdf);
            self.radiance += self.throughput * light;
        }
        if gathers {
            let light = self.gathered(hit, bsdf, gather);
            self.radiance += self.throughput * light;
        }
    }

    /// Continues from a surface: where photons have been gathered, which represent all else, by perfectly specular lobes alone.
    /// Where light comes from below a surface, it is gathered around the point where it entered.
    fn scatter(
        &mut self,
        hit: &GeometryHit,
        bsdf: &Bsdf,
        differentials: Option<&RayDifferentials>,
        (gathered, gather): (bool, &Gather),
    ) -> Option<()> {
        let third = self.stream.next_1d_if(bsdf.needs_third());
        let sample = bsdf.sample(hit.surface.wo, third, self.stream.next_2d())?;
        if gathered && !sample.specular {
            return None;
        }
        let cosine = bsdf.shading_normal().dot(sample.wi).abs();
        self.throughput *= sample.f * (cosine / sample.pdf);
        if sample.transmission {
            let (world, choice) = (self.mapper.world, || self.stream.next_1d());
            let scattered = (bsdf, &sample);
            let surface = &hit.surface;
            let transport =
                world.subsurface_transport(hit.material, surface, scattered, differentials, choice);
            self.throughput *= transport.share;
            if let Some(bssrdf) = transport.bssrdf {
                let exit = find_exit(world, self.stream, &bssrdf, hit)?;
                self.throughput *= exit.weight;
                self.add_light(&exit.hit, &exit.bsdf, gather, true);
                return None;
            }
        }
        let survival = luminance(self.throughput);
        if survival < FAINT {
            if self.stream.next_1d() >= survival {
                return None;
            }
            self.throughput /= survival;
        }
        self.after_delta = sample.specular;
        self.ray = hit.surface.spawn_ray(sample.wi);
        (!has_gone(self.throughput)).then_some(())
    }

    /// The light of photons that is scattered along the path: their flux over the area of the disc. Under interpolated normals
    /// light counts as if it came at its angle to them, as where lights are sampled.
    fn gathered(&mut self, hit: &GeometryHit, bsdf: &Bsdf, gather: &Gather) -> Rgb {
        let (surface, shading) = (&hit.surface, bsdf.shading_normal());
        let (mut sum, mut found) = (DVec3::ZERO, 0);
        let radius = gather.disc.radius();
        gather.map.visit(surface.p, radius as f32, |photon| {
            found += 1;
            let (shading, real) = (shading.dot(photon.wi), surface.n.dot(photon.wi));
            if real != 0.0 {
                let f = bsdf.f(surface.wo, photon.wi);
                sum += (f * photon.flux * (shading / real).abs()).as_dvec3();
            }
        });
        self.found += found;
        (sum / (PI * radius * radius * gather.paths)).as_vec3()
    }

    /// Light from the sources that is scattered along the path: one sample of a light and one of the BSDF, combined by the
    /// power heuristic (Veach 1997, §9.2).
    fn direct_light(&mut self, hit: &GeometryHit, bsdf: &Bsdf) -> Rgb {
        let from = receiver(&hit.surface, bsdf);
        let mut light = self.sampled_light(hit, bsdf, &from);
        if self.mapper.finds_lights {
            light += self.met_light(hit, bsdf, &from);
        }
        light
    }

    /// The sample of a light.
    fn sampled_light(&mut self, hit: &GeometryHit, bsdf: &Bsdf, from: &ReferencePoint) -> Rgb {
        let (world, selector) = (self.mapper.world, &self.mapper.lights.selector);
        let numbers = self.stream.next_choice(selector.chooses());
        let sample = { selector.sample(from, numbers.choice) }.and_then(|selected| {
            let u = numbers.point(selected.pmf, selected.rest);
            let light = world.light(selected.light).sample(from, u)?;
            Some((light, selected.pmf))
        });
        let Some((light, pmf)) = sample else {
            return Rgb::ZERO;
        };
        let (f, pdf) = bsdf.f_and_pdf(hit.surface.wo, light.wi);
        let contribution = f * light.radiance * bsdf.shading_normal().dot(light.wi).abs();
        if is_black(contribution) || world.occluded(&light.shadow) {
            return Rgb::ZERO;
        }
        let own = pmf * light.pdf;
        let weight = if light.delta {
            1.0
        } else {
            power_heuristic(own, pdf)
        };
        contribution * (weight / own)
    }

    /// The sample of the BSDF.
    fn met_light(&mut self, hit: &GeometryHit, bsdf: &Bsdf, from: &ReferencePoint) -> Rgb {
        let third = self.stream.next_1d_if(bsdf.needs_third());
        let sample = bsdf.sample(hit.surface.wo, third, self.stream.next_2d());
        let Some(sample) = sample.filter(|sample| !sample.specular) else {
            return Rgb::ZERO;
        };
        let (world, selector) = (self.mapper.world, &self.mapper.lights.selector);
        let weighted = |id: LightId, radiance: Rgb, pdf: f32| match selector.pmf(from, id) * pdf {
            // A light that is never chosen (an instanced emitter) lights nothing.
            0.0 => Rgb::ZERO,
            other => radiance * power_heuristic(sample.pdf, other),
        };
        let ray = hit.surface.spawn_ray(sample.wi);
        let light = match world.intersect_emitter(&ray) {
            EmitterHit::Escaped => { world.infinite_lights.iter() }
                .map(|&id| {
                    let (radiance, pdf) = world.light(id).escaped_and_pdf(from, ray.d);
                    weighted(id, radiance, pdf)
                })
                .sum(),
            EmitterHit::Emitter(hit) => hit.light.map_or(Rgb::ZERO, |id| {
                let (light, met) = (world.light(id), &hit.surface);
                weighted(id, light.emitted(met), light.pdf(from, ray.d, Some(met)))
            }),
            EmitterHit::NotEmissive => Rgb::ZERO,
        };
        let cosine = bsdf.shading_normal().dot(sample.wi).abs();
        light * sample.f * (cosine / sample.pdf)
    }

    /// Reports the vertex just reached, for the search for samples that are not finite.
    fn arrive(&mut self, met: Met) {
        if let Some(watch) = &mut self.watch {
            let depth = self.depth;
            watch.arrive(Place { depth, met }, self.radiance);
        }
    }
}
