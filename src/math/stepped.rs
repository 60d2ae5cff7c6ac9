//! Many small densities side by side, quantized: sampling one costs a cache line or two.

use super::float::clamp_nan_low;
use std::ops::Range;

/// Number of steps that a density's cells share. One less than 16 bits can count, so that a cell may start after the
/// last step.
const STEPS: u16 = u16::MAX;

/// Number of cells in one line of the table.
const LINE: usize = 16;

/// Maximum number of cells of a density: each needs a step, and rounding must leave only a few over.
pub const MAX_CELLS: usize = 4096;

/// The starts of sixteen cells; entries after the last cell start with the last step.
#[derive(Clone, Copy, Debug)]
#[repr(align(32))]
struct Line([u16; LINE]);

/// Piecewise-constant densities over [0, 1), all with the same number of equal cells.
///
/// Probabilities are integer multiples of 1/65535, at least one for anything nonzero: inversion samples the stated
/// density to the bit. Cells are found without branches, by counting how many of a row of 16-bit values are passed,
/// eight or sixteen per instruction; 32 of them are a cache line.
#[derive(Clone, Debug)]
pub struct SteppedDensities {
    cells: usize,
    lines_each: usize,
    lines: Vec<Line>,
}

impl SteppedDensities {
    /// An empty table for densities with `cells` cells, 1 to [`MAX_CELLS`].
    pub fn new(cells: usize) -> SteppedDensities {
        let cells = cells.clamp(1, MAX_CELLS);
        SteppedDensities {
            cells,
            lines_each: cells.div_ceil(LINE),
            lines: Vec::new(),
        }
    }

    /// Number of cells of each density.
    pub fn cells(&self) -> usize {
        self.cells
    }

    /// Adds the density proportional to non-negative values, one for each cell; uniform if all are zero. Negative,
    /// non-finite and missing values count as zero.
    pub fn push(&mut self, values: &[f64]) {
        let value = |i: usize| {
            values
                .get(i)
                .map_or(0.0, |v| if v.is_finite() { v.max(0.0) } else { 0.0 })
        };
        let largest = (0..self.cells).map(value).fold(0.0, f64::max);
        // Relative to the largest: sums stay finite.
        let share = |i: usize| {
            if largest > 0.0 {
                value(i) / largest
            } else {
                1.0
            }
        };
        let total: f64 = (0..self.cells).map(share).sum();
        let positive = (0..self.cells).filter(|&i| share(i) > 0.0).count();
        let spread = f64::from(STEPS) - positive as f64;
        let (mut sum, mut before) = (0.0, 0u16);
        let start = |i: usize| {
            let start = (sum / total * spread).round() as u16 + before;
            sum += share(i);
            before += u16::from(share(i) > 0.0);
            start
        };
        let mut starts: Vec<u16> = (0..self.cells).map(start).collect();
        starts.resize(self.lines_each * LINE, STEPS);
        let (lines, _) = starts.as_chunks();
        self.lines.extend(lines.iter().map(|&line| Line(line)));
    }

    fn lines_of(&self, density: usize) -> Range<usize> {
        density * self.lines_each..(density + 1) * self.lines_each
    }

    /// The number of steps before each cell of a density.
    fn starts(&self, density: usize) -> &[Line] {
        self.lines.get(self.lines_of(density)).unwrap_or_default()
    }

    /// The cell that contains `u` in [0, 1), the position in it, in [0, 1), and its probability. For a nonexistent
    /// density, the first cell with probability 0.
    #[inline]
    pub fn locate(&self, density: usize, u: f32) -> (usize, f32, f32) {
        let position = u * f32::from(STEPS);
        let step = (position as u16).min(STEPS - 1);
        let lines = self.starts(density);
        // By place in a line, and added up once: few instructions for each line.
        let mut passed = [0u16; LINE];
        for line in lines {
            for (passed, start) in passed.iter_mut().zip(line.0) {
                *passed += u16::from(start <= step);
            }
        }
        let passed: u16 = passed.iter().sum();
        // The first start is never after a step; cells of no width come before the one that is found.
        let cell = usize::from(passed).saturating_sub(1);
        let (start, end) = ends(lines, cell);
        let width = end - start;
        let inside = clamp_nan_low((position - start) / width, 0.0, 1.0 - f32::EPSILON / 2.0);
        (cell, inside, width / f32::from(STEPS))
    }

    /// Probability of a cell.
    #[inline]
    pub fn probability(&self, density: usize, cell: usize) -> f32 {
        let (start, end) = ends(self.starts(density), cell);
        (end - start) / f32::from(STEPS)
    }
}

/// The start and end of a cell, in steps.
#[inline]
fn ends(lines: &[Line], cell: usize) -> (f32, f32) {
    let at = |i: usize| lines.get(i / LINE).map_or(STEPS, |line| line.0[i % LINE]);
    (f32::from(at(cell)), f32::from(at(cell + 1)))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn table(cells: usize, densities: &[Vec<f64>]) -> SteppedDensities {
        let mut table = SteppedDensities::new(cells);
        densities.iter().for_each(|d| table.push(d));
        table
    }

    #[test]
    fn probabilities_are_those_asked_for_to_a_step() {
        for cells in [1, 2, 15, 16, 17, 32, 300] {
            let values: Vec<f64> = (0..cells)
                .map(|i| ((i * i) % 7) as f64 + f64::from(i == 0))
                .collect();
            let total: f64 = values.iter().sum();
            let table = table(cells, &[vec![1.0; cells], values.clone()]);
            let mut sum = 0.0;
            for (i, v) in values.iter().enumerate() {
                let p = f64::from(table.probability(1, i));
                // Rounding at both ends, the cell's own step, and the fraction of steps reserved for all cells.
                let bound = (2.0 + cells as f64 * v / total) / f64::from(STEPS);
                assert!((p - v / total).abs() <= bound, "{cells} {i}: {p}");
                assert_eq!(p > 0.0, *v > 0.0);
                sum += p;
            }
            assert!((sum - 1.0).abs() < 1e-6);
        }
    }

    #[test]
    fn every_number_falls_on_the_cell_that_holds_it() {
        let values = vec![
            0.0, 0.0, 3.0, 1e-12, 0.0, 900.0, 0.0, 1.0, 2.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0,
            5.0, 0.0, 0.0,
        ];
        let table = table(values.len(), std::slice::from_ref(&values));
        let n = 1 << 18;
        let mut counts = vec![0.0; values.len()];
        for k in 0..n {
            let u = (k as f32 + 0.5) / n as f32;
            let (cell, inside, probability) = table.locate(0, u);
            assert_eq!(probability, table.probability(0, cell));
            assert!(
                (0.0..1.0).contains(&inside) && values[cell] > 0.0,
                "{u} {cell}"
            );
            let before: f32 = (0..cell).map(|i| table.probability(0, i)).sum();
            // Sums and products of single-precision values below 1, and the width divided by.
            assert!(
                (before + inside * probability - u).abs() < 1e-6,
                "{u} {cell} {inside}"
            );
            counts[cell] += 1.0 / f64::from(n);
        }
        for (i, count) in counts.into_iter().enumerate() {
            // Equally spaced samples are off by one at each end.
            assert!((count - f64::from(table.probability(0, i))).abs() <= 2.0 / f64::from(n));
        }
        for u in [0.0, f32::MIN_POSITIVE, 1.0 - f32::EPSILON / 2.0] {
            assert!(values[table.locate(0, u).0] > 0.0);
        }
    }

    #[test]
    fn odd_values_do_no_harm() {
        let wild = vec![f64::NAN, f64::INFINITY, -1.0, 1e300];
        let table = table(
            4,
            &[
                wild,
                vec![0.0; 4],
                vec![1.0],
                vec![f64::MIN_POSITIVE, 1e308, 0.0, 1e308],
            ],
        );
        assert_eq!(table.probability(0, 3), 1.0);
        assert!((table.probability(1, 2) - 0.25).abs() < 1e-4);
        assert_eq!(table.probability(2, 0), 1.0);
        assert!((table.probability(3, 1) - 0.5).abs() < 1e-4);
        assert_eq!(table.locate(4, 0.5).2, 0.0);
        for u in [f32::NAN, -1.0, 2.0] {
            assert!(table.locate(0, u).0 < 4);
        }
        // As many as allowed.
        let many = vec![1.0; MAX_CELLS];
        let mut table = SteppedDensities::new(usize::MAX);
        table.push(&many);
        assert!((0..table.cells()).all(|i| table.probability(0, i) > 0.0));
    }
}
