//! One direction of a separable kernel: weights of some texels in a row.

use crate::assets::ptex::Border;

/// Most texels that a kernel covers in a direction.
pub(super) const MAX_TAPS: usize = 8;

/// Weights of neighboring texels in one direction of a face.
#[derive(Clone, Copy, Debug)]
pub(super) struct Axis {
    /// The face has 2^`log2` texels in this direction.
    pub log2: u8,
    /// Where the first weight's texel is; those below 0 are beyond the face's low edge.
    pub start: i32,
    taps: usize,
    weights: [f32; MAX_TAPS],
}

/// Cubic B-spline (Mitchell and Netravali 1988, B = 1, C = 0), of width 4.
fn bspline(x: f32) -> f32 {
    let x = x.abs();
    if x < 1.0 {
        (0.5 * x - 1.0) * x * x + 2.0 / 3.0
    } else if x < 2.0 {
        let rest = 2.0 - x;
        rest * rest * rest / 6.0
    } else {
        0.0
    }
}

/// Cubic Hermite step of width 2, about one and a half times as blurred as [`bspline`] in units of its
/// own width.
fn hermite(x: f32) -> f32 {
    let x = x.abs();
    if x < 1.0 {
        (2.0 * x - 3.0) * x * x + 1.0
    } else {
        0.0
    }
}

impl Axis {
    /// A kernel around `u`, in units of the face, for a footprint of this width; of a face of 2^`finest`
    /// texels.
    ///
    /// The resolution is the coarsest with texels no wider than the footprint, so that the B-spline
    /// covers four to eight of them. Beyond a quarter of a face it would reach past neighbors on both
    /// sides: first its width stays that of four texels of a quarter each, then two texels a face, and in
    /// the end one, are interpolated by Hermite steps.
    pub(super) fn new(u: f32, width: f32, finest: u8) -> Axis {
        let width = width.max(1.0 / (1u32 << finest) as f32);
        if width >= 1.0 {
            let at = u - 0.5;
            let low = at.floor();
            let first = hermite(at - low);
            let weights = [first, 1.0 - first];
            return Axis::of(0, low as i32, 2, |i| weights[i & 1]);
        }
        if width >= 0.5 {
            let at = 2.0 * u - 0.5;
            let start = 2 * (u - 0.5).floor() as i32;
            let scale = 1.0 / (1.5 * width + 0.5);
            return Axis::of(1, start, 4, |i| {
                hermite(((start + i as i32) as f32 - at) * scale)
            });
        }
        if width >= 0.25 {
            return Axis::around(2, 4.0 * u - 0.5, 1.0);
        }
        // 2^-log2 ≤ width < 2^(1 - log2), from the exponent: no logarithm is rounded.
        let log2 = (127 - (width.to_bits() >> 23) as i32).clamp(0, i32::from(finest)) as u8;
        let texels = (1u32 << log2) as f32;
        Axis::around(log2, u * texels - 0.5, width * texels)
    }

    /// A B-spline around `at`, in texels from the first one's center, stretched by `width`.
    fn around(log2: u8, at: f32, width: f32) -> Axis {
        let [start, end] = [at - 2.0 * width, at + 2.0 * width].map(|x| x.ceil() as i32);
        let taps = (end - start).clamp(0, MAX_TAPS as i32) as usize;
        Axis::of(log2, start, taps, |i| {
            bspline(((start + i as i32) as f32 - at) / width)
        })
    }

    /// With these weights, less the zeros at both ends.
    fn of(log2: u8, start: i32, taps: usize, weight: impl Fn(usize) -> f32) -> Axis {
        let mut axis = Axis {
            log2,
            start,
            taps,
            weights: std::array::from_fn(|i| if i < taps { weight(i) } else { 0.0 }),
        };
        let zeros = axis.weights().iter().take_while(|&&w| w == 0.0).count();
        axis.drop_first(zeros);
        let last = axis.weights().iter().rposition(|&w| w != 0.0);
        axis.taps = last.map_or(0, |last| last + 1);
        axis
    }

    /// Texels of the face in this direction.
    pub(super) fn size(&self) -> i32 {
        1 << self.log2
    }

    /// The weights.
    #[inline]
    pub(super) fn weights(&self) -> &[f32] {
        &self.weights[..self.taps]
    }

    /// One past the last weight's texel.
    pub(super) fn end(&self) -> i32 {
        self.start + self.taps as i32
    }

    /// Sum of the weights.
    pub(super) fn sum(&self) -> f32 {
        self.weights().iter().sum()
    }

    fn drop_first(&mut self, count: usize) {
        let count = count.min(self.taps);
        self.weights.copy_within(count..self.taps, 0);
        self.start += count as i32;
        self.taps -= count;
    }

    /// Takes off what is beyond the edge: the high one, or the low one. It is then counted from the
    /// neighbor's edge, as if this was turned as the face is.
    pub(super) fn split(&mut self, high: bool) -> Axis {
        let size = self.size();
        let mut beyond = *self;
        if high {
            let inside = (size - self.start).clamp(0, self.taps as i32) as usize;
            self.taps = inside;
            beyond.drop_first(inside);
            beyond.start -= size;
        } else {
            let outside = (-self.start).clamp(0, self.taps as i32) as usize;
            beyond.taps = outside;
            beyond.start += size;
            self.drop_first(outside);
        }
        beyond
    }

    /// Where there is no neighbor, what is beyond the edge counts for the outermost texel, or for
    /// nothing.
    pub(super) fn merge(&mut self, high: bool, border: Border) {
        let size = self.size();
        let beyond = self.split(high);
        if border == Border::Black || beyond.taps == 0 {
            return;
        }
        let sum = beyond.sum();
        match (self.taps, high) {
            (0, _) => {
                self.taps = 1;
                self.start = if high { size - 1 } else { 0 };
                self.weights[0] = sum;
            }
            (taps, true) => self.weights[taps - 1] += sum,
            (_, false) => self.weights[0] += sum,
        }
    }

    /// Seen from the other end.
    pub(super) fn flip(&mut self) {
        self.start = self.size() - self.end();
        self.weights[..self.taps].reverse();
    }

    /// For texels twice as wide: the weights of each two are added up.
    pub(super) fn halve(&mut self) {
        let first = self.start.div_euclid(2);
        let mut sums = [0.0; MAX_TAPS];
        for (i, weight) in (self.start..).zip(self.weights()) {
            sums[(i.div_euclid(2) - first) as usize] += weight;
        }
        let last = (self.end() - 1).div_euclid(2);
        self.taps = if self.taps == 0 {
            0
        } else {
            (last - first + 1) as usize
        };
        self.start = first;
        self.weights = sums;
        self.log2 -= 1;
    }

    /// For texels half as wide: each weight is divided among two. Only kernels of few texels may be.
    fn double(&mut self) {
        self.weights = std::array::from_fn(|i| 0.5 * self.weights[i / 2]);
        self.taps = (2 * self.taps).min(MAX_TAPS);
        self.start *= 2;
        self.log2 += 1;
    }

    /// Counted in faces half as large, from the low end of the same face: where that has a single texel
    /// it is cut in two first.
    pub(super) fn enter_half_face(&mut self) {
        if self.log2 == 0 {
            self.double();
        }
        self.log2 -= 1;
    }

    /// Counted in faces twice as large; `in_high_half` tells which half of them this one is.
    pub(super) fn leave_half_face(&mut self, in_high_half: bool) {
        if in_high_half {
            self.start += self.size();
        }
        self.log2 += 1;
    }

    /// Drops all but the texels of the face.
    pub(super) fn clip(&mut self) {
        self.split(false);
        self.split(true);
    }

    /// Drops all but the first `taps` weights.
    fn truncate(&mut self, taps: usize) {
        self.taps = self.taps.min(taps);
    }

    /// Makes two kernels that start in a corner the same: the sum of both, as far as the shorter goes.
    /// Gives the sum of its weights. Faces around a corner of five or more are then all alike.
    pub(super) fn make_equal(a: &mut Axis, b: &mut Axis) -> f32 {
        while a.log2 > b.log2 {
            a.halve();
        }
        while b.log2 > a.log2 {
            b.halve();
        }
        a.truncate(b.taps);
        b.truncate(a.taps);
        for i in 0..a.taps {
            a.weights[i] += b.weights[i];
        }
        b.weights = a.weights;
        b.start = a.start;
        a.sum()
    }

    /// Times a factor.
    pub(super) fn scale(&mut self, factor: f32) {
        self.weights.iter_mut().for_each(|w| *w *= factor);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn all() -> impl Iterator<Item = (f32, f32, u8)> {
        let us = (0..=40).map(|i| i as f32 / 40.0);
        us.flat_map(|u| {
            let widths = (0..60).map(|i| 0.002 * 1.15f32.powi(i));
            widths.flat_map(move |w| [0, 1, 2, 3, 8].map(|finest| (u, w, finest)))
        })
    }

    #[test]
    fn kernels_stay_within_a_face_of_their_own() {
        for (u, width, finest) in all() {
            let axis = Axis::new(u, width, finest);
            assert!(axis.log2 <= finest, "{u} {width} {finest}");
            assert!(axis.start >= -axis.size() && axis.end() <= 2 * axis.size());
            assert!(!axis.weights().is_empty() && axis.sum() > 0.0);
            assert!(axis.weights().iter().all(|w| w.is_finite() && *w >= 0.0));
        }
    }

    #[test]
    fn bsplines_add_up_to_the_same_everywhere() {
        // A stretched one is sampled often enough: its sum over texels varies by next to nothing.
        for (u, width, finest) in all().filter(|(_, w, f)| *w < 0.25 && *f == 8) {
            let axis = Axis::new(u, width, finest);
            let stretch = width.max(1.0 / 256.0) * axis.size() as f32;
            // The B-spline's integral is 1; its spectrum at one cycle a texel is sinc⁴(stretch), 0 at 1
            // and below 0.005 up to 2.
            assert!(
                (axis.sum() / stretch - 1.0).abs() < 0.011,
                "{}",
                axis.sum() / stretch
            );
        }
    }

    #[test]
    fn splitting_and_merging_keep_the_sum() {
        for (u, width, finest) in all() {
            let whole = Axis::new(u, width, finest);
            for high in [false, true] {
                let mut inside = whole;
                let beyond = inside.split(high);
                assert!((inside.sum() + beyond.sum() - whole.sum()).abs() < 1e-5);
                assert!(beyond.weights().is_empty() || (beyond.start >= 0 || !high));
                let mut merged = whole;
                merged.merge(high, Border::Clamp);
                assert!((merged.sum() - whole.sum()).abs() < 1e-5);
                let mut dark = whole;
                dark.merge(high, Border::Black);
                assert_eq!(dark.sum(), inside.sum());
            }
            let mut flipped = whole;
            flipped.flip();
            assert!((flipped.sum() - whole.sum()).abs() < 1e-5);
            flipped.flip();
            assert_eq!(
                (flipped.start, flipped.weights()),
                (whole.start, whole.weights())
            );
        }
    }

    #[test]
    fn halving_and_doubling_keep_sum_and_place() {
        let mean = |a: &Axis| {
            let at = |i: i32| (i as f32 + 0.5) / a.size() as f32;
            let sum: f32 = (a.start..).zip(a.weights()).map(|(i, w)| at(i) * w).sum();
            sum / a.sum()
        };
        for (u, width, finest) in all() {
            let whole = Axis::new(u, width, finest);
            if whole.log2 > 0 {
                let mut half = whole;
                half.halve();
                assert!((half.sum() - whole.sum()).abs() < 1e-5);
                // By half a wider texel at most.
                assert!((mean(&half) - mean(&whole)).abs() <= 0.5 / half.size() as f32);
            } else {
                let mut double = whole;
                double.double();
                assert!((double.sum() - whole.sum()).abs() < 1e-5);
                assert!((mean(&double) - mean(&whole)).abs() < 1e-5);
            }
        }
    }
}
