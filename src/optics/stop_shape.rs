//! The shape of an aperture stop that is not round: straight blades, or an image of what lets how much light through.
//!
//! All lie in the circle of the stop's diameter, which stays the limit: what pupils are found for and f-numbers mean.
//! A polygon ends rays in the tracer like any rim ([`crate::optics::LensTracer`]); an image weakens them
//! ([`crate::optics::Lens::stop_transmission`]). x and y are those of lens and camera: right and up, as a photographer sees
//! the stop through the lens from behind the camera.
//!
//! The built-in shapes are pbrt-v4's in size and position (`RealisticCamera`, pbrt 4th edition §5.4); its `gaussian` is
//! scaled to let everything through in the middle.

use super::real::{Mask, Number, Plain};

/// What a stop lets through.
#[derive(Clone, Debug, PartialEq)]
pub enum StopShape {
    /// Straight edges.
    Polygon(StopPolygon),
    /// exp(−r²) − exp(−1), relative to the middle; r in radii of the stop.
    Gaussian,
    /// An image of the square around the stop's circle.
    ImageData(StopImage),
}

impl StopShape {
    /// Part of a round stop's light that gets through where all of the stop is lit alike: above 0, at most 1; 0 for a black image.
    pub fn light(&self) -> f64 {
        /// Cells of the stop's square per side: to 1e-4 of the sums over smooth and over drawn shapes.
        const CELLS: u32 = 256;
        if let StopShape::Polygon(polygon) = self {
            return polygon.area();
        }
        let middle = |i: u32| (f64::from(i) + 0.5) * 2.0 / f64::from(CELLS) - 1.0;
        let points = (0..CELLS * CELLS).map(|i| [middle(i % CELLS), middle(i / CELLS)]);
        let round = points.filter(|[x, y]| x * x + y * y <= 1.0);
        let (sum, count) = round.fold((0.0, 0.0), |(sum, count), p| {
            (sum + self.transmission(p), count + 1.0)
        });
        sum / count
    }

    /// The part of the light that passes the point (x, y), in radii of the stop; 0 outside its circle.
    pub fn transmission(&self, [x, y]: [f64; 2]) -> f64 {
        let r2 = x * x + y * y;
        if r2.is_nan() || r2 > 1.0 {
            return 0.0;
        }
        match self {
            StopShape::Polygon(polygon) => f64::from(polygon.edges(1.0).hold(x, y)),
            StopShape::Gaussian => {
                let edge = (-1.0f64).exp();
                ((-r2).exp() - edge) / (1.0 - edge)
            }
            StopShape::ImageData(image) => image.at(x, y),
        }
    }
}

/// A regular polygon, or the five-pointed star that its lines make.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StopPolygon {
    /// Number of edges, at least 3.
    blades: usize,
    /// From the middle to a corner (of the star: to a point), in radii of the stop.
    corner: f64,
    /// Direction of one corner, degrees counterclockwise from x.
    direction: f64,
    /// A point counts as inside that is beyond this many of the edges' lines.
    beyond: usize,
}

/// More blades are round to 1e-5 of the radius.
pub const MAX_BLADES: usize = 1000;

impl StopPolygon {
    fn new(blades: usize, corner: f64, direction: f64, beyond: usize) -> StopPolygon {
        StopPolygon {
            blades,
            corner,
            direction,
            beyond,
        }
    }

    /// A diaphragm of `blades` (3 to [`MAX_BLADES`]) straight edges, its corners on the stop's circle, one of them up, turned
    /// counterclockwise by `rotation` degrees.
    pub fn of_blades(blades: usize, rotation: f64) -> StopPolygon {
        StopPolygon::new(blades.clamp(3, MAX_BLADES), 1.0, 90.0 + rotation, 0)
    }

    /// pbrt-v4's "square": its sides are half the stop's diameter.
    pub fn square(rotation: f64) -> StopPolygon {
        StopPolygon::new(4, std::f64::consts::FRAC_1_SQRT_2, 45.0 + rotation, 0)
    }

    /// pbrt-v4's "pentagon": corners at 0.8 of the stop's radius, one of them down.
    pub fn pentagon(rotation: f64) -> StopPolygon {
        StopPolygon::new(5, 0.8, rotation - 90.0, 0)
    }

    /// pbrt-v4's "star": a pentagram, its points on the stop's circle, one of them to the left.
    pub fn star(rotation: f64) -> StopPolygon {
        StopPolygon::new(5, 1.0, 180.0 + rotation, 1)
    }

    /// The edges of a stop of `radius` mm.
    pub fn edges<B: Plain>(&self, radius: f64) -> StopEdges<B> {
        let step = 360.0 / self.blades as f64;
        // A regular polygon's edges face between two corners; the lines of a pentagram, which join every second point, pass
        // below the point in between.
        let (facing, inradius) = if self.beyond == 0 {
            (0.5 * step, (0.5 * step).to_radians().cos())
        } else {
            (0.0, step.to_radians().cos())
        };
        let normal = |i: usize| {
            let angle = (self.direction + facing + step * i as f64).to_radians();
            [B::round_from(angle.cos()), B::round_from(angle.sin())]
        };
        StopEdges {
            normals: (0..self.blades).map(normal).collect(),
            distance: B::round_from(self.corner * inradius * radius),
            star: self.beyond > 0,
        }
    }

    /// Part of the circle's area.
    pub fn area(&self) -> f64 {
        let (n, step) = (
            self.blades as f64,
            std::f64::consts::TAU / self.blades as f64,
        );
        // Triangles from the middle; of a star between a point and the corner beside it, cos 72°/cos 36° out.
        let triangles = if self.beyond == 0 {
            n * step.sin()
        } else {
            2.0 * n * (0.5 * step).sin() * step.cos() / (0.5 * step).cos()
        };
        self.corner * self.corner * triangles / std::f64::consts::TAU
    }
}

/// A polygonal stop ready for tracing in precision `B`: outward normals of lines, and their distance from the middle.
#[derive(Clone, Debug)]
pub struct StopEdges<B> {
    normals: Vec<[B; 2]>,
    distance: B,
    star: bool,
}

impl<B: Plain> StopEdges<B> {
    /// True where light passes at (x, y), for one point or a bundle of them; not at what is not a number.
    #[inline(always)]
    pub fn hold<T: Number<Base = B>>(&self, x: T, y: T) -> T::Mask {
        let (mut within_all, mut within_all_but_one) = (T::Mask::YES, T::Mask::YES);
        for normal in &self.normals {
            let within = (x.times(normal[0]) + y.times(normal[1])).at_most(self.distance);
            within_all_but_one = within_all_but_one & (within | within_all);
            within_all = within_all & within;
        }
        if self.star {
            within_all_but_one
        } else {
            within_all
        }
    }
}

/// Transmission as an image, from 0 to 1.
#[derive(Clone, Debug, PartialEq)]
pub struct StopImage {
    width: usize,
    /// Row by row from the top.
    texels: std::sync::Arc<[f32]>,
}

impl StopImage {
    /// Of `texels` row by row from the top, left to right; `None` where they do not fill whole rows. Values outside 0 to 1 are
    /// moved to the nearer end, what is not a number to 0.
    pub fn new(width: usize, texels: impl Iterator<Item = f32>) -> Option<StopImage> {
        let clean = |t: f32| if t.is_nan() { 0.0 } else { t.clamp(0.0, 1.0) };
        let texels: std::sync::Arc<[f32]> = texels.map(clean).collect();
        let whole = width > 0 && !texels.is_empty() && texels.len().is_multiple_of(width);
        whole.then_some(StopImage { width, texels })
    }

    /// Mean over the stop's square.
    pub fn mean(&self) -> f64 {
        self.texels.iter().map(|t| f64::from(*t)).sum::<f64>() / self.texels.len() as f64
    }

    /// Between the middles of texels linearly, black around the image, as pbrt-v4; x and y from −1 to 1.
    fn at(&self, x: f64, y: f64) -> f64 {
        let height = self.texels.len() / self.width;
        let u = 0.5 * (x + 1.0) * self.width as f64 - 0.5;
        let v = 0.5 * (1.0 - y) * height as f64 - 0.5;
        let (column, row) = (u.floor(), v.floor());
        let (s, t) = (u - column, v - row);
        let texel = |i: f64, j: f64| {
            if i < 0.0 || j < 0.0 || i >= self.width as f64 || j >= height as f64 {
                return 0.0;
            }
            let found = self.texels.get(j as usize * self.width + i as usize);
            found.map_or(0.0, |t| f64::from(*t))
        };
        let mix = |a: f64, b: f64, t: f64| a + t * (b - a);
        mix(
            mix(texel(column, row), texel(column + 1.0, row), s),
            mix(texel(column, row + 1.0), texel(column + 1.0, row + 1.0), s),
            t,
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::optics::lanes::Lanes;

    /// The corners, from their definition in pbrt-v4's terms.
    fn corners(count: usize, radius: f64, direction: f64) -> Vec<[f64; 2]> {
        (0..count)
            .map(|i| (direction + 360.0 * i as f64 / count as f64).to_radians())
            .map(|a| [radius * a.cos(), radius * a.sin()])
            .collect()
    }

    fn holds(polygon: &StopPolygon, p: [f64; 2], scale: f64) -> bool {
        StopShape::Polygon(*polygon).transmission(p.map(|x| scale * x)) == 1.0
    }

    #[test]
    fn corners_are_where_they_should_be() {
        for (polygon, count, radius, direction) in [
            (StopPolygon::of_blades(6, 0.0), 6, 1.0, 90.0),
            (StopPolygon::of_blades(3, 20.0), 3, 1.0, 110.0),
            (StopPolygon::square(0.0), 4, 0.5f64.sqrt(), 45.0),
            (StopPolygon::pentagon(0.0), 5, 0.8, -90.0),
            (StopPolygon::pentagon(10.0), 5, 0.8, -80.0),
            (StopPolygon::star(0.0), 5, 1.0, 180.0),
        ] {
            for corner in corners(count, radius, direction) {
                assert!(holds(&polygon, corner, 0.999), "{polygon:?} {corner:?}");
                assert!(!holds(&polygon, corner, 1.001), "{polygon:?} {corner:?}");
            }
        }
        // The star's inner corners: cos 72°/cos 36° out, opposite to its points.
        let inner = 72f64.to_radians().cos() / 36f64.to_radians().cos();
        for corner in corners(5, inner, 0.0) {
            let star = StopPolygon::star(0.0);
            assert!(holds(&star, corner, 0.999) && !holds(&star, corner, 1.001));
        }
        // The square's sides.
        let square = StopPolygon::square(0.0);
        assert!(holds(&square, [0.5, 0.0], 0.999) && !holds(&square, [0.5, 0.0], 1.001));
    }

    #[test]
    fn areas_are_those_counted() {
        for polygon in [
            StopPolygon::of_blades(3, 0.0),
            StopPolygon::of_blades(7, 13.0),
            StopPolygon::square(30.0),
            StopPolygon::pentagon(0.0),
            StopPolygon::star(5.0),
        ] {
            let n = 2000;
            let at = |i: usize| 2.0 * (i as f64 + 0.5) / n as f64 - 1.0;
            let inside = (0..n * n)
                .filter(|i| holds(&polygon, [at(i % n), at(i / n)], 1.0))
                .count();
            let counted = 4.0 * inside as f64 / (n * n) as f64 / std::f64::consts::PI;
            // A grid's error is some perimeters times its spacing, mostly canceling.
            assert!(
                (counted - polygon.area()).abs() < 1e-4,
                "{polygon:?} {counted}"
            );
        }
        // A regular hexagon, 3√3/2 r² (any table of formulas).
        let hexagon = 1.5 * 3f64.sqrt() / std::f64::consts::PI;
        assert!((StopPolygon::of_blades(6, 0.0).area() - hexagon).abs() < 1e-15);
    }

    #[test]
    fn a_bundle_is_judged_like_its_points() {
        for polygon in [StopPolygon::of_blades(5, 3.0), StopPolygon::star(0.0)] {
            let edges = polygon.edges::<f32>(4.0);
            for i in 0..200 {
                let at = |k: i32, j: i32| {
                    8.0 * (0.618_034 * (i * 8 + j) as f32 * k as f32).fract() - 4.0
                };
                let x = Lanes::<8>(std::array::from_fn(|j| at(1, j as i32)));
                let y = Lanes::<8>(std::array::from_fn(|j| at(7, j as i32)));
                let mask = edges.hold(x, y);
                for lane in 0..8 {
                    assert_eq!(mask.at(lane), edges.hold(x.0[lane], y.0[lane]));
                }
            }
            assert!(!edges.hold(f32::NAN, 0.0));
        }
    }

    #[test]
    fn images_are_upright_and_black_around() {
        // Top left white, top right half, bottom black.
        let image = StopImage::new(2, [1.0, 0.5, 0.0, 0.0].into_iter()).unwrap();
        let shape = StopShape::ImageData(image.clone());
        assert_eq!(image.mean(), 0.375);
        // The middles of texels.
        assert_eq!(shape.transmission([-0.5, 0.5]), 1.0);
        assert_eq!(shape.transmission([0.5, 0.5]), 0.5);
        assert_eq!(shape.transmission([-0.5, -0.5]), 0.0);
        assert_eq!(shape.transmission([0.0, 0.5]), 0.75);
        // Half-way to the black around it, and outside the stop's circle.
        assert_eq!(shape.transmission([-0.75, 0.5]), 0.75);
        assert_eq!(shape.transmission([-0.9, 0.9]), 0.0);
        assert_eq!(shape.transmission([f64::NAN, 0.0]), 0.0);
        assert_eq!(StopImage::new(2, [1.0; 3].into_iter()), None);
        let wild = StopImage::new(1, [f32::NAN, 3.0, -1.0].into_iter()).unwrap();
        assert_eq!(wild.texels.as_ref(), [0.0, 1.0, 0.0]);
    }

    #[test]
    fn the_gaussian_ends_at_the_rim() {
        let at = |r: f64| StopShape::Gaussian.transmission([0.6 * r, 0.8 * r]);
        assert_eq!(at(0.0), 1.0);
        assert!(at(1.0).abs() < 1e-15 && at(1.1) == 0.0);
        // pbrt-v4's function at half the radius, relative to its middle.
        let v = |r: f64| (-r * r).exp() - (-1.0f64).exp();
        assert!((at(0.5) - v(0.5) / v(0.0)).abs() < 1e-15);
    }
}
