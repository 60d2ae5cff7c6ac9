//! Traced rays to fit models to.

use super::shape::{PupilShape, RADII};
use crate::optics::lens::Lens;
use crate::optics::trace::LensRay;

/// A ray that passes the lens.
#[derive(Clone, Copy, Debug)]
pub struct FitRay {
    /// Film point, mm.
    pub film: [f64; 2],
    /// Point of the plane aimed at, mm.
    pub pupil: [f64; 2],
    /// In the scene.
    pub scene: LensRay<f64>,
}

/// Circles of pupil points around each film point's middle.
const CIRCLES: usize = 8;

/// Directions over half a turn; the mirror image says the same again.
const DIRECTIONS: usize = 12;

/// Rays from the film points (r, 0) with r at each of the shape's film radii, evenly spread over the
/// pupil and out to its very edge: one list for each film radius, empty where it is dark.
pub fn fit_rays(
    lens: &Lens,
    film_radius: f64,
    plane_z: f64,
    shape: &PupilShape<f64>,
) -> Vec<Vec<FitRay>> {
    (0..=RADII)
        .map(|i| {
            let film = [film_radius * i as f64 / RADII as f64, 0.0];
            pupil_points(shape, i)
                .filter_map(|pupil| {
                    let scene = lens.trace_from_film(film, [pupil[0], pupil[1], plane_z]);
                    scene.ok().map(|scene| FitRay { film, pupil, scene })
                })
                .collect()
        })
        .collect()
}

/// The middle, and circles of equal area between them up to just inside the edge.
fn pupil_points(shape: &PupilShape<f64>, i: usize) -> impl Iterator<Item = [f64; 2]> {
    let middle = shape.middle(i);
    let circles = (0..CIRCLES * (DIRECTIONS + 1)).map(move |k| {
        let (circle, direction) = (k / (DIRECTIONS + 1) + 1, k % (DIRECTIONS + 1));
        let angle = std::f64::consts::PI * direction as f64 / DIRECTIONS as f64;
        // 0.1 % short of the edge, which lies just outside and between two measured directions.
        let part = (circle as f64 / CIRCLES as f64).sqrt() * 0.999;
        let reach = part * shape.reach(i, angle);
        [middle + reach * angle.cos(), reach * angle.sin()]
    });
    std::iter::once([middle, 0.0]).chain(circles)
}
