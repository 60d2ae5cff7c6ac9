//! Piecewise-constant densities in one dimension, sampled by inversion
//! (Pharr, Jakob and Humphreys 2016, §13.3.1).

/// A piecewise-constant density over [0, 1) with equal cells.
#[derive(Clone, Debug, PartialEq)]
pub struct Distribution1D {
    function: Vec<f32>,
    cdf: Vec<f32>,
    integral: f32,
    /// The number of entries of `cdf` that are at most k/m, for k from 0 to a power of two m: bounds of the search (the
    /// guide table method of Chen and Asau, "On Generating Random Variates from an Empirical Distribution", 1974).
    guide: Vec<u32>,
}

impl Distribution1D {
    /// From non-negative cell values (negative and non-finite ones count as 0).
    /// Where all are zero the density is uniform and integral is 0.
    pub fn new(values: impl IntoIterator<Item = f32>) -> Distribution1D {
        let function: Vec<f32> = values
            .into_iter()
            .map(|v| if v.is_finite() { v.max(0.0) } else { 0.0 })
            .collect();
        let n = function.len().max(1) as f64;
        let mut sum = 0.0;
        let running = function.iter().map(|&v| {
            sum += f64::from(v) / n;
            sum
        });
        let running: Vec<f64> = std::iter::once(0.0).chain(running).collect();
        let cdf: Vec<f32> = if sum > 0.0 {
            running.iter().map(|&c| (c / sum) as f32).collect()
        } else {
            (0..running.len()).map(|i| i as f32 / n as f32).collect()
        };
        Distribution1D {
            guide: guide(&cdf, function.len()),
            function,
            cdf,
            integral: sum as f32,
        }
    }

    /// Number of cells.
    pub fn cells(&self) -> usize {
        self.function.len()
    }

    /// The cell of `u` in [0, 1), with the position inside the cell in [0, 1).
    fn locate(&self, u: f32) -> (usize, f32) {
        // The first cell whose upper end is beyond u: never one of zero probability.
        let i = self.entries_up_to(u).clamp(1, self.function.len()) - 1;
        let width = self.cdf[i + 1] - self.cdf[i];
        let inside = if width > 0.0 {
            ((u - self.cdf[i]) / width).clamp(0.0, 1.0 - f32::EPSILON / 2.0)
        } else {
            0.5
        };
        (i, inside)
    }

    /// The number of entries of the CDF that are at most `u`.
    fn entries_up_to(&self, u: f32) -> usize {
        // A product with a power of two is exact: k/m ≤ u < (k+1)/m.
        let k = (u * (self.guide.len() - 1) as f32) as usize;
        let (Some(&low), Some(&high)) = (self.guide.get(k), self.guide.get(k + 1)) else {
            // Not less than 1.
            return self.cdf.len();
        };
        let (low, high) = (low as usize, high as usize);
        low + self.cdf[low..high].partition_point(|&c| c <= u)
    }

    /// Samples a position in [0, 1); also returns its density and its cell.
    pub fn sample_continuous(&self, u: f32) -> (f32, f32, usize) {
        let (i, inside) = self.locate(u);
        let x = ((i as f32 + inside) / self.function.len() as f32).min(1.0 - f32::EPSILON / 2.0);
        (x, self.density(i), i)
    }

    /// Samples a cell; also returns its probability, and `u` rescaled over the cell for reuse.
    pub fn sample_discrete(&self, u: f32) -> (usize, f32, f32) {
        let (i, inside) = self.locate(u);
        (i, self.probability(i), inside)
    }

    /// Density over [0, 1) in cell `i`.
    pub fn density(&self, i: usize) -> f32 {
        if self.integral > 0.0 {
            self.function[i] / self.integral
        } else {
            1.0
        }
    }

    /// Probability of cell `i`.
    pub fn probability(&self, i: usize) -> f32 {
        self.density(i) / self.function.len() as f32
    }
}

/// See [`Distribution1D::guide`]; the table has at least as many parts as `cells`, and at most twice as many.
fn guide(cdf: &[f32], cells: usize) -> Vec<u32> {
    let parts = cells.next_power_of_two();
    let mut entries = 0;
    let up_to = |k: usize| {
        let end = k as f32 / parts as f32;
        while cdf.get(entries).is_some_and(|&c| c <= end) {
            entries += 1;
        }
        entries as u32
    };
    (0..=parts).map(up_to).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn zero_cells_are_never_chosen() {
        let d = Distribution1D::new([0.0, 1.0, 0.0, 3.0, 0.0]);
        for i in 0..1000 {
            let (cell, p, _) = d.sample_discrete(i as f32 / 1000.0);
            assert!(p > 0.0 && (cell == 1 || cell == 3));
        }
        let (cell, _, _) = d.sample_discrete(1.0 - f32::EPSILON / 2.0);
        assert_eq!(cell, 3);
    }

    #[test]
    fn the_guide_finds_what_a_search_of_all_finds() {
        let spiky = (0..300).map(|i| if i % 37 == 0 { 1e4 } else { (i % 3) as f32 });
        for d in [
            Distribution1D::new(spiky),
            Distribution1D::new([0.0; 5]),
            Distribution1D::new([2.0]),
            Distribution1D::new([0.0, 0.0, 1.0, 0.0]),
        ] {
            let inner = d.cdf.iter().flat_map(|&c| [c.next_down(), c, c.next_up()]);
            let even = (0..1000).map(|i| i as f32 / 1000.0);
            for u in inner.chain(even).filter(|u| (0.0..1.0).contains(u)) {
                assert_eq!(
                    d.entries_up_to(u),
                    d.cdf.partition_point(|&c| c <= u),
                    "{u}"
                );
            }
        }
    }

    #[test]
    fn sampled_frequencies_are_the_density() {
        let values: Vec<f32> = (0..12).map(|i| (i % 5) as f32).collect();
        let d = Distribution1D::new(values.iter().copied());
        let n = 100_000;
        let mut counts = [0.0f64; 12];
        for i in 0..n {
            let (cell, probability, _) = d.sample_discrete((i as f32 + 0.5) / n as f32);
            assert_eq!(probability, d.probability(cell));
            counts[cell] += 1.0 / f64::from(n);
        }
        let total: f32 = values.iter().sum();
        for (c, v) in counts.iter().zip(&values) {
            // Equally spaced samples are off by one at each end.
            assert!((c - f64::from(v / total)).abs() < 3.0 / f64::from(n));
        }
    }

    #[test]
    fn all_zero_is_uniform() {
        let d = Distribution1D::new([0.0; 4]);
        assert_eq!(d.integral, 0.0);
        assert_eq!(d.sample_continuous(0.6).1, 1.0);
    }
}
