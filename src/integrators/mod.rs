//! Light transport: from a camera ray to the radiance that arrives along it.
//!
//! One file per integrator, named as the scene file names it; `kinds` is their table. They share direct light at a
//! surface (`direct`) and the recursion over perfect mirrors and glass (`specular`).

mod ambientocclusion;
mod bdpt;
mod context;
mod counts;
mod differentials;
mod direct;
mod directlighting;
mod emitters;
mod first_surfaces;
mod ghost_light;
mod kinds;
mod landing;
mod parts;
mod path;
mod shadows;
mod specular;
mod sppm;
mod stand_in;
mod subsurface;
#[cfg(test)]
mod testing;
mod vertex;
mod vertices;
mod volpath;
mod whitted;
pub mod witness;

use crate::lights::{Light, LightGroups, LightSelector};
use crate::materials::Material;
use crate::math::Rgb;
use crate::math::ray::RayDifferentials;
use crate::params::ParamReader;
use crate::samplers::SampleStream;
use crate::syntax::Span;
use crate::world::{MAX_NULL_SURFACES, World};
use arrayvec::ArrayVec;
use context::{Bundle, Context, Lights};
use emitters::Emitters;
pub use emitters::{Beginning, Learned};
use kinds::Transport;
use path::Wave;
use witness::Watch;

pub use ambientocclusion::AmbientOcclusion;
pub use bdpt::{Bdpt, Shown};
pub use context::{CameraEnd, CameraPath, LightJob, Paired, Splat, WAVE, Workspace};
pub use counts::Counts;
pub use directlighting::DirectLighting;
pub use first_surfaces::{FirstSurfaces, Sight, first_surfaces};
pub use ghost_light::GhostLight;
pub use kinds::{IntegratorSpec, NAMES};
pub use parts::LightParts;
pub use path::{MediaSeen, Path};
pub use sppm::{Disc, Gather, Photon, PhotonMap, PhotonMapper, Sppm};
pub use stand_in::LightTracer;
pub use volpath::VolPath;
pub use whitted::Whitted;

/// Before so many scattering events paths take both ways at smooth glass (docs/notes/light-paths.md, "Smooth boundaries").
const BOTH_WAYS: u32 = 3;

/// Integrator and the pixels it is confined to.
#[derive(Clone, Debug, PartialEq)]
pub struct IntegratorSettings {
    /// Which one, with its parameters.
    pub spec: IntegratorSpec,
    /// `pixelbounds`: x0, x1, y0, y1; pixels outside are left black.
    pub pixel_bounds: Option<[i32; 4]>,
    /// Where the scene names it; `None` where it names none.
    pub place: Option<Span>,
    /// The scene's integrator, where that traces light from its sources and `spec` does not.
    pub light_tracer: Option<LightTracer>,
}

impl IntegratorSettings {
    /// Reads an `Integrator` or `SurfaceIntegrator` directive. Its place is the caller's to add.
    pub fn from_params(reader: &ParamReader) -> IntegratorSettings {
        IntegratorSettings {
            spec: IntegratorSpec::from_params(reader),
            pixel_bounds: pixel_bounds(reader),
            place: None,
            light_tracer: LightTracer::from_params(reader),
        }
    }
}

/// `pixelbounds`: four integers x0 x1 y0 y1.
fn pixel_bounds(reader: &ParamReader) -> Option<[i32; 4]> {
    let values = reader.integers("pixelbounds")?;
    let Ok(v) = <[f64; 4]>::try_from(values) else {
        reader.ignored(
            "pixelbounds",
            "`pixelbounds` takes four integers: x0 x1 y0 y1",
        );
        return None;
    };
    Some(v.map(|x| x as i32))
}

/// `maxdepth` as a count; negative values count as zero, with a warning.
fn max_depth(reader: &ParamReader) -> u32 {
    reader.integer_within("maxdepth", 5, 0..=i64::from(u32::MAX >> 1)) as u32
}

/// An integrator ready to run.
#[derive(Debug)]
pub struct Integrator {
    spec: IntegratorSpec,
    lights: Lights,
}

impl Integrator {
    /// Prepares the sampling of the world's lights.
    pub fn new(spec: &IntegratorSpec, world: &World) -> Integrator {
        let (_, radius) = world.geometry.bounds().bounding_sphere();
        let lights = world.sampled_lights();
        let (selected, grouped) = match spec.is_indirect() {
            true => (lights, &[][..]),
            false => (&[][..], lights),
        };
        let strategy = spec.path().map(|path| path.light_strategy);
        Integrator {
            spec: spec.clone(),
            lights: Lights {
                selector: LightSelector::new(selected, strategy.unwrap_or_default(), radius),
                groups: LightGroups::new(grouped),
                emitters: spec.begins_at_lights().then(|| Emitters::new(world)),
            },
        }
    }

    /// For a thread that walks paths in `world`.
    ///
    /// Never inlined: it is made on the stack, where the recursion that divides the tiles would keep room for it at each level.
    #[inline(never)]
    pub fn workspace(&self, world: &World) -> Workspace {
        let wave = match &self.spec {
            IntegratorSpec::Path(_) | IntegratorSpec::VolPath(_) => Some(Wave::new(world)),
            _ => None,
        };
        Workspace {
            wave,
            ..Workspace::default()
        }
    }

    /// Radiance along a camera's ray. Every vertex of the path is reported to `watch`.
    pub fn radiance(
        &self,
        world: &World,
        end: &CameraEnd,
        differentials: Option<&RayDifferentials>,
        stream: &mut SampleStream,
        workspace: &mut Workspace,
        watch: Option<&mut Watch>,
    ) -> Rgb {
        let context = self.context(world, end, differentials, stream, workspace);
        self.spec.radiance(Context { watch, ..context })
    }

    /// [`Integrator::radiance`] along each of these camera rays, at most [`WAVE`], which may be traced side by side.
    ///
    /// Light paths that are [paired](CameraEnd::paired) with them are joined to the lens as well if there is a `light_job`, and
    /// [room](Workspace::splats) for what they bring.
    pub fn radiances(
        &self,
        world: &World,
        paths: &mut [CameraPath],
        workspace: &mut Workspace,
        light_job: Option<&LightJob>,
    ) -> ArrayVec<Rgb, WAVE> {
        let mut radiances = ArrayVec::new();
        let bundle = Bundle {
            world,
            lights: &self.lights,
            paths,
            workspace,
            light_job,
        };
        self.spec.radiances(bundle, &mut radiances);
        radiances
    }

    /// [`Integrator::radiance`] in two parts: without and from connections to light paths, which are made for all camera paths
    /// although each is over the share of them that are joined in the image.
    pub fn radiance_in_parts(
        &self,
        world: &World,
        end: &CameraEnd,
        differentials: Option<&RayDifferentials>,
        stream: &mut SampleStream,
        workspace: &mut Workspace,
    ) -> [Rgb; 2] {
        let context = self.context(world, end, differentials, stream, workspace);
        self.spec.radiance_in_parts(context)
    }

    fn context<'a>(
        &'a self,
        world: &'a World,
        end: &'a CameraEnd<'a>,
        differentials: Option<&'a RayDifferentials>,
        stream: &'a mut SampleStream,
        workspace: &'a mut Workspace,
    ) -> Context<'a> {
        Context {
            world,
            lights: &self.lights,
            stream,
            differentials,
            end,
            workspace,
            watch: None,
        }
    }

    /// Returns `true` if paths from the lights may help the path tracer, which finds the same light without: through smooth glass
    /// and off mirrors its camera paths meet a small light rarely. Not in media, which `path` does not see.
    pub fn may_be_assisted(&self, world: &World) -> bool {
        let mut lights = world.sampled_lights().iter();
        let mut materials = world.materials.iter();
        self.spec.may_be_assisted()
            && !world.has_recoverable_surfaces()
            && !world.geometry.has_curves()
            && world.media.is_empty()
            && lights.any(|light| !light.is_delta())
            && materials.any(|material| material.may_focus())
    }

    /// What renders the image, as scenes name it: perhaps not what the scene asks for ([`Integrator::leave_to_camera_paths`]).
    pub fn name(&self) -> &'static str {
        self.spec.name()
    }

    /// Returns `true` if light may be scattered twice on its way to the camera. Of what is scattered once, emitter sampling
    /// finds all that light paths find.
    pub fn is_indirect(&self) -> bool {
        self.spec.max_depth().is_some_and(|depth| depth >= 2)
    }

    /// Returns `true` if camera paths may not find all light that light paths find, or rarely.
    pub fn needs_light_paths(&self, world: &World) -> bool {
        let focuses = world.materials.iter().any(Material::may_focus);
        self.is_indirect() && (focuses || !world.media.is_empty())
    }

    /// Lets paths from the lights help the path tracer: camera paths know that light paths are joined to the lens. They begin at
    /// lights that camera paths can meet: the light of others is what it is without. Returns how it was before.
    pub fn assist(&mut self, world: &World) -> IntegratorSpec {
        let assisted = match self.spec.path() {
            Some(path) => IntegratorSpec::Bdpt(Bdpt::assisting(path)),
            None => self.spec.clone(),
        };
        self.lights.emitters = Some(Emitters::of_lights_that_are_met(world));
        std::mem::replace(&mut self.spec, assisted)
    }

    /// Undoes [`Integrator::assist`].
    pub fn leave_alone(&mut self, before: IntegratorSpec) {
        self.spec = before;
        self.lights.emitters = None;
    }

    /// Returns `true` if the path tracer finds all light that `bdpt` does, and none of it so rarely that a pilot pass has to miss
    /// it: not in media, not what glass and mirrors gather that are smooth all over, nor that of lights without area gathered by anything. Its shadow rays end at
    /// surfaces without a material, or with a cut-out for them alone; and curves scatter other light for paths from elsewhere.
    pub fn camera_paths_find_all(&self, world: &World) -> bool {
        let mut materials = world.materials.iter();
        let lacks_area = world.sampled_lights().iter().any(Light::is_delta);
        let gathers = |material: &Material| match lacks_area {
            true => material.may_focus(),
            false => material.is_smooth(&world.materials),
        };
        (!self.is_indirect() || !materials.any(gathers))
            && world.media.is_empty()
            && !world.has_recoverable_surfaces()
            && !world.geometry.has_curves()
    }

    /// Renders by `path`, which walks many paths side by side, where [that finds all](Integrator::camera_paths_find_all).
    pub fn leave_to_camera_paths(&mut self) {
        if let (IntegratorSpec::Bdpt(_), Some(path)) = (&self.spec, self.spec.path()) {
            self.spec = IntegratorSpec::Path(path);
            self.lights.emitters = None;
        }
    }

    /// Returns `true` if all that every strategy finds by itself is shown.
    pub fn shows_all_strategies(&self) -> bool {
        matches!(&self.spec, IntegratorSpec::Bdpt(bdpt) if bdpt.shown == Some(Shown::Alone))
    }

    /// Returns `true` if it is shown what any strategy finds.
    pub fn shows_strategies(&self) -> bool {
        matches!(&self.spec, IntegratorSpec::Bdpt(bdpt) if bdpt.shown.is_some())
    }

    /// Joins a `share` of camera paths to light paths.
    pub fn join(&mut self, share: f32) {
        if let IntegratorSpec::Bdpt(bdpt) = &mut self.spec {
            bdpt.connections = share;
        }
    }

    /// Returns `true` if the image is of light, and light may be added to it that is traced otherwise.
    pub fn has_light_pass(&self) -> bool {
        self.spec.has_light_pass()
    }

    /// The share of camera paths that are joined to light paths.
    pub fn joined(&self) -> f32 {
        match &self.spec {
            IntegratorSpec::Bdpt(bdpt) => bdpt.connections,
            _ => 0.0,
        }
    }

    /// Returns `true` if paths are traced from the lights, too: [`Integrator::light_paths`].
    pub fn traces_light(&self) -> bool {
        self.spec.traces_light()
    }

    /// Returns `true` if paths begin at lights, whatever becomes of them.
    pub fn begins_at_lights(&self) -> bool {
        self.spec.begins_at_lights()
    }

    /// Where photons are gathered: what sends them and gathers them. Then [`Integrator::radiance`] is without their light.
    pub fn photons<'a>(&'a self, world: &'a World) -> Option<PhotonMapper<'a>> {
        match &self.spec {
            IntegratorSpec::Sppm(sppm) => Some(PhotonMapper::new(sppm, world, &self.lights)),
            _ => None,
        }
    }

    /// Traces paths from lights, each with its number, and hands over what they bring to pixels, in some order. Values hold the filter's factor; their sum over many paths, over their number, is to be added to the mean
    /// radiance of a pixel's camera rays.
    pub fn light_paths(
        &self,
        job: &LightJob,
        paths: impl Iterator<Item = (u64, SampleStream)>,
        workspace: &mut Workspace,
        splat: &mut impl FnMut(Splat),
    ) {
        let lights = &self.lights;
        self.spec.light_paths(job, lights, paths, workspace, splat);
    }

    /// Where the light path with these sample points begins.
    pub fn beginning(&self, job: &LightJob, stream: SampleStream) -> Option<Beginning> {
        self.spec.beginning(job, &self.lights, stream)
    }

    /// Aims so many light paths at what may gather light, before anything is learned.
    pub fn aim_emission(&mut self, world: &World, paths: u64) {
        if let Some(emitters) = &mut self.lights.emitters {
            emitters.aim(world, paths as usize);
        }
    }

    /// Begins light paths where they bring much, by what was `learned` from so many `paths`.
    pub fn guide_emission(&mut self, learned: &[Learned], paths: usize) {
        if let Some(emitters) = &mut self.lights.emitters {
            emitters.learn(learned, paths);
        }
    }
}
