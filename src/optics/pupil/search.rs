//! The search for where a function first becomes positive, as a dialogue: many of them can be led side by side.

/// The outline is found to this part of its distance from the middle.
const TOLERANCE: f64 = 1e-5;

/// Steps 1 + 2^k/64 leave the range of f64 within so many either way.
const MAX_STEPS_OUT: u32 = 61;

/// False position needs a handful of steps; every fourth is a bisection, so that none takes more than 4·17.
const MAX_STEPS: u32 = 80;

/// The search for the smallest t, to [`TOLERANCE`] and not below, where a function becomes positive; it is not at
/// t = 0. Brackets it from a guess by steps that double each time, then narrows the bracket by false
/// position (the Illinois form: Dowell and Jarratt, BIT 11, 1971), with the estimate moved to
/// the far side by half the tolerance so that both ends close in.
#[derive(Clone, Copy, Debug)]
pub(super) struct Search {
    /// Where the function's value is wanted.
    wanted: f64,
    /// The farthest point known where the function is not positive.
    low: Option<End>,
    /// The nearest point known where it is.
    high: Option<End>,
    /// Since the search began, or since there are two ends.
    steps: u32,
    /// Last step outward or inward, relative to t.
    factor: f64,
    /// `Some(true)` if of the two ends the high one moved last.
    high_moved: Option<bool>,
    found: Option<f64>,
}

/// One end of a bracket.
#[derive(Clone, Copy, Debug)]
struct End {
    t: f64,
    value: f64,
}

impl Search {
    /// Begins at `guess`.
    pub(super) fn new(guess: f64) -> Search {
        Search {
            wanted: guess,
            low: None,
            high: None,
            steps: 0,
            factor: 1.0 / 128.0,
            high_moved: None,
            found: None,
        }
    }

    /// The t at which it wants to know the function next.
    pub(super) fn wanted(&self) -> f64 {
        self.wanted
    }

    /// The t that was sought, once it is found.
    pub(super) fn found(&self) -> Option<f64> {
        self.found
    }

    /// Takes the function's value at the t that was wanted.
    pub(super) fn learn(&mut self, value: f64) {
        let outside = value > 0.0 || value.is_nan();
        let narrowing = self.low.is_some() && self.high.is_some();
        let (moves, stays) = match outside {
            true => (&mut self.high, &mut self.low),
            false => (&mut self.low, &mut self.high),
        };
        let end = End {
            t: self.wanted,
            value,
        };
        *moves = Some(end);
        if let (Some(stays), true) = (stays, self.high_moved == Some(outside)) {
            // The end that stays is given half its weight.
            stays.value *= 0.5;
        }
        if narrowing {
            self.high_moved = Some(outside);
        }
        match (self.low, self.high) {
            (Some(low), Some(high)) => {
                self.steps = if narrowing { self.steps + 1 } else { 1 };
                self.narrow(low, high);
            }
            _ => self.step_out(end.t, outside),
        }
    }

    /// Continues from `t` inward if that is `outside`, else outward.
    fn step_out(&mut self, t: f64, outside: bool) {
        self.factor *= 2.0;
        self.steps += 1;
        let step = 1.0 + self.factor;
        self.wanted = if outside { t / step } else { t * step };
        if self.steps == MAX_STEPS_OUT {
            // Nothing inside, or nothing outside.
            self.found = Some(t);
        }
    }

    /// Chooses the next point between two ends.
    fn narrow(&mut self, low: End, high: End) {
        let width = high.t - low.t;
        let tolerance = TOLERANCE * high.t;
        let wide = width > tolerance && high.t.is_finite();
        if !wide || self.steps == MAX_STEPS {
            self.found = Some(high.t);
            return;
        }
        let bisect =
            self.steps.is_multiple_of(4) || !high.value.is_finite() || !low.value.is_finite();
        self.wanted = if bisect {
            low.t + 0.5 * width
        } else {
            let t = low.t + width * low.value / (low.value - high.value);
            let toward = if t - low.t < high.t - t { 0.45 } else { -0.45 };
            let t = t + toward * tolerance;
            t.max(low.t + 0.4 * tolerance).min(high.t - 0.4 * tolerance)
        };
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn first_outside(excess: impl Fn(f64) -> f64, guess: f64) -> f64 {
        let mut search = Search::new(guess);
        loop {
            if let Some(t) = search.found() {
                return t;
            }
            search.learn(excess(search.wanted()));
        }
    }

    #[test]
    fn the_first_change_is_found_in_few_steps() {
        for (edge, guess) in [(1.0, 1.0), (1.0, 1.3), (7.0, 6.9), (1e-6, 1.0), (3.0, 1e-9)] {
            // A kink just inside, as where two apertures meet.
            let excess = |t: f64| {
                let x: f64 = t / edge - 1.0;
                if x > -0.01 {
                    x
                } else {
                    0.3 * (x + 0.01) - 0.01
                }
            };
            let calls = std::cell::Cell::new(0);
            let found = first_outside(
                |t| {
                    calls.set(calls.get() + 1);
                    excess(t)
                },
                guess,
            );
            assert!(excess(found) > 0.0 && excess(found * (1.0 - TOLERANCE)) <= 0.0);
            // Doubling over nine powers of ten takes 30 steps, the rest is false position.
            let limit = if guess / edge > 0.5 && guess / edge < 2.0 {
                16
            } else {
                50
            };
            assert!(calls.get() <= limit, "{edge} {guess}: {}", calls.get());
        }
        // Where rays end without a height, bisection does.
        let wall = |t: f64| if t > 2.5 { f64::INFINITY } else { -1.0 };
        let found = first_outside(wall, 2.0);
        assert!(found > 2.5 && found < 2.5 * (1.0 + TOLERANCE));
        // Nothing outside, nothing inside, nothing at all: it ends.
        assert!(first_outside(|_| -1.0, 1.0) > 1e100);
        assert!(first_outside(|_| 1.0, 1.0) < 1e-100);
        first_outside(|_| f64::NAN, 1.0);
    }
}
