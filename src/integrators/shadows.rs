//! Shadow rays that wait to be traced together, and what arrives along those that meet nothing.

use crate::accel::ClosestHit;
use crate::math::ray::Ray;
use crate::world::World;
use arrayvec::ArrayVec;

/// Rays that can wait.
const ROOM: usize = 256;

/// What waits is added to what paths have collected in the order in which it came. `G`: what is gained if nothing blocks a ray.
pub(super) struct Shadows<G> {
    rays: ArrayVec<Ray, ROOM>,
    gains: ArrayVec<G, ROOM>,
    /// What blocks the rays.
    found: [Option<ClosestHit>; ROOM],
}

impl<G> Default for Shadows<G> {
    fn default() -> Self {
        Shadows {
            rays: ArrayVec::new(),
            gains: ArrayVec::new(),
            found: [None; ROOM],
        }
    }
}

impl<G: Copy> Shadows<G> {
    /// Keeps a shadow ray. Returns `true` if the next one needs room: [`Shadows::trace`].
    #[inline(always)]
    pub(super) fn push(&mut self, shadow: &Ray, gain: G) -> bool {
        let _ = self.rays.try_push(*shadow);
        let _ = self.gains.try_push(gain);
        self.rays.is_full()
    }

    /// How many more rays can wait.
    pub(super) fn room(&self) -> usize {
        self.rays.remaining_capacity()
    }

    /// Traces all that wait.
    pub(super) fn trace(&mut self, world: &World, mut add: impl FnMut(&Ray, G)) {
        world.occluders(&self.rays, &mut self.found);
        for ((ray, &gain), found) in self.rays.iter().zip(&self.gains).zip(&self.found) {
            if found.is_none() {
                add(ray, gain);
            }
        }
        self.rays.clear();
        self.gains.clear();
    }
}
