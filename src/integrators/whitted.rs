//! `Integrator "whitted"`: one sample of every light at each hit, perfect mirrors and glass
//! (Whitted 1980; Pharr, Jakob and Humphreys 2016, §1.3).

use super::specular;
use super::witness::Witness;
use crate::lights::LightGroups;
use crate::math::ray::{Ray, RayDifferentials};
use crate::math::{Rgb, color::is_black};
use crate::params::ParamReader;
use crate::samplers::SampleStream;
use crate::world::World;

/// Parameters of `Integrator "whitted"`.
#[derive(Clone, Debug, PartialEq)]
pub struct Whitted {
    /// `maxdepth` (5): recursion levels; at most one fewer mirror bounces.
    pub max_depth: u32,
}

impl Whitted {
    /// Reads the parameters.
    pub fn from_params(reader: &ParamReader) -> Whitted {
        Whitted {
            max_depth: super::max_depth(reader),
        }
    }

    /// Radiance along a camera ray.
    pub fn radiance(
        &self,
        world: &World,
        lights: &LightGroups,
        ray: Ray,
        differentials: Option<&RayDifferentials>,
        stream: &mut SampleStream,
        witness: &mut impl Witness,
    ) -> Rgb {
        specular::trace(
            world,
            self.max_depth,
            ray,
            differentials,
            stream,
            witness,
            |hit, bsdf, stream| {
                if !bsdf.has_non_specular() {
                    return Rgb::ZERO;
                }
                let surface = &hit.surface;
                let from = surface.reference_point();
                lights
                    .iter()
                    .map(|group| {
                        let (id, probability) = group.piece(stream.next_1d_if(group.chooses()));
                        let u = stream.next_2d();
                        let Some(sample) = world.light(id).sample(&from, u) else {
                            return Rgb::ZERO;
                        };
                        let cosine = sample.wi.dot(bsdf.shading_normal()).abs();
                        let weight = cosine / (probability * sample.pdf);
                        let contribution = bsdf.f(surface.wo, sample.wi) * sample.radiance * weight;
                        if is_black(contribution) || world.occluded(&sample.shadow) {
                            Rgb::ZERO
                        } else {
                            contribution
                        }
                    })
                    .sum()
            },
        )
    }
}
