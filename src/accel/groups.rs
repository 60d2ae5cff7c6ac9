//! Input of the binary builder: every box once, and no two exactly alike.

use super::aabb::Aabb;
use super::primitive::Item;
use crate::math::Vec3;
use crate::math::hash::{mix, mix2, unit_float};
use rayon::prelude::*;

/// Maximum relative enlargement of a box for the binary builder ([`Groups::boxes`]). Boxes that grow faster than this
/// from one to the next overflow single precision after 20,000.
const UNEVENNESS: f32 = 0.01;

/// Number of parts in which boxes are compared, by the low bits of their hashes: a part's table stays in the
/// processor's cache.
const PARTS: usize = 8;

/// Items grouped by box: the binary builder merges the nearest neighbors, and among thousands of equal boxes finds only
/// one pair per pass, which takes practically forever. So it gets every box once.
pub(super) enum Groups {
    /// No two boxes are equal: every item is a group.
    Single(usize),
    /// Some boxes are equal. (Often the two triangles of a quad.)
    Shared {
        /// Items with equal boxes are adjacent, in the order of the first of each group, as neighbors in a file are
        /// near each other in space and in memory.
        order: Vec<u32>,
        /// Start of each group in `order`, followed by its length.
        starts: Vec<u32>,
    },
}

impl Groups {
    pub(super) fn of(items: &[Item]) -> Groups {
        let hash = |item: &Item| bits(item).into_iter().fold(0, mix2);
        let hashes: Vec<u64> = items.par_iter().map(hash).collect();
        let parts = (0..PARTS).into_par_iter();
        let mut later: Vec<(u32, u32)> = parts
            .flat_map_iter(|part| later_of_part(items, &hashes, part))
            .collect();
        if later.is_empty() {
            return Groups::Single(items.len());
        }
        later.par_sort_unstable();
        let mut is_later = vec![false; items.len()];
        for &(_, item) in &later {
            is_later[item as usize] = true;
        }
        let mut order = Vec::with_capacity(items.len());
        let mut starts = Vec::with_capacity(items.len() - later.len() + 1);
        let mut later = later.iter().peekable();
        for (i, is_later) in (0..).zip(is_later) {
            if is_later {
                continue;
            }
            starts.push(order.len() as u32);
            order.push(i);
            while let Some(&(_, item)) = later.next_if(|&&(first, _)| first == i) {
                order.push(item);
            }
        }
        starts.push(order.len() as u32);
        Groups::Shared { order, starts }
    }

    /// The number of groups.
    pub(super) fn len(&self) -> usize {
        match self {
            Groups::Single(len) => *len,
            Groups::Shared { starts, .. } => starts.len() - 1,
        }
    }

    /// The items of a group.
    pub(super) fn members(&self, group: u32) -> impl ExactSizeIterator<Item = u32> + '_ {
        // A single item is returned as a slice of one.
        let range = match self {
            Groups::Single(_) => group as usize..group as usize + 1,
            Groups::Shared { starts, .. } => {
                starts[group as usize] as usize..starts[group as usize + 1] as usize
            }
        };
        range.map(move |i| match self {
            Groups::Single(_) => i as u32,
            Groups::Shared { order, .. } => order[i],
        })
    }

    /// The box of a group.
    pub(super) fn bounds(&self, group: u32, items: &[Item]) -> Aabb {
        let mut members = self.members(group);
        members
            .next()
            .map_or(Aabb::EMPTY, |i| items[i as usize].bounds)
    }

    /// The boxes for the binary builder: one per group, each enlarged slightly by a different amount.
    ///
    /// The builder merges mutual nearest neighbors, pass by pass. Where every box's nearest is the previous one (a row
    /// of equal boxes, boxes that grow from one to the next) there is one mutual pair, and as many passes as boxes.
    /// Uneven sizes make a third of them mutual.
    pub(super) fn boxes(&self, items: &[Item]) -> Vec<obvhs::aabb::Aabb> {
        (0..self.len() as u32)
            .into_par_iter()
            .map(|group| {
                let bounds = self.bounds(group, items);
                let share = UNEVENNESS * unit_float(mix(u64::from(group)));
                let grown = (bounds.max - bounds.min) * share;
                // If the sum overflows, the box already extends to the largest number.
                let max = (bounds.max + grown).min(Vec3::MAX);
                obvhs::aabb::Aabb::new(bounds.min.into(), max.into())
            })
            .collect()
    }
}

/// The duplicates among the items that belong to a part: the first item with a box, and a later one with the same.
fn later_of_part(items: &[Item], hashes: &[u64], part: usize) -> Vec<(u32, u32)> {
    let parts = PARTS as u64;
    let belongs = |hash: &u64| hash % parts == part as u64;
    // At least half empty: the first free slot is near.
    let count = hashes.iter().filter(|hash| belongs(hash)).count();
    let places = (2 * count).next_power_of_two();
    // Indices of items plus one.
    let mut table = vec![0u32; places];
    let mut found = Vec::new();
    for (&hash, i) in hashes.iter().zip(0u32..).filter(|(hash, _)| belongs(hash)) {
        let mut place = (hash / parts) as usize & (places - 1);
        loop {
            let Some(first) = table[place].checked_sub(1) else {
                table[place] = i + 1;
                break;
            };
            if bits(&items[first as usize]) == bits(&items[i as usize]) {
                found.push((first, i));
                break;
            }
            place = (place + 1) & (places - 1);
        }
    }
    found
}

/// The bits that identify a box.
fn bits(item: &Item) -> [u64; 3] {
    let Aabb { min, max } = item.bounds;
    let pair = |a: f32, b: f32| u64::from(a.to_bits()) << 32 | u64::from(b.to_bits());
    [pair(min.x, max.x), pair(min.y, max.y), pair(min.z, max.z)]
}

#[cfg(test)]
mod tests {
    use super::super::primitive::PrimitiveId;
    use super::*;

    /// Items with boxes of these sizes around the origin.
    fn items(sizes: &[f32]) -> Vec<Item> {
        let item = |(&size, i): (&f32, u32)| Item {
            id: PrimitiveId::triangle(i, false),
            bounds: Aabb {
                min: Vec3::splat(-size),
                max: Vec3::splat(size),
            },
        };
        sizes.iter().zip(0..).map(item).collect()
    }

    #[test]
    fn equal_boxes_are_together_in_the_order_of_the_first() {
        let items = items(&[5.0, 3.0, 3.0, 5.0, 1.0, 3.0, 7.0]);
        let groups = Groups::of(&items);
        let members = (0..groups.len() as u32).map(|group| groups.members(group).collect());
        let members: Vec<Vec<u32>> = members.collect();
        assert_eq!(members, [vec![0, 3], vec![1, 2, 5], vec![4], vec![6]]);
        assert_eq!(groups.bounds(1, &items), items[1].bounds);
    }

    #[test]
    fn thousands_of_equal_boxes_and_of_different_ones() {
        let sizes: Vec<f32> = (0..40_000).map(|i| 1.0 + (i % 10_000) as f32).collect();
        assert_eq!(Groups::of(&items(&sizes)).len(), 10_000);
        assert_eq!(Groups::of(&items(&[1.0; 40_000])).len(), 1);
        let different = Groups::of(&items(&sizes[..10_000]));
        assert!(matches!(different, Groups::Single(10_000)));
    }
}
