//! `Integrator "bdpt"`: bidirectional path tracing (Veach and Guibas 1994; Lafortune and Willems 1993; Veach 1997, chapter
//! 10; Pharr, Jakob and Humphreys 2016, §16.3).
//!
//! Light is transported along paths that are made in every way at once: s vertices from a light and t from the camera. Each way is
//! good at other paths; all are summed with the weights of multiple importance sampling ([`weights`]).
//!
//! | s | t | | file |
//! |---|---|---|---|
//! | 0 | ≥ 2 | a camera path meets a light | [`camera_path`] |
//! | 1 | ≥ 2 | emitter sampling | [`joins`] |
//! | ≥ 2 | ≥ 2 | a camera path is joined to a light path | [`joins`], [`light_path`] |
//! | ≥ 2 | 1 | a light path is joined to the lens: the light pass | [`splat`] |
//!
//! The last row is what no path tracer has: the caustics of lights without area. Its paths are shared by all pixels; an image is the sum of
//! both parts, each unbiased by itself. Where every camera path is joined to a light path, that is one of the light pass, and is traced once for
//! both ([`Paired`](super::Paired)). Which of these ways are taken, and how often, is what pays in a pilot pass; an image that camera paths find at less cost alone is left to [`Path`].
//!
//! Many paths of either kind go side by side ([`camera_wave`], [`light_wave`]): their rays are traced together, vertices on flat matte triangles are
//! kept as rows of numbers ([`flats`]), and smooth boundaries have no BSDF's memory. What a path brings does not depend on the others.
//!
//! Subsurface scattering is found by camera paths, but for light that comes to a smooth boundary from a light without area by smooth
//! glass or mirrors, which light paths alone find.

mod camera_path;
mod camera_wave;
mod flats;
mod joins;
mod kept;
mod light_end;
mod light_path;
mod light_wave;
mod splat;
mod strategies;
mod vertex;
mod walk;
mod weights;

use super::context::{Bundle, Context, Lights, WAVE};
use super::{Beginning, LightJob, Path, Splat, Transport, Workspace};
use crate::lights::SelectionStrategy;
use crate::math::Rgb;
use crate::params::ParamReader;
use crate::samplers::SampleStream;
use crate::world::World;
use arrayvec::ArrayVec;
use camera_path::{CameraPath, Trail};
use kept::LightPaths;
use light_path::{LightTracer, LightVertex};

pub(super) use camera_wave::WaveBuffers;
pub(super) use kept::SpareVertices;
pub use strategies::Shown;
pub(super) use walk::{Carries, Turn};

/// Parameters of `Integrator "bdpt"`.
#[derive(Clone, Debug, PartialEq)]
pub struct Bdpt {
    /// `maxdepth` (5): largest number of scattering events; 0 shows only emitters.
    pub max_depth: u32,
    /// `lightsamplestrategy` ("spatial"): how emitter sampling chooses a light; noise only.
    pub light_strategy: SelectionStrategy,
    /// The share of camera paths that are joined to a light path (s ≥ 2 and t ≥ 2): what pays is found by a pilot pass. 0 only where
    /// all light is found by camera paths alone, too.
    pub connections: f32,
    /// Images of strategies, if they are wanted.
    pub shown: Option<Shown>,
}

impl Bdpt {
    /// Reads the parameters.
    pub fn from_params(reader: &ParamReader) -> Bdpt {
        let bdpt = Bdpt::from(Path::with_depth_and_strategy(reader));
        let mut max_depth = bdpt.max_depth;
        let shown = Shown::from_params(reader, &mut max_depth);
        Bdpt {
            max_depth,
            shown,
            ..bdpt
        }
    }

    /// What the images of strategies are called; none if they are not wanted.
    pub fn strategies(&self) -> Vec<String> {
        let names = self.shown.map(|_| strategies::names(self.max_depth));
        names.unwrap_or_default()
    }
}

impl From<Path> for Bdpt {
    /// Of the same depth, with the same choice of lights; all else is the path tracer's alone.
    fn from(path: Path) -> Bdpt {
        Bdpt {
            max_depth: path.max_depth,
            light_strategy: path.light_strategy,
            connections: 1.0,
            shown: None,
        }
    }
}

impl Bdpt {
    /// A path tracer that is helped by the light pass, without joints.
    pub(super) fn assisting(path: Path) -> Bdpt {
        Bdpt {
            connections: 0.0,
            ..Bdpt::from(path)
        }
    }

    /// Returns `true` if a camera path, whose first number decides, is joined to a light path.
    fn joins(&self, stream: &mut SampleStream) -> bool {
        let share = self.connections;
        share >= 1.0 || (share > 0.0 && stream.next_1d() < share)
    }

    /// Radiance along the camera ray: that of camera paths, and of those that are joined to a light path if this one `joins`.
    fn parts(&self, mut context: Context, joins: bool) -> [Rgb; 2] {
        let paired = context.end.paired;
        let tracer = self.joinable(context.world, context.lights, paired.is_some());
        let room = (usize::from(joins), tracer.max_depth);
        let mut light_paths = LightPaths::in_spare(&mut context.workspace.vertices, room);
        if joins {
            let camera = context.end.camera;
            let (start, mut stream) = kept::start((context.world, context.end), context.stream, 0);
            tracer.trace(start.time, &mut stream, |light, vertex, stream| {
                if self.joins_vertex(&vertex) {
                    light_paths.push(0, light, &vertex);
                }
                if paired.is_some() {
                    splat::skip_lens(camera, stream);
                }
            });
        }
        let mut trail = Trail::default();
        trail.begin(&context);
        let mut path = CameraPath {
            bdpt: self,
            differentials: context.differentials,
            context: &mut context,
            trail: &mut trail,
            light_path: light_paths.path(0),
            waiting: None,
        };
        while path.extend().or_else(|| path.turn_back()).is_some() {}
        let parts = [trail.radiance, trail.joined];
        light_paths.give_back(&mut context.workspace.vertices);
        parts
    }

    /// What light paths are traced through that camera paths are joined to, which may be of the light pass, too.
    fn joinable<'c, 'a>(
        &'c self,
        world: &'a World,
        lights: &'c Lights,
        are_paired: bool,
    ) -> LightTracer<'c, 'a> {
        // The camera's vertex takes one of the scattering events.
        let taken = u32::from(!are_paired);
        self.tracer(world, lights, self.max_depth.saturating_sub(taken))
    }

    fn tracer<'c, 'a>(
        &'c self,
        world: &'a World,
        lights: &'c Lights,
        max_depth: u32,
    ) -> LightTracer<'c, 'a> {
        LightTracer {
            bdpt: self,
            world,
            lights,
            max_depth,
        }
    }

    /// Returns `true` if a camera path may be joined to the vertex, as far as the number of scattering events goes.
    fn joins_vertex(&self, vertex: &LightVertex) -> bool {
        vertex.depth + 1 < self.max_depth
    }
}

impl Transport for Bdpt {
    const MEDIA: bool = true;
    const INDIRECT: bool = true;
    const TRACES_LIGHT: bool = true;
    const IN_WAVES: bool = true;

    fn radiance(&self, context: Context) -> Rgb {
        let joins = self.joins(context.stream);
        let [radiance, joined] = self.parts(context, joins);
        radiance + joined
    }

    fn radiances(&self, bundle: Bundle, out: &mut ArrayVec<Rgb, WAVE>) {
        camera_wave::radiances(self, bundle, out);
    }

    fn radiance_in_parts(&self, context: Context) -> [Rgb; 2] {
        self.parts(context, true)
    }

    fn light_paths(
        &self,
        job: &LightJob,
        lights: &Lights,
        paths: impl Iterator<Item = (u64, SampleStream)>,
        workspace: &mut Workspace,
        splat: &mut impl FnMut(Splat),
    ) {
        let tracer = self.tracer(job.world, lights, self.max_depth);
        let buffers = workspace.buffers.get_or_insert_default();
        splat::splat_paths(&tracer, job, paths, &mut buffers.flats, splat);
    }

    fn beginning(
        &self,
        job: &LightJob,
        lights: &Lights,
        stream: SampleStream,
    ) -> Option<Beginning> {
        let tracer = self.tracer(job.world, lights, self.max_depth);
        let (_, mut stream) = splat::start((job.world, job.camera), (0, 0), stream);
        tracer.beginning(&mut stream)
    }

    fn path(&self) -> Option<Path> {
        Some(Path {
            max_depth: self.max_depth,
            light_strategy: self.light_strategy,
            ..Path::default()
        })
    }
}

#[cfg(test)]
mod tests;
