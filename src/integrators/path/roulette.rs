//! Russian roulette: ends paths of low throughput and scales up the others (Arvo and Kirk 1990; Pharr, Jakob and
//! Humphreys 2016, §13.7 and §14.5.4).

use super::Trail;
use super::emission::MisState;

/// Scattering events after which the survival probability is the throughput (pbrt-v3: bounce counter > 3).
const MIN_BOUNCES: u32 = 3;

/// Before that many bounces the survival probability is scaled by this factor, so that only very dim paths are terminated
/// early, as in foliage, where they cost two fifths of the time and add no visible noise (docs/notes/performance.md).
const EARLY_SCALE: f32 = 4.0;

/// Early roulette applies only to broad lobes: pdf ≤ 1/sr, three times a diffuse lobe's peak. What emitter sampling misses
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
            _ if late => 1.0,
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
