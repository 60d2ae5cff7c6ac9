//! Numbers for choosing one of several things, and a point of it.

use super::SampleStream;
use crate::math::Vec2;
use crate::math::hash::{mix2, unit_float};
use crate::math::sampling::BELOW_ONE;

/// Numbers for the choice of one of several things, and for a point of the one that is chosen.
///
/// Low-discrepancy points choose by their own first number, stretched afterwards over what would have chosen the same: the points of each
/// thing of a probability of 1/256 and more are stratified nearly as if it were the only one (exactly, if what chooses it is an elementary interval). Independent
/// points gain nothing by that, and a grid of n² cells would choose by n columns instead of n² intervals: both have another number for the choice.
#[derive(Clone, Copy, Debug)]
pub struct ChoiceSample {
    /// Chooses, in [0, 1).
    pub choice: f32,
    point: Vec2,
    /// The point's first number is that which chooses.
    is_shared: bool,
}

/// Things less probable than this have another number: the one that chose them has too few digits left.
pub(crate) const MIN_SHARED: f32 = 1.0 / 256.0;

impl ChoiceSample {
    /// By a pair of low-discrepancy points, whose first number chooses if it `is_choice`.
    #[inline(always)]
    pub fn shared(point: Vec2, is_choice: bool) -> ChoiceSample {
        ChoiceSample {
            choice: if is_choice { point.x } else { 0.0 },
            point,
            is_shared: is_choice,
        }
    }

    /// With the choice from part `number` of `all` equal parts of [0, 1).
    pub fn within(mut self, number: u32, all: u32) -> ChoiceSample {
        self.choice = ((number as f32 + self.choice) / all as f32).min(BELOW_ONE);
        self
    }

    /// The point of a thing that is chosen with this probability; `rest` in [0, 1) is the place of [`ChoiceSample::choice`] among the numbers that choose
    /// it.
    pub fn point(&self, probability: f32, rest: f32) -> Vec2 {
        let Vec2 { x, y } = self.point;
        match self.is_shared {
            true if probability >= MIN_SHARED => Vec2::new(rest.min(BELOW_ONE), y),
            true => Vec2::new(unit_float(mix2(x.to_bits().into(), y.to_bits().into())), y),
            false => self.point,
        }
    }
}

impl SampleStream {
    /// The next number for a choice, if it `is_choice`, and the next pair.
    #[inline]
    pub fn next_choice(&mut self, is_choice: bool) -> ChoiceSample {
        if matches!(self, SampleStream::Sobol(_)) {
            self.skip_1d();
            return ChoiceSample::shared(self.next_2d(), is_choice);
        }
        ChoiceSample {
            choice: self.next_1d_if(is_choice),
            point: self.next_2d(),
            is_shared: false,
        }
    }
}

#[cfg(test)]
mod tests {
    use crate::math::{IVec2, Vec2};
    use crate::samplers::{Points, Sampler, SamplerSpec, Stratified};

    /// Of things; the last is so improbable that its points have a number of their own.
    const PROBABILITIES: [f32; 3] = [0.25, 0.748, 0.002];

    /// The thing that a number chooses, and the number's place among those that do.
    fn choose(choice: f32) -> (usize, f32) {
        let [first, second, third] = PROBABILITIES;
        match choice {
            c if c < first => (0, c / first),
            c if c < first + second => (1, (c - first) / second),
            c => (2, (c - first - second) / third),
        }
    }

    /// The points of each thing, with `all` choices for each of `count` samples.
    fn points(spec: &SamplerSpec, count: u32, all: u32) -> [Vec<Vec2>; 3] {
        let sampler = Sampler::new(spec, 7);
        let mut points = [vec![], vec![], vec![]];
        for i in 0..count {
            let mut stream = sampler.stream(IVec2::ZERO, i);
            for number in 0..all {
                let numbers = stream.next_choice(true).within(number, all);
                let part = numbers.choice * all as f32 - number as f32;
                // Rounded once, near 3 at most.
                assert!((-2e-7..1.0 + 2e-7).contains(&part), "{part}");
                let (chosen, rest) = choose(numbers.choice);
                points[chosen].push(numbers.point(PROBABILITIES[chosen], rest));
            }
        }
        points
    }

    #[test]
    fn things_are_chosen_as_often_as_they_should_be_and_their_points_are_uniform() {
        let grid = Points::Stratified(Stratified::new(16, 16, true, None));
        let of = |points| SamplerSpec {
            points,
            ..SamplerSpec::random(256)
        };
        for kind in [Points::Sobol, Points::Random, grid] {
            for all in [1, 3] {
                let count = 65_536;
                for (points, p) in points(&of(kind), count, all).iter().zip(PROBABILITIES) {
                    let expected = p * (count * all) as f32;
                    let met = points.len() as f32;
                    // Five standard errors of independent choices; others scatter less.
                    assert!(
                        (met - expected).abs() < 5.0 * expected.sqrt(),
                        "{kind:?}: {met}, {expected}"
                    );
                    let mut cells = [0.0; 16];
                    for point in points {
                        assert!(point.min_element() >= 0.0 && point.max_element() < 1.0);
                        cells[(point.x * 4.0) as usize * 4 + (point.y * 4.0) as usize] += 1.0;
                    }
                    let mean = met / 16.0;
                    let chi2: f32 = cells.iter().map(|n| (n - mean) * (n - mean) / mean).sum();
                    // The chi-squared distribution with 15 degrees of freedom has more once in 100,000 times.
                    assert!(chi2 < 50.5, "{kind:?}, {all}: {chi2}");
                }
            }
        }
    }

    #[test]
    fn points_of_a_thing_are_stratified_as_if_it_were_the_only_one() {
        let [quarter, ..] = points(&SamplerSpec::sobol(256), 256, 1);
        assert_eq!(quarter.len(), 64);
        let strata = |of: fn(&Vec2) -> f32| {
            let mut met: Vec<usize> = quarter.iter().map(|p| (of(p) * 64.0) as usize).collect();
            met.sort_unstable();
            met
        };
        let each: Vec<usize> = (0..64).collect();
        assert_eq!(strata(|p| p.x), each);
        assert_eq!(strata(|p| p.y), each);
    }
}
