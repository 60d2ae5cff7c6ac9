//! `Integrator "whitted"`: one sample of every light at each hit, perfect mirrors and glass
//! (Whitted 1980; Pharr, Jakob and Humphreys 2016, §1.3).

use super::{Context, Path, Transport, specular};
use crate::bsdf::Bsdf;
use crate::lights::LightGroup;
use crate::math::{Rgb, color::is_black};
use crate::params::ParamReader;
use crate::surface::SurfaceHit;

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
}

impl Transport for Whitted {
    const FOLLOWS_DIFFERENTIALS: bool = true;

    fn radiance(&self, context: Context) -> Rgb {
        specular::trace(context, self.max_depth, sample_lights)
    }

    fn path(&self) -> Option<Path> {
        Some(Path::direct_only(self.max_depth))
    }
}

/// Direct light by one sample of every light.
fn sample_lights(context: &mut Context, surface: &SurfaceHit, bsdf: &Bsdf) -> Rgb {
    let (world, lights) = (context.world, context.lights);
    let from = surface.reference_point();
    let sample_group = |group: &LightGroup| {
        let numbers = context.stream.next_choice(group.chooses());
        let piece = group.piece(numbers.choice);
        let (id, probability) = (piece.light, piece.pmf);
        let u = numbers.point(probability, piece.rest);
        let Some(sample) = world.light(id).sample(&from, u) else {
            return Rgb::ZERO;
        };
        let cosine = sample.wi.dot(bsdf.shading_normal()).abs();
        let weight = cosine / (probability * sample.pdf);
        let contribution = bsdf.f(surface.wo, sample.wi) * sample.radiance * weight;
        if is_black(contribution) || !context.is_lit(id, &sample.shadow) {
            Rgb::ZERO
        } else {
            context.part(Some(id), contribution);
            contribution
        }
    };
    lights.groups.iter().map(sample_group).sum()
}
