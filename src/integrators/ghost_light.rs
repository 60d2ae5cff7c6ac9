//! The light of ghosts: from an emitter or the sky straight to the camera's lens, and there by two reflections to the film.
//!
//! Each sample begins at a point of the lens' first surface, for which a light is chosen and a direction to it, as at any surface that is
//! lit; the camera finds where on the film that lands (`cameras::realistic::ghosts`). Lights without area, those with one and the sky are all found so, and
//! nothing else finds the same. Light that surfaces of the scene reflect to the lens makes no ghosts.

use super::landing::{for_pixels, reaches_film};
use super::volpath::transmittance;
use super::{Integrator, LightJob, Splat};
use crate::lights::{LightSelector, Selected, SelectionStrategy};
use crate::math::ray::Ray;
use crate::math::{Rgb, color::is_black};
use crate::samplers::SampleStream;
use crate::world::World;

/// What ghosts are lit by.
#[derive(Debug)]
pub struct GhostLight {
    selector: LightSelector,
    sees_media: bool,
}

impl GhostLight {
    /// Of all lights of the world; `None` where the integrator's image is not of light, or is made of photons, for which there is no light pass.
    pub fn new(integrator: &Integrator, world: &World) -> Option<GhostLight> {
        let (_, radius) = world.geometry.bounds().bounding_sphere();
        let lights = world.sampled_lights();
        let spec = &integrator.spec;
        spec.has_light_pass().then(|| GhostLight {
            selector: LightSelector::new(lights, SelectionStrategy::default(), radius),
            sees_media: spec.sees_media(),
        })
    }

    /// Takes sample number `path` and hands over what it brings to pixels. Values hold the filter's factor; their sum over many, over their
    /// number, is to be added to the mean radiance of a pixel's camera rays.
    pub fn splat(
        &self,
        job: &LightJob,
        path: u64,
        stream: &mut SampleStream,
        splat: &mut impl FnMut(Splat),
    ) {
        let time = job.camera.shutter().time(stream.next_1d());
        let wavelength = stream.next_1d_if(job.camera.disperses());
        // No ghost where there is no light, or none of it gets to the film.
        let _ = self.bring(job, path, (time, wavelength), stream, splat);
    }

    fn bring(
        &self,
        job: &LightJob,
        path: u64,
        (time, wavelength): (f32, f32),
        stream: &mut SampleStream,
        splat: &mut impl FnMut(Splat),
    ) -> Option<()> {
        let entry = job.camera.ghost_entry(time, wavelength, stream.next_2d())?;
        let numbers = stream.next_choice(true);
        let Selected { light, pmf, rest } = self.selector.sample(&entry.point, numbers.choice)?;
        let emitter = job.world.sampled_lights().get(light.index())?;
        let sample = emitter.sample(&entry.point, numbers.point(pmf, rest))?;
        let landing = job.camera.ghost(&entry, sample.wi, stream.next_1d())?;
        let brought = sample.radiance * landing.importance / (pmf * sample.pdf);
        if is_black(brought) || !reaches_film(job, landing.raster) {
            return None;
        }
        let left = self.left(job.world, stream, &entry.clipped(&sample.shadow)?);
        if is_black(left) {
            return None;
        }
        for_pixels(job, landing.raster, |pixel, value, _| {
            splat(Splat {
                path,
                light,
                pixel,
                value: brought * left * value,
                shown: None,
                by_camera: 0.0,
            });
        });
        Some(())
    }

    /// The share of light that comes to the lens along the `shadow` ray.
    fn left(&self, world: &World, stream: &mut SampleStream, shadow: &Ray) -> Rgb {
        if self.sees_media {
            return transmittance(world, stream, shadow, world.media.camera);
        }
        match world.occluded(shadow) {
            true => Rgb::ZERO,
            false => Rgb::ONE,
        }
    }
}
