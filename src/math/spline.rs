//! Catmull–Rom splines over unevenly spaced nodes (Pharr, Jakob and Humphreys 2016, §8.6.1, §13.3 and §14.1.4): cubic
//! pieces through the given values, whose slope at a node is that of the chord between its two neighbors; at either end
//! it is the slope of the last chord.
//!
//! Nodes ascend. Two may coincide where two unrelated sides meet: the spline ends there on either side, so that neither
//! overshoots because of the other. There is no piece between them; it is never sampled, and its width is not a
//! divisor. At their position the later one's value is used. Positions outside the nodes, and NaN, have no value.

/// Steps of Newton's method, or of bisection where it fails: each bisection gains a bit, so this is more than a double
/// has.
const MAX_STEPS: usize = 64;

/// The four values that determine the spline at a position, and their weights, whose sum is 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Weights {
    /// Index of the node that the first weight belongs to, plus one. Weights of nonexistent nodes are 0.
    interval: usize,
    last: usize,
    weights: [f32; 4],
}

impl Weights {
    /// The weights at `x`; `None` outside the nodes.
    pub fn new(nodes: &[f32], x: f32) -> Option<Weights> {
        let (&first, &last) = (nodes.first()?, nodes.last()?);
        if !(x >= first && x <= last) || nodes.len() < 2 {
            return None;
        }
        let i = wide(nodes, interval(nodes.len(), |i| nodes[i] <= x))?;
        let width = nodes[i + 1] - nodes[i];
        let t = (x - nodes[i]) / width;
        let (t2, t3) = (t * t, t * t * t);
        // Hermite's basis: values at both ends, then slopes at both ends.
        let mut weights = [0.0, 2.0 * t3 - 3.0 * t2 + 1.0, -2.0 * t3 + 3.0 * t2, 0.0];
        let (slope0, slope1) = (t3 - 2.0 * t2 + t, t3 - t2);
        let [before, after] = neighbors(nodes, i);
        if before < i {
            let chord = slope0 * width / (nodes[i + 1] - nodes[before]);
            weights[0] -= chord;
            weights[2] += chord;
        } else {
            weights[1] -= slope0;
            weights[2] += slope0;
        }
        if after > i + 1 {
            let chord = slope1 * width / (nodes[after] - nodes[i]);
            weights[1] -= chord;
            weights[3] += chord;
        } else {
            weights[1] -= slope1;
            weights[2] += slope1;
        }
        Some(Weights {
            interval: i,
            last: nodes.len() - 1,
            weights,
        })
    }

    /// The indices of the nodes with their weights. (One beyond an end is replaced by the end, with weight 0.)
    pub fn terms(&self) -> [(usize, f32); 4] {
        std::array::from_fn(|k| {
            let node = (self.interval + k).saturating_sub(1).min(self.last);
            (node, self.weights[k])
        })
    }

    /// The weighted sum of the values that `value` returns for each node.
    pub fn sum(&self, value: impl Fn(usize) -> f32) -> f32 {
        self.terms().iter().map(|&(i, w)| w * value(i)).sum()
    }
}

/// The last `i` below `count` - 1 for which `before(i)` holds, if it holds up to some index and not beyond; 0 if it
/// never does. `count` is at least 2.
fn interval(count: usize, before: impl Fn(usize) -> bool) -> usize {
    let (mut low, mut high) = (0, count - 1);
    while high - low > 1 {
        let middle = low + (high - low) / 2;
        if before(middle) {
            low = middle;
        } else {
            high = middle;
        }
    }
    low
}

/// The end nodes of the chords that determine the slopes at both ends of interval `i`: its own nodes where the spline
/// ends, at either end or where two nodes coincide.
fn neighbors(nodes: &[f32], i: usize) -> [usize; 2] {
    let (before, after) = (i.saturating_sub(1), (i + 2).min(nodes.len() - 1));
    let chord_before = nodes[before] < nodes[i];
    let chord_after = nodes[i + 1] < nodes[after];
    [
        if chord_before { before } else { i },
        if chord_after { after } else { i + 1 },
    ]
}

/// The last interval up to index `i` with a nonzero width: `i` itself unless nodes at an end coincide.
fn wide(nodes: &[f32], i: usize) -> Option<usize> {
    (0..=i).rev().find(|&i| nodes[i] < nodes[i + 1])
}

/// One cubic piece over t in 0…1.
#[derive(Clone, Copy, Debug)]
struct Piece {
    /// Values at its ends.
    f: [f64; 2],
    /// Coefficients of t, t² and t³.
    slope: f64,
    square: f64,
    cube: f64,
}

impl Piece {
    fn new(nodes: &[f32], value: &impl Fn(usize) -> f32, i: usize) -> Piece {
        let x = |i: usize| f64::from(nodes[i]);
        let y = |i: usize| f64::from(value(i));
        let (f0, f1) = (y(i), y(i + 1));
        let width = x(i + 1) - x(i);
        let chord = |from: usize, to: usize| width * (y(to) - y(from)) / (x(to) - x(from));
        let [before, after] = neighbors(nodes, i);
        // Slopes at both ends, per unit of t.
        let (d0, d1) = (chord(before, i + 1), chord(i, after));
        Piece {
            f: [f0, f1],
            slope: d0,
            square: 3.0 * (f1 - f0) - 2.0 * d0 - d1,
            cube: 2.0 * (f0 - f1) + d0 + d1,
        }
    }

    fn value(&self, t: f64) -> f64 {
        self.f[0] + t * (self.slope + t * (self.square + t * self.cube))
    }

    /// ∫ from 0 to t.
    fn integral(&self, t: f64) -> f64 {
        let curved = t * (self.square / 3.0 + t * self.cube / 4.0);
        t * (self.f[0] + t * (self.slope / 2.0 + curved))
    }

    fn derivative(&self, t: f64) -> f64 {
        self.slope + t * (2.0 * self.square + t * 3.0 * self.cube)
    }
}

/// Solves the ascending `function` for `wanted` in 0…1, by Newton's method from `guess`, with bisection if a step
/// leaves the bracket. `function` returns value and derivative.
pub fn solve(guess: f64, wanted: f64, function: impl Fn(f64) -> (f64, f64)) -> f64 {
    // Finer than the single precision of the result.
    const ACCURACY: f64 = 1e-9;
    let (mut low, mut high, mut t) = (0.0, 1.0, guess);
    for _ in 0..MAX_STEPS {
        if !(t >= low && t <= high) {
            t = 0.5 * (low + high);
        }
        let (f, slope) = function(t);
        let over = f - wanted;
        if over < 0.0 {
            low = t;
        } else {
            high = t;
        }
        if over == 0.0 || high - low < ACCURACY {
            break;
        }
        let step = over / slope;
        t -= step;
        if step.abs() < ACCURACY {
            break;
        }
    }
    if t.is_finite() {
        t.clamp(0.0, 1.0)
    } else {
        0.5 * (low + high)
    }
}

/// Cumulative integrals of the spline through `value` from the first node to each.
pub fn integrals(nodes: &[f32], value: impl Fn(usize) -> f32) -> Vec<f32> {
    let mut sum = 0.0;
    let pieces = (0..nodes.len().saturating_sub(1)).map(|i| {
        let width = f64::from(nodes[i + 1]) - f64::from(nodes[i]);
        if width > 0.0 {
            sum += width * Piece::new(nodes, &value, i).integral(1.0);
        }
        sum as f32
    });
    std::iter::once(0.0)
        .chain(pieces)
        .take(nodes.len())
        .collect()
}

/// The position at which the spline through the ascending `values` is `wanted`; the nearer end if it never is. `None`
/// without nodes, which must be distinct here.
pub fn invert(nodes: &[f32], values: &[f32], wanted: f32) -> Option<f32> {
    let (&first, &last) = (nodes.first()?, nodes.last()?);
    if nodes.len() < 2 || wanted.is_nan() || wanted <= *values.first()? {
        return Some(first);
    }
    if wanted >= *values.last()? {
        return Some(last);
    }
    let i = interval(nodes.len().min(values.len()), |i| values[i] <= wanted);
    let piece = Piece::new(nodes, &|i| values[i], i);
    let wanted = f64::from(wanted);
    let guess = (wanted - piece.f[0]) / (piece.f[1] - piece.f[0]);
    let t = solve(guess, wanted, |t| (piece.value(t), piece.derivative(t)));
    Some(between(nodes, i, t))
}

/// A position sampled in proportion to a spline.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SplineSample {
    /// The position.
    pub x: f32,
    /// The spline's value there.
    pub value: f32,
    /// Density: the value over the whole integral.
    pub pdf: f32,
}

/// Samples a position in proportion to the spline through `value`, not negative, whose cumulative integrals are
/// `integral`; `u` in [0, 1). `None` if the whole integral is not positive.
pub fn sample(
    nodes: &[f32],
    value: impl Fn(usize) -> f32,
    integral: impl Fn(usize) -> f32,
    u: f32,
) -> Option<SplineSample> {
    let count = nodes.len();
    if count < 2 {
        return None;
    }
    let whole = integral(count - 1);
    if !(whole > 0.0 && whole.is_finite()) {
        return None;
    }
    let wanted = u * whole;
    // Integrals on both sides of a piece without width are equal, so it is never the last.
    let i = wide(nodes, interval(count, |i| integral(i) <= wanted))?;
    let piece = Piece::new(nodes, &value, i);
    let width = f64::from(nodes[i + 1]) - f64::from(nodes[i]);
    let rest = f64::from(wanted - integral(i)) / width;
    let t = solve(linear_guess(piece.f, rest), rest, |t| {
        (piece.integral(t), piece.value(t))
    });
    let value = piece.value(t).max(0.0) as f32;
    Some(SplineSample {
        x: between(nodes, i, t),
        value,
        pdf: value / whole,
    })
}

/// Where the integral of the linear function between two values is `rest`.
fn linear_guess([f0, f1]: [f64; 2], rest: f64) -> f64 {
    if f0 == f1 {
        return rest / f0;
    }
    let root = (f0 * f0 + 2.0 * rest * (f1 - f0)).max(0.0).sqrt();
    (f0 - root) / (f0 - f1)
}

/// The position at `t` of interval `i`.
fn between(nodes: &[f32], i: usize, t: f64) -> f32 {
    let (a, b) = (f64::from(nodes[i]), f64::from(nodes[i + 1]));
    (a + (b - a) * t) as f32
}

#[cfg(test)]
mod tests {
    use super::*;

    const NODES: [f32; 7] = [-1.0, -0.6, 0.1, 0.2, 1.0, 1.5, 3.0];

    fn at(values: &[f32], x: f32) -> f32 {
        Weights::new(&NODES, x).unwrap().sum(|i| values[i])
    }

    #[test]
    fn splines_pass_through_their_values_and_reproduce_lines() {
        let values = [0.3, 1.0, 0.2, 0.5, 2.0, 0.1, 0.7];
        for (x, y) in NODES.iter().zip(values) {
            assert!((at(&values, *x) - y).abs() < 1e-6);
        }
        let line = NODES.map(|x| 2.0 - 0.5 * x);
        for k in 0..=100 {
            let x = -1.0 + 0.04 * k as f32;
            // Rounding of weights that are at most 1.
            assert!((at(&line, x) - (2.0 - 0.5 * x)).abs() < 2e-6, "{x}");
        }
    }

    #[test]
    fn slopes_are_continuous() {
        let values = [0.3, 1.0, 0.2, 0.5, 2.0, 0.1, 0.7];
        for &x in &NODES[1..6] {
            let h = 1e-3;
            let before = (at(&values, x) - at(&values, x - h)) / h;
            let after = (at(&values, x + h) - at(&values, x)) / h;
            // Curvatures up to 200 between the two nodes 0.1 apart, times h.
            assert!((before - after).abs() < 0.2, "{before} and {after} at {x}");
        }
    }

    #[test]
    fn nothing_lies_outside() {
        for x in [-1.001, 3.001, f32::NAN, f32::INFINITY] {
            assert_eq!(Weights::new(&NODES, x), None);
        }
        assert_eq!(Weights::new(&[], 0.0), None);
        assert_eq!(Weights::new(&[1.0], 1.0), None);
    }

    #[test]
    fn integrals_are_those_of_the_pieces() {
        // A straight line is integrated exactly: ∫ (x + 2) = x²/2 + 2x.
        let sums = integrals(&NODES, |i| NODES[i] + 2.0);
        for (sum, x) in sums.iter().zip(NODES) {
            let exact = (0.5 * x * x + 2.0 * x) - (0.5 - 2.0);
            assert!((sum - exact).abs() < 1e-5, "{sum} for {exact}");
        }
    }

    #[test]
    fn inversion_undoes_evaluation() {
        let values = [0.0, 0.1, 0.15, 0.5, 0.6, 2.0, 2.5];
        for k in 0..200 {
            let wanted = 2.5 * (k as f32 + 0.5) / 200.0;
            let x = invert(&NODES, &values, wanted).unwrap();
            assert!((at(&values, x) - wanted).abs() < 1e-5, "{wanted} at {x}");
        }
        assert_eq!(invert(&NODES, &values, -1.0), Some(-1.0));
        assert_eq!(invert(&NODES, &values, 9.0), Some(3.0));
        assert_eq!(invert(&NODES, &values, f32::NAN), Some(-1.0));
    }

    #[test]
    fn samples_follow_the_spline() {
        let values = [0.0, 1.0, 0.9, 0.5, 2.0, 0.7, 0.0];
        let sums = integrals(&NODES, |i| values[i]);
        let whole = sums[6];
        let n = 10_000;
        for k in 0..n {
            let u = (k as f32 + 0.5) / n as f32;
            let s = sample(&NODES, |i| values[i], |i| sums[i], u).unwrap();
            assert!((s.value - at(&values, s.x).max(0.0)).abs() < 1e-5);
            assert!((s.pdf * whole - s.value).abs() < 1e-6);
            // The fraction of the integral before the sample is u.
            let i = NODES.iter().rposition(|&x| x <= s.x).unwrap().min(5);
            let piece = Piece::new(&NODES, &|i| values[i], i);
            let width = f64::from(NODES[i + 1] - NODES[i]);
            let t = f64::from(s.x - NODES[i]) / width;
            let before = f64::from(sums[i]) + width * piece.integral(t);
            assert!((before as f32 / whole - u).abs() < 1e-5, "{u}: {before}");
        }
    }

    /// Nodes may coincide: the spline has a kink or step there. Their distance is never a divisor, and the piece
    /// between them never sampled.
    #[test]
    fn nodes_that_stand_twice_have_no_piece_between_them() {
        const TWICE: [f32; 8] = [-1.0, -0.6, -0.1, 0.0, 0.0, 0.1, 0.7, 1.0];
        const THRICE: [f32; 8] = [-1.0, -0.6, 0.0, 0.0, 0.0, 0.1, 1.0, 1.0];
        const ENDS: [f32; 8] = [-1.0, -1.0, 0.0, 0.0, 0.0, 0.1, 1.0, 1.0];
        let values = [0.4, 1.0, 0.9, 0.5, 2.0, 2.7, 0.3, 0.2];
        for nodes in [TWICE, THRICE, ENDS] {
            let sums = integrals(&nodes, |i| values[i]);
            assert!(sums.iter().all(|sum| sum.is_finite()), "{sums:?}");
            let whole = sums[7];
            let value = |x: f32| Weights::new(&nodes, x).unwrap().sum(|i| values[i]);
            for x in [-1.0, -0.5, -1e-20, -0.0, 0.0, 1e-20, 0.05, 1.0] {
                let weights = Weights::new(&nodes, x).unwrap();
                let sum: f32 = weights.sum(|_| 1.0);
                // Rounding of weights that are at most 1.
                assert!((sum - 1.0).abs() < 2e-6, "{weights:?} at {x} of {nodes:?}");
                assert!(value(x).is_finite());
            }
            // At the node itself the value is that of the later one.
            let at_zero = nodes.iter().rposition(|&x| x == 0.0).unwrap();
            assert_eq!(value(0.0), values[at_zero]);
            // Neither side depends on the other.
            let other_side = |i: usize| values[i] + if i >= at_zero { 7.0 } else { 0.0 };
            let beside = Weights::new(&nodes, -1e-3).unwrap().sum(other_side);
            assert_eq!(beside, value(-1e-3));
            for k in 0..2000 {
                let u = k as f32 / 2000.0;
                let s = sample(&nodes, |i| values[i], |i| sums[i], u).unwrap();
                assert!(
                    s.x.is_finite() && s.pdf >= 0.0 && s.pdf.is_finite(),
                    "{s:?}"
                );
                assert!((s.pdf * whole - s.value).abs() < 1e-6);
                let i = nodes.iter().rposition(|&x| x <= s.x).unwrap();
                let i = (0..=i.min(6)).rfind(|&i| nodes[i + 1] > nodes[i]).unwrap();
                let piece = Piece::new(&nodes, &|i| values[i], i);
                let width = f64::from(nodes[i + 1]) - f64::from(nodes[i]);
                let t = (f64::from(s.x) - f64::from(nodes[i])) / width;
                let before = f64::from(sums[i]) + width * piece.integral(t);
                assert!((before as f32 / whole - u).abs() < 1e-5, "{u}: {before}");
            }
        }
    }

    #[test]
    fn nothing_is_drawn_from_nothing() {
        let draw = |values: [f32; 7]| {
            let sums = integrals(&NODES, |i| values[i]);
            sample(&NODES, |i| values[i], |i| sums[i], 0.5)
        };
        assert_eq!(draw([0.0; 7]), None);
        assert_eq!(draw([f32::NAN; 7]), None);
        assert_eq!(draw([f32::INFINITY; 7]), None);
    }
}
