//! From description to world: meshes and pictures are loaded, shapes placed, trees built.
//!
//! The world is built in *render space*: world space moved so that the camera is at the origin.
//! A rounding error of f32 then is 6e-8 of the distance from the camera, the same angle on the
//! film for everything in the picture, however far from the world's origin the scene was modelled.

mod geometry;
mod lights;

use crate::cameras::{Camera, FilmGeometry};
use crate::film::FilmMetadata;
use crate::integrators::Integrator;
use crate::math::transform::Transform;
use crate::math::{DMat4, DVec3};
use crate::render::Shot;
use crate::samplers::Sampler;
use crate::scene::Frame;
use crate::scene::options::Options;
use crate::syntax::{Diagnostic, Diagnostics};
use crate::textures::Textures;
use crate::world::World;

/// A frame ready to be rendered.
#[derive(Debug)]
pub struct Built {
    /// World, camera, integrator and the rest.
    pub shot: Shot,
    /// What the output file says of itself; scene name and seed are the caller's.
    pub metadata: FilmMetadata,
    /// What a photographer wants to know, one fact a line.
    pub description: Vec<String>,
}

/// Builds a frame. Files that cannot be loaded are reported; `None` where there is no camera.
pub fn build(frame: Frame, seed: u64, diagnostics: &Diagnostics) -> Option<Built> {
    let Frame { options, float_textures, spectrum_textures, materials, shapes, objects, instances, lights, area_lights } =
        frame;
    let render_from_world = render_from_world(&options.camera_from_world);
    let film = FilmGeometry { resolution: options.film.resolution, diagonal_mm: options.film.diagonal_mm };
    let render_from_camera = render_from_world * options.camera_from_world.inverted();
    let camera = match Camera::new(&options.camera, &film, &render_from_camera) {
        Ok(camera) => camera,
        Err(error) => {
            diagnostics.push(Diagnostic::error(error.to_string()));
            return None;
        }
    };
    let (textures, problems) = Textures::compile(float_textures, spectrum_textures, &render_from_world);
    for problem in problems {
        diagnostics.push(Diagnostic::error(problem.to_string()));
    }
    let mut lights = lights::place(&lights, &render_from_world, diagnostics);
    let geometry =
        geometry::build(shapes, objects, &instances, &area_lights, &render_from_world, &mut lights, diagnostics)?;
    let world = World::new(geometry, materials, textures, lights);
    let mut description = options.camera.describe(&film);
    description.extend(options.camera.warnings(&film).into_iter().map(|w| format!("warning: {w}")));
    let metadata = metadata(&options, &film);
    let integrator = Integrator::new(&options.integrator.spec, &world);
    let sampler = Sampler::new(&options.sampler, seed);
    let sampled = sampled_bounds(&options);
    let Options { film, filter, .. } = options;
    let shot = Shot { world, camera, integrator, sampler, filter, film, sampled };
    Some(Built { shot, metadata, description })
}

/// World to render space: minus the camera's position.
fn render_from_world(camera_from_world: &Transform) -> Transform {
    let eye = camera_from_world.inverted().point(DVec3::ZERO);
    Transform::translate(if eye.is_finite() { -eye } else { DVec3::ZERO })
}
