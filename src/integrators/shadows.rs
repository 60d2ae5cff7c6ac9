//! Shadow rays that wait to be traced together, and what arrives along those that meet nothing.

use crate::accel::{ClosestHit, Passage};
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
        self.clear();
    }

    /// Traces all that wait, for light that surfaces without material let pass: see [`unblocked`].
    pub(super) fn trace_through(
        &mut self,
        world: &World,
        mut add: impl FnMut(&Ray, G, Option<&mut Passage>),
    ) {
        unblocked::<16>(world, &self.rays, &mut self.found, |i, passage| {
            add(&self.rays[i], self.gains[i], passage);
        });
        self.clear();
    }

    fn clear(&mut self) {
        self.rays.clear();
        self.gains.clear();
    }
}

/// Calls `pass` with the number of each ray that nothing with a material blocks, and with what it passes if there are surfaces without one in
/// the scene; so many are traced `TOGETHER` there. `found` has at least as many places as there are rays.
#[inline(always)]
pub(super) fn unblocked<const TOGETHER: usize>(
    world: &World,
    rays: &[Ray],
    found: &mut [Option<ClosestHit>],
    mut pass: impl FnMut(usize, Option<&mut Passage>),
) {
    if !world.has_recoverable_surfaces() {
        world.occluders(rays, &mut found[..rays.len()]);
        for (i, found) in found[..rays.len()].iter().enumerate() {
            if found.is_none() {
                pass(i, None);
            }
        }
        return;
    }
    for (group, rays) in rays.chunks(TOGETHER).enumerate() {
        let mut passages: [Passage; TOGETHER] = std::array::from_fn(|_| Passage::default());
        let found = &mut found[..rays.len()];
        world.passages(rays, (found, &mut passages[..rays.len()]));
        for (i, (found, passage)) in found.iter().zip(&mut passages).enumerate() {
            if found.is_none() {
                pass(group * TOGETHER + i, Some(passage));
            }
        }
    }
}
