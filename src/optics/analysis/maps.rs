//! Where a lens puts what a pinhole would put elsewhere, and how bright: maps for compositing.
//!
//! The pinhole is the one that shows what the lens does near its axis: at the entrance pupil, and as far from the film as
//! [`Lens::pinhole_focal_length`]. Both look at the same object plane; nearer and farther things a pinhole sees from one point and a
//! lens, whose pupil moves with the field, does not quite. The lens' image of a point is where its chief ray lands.

use super::chief::ChiefFinder;
use super::field::ReferenceScale;
use super::film::Film;
use super::illumination::projected_solid_angle;
use super::object::ObjectPlane;
use crate::optics::bisection::bisect;
use crate::optics::lens::Lens;
use crate::optics::pupil::{ExitPupil, RINGS};

/// A factor by distance from the axis, even about it.
#[derive(Clone, Debug, PartialEq)]
pub struct RadialFactor {
    /// Between nodes, mm.
    step: f64,
    /// At 0, one step, two steps …; at least two.
    nodes: Vec<f64>,
}

impl RadialFactor {
    /// The factor at `radius` mm; `None` beyond where it is known.
    pub fn at(&self, radius: f64) -> Option<f64> {
        let last = self.nodes.len() - 1;
        let place = radius.abs() / self.step;
        if place.is_nan() || place > last as f64 {
            return None;
        }
        let i = (place.floor() as usize).min(last - 1);
        let node = |k: isize| {
            // Beyond the axis the other side; beyond the end as it continued.
            let k = k.unsigned_abs();
            match self.nodes.get(k) {
                Some(node) => *node,
                None => 2.0 * self.nodes[last] - self.nodes[last - 1],
            }
        };
        let i = i as isize;
        let [a, b, c, d] = [node(i - 1), node(i), node(i + 1), node(i + 2)];
        // Lagrange's cubic through four nodes.
        let t = place - i as f64;
        let (s, u, w) = (t + 1.0, t - 1.0, t - 2.0);
        Some(-a * t * u * w / 6.0 + b * s * u * w / 2.0 - c * s * t * w / 2.0 + d * s * t * u / 6.0)
    }

    /// The radius times its factor.
    fn scaled(&self, radius: f64) -> Option<f64> {
        Some(radius * self.at(radius)?)
    }

    /// How far out it is known, mm.
    pub fn reach(&self) -> f64 {
        self.step * (self.nodes.len() - 1) as f64
    }
}

/// What compositing asks of a lens.
#[derive(Clone, Debug, PartialEq)]
pub struct LensMaps {
    /// From a distance from the axis in the lens' image to that in the pinhole's.
    pub to_pinhole: RadialFactor,
    /// From one in the pinhole's image to that in the lens'.
    pub to_lens: RadialFactor,
}

/// Nodes over the film's diagonal and half as much again: interpolation between them is good to 1e-4 of a pixel of 24 million, of a
/// fisheye of 150° too.
const NODES: usize = 768;
/// How much farther than the corner of the film maps are known: a lens with barrel distortion shows more than the pinhole's image
/// holds, one with pincushion distortion less.
const BEYOND: f64 = 1.5;

impl LensMaps {
    /// Of `lens` before `film`, looking at `object`; `None` of a lens without chief rays near its axis.
    pub fn new(lens: &Lens, film: Film, object: ObjectPlane) -> Option<LensMaps> {
        LensMaps::with_nodes(lens, film, object, NODES)
    }

    /// The same with another number of nodes, at least one, each of which costs a search for a chief ray.
    pub(super) fn with_nodes(
        lens: &Lens,
        film: Film,
        object: ObjectPlane,
        count: usize,
    ) -> Option<LensMaps> {
        let chief = ChiefFinder::new(lens);
        let corner = 0.5 * film.diagonal();
        let scale = ReferenceScale::new(&chief, object, corner);
        let step = BEYOND * corner / count as f64;
        let mut nodes = vec![1.0];
        let mut farthest = 0.0;
        for i in 1..=count {
            let height = step * i as f64;
            let found = chief.find(height);
            let ideal = found
                .filter(|ray| ray.ray.d[2] < 0.0)
                .map(|ray| scale.ideal_height(&ray));
            // Up to where it turns back, or looks sideways.
            let Some(ideal) = ideal.filter(|x| x.is_finite() && *x > farthest) else {
                break;
            };
            farthest = ideal;
            nodes.push(ideal / height);
        }
        if nodes.len() < 2 {
            return None;
        }
        let to_pinhole = RadialFactor { step, nodes };
        let to_lens = inverse(&to_pinhole, farthest.min(2.0 * BEYOND * corner));
        Some(LensMaps {
            to_pinhole,
            to_lens,
        })
    }
}

/// The factor that takes back what `map` does, for results up to `farthest`.
fn inverse(map: &RadialFactor, farthest: f64) -> RadialFactor {
    let step = farthest / NODES as f64;
    let node = |i: usize| {
        let wanted = step * i as f64;
        let short = |r: f64| map.scaled(r).is_some_and(|found| found < wanted);
        // 60 halvings leave nothing of the interval.
        let [low, high] = bisect([0.0, map.reach()], 60, short);
        0.5 * (low + high) / wanted
    };
    let first = std::iter::once(1.0 / map.nodes[0]);
    RadialFactor {
        step,
        nodes: first.chain((1..=NODES).map(node)).collect(),
    }
}

/// Irradiance over that in the middle of the film, by distance from the axis; `None` for a lens that is dark there.
pub fn shading(lens: &Lens, film: Film) -> Option<RadialFactor> {
    /// Vignetting begins within one of them.
    const NODES: usize = 128;
    const SAMPLES: u32 = 1 << 13;
    // The corner itself must lie within the last ring.
    let corner = 0.5 * film.diagonal() * (1.0 + 1e-6);
    let pupil = ExitPupil::new(lens, corner, RINGS);
    let step = corner / NODES as f64;
    let at = |i: usize| projected_solid_angle(lens, &pupil, step * i as f64, SAMPLES);
    let middle = at(0);
    let nodes = (0..=NODES).map(|i| at(i) / middle).collect();
    (middle > 0.0).then_some(RadialFactor { step, nodes })
}

/// The pixels of an image on a film.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Raster {
    /// Pixels across and down.
    pub size: [usize; 2],
    /// What they cover.
    pub film: Film,
}

impl Raster {
    /// Of `size` pixels, which are square, over a film of this diagonal, mm.
    pub fn new(size: [usize; 2], diagonal: f64) -> Raster {
        let [width, height] = size.map(|n| n as f64);
        let pitch = diagonal / width.hypot(height);
        let film = Film {
            width: pitch * width,
            height: pitch * height,
        };
        Raster { size, film }
    }

    /// The middle of the pixel in this column and row, row 0 at the top: mm to the right and up from the middle of the image.
    pub fn place(&self, [column, row]: [usize; 2]) -> [f64; 2] {
        let part = |i: usize, n: usize| (i as f64 + 0.5) / n as f64 - 0.5;
        [
            part(column, self.size[0]) * self.film.width,
            -part(row, self.size[1]) * self.film.height,
        ]
    }

    /// A place as a part of the image's width and height, from its lower left corner: what an STMap holds.
    pub fn st(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        [0.5 + x / self.film.width, 0.5 + y / self.film.height]
    }

    /// Where the image comes from that `map` makes of this pixel, as an STMap says it; `None` where it is not known.
    pub fn source(&self, map: &RadialFactor, pixel: [usize; 2]) -> Option<[f64; 2]> {
        let [x, y] = self.place(pixel);
        let factor = map.at(x.hypot(y))?;
        Some(self.st([factor * x, factor * y]))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::Vec2;
    use crate::optics::Prescription;

    fn golden(name: &str, stop: f64) -> Lens {
        let file = format!("{}/tests/golden/{name}.dat", env!("CARGO_MANIFEST_DIR"));
        let mut p = Prescription::read(file.as_ref()).unwrap();
        p.set_stops(stop);
        Lens::new(&p, Lens::focused(&p, f64::INFINITY).unwrap()).unwrap()
    }

    /// Rays of a narrow stop, found by sampling the exit pupil and not by chief rays, come from where the map says that their pixel does:
    /// to 0.02 pixels of 24 million, 0.12 µm.
    #[test]
    fn warped_pinhole_points_land_on_the_lens_picture() {
        for (name, fields) in [
            ("dgauss_50", 1.0),
            ("retrofocus_35", 1.0),
            ("canon_uw_14", 0.8),
            ("fisheye_10", 0.55),
        ] {
            let lens = golden(name, 0.1);
            let raster = Raster::new([6000, 4000], Film::FULL_FRAME.diagonal());
            let pixel = raster.film.width / 6000.0;
            let maps = LensMaps::new(&lens, raster.film, ObjectPlane::INFINITY).unwrap();
            let pinhole = lens.pinhole_focal_length().unwrap();
            let pupil = ExitPupil::new(&lens, 22.0, RINGS);
            for i in 1..40 {
                let height = fields * 21.6 * f64::from(i) / 40.0;
                // The mean direction of the rays that get through.
                let (mut slope, mut count) = (0.0, 0.0);
                for k in 0..256 {
                    let u = Vec2::new((k % 16) as f32 / 16.0 + 0.03, (k / 16) as f32 / 16.0 + 0.03);
                    let Some(sample) = pupil.sample([0.0, height], u) else {
                        continue;
                    };
                    if let Ok(ray) = lens.trace_from_film([0.0, height], sample.point) {
                        slope += ray.d[1] / ray.d[2];
                        count += 1.0;
                    }
                }
                assert!(count > 50.0, "{name} {height}: {count}");
                let there = pinhole * slope / count;
                let mapped = height * maps.to_pinhole.at(height).unwrap();
                // In the pinhole's image, and back in the lens' where lengths are other ones.
                assert!(
                    (mapped - there).abs() < 0.02 * pixel * (there / height).max(1.0),
                    "{name} {height}: {mapped} {there}"
                );
                if let Some(factor) = maps.to_lens.at(mapped) {
                    let back = factor * mapped;
                    assert!(
                        (back - height).abs() < 1e-3 * pixel,
                        "{name} {height}: {back}"
                    );
                }
            }
        }
    }

    #[test]
    fn an_stmap_without_distortion_has_the_middles_of_its_pixels() {
        // A hole: nothing is bent.
        let lens = Lens::new(&Prescription::parse("0 0 0 0.01\n").unwrap(), 30.0).unwrap();
        let raster = Raster::new([6, 4], 43.2);
        let maps = LensMaps::new(&lens, raster.film, ObjectPlane::INFINITY).unwrap();
        for map in [&maps.to_pinhole, &maps.to_lens] {
            for (pixel, expected) in [
                ([0, 3], [0.5 / 6.0, 0.5 / 4.0]),
                ([5, 0], [5.5 / 6.0, 3.5 / 4.0]),
            ] {
                let found = raster.source(map, pixel).unwrap();
                assert!(
                    (0..2).all(|i| (found[i] - expected[i]).abs() < 1e-9),
                    "{pixel:?} {found:?}"
                );
            }
        }
        // It darkens by the fourth power of the cosine: at 21.6 mm of 30.
        let dark = shading(&lens, raster.film).unwrap();
        let cosine2 = 1.0 / (1.0 + 0.72f64.powi(2));
        assert!((dark.at(21.6).unwrap() - cosine2 * cosine2).abs() < 2e-3);
        assert!((dark.at(0.0).unwrap() - 1.0).abs() < 1e-12);
        assert_eq!(dark.at(25.0), None);
    }

    #[test]
    fn interpolation_is_exact_for_cubics_and_even_at_the_axis() {
        let f = |r: f64| 1.0 + 0.3 * r * r;
        let factor = RadialFactor {
            step: 0.5,
            nodes: (0..=8).map(|i| f(0.5 * f64::from(i))).collect(),
        };
        for r in [0.0, 0.1, 0.26, 1.0, 3.3] {
            assert!((factor.at(r).unwrap() - f(r)).abs() < 1e-12, "{r}");
        }
        assert_eq!(
            (factor.reach(), factor.at(4.1), factor.at(f64::NAN)),
            (4.0, None, None)
        );
    }
}
