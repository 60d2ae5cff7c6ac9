//! What counts as right: "as good as the data".
//!
//! An answer is right when it differs from the exact one no more than exact answers for data that are off by a few
//! roundings do. That holds however ill-conditioned the question is, and is as strict as can be where it is not.

use super::exact_optics::dd::Dd;
use super::exact_optics::{ExactLens, Outcome};
use fstop::optics::Cause;

/// Half a unit in the last place of 1, in f64 ...
pub(super) const DOUBLE: f64 = f64::EPSILON / 2.0;
/// ... and f32.
pub(super) const SINGLE: f64 = f32::EPSILON as f64 / 2.0;

/// What a tracer answers: position and direction, or where and why the ray ended; lanes do not say.
pub(super) type Found = Result<([f64; 3], [f64; 3]), Option<(usize, Cause)>>;

/// The exact answer, and those for data that are off by some roundings.
pub(super) struct Neighborhood {
    center: Outcome,
    shaken: Vec<Outcome>,
    /// Relative rounding of the number type, times the square of the largest index.
    epsilon: f64,
}

/// Every number of lens and ray is off by this many roundings, times the square of the largest index: what a few
/// operations on each of them make. (Cosines carry an absolute rounding, which enters Snell's law times (n/n')².)
pub(super) const ROUNDINGS: f64 = 16.0;

/// Patterns of up and down that are tried.
pub(super) const PATTERNS: u64 = 12;

impl Neighborhood {
    /// Of the ray from `o` (z from the last vertex where `behind`) along `d`.
    pub(super) fn new(
        lens: &ExactLens,
        o: [f64; 3],
        d: [f64; 3],
        behind: bool,
        epsilon: f64,
    ) -> Neighborhood {
        let trace = |lens: &ExactLens, o: [f64; 3], d: [f64; 3]| {
            let mut o = o.map(Dd::from);
            if behind {
                o[2] = o[2] + lens.length();
            }
            lens.trace(o, d.map(Dd::from))
        };
        let strongest = lens.rows.iter().map(|r| r.index.hi).fold(1.0, f64::max);
        let epsilon = epsilon * strongest * strongest;
        let by = ROUNDINGS * epsilon;
        let shaken = (1..=PATTERNS).map(|pattern| {
            let shake = |x: f64, bit: u64| {
                x * if pattern >> bit & 1 == 0 {
                    1.0 + by
                } else {
                    1.0 - by
                }
            };
            let o = [shake(o[0], 0), shake(o[1], 1), shake(o[2], 2)];
            let length = d.iter().map(|x| x * x).sum::<f64>().sqrt();
            let turn = |x: f64, bit: u64| x + (shake(length, bit) - length);
            let d = [turn(d[0], 1), turn(d[1], 2), turn(d[2], 0)];
            trace(&lens.shaken(by, pattern), o, d)
        });
        Neighborhood {
            center: trace(lens, o, d),
            shaken: shaken.collect(),
            epsilon,
        }
    }

    /// Lies the rim that ended the ray farther from it than roundings carry it? A pinhole may be so small that none of the
    /// patterns finds it.
    fn clear_of_the_rim(&self) -> bool {
        let (Err((_, Cause::Vignetted)), Some((rim, [x, y]))) = (self.center.end, self.center.last)
        else {
            return true;
        };
        let others = self.shaken.iter().filter_map(|o| o.last);
        let carried = others
            .map(|(_, [u, v])| (u - x).hypot(v - y))
            .fold(0.0, f64::max);
        x.hypot(y) - 2.0 * carried > rim
    }

    /// Is what was found one of these answers?
    pub(super) fn holds(&self, found: Found, length: f64) -> Result<(), String> {
        // What roundings decide, or what lies on the very edge of two things, may end either way.
        let end = |o: &Outcome| o.end.err();
        let decided = self.shaken.iter().all(|o| end(o) == end(&self.center))
            && self.center.margin > 4.0 * ROUNDINGS * self.epsilon
            && self.clear_of_the_rim();
        let (exact, (o, d)) = match (&self.center.end, found) {
            (Ok(exact), Ok(found)) => (exact, found),
            // Lanes say that a ray ended, not where.
            (Err(_), Err(None)) => return Ok(()),
            (Err(exact), Err(Some(found))) if *exact == found => return Ok(()),
            _ if !decided => return Ok(()),
            (exact, found) => return Err(format!("found {found:?}, exact {exact:?}")),
        };
        // Nor can it be told how far a ray may be off that hardly any of its neighbors follows.
        if self.shaken.iter().filter(|o| o.end.is_ok()).count() < self.shaken.len() / 2 {
            return Ok(());
        }
        let difference = |a: [f64; 3], b: [Dd; 3]| -> f64 {
            (0..3)
                .map(|i| (Dd::from(a[i]) - b[i]).hi.abs())
                .fold(0.0, f64::max)
        };
        let difference_from = |a: [Dd; 3], b: [Dd; 3]| difference(a.map(|x| x.hi), b);
        let mut spread = [0.0f64; 2];
        for (o, d) in self.shaken.iter().filter_map(|o| o.end.as_ref().ok()) {
            spread[0] = spread[0].max(difference_from(exact.0, *o));
            spread[1] = spread[1].max(difference_from(exact.1, *d));
        }
        let size = exact.0.iter().map(|x| x.hi.abs()).fold(length, f64::max);
        // The rounding of the answer itself comes on top, and z is a sum with the lens's length.
        let most = [
            4.0 * spread[0] + 4.0 * self.epsilon * size,
            4.0 * spread[1] + 4.0 * self.epsilon,
        ];
        let errors = [difference(o, exact.0), difference(d, exact.1)];
        let right = errors.iter().zip(&most).all(|(error, most)| error <= most);
        right.then_some(()).ok_or_else(|| {
            format!("off by {errors:?}, at most {most:?}: {o:?} {d:?}, exact {exact:?}")
        })
    }
}
