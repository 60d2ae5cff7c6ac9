//! Russian roulette: ends paths of low throughput and scales up the others (Arvo and Kirk 1990; Pharr, Jakob and
//! Humphreys 2016, §13.7 and §14.5.4).

use super::Trail;
use super::emission::MisState;

/// Scattering events after which paths may be terminated whatever they scattered by (pbrt-v3: bounce counter > 3).
const MIN_BOUNCES: u32 = 3;

/// The survival probability over the throughput; pbrt-v3 has 1. A path that survives has so much less throughput than with 1, and so
/// less noise, and only dim paths are terminated. With 4 instead of 1, scenes of many bounces have 0.83 to 0.89 times the squared error in 1.01 to
/// 1.08 times the instructions (docs/notes/performance.md).
const SCALE: f32 = 4.0;

/// [`SCALE`] before [`MIN_BOUNCES`]. With 8 instead of 4, textures, copper and foliage have 0.81 to 0.92 times the squared error and 0.5 to 0.65 times the
/// squared relative error in 1.03 to 1.15 times the instructions. Foliage still takes 0.7 of the time that it takes without roulette.
const EARLY_SCALE: f32 = 8.0;

/// Before [`MIN_BOUNCES`] roulette applies only to broad lobes: pdf ≤ 1/sr, three times a diffuse lobe's peak. What emitter sampling misses
/// is often bright, and dim mirrors and glossy surfaces would rarely show it.
const MAX_BROAD_PDF: f32 = 1.0;

/// No path is terminated with less than this probability once roulette applies, as in pbrt-v3.
const MIN_TERMINATION: f32 = 0.05;

impl Trail {
    /// Counts the scattering event and decides whether the path continues: not where nothing more can come. `choice` returns a sample in
    /// [0, 1) if one is needed.
    #[inline(always)]
    pub(super) fn russian_roulette(
        &mut self,
        threshold: f32,
        choice: impl FnOnce() -> f32,
    ) -> Option<()> {
        let late = self.depth > MIN_BOUNCES;
        self.depth += 1;
        if self.depth >= self.max_depth && !self.looks_on {
            return None;
        }
        let scale = match self.mis {
            _ if late => SCALE,
            MisState::Sampled(sampled) if sampled.pdf <= MAX_BROAD_PDF => EARLY_SCALE,
            _ => return Some(()),
        };
        let survival = scale * (self.throughput * self.eta_scale).max_element();
        if survival >= threshold {
            return Some(());
        }
        let termination = (1.0 - survival).max(MIN_TERMINATION);
        self.throughput /= 1.0 - termination;
        (choice() >= termination).then_some(())
    }
}
