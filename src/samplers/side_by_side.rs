//! 2-D samples of many streams, computed together: the same as those that each would draw by itself.

use super::SampleStream;
use super::choice::ChoiceSample;
use super::sobol::{Kind, ScrambledPoints, points_in_sets};
use crate::math::Vec2;
use crate::math::instruction_set::{Instructions, Kernel, WIDEST, vectorize};
use std::num::NonZeroU32;

/// The next 2-D sample of each of some streams. Where it is not known yet, it is [requested](Pairs::ask) for vertex, or pixel, `whose` of the caller's; requests are
/// [computed](Pairs::compute) together and [answered](Pairs::answer) one by one. Between request and answer nothing else is drawn from the stream. Only
/// Owen-scrambled points are worth that; `N` is a multiple of [`WIDEST`].
#[derive(Clone, Debug)]
pub struct Pairs<const N: usize> {
    /// Requests.
    asked: usize,
    /// Points of each set, as in [`Kind::Hammersley`].
    count: Option<NonZeroU32>,
    /// Of each request: `indices` are the samples' of [`Kind`], `numbers` those of the sets of dimensions.
    whose: [u32; N],
    seeds: [u64; N],
    indices: [u32; N],
    numbers: [u32; N],
    /// The sets' coordinates.
    values: [[f32; N]; 4],
}

impl<const N: usize> Default for Pairs<N> {
    fn default() -> Pairs<N> {
        Pairs {
            asked: 0,
            count: None,
            whose: [0; N],
            seeds: [0; N],
            indices: [0; N],
            numbers: [0; N],
            values: [[0.0; N]; 4],
        }
    }
}

impl<const N: usize> Pairs<N> {
    /// Drops all requests.
    #[inline(always)]
    pub fn clear(&mut self) {
        self.asked = 0;
    }

    /// The stream's next pair, as [`SampleStream::next_2d`] has it, or `None`: then it is requested.
    #[inline(always)]
    pub fn ask(&mut self, stream: &mut SampleStream, whose: usize) -> Option<Vec2> {
        let SampleStream::Sobol(own) = stream else {
            return Some(stream.next_2d());
        };
        if let Some(known) = own.next_known_2d() {
            return Some(known);
        }
        let (index, count) = match own.points.kind {
            Kind::Sequence { index_reversed } => (index_reversed, None),
            Kind::Hammersley { index, count } => (index, Some(count)),
        };
        if self.asked == 0 {
            self.count = count;
        }
        let i = self.asked;
        if i == N || count != self.count {
            return Some(own.next_2d());
        }
        self.whose[i] = whose as u32;
        self.indices[i] = index;
        (self.seeds[i], self.numbers[i]) = (own.points.seed, own.begin_pair());
        self.asked += 1;
        None
    }

    /// The stream's next choice, as [`SampleStream::next_choice`] has it, or `None`: then a 2-D sample is requested, from which it [follows](ChoiceSample::shared).
    #[inline(always)]
    pub fn ask_choice(
        &mut self,
        stream: &mut SampleStream,
        is_choice: bool,
        whose: usize,
    ) -> Option<ChoiceSample> {
        if !matches!(stream, SampleStream::Sobol(_)) {
            return Some(stream.next_choice(is_choice));
        }
        stream.skip_1d();
        let known = self.ask(stream, whose)?;
        Some(ChoiceSample::shared(known, is_choice))
    }

    /// Computes all requests.
    pub fn compute(&mut self) {
        const { assert!(N.is_multiple_of(WIDEST)) };
        let few = self.asked % WIDEST;
        let beyond = self.asked.next_multiple_of(WIDEST);
        if few <= MAX_ALONE {
            (self.asked - few..self.asked).for_each(|i| self.compute_alone(i));
        } else if let Some(rest) = self.indices.get_mut(self.asked..beyond) {
            // What is there may be no index of these sets.
            rest.fill(0);
        }
        vectorize::<N, _>(Compute(self));
    }

    fn compute_alone(&mut self, i: usize) {
        let index = self.indices[i];
        let points = ScrambledPoints {
            seed: self.seeds[i],
            kind: match self.count {
                Some(count) => Kind::Hammersley { index, count },
                None => Kind::Sequence {
                    index_reversed: index,
                },
            },
        };
        let values = points.in_set(self.numbers[i]);
        for (all, value) in self.values.iter_mut().zip(values) {
            all[i] = value;
        }
    }

    /// Number of requests: at most `N`, which the compiler does not know of the field.
    #[inline(always)]
    pub fn asked(&self) -> usize {
        self.asked.min(N)
    }

    /// Whose request `i` is.
    #[inline(always)]
    pub fn whose(&self, i: usize) -> usize {
        self.whose[i] as usize
    }

    /// The answer to request `i`, for the stream that has made it.
    #[inline(always)]
    pub fn answer(&self, i: usize, stream: &mut SampleStream) -> Vec2 {
        let values = self.values.each_ref().map(|values| values[i]);
        match stream {
            SampleStream::Sobol(stream) => stream.answer(values),
            _ => {
                debug_assert!(false, "other streams do not ask");
                stream.next_2d()
            }
        }
    }
}

/// A remainder of up to so many sets is computed one by one, which takes fewer instructions.
const MAX_ALONE: usize = 6;

/// Computes chunks of [`WIDEST`] sets, all but such a remainder.
struct Compute<'a, const N: usize>(&'a mut Pairs<N>);

impl<const N: usize> Kernel for Compute<'_, N> {
    type Output = ();

    #[inline(always)]
    fn run(self, _: impl Instructions) {
        let pairs = self.0;
        let [x, y, z, w] = pairs
            .values
            .each_mut()
            .map(|values| values.as_chunks_mut::<WIDEST>().0);
        let values = x.iter_mut().zip(y).zip(z).zip(w);
        let seeds = pairs.seeds.as_chunks::<WIDEST>().0;
        let (indices, numbers) = (pairs.indices.as_chunks().0, pairs.numbers.as_chunks().0);
        let keys = seeds.iter().zip(numbers);
        let chunks = values.zip(indices.iter().zip(keys));
        for ((((x, y), z), w), (indices, keys)) in
            chunks.take((pairs.asked + WIDEST - 1 - MAX_ALONE) / WIDEST)
        {
            [*x, *y, *z, *w] = points_in_sets(pairs.count, *indices, keys);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::IVec2;
    use crate::math::instruction_set::InstructionSet;
    use crate::samplers::{Points, Sampler, SamplerSpec, Stratified};

    const N: usize = 32;

    /// Streams of neighboring pixels that have come to different places.
    fn streams(spec: &SamplerSpec, count: u32) -> Vec<SampleStream> {
        let sampler = Sampler::new(spec, 7);
        let stream = |i: u32| {
            let mut stream = sampler.stream(IVec2::new((i / spec.spp) as i32, 3), i % spec.spp);
            (0..i % 3).for_each(|_| stream.skip_1d());
            (0..i % 4).for_each(|_| _ = stream.next_2d());
            (0..i % 2).for_each(|_| stream.skip_2d());
            if i.is_multiple_of(5) {
                stream.fork()
            } else {
                stream
            }
        };
        (0..count).map(stream).collect()
    }

    /// The next pair of each.
    fn draw(pairs: &mut Pairs<N>, streams: &mut [SampleStream]) -> Vec<Vec2> {
        let mut drawn = vec![Vec2::NAN; streams.len()];
        pairs.clear();
        for (i, stream) in streams.iter_mut().enumerate() {
            if let Some(known) = pairs.ask(stream, i) {
                drawn[i] = known;
            }
        }
        pairs.compute();
        for i in 0..pairs.asked() {
            let whose = pairs.whose(i);
            drawn[whose] = pairs.answer(i, &mut streams[whose]);
        }
        drawn
    }

    #[test]
    fn pairs_are_those_of_each_stream() {
        let grid = Points::Stratified(Stratified::new(4, 4, true, None));
        let stratified = SamplerSpec {
            points: grid,
            ..SamplerSpec::random(16)
        };
        let sobol = [3, 5, 24, 25, 70_001, 1, 16].map(SamplerSpec::sobol);
        let others = [SamplerSpec::random(16), stratified];
        for spec in sobol.iter().chain(&others) {
            for count in [1, 15, 16, 17, 31, 40] {
                let (mut alone, mut together) = (streams(spec, count), streams(spec, count));
                let mut pairs = Pairs::default();
                // Halves of sets that are known, too.
                for _ in 0..5 {
                    let all = alone.iter_mut().chain(&mut together);
                    all.for_each(SampleStream::skip_1d);
                    let own: Vec<Vec2> = alone.iter_mut().map(SampleStream::next_2d).collect();
                    assert_eq!(draw(&mut pairs, &mut together), own, "{spec:?}, {count}");
                    // So is what is drawn after it.
                    let single = |streams: &mut [SampleStream]| -> Vec<f32> {
                        streams.iter_mut().map(SampleStream::next_1d).collect()
                    };
                    assert_eq!(single(&mut alone), single(&mut together));
                }
            }
        }
    }

    #[test]
    fn choices_are_those_of_each_stream() {
        for spec in [
            SamplerSpec::sobol(16),
            SamplerSpec::sobol(24),
            SamplerSpec::random(16),
        ] {
            for is_choice in [false, true] {
                let (mut alone, mut together) = (streams(&spec, 20), streams(&spec, 20));
                let mut pairs = Pairs::<N>::default();
                let mut choices: Vec<_> = together
                    .iter_mut()
                    .enumerate()
                    .map(|(i, stream)| pairs.ask_choice(stream, is_choice, i))
                    .collect();
                pairs.compute();
                for i in 0..pairs.asked() {
                    let whose = pairs.whose(i);
                    let pair = pairs.answer(i, &mut together[whose]);
                    let other = choices[whose].replace(ChoiceSample::shared(pair, is_choice));
                    assert!(other.is_none());
                }
                for (i, (alone, together)) in alone.iter_mut().zip(&mut together).enumerate() {
                    let (own, other) = (alone.next_choice(is_choice), choices[i].unwrap());
                    assert_eq!(own.choice, other.choice);
                    assert_eq!(own.point(0.5, 0.25), other.point(0.5, 0.25));
                    assert_eq!(alone.next_2d(), together.next_2d());
                }
            }
        }
    }

    #[test]
    fn samples_of_different_kinds_may_ask_together() {
        let specs = [24, 16, 25].map(SamplerSpec::sobol);
        let all = || specs.iter().flat_map(|spec| streams(spec, 3));
        let (mut alone, mut together): (Vec<_>, Vec<_>) = (all().collect(), all().collect());
        let own: Vec<Vec2> = alone.iter_mut().map(SampleStream::next_2d).collect();
        assert_eq!(draw(&mut Pairs::default(), &mut together), own);
    }

    /// What is left in a list from sets of more points is no index of those of fewer.
    #[test]
    fn lists_are_used_again() {
        let mut pairs = Pairs::default();
        for (spp, count) in [(70_001, 32), (16, 32), (5, 9), (3, 31)] {
            let spec = SamplerSpec::sobol(spp);
            let (mut alone, mut together) = (streams(&spec, count), streams(&spec, count));
            let own: Vec<Vec2> = alone.iter_mut().map(SampleStream::next_2d).collect();
            assert_eq!(draw(&mut pairs, &mut together), own);
        }
    }

    #[test]
    fn instruction_sets_make_the_same_bits() {
        for spec in [24, 16].map(SamplerSpec::sobol) {
            let values = InstructionSet::available().into_iter().map(|set| {
                let mut pairs = Pairs::<N>::default();
                let mut streams = streams(&spec, N as u32);
                for stream in &mut streams {
                    pairs.ask(stream, 0);
                }
                assert!(pairs.asked() > 8);
                set.run(Compute(&mut pairs));
                pairs.values
            });
            let values: Vec<_> = values.collect();
            assert!(values.iter().all(|own| *own == values[0]));
        }
    }
}
