//! What an integrator works with: a camera ray, the world, its lights and the samples.

use super::Seen;
use super::witness::{Met, Place, Watch};
use crate::lights::{LightGroups, LightSelector};
use crate::math::Rgb;
use crate::math::ray::{Ray, RayDifferentials};
use crate::samplers::SampleStream;
use crate::world::World;

/// The lights as integrators sample them.
#[derive(Debug)]
pub(super) struct Lights {
    /// For integrators of paths, which choose a light by its estimated contribution.
    pub selector: LightSelector,
    /// For `directlighting` and `whitted`, which sample every light or any.
    pub groups: LightGroups,
}

/// All that the radiance along a camera ray depends on, besides the integrator.
pub(super) struct Context<'a> {
    pub world: &'a World,
    pub lights: &'a Lights,
    pub stream: &'a mut SampleStream,
    /// The camera ray.
    pub ray: Ray,
    pub differentials: Option<&'a RayDifferentials>,
    /// Where the ray comes from.
    #[allow(dead_code)]
    pub seen: &'a Seen<'a>,
    /// For samples that are traced again because they were not finite.
    pub watch: Option<&'a mut Watch>,
}

impl Context<'_> {
    /// Reports a vertex after `depth` scattering events, with the `radiance` collected before it.
    #[inline(always)]
    pub(super) fn arrive(&mut self, depth: u32, met: Met, radiance: Rgb) {
        if let Some(watch) = &mut self.watch {
            watch.arrive(Place { depth, met }, radiance);
        }
    }
}
