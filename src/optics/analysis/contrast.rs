//! The sign of contrast: where black and white change places.

/// Largest step in frequency between values whose phases are compared, line pairs per mm.
pub(super) const STEP: f64 = 2.0;

/// Follows an optical transfer function from frequency zero on, and gives its modulus a sign.
///
/// Where the function passes through zero its phase jumps by half a turn, and black and white change places: that is spurious
/// resolution (Goodman, *Introduction to Fourier Optics*, §6.4.4), and the sign changes. The phase of an unsymmetrical spot drifts
/// besides, which moves the lines and reverses nothing. So each value is compared with where the phase would be if it continued to turn as
/// before: nearer to half a turn from there than to none is a jump. Past a zero that is missed by little the phase turns quickly, which says
/// nothing of how it continues.
#[derive(Clone, Copy, Debug)]
pub(super) struct Follower {
    /// The last value that was not zero, with its sign.
    last: [f64; 2],
    /// What turns a value into the next where nothing jumps, of modulus 1.
    turn: [f64; 2],
    sign: f64,
}

impl Default for Follower {
    /// At frequency zero.
    fn default() -> Follower {
        Follower {
            last: [1.0, 0.0],
            turn: [1.0, 0.0],
            sign: 1.0,
        }
    }
}

impl Follower {
    /// From a value whose contrast is known; the next ones may be values at other frequencies or other planes.
    pub(super) fn starting_at(value: [f64; 2], contrast: f64) -> Follower {
        let sign = 1f64.copysign(contrast);
        Follower {
            last: value.map(|x| sign * x),
            turn: [1.0, 0.0],
            sign,
        }
    }

    /// The modulus of the next value \[real, imaginary\] with its sign.
    pub(super) fn next(&mut self, value: [f64; 2]) -> f64 {
        let turned = times(value, conjugate(self.last));
        let size = turned[0].hypot(turned[1]);
        if !(size > 0.0 && size.is_finite()) {
            return 0.0;
        }
        let mut turn = turned.map(|x| self.sign * x / size);
        let mut along = times(turn, conjugate(self.turn))[0];
        if along < 0.0 {
            self.sign = -self.sign;
            turn = turn.map(|x| -x);
            along = -along;
        }
        // An eighth of a turn: a drift changes by less from step to step.
        if along > std::f64::consts::FRAC_1_SQRT_2 {
            self.turn = turn;
        }
        self.last = value.map(|x| self.sign * x);
        self.sign * value[0].hypot(value[1])
    }
}

/// The product of two complex numbers.
pub(super) fn times(a: [f64; 2], b: [f64; 2]) -> [f64; 2] {
    [a[0] * b[0] - a[1] * b[1], a[0] * b[1] + a[1] * b[0]]
}

fn conjugate([re, im]: [f64; 2]) -> [f64; 2] {
    [re, -im]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A slit's image, sin x / x, changes its sign at each multiple of π, and wherever it lies: a shift turns the phase evenly.
    #[test]
    fn zeros_change_the_sign_and_shifts_do_not() {
        for shift in [0.0, 0.4, -1.1] {
            let mut follower = Follower::default();
            for i in 1..200 {
                let x = 0.1 * f64::from(i) + 0.05;
                let value = x.sin() / x;
                let (sin, cos) = (shift * f64::from(i)).sin_cos();
                let found = follower.next([value * cos, value * sin]);
                // A dozen roundings.
                assert!((found - value).abs() < 1e-14, "{shift} {x}: {found}");
            }
        }
    }

    /// A spot with one long tail, e⁻ˣ from 0 on: 1 / (1 + iν) is never zero, though about the centroid its phase, ν − atan ν, makes
    /// many turns.
    #[test]
    fn a_drifting_phase_reverses_nothing() {
        let mut follower = Follower::default();
        for i in 1..300 {
            let v = 0.1 * f64::from(i);
            let (sin, cos) = v.sin_cos();
            let value = times([cos, sin], [1.0 / (1.0 + v * v), -v / (1.0 + v * v)]);
            let found = follower.next(value);
            assert!((found - 1.0 / v.hypot(1.0)).abs() < 1e-14, "{v}: {found}");
        }
    }

    /// Symmetric but for a little: the zero of cos x is missed by 0.05, in steps that are coarse beside it. Whether black and white then
    /// change places is a matter of taste, but they do so once.
    #[test]
    fn near_a_zero_the_sign_changes_once_at_most() {
        for step in [0.03, 0.1, 0.3, 0.7] {
            let mut follower = Follower::default();
            let count = (3.0 / step) as i32;
            let values = (0..=count).map(|i| f64::from(i) * step);
            let signs: Vec<bool> = values
                .map(|x| follower.next([x.cos(), 0.05 * x.sin()]) < 0.0)
                .collect();
            let changes = signs.windows(2).filter(|pair| pair[0] != pair[1]).count();
            assert!(changes <= 1, "{step}: {signs:?}");
        }
    }

    #[test]
    fn nothing_is_no_contrast() {
        let mut follower = Follower::default();
        for value in [[0.0, 0.0], [f64::NAN, 0.0], [f64::INFINITY, 0.0]] {
            assert_eq!(follower.next(value), 0.0);
        }
        assert_eq!(follower.next([0.5, 0.0]), 0.5);
    }
}
