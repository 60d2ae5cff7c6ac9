//! Direct light of the commonest emitters, which are parallelograms and balls, on the commonest surfaces, computed side by side.
//!
//! Vertices are kept as rows of numbers, in a cache near the processor, and the functions that serve a single vertex are run in a loop
//! over them that has no branches: it is compiled to vector instructions. Bits are those of one at a time.

use super::emitter_sampling::weighted;
use crate::bsdf::{Scatterer, ScattererRows};
use crate::handles::LightId;
use crate::integrators::context::WAVE;
use crate::integrators::vertices::VertexRows;
use crate::lights::{Glow, Light};
use crate::math::color::is_black;
use crate::math::instruction_set::{Instructions, Kernel, WIDEST, vectorize};
use crate::math::ray::Ray;
use crate::math::rows::Rows3;
use crate::math::{Rgb, Vec2};
use crate::shapes::emitter::{BranchlessEmitter, Emitter};
use crate::surface::ReferencePoint;
use crate::world::World;

/// Light that a path gains if nothing blocks a shadow ray.
#[derive(Clone, Copy)]
pub(super) struct Gain {
    pub path: u32,
    /// Where it comes from.
    pub from: LightId,
    pub light: Rgb,
}

/// Vertices side by side.
const ROOM: usize = WAVE;

/// Of each light so many vertices must come together that it pays, so lights must be few.
const LIGHTS: usize = 4;

/// The vertices that wait for light.
pub(super) struct EmitterBatches<S: Scatterer> {
    /// By light; none where a light is not one of these.
    waiting: [Option<Box<Waiting<S>>>; LIGHTS],
    /// What has been found for those of one light.
    samples: Box<Samples>,
}

impl<S: Scatterer> EmitterBatches<S> {
    /// Those of the world.
    pub(super) fn new(world: &World) -> EmitterBatches<S> {
        let mut batches = EmitterBatches {
            waiting: Default::default(),
            samples: Box::default(),
        };
        let lights = world.sampled_lights();
        if lights.len() <= LIGHTS {
            for (waiting, light) in batches.waiting.iter_mut().zip(lights) {
                *waiting = is_branchless(light).then(Box::default);
            }
        }
        batches
    }

    /// Returns `true` if this light is one of them, as seen from here.
    #[inline(always)]
    pub(super) fn has(&self, world: &World, light: LightId, from: &ReferencePoint) -> bool {
        matches!(self.waiting.get(light.index()), Some(Some(_)))
            && match world.light(light).shape() {
                Some((Emitter::Sphere(ball), _)) => ball.is_far_from(from),
                _ => true,
            }
    }

    /// Keeps a sample for later, of a light that was chosen with probability `pmf`, at a point that `u` chooses: of a vertex of the path
    /// with this number. Returns `true` if the next one needs room: [`EmitterBatches::light`].
    #[inline]
    pub(super) fn keep(
        &mut self,
        (light, pmf): (LightId, f32),
        u: Vec2,
        vertex: (&ReferencePoint, &S),
        (path, throughput): (u32, Rgb),
    ) -> bool {
        let Some(Some(waiting)) = self.waiting.get_mut(light.index()) else {
            return false;
        };
        let i = waiting.count & (ROOM - 1);
        waiting.vertices.set(i, pmf, u, vertex, throughput);
        waiting.paths[i] = path;
        waiting.count = i + 1;
        waiting.count == ROOM
    }

    /// Computes all that waits: shadow rays, and what is gained where nothing blocks them.
    pub(super) fn light(&mut self, world: &World, mut add: impl FnMut(&Ray, Gain)) {
        let samples = &mut self.samples;
        for (waiting, light) in self.waiting.iter_mut().zip(0..) {
            if let Some(waiting) = waiting.as_deref_mut().filter(|waiting| waiting.count > 0) {
                waiting.light((world, LightId(light)), samples, &mut add);
            }
        }
    }

    /// Computes for the first `count` of these vertices; of those that do not sample this light, whatever comes of it, nobody is to ask
    /// [`EmitterBatches::found`].
    pub(super) fn light_all(
        &mut self,
        (world, light): (&World, LightId),
        vertices: VertexRows<S>,
        count: usize,
    ) {
        let samples = &mut self.samples;
        samples.find((world, light), vertices, count);
    }

    /// The shadow ray of vertex `i` of these, and what is gained if nothing blocks it; `None` for nothing.
    #[inline(always)]
    pub(super) fn found(&self, i: usize, time: f32) -> Option<(Ray, Rgb)> {
        let light = self.samples.value.get(i);
        (!is_black(light)).then(|| (self.samples.shadow(i, time), light))
    }
}

fn is_branchless(light: &Light) -> bool {
    let shape = light.shape().map(|(shape, _)| shape);
    matches!(shape, Some(Emitter::Parallelogram(_) | Emitter::Sphere(_)))
}

/// Vertices that wait for the light of one lamp.
struct Waiting<S: Scatterer> {
    /// Those that are used.
    count: usize,
    vertices: Vertices<S>,
    /// Their paths.
    paths: [u32; ROOM],
}

impl<S: Scatterer> Default for Waiting<S> {
    fn default() -> Self {
        Waiting {
            count: 0,
            vertices: Vertices::default(),
            paths: [0; ROOM],
        }
    }
}

impl<S: Scatterer> Waiting<S> {
    fn light(
        &mut self,
        (world, from): (&World, LightId),
        samples: &mut Samples,
        add: &mut impl FnMut(&Ray, Gain),
    ) {
        let count = std::mem::take(&mut self.count);
        samples.find((world, from), self.vertices.rows(), count);
        let kept = self.vertices.time.iter().zip(&self.paths).take(count);
        for ((&time, &path), i) in kept.zip(0..) {
            let light = samples.value.get(i);
            if !is_black(light) {
                add(&samples.shadow(i, time), Gain { path, from, light });
            }
        }
    }
}

/// What is known.
struct Vertices<S: Scatterer> {
    pmf: [f32; ROOM],
    u: [[f32; ROOM]; 2],
    p: Rows3<ROOM>,
    p_error: Rows3<ROOM>,
    time: [f32; ROOM],
    scatterers: S::Rows<ROOM>,
    throughput: Rows3<ROOM>,
}

impl<S: Scatterer> Default for Vertices<S> {
    fn default() -> Self {
        Vertices {
            pmf: [0.0; ROOM],
            u: [[0.0; ROOM]; 2],
            p: Rows3::default(),
            p_error: Rows3::default(),
            time: [0.0; ROOM],
            scatterers: Default::default(),
            throughput: Rows3::default(),
        }
    }
}

impl<S: Scatterer> Vertices<S> {
    fn rows(&self) -> VertexRows<'_, S> {
        VertexRows {
            pmf: &self.pmf,
            u: &self.u,
            p: &self.p,
            p_error: &self.p_error,
            scatterers: &self.scatterers,
            throughput: &self.throughput,
        }
    }

    #[inline(always)]
    fn set(
        &mut self,
        i: usize,
        pmf: f32,
        u: Vec2,
        (from, scatterer): (&ReferencePoint, &S),
        throughput: Rgb,
    ) {
        self.pmf[i] = pmf;
        (self.u[0][i], self.u[1][i]) = (u.x, u.y);
        self.p.set(i, from.p);
        self.p_error.set(i, from.p_error);
        self.time[i] = from.time;
        self.scatterers.set(i, scatterer);
        self.throughput.set(i, throughput);
    }
}

impl<S: Scatterer> VertexRows<'_, S> {
    /// What [`super::PathState::sample_light`] would add, and its shadow ray. Black where nothing comes.
    #[inline(always)]
    fn sample<E: BranchlessEmitter>(&self, i: usize, emitter: &E, glow: &Glow) -> (Rgb, Ray) {
        let scatterer = self.scatterers.get(i);
        let from = ReferencePoint {
            p: self.p.get(i),
            p_error: self.p_error.get(i),
            n: scatterer.geometric_normal(),
            ..Default::default()
        };
        let u = Vec2::new(self.u[0][i], self.u[1][i]);
        let (point, is_seen) = emitter.sample(&from, u);
        let light = glow.arriving(&from, &point);
        let (scattered, scattered_pdf) = scatterer.scattered_and_pdf(light.wi);
        let contribution = scattered * light.radiance;
        let weighted = weighted(contribution, self.pmf[i] * light.pdf, Some(scattered_pdf));
        let value = self.throughput.get(i) * weighted;
        let comes = is_seen & !is_black(contribution);
        (if comes { value } else { Rgb::ZERO }, light.shadow)
    }
}

/// What is found.
struct Samples {
    value: Rows3<ROOM>,
    o: Rows3<ROOM>,
    d: Rows3<ROOM>,
    t_max: [f32; ROOM],
}

impl Default for Samples {
    fn default() -> Self {
        Samples {
            value: Rows3::default(),
            o: Rows3::default(),
            d: Rows3::default(),
            t_max: [0.0; ROOM],
        }
    }
}

impl Samples {
    /// Finds them for the first `count` of these vertices.
    fn find<S: Scatterer>(
        &mut self,
        (world, from): (&World, LightId),
        vertices: VertexRows<S>,
        count: usize,
    ) {
        match world.light(from).shape() {
            Some((Emitter::Parallelogram(piece), glow)) => {
                self.sample((&**piece, glow), vertices, count);
            }
            Some((Emitter::Sphere(ball), glow)) => {
                self.sample((&ball.far(), glow), vertices, count);
            }
            _ => {}
        }
    }

    fn sample<E: BranchlessEmitter, S: Scatterer>(
        &mut self,
        (emitter, glow): (&E, Glow),
        vertices: VertexRows<S>,
        count: usize,
    ) {
        vectorize::<ROOM, _>(SideBySide {
            emitter: *emitter,
            glow,
            vertices,
            count,
            samples: self,
        });
    }

    #[inline(always)]
    fn set(&mut self, i: usize, (value, shadow): (Rgb, Ray)) {
        self.value.set(i, value);
        self.o.set(i, shadow.o);
        self.d.set(i, shadow.d);
        self.t_max[i] = shadow.t_max;
    }

    #[inline]
    fn shadow(&self, i: usize, time: f32) -> Ray {
        Ray {
            o: self.o.get(i),
            d: self.d.get(i),
            t_max: self.t_max[i],
            time,
        }
    }
}

/// The loop.
struct SideBySide<'a, E, S: Scatterer> {
    emitter: E,
    glow: Glow,
    vertices: VertexRows<'a, S>,
    count: usize,
    samples: &'a mut Samples,
}

impl<E: BranchlessEmitter, S: Scatterer> Kernel for SideBySide<'_, E, S> {
    type Output = ();

    #[inline(always)]
    fn run(self, _: impl Instructions) {
        let whole = self.count.next_multiple_of(WIDEST).min(ROOM);
        for i in 0..whole {
            let sample = self.vertices.sample(i, &self.emitter, &self.glow);
            self.samples.set(i, sample);
        }
    }
}

#[cfg(test)]
mod tests;
