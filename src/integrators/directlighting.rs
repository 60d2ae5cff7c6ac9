//! `Integrator "directlighting"`: emission, direct light and perfect mirrors and glass
//! (Pharr, Jakob and Humphreys 2016, §14.3).

use super::{Context, Path, Transport, direct, specular};
use crate::bsdf::Bsdf;
use crate::lights::LightGroup;
use crate::math::Rgb;
use crate::params::ParamReader;
use crate::surface::SurfaceHit;

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
}

impl Transport for DirectLighting {
    const FOLLOWS_DIFFERENTIALS: bool = true;

    fn radiance(&self, context: Context) -> Rgb {
        let sample_lights = match self.strategy {
            Strategy::All => sample_all_lights,
            Strategy::One => sample_one_light,
        };
        specular::trace(context, self.max_depth, sample_lights)
    }

    fn path(&self) -> Option<Path> {
        Some(Path::direct_only(self.max_depth))
    }
}

fn sample_all_lights(context: &mut Context, surface: &SurfaceHit, bsdf: &Bsdf) -> Rgb {
    let groups = &context.lights.groups;
    let mean = |group: &LightGroup| {
        let samples = group.sample_count();
        let sum: Rgb = (0..samples)
            .map(|_| direct::estimate(context, surface, bsdf, group))
            .sum();
        let mean = sum / samples as f32;
        context.part(Some(group.first()), mean);
        mean
    };
    groups.iter().map(mean).sum()
}

fn sample_one_light(context: &mut Context, surface: &SurfaceHit, bsdf: &Bsdf) -> Rgb {
    let choice = context.stream.next_1d();
    match context.lights.groups.choose(choice) {
        Some((group, probability)) => {
            let light = direct::estimate(context, surface, bsdf, group) / probability;
            context.part(Some(group.first()), light);
            light
        }
        None => Rgb::ZERO,
    }
}
