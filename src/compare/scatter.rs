//! Tests for images without variances, by the scatter of their difference.
//!
//! The difference of two renders with the same expectation is pure noise: the image content cancels. So within a block
//! of pixels it scatters around 0, and Student's one-sample t-test on the difference (a paired test, pixel by pixel)
//! tests whether its mean is 0. It needs no variances, but assumes that
//! - pixels are independent of each other. Splatting filters and denoisers correlate neighbors; squares of pixels wider
//!   than the filter (`cell`) are nearly independent again;
//! - differences are as likely positive as negative: true for images that were made alike, and nearly so for averages
//!   of many samples. Noise of uniform size is *not* assumed: for symmetric differences of any sizes the test errs
//!   toward "agree" (B. Efron, "Student's t-test under symmetry conditions", J. Am. Stat. Assoc. 64, 1969).
//!
//! A single pixel has no scatter: one or two wrong pixels are not found. Differences that average to zero (edges that
//! moved, texture that got sharper) are found by testing whether neighboring differences are independent, as noise is:
//! products of neighbors scatter around 0 as well.

use super::Estimate;
use super::verdict::{BlockTest, Candidate, Statistic};
use crate::film::{Image, PixelBounds};
use crate::math::{Rgb, UVec2};
use glam::DVec3;

/// Two images, and the definition of one observation.
#[derive(Clone, Copy)]
pub(super) struct Scatter<'a> {
    pub a: Estimate<'a>,
    pub b: Estimate<'a>,
    /// Relative differences, to the brightest channel, up to this are ignored.
    pub tolerance: f64,
    /// Side of the squares whose mean difference is one observation, at least 1.
    pub cell: u32,
}

/// Tests whether the mean of the difference is 0.
pub(super) struct MeanScatter<'a>(pub Scatter<'a>);

/// Tests whether neighboring differences are independent.
pub(super) struct NeighborScatter<'a>(pub Scatter<'a>);

impl BlockTest for MeanScatter<'_> {
    const STATISTIC: Statistic = Statistic::Mean;

    fn ask(&self, bounds: PixelBounds) -> [Candidate; 3] {
        let grid = self.0.grid(bounds);
        let [a, b] = grid.means;
        let tolerated = self.0.tolerance * a.abs().max(b.abs()).max_element();
        [0, 1, 2].map(|c| {
            let differences = grid.cells.iter().map(|cell| f64::from(cell.difference[c]));
            candidate([a[c], b[c]], differences, tolerated)
        })
    }
}

impl BlockTest for NeighborScatter<'_> {
    const STATISTIC: Statistic = Statistic::Neighbors;

    fn ask(&self, bounds: PixelBounds) -> [Candidate; 3] {
        let grid = self.0.grid(bounds);
        let [a, b] = grid.means;
        [0, 1, 2].map(|c| {
            let beyond = |cell: &Cell| cell.beyond(self.0.tolerance, c);
            let products = pairs(grid.size)
                .filter_map(|[i, j]| Some(beyond(grid.cells.get(i)?) * beyond(grid.cells.get(j)?)));
            let candidate = candidate([a[c], b[c]], products, 0.0);
            // The products' signs follow from the signs of the differences, of which there are fewer.
            let signs = grid.cells.iter().filter(|cell| beyond(cell) != 0.0);
            Candidate {
                floor: min_p(signs.count()).max(candidate.floor),
                ..candidate
            }
        })
    }
}

/// One observation. Single precision: there are as many as pixels, and their relative error of 6e-8 is negligible
/// compared with their scatter.
#[derive(Clone, Copy)]
struct Cell {
    /// Mean of A minus mean of B.
    difference: Rgb,
    /// The largest channel of either image.
    brightest: f32,
}

impl Cell {
    /// The difference beyond rounding, which is not random.
    fn beyond(&self, tolerance: f64, channel: usize) -> f64 {
        let difference = f64::from(self.difference[channel]);
        let excess = difference.abs() - tolerance * f64::from(self.brightest);
        excess.max(0.0).copysign(difference)
    }
}

/// The cells of a block.
struct Grid {
    size: UVec2,
    cells: Vec<Cell>,
    /// Means of the cells' values in A and in B.
    means: [DVec3; 2],
}

impl Scatter<'_> {
    fn grid(&self, bounds: PixelBounds) -> Grid {
        let mut sums = [DVec3::ZERO; 2];
        let cells: Vec<Cell> = bounds
            .tiles(self.cell)
            .map(|cell| {
                let [a, b] = [self.a.image, self.b.image].map(|image| mean(image, cell));
                sums[0] += a;
                sums[1] += b;
                Cell {
                    difference: (a - b).as_vec3(),
                    brightest: a.abs().max(b.abs()).max_element() as f32,
                }
            })
            .collect();
        Grid {
            size: bounds.size().map(|n| n.div_ceil(self.cell.max(1))),
            means: sums.map(|sum| sum / cells.len().max(1) as f64),
            cells,
        }
    }

    /// Standard error of the mean difference over the whole image.
    pub(super) fn error_of_mean(&self) -> DVec3 {
        let grid = self.grid(self.a.image.bounds);
        let n = grid.cells.len() as f64;
        let mean = grid.means[0] - grid.means[1];
        let squares = grid.cells.iter().map(|cell| {
            let d = cell.difference.as_dvec3() - mean;
            d * d
        });
        (squares.sum::<DVec3>() / (n * (n - 1.0).max(1.0))).map(f64::sqrt)
    }
}

fn mean(image: &Image, bounds: PixelBounds) -> DVec3 {
    let indices = bounds.pixels().filter_map(|p| image.bounds.index(p));
    let values = indices.filter_map(|i| image.pixels.get(i).map(|p| p.as_dvec3()));
    values.sum::<DVec3>() / bounds.area().max(1) as f64
}

/// Indices of all pairs of horizontally and vertically adjacent cells.
fn pairs(size: UVec2) -> impl Iterator<Item = [usize; 2]> + Clone {
    let (width, height) = (size.x as usize, size.y as usize);
    let across =
        (0..height).flat_map(move |y| (1..width).map(move |x| [y * width + x - 1, y * width + x]));
    let down = (1..height)
        .flat_map(move |y| (0..width).map(move |x| [(y - 1) * width + x, y * width + x]));
    across.chain(down)
}

/// Student's t-test of whether the mean of some observations is 0.
///
/// The degrees of freedom are n − 1 for normal observations and fewer if some are much larger than the rest: 3 (Σd²)² /
/// Σd⁴ − 1, Satterthwaite's formula with d⁴ / 3 for the squared variance of each (a normal d has the fourth moment
/// 3σ⁴).
fn candidate(
    means: [f64; 2],
    observations: impl Iterator<Item = f64> + Clone,
    tolerated: f64,
) -> Candidate {
    let (mut count, mut signs, mut sum) = (0usize, 0usize, 0.0);
    for d in observations.clone() {
        count += 1;
        signs += usize::from(d != 0.0);
        sum += d;
    }
    let n = count as f64;
    let mean = sum / n.max(1.0);
    let (squares, fourths) = observations.fold((0.0, 0.0), |(squares, fourths), d| {
        let square = (d - mean) * (d - mean);
        (squares + square, fourths + square * square)
    });
    let excess = mean.abs() - tolerated;
    let error = (squares / (n * (n - 1.0).max(0.0))).sqrt();
    let (t, freedom) = if count < 2 || excess.is_nan() || excess <= 0.0 {
        (0.0, n - 1.0)
    } else if squares == 0.0 || fourths == 0.0 {
        (f64::INFINITY.copysign(mean), n - 1.0)
    } else {
        let effective = 3.0 * squares * squares / fourths - 1.0;
        ((excess / error).copysign(mean), effective.min(n - 1.0))
    };
    Candidate {
        means,
        t,
        freedom,
        // One observation has no scatter.
        error: if error.is_finite() {
            error
        } else {
            f64::INFINITY
        },
        missed: None,
        tolerated,
        floor: min_p(signs),
        floor_of_all: min_p(count),
    }
}

/// The smallest p-value that this many signs can give: all are equal with probability 2·2⁻ⁿ.
fn min_p(signs: usize) -> f64 {
    2f64.powf(1.0 - signs as f64).min(1.0)
}

/// Correlation of the differences of horizontal neighbors over the whole image.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Neighbors {
    /// Correlation coefficient over all channels, of differences that are weighted by their standard errors if both
    /// images have variances.
    pub correlation: f64,
    /// Its standard error if the pixels are independent: 1/√n.
    pub error: f64,
}

impl Neighbors {
    /// Returns `true` if the correlation is far from that of independent pixels: by five standard errors (one false
    /// alarm in two million) and by more than 5 %, which changes a standard error by a tenth at most.
    pub fn suspicious(&self) -> bool {
        self.correlation.abs() > (5.0 * self.error).max(0.05)
    }

    pub(super) fn new(a: &Estimate, b: &Estimate, weighted: bool) -> Neighbors {
        let width = a.image.bounds.size().x.max(1) as usize;
        let variance = |e: &Estimate, i: usize| {
            let variances = e.image.variance.as_ref().filter(|_| weighted)?;
            variances.get(i).map(|p| p.as_dvec3())
        };
        let difference = |i: usize| {
            let [p, q] =
                [a, b].map(|e| e.image.pixels.get(i).map_or(DVec3::ZERO, |p| p.as_dvec3()));
            let scale = match (variance(a, i), variance(b, i)) {
                (Some(u), Some(v)) => (u + v).map(f64::sqrt),
                _ => DVec3::ONE,
            };
            ((p - q) / scale).map(|d| if d.is_finite() { d } else { 0.0 })
        };
        let (mut products, mut squares, mut count) = (0.0, 0.0, 0usize);
        let row_of = |start: usize| start..(start + width).min(a.image.pixels.len());
        for row in (0..a.image.pixels.len()).step_by(width).map(row_of) {
            let mut last = DVec3::ZERO;
            for (x, i) in row.enumerate() {
                let here = difference(i);
                if x > 0 {
                    products += last.dot(here);
                    squares += 0.5 * (last.length_squared() + here.length_squared());
                    // Pixels without any difference carry no information.
                    count += usize::from(last != DVec3::ZERO && here != DVec3::ZERO);
                }
                last = here;
            }
        }
        Neighbors {
            correlation: if squares > 0.0 {
                products / squares
            } else {
                0.0
            },
            error: 1.0 / (count.max(1) as f64).sqrt(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// d = 1, 2, 3, 4: mean 2.5, s² = 5/3, t = 2.5 / √(5/12) = √15.
    #[test]
    fn students_t_by_hand() {
        let test = candidate([0.0; 2], [1.0, 2.0, 3.0, 4.0].into_iter(), 0.0);
        assert!((test.t - 15f64.sqrt()).abs() < 1e-12);
        // 3 · 5² / (2 (1.5⁴ + 0.5⁴)) − 1 = 6.3, but no more than 3.
        assert_eq!(test.freedom, 3.0);
        assert_eq!(test.floor, 0.125);
        // Within the tolerance it does not count; beyond it, only the excess does.
        assert_eq!(candidate([0.0; 2], [1.0, 2.0].into_iter(), 1.5).t, 0.0);
        let beyond = candidate([0.0; 2], [1.0, 2.0, 3.0, 4.0].into_iter(), 1.25);
        assert!((beyond.t - 0.5 * 15f64.sqrt()).abs() < 1e-12);
    }

    #[test]
    fn one_observation_decides_nothing() {
        let lonely = [0.0, 0.0, 0.0, 7.0].into_iter();
        assert_eq!(candidate([0.0; 2], lonely, 0.0).p(), 1.0);
        assert_eq!(candidate([0.0; 2], std::iter::once(3.0), 0.0).p(), 1.0);
        assert_eq!(candidate([0.0; 2], std::iter::empty(), 0.0).p(), 1.0);
        // The same difference everywhere is as significant as signs can be.
        let same = candidate([0.0; 2], std::iter::repeat_n(1.0, 40), 0.0);
        assert_eq!(same.p(), 2f64.powi(-39));
    }

    #[test]
    fn all_pairs_of_neighbors() {
        let found: Vec<_> = pairs(UVec2::new(2, 2)).collect();
        assert_eq!(found, [[0, 1], [2, 3], [0, 2], [1, 3]]);
        assert_eq!(
            pairs(UVec2::new(1, 1)).count() + pairs(UVec2::ZERO).count(),
            0
        );
        assert_eq!(pairs(UVec2::new(5, 3)).count(), 4 * 3 + 5 * 2);
    }
}
