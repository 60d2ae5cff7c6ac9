//! When light paths help a path tracer: its camera paths find all light of lights with an area, but that of a small one through
//! glass or off a mirror rarely. Joined by multiple importance sampling the expectation is the same.

use super::{
    Blocks, CHUNK, COST_OF_CAMERA, COST_OF_PATH, LightOfBlocks, Pilot, RARE, RenderJob,
    SHARE_OF_PILOT, Told, blocks_of_side, noise_of_camera, worth,
};

/// Light paths of a first look, as a part of the image's camera samples. Together with twice as many camera paths it takes less than
/// 2 % of the time.
const PART: f64 = 1.0 / 256.0;

/// Light paths for each camera sample that may be chosen: see [`super::LIGHT_SHARES`]. As the first look is at rare samples, not so few.
const SHARES: [f32; 4] = [0.25, 0.5, 1.0, 2.0];

/// With fewer of them nothing would be learned, and with more no more.
const PATHS: [u64; 2] = [1 << 10, 1 << 14];

/// Light paths are kept if they divide noise × time by at least this.
const MIN_GAIN: f64 = 1.5;

/// More is learned if the noise of rare samples of a path tracer alone is at least this part of the noise of helped samples, by the
/// first look. That finds little of it: with a lamp over a ball of glass a 30th to a 150th of what the second look finds.
const MIN_RARE: f64 = 0.03;

impl RenderJob {
    /// Returns `true` if paths from the lights may help a path tracer, and the image is large enough for it to be found out.
    pub fn may_be_assisted(&self) -> bool {
        self.integrator.may_be_assisted(&self.world)
            && self.camera.connects()
            && self.filter.is_continuous()
            && self.film.max_sample_luminance.is_infinite()
            && self.paths_of_look() >= PATHS[0]
    }

    fn paths_of_look(&self) -> u64 {
        let samples = self.lit().area() as f64 * f64::from(self.sampler.spp());
        (PART * samples) as u64
    }

    /// Lets light paths help a path tracer if that lowers noise × time. A pure function of scene and settings, whatever the seed is.
    pub fn consider_assistance(&mut self) {
        let count = self.paths_of_look().min(PATHS[1]);
        let side = (count as f64 * 0.5).sqrt() as u32;
        let mut pilot = Pilot {
            sampler: self.sampler.pilot(),
            blocks: Blocks::new(self.lit(), side),
        };
        let before = self.integrator.assist(&self.world);
        self.integrator.aim_emission(&self.world, count);
        self.light_share = SHARE_OF_PILOT;
        let helped = self.look(&pilot);
        let count = count.next_multiple_of(CHUNK);
        let brought = self.light(&pilot, 0..count);
        let mut lit = LightOfBlocks::default();
        lit.extend(&brought, count, self.paths_per_sample().into());
        let told = Told {
            brought: &brought,
            paths: count,
            blocks: &pilot.blocks,
            worth: &worth(&pilot.blocks, &helped, &lit),
            may_be_paired: false,
        };
        let least = noise_of_camera(&helped, 0.0, told.worth) * COST_OF_CAMERA;
        let rare = told.rare_alone(RARE) * COST_OF_PATH;
        self.integrator.leave_alone(before);
        if rare < MIN_RARE * least {
            return;
        }
        let noise = noise_of_camera(&self.look(&pilot), 0.0, told.worth);
        let before = self.integrator.assist(&self.world);
        pilot.blocks = Blocks::new(self.lit(), blocks_of_side(self.sampler.spp()));
        let helped = self.look(&pilot);
        let effort = self.guide_light_paths(&pilot, (&helped, 0.0), &SHARES);
        if (noise + effort.rare_alone) * COST_OF_PATH < MIN_GAIN * effort.least {
            self.integrator.leave_alone(before);
        }
    }
}
