//! Divides many primitives into chunks whose trees are built one after the other.
//!
//! While a tree is built there are some 260 bytes for each of its primitives at once, three times what stays in the end. Of chunks
//! only one is being built. Where they are divided, the surface area heuristic (Goldsmith and Salmon 1987) decides, for planes in
//! bins (Wald, "On fast Construction of SAH-based Bounding Volume Hierarchies", 2007, §3).

use super::aabb::Aabb;
use super::node::Node;
use super::primitive::Item;
use crate::math::Vec3;
use rayon::prelude::*;
use std::ops::Range;

/// So many items and fewer are not divided: they take some 70 MB.
const WHOLE: usize = 1 << 18;

/// The most items of a chunk: one in so many, or so many if that is more.
const CHUNKS: usize = 32;

/// See [`CHUNKS`].
const CHUNK: usize = 1 << 16;

/// Of what is divided, each half has at least one in so many: chunks are few, and the way to them is short.
const LEAST: usize = 8;

/// Places where items are tried to be divided, along each axis.
const BINS: usize = 32;

/// Items that are counted at a time.
const AT_A_TIME: usize = 1 << 14;

/// A range of the items.
pub(super) enum Chunk {
    /// They are built together.
    Items(Range<usize>),
    /// They are divided; the first half comes first.
    Halves(Box<[Chunk; 2]>, Aabb),
}

impl Chunk {
    /// Divides the items, which it sorts for that.
    pub(super) fn of(items: &mut [Item]) -> Chunk {
        let most = Chunk::most(items.len());
        Chunk::divided(items, 0, most)
    }

    /// The most items of a chunk, of so many in all.
    pub(super) fn most(items: usize) -> usize {
        match items {
            0..=WHOLE => WHOLE,
            _ => (items / CHUNKS).max(CHUNK),
        }
    }

    /// Into chunks of at most so many items, of which the first has this number.
    fn divided(items: &mut [Item], first: usize, most: usize) -> Chunk {
        if items.len() <= most {
            return Chunk::Items(first..first + items.len());
        }
        let bins = Bins::of(items);
        let at = bins.sorted(items);
        let (left, right) = items.split_at_mut(at);
        let halves = [(left, first), (right, first + at)];
        let halves = halves.map(|(half, first)| Chunk::divided(half, first, most));
        Chunk::Halves(Box::new(halves), bins.bounds)
    }

    /// In how many parts, and which, this is divided below a node; in order.
    pub(super) fn parts(&self) -> Vec<&Chunk> {
        let mut parts = vec![self];
        while parts.len() < Node::WIDTH {
            let size = |chunk: &Chunk| match chunk {
                Chunk::Items(_) => None,
                Chunk::Halves(_, bounds) => Some(bounds.half_area()),
            };
            let sizes = parts.iter().map(|part| size(part)).enumerate();
            let divisible = sizes.filter_map(|(i, size)| Some((i, size?)));
            let largest = divisible.max_by(|(_, a), (_, b)| a.total_cmp(b));
            let Some((i, _)) = largest else { break };
            if let Chunk::Halves(halves, _) = parts[i] {
                parts.splice(i..=i, halves.iter());
            }
        }
        parts
    }
}

/// Items counted by the places of their centers.
struct Bins {
    /// Of all items.
    bounds: Aabb,
    /// Of their centers.
    centers: Aabb,
    /// Along each axis.
    bins: [[Bin; BINS]; 3],
}

/// Items, and the box around them.
#[derive(Clone, Copy)]
struct Bin {
    count: usize,
    bounds: Aabb,
}

impl Bin {
    const EMPTY: Bin = Bin {
        count: 0,
        bounds: Aabb::EMPTY,
    };

    fn with(self, other: Bin) -> Bin {
        Bin {
            count: self.count + other.count,
            bounds: self.bounds.union(other.bounds),
        }
    }
}

fn center(item: &Item) -> Vec3 {
    0.5 * (item.bounds.min + item.bounds.max)
}

impl Bins {
    fn of(items: &[Item]) -> Bins {
        let groups = items.par_chunks(AT_A_TIME);
        let boxes = groups.clone().map(|items| {
            let around = |boxes: [Aabb; 2], item: &Item| {
                let [all, centers] = boxes;
                [all.union(item.bounds), centers.with_point(center(item))]
            };
            items.iter().fold([Aabb::EMPTY; 2], around)
        });
        let both = |[a, b]: [Aabb; 2], [c, d]: [Aabb; 2]| [a.union(c), b.union(d)];
        let [bounds, centers] = boxes.reduce(|| [Aabb::EMPTY; 2], both);
        let none = || [[Bin::EMPTY; BINS]; 3];
        let counted = groups.map(|items| {
            let mut bins = none();
            for item in items {
                let places = places(&centers, item);
                for (bins, place) in bins.iter_mut().zip(places) {
                    bins[place] = bins[place].with(Bin {
                        count: 1,
                        bounds: item.bounds,
                    });
                }
            }
            bins
        });
        // In any order: boxes and counts do not depend on it.
        let sums = |mut a: [[Bin; BINS]; 3], b: [[Bin; BINS]; 3]| {
            for (a, b) in a.as_flattened_mut().iter_mut().zip(b.as_flattened()) {
                *a = a.with(*b);
            }
            a
        };
        Bins {
            bounds,
            centers,
            bins: counted.reduce(none, sums),
        }
    }

    /// Sorts the items into two parts; where the second one starts.
    fn sorted(&self, items: &mut [Item]) -> usize {
        if let Some((axis, at)) = self.best() {
            let mut first = 0;
            for i in 0..items.len() {
                if places(&self.centers, &items[i])[axis] < at {
                    items.swap(i, first);
                    first += 1;
                }
            }
            return first;
        }
        // By number, where that is the only way to have enough in both.
        let size = self.centers.max - self.centers.min;
        let axis = size.max_position();
        let half = items.len() / 2;
        let key = |item: &Item| center(item)[axis];
        items.select_nth_unstable_by(half, |a, b| key(a).total_cmp(&key(b)).then(a.id.cmp(&b.id)));
        half
    }

    /// The axis and the bin before which to divide that is the cheapest, of those that leave enough in both halves.
    fn best(&self) -> Option<(usize, usize)> {
        let mut best: Option<(f64, usize, usize)> = None;
        for (axis, bins) in self.bins.iter().enumerate() {
            let mut above = [Bin::EMPTY; BINS];
            let mut sum = Bin::EMPTY;
            for (above, &bin) in above.iter_mut().zip(bins).rev() {
                sum = sum.with(bin);
                *above = sum;
            }
            let least = sum.count.div_ceil(LEAST);
            let mut below = Bin::EMPTY;
            for at in 1..BINS {
                below = below.with(bins[at - 1]);
                if below.count.min(above[at].count) < least {
                    continue;
                }
                let cost = |bin: Bin| f64::from(bin.bounds.half_area()) * bin.count as f64;
                let cost = cost(below) + cost(above[at]);
                if best.is_none_or(|(lowest, ..)| cost < lowest) {
                    best = Some((cost, axis, at));
                }
            }
        }
        best.map(|(_, axis, at)| (axis, at))
    }
}

/// The bin of an item, along each axis.
#[inline]
fn places(centers: &Aabb, item: &Item) -> [usize; 3] {
    let place = (center(item) - centers.min) / (centers.max - centers.min);
    // Where all centers are at one place, that is not a number, and 0.
    place
        .to_array()
        .map(|place| ((place * BINS as f32) as usize).min(BINS - 1))
}

#[cfg(test)]
mod tests {
    use super::super::primitive::PrimitiveId;
    use super::*;
    use crate::math::hash::{mix2, unit_float};

    fn items(count: u32, at: impl Fn(u32) -> Vec3) -> Vec<Item> {
        let item = |i| Item {
            id: PrimitiveId::triangle(i, false),
            bounds: Aabb {
                min: at(i),
                max: at(i) + Vec3::ONE,
            },
        };
        (0..count).map(item).collect()
    }

    /// The ranges of all chunks, in order.
    fn ranges(chunk: &Chunk) -> Vec<Range<usize>> {
        match chunk {
            Chunk::Items(range) => vec![range.clone()],
            Chunk::Halves(halves, _) => halves.iter().flat_map(ranges).collect(),
        }
    }

    fn random(i: u32) -> Vec3 {
        Vec3::from_array([1, 2, 3].map(|k| unit_float(mix2(i.into(), k))))
    }

    #[test]
    fn chunks_hold_every_item_once_and_neither_too_few_nor_too_many() {
        let places: [fn(u32) -> Vec3; 4] = [
            |i| 100.0 * random(i),
            // All alike; ever denser; a heap that the others are far from.
            |_| Vec3::ONE,
            |i| Vec3::X * 0.999f32.powi(i as i32),
            |i| random(i) + Vec3::X * if i < 9 { 1e9 } else { 0.0 },
        ];
        for place in places {
            for count in [1, WHOLE as u32, WHOLE as u32 + 1, 400_000] {
                let mut items = items(count, place);
                let all = Chunk::of(&mut items);
                let ranges = ranges(&all);
                let mut end = 0;
                for range in &ranges {
                    assert_eq!(range.start, end);
                    let few = CHUNK.min(count as usize) / (2 * LEAST);
                    assert!((few..=Chunk::most(items.len())).contains(&range.len()));
                    end = range.end;
                }
                assert_eq!(end, items.len());
                let mut ids: Vec<usize> = items.iter().map(|item| item.id.index()).collect();
                ids.sort_unstable();
                assert!(ids.into_iter().eq(0..count as usize));
            }
        }
    }

    #[test]
    fn heaps_are_divided_between() {
        let heap =
            |i: u32| 10.0 * random(i) + Vec3::Y * f32::from(u8::from(i.is_multiple_of(3))) * 100.0;
        let mut items = items(300_000, heap);
        let Chunk::Halves(halves, bounds) = Chunk::of(&mut items) else {
            panic!("too many for one");
        };
        assert!(bounds.max.y > 100.0);
        let first = ranges(&halves[0]);
        let number = first.iter().map(|range| range.len()).sum::<usize>();
        assert_eq!(number, 200_000);
        assert!(items[..number].iter().all(|item| item.bounds.min.y < 50.0));
    }

    #[test]
    fn parts_are_in_order_and_at_most_as_many_as_a_node_has() {
        let mut items = items(800_000, |i| 100.0 * random(i));
        let all = Chunk::of(&mut items);
        let parts = all.parts();
        assert_eq!(parts.len(), Node::WIDTH);
        let below: Vec<_> = parts.into_iter().flat_map(ranges).collect();
        assert_eq!(below, ranges(&all));
    }
}
