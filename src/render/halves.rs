//! The two halves of a progressive image: what they tell of its error, and what the next pass takes.

use super::allocation::{Share, doubled, for_error, for_samples};
use super::confidence::Noise;
use super::{Ended, Goal};
use crate::film::{
    Developed, DroppedSample, Film, FilmSpec, Kept, PixelBounds, PixelStatistics, Splats, Tile,
};
use crate::math::UVec2;
use glam::DVec3;

/// Sample counts per pixel of each half's tiles.
pub(super) type Counts = [Vec<u32>; 2];

/// A pass is planned for slightly less than the requested error: its estimate is noisy, and a miss costs another pass.
const PART_OF_ERROR: f64 = 0.97;

/// Two independent images of one scene (see [`render_until`](super::render_until)).
pub struct Halves {
    tiles: Vec<PixelBounds>,
    films: [Film; 2],
    /// Of paths from the lights, if any are traced.
    splats: Vec<Splats>,
    counts: Counts,
    /// Samples of a pixel are, in each half.
    are_dependent: bool,
}

impl Halves {
    /// Without samples. Those of all pixels in a tile are equally many. If paths are traced from the lights, both halves
    /// have splats. Whether the samples of a pixel depend on each other says how its variance is estimated.
    pub fn new(
        spec: &FilmSpec,
        sampled: PixelBounds,
        tile_size: u32,
        splats: Option<[Splats; 2]>,
        are_dependent: bool,
    ) -> Halves {
        let film = Film::new(spec);
        let bounds = film.bounds().intersection(sampled);
        let tiles: Vec<PixelBounds> = bounds.tiles(tile_size).collect();
        let none = vec![0; tiles.len()];
        Halves {
            tiles,
            films: [film.clone(), film],
            splats: splats.map(Vec::from).unwrap_or_default(),
            counts: [none.clone(), none],
            are_dependent,
        }
    }

    /// The tiles, whose order is that of all counts.
    pub fn tiles(&self) -> &[PixelBounds] {
        &self.tiles
    }

    /// What each tile has.
    pub fn counts(&self) -> &Counts {
        &self.counts
    }

    /// Adds samples of one half: a tile, or part of one.
    pub fn merge(&mut self, half: usize, tile: Tile) {
        self.films[half].merge(tile);
    }

    /// All pixels of a half's tile have this many samples now.
    pub fn reach(&mut self, half: usize, tile: usize, count: u32) {
        self.counts[half][tile] = count;
    }

    /// The camera samples of one half so far, or in a plan.
    pub fn samples_of(&self, half: usize, counts: &Counts) -> u64 {
        let pairs = self.tiles.iter().zip(&counts[half]);
        pairs.map(|(t, &n)| t.area() as u64 * u64::from(n)).sum()
    }

    /// Those of one half; `None` if no light paths are traced.
    pub fn splats(&mut self, half: usize) -> Option<&mut Splats> {
        self.splats.get_mut(half)
    }

    /// Every pixel of one half that has samples: these, and their mean with the light of its light paths.
    fn means(&self, half: usize) -> impl Iterator<Item = (&PixelStatistics, DVec3)> {
        let pixels = self.films[half].bounds().pixels();
        pixels.filter_map(move |pixel| self.at(half, pixel))
    }

    /// The samples of a pixel of one half, if there are any, and their mean with the light of light paths.
    fn at(&self, half: usize, pixel: UVec2) -> Option<(&PixelStatistics, DVec3)> {
        let own = self.films[half]
            .statistics(pixel)
            .filter(|own| own.count() > 0)?;
        let light = self.splats.get(half).map(|splats| splats.mean(pixel));
        Some((own, light.map_or(own.mean(), |light| own.mean() + light)))
    }

    /// Why no further pass is needed, if so, with this [error](Halves::judged).
    pub fn reached(&self, goal: &Goal, error: Option<f64>) -> Option<Ended> {
        let good = |wanted: f64| error.is_some_and(|error| error <= wanted);
        if goal.error.is_some_and(good) {
            return Some(Ended::Error);
        }
        let most = goal.most_of_half();
        let all_have = self.counts.iter().flatten().all(|&n| n >= most);
        all_have.then_some(Ended::Samples)
    }

    /// Number of camera samples so far.
    pub fn samples(&self) -> f64 {
        let of = |counts: &Vec<u32>| -> f64 {
            let pairs = self.tiles.iter().zip(counts);
            pairs.map(|(t, &n)| t.area() as f64 * f64::from(n)).sum()
        };
        self.counts.iter().map(of).sum()
    }

    /// Number of pixels.
    pub fn pixels(&self) -> f64 {
        self.tiles.iter().map(|t| t.area() as f64).sum()
    }

    /// Average number of samples per pixel.
    pub fn spp(&self) -> f64 {
        self.samples() / self.pixels().max(1.0)
    }

    /// The estimated relative error: see `Progressive::error`.
    pub fn error(&self) -> Option<f64> {
        Some(self.noise(|p, q| (p + q) * 0.5)?.error)
    }

    /// What is to be as small as the goal at the `look`-th pass: the error, or its bound, for which pixels are as dark as the
    /// darker half says: one that is bright in one half by chance has a large error of little light, not a small one of much.
    pub fn judged(&self, goal: &Goal, look: u32) -> Option<f64> {
        let Some(confidence) = goal.confidence else {
            return self.error();
        };
        let noise = self.noise(|p, q| p.abs().min(q.abs()))?;
        (self.spp() >= SURE_FROM).then(|| noise.bound(confidence, look))
    }

    /// The error, relative to what `light` says of a pixel's halves, and how well it is known; `None` if it is unknown.
    fn noise(&self, light: impl Fn(DVec3, DVec3) -> DVec3) -> Option<Noise> {
        if self.counts.iter().flatten().any(|&n| n == 0) {
            return None;
        }
        let pairs = || self.means(0).zip(self.means(1));
        let count = pairs().count() as f64;
        let mean: DVec3 = pairs().map(|((_, p), (_, q))| (p + q) * 0.5).sum();
        let floor = floor(mean.element_sum() / (3.0 * count));
        Noise::of(pairs().map(|((of_p, p), (of_q, q))| {
            let (light, error) = (light(p, q), (p - q) * 0.5);
            let scatter = 0.25 * (of_p.variance_of_mean() + of_q.variance_of_mean());
            [error * error, scatter].map(|v| (v / (light * light + floor)).element_sum())
        }))
    }

    /// The tiles of `of`, with the noise measured by the other half: that of camera samples, which are allocated. The noise of
    /// light paths falls as the mean of all counts grows.
    fn shares(&self, of: usize) -> Vec<Share> {
        let sum: DVec3 = self.means(1 - of).map(|(_, mean)| mean).sum();
        let floor = floor(sum.element_sum() / (3.0 * self.pixels()));
        let noise = |(own, mean): (&PixelStatistics, DVec3)| {
            let variance = own.variance_of_mean() * own.count() as f64;
            (variance / (mean * mean + floor)).element_sum() / 3.0
        };
        let at = |pixel| self.at(1 - of, pixel);
        let share = |(tile, &count): (&PixelBounds, &u32)| Share {
            noise: tile.pixels().filter_map(at).map(noise).sum(),
            area: tile.area() as f64,
            count,
        };
        self.tiles.iter().zip(&self.counts[of]).map(share).collect()
    }

    /// The counts after the next pass: a pure function of the samples, but for how many are `affordable` in the time
    /// that is left.
    pub fn plan(&self, goal: &Goal, error: Option<f64>, affordable: Option<f64>) -> Counts {
        let most = goal.most_of_half();
        let shares = [0, 1].map(|half| self.shares(half));
        let mut plan = [0, 1].map(|half| doubled(&shares[half], most));
        if let Some((wanted, error)) = goal.error.zip(error) {
            // The error that the allocation predicts for the mean of the halves, compared with their actual difference:
            // well-distributed samples do better than independent ones.
            let promised: f64 = shares
                .iter()
                .flatten()
                .map(|s| s.noise / f64::from(s.count))
                .sum();
            let measured = (error / (PART_OF_ERROR * wanted)).powi(2);
            let target = 0.5 * promised / measured;
            plan = [0, 1].map(|i| for_error(&shares[i], target, most));
        }
        let Some(affordable) = affordable else {
            return plan;
        };
        let cost = |plan: &[Vec<u32>; 2]| -> f64 {
            let of = |half: usize| -> f64 {
                let tiles = plan[half].iter().zip(&shares[half]);
                tiles.map(|(&n, s)| f64::from(n - s.count) * s.area).sum()
            };
            of(0) + of(1)
        };
        if goal.error.is_some() && cost(&plan) <= affordable {
            return plan;
        }
        [0, 1].map(|i| for_samples(&shares[i], 0.5 * affordable, most))
    }

    /// The mean of both, with pooled variances if samples depend on each other. Their camera samples go through `fill` before
    /// the light of light paths is added.
    pub fn developed(&self, fill: impl FnOnce(&mut Film)) -> Developed {
        let mut film = Film::mean_of(&self.films[0], &self.films[1]);
        fill(&mut film);
        if !self.splats.is_empty() {
            film.add_light(&self.splats);
        }
        if !self.are_dependent {
            return film.developed(Kept::Variance);
        }
        film.developed_halves(|pixel| [0, 1].map(|half| self.at(half, pixel).map(|(_, mean)| mean)))
    }

    /// The first sample that was dropped, and its half.
    pub fn first_dropped(&self) -> Option<(DroppedSample, usize)> {
        let of = |half: usize| Some((self.films[half].first_dropped()?, half));
        of(0).or_else(|| of(1))
    }
}

/// Returns `true` if these can be the counts after a pass.
pub(super) fn follows(have: &Counts, next: &Counts, goal: &Goal) -> bool {
    let most = goal.most_of_half();
    let halves = || next.iter().zip(have);
    halves().all(|(next, have)| next.len() == have.len()) && { halves() }
        .flat_map(|(next, have)| next.iter().zip(have))
        .all(|(next, have)| (*have..=most.max(*have)).contains(next))
}

/// Samples a pixel from which on there is a bound: fewer have hardly met what is rare.
const SURE_FROM: f64 = 32.0;

/// ε² for an image of this mean.
pub(super) fn floor(mean: f64) -> DVec3 {
    DVec3::splat((0.01 * mean).powi(2).max(f64::MIN_POSITIVE))
}
