//! Linear least squares.

/// A matrix of rows that is brought to upper triangular form by Householder reflections
/// (Golub and Van Loan, *Matrix Computations*, §5.3.2), and its right-hand sides.
pub struct LeastSquares<const R: usize> {
    columns: usize,
    /// Column after column.
    matrix: Vec<f64>,
    right: [Vec<f64>; R],
}

/// Columns whose part independent of those before is less than this fraction of them say nothing
/// and get the coefficient 0: a hundred times the rounding of f64 over some thousand rows.
const INDEPENDENT: f64 = 1e-12;

impl<const R: usize> LeastSquares<R> {
    /// For rows of `columns` numbers.
    pub fn new(columns: usize, rows: impl Iterator<Item = (Vec<f64>, [f64; R])>) -> Self {
        let mut right: [Vec<f64>; R] = std::array::from_fn(|_| Vec::new());
        let rows: Vec<Vec<f64>> = rows
            .map(|(row, values)| {
                right.iter_mut().zip(values).for_each(|(r, v)| r.push(v));
                row
            })
            .collect();
        let matrix = (0..columns)
            .flat_map(|c| rows.iter().map(move |row| row[c]))
            .collect();
        LeastSquares {
            columns,
            matrix,
            right,
        }
    }

    /// The coefficients that bring each right-hand side closest, in the sum of squares.
    pub fn solve(mut self) -> [Vec<f64>; R] {
        let rows = self.right[0].len();
        let mut diagonal = vec![0.0; self.columns];
        for c in 0..self.columns.min(rows) {
            let (before, rest) = self.matrix.split_at_mut((c + 1) * rows);
            let column = &mut before[c * rows..];
            let whole = norm(column);
            let length = norm(&column[c..]);
            if length <= INDEPENDENT * whole || length == 0.0 {
                continue;
            }
            // Away from zero, so that nothing cancels.
            diagonal[c] = -length.copysign(column[c]);
            let v = &mut column[c..];
            v[0] -= diagonal[c];
            let scale = 2.0 / dot(v, v);
            rest.chunks_mut(rows)
                .for_each(|other| reflect(v, scale, &mut other[c..]));
            for right in &mut self.right {
                reflect(v, scale, &mut right[c..]);
            }
        }
        let Self {
            columns,
            matrix,
            right,
        } = self;
        right.map(|right| {
            let mut x = vec![0.0; columns];
            for c in (0..columns.min(rows)).rev() {
                if diagonal[c] != 0.0 {
                    let known: f64 = (c + 1..columns).map(|k| matrix[k * rows + c] * x[k]).sum();
                    x[c] = (right[c] - known) / diagonal[c];
                }
            }
            x
        })
    }
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

fn norm(a: &[f64]) -> f64 {
    dot(a, a).sqrt()
}

/// Reflects `x` at the plane perpendicular to `v`; `scale` is 2/v·v.
fn reflect(v: &[f64], scale: f64, x: &mut [f64]) {
    let k = scale * dot(v, x);
    x.iter_mut().zip(v).for_each(|(x, v)| *x -= k * v);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_polynomial_is_found_again() {
        // Nearly dependent columns: powers up to 9 on [0, 1] have condition 1e7.
        let truth: Vec<f64> = (0..10).map(|k| (k as f64 - 4.5).sin()).collect();
        let rows = (0..200).map(|i| {
            let x = i as f64 / 199.0;
            let row: Vec<f64> = (0..10).map(|k| x.powi(k)).collect();
            let y = dot(&row, &truth);
            (row, [y])
        });
        let [found] = LeastSquares::new(10, rows).solve();
        for (found, truth) in found.iter().zip(&truth) {
            // Rounding times the condition.
            assert!((found - truth).abs() < 1e-8, "{found} {truth}");
        }
    }

    #[test]
    fn the_residual_is_perpendicular_to_the_columns() {
        let row = |i: i32| vec![1.0, f64::from(i), f64::from(i * i)];
        let value = |i: i32| f64::from((i * 7919) % 31);
        let [x] = LeastSquares::new(3, (0..40).map(|i| (row(i), [value(i)]))).solve();
        for c in 0..3 {
            let sum: f64 = (0..40)
                .map(|i| row(i)[c] * (value(i) - dot(&row(i), &x)))
                .sum();
            assert!(sum.abs() < 1e-8, "{c} {sum}");
        }
    }

    #[test]
    fn what_says_nothing_counts_nothing() {
        // A column twice, a column of zeros, and more columns than rows.
        let rows = (0..5).map(|i| {
            let x = f64::from(i);
            (vec![x, x, 0.0, 1.0, x * x, x * x * x, x.powi(4)], [3.0 * x])
        });
        let [x] = LeastSquares::new(7, rows).solve();
        assert!(x.iter().all(|x| x.is_finite()));
        assert!((x[0] + x[1] - 3.0).abs() < 1e-9);
        let [none] = LeastSquares::<1>::new(3, std::iter::empty()).solve();
        assert_eq!(none, [0.0; 3]);
    }
}
