//! Compiles textures and loads their images.

use crate::budget::Budget;
use crate::math::transform::Transform;
use crate::scene::Frame;
use crate::syntax::{Diagnostic, Diagnostics};
use crate::textures::{TextureProblem, TextureUsage, Textures};

/// Creates all textures of a frame. An image that cannot be read is an error at its name; if nothing in the image uses
/// the texture, only a warning.
pub fn load(
    frame: &Frame,
    render_from_world: &Transform,
    diagnostics: &Diagnostics,
    budget: &Budget,
) -> Textures {
    let (textures, problems) = Textures::compile(
        &frame.float_textures,
        &frame.spectrum_textures,
        &usage(frame),
        render_from_world,
        budget,
    );
    for problem in problems {
        diagnostics.push(match problem {
            TextureProblem::ImageData {
                error,
                span,
                used: false,
            }
            | TextureProblem::Ptex {
                error,
                span,
                used: false,
            } => Diagnostic::warning(error.to_string())
                .at(span)
                .label("no shape uses this texture"),
            TextureProblem::ImageData {
                ref error, span, ..
            }
            | TextureProblem::Ptex {
                ref error, span, ..
            } => Diagnostic::error(error.to_string()).at(span).recoverable(),
            _ => Diagnostic::error(problem.to_string()),
        });
    }
    textures
}

/// The textures that shapes look up, directly or through their materials. Objects count whether or not they have an
/// instance.
fn usage(frame: &Frame) -> TextureUsage {
    let (floats, spectra) = (&frame.float_textures, &frame.spectrum_textures);
    let mut usage = TextureUsage::new(floats.len(), spectra.len());
    let mut seen = vec![false; frame.materials.len()];
    let objects = frame.objects.iter().flat_map(|object| &object.shapes);
    for shape in frame.shapes.iter().chain(objects) {
        for alpha in [shape.spec.alpha, shape.spec.shadow_alpha] {
            alpha.into_iter().for_each(|input| usage.float(input));
        }
        if let Some(id) = shape.material.map(|material| material.index())
            && let Some(material) = frame.materials.get(id)
            && !std::mem::replace(&mut seen[id], true)
        {
            material.add_usage(&frame.materials, &mut usage);
        }
    }
    usage.complete(floats, spectra);
    usage
}
