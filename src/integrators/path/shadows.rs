//! Shadow rays that wait to be traced together, and what arrives along those that meet nothing.

use crate::accel::ClosestHit;
use crate::handles::LightId;
use crate::math::Rgb;
use crate::math::ray::Ray;
use crate::world::World;
use arrayvec::ArrayVec;

/// Rays that can wait.
const ROOM: usize = 256;

/// Light that a path gains if nothing blocks a shadow ray.
#[derive(Clone, Copy)]
pub(super) struct Gain {
    pub path: u32,
    /// Where it comes from.
    pub from: LightId,
    pub light: Rgb,
}

/// What waits is added to what paths have collected in the order in which it came.
pub(super) struct Shadows {
    rays: ArrayVec<Ray, ROOM>,
    gains: ArrayVec<Gain, ROOM>,
    /// What blocks the rays.
    found: [Option<ClosestHit>; ROOM],
}

impl Default for Shadows {
    fn default() -> Self {
        Shadows {
            rays: ArrayVec::new(),
            gains: ArrayVec::new(),
            found: [None; ROOM],
        }
    }
}

impl Shadows {
    /// Keeps a shadow ray. Returns `true` if the next one needs room: [`Shadows::trace`].
    #[inline(always)]
    pub(super) fn push(&mut self, shadow: &Ray, gain: Gain) -> bool {
        let _ = self.rays.try_push(*shadow);
        let _ = self.gains.try_push(gain);
        self.rays.is_full()
    }

    /// Traces all that wait.
    pub(super) fn trace(&mut self, world: &World, mut add: impl FnMut(Gain)) {
        world.occluders(&self.rays, &mut self.found);
        for (&gain, found) in self.gains.iter().zip(&self.found) {
            if found.is_none() {
                add(gain);
            }
        }
        self.rays.clear();
        self.gains.clear();
    }
}
