//! A pilot pass: a few samples before the image, from which is learned where paths from the lights are to begin, how many there
//! are to be, and how many camera paths are to be joined to one.
//!
//! What counts is the error relative to the image's own brightness: a path's worth is the sum of the squares of what it brings to
//! pixels, over what they have. Both are known roughly, in blocks of pixels. Figures: docs/notes/light-paths.md.
//!
//! The choice by noise and cost is that of efficiency-aware multiple importance sampling (Grittmann, Yazici, Georgiev and
//! Slusallek 2022), with times that are fixed instead of measured, so that an image does not depend on a clock.

use super::{CameraRay, CameraSample, OfAll, PendingSample, RenderJob};
use crate::cameras::BUNDLE;
use crate::film::{LightShare, PixelBounds};
use crate::integrators::{Learned, LightJob, Workspace};
use crate::math::{Rgb, UVec2, color::luminance};
use crate::samplers::Sampler;
use arrayvec::ArrayVec;
use rayon::prelude::*;
use std::collections::BTreeMap;
use std::ops::Range;

/// Rounds of light paths: each after the first is guided by those before it.
const ROUNDS: u64 = 2;

/// Light paths of a round for each pixel, and least and most of them.
const PATHS_OF_PIXEL: usize = 4;
const PATHS: [usize; 2] = [1 << 12, 1 << 18];

/// Blocks along a side of the image at most.
const BLOCKS: u32 = 64;

/// The brightness below which darkness does not count any more, over the image's mean.
const FLOOR: f64 = 0.02;

/// Paths that a worker takes at a time.
const CHUNK: u64 = 1 << 9;

/// Shares of camera paths that may be joined to light paths. Never none: some light may be found in no other way.
const JOINED: [f32; 2] = [1.0, 1.0 / 32.0];

/// Light paths for each camera sample that may be chosen. Never none, as above; and not many, as the noise of camera paths is
/// underestimated where its tail is heavy, of which a pilot pass meets nothing.
const LIGHT_SHARES: [f32; 4] = [0.25, 0.5, 1.0, 2.0];

/// Time for a camera sample, for joining it to a light path, and for a path of the light pass: proportions as they were measured in
/// the scenes of tests/scenes/census. Those of a scene may be others by half, which moves the choice little.
const COST_OF_CAMERA: f64 = 1.0;
const COST_OF_JOINING: f64 = 1.2;
const COST_OF_LIGHT: f64 = 1.3;

/// Light that a path brings to a pixel.
struct Brought {
    path: u64,
    block: u32,
    value: f64,
}

/// What light paths have brought to each block, so far.
#[derive(Default)]
struct Light {
    /// Sums, by block.
    values: BTreeMap<u32, f64>,
    paths: u64,
}

impl Light {
    fn extend(&mut self, brought: &[Brought], paths: u64) {
        self.paths += paths;
        for b in brought {
            *self.values.entry(b.block).or_insert(0.0) += b.value;
        }
    }
}

/// What the samples of a pilot pass are taken of.
struct Pilot {
    sampler: Sampler,
    blocks: Blocks,
}

/// What two camera samples of a block's pixel saw: each without and by connections.
type Pair = [[f64; 2]; 2];

impl RenderJob {
    /// Chooses how light paths are traced. A pure function of scene, settings and seed, but for the number of samples.
    pub fn learn(&mut self) {
        // What is found as well by camera paths is left to them where light paths are few: then these are as noisy as what they alone
        // find.
        self.light_share = LightShare(LIGHT_SHARES[1]);
        let pilot = Pilot {
            sampler: self.sampler.pilot(),
            blocks: Blocks::new(self.lit()),
        };
        if pilot.blocks.count() == 0 {
            return;
        }
        let (seen, share) = self.choose_joined(&pilot);
        self.integrator.join(share);
        let count = (PATHS_OF_PIXEL * self.lit().area()).clamp(PATHS[0], PATHS[1]) as u64;
        let count = count.next_multiple_of(CHUNK);
        let (mut learned, mut lit) = (Vec::new(), Light::default());
        let mut noise = 0.0;
        for round in 1..=ROUNDS {
            let brought = self.light(&pilot, (round - 1) * count..round * count);
            lit.extend(&brought, count);
            let worth = worth(&pilot.blocks, &seen, &lit);
            noise = noise_of_light(&brought, count, &pilot.blocks, &worth);
            learned.extend(self.learned(&pilot, &brought, &worth));
            self.integrator.guide_emission(&learned, lit.paths as usize);
        }
        let camera = noise_of_camera(&seen, share.into(), &worth(&pilot.blocks, &seen, &lit));
        self.light_share = LightShare(best_light_share(camera, noise, share));
    }

    /// The share of camera paths to be joined to light paths, and what they saw.
    fn choose_joined(&mut self, pilot: &Pilot) -> (Vec<Pair>, f32) {
        let looks = JOINED.map(|share| {
            self.integrator.join(share);
            (self.look(pilot), share)
        });
        let worth = worth(&pilot.blocks, &looks[0].0, &Light::default());
        let effort = |(seen, share): &(Vec<Pair>, f32)| {
            let share = f64::from(*share);
            noise_of_camera(seen, share, &worth) * (COST_OF_CAMERA + share * COST_OF_JOINING)
        };
        let least = looks
            .into_iter()
            .min_by(|a, b| effort(a).total_cmp(&effort(b)));
        least.unwrap_or_default()
    }

    fn light_job(&self) -> LightJob<'_> {
        LightJob {
            world: &self.world,
            camera: &self.camera,
            filter: &self.filter,
            bounds: self.lit(),
            light_paths: self.paths_per_sample(),
        }
    }

    /// Luminances of two camera paths in each block.
    fn look(&self, pilot: &Pilot) -> Vec<Pair> {
        let Pilot { sampler, blocks } = pilot;
        let all = OfAll::new(self);
        let all_blocks = (0..blocks.count()).into_par_iter();
        let pairs = all_blocks.map_init(Workspace::default, |workspace, block| {
            let pixel = blocks.middle(block);
            [0, 1].map(|index| self.luminance_in_parts(sampler, (pixel, index), &all, workspace))
        });
        pairs.collect()
    }

    fn luminance_in_parts(
        &self,
        sampler: &Sampler,
        (pixel, index): (UVec2, u32),
        all: &OfAll,
        workspace: &mut Workspace,
    ) -> [f64; 2] {
        let (sample, mut waiting) = PendingSample::new(self, sampler, pixel, index);
        let mut rays = ArrayVec::new();
        let samples: ArrayVec<CameraSample, BUNDLE> = [sample].into_iter().collect();
        let differentials = self.world.needs_footprint();
        self.camera.rays(&samples, differentials, &mut rays);
        let Some(Some(ray)) = rays.first() else {
            return [0.0; 2];
        };
        let ray: &CameraRay = ray;
        let parts = self.integrator.radiance_in_parts(
            &self.world,
            &waiting.camera_end(self, &sample, ray, all),
            ray.scaled_differentials(all.spacing).as_ref(),
            &mut waiting.stream,
            workspace,
        );
        parts.map(|part| finite(part * ray.tint * (ray.weight * waiting.filter_weight)))
    }

    /// What light paths bring, in their order.
    fn light(&self, pilot: &Pilot, paths: Range<u64>) -> Vec<Brought> {
        let Pilot { sampler, blocks } = pilot;
        let job = self.light_job();
        let chunks = (paths.start / CHUNK..paths.end / CHUNK).into_par_iter();
        let brought = chunks.map(|chunk| {
            let paths = chunk * CHUNK..(chunk + 1) * CHUNK;
            let paths = paths.map(|path| (path, sampler.light_stream(path)));
            let mut brought = Vec::new();
            self.integrator
                .light_paths(&job, paths, &mut |path, pixel, value| {
                    brought.push(Brought {
                        path,
                        block: blocks.of(pixel),
                        value: finite(value),
                    });
                });
            brought
        });
        brought.flatten().collect()
    }

    /// What paths have told.
    fn learned(&self, pilot: &Pilot, brought: &[Brought], worth: &[f64]) -> Vec<Learned> {
        let job = self.light_job();
        let mut squares = BTreeMap::new();
        for b in brought {
            *squares.entry(b.path).or_insert(0.0) += b.value * b.value * worth[b.block as usize];
        }
        let learned = squares.into_iter().filter_map(|(path, brought)| {
            let stream = pilot.sampler.light_stream(path);
            let beginning = self.integrator.beginning(&job, stream)?;
            Some(Learned { beginning, brought })
        });
        learned.collect()
    }
}

/// 1 over the square of each block's brightness.
fn worth(blocks: &Blocks, seen: &[Pair], lit: &Light) -> Vec<f64> {
    let of_pair = |pair: &Pair| 0.5 * pair.iter().flatten().sum::<f64>();
    let mut bright: Vec<f64> = seen.iter().map(of_pair).collect();
    for (&block, value) in &lit.values {
        let block = block as usize;
        bright[block] += value / (lit.paths as f64 * blocks.pixels(block));
    }
    let mean = bright.iter().sum::<f64>() / bright.len() as f64;
    let worth = bright.iter().map(|b| (b + FLOOR * mean).powi(-2));
    worth.collect()
}

/// The variance of a camera sample where a `share` of them is joined to light paths, over the blocks' brightness: half the mean
/// square of the difference of two.
fn noise_of_camera(seen: &[Pair], share: f64, worth: &[f64]) -> f64 {
    let of_block = |(&[[a, joined], [b, other]], worth): (&Pair, &f64)| {
        let difference = (a + share * joined) - (b + share * other);
        let by_chance = share * (1.0 - share) * (joined * joined + other * other);
        0.5 * worth * (difference * difference + by_chance)
    };
    seen.iter().zip(worth).map(of_block).sum::<f64>() / seen.len() as f64
}

/// The variance of what so many light paths brought as there are pixels, over the blocks' brightness: the mean square; what a path
/// brings to a pixel is far more than the pixel has.
fn noise_of_light(brought: &[Brought], paths: u64, blocks: &Blocks, worth: &[f64]) -> f64 {
    let of = |b: &Brought| b.value * b.value * worth[b.block as usize];
    let pixels = blocks.bounds.area() as f64;
    brought.iter().map(of).sum::<f64>() / (paths as f64 * pixels * pixels)
}

/// Light paths for each camera sample by which the error falls fastest, given the variances of both.
fn best_light_share(camera: f64, light: f64, joined: f32) -> f32 {
    let effort = |share: f32| {
        let share = f64::from(share);
        let cost = COST_OF_CAMERA + f64::from(joined) * COST_OF_JOINING + share * COST_OF_LIGHT;
        (camera + light / share) * cost
    };
    let least = LIGHT_SHARES
        .into_iter()
        .min_by(|&a, &b| effort(a).total_cmp(&effort(b)));
    least.unwrap_or(1.0)
}

fn finite(value: Rgb) -> f64 {
    let value = f64::from(luminance(value));
    if value.is_finite() {
        value.max(0.0)
    } else {
        0.0
    }
}

/// Blocks of pixels.
struct Blocks {
    bounds: PixelBounds,
    side: u32,
    columns: u32,
}

impl Blocks {
    fn new(bounds: PixelBounds) -> Blocks {
        let size = bounds.size();
        let side = size.max_element().div_ceil(BLOCKS).max(1);
        Blocks {
            bounds,
            side,
            columns: size.x.div_ceil(side),
        }
    }

    fn count(&self) -> usize {
        (self.columns * self.bounds.size().y.div_ceil(self.side)) as usize
    }

    fn of(&self, pixel: UVec2) -> u32 {
        let at = (pixel - self.bounds.min) / self.side;
        at.y * self.columns + at.x
    }

    fn corner(&self, block: usize) -> UVec2 {
        let block = block as u32;
        self.bounds.min + self.side * UVec2::new(block % self.columns, block / self.columns)
    }

    fn size(&self, block: usize) -> UVec2 {
        (self.bounds.max - self.corner(block)).min(UVec2::splat(self.side))
    }

    /// Pixels of a block.
    fn pixels(&self, block: usize) -> f64 {
        let size = self.size(block);
        f64::from(size.x * size.y)
    }

    /// A pixel of the block.
    fn middle(&self, block: usize) -> UVec2 {
        self.corner(block) + self.size(block) / 2
    }
}
