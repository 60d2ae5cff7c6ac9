//! Shadow rays that wait to be traced together, and what arrives along those that meet nothing.

use crate::accel::ClosestHit;
use crate::math::Rgb;
use crate::math::ray::Ray;
use crate::world::World;
use arrayvec::ArrayVec;

/// Rays that can wait.
const ROOM: usize = 256;

/// What waits is added to what paths have collected in the order in which it came.
#[derive(Default)]
pub(super) struct Shadows {
    rays: ArrayVec<Ray, ROOM>,
    /// The path, and the light that it gains.
    gains: ArrayVec<(u32, Rgb), ROOM>,
}

impl Shadows {
    /// Path `path` gains `light`, if nothing blocks the `shadow` ray. Returns `true` if the next one needs room: [`Shadows::trace`].
    #[inline(always)]
    pub(super) fn push(&mut self, path: u32, shadow: &Ray, light: Rgb) -> bool {
        let _ = self.rays.try_push(*shadow);
        let _ = self.gains.try_push((path, light));
        self.rays.is_full()
    }

    /// Traces all that wait: `add(path, light)`.
    pub(super) fn trace(&mut self, world: &World, mut add: impl FnMut(u32, Rgb)) {
        let mut found: [Option<ClosestHit>; ROOM] = [None; ROOM];
        world.occluders(&self.rays, &mut found);
        for (&(path, light), found) in self.gains.iter().zip(&found) {
            if found.is_none() {
                add(path, light);
            }
        }
        self.rays.clear();
        self.gains.clear();
    }
}
