//! Which of some things a pixel shows, and how much of it each of them covers.
//!
//! Samples of one image have the same weight but for its sign (the filter's), so that counting is enough: whole numbers have no order.

use super::{Layer, LayerSet, MatteId};
use std::borrow::Cow;
use std::cmp::Reverse;

/// Things of a pixel that are written, those that cover most of it: what Cryptomatte's files have by default.
pub(super) const RANKS: usize = 6;

/// Bytes of things that a pixel shows.
pub(super) const ENTRY: usize = size_of::<Entry>();

/// What the samples of some pixels have met, for both mattes at once: most pixels show one thing of either.
#[derive(Clone, Debug, Default, PartialEq)]
pub(in super::super) struct Coverage {
    /// By pixel, while a tile is rendered; a pixel may be there in several parts.
    entries: Vec<Entry>,
    /// How many there were when each pair of things of a pixel was there once.
    tidied: usize,
    /// The weight of a sample, without its sign.
    unit: f32,
}

/// Things that the same samples of a pixel show.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Entry {
    pixel: u32,
    things: Pair,
    /// Samples of positive weight, less those of negative weight.
    count: i32,
}

/// A thing of each of [`Layer::MATTES`], as one number that is compared at once.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
struct Pair(u64);

impl Pair {
    fn new([first, second]: [MatteId; 2]) -> Pair {
        Pair(u64::from(first.bits()) << 32 | u64::from(second.bits()))
    }

    /// That of this matte.
    fn id(self, kind: usize) -> MatteId {
        let bits = if kind == 0 { self.0 >> 32 } else { self.0 };
        MatteId::from_bits(bits as u32)
    }
}

impl Coverage {
    /// Adds samples that count so much, each of the weight `unit` without its sign. Those of a pixel come one after the other.
    pub(super) fn add(&mut self, pixel: u32, ids: [MatteId; 2], count: i32, unit: f32) {
        self.unit = self.unit.max(unit);
        let things = Pair::new(ids);
        let same = { self.entries.iter_mut().rev() }.take_while(|entry| entry.pixel == pixel);
        match same.into_iter().find(|entry| entry.things == things) {
            Some(entry) => entry.count += count,
            None => self.entries.push(Entry {
                pixel,
                things,
                count,
            }),
        }
    }

    /// Adds those of other pixels, each of which is the one of these that `place` says, if any.
    pub(super) fn merge(&mut self, more: &Coverage, place: impl Fn(usize) -> Option<usize>) {
        self.unit = self.unit.max(more.unit);
        let moved = more.entries.iter().filter_map(|entry| {
            let pixel = place(entry.pixel as usize)? as u32;
            Some(Entry { pixel, ..*entry })
        });
        self.entries.extend(moved);
        // Now and then, so that it takes little time of all.
        if self.entries.len() > 2 * self.tidied {
            self.tidy();
        }
    }

    /// Adds those of the same pixels, where what each counts is multiplied by the pixel's `weights` of these and of those.
    pub(super) fn join(&mut self, more: &Coverage, weights: impl Fn(usize) -> [i32; 2]) {
        let weighed = |which: usize| {
            let weights = &weights;
            move |entry: &Entry| Entry {
                count: entry
                    .count
                    .saturating_mul(weights(entry.pixel as usize)[which]),
                ..*entry
            }
        };
        let own = weighed(0);
        self.entries
            .iter_mut()
            .for_each(|entry| *entry = own(entry));
        self.unit = self.unit.max(more.unit);
        self.entries.extend(more.entries.iter().map(weighed(1)));
        self.tidy();
    }

    /// Each pair of things of a pixel once, in order.
    fn tidy(&mut self) {
        let key = |entry: &Entry| (entry.pixel, entry.things);
        self.entries.sort_unstable_by_key(key);
        self.entries.dedup_by(|next, kept| {
            let is_same = key(next) == key(kept);
            if is_same {
                kept.count += next.count;
            }
            is_same
        });
        self.tidied = self.entries.len();
    }

    /// Returns `true` if each pair of things of a pixel is there once, and one pixel comes after the other, as in a tile that has not been returned to. Not
    /// where pixels show many things, for which it would take long to know.
    fn is_tidy(&self) -> bool {
        const MANY: usize = 16;
        let (mut first, mut last) = (0, None);
        self.entries.iter().enumerate().all(|(i, entry)| {
            if last < Some(entry.pixel) {
                (first, last) = (i, Some(entry.pixel));
                return true;
            }
            let same = self.entries.get(first..i).unwrap_or_default();
            let is_new = same.iter().all(|other| other.things != entry.things);
            last == Some(entry.pixel) && same.len() < MANY && is_new
        })
    }

    /// In one order, whatever it was made from.
    #[cfg(test)]
    pub(in super::super) fn canonical(&self) -> Coverage {
        let mut canonical = self.clone();
        canonical.tidy();
        canonical
    }

    /// Sets the ranks of pixels in `mattes`, where `place` says, of which so many samples have left the lens. `place` is asked
    /// of one pixel after the other.
    pub(super) fn develop(
        &self,
        mattes: &mut [ImageMatte],
        seen: impl Fn(usize) -> f64,
        mut place: impl FnMut(usize) -> Option<usize>,
    ) {
        let mut all = Cow::Borrowed(self);
        if !self.is_tidy() {
            all.to_mut().tidy();
        }
        let mut things = Vec::new();
        let mut rest = all.entries.as_slice();
        while let [Entry { pixel, .. }, others @ ..] = rest {
            let pixel = *pixel;
            let same = others.iter().take_while(|other| other.pixel == pixel);
            let (entries, others) = rest.split_at(1 + same.count());
            rest = others;
            let (seen, index) = (seen(pixel as usize), place(pixel as usize));
            let Some(index) = index.filter(|_| seen > 0.0) else {
                continue;
            };
            let part = |count: i32| {
                let part = f64::from(count) * f64::from(self.unit) / seen;
                part.min(1.0) as f32
            };
            if let [Entry { things, count, .. }] = *entries {
                if count > 0 {
                    let part = part(count);
                    for matte in mattes.iter_mut() {
                        matte.set(index, 0, (things.id(matte.kind), part));
                    }
                }
                continue;
            }
            for matte in mattes.iter_mut() {
                let kind = matte.kind;
                things.clear();
                things.extend(entries.iter().map(|of| (of.things.id(kind), of.count)));
                rank(&mut things);
                let shown = things.iter().filter(|(_, count)| *count > 0).take(RANKS);
                for (rank, &(id, count)) in shown.enumerate() {
                    matte.set(index, rank, (id, part(count)));
                }
            }
        }
    }

    /// As words of a checkpoint.
    pub(in super::super) fn to_words(&self) -> impl Iterator<Item = u64> + '_ {
        let head = [self.entries.len() as u64, self.unit.to_bits().into()];
        let entries = self.entries.iter().flat_map(|entry| {
            let met = u64::from(entry.pixel) << 32 | u64::from(entry.count as u32);
            [met, entry.things.0]
        });
        head.into_iter().chain(entries)
    }

    /// From such words; `None` if there are too few.
    pub(in super::super) fn from_words(mut word: impl FnMut() -> Option<u64>) -> Option<Coverage> {
        let (count, unit) = (word()?, f32::from_bits(word()? as u32));
        let mut entries = Vec::new();
        for _ in 0..count {
            let (met, things) = (word()?, Pair(word()?));
            entries.push(Entry {
                pixel: (met >> 32) as u32,
                things,
                count: met as u32 as i32,
            });
        }
        Some(Coverage {
            tidied: 0,
            entries,
            unit,
        })
    }
}

/// Each thing once: by what it covers, and by its number where that is the same.
fn rank(things: &mut Vec<(MatteId, i32)>) {
    things.sort_unstable();
    things.dedup_by(|next, kept| {
        let is_same = next.0 == kept.0;
        if is_same {
            kept.1 += next.1;
        }
        is_same
    });
    things.sort_unstable_by_key(|&(id, count)| (Reverse(count), id));
}

/// A Cryptomatte of all pixels of an image.
#[derive(Clone, Debug, PartialEq)]
pub struct ImageMatte {
    /// Which.
    pub layer: Layer,
    /// Those of [`Layer::channels`], each row by row, as the image's pixels: number and part of what covers most of the pixel, of what covers most of the
    /// rest, and so on. Empty where no pixel shows so many things.
    pub channels: [Vec<f32>; 2 * RANKS],
    /// Its place among [`Layer::MATTES`].
    kind: usize,
    pixels: usize,
}

impl ImageMatte {
    /// Those of these layers, of so many pixels that show nothing.
    pub(in super::super) fn all_of(set: LayerSet, pixels: usize) -> Vec<ImageMatte> {
        let blank = |(kind, layer)| ImageMatte {
            layer,
            channels: Default::default(),
            kind,
            pixels,
        };
        let all = Layer::MATTES.into_iter().enumerate();
        let wanted = all.filter(|(_, layer)| set.contains(*layer));
        wanted.map(blank).collect()
    }

    #[inline(always)]
    fn set(&mut self, pixel: usize, rank: usize, (id, part): (MatteId, f32)) {
        let channels = self.channels.get_mut(2 * rank..2 * rank + 2);
        if let Some([ids, parts]) = channels {
            for (channel, value) in [(ids, id.number()), (parts, part)] {
                match channel.get_mut(pixel) {
                    Some(slot) => *slot = value,
                    None => begin(channel, self.pixels, pixel, value),
                }
            }
        }
    }

    /// What a pixel shows: numbers, and the parts of the pixel that they cover.
    #[cfg(test)]
    pub(crate) fn ranks(&self, pixel: usize) -> [(f32, f32); RANKS] {
        let at = |channel: usize| self.channels[channel].get(pixel).copied().unwrap_or(0.0);
        std::array::from_fn(|rank| (at(2 * rank), at(2 * rank + 1)))
    }
}

/// Makes a channel of so many pixels, of which this one is not 0.
#[cold]
fn begin(channel: &mut Vec<f32>, pixels: usize, pixel: usize, value: f32) {
    *channel = vec![0.0; pixels];
    if let Some(slot) = channel.get_mut(pixel) {
        *slot = value;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ids() -> [MatteId; 9] {
        std::array::from_fn(|i| MatteId::of(&format!("thing {i}")))
    }

    #[test]
    fn parts_are_those_of_the_samples_whatever_the_order() {
        let ids = ids();
        // Thing i is met 10 − i times, one of them with a negative weight; two of all 60 rays meet nothing.
        let samples: Vec<(MatteId, f32)> = { ids.into_iter().enumerate() }
            .flat_map(|(i, id)| (0..10 - i).map(move |k| (id, if k == 5 { -1.5 } else { 1.5 })))
            .collect();
        let developed = |order: &[(MatteId, f32)], parts: usize| {
            let mut all = Coverage::default();
            for part in order.chunks(order.len().div_ceil(parts)) {
                let mut coverage = Coverage::default();
                for (i, &(id, weight)) in part.iter().enumerate() {
                    // Of several instances that have the same material.
                    let ids = [id, MatteId::of(["a", "b"][i % 2])];
                    coverage.add(0, ids, weight.signum() as i32, weight.abs());
                }
                all.merge(&coverage, |_| Some(1));
            }
            let mut matte = ImageMatte::all_of(LayerSet::NONE.with(Layer::Material), 2);
            all.develop(&mut matte, |_| 60.0, Some);
            assert_eq!(matte[0].ranks(0), [(0.0, 0.0); RANKS]);
            assert!(matte[0].channels.iter().all(|channel| channel.len() == 2));
            matte[0].ranks(1)
        };
        let ranks = developed(&samples, 1);
        let met = [8, 7, 6, 5, 5, 4];
        for (rank, met) in ranks.into_iter().zip(met) {
            assert_eq!(rank.1, 1.5 * met as f32 / 60.0);
        }
        let mut same = [ids[3].number(), ids[4].number(), ids[5].number()];
        same.sort_by(f32::total_cmp);
        assert!(same.contains(&ranks[3].0) && same.contains(&ranks[4].0));
        let mut reversed = samples.clone();
        reversed.reverse();
        for parts in [1, 3, 7] {
            assert_eq!(developed(&samples, parts), ranks);
            assert_eq!(developed(&reversed, parts), ranks);
        }
    }

    #[test]
    fn what_no_pixel_shows_takes_no_memory() {
        let mut coverage = Coverage::default();
        for (pixel, thing) in [(0, 3), (2, 1), (2, 4)] {
            coverage.add(pixel, [ids()[0], ids()[thing]], 1, 1.0);
        }
        let mut matte = ImageMatte::all_of(LayerSet::NONE.with(Layer::Instance), 3);
        coverage.develop(&mut matte, |_| 2.0, Some);
        let pixels = matte[0].channels.each_ref().map(Vec::len);
        assert_eq!(pixels, [3, 3, 3, 3, 0, 0, 0, 0, 0, 0, 0, 0]);
        assert_eq!(
            matte[0].ranks(0)[..2],
            [(ids()[3].number(), 0.5), (0.0, 0.0)]
        );
        assert_eq!(matte[0].ranks(1), [(0.0, 0.0); RANKS]);
    }

    #[test]
    fn only_what_is_in_order_is_tidy() {
        let ids = ids();
        let coverage = |entries: &[(u32, usize)]| {
            let entry = |&(pixel, i): &(u32, usize)| Entry {
                pixel,
                things: Pair::new([ids[8], ids[i]]),
                count: 1,
            };
            Coverage {
                entries: entries.iter().map(entry).collect(),
                ..Coverage::default()
            }
        };
        assert!(coverage(&[]).is_tidy());
        assert!(coverage(&[(0, 3), (0, 1), (2, 1), (3, 0)]).is_tidy());
        assert!(!coverage(&[(0, 3), (2, 1), (1, 0)]).is_tidy());
        assert!(!coverage(&[(0, 3), (0, 1), (0, 3)]).is_tidy());
    }

    #[test]
    fn words_are_read_back() {
        let mut coverage = Coverage::default();
        for (i, id) in ids().into_iter().enumerate() {
            let ids = [id, ids()[8 - i]];
            coverage.add(i as u32 / 2, ids, if i == 4 { -1 } else { 1 }, 0.5);
        }
        let words: Vec<u64> = coverage.to_words().collect();
        let mut rest = words.iter().copied();
        assert_eq!(Coverage::from_words(|| rest.next()), Some(coverage));
        let mut short = words[..words.len() - 1].iter().copied();
        assert_eq!(Coverage::from_words(|| short.next()), None);
    }
}
