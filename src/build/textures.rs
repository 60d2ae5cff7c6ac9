//! Compiles textures and loads their images.

use crate::budget::Budget;
use crate::inputs::FloatInput;
use crate::math::transform::Transform;
use crate::scene::Frame;
use crate::syntax::{Diagnostic, Diagnostics};
use crate::textures::{TextureUsage, Textures};

/// Creates all textures of a frame. An image that cannot be read is an error at its name; if nothing in the image uses
/// the texture, only a warning.
pub(super) fn load(
    frame: &Frame,
    render_from_world: &Transform,
    diagnostics: &Diagnostics,
    budget: &Budget,
) -> Textures {
    let usage = usage(frame);
    let (textures, problems) =
        Textures::compile(&frame.textures, &usage, render_from_world, budget);
    for problem in problems {
        let message = problem.error.to_string();
        diagnostics.push(match problem.used {
            true if problem.is_usable => Diagnostic::warning(message).at(problem.span),
            true => Diagnostic::error(message)
                .at(problem.span)
                .recoverable()
                .failed_if(problem.error.is_failure),
            false => Diagnostic::warning(message)
                .at(problem.span)
                .label("no shape uses this texture"),
        });
    }
    textures
}

/// The textures that shapes look up, directly or through their materials. Objects count whether or not they have an
/// instance.
fn usage(frame: &Frame) -> TextureUsage {
    let mut usage = TextureUsage::new(&frame.textures);
    let mut seen = vec![false; frame.materials.len()];
    let objects = frame.objects.iter().flat_map(|object| &object.shapes);
    for shape in frame.shapes.iter().chain(objects) {
        for alpha in [shape.spec.alpha, shape.spec.shadow_alpha] {
            usage.add(alpha.and_then(FloatInput::texture));
        }
        if let Some(id) = shape.material.map(|material| material.index())
            && let Some(material) = frame.materials.get(id)
            && !std::mem::replace(&mut seen[id], true)
        {
            material.add_usage(&frame.materials, &mut usage);
        }
    }
    usage.complete(&frame.textures);
    usage
}
