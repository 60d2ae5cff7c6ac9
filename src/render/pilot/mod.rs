//! A pilot pass: a few samples before the image, from which is learned where paths from the lights are to begin, how many there
//! are to be, and how many camera paths are to be joined to one; and whether `path` finds the same at less cost.
//!
//! What counts is the error relative to the image's own brightness: a path's worth is the sum of the squares of what it brings to
//! pixels, over what they have. Both are known roughly, in blocks of pixels. Figures: docs/notes/light-paths.md.
//!
//! A path tracer is helped by light paths where that pays ([`assistance`]).
//!
//! The choice by noise and cost is that of efficiency-aware multiple importance sampling (Grittmann, Yazici, Georgiev and
//! Slusallek 2022), with times that are fixed instead of measured, so that an image does not depend on a clock.

mod assistance;
mod blocks;

use super::{OfAll, RenderJob, SampleState};
use crate::film::LightShare;
use crate::integrators::{Learned, Splat, Workspace};
use crate::math::{Rgb, UVec2, color::luminance};
use crate::samplers::Sampler;
use blocks::Blocks;
use rayon::prelude::*;
use std::collections::BTreeMap;
use std::ops::Range;

/// Rounds of light paths: each after the first is guided by those before it. More of them where few paths brought anything.
const ROUNDS: u64 = 2;
const MAX_ROUNDS: u64 = 4;

/// Light paths of a round that must have brought something for what others would bring to be known.
const ENOUGH: usize = 100;

/// Samples of a pixel in the image for each light path of a round, and the most light paths for each pixel.
const SAMPLES_OF_PATH: u32 = 8;
const PATHS_OF_PIXEL: f64 = 8.0;

/// Most light paths of a round.
const PATHS: u64 = 1 << 18;

/// Blocks along a side of the image: at most so many, fewer for images of less than so many samples in a pixel.
const BLOCKS: u32 = 64;

/// The brightness below which darkness does not count any more, over the image's mean: that of errors everywhere
/// ([`Progressive::error`](super::Progressive#structfield.error)).
const FLOOR: f64 = 0.01;

/// The least blocks by which the image may be left to the path tracer: two samples in each of fewer may meet nothing of what is noise in
/// an image.
const MIN_BLOCKS: usize = 1 << 10;

/// The part of the light that `bdpt` sees which samples of the path tracer must have, too, rare ones cut: of rooms with a lamp they have
/// 0.9 and more, but 0.6 where half of an image is a room whose lamp is in a ball of rough glass.
const MIN_SEEN: f64 = 0.8;

/// Camera samples so many times as bright as their block are rare.
const RARE: f64 = 8.0;

/// The same of an image that may be left to the path tracer, for each of its samples in the pilot pass, which then have met what is less
/// rare: of this brightness 25 of them if that is a quarter of the light.
const RARE_OF_SAMPLE: f64 = 0.01;

/// The variance of light paths, which are points of one sequence, over that of independent ones.
const EVEN: f64 = 0.5;

/// Paths that a worker takes at a time.
const CHUNK: u64 = 1 << 9;

/// Shares of camera paths that may be joined to light paths. Never none where some light may be found in no other way.
const JOINED: [f32; 2] = [1.0, 1.0 / 32.0];

/// The part of the light that joints must bring for all camera paths to be joined. The mean tells more of a few samples than their
/// noise, of which the rare bright ones are the most. In the census that part is 0.02 at most (`point_glossyring`, with 1.05 times the error × time if
/// all are joined), or 0.07 and more (`spot_alphasheet`, with 0.52 times).
const MIN_JOINED: f64 = 0.05;

/// Light paths for each camera sample that may be chosen: not many, as the noise of camera paths is
/// underestimated where its tail is heavy, of which a pilot pass meets nothing.
const LIGHT_SHARES: [f32; 6] = [1.0 / 16.0, 0.125, 0.25, 0.5, 1.0, 2.0];

/// Those where anything scatters in a medium: two samples of a pixel say little of its noise, and light paths do not tell of it either.
const SHARES_IN_MEDIA: [f32; 2] = [1.0, 2.0];

/// Light paths for each camera sample of the pilot pass. What is found as well by camera paths is left to them where light paths are few:
/// then these are as noisy as what they alone find.
const SHARE_OF_PILOT: LightShare = LightShare(0.5);

/// Time for a camera sample, for joining it to a light path, and for a path of the light pass: proportions as they were measured in
/// the scenes of tests/scenes/census. Those of a scene may be others by half, which moves the choice little.
const COST_OF_CAMERA: f64 = 1.0;
const COST_OF_JOINING: f64 = 1.2;
const COST_OF_LIGHT: f64 = 1.3;

/// Time for joining to the lens a path that is traced for a camera path.
const COST_OF_LENS: f64 = 0.4;

/// Time for a sample of the path tracer: 0.55 to 0.71 of the same as one of `bdpt` that is not joined to a light path.
const COST_OF_PATH: f64 = 0.6;

/// Light paths that tell of rare bright samples of the path tracer: this part of a round.
const PART_OF_ROUND: u64 = 4;

/// Light that a path brings to a pixel of a block.
struct Brought {
    path: u64,
    block: u32,
    /// The light without its weight.
    light: f64,
    /// The density with which a camera sample of the pixel finds it, over that of one light path.
    by_camera: f64,
}

impl Brought {
    /// Where there are so many light paths for each sample of a pixel: what this one brings, and the mean square of what camera samples
    /// bring by paths like it, each with its weight (the power heuristic's). With p the density of a light path and q that of a camera
    /// sample, the mean of (f/q)² over camera samples is that of (f/p)² p/q over light paths.
    fn shared(&self, light_paths: f64) -> (f64, f64) {
        let ratio = (self.by_camera / light_paths).powi(2);
        let (mine, others) = (1.0 / (1.0 + ratio), 1.0 / (1.0 + 1.0 / ratio));
        (self.light * mine, others * others * self.square_alone())
    }

    /// The mean square of what camera samples bring by paths like it where there are no light paths.
    fn square_alone(&self) -> f64 {
        let square = self.light * self.light / self.by_camera;
        if square.is_finite() { square } else { 0.0 }
    }
}

/// What light paths have brought to each block, so far.
#[derive(Default)]
struct LightOfBlocks {
    /// Sums, by block.
    values: BTreeMap<u32, f64>,
    paths: u64,
}

impl LightOfBlocks {
    /// Adds what so many more paths brought, with weights for so many for each sample of a pixel.
    fn extend(&mut self, brought: &[Brought], paths: u64, light_paths: f64) {
        self.paths += paths;
        for b in brought {
            *self.values.entry(b.block).or_insert(0.0) += b.shared(light_paths).0;
        }
    }
}

/// What a pilot pass expects of an image.
struct Effort {
    /// Noise × time.
    least: f64,
    /// The mean square of rare bright camera samples where there are no light paths.
    rare_alone: f64,
}

/// What the samples of a pilot pass are taken of.
struct Pilot {
    sampler: Sampler,
    blocks: Blocks,
}

/// What two camera samples of a block's pixel saw: each without and by connections.
type Pair = [[f64; 2]; 2];

impl RenderJob {
    /// Chooses how light paths are traced, in a small part of the time of the image. A pure function of scene and settings, whatever the seed is.
    pub fn run_pilot_pass(&mut self) {
        if self.integrator.shows_all_strategies() {
            // As they are, not as they pay: one light path for each camera sample.
            self.light_share = LightShare(1.0);
            return;
        }
        // Where samples are cut, the two cut other light.
        let by_path = self.integrator.camera_paths_find_all(&self.world)
            && self.film.max_sample_luminance.is_infinite()
            && !self.integrator.shows_strategies();
        if !self.integrator.is_indirect() {
            self.integrator.join(0.0);
            self.light_share = LightShare(0.0);
            if by_path {
                self.integrator.leave_to_camera_paths();
            }
            return;
        }
        self.light_share = SHARE_OF_PILOT;
        let pilot = Pilot {
            sampler: self.sampler.pilot(),
            blocks: Blocks::new(self.lit(), blocks_of_side(self.sampler.spp())),
        };
        if pilot.blocks.count() == 0 {
            return;
        }
        let (seen, share) = self.choose_joined(&pilot);
        if by_path && self.leaves_to_path(&pilot, &seen, share) {
            return;
        }
        self.integrator.join(share);
        let shares = match self.world.media.is_empty() {
            true => &LIGHT_SHARES[..],
            false => &SHARES_IN_MEDIA,
        };
        let effort = self.guide_light_paths(&pilot, (&seen, share), shares);
        if !self.integrator.needs_light_paths(&self.world) {
            self.consider_no_light_paths(&pilot, share, &effort);
        }
    }

    /// Leaves all light to camera paths if their noise × time, with that of rare samples of which light paths told, is less than with light paths; a
    /// `share` of them is joined.
    fn consider_no_light_paths(&mut self, pilot: &Pilot, share: f32, effort: &Effort) {
        let chosen = std::mem::replace(&mut self.light_share, LightShare(0.0));
        let seen = self.look(pilot);
        let worth = worth(&pilot.blocks, &seen, &LightOfBlocks::default());
        let noise = noise_of_camera(&seen, share.into(), &worth);
        // What is not a number proves nothing.
        let is_better = (noise + effort.rare_alone) * cost_of_camera(share) <= effort.least;
        if !is_better {
            self.light_share = chosen;
        }
    }

    /// Leaves the image to the path tracer, and returns `true`, if its noise × time is less than that of camera paths that saw what was
    /// `seen`, with light paths beside them, and a `share` of which is joined to one.
    fn leaves_to_path(&mut self, pilot: &Pilot, seen: &[Pair], share: f32) -> bool {
        if pilot.blocks.count() < MIN_BLOCKS {
            return false;
        }
        self.integrator.join(0.0);
        self.light_share = LightShare(0.0);
        let by_path = self.look(pilot);
        self.light_share = SHARE_OF_PILOT;
        let is_better = self.is_better_by_path(pilot, (seen, share), &by_path);
        if is_better {
            self.light_share = LightShare(0.0);
            self.integrator.leave_to_camera_paths();
        }
        is_better
    }

    /// Returns `true` if noise × time is less by samples like those `by_path`. Written so that what is not a number, as in a black image,
    /// proves nothing.
    fn is_better_by_path(
        &self,
        pilot: &Pilot,
        (seen, share): (&[Pair], f32),
        by_path: &[Pair],
    ) -> bool {
        let worth = worth_beside_lamps(&pilot.blocks, seen);
        let cost = cost_of_camera(share) + f64::from(SHARE_OF_PILOT.0) * COST_OF_LIGHT;
        let least = noise_of_camera(seen, share.into(), &worth) * cost;
        let noise = noise_of_camera(by_path, 0.0, &worth);
        let may_be_better = noise * COST_OF_PATH <= least;
        if !may_be_better {
            return false;
        }
        // Of the rare bright samples that camera paths have not met light paths tell, if enough of them come to the lens.
        let paths = (self.paths_of_round() / PART_OF_ROUND).next_multiple_of(CHUNK);
        let told = Told {
            brought: &self.light(pilot, 0..paths),
            paths,
            blocks: &pilot.blocks,
            worth: &worth,
            may_be_paired: false,
        };
        let rare = RARE.max(RARE_OF_SAMPLE * 2.0 * by_path.len() as f64);
        let all = brightness(seen, (share.into(), rare), &worth)
            + told.brightness(self.paths_per_sample());
        told.lucky_paths() >= ENOUGH
            && (noise + told.rare_alone(rare)) * COST_OF_PATH <= least
            && brightness(by_path, (0.0, rare), &worth) >= MIN_SEEN * all
    }

    /// Light paths of a round.
    fn paths_of_round(&self) -> u64 {
        let of_pixel = f64::from(self.sampler.spp()) / f64::from(SAMPLES_OF_PATH);
        let count = (of_pixel.min(PATHS_OF_PIXEL) * self.lit().area() as f64) as u64;
        count.clamp(1, PATHS).next_multiple_of(CHUNK)
    }

    /// Learns where light paths are to begin, and which of the `shares` of them there are to be, where camera samples see what was `seen`
    /// and a `share` of them is joined.
    fn guide_light_paths(
        &mut self,
        pilot: &Pilot,
        (seen, share): (&[Pair], f32),
        shares: &[f32],
    ) -> Effort {
        let count = self.paths_of_round();
        self.integrator.aim_emission(&self.world, count);
        let weights = f64::from(self.paths_per_sample());
        let (mut learned, mut lit) = (Vec::new(), LightOfBlocks::default());
        let mut brought = Vec::new();
        let mut told_enough = false;
        for round in 1..=MAX_ROUNDS {
            brought = self.light(pilot, (round - 1) * count..round * count);
            lit.extend(&brought, count, weights);
            let worth = worth(&pilot.blocks, seen, &lit);
            let of_round = self.learned(pilot, &brought, &worth);
            told_enough = of_round.len() >= ENOUGH;
            let tells_more = !told_enough && !of_round.is_empty();
            learned.extend(of_round);
            self.integrator.guide_emission(&learned, lit.paths as usize);
            if round >= ROUNDS && !tells_more {
                break;
            }
        }
        // Few paths that brought little may be all that were lucky: what is rare is not left to fewer.
        let shares = match told_enough {
            true => shares,
            false => &shares[shares.partition_point(|&share| share < 1.0)..],
        };
        let told = Told {
            brought: &brought,
            paths: count,
            blocks: &pilot.blocks,
            worth: &worth(&pilot.blocks, seen, &lit),
            may_be_paired: self.may_pair_paths(),
        };
        let camera = noise_of_camera(seen, share.into(), told.worth);
        let (light_share, least) = best_light_share(camera, &told, share, shares);
        self.light_share = LightShare(light_share);
        Effort {
            least,
            rare_alone: told.rare_alone(RARE),
        }
    }

    /// The share of camera paths to be joined to light paths, and what they saw.
    fn choose_joined(&mut self, pilot: &Pilot) -> (Vec<Pair>, f32) {
        let [all, few] = match self.integrator.needs_light_paths(&self.world) {
            true => JOINED,
            false => [JOINED[0], 0.0],
        };
        self.integrator.join(all);
        let seen = self.look(pilot);
        let worth = worth_beside_lamps(&pilot.blocks, &seen);
        let joined = part_of_joined(&pilot.blocks, &seen, &worth);
        if joined >= MIN_JOINED {
            return (seen, all);
        }
        self.integrator.join(few);
        // Where joints bring nothing weights do not depend on them.
        match joined > 0.0 {
            true => (self.look(pilot), few),
            false => (seen, few),
        }
    }

    /// Luminances of two camera paths in each block.
    fn look(&self, pilot: &Pilot) -> Vec<Pair> {
        let Pilot { sampler, blocks } = pilot;
        let all = OfAll::new(self, sampler, None);
        let all_blocks = (0..blocks.count()).into_par_iter();
        let pairs = all_blocks.map_init(Workspace::default, |workspace, block| {
            let pixel = blocks.pixel(block);
            [0, 1].map(|index| self.luminance_in_parts(sampler, (pixel, index), &all, workspace))
        });
        pairs.collect()
    }

    /// Never inlined, as [`sample_tile`](super::sample_tile).
    #[inline(never)]
    fn luminance_in_parts(
        &self,
        sampler: &Sampler,
        (pixel, index): (UVec2, u32),
        all: &OfAll,
        workspace: &mut Workspace,
    ) -> [f64; 2] {
        let (sample, mut waiting) = SampleState::new(self, sampler, pixel, index);
        let mut rays = [None];
        let differentials = self.world.needs_footprint();
        self.camera.rays(&[sample], differentials, &mut rays);
        let [Some(ray)] = &rays else {
            return [0.0; 2];
        };
        let parts = self.integrator.radiance_in_parts(
            &self.world,
            &waiting.camera_end(self, &sample, ray, all),
            ray.scaled_differentials(all.spacing).as_ref(),
            &mut waiting.stream,
            workspace,
        );
        parts.map(|part| finite_luminance(part * ray.tint * (ray.weight * waiting.filter_weight)))
    }

    /// What light paths bring, in their order.
    fn light(&self, pilot: &Pilot, paths: Range<u64>) -> Vec<Brought> {
        let Pilot { sampler, blocks } = pilot;
        let job = self.light_job();
        let chunks = (paths.start / CHUNK..paths.end / CHUNK).into_par_iter();
        let brought = chunks.map_init(Workspace::default, |workspace, chunk| {
            let paths = chunk * CHUNK..(chunk + 1) * CHUNK;
            let paths = paths.map(|path| (path, sampler.light_stream(path)));
            let mut brought = Vec::new();
            self.integrator
                .light_paths(&job, paths, workspace, &mut |splat: Splat| {
                    let others = splat.by_camera * splat.by_camera;
                    brought.push(Brought {
                        path: splat.path,
                        block: blocks.of(splat.pixel),
                        light: finite_luminance(splat.value) * (1.0 + others),
                        by_camera: splat.by_camera * f64::from(job.light_paths),
                    });
                });
            // Paths bring it side by side.
            brought.sort_by_key(|brought: &Brought| brought.path);
            brought
        });
        brought.flatten().collect()
    }

    /// What paths have told.
    fn learned(&self, pilot: &Pilot, brought: &[Brought], worth: &[f64]) -> Vec<Learned> {
        let job = self.light_job();
        let mut squares = BTreeMap::new();
        for b in brought {
            let (value, _) = b.shared(job.light_paths.into());
            *squares.entry(b.path).or_insert(0.0) += value * value * worth[b.block as usize];
        }
        let learned = squares.into_iter().filter_map(|(path, brought)| {
            let stream = pilot.sampler.light_stream(path);
            let beginning = self.integrator.beginning(&job, stream)?;
            Some(Learned { beginning, brought })
        });
        learned.collect()
    }
}

/// 1 over the square of each block's brightness, by what was `seen` and what light paths brought to it.
fn worth(blocks: &Blocks, seen: &[Pair], lit: &LightOfBlocks) -> Vec<f64> {
    let bright = brightnesses(blocks, seen, lit);
    let mean = bright.iter().sum::<f64>() / bright.len() as f64;
    worth_over(&bright, FLOOR * mean)
}

/// The same where even a lamp in the image does not make all else dark: the mean is of roots.
fn worth_beside_lamps(blocks: &Blocks, seen: &[Pair]) -> Vec<f64> {
    let bright = brightnesses(blocks, seen, &LightOfBlocks::default());
    let root = bright.iter().map(|b| b.sqrt()).sum::<f64>() / bright.len() as f64;
    worth_over(&bright, FLOOR * root * root)
}

fn worth_over(bright: &[f64], floor: f64) -> Vec<f64> {
    bright.iter().map(|b| (b + floor).powi(-2)).collect()
}

/// Each block's brightness, as it and its neighbors tell of it: judged by itself alone a rare bright sample would come from a bright block.
fn brightnesses(blocks: &Blocks, seen: &[Pair], lit: &LightOfBlocks) -> Vec<f64> {
    let of_pair = |pair: &Pair| 0.5 * pair.iter().flatten().sum::<f64>();
    let mut bright = blocks.smooth(&seen.iter().map(of_pair).collect::<Vec<f64>>());
    for (&block, value) in &lit.values {
        let block = block as usize;
        bright[block] += value / (lit.paths as f64 * blocks.pixels(block));
    }
    bright
}

/// The part of the light that comes of joints where all camera paths are joined: the root of the mean square over regions of the image, of which
/// one alone may live by joints.
fn part_of_joined(blocks: &Blocks, seen: &[Pair], worth: &[f64]) -> f64 {
    let of_block = |(pair, worth): (&Pair, &f64)| pair.map(|[_, joined]| joined * worth.sqrt());
    let square = blocks.mean_square_of_regions(seen.iter().zip(worth).map(of_block));
    square.sqrt()
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

/// What camera samples see where a `share` of them is joined to light paths, over the blocks' brightness: no more than `most` times that.
fn brightness(seen: &[Pair], (share, most): (f64, f64), worth: &[f64]) -> f64 {
    let of_block = |(pair, worth): (&Pair, &f64)| {
        let common =
            |[alone, joined]: [f64; 2]| (worth.sqrt() * (alone + share * joined)).min(most);
        0.5 * (common(pair[0]) + common(pair[1]))
    };
    seen.iter().zip(worth).map(of_block).sum::<f64>() / seen.len() as f64
}

/// What light paths told.
struct Told<'a> {
    brought: &'a [Brought],
    /// How many they were.
    paths: u64,
    blocks: &'a Blocks,
    /// Of the blocks' light.
    worth: &'a [f64],
    /// Camera paths may be joined to light paths of the image's light pass.
    may_be_paired: bool,
}

impl Told<'_> {
    /// The mean over the pixels of what `square` says of what was brought, over the blocks' brightness.
    fn mean(&self, square: impl Fn(&Brought) -> f64) -> f64 {
        let of = |b: &Brought| square(b) * self.worth[b.block as usize];
        self.brought.iter().map(of).sum::<f64>() / (self.paths as f64 * self.pixels())
    }

    /// How many paths have brought anything.
    fn lucky_paths(&self) -> usize {
        self.brought.chunk_by(|a, b| a.path == b.path).count()
    }

    fn pixels(&self) -> f64 {
        self.blocks.all_pixels()
    }

    /// The light that so many light paths for each sample of a pixel bring, over the blocks' brightness.
    fn brightness(&self, light_paths: f32) -> f64 {
        let of = |b: &Brought| b.shared(light_paths.into()).0 * self.worth[b.block as usize].sqrt();
        self.brought.iter().map(of).sum::<f64>() / (self.paths as f64 * self.pixels())
    }

    /// The variance of light paths where there are so many for each camera sample: the mean square; what a path brings to a pixel is far
    /// more than the pixel has.
    fn noise(&self, share: f64) -> f64 {
        let paths = share * self.pixels();
        EVEN * self.mean(|b| b.shared(paths).0.powi(2)) / paths
    }

    /// The mean square of rare bright camera samples there, which none of a pilot pass may have been.
    fn rare(&self, share: f64) -> f64 {
        let paths = share * self.pixels();
        self.mean(|b| {
            if self.is_rare(b, RARE) {
                b.shared(paths).1
            } else {
                0.0
            }
        })
    }

    /// The same where there are no light paths, of samples so many times as bright as their block.
    fn rare_alone(&self, least: f64) -> f64 {
        self.mean(|b| {
            if self.is_rare(b, least) {
                b.square_alone()
            } else {
                0.0
            }
        })
    }

    fn is_rare(&self, b: &Brought, least: f64) -> bool {
        let brightness = self.worth[b.block as usize].powf(-0.5);
        b.light / b.by_camera > least * brightness
    }
}

/// Time for a camera sample of which a `share` is joined to a light path.
fn cost_of_camera(share: f32) -> f64 {
    COST_OF_CAMERA + f64::from(share) * COST_OF_JOINING
}

/// Time for so many light paths for each camera sample, which are joined to one each if `are_paired`.
fn cost_of_light(share: f32, are_paired: bool) -> f64 {
    let share = f64::from(share);
    match are_paired && share >= 1.0 {
        true => COST_OF_LENS + (share - 1.0) * COST_OF_LIGHT,
        false => share * COST_OF_LIGHT,
    }
}

/// Light paths for each camera sample by which the error falls fastest, given the variance of camera samples, and noise × time then.
fn best_light_share(camera: f64, told: &Told, joined: f32, shares: &[f32]) -> (f32, f64) {
    let effort = |share: f32| {
        let of_light = f64::from(share);
        let cost =
            cost_of_camera(joined) + cost_of_light(share, told.may_be_paired && joined >= 1.0);
        (camera + told.rare(of_light) + told.noise(of_light)) * cost
    };
    let least = { shares.iter() }
        .map(|&share| (share, effort(share)))
        .min_by(|a, b| a.1.total_cmp(&b.1));
    least.unwrap_or((1.0, f64::INFINITY))
}

fn finite_luminance(value: Rgb) -> f64 {
    let value = f64::from(luminance(value));
    if value.is_finite() {
        value.max(0.0)
    } else {
        0.0
    }
}

/// With as many samples of blocks as there are of pixels, the pilot pass has the same share of any image's time.
fn blocks_of_side(spp: u32) -> u32 {
    let part = f64::from(spp) / f64::from(BLOCKS);
    ((part.sqrt() * f64::from(BLOCKS)) as u32).clamp(1, BLOCKS)
}

#[cfg(test)]
mod tests;
