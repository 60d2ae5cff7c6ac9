//! Many camera paths side by side, whose rays are traced together. Nothing that a path brings depends on the others, and all bits are those
//! of one path at a time.

use super::Bdpt;
use super::camera_path::{CameraPath, Gain, Trail};
use super::light_path::LightPath;
use crate::accel::ClosestHit;
use crate::integrators::context::{Bundle, WAVE};
use crate::integrators::shadows::Shadows;
use crate::math::Rgb;
use crate::math::ray::Ray;
use crate::world::World;
use arrayvec::ArrayVec;

/// Paths on their way.
struct Wave {
    /// By path.
    trails: ArrayVec<Trail, WAVE>,
    /// The paths that go on.
    walking: ArrayVec<u32, WAVE>,
    shadows: Shadows<Gain>,
}

/// The radiance along each path of the bundle. Those that are joined to light paths go by themselves.
pub(super) fn radiances(bdpt: &Bdpt, mut bundle: Bundle, out: &mut ArrayVec<Rgb, WAVE>) {
    let mut wave = Wave {
        trails: ArrayVec::new(),
        walking: ArrayVec::new(),
        shadows: Shadows::default(),
    };
    for path in 0..bundle.paths.len().min(WAVE) {
        let context = bundle.context(path);
        let mut trail = Trail::new(&context);
        if bdpt.joins(context.stream) {
            [trail.radiance, trail.joined] = bdpt.parts(context, true);
        } else {
            wave.walking.push(path as u32);
        }
        wave.trails.push(trail);
    }
    let mut is_first = true;
    while !wave.walking.is_empty() {
        wave.extend(bdpt, &mut bundle, is_first);
        is_first = false;
    }
    out.extend(
        wave.trails
            .iter()
            .map(|trail| trail.radiance + trail.joined),
    );
}

impl Wave {
    /// Extends all paths by a vertex.
    fn extend(&mut self, bdpt: &Bdpt, bundle: &mut Bundle, is_first: bool) {
        let world = bundle.world;
        let waits = shadows_may_wait(world);
        let mut found = [None; WAVE];
        self.closest(world, &mut found);
        let light_path = LightPath::default();
        for (path, found) in std::mem::take(&mut self.walking).into_iter().zip(found) {
            let trail = &mut self.trails[path as usize];
            let hit = found.and_then(|found| world.surface(&trail.walk.ray, &found));
            let mut context = bundle.context(path as usize);
            let mut state = CameraPath {
                bdpt,
                differentials: context.differentials.filter(|_| is_first),
                context: &mut context,
                trail,
                light_path: &light_path,
                waiting: waits.then_some((&mut self.shadows, path)),
            };
            if state.arrive_at(hit.as_ref()).is_some() {
                self.walking.push(path);
            }
        }
        let trails = &mut self.trails;
        self.shadows.trace(world, |gain| {
            let mut context = bundle.context(gain.path as usize);
            let mut state = CameraPath {
                bdpt,
                differentials: None,
                context: &mut context,
                trail: &mut trails[gain.path as usize],
                light_path: &light_path,
                waiting: None,
            };
            state.gain_unblocked(&gain);
        });
    }

    /// What the paths hit.
    fn closest(&self, world: &World, found: &mut [Option<ClosestHit>; WAVE]) {
        let ray = |&path: &u32| self.trails[path as usize].walk.ray;
        let rays: ArrayVec<Ray, WAVE> = self.walking.iter().map(ray).collect();
        world.closest(&rays, &mut found[..rays.len()]);
    }
}

/// Returns `true` if shadow rays may be traced after what comes next on their path: no path comes to two vertices in one step, and none of its
/// numbers is drawn for them.
fn shadows_may_wait(world: &World) -> bool {
    !world.has_recoverable_surfaces() && !world.has_interiors() && !world.media.are_estimated()
}
