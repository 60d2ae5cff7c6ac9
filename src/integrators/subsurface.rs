//! Subsurface scattering: from the point where a path enters a material to the one where it leaves
//! (Pharr, Jakob and Humphreys 2016, §15.4).

use crate::accel::GeometryHit;
use crate::bsdf::{Bsdf, Lobe};
use crate::bssrdf::{Bssrdf, Probe};
use crate::math::Rgb;
use crate::math::color::is_black;
use crate::math::float::offset_ray_origin;
use crate::math::ray::Ray;
use crate::samplers::SampleStream;
use crate::surface::SurfaceHit;
use crate::world::World;

/// The most surfaces along one probe: more are a modelling error.
const MAX_CROSSINGS: u32 = 4096;

/// The point where a path leaves a material.
pub(super) struct Exit {
    /// The point; the `wo` of its surface is its shading normal: the direction inside does not matter.
    pub hit: GeometryHit,
    /// How it scatters light from outside.
    pub bsdf: Bsdf<'static>,
    /// What the path's throughput is multiplied by.
    pub weight: Rgb,
}

/// Samples a point where the path leaves the material that it entered at `entry`; `None`
/// where it does not.
///
/// Among the surfaces of the same material along a probe ray one is chosen uniformly by reservoir sampling: the k-th
/// replaces the one kept so far with probability 1/k.
pub(super) fn find_exit(
    world: &World,
    stream: &mut SampleStream,
    bssrdf: &Bssrdf,
    entry: &GeometryHit,
) -> Option<Exit> {
    let (uc, u) = (stream.next_1d(), stream.next_2d());
    let probe = bssrdf.probe(uc, u)?;
    let (mut kept, mut found, mut choice) = (None, 0u32, probe.choice);
    visit(world, &probe, entry.surface.time, |hit| {
        if hit.material == entry.material {
            found += 1;
            let probability = 1.0 / found as f32;
            if choice < probability {
                kept = Some(*hit);
                choice /= probability;
            } else {
                choice = (choice - probability) / (1.0 - probability);
            }
        }
    });
    let mut hit: GeometryHit = kept?;
    let surface = &mut hit.surface;
    let pdf = bssrdf.pdf(surface.p, surface.n) / found as f32;
    let weight = bssrdf.value(surface.p) / pdf;
    if !weight.is_finite() || is_black(weight) {
        return None;
    }
    surface.wo = surface.shading.n;
    let mut bsdf = Bsdf::new(surface.n, &surface.shading);
    bsdf.add(Lobe::SubsurfaceExit(bssrdf.exit()));
    Some(Exit { hit, bsdf, weight })
}

/// Visits all surfaces along a probe.
fn visit(world: &World, probe: &Probe, time: f32, mut meet: impl FnMut(&GeometryHit)) {
    let end = probe.o + probe.length * probe.d;
    let mut ray = Ray {
        t_max: probe.length,
        ..Ray::new(probe.o, probe.d, time)
    };
    for _ in 0..MAX_CROSSINGS {
        let Some(hit) = world.intersect(&ray) else {
            return;
        };
        meet(&hit);
        let SurfaceHit { p, p_error, n, .. } = hit.surface;
        ray.o = offset_ray_origin(p, p_error, n, probe.d);
        ray.t_max = (end - ray.o).dot(probe.d);
        if ray.t_max <= 0.0 {
            return;
        }
    }
}
