//! How many rays get through, for several ways to sample the pupil.

use super::illumination::spread;
use crate::math::Vec2;
use crate::math::sampling::concentric_disk;
use crate::optics::lens::Lens;
use crate::optics::pupil::ExitPupil;
use serde::Serialize;

/// Parts of the rays from one film height that get through the lens, from 0 to 1.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct PassFractions {
    /// From the axis, mm.
    pub height: f64,
    /// Aimed evenly at the disk of the rear element, as the course does.
    pub rear_element: f64,
    /// Aimed evenly at the paraxial exit pupil (which misses part of the light off the axis); `None` for a pupil at infinity.
    pub exit_pupil: Option<f64>,
    /// Aimed evenly at the box on the rear vertex plane that bounds the light of the ring of film radii, as pbrt-v3
    /// does (Physically Based Rendering, 3rd edition, §6.4.5).
    pub bounding_box: f64,
    /// Aimed as fstop does.
    pub fstop: f64,
}

/// Rings of film radii, as pbrt has.
const RINGS: usize = 64;

/// Film heights in the table.
const HEIGHTS: u32 = 9;

/// From the middle of the film to `corner` mm.
pub fn over_the_field(
    lens: &Lens,
    pupil: &ExitPupil,
    corner: f64,
    samples: u32,
) -> Vec<PassFractions> {
    (0..HEIGHTS)
        .map(|i| corner * f64::from(i) / f64::from(HEIGHTS - 1))
        .map(|height| at(lens, pupil, corner, height, samples))
        .collect()
}

fn at(lens: &Lens, pupil: &ExitPupil, corner: f64, height: f64, samples: u32) -> PassFractions {
    let disk = |u: Vec2, radius: f64, z: f64| {
        let p = concentric_disk(u).as_dvec2() * radius;
        Some([p.x, p.y, z])
    };
    let rear = lens.rear().clear_radius();
    let bounds = pbrt_box(lens, corner, height);
    PassFractions {
        height,
        rear_element: passed(lens, height, samples, |u| disk(u, rear, lens.length())),
        exit_pupil: lens
            .paraxial()
            .exit_pupil
            .map(|p| passed(lens, height, samples, |u| disk(u, 0.5 * p.diameter, p.z))),
        bounding_box: bounds.map_or(0.0, |b| {
            passed(lens, height, samples, |u| {
                let at =
                    |axis: usize, u: f32| b[axis][0] + f64::from(u) * (b[axis][1] - b[axis][0]);
                Some([at(0, u.x), at(1, u.y), lens.length()])
            })
        }),
        fstop: passed(lens, height, samples, |u| {
            pupil.sample([0.0, height], u).map(|s| s.point)
        }),
    }
}

/// The part of the rays from film height `height` toward the points `aim` that gets through.
fn passed(lens: &Lens, height: f64, samples: u32, aim: impl Fn(Vec2) -> Option<[f64; 3]>) -> f64 {
    let passed = spread(samples)
        .filter_map(aim)
        .filter(|p| lens.trace_from_film([0.0, height], *p).is_ok())
        .count();
    passed as f64 / f64::from(samples.max(1))
}

/// The box of pbrt-v3 for the ring of film radii that holds `height`: around what passes of a square of points one and
/// a half times as large as the rear element, seen from anywhere in the ring, and larger by twice their spacing.
fn pbrt_box(lens: &Lens, corner: f64, height: f64) -> Option<[[f64; 2]; 2]> {
    let ring = ((height / corner * RINGS as f64) as usize).min(RINGS - 1);
    let reach = 1.5 * lens.rear().clear_radius();
    // pbrt takes 1024² random points; a grid of 192² finds the edges as well, and the margin is pbrt's.
    let across = 192;
    let at = |i: usize| reach * (2.0 * (i as f64 + 0.5) / across as f64 - 1.0);
    let mut bounds = [[f64::INFINITY, f64::NEG_INFINITY]; 2];
    for i in 0..across * across {
        let p = [at(i % across), at(i / across)];
        let part = (i as f64 * 0.618_033_988_749_895).fract();
        let film = [0.0, corner * (ring as f64 + part) / RINGS as f64];
        if lens
            .trace_from_film(film, [p[0], p[1], lens.length()])
            .is_ok()
        {
            for (range, x) in bounds.iter_mut().zip(p) {
                *range = [range[0].min(x), range[1].max(x)];
            }
        }
    }
    let margin = 2.0 * (2.0 * reach * std::f64::consts::SQRT_2) / 1024.0;
    bounds
        .iter()
        .all(|[low, high]| low <= high)
        .then(|| bounds.map(|[low, high]| [low - margin, high + margin]))
}
