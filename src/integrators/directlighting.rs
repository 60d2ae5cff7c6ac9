//! `Integrator "directlighting"`: emission, direct light and perfect mirrors and glass
//! (Pharr, Jakob and Humphreys 2016, §14.3).

use super::witness::Witness;
use super::{direct, specular};
use crate::lights::LightGroups;
use crate::math::Rgb;
use crate::math::ray::{Ray, RayDifferentials};
use crate::params::ParamReader;
use crate::samplers::SampleStream;
use crate::world::World;

/// Which lights are sampled at each hit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Strategy {
    /// Every light, as often as its `samples` says.
    All,
    /// One light, chosen at random.
    One,
}

/// Parameters of `Integrator "directlighting"`.
#[derive(Clone, Debug, PartialEq)]
pub struct DirectLighting {
    /// `maxdepth` (5): recursion levels; at most one fewer mirror bounces.
    pub max_depth: u32,
    /// `strategy` ("all").
    pub strategy: Strategy,
}

impl Default for DirectLighting {
    fn default() -> Self {
        DirectLighting {
            max_depth: 5,
            strategy: Strategy::All,
        }
    }
}

impl DirectLighting {
    /// Reads the parameters.
    pub fn from_params(reader: &ParamReader) -> DirectLighting {
        DirectLighting {
            max_depth: super::max_depth(reader),
            strategy: match reader.one_of("strategy", &["all", "one"]) {
                "one" => Strategy::One,
                _ => Strategy::All,
            },
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
                let choice = match self.strategy {
                    Strategy::One => stream.next_1d(),
                    Strategy::All => 0.0,
                };
                let mut estimate =
                    |group| direct::estimate(world, &hit.surface, bsdf, group, stream);
                match self.strategy {
                    Strategy::One => {
                        let Some((group, probability)) = lights.choose(choice) else {
                            return Rgb::ZERO;
                        };
                        estimate(group) / probability
                    }
                    Strategy::All => lights
                        .iter()
                        .map(|group| {
                            let samples = group.sample_count();
                            let sum: Rgb = (0..samples).map(|_| estimate(group)).sum();
                            sum / samples as f32
                        })
                        .sum(),
                }
            },
        )
    }
}
