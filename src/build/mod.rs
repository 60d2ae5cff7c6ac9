//! From scene description to world: loads meshes and images, places shapes, builds trees.
//!
//! The world is built in *render space*: world space translated so that the camera is at the origin. A rounding error
//! of f32 is then 6e-8 of the distance from the camera, the same angle on the film for everything in the image, however
//! far from the world's origin the scene was modeled.

mod autofocus;
mod geometry;
mod light_paths;
mod lights;
mod motion;
mod textures;

use crate::budget::Budget;
use crate::cameras::{Camera, CameraError, FilmGeometry};
use crate::film::{FilmMetadata, Layer, LightShare, OF_STATISTICS, PixelBounds};
use crate::filters::Filter;
use crate::integrators::{GhostLight, Integrator};
use crate::lights::Light;
use crate::materials::{self, BsdfFiles, Material};
use crate::math::transform::Transform;
use crate::math::{DVec3, UVec2};
use crate::media::Media;
use crate::render::{Mattes, RenderJob};
use crate::samplers::Sampler;
use crate::scene::Frame;
use crate::scene::options::Options;
use crate::syntax::{Diagnostic, Diagnostics};
use crate::textures::Textures;
use crate::world::World;
use geometry::Shapes;

/// A frame ready to be rendered.
pub struct PreparedScene {
    /// World, camera, integrator and film.
    pub job: RenderJob,
    /// Metadata of the output file; the caller adds scene name and seed.
    pub metadata: FilmMetadata,
    /// Facts of interest to a photographer, one per line.
    pub description: Vec<String>,
}

/// Builds a frame on the current rayon pool. Files that cannot be loaded are among the diagnostics returned; the scene
/// is `None` if there is no camera.
pub fn build(frame: Frame, seed: u64) -> (Option<PreparedScene>, Diagnostics) {
    let diagnostics = Diagnostics::new();
    let built = build_frame(frame, seed, &diagnostics);
    (built, diagnostics)
}

/// Reports every problem that building a frame would, without building trees: loads all images and meshes and discards
/// them.
pub fn check(frame: &Frame, diagnostics: &Diagnostics) {
    light_paths::note(frame, diagnostics);
    let budget = Budget::new(frame.options.max_memory);
    FrameAssets::new(frame, diagnostics, &budget);
    geometry::check(frame, diagnostics, &budget);
}

/// Everything in a frame that is built before its shapes.
struct FrameAssets {
    render_from_world: Transform,
    film: FilmGeometry,
    camera: Option<Camera>,
    textures: Textures,
    bsdf_files: BsdfFiles,
    lights: Vec<Light>,
}

impl FrameAssets {
    fn new(frame: &Frame, diagnostics: &Diagnostics, budget: &Budget) -> FrameAssets {
        let options = &frame.options;
        let pixels = options.film.pixel_bounds().area() as u64;
        let layers = options.film.layers;
        let mut bytes = { options.accumulation }.memory_of_pixel(frame.may_trace_light(), layers);
        if options.integrator.spec.gathers_photons() {
            // Its tiles, and the film that is made of them.
            bytes += 2 * OF_STATISTICS;
        }
        if let Err(error) = budget.take(pixels.saturating_mul(bytes)) {
            diagnostics.push(Diagnostic {
                span: options.film_at,
                ..Diagnostic::error(format!("the film {error}"))
            });
        }
        let integrator = &options.integrator;
        if let Err(error) = budget.take(integrator.spec.memory(pixels)) {
            diagnostics.push(Diagnostic {
                span: integrator.place,
                ..Diagnostic::error(format!("an iteration of this integrator {error}"))
            });
        }
        let sampled = sampled_bounds(options.film.pixel_bounds(), integrator.pixel_bounds);
        if sampled.area() == 0 {
            let message = "`pixelbounds` leaves no pixel of the image";
            diagnostics.push(Diagnostic {
                span: integrator.place,
                ..Diagnostic::error(message).recoverable()
            });
        }
        let camera_from_world = &options.camera_from_world;
        let render_from_world = render_from_world(&camera_from_world.start);
        let film = film_geometry(options);
        let camera = match camera(options) {
            // Already reported when the scene was read, with its location.
            _ if !camera_from_world.is_invertible() => None,
            Ok(camera) => Some(camera),
            Err(error) => {
                diagnostics.push(Diagnostic::error(error.to_string()));
                None
            }
        };
        if !options.integrator.spec.is_indirect()
            && frame.materials.iter().any(Material::has_interior)
        {
            diagnostics.push(Diagnostic::warning(
                "only path integrators scatter light inside `subsurface` and `kdsubsurface`: \
                 their boundary alone is seen",
            ));
        }
        light_paths::warn(frame, camera.as_ref(), diagnostics);
        for warning in camera.iter().flat_map(Camera::warnings) {
            diagnostics.push(Diagnostic::warning(warning));
        }
        FrameAssets {
            render_from_world,
            film,
            camera,
            textures: textures::load(frame, &render_from_world, diagnostics, budget),
            bsdf_files: BsdfFiles::load(&frame.materials, diagnostics),
            lights: lights::place(&frame.lights, &render_from_world, diagnostics, budget),
        }
    }
}

fn build_frame(frame: Frame, seed: u64, diagnostics: &Diagnostics) -> Option<PreparedScene> {
    let budget = Budget::new(frame.options.max_memory);
    let assets = FrameAssets::new(&frame, diagnostics, &budget);
    let Some(mut camera) = assets.camera else {
        geometry::check(&frame, diagnostics, &budget);
        return None;
    };
    let shutter = *camera.shutter();
    let shows_motion = { frame.options.film.layers }.contains(Layer::Motion);
    let motion_times = shows_motion.then(|| motion::times(&frame, &shutter));
    let (mut options, mut materials) = (frame.options, frame.materials);
    materials::prepare(&mut materials, &assets.bsdf_files);
    let shapes = Shapes {
        bare: bare(&options, &assets.textures, &materials),
        placed: frame.shapes,
        objects: frame.objects,
        instances: frame.instances,
        area_lights: frame.area_lights,
        light_media: frame.light_media,
        light_groups: shows_groups(&options).then_some(frame.light_groups),
        need_faces: assets.textures.need_faces(),
        many_rays: options.integrator.spec.goes_in_waves(),
    };
    let place = &assets.render_from_world;
    let placed = geometry::build(shapes, assets.lights, place, diagnostics, &budget)?;
    let mut world = World::new(
        placed.geometry,
        materials,
        assets.textures,
        placed.lights,
        placed.sampled_lights,
        Media::new(frame.media, placed.light_media, place),
    );
    world.light_layers = placed.light_layers;
    if let Some(problem) = autofocus::focus(&mut options, &mut camera, &world) {
        diagnostics.push(problem);
    }
    let bounds = options.film.pixel_bounds();
    let sampler = Sampler::new(&options.sampler, seed);
    let metadata = metadata(&options, &camera, &assets.film);
    let description = camera.describe(&assets.film);
    let moves = world.moves() || camera.moves();
    let mut job = RenderJob {
        integrator: Integrator::new(&options.integrator.spec, &world),
        world,
        camera,
        footprint_spp: sampler.spp(),
        sampler,
        filter: filter(&options),
        sampled: sampled_bounds(bounds, options.integrator.pixel_bounds),
        film: options.film,
        mattes: Mattes::default(),
        motion_times: motion_times.filter(|_| moves),
        world_from_render: place.inverted().point(DVec3::ZERO),
        light_share: LightShare(1.0),
        ghosts: None,
    };
    prepare_light_paths(&mut job);
    Some(PreparedScene {
        job,
        metadata,
        description,
    })
}

/// Of each material, whether nothing but the point is asked of its surfaces: no (u, v), and no derivatives.
fn bare(options: &Options, textures: &Textures, materials: &[Material]) -> Vec<bool> {
    // Ray differentials need them as well, where they are reflected or refracted.
    let follows = options.integrator.spec.follows_differentials()
        && (textures.needs_footprint() || materials.iter().any(Material::needs_footprint));
    let bare = materials.iter().map(|material| {
        !(material.needs_parameters(materials) || follows && material.is_smooth(materials))
    });
    bare.collect()
}

/// Returns `true` if layers of light are those of groups.
fn shows_groups(options: &Options) -> bool {
    options.film.layers.contains(Layer::Lights) && options.integrator.spec.strategies().is_empty()
}

/// Changes a job's options and seed, except for its film: the options are the frame's own, changed in ways that do not
/// affect its world. The camera keeps its position, and textures are filtered for as many samples as before.
pub fn reset(job: &mut RenderJob, options: &Options, seed: u64) -> Result<(), CameraError> {
    job.camera = camera(options)?;
    // What it says it has said.
    autofocus::focus(&mut options.clone(), &mut job.camera, &job.world);
    job.integrator = Integrator::new(&options.integrator.spec, &job.world);
    job.sampler = Sampler::new(&options.sampler, seed);
    job.filter = filter(options);
    prepare_light_paths(job);
    Ok(())
}

/// Makes what only paths from the lights and ghosts need, or who asks where on the film a point is seen.
fn prepare_light_paths(job: &mut RenderJob) {
    if job.integrator.begins_at_lights() {
        job.world.prepare_emission();
    }
    let (lit, radius) = (job.lit(), job.filter.radius());
    let window = [lit.min.as_vec2() - radius, lit.max.as_vec2() + radius];
    job.ghosts = None;
    if job.camera.has_ghosts() && job.filter.is_continuous() {
        job.camera.prepare_ghosts(window);
        job.ghosts = GhostLight::new(&job.integrator, &job.world);
    }
    job.light_share = LightShare(1.0);
    let assisted = job.may_be_assisted();
    let traces_light = assisted || job.traces_light();
    if job.motion_times.is_some() {
        let (size, radius) = (job.film.resolution.as_vec2(), 0.5);
        job.camera
            .prepare_motion([-radius * size, (1.0 + radius) * size]);
    }
    if !traces_light {
        return;
    }
    job.camera.prepare_connections(window);
    match assisted {
        true => job.consider_assistance(),
        false if traces_light => job.run_pilot_pass(),
        false => {}
    }
}

fn film_geometry(options: &Options) -> FilmGeometry {
    FilmGeometry {
        resolution: options.film.resolution,
        diagonal_mm: options.film.diagonal_mm,
    }
}

fn camera(options: &Options) -> Result<Camera, CameraError> {
    let world_from_camera = options.camera_from_world.inverted();
    let render_from_world = render_from_world(&options.camera_from_world.start);
    let render_from_camera = render_from_world * world_from_camera.start;
    let film = film_geometry(options);
    let mut camera = Camera::new(&options.camera, &film, &render_from_camera)?;
    if let Some(motion) = world_from_camera.motion() {
        camera.set_motion(motion.shifted(render_from_world.point(DVec3::ZERO)));
    }
    Ok(camera)
}

fn filter(options: &Options) -> Filter {
    match options.sampler.pixel_centers {
        true => options.filter.at_pixel_centers(),
        false => options.filter.clone(),
    }
}

/// World to render space: minus the camera's position.
fn render_from_world(camera_from_world: &Transform) -> Transform {
    let eye = camera_from_world.inverted().point(DVec3::ZERO);
    Transform::translate(if eye.is_finite() { -eye } else { DVec3::ZERO })
}

/// Metadata of the output file, except scene name and seed.
fn metadata(options: &Options, camera: &Camera, film: &FilmGeometry) -> FilmMetadata {
    let world_to_camera = options.camera_from_world.start.m;
    let ndc_from_camera = options.camera.ndc_from_camera(film);
    FilmMetadata {
        world_to_camera: Some(world_to_camera),
        // Beyond the range of numbers for an angle of view of nothing.
        world_to_ndc: { ndc_from_camera.map(|ndc| ndc * world_to_camera) }
            .filter(|ndc| ndc.is_finite()),
        pixel_aspect: options.camera.pixel_aspect(film),
        spp: options.sampler.spp,
        white_luminance: options.film.white_luminance,
        lens: options.camera.lens_name(),
        photograph: camera.photograph(film),
        software: concat!("fstop ", env!("CARGO_PKG_VERSION")).to_string(),
        ..FilmMetadata::default()
    }
}

/// The film's pixels within `pixelbounds` (x0, x1, y0, y1).
fn sampled_bounds(film: PixelBounds, pixel_bounds: Option<[i32; 4]>) -> PixelBounds {
    match pixel_bounds {
        None => film,
        Some(bounds) => {
            let [x0, x1, y0, y1] = bounds.map(|v| v.max(0) as u32);
            film.intersection(PixelBounds::new(UVec2::new(x0, y0), UVec2::new(x1, y1)))
        }
    }
}
