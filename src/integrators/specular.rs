//! The tree of perfectly specular paths that `directlighting` and `whitted` follow: at every hit
//! the reflected and the refracted ray. Traversed with an explicit stack, so that no `maxdepth` can exhaust
//! the thread's.

use super::witness::Met;
use super::{Context, MAX_NULL_SURFACES, Sight, differentials};
use crate::accel::GeometryHit;
use crate::bsdf::Bsdf;
use crate::math::ray::{Ray, RayDifferentials};
use crate::math::{Rgb, color::is_black};
use crate::samplers::SampleStream;
use crate::surface::SurfaceHit;

/// Recursion levels that are always followed in full; Russian roulette applies to deeper ones, or two glass surfaces
/// would double the work with every level.
const FULL_LEVELS: u32 = 8;

struct Branch {
    ray: Ray,
    differentials: Option<RayDifferentials>,
    throughput: Rgb,
    level: u32,
    nulls: u32,
}

/// Those that are still to be followed.
struct Branches {
    next: Option<Branch>,
    pending: arrayvec::ArrayVec<Branch, 64>,
}

impl Branches {
    fn add(&mut self, branch: Branch) {
        if self.next.is_none() {
            self.next = Some(branch);
        } else if !self.pending.is_full() {
            // Only absurd depths would fill 64 pending branches, and Russian roulette prunes those long before.
            self.pending.push(branch);
        }
    }

    fn take(&mut self) -> Option<Branch> {
        self.next.take().or_else(|| self.pending.pop())
    }
}

/// Sums emission and `direct_light`, which is called at hits with lobes that are not perfectly specular, over the
/// specular tree, down to `max_depth` levels (the camera ray's hit is the first).
pub(super) fn trace(
    mut context: Context,
    max_depth: u32,
    mut direct_light: impl FnMut(&mut Context, &SurfaceHit, &Bsdf) -> Rgb,
) -> Rgb {
    let world = context.world;
    let mut radiance = Rgb::ZERO;
    let mut branches = Branches {
        next: Some(Branch {
            ray: *context.ray(),
            differentials: context.differentials.copied(),
            throughput: Rgb::ONE,
            level: 0,
            nulls: 0,
        }),
        pending: Default::default(),
    };
    while let Some(branch) = branches.take() {
        let depth = branch.level;
        let wants_uv = depth == 0 && context.wants_parameters();
        let Some(hit) = world.intersect_with(&branch.ray, wants_uv) else {
            context.arrive(depth, Met::Background, radiance);
            radiance += escape(&mut context, &branch);
            continue;
        };
        context.arrive(depth, Met::Surface(hit.material), radiance);
        let Some(material) = world.material(hit.material) else {
            branches.next = beyond(branch, &hit);
            continue;
        };
        let mut bsdf = Bsdf::empty();
        let differentials = branch.differentials.as_ref();
        world.fill_bsdf(material, &hit.surface, differentials, &mut bsdf);
        if depth == 0
            && let Some((sight, numbers)) = context.sight()
        {
            let scattering = (&bsdf, material.has_interior());
            sight.meet_alone(world, (&branch.ray, &hit), scattering, numbers);
        }
        context.scale_parts(branch.throughput);
        let direct = match bsdf.has_non_specular() {
            true => direct_light(&mut context, &hit.surface, &bsdf),
            false => Rgb::ZERO,
        };
        let emitted = world.emitted_radiance(&hit);
        context.part(hit.light, emitted);
        radiance += branch.throughput * (emitted + direct);
        if branch.level + 1 >= max_depth || !bsdf.has_specular() {
            continue;
        }
        for transmit in [false, true] {
            let child = scatter(&hit, &bsdf, &branch, transmit, context.stream);
            child.into_iter().for_each(|child| branches.add(child));
        }
    }
    radiance
}

/// What a ray brings that meets nothing.
fn escape(context: &mut Context, branch: &Branch) -> Rgb {
    if branch.level == 0 {
        context.look(Sight::escape);
    }
    context.scale_parts(branch.throughput);
    let d = branch.ray.d;
    context.parts_at_infinity(|context, id| context.world.light(id).escaped(d));
    branch.throughput * context.world.escaped_radiance(&branch.ray)
}

/// The ray through a surface without material, if there have not been too many.
fn beyond(branch: Branch, hit: &GeometryHit) -> Option<Branch> {
    (branch.nulls < MAX_NULL_SURFACES).then(|| Branch {
        ray: hit.surface.spawn_ray(branch.ray.d),
        // As in pbrt-v3 (docs/scene-language.md §4.3).
        differentials: None,
        nulls: branch.nulls + 1,
        ..branch
    })
}

/// The specular ray that leaves a hit on one side, if there is one and it survives Russian roulette.
fn scatter(
    hit: &GeometryHit,
    bsdf: &Bsdf,
    branch: &Branch,
    transmit: bool,
    stream: &mut SampleStream,
) -> Option<Branch> {
    let sample = bsdf.sample_specular(hit.surface.wo, transmit, stream.next_1d())?;
    let cosine = sample.wi.dot(bsdf.shading_normal()).abs();
    let mut throughput = branch.throughput * sample.f * (cosine / sample.pdf);
    if is_black(throughput) || !throughput.is_finite() {
        return None;
    }
    let level = branch.level + 1;
    if level >= FULL_LEVELS {
        let survive = throughput.max_element().clamp(0.05, 1.0) * 0.5;
        if stream.next_1d() >= survive {
            return None;
        }
        throughput /= survive;
    }
    let arriving = branch.differentials.as_ref();
    Some(Branch {
        ray: hit.surface.spawn_ray(sample.wi),
        differentials: arriving
            .map(|arriving| differentials::scattered(arriving, &hit.surface, bsdf, &sample)),
        throughput,
        level,
        nulls: 0,
    })
}
