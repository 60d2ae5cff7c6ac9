//! Paths from the lights, which leave photons where they arrive.

use super::photon_map::Photon;
use super::{PhotonMapper, has_gone};
use crate::accel::GeometryHit;
use crate::bsdf::Bsdf;
use crate::integrators::MAX_NULL_SURFACES;
use crate::integrators::bdpt::{Carries, Turn};
use crate::integrators::subsurface::find_exit;
use crate::math::color::luminance;
use crate::math::ray::Ray;
use crate::math::{Rgb, Vec2};
use crate::samplers::SampleStream;

impl PhotonMapper<'_> {
    /// Traces a path from a light and adds its photons to `photons`. Dimensions are used in the order light and time; position and
    /// direction on the light; then those of each surface. `time`: the time at a fraction of the shutter's interval.
    pub fn trace(
        &self,
        time: impl FnOnce(f32) -> f32,
        stream: &mut SampleStream,
        photons: &mut Vec<Photon>,
    ) {
        let choice = stream.next_1d();
        let time = time(stream.next_1d());
        let (at, toward) = (stream.next_2d(), stream.next_2d());
        if let Some((ray, flux)) = self.begin(choice, time, at, toward) {
            self.follow(ray, flux, stream, photons);
        }
    }

    /// A ray from a light and the flux that it carries.
    fn begin(&self, choice: f32, time: f32, at: Vec2, toward: Vec2) -> Option<(Ray, Rgb)> {
        let emitters = self.lights.emitters.as_ref()?;
        let (id, pmf, _) = emitters.choice.sample(choice)?;
        let emission = self.world.light(id).emit(&emitters.scene, at, toward)?;
        let flux = emission.flux() / pmf;
        (!has_gone(flux)).then(|| (emission.ray(time), flux))
    }

    /// Follows light from surface to surface. What arrives at the first is direct light, for which lights are sampled; what
    /// arrives at perfectly specular surfaces is seen through no disc.
    fn follow(
        &self,
        mut ray: Ray,
        mut flux: Rgb,
        stream: &mut SampleStream,
        photons: &mut Vec<Photon>,
    ) -> Option<()> {
        let (mut depth, mut null_surfaces) = (0, 0);
        while depth < self.sppm.max_depth && null_surfaces < MAX_NULL_SURFACES {
            let hit = self.world.intersect(&ray)?;
            let Some(material) = self.world.material(hit.material) else {
                null_surfaces += 1;
                ray = hit.surface.spawn_ray(ray.d);
                continue;
            };
            let mut bsdf = Bsdf::empty();
            self.world
                .fill_bsdf(material, &hit.surface, None, &mut bsdf);
            let is_seen = bsdf.has_non_specular() || material.has_interior();
            if depth > 0 && is_seen && hit.surface.p.is_finite() {
                photons.push(Photon::new(hit.surface.p, hit.surface.wo, flux));
            }
            depth += 1;
            if depth == self.sppm.max_depth {
                return None;
            }
            let (factor, next) = self.scatter(&hit, &bsdf, stream)?;
            let scattered = flux * factor;
            // Roulette by what is left: photons of about equal flux are worth most.
            let survival = (luminance(scattered) / luminance(flux)).min(1.0);
            if stream.next_1d() >= survival {
                return None;
            }
            flux = scattered / survival;
            if has_gone(flux) {
                return None;
            }
            ray = next;
        }
        None
    }

    /// What a surface does to the flux, and the ray on which it continues. Subsurface scattering is the same both ways, so
    /// that its factors are those of a path from the camera.
    fn scatter(
        &self,
        hit: &GeometryHit,
        bsdf: &Bsdf,
        stream: &mut SampleStream,
    ) -> Option<(Rgb, Ray)> {
        let turn = Turn::sample(hit, bsdf, Carries::Importance, stream)?;
        let (sample, surface) = (&turn.sample, &hit.surface);
        let ray = || surface.spawn_ray(sample.wi);
        if !sample.transmission {
            return Some((turn.factor, ray()));
        }
        let (world, choice) = (self.world, || stream.next_1d());
        let transport =
            world.subsurface_transport(hit.material, surface, (bsdf, sample), None, choice);
        let Some(bssrdf) = transport.bssrdf else {
            return Some((turn.factor * transport.share, ray()));
        };
        let exit = find_exit(world, stream, &bssrdf, hit)?;
        let cosine = bsdf.shading_normal().dot(sample.wi).abs();
        let entered = sample.f * (cosine / sample.pdf) * transport.share * exit.weight;
        let left = Turn::sample(&exit.hit, &exit.bsdf, Carries::Radiance, stream)?;
        let ray = exit.hit.surface.spawn_ray(left.sample.wi);
        Some((entered * left.factor, ray))
    }
}
