//! The smallest ellipse around a region: its bounding shape where its outline cannot be trusted.

use super::mapping::Spot;
use super::outline::DIRECTIONS;

/// The extent of a region, and its area.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Region {
    /// Distance of the middle from the lens axis, in the direction of the film point, mm.
    pub center: f64,
    /// Half the extent along that direction, mm.
    pub along: f64,
    /// Half the extent across it, mm.
    pub across: f64,
    /// In mm².
    pub area: f64,
}

impl Region {
    /// The ellipse with these center and semi-axes.
    pub(super) fn ellipse(center: f64, along: f64, across: f64) -> Region {
        Region {
            center,
            along,
            across,
            area: std::f64::consts::PI * along * across,
        }
    }

    /// Corners of a polygon around the half with y ≥ 0, relative to the center.
    pub(super) fn corners(&self) -> impl Iterator<Item = [f64; 2]> {
        let e = *self;
        let step = std::f64::consts::PI / DIRECTIONS as f64;
        let scale = 1.0 / (0.5 * step).cos();
        (0..=DIRECTIONS).map(move |i| {
            let (sin, cos) = (step * i as f64).sin_cos();
            [scale * e.along * cos, scale * e.across * sin.max(0.0)]
        })
    }

    /// A small ellipse, centered on the y = 0 axis, around points given by their half with y ≥ 0;
    /// `None` for no points. For each ratio of the axes the best circle after scaling y, and of the
    /// ratios the one with the least area.
    pub(in crate::optics) fn around(points: &[[f64; 2]]) -> Option<Region> {
        let (mut low, mut high, mut top) = (f64::INFINITY, f64::NEG_INFINITY, 0.0f64);
        for p in points {
            (low, high, top) = (low.min(p[0]), high.max(p[0]), top.max(p[1]));
        }
        if !(high - low).is_finite() || !top.is_finite() {
            return None;
        }
        // Regions thinner than this part of their length are as good as lines.
        let width = (0.5 * (high - low)).max(1e-6 * top).max(f64::MIN_POSITIVE);
        let height = top.max(1e-6 * width);
        let fit = |log_ratio: f64| {
            let ratio = height / width * log_ratio.exp();
            let farthest = |center: f64| {
                let distance2 = |p: &[f64; 2]| {
                    let (x, y) = (p[0] - center, p[1] / ratio);
                    x * x + y * y
                };
                points.iter().map(distance2).fold(0.0, f64::max)
            };
            let center = valley(farthest, low, high);
            let radius = farthest(center).sqrt().max(f64::MIN_POSITIVE);
            Region::ellipse(center, radius, radius * ratio)
        };
        // The axes' ratio is the box' to within a factor of e, for any convex region.
        Some(fit(valley(|k| fit(k).along * fit(k).across, -1.0, 1.0)))
    }

    /// The point `p` of the ellipse, relative to the lens axis.
    pub(super) fn point(&self, p: Spot<f64>) -> [f64; 2] {
        let (sin, cos) = (std::f64::consts::PI * p.half).sin_cos();
        [
            self.center + self.along * p.radius * cos,
            self.across * p.radius * p.side * sin,
        ]
    }
}

/// Lowest point of a function with one valley, to 1e-4 of the bracket.
fn valley(f: impl Fn(f64) -> f64, mut a: f64, mut b: f64) -> f64 {
    const RATIO: f64 = 0.618_033_988_749_895;
    let (mut x, mut y) = (b - RATIO * (b - a), a + RATIO * (b - a));
    let (mut fx, mut fy) = (f(x), f(y));
    for _ in 0..18 {
        if fx < fy {
            (b, y, fy) = (y, x, fx);
            x = b - RATIO * (b - a);
            fx = f(x);
        } else {
            (a, x, fx) = (x, y, fy);
            y = a + RATIO * (b - a);
            fy = f(y);
        }
    }
    0.5 * (a + b)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_ellipse_around_an_ellipse_is_itself() {
        let points: Vec<[f64; 2]> = (0..=48)
            .map(|i| std::f64::consts::PI * f64::from(i) / 48.0)
            .map(|a| [7.0 + 3.0 * a.cos(), 0.5 * a.sin()])
            .collect();
        let e = Region::around(&points).unwrap();
        // What the coarse search leaves, on each axis.
        assert!(
            (e.along / 3.0 - 1.0).abs() < 5e-3 && (e.across / 0.5 - 1.0).abs() < 5e-3,
            "{e:?}"
        );
        assert!((e.center - 7.0).abs() < 1e-2);
        assert_eq!(Region::around(&[]), None);
        // Its polygon's sides touch it from outside.
        let corners: Vec<[f64; 2]> = e.corners().collect();
        for p in corners.windows(2) {
            let (x, y) = (
                0.5 * (p[0][0] + p[1][0]) / e.along,
                0.5 * (p[0][1] + p[1][1]) / e.across,
            );
            assert!((x.hypot(y) - 1.0).abs() < 1e-12);
        }
    }
}
