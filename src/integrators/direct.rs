//! Direct light at a surface from one given light, whole or in pieces: one sample of the light and one of the BSDF,
//! combined by the power heuristic (Veach 1997, §9.2; Pharr, Jakob and Humphreys 2016, §14.3.1).

use super::Context;
use super::vertex::receiver;
use crate::accel::EmitterHit;
use crate::bsdf::Bsdf;
use crate::lights::LightGroup;
use crate::math::sampling::power_heuristic;
use crate::math::{Rgb, color::is_black};
use crate::surface::SurfaceHit;

/// One estimate of the light that `group` sends to `surface` and on toward its `wo`.
/// Perfectly specular lobes are ignored.
pub(super) fn estimate(
    context: &mut Context,
    surface: &SurfaceHit,
    bsdf: &Bsdf,
    group: &LightGroup,
) -> Rgb {
    let (world, stream) = (context.world, &mut *context.stream);
    let numbers = stream.next_choice(group.chooses());
    let piece = group.piece(numbers.choice);
    let (id, probability) = (piece.light, piece.pmf);
    let light_u = numbers.point(probability, piece.rest);
    let third = stream.next_1d_if(bsdf.needs_third());
    let direction_u = stream.next_2d();
    let light = world.light(id);
    let from = receiver(surface, bsdf);
    let mut sum = Rgb::ZERO;
    if let Some(sample) = light.sample(&from, light_u) {
        let (f, pdf) = bsdf.f_and_pdf(surface.wo, sample.wi);
        let cosine = sample.wi.dot(bsdf.shading_normal()).abs();
        let contribution = f * sample.radiance * cosine;
        if !is_black(contribution) && context.is_lit(id, &sample.shadow) {
            let weight = if sample.delta {
                1.0
            } else {
                power_heuristic(probability * sample.pdf, pdf)
            };
            sum += contribution * (weight / (probability * sample.pdf));
        }
    }
    if light.is_delta() {
        return sum;
    }
    let Some(sample) = bsdf
        .sample(surface.wo, third, direction_u)
        .filter(|s| !s.specular)
    else {
        return sum;
    };
    let ray = surface.spawn_ray(sample.wi);
    let (radiance, light_pdf) = match world.intersect_emitter(&ray) {
        EmitterHit::Emitter(hit) => match hit.light.map(|met| (world.light(met), group.pmf(met))) {
            Some((met, probability)) if probability > 0.0 => (
                met.emitted(&hit.surface),
                probability * met.pdf(&from, ray.d, Some(&hit.surface)),
            ),
            _ => return sum,
        },
        EmitterHit::Escaped if light.is_infinite() => light.escaped_and_pdf(&from, ray.d),
        _ => return sum,
    };
    if light_pdf > 0.0 {
        let cosine = sample.wi.dot(bsdf.shading_normal()).abs();
        let weight = power_heuristic(sample.pdf, light_pdf);
        sum += sample.f * radiance * (cosine * weight / sample.pdf);
    }
    sum
}
