//! What the binary builder is given: every box once, and no two quite alike.

use super::aabb::Aabb;
use super::tree::Item;
use crate::math::Vec3;
use crate::math::hash::{mix, mix2, unit_float};
use rayon::prelude::*;

/// Up to how much larger a box looks to the binary builder than it is ([`Groups::boxes`]). Boxes that
/// grow faster than this from one to the next run out of single precision after 20,000.
const UNEVENNESS: f32 = 0.01;

/// Items by box: the binary builder pairs neighbours of least cost, and among thousands of equal
/// ones finds a single pair a pass, which takes for ever. So it gets every box once.
pub(super) enum Groups {
    /// No two boxes are equal: every item is a group.
    Single(usize),
    /// Some are.
    Shared {
        /// Items, those with equal boxes together.
        order: Vec<u32>,
        /// Where groups start in `order`, and its length.
        starts: Vec<u32>,
    },
}

impl Groups {
    pub fn of(items: &[Item]) -> Groups {
        let bits = |v: Vec3| {
            v.to_array()
                .into_iter()
                .fold(0, |h, x| mix2(h, u64::from(x.to_bits())))
        };
        let hash = |item: &Item| mix(bits(item.bounds.min)) ^ bits(item.bounds.max);
        let mut hashes: Vec<u64> = items.par_iter().map(hash).collect();
        hashes.par_sort_unstable();
        if hashes.par_windows(2).all(|pair| pair[0] != pair[1]) {
            // The usual case; in the file's order neighbours are near each other in memory.
            return Groups::Single(items.len());
        }
        drop(hashes);
        let mut keys: Vec<(u64, u32)> = items
            .iter()
            .zip(0..)
            .map(|(item, i)| (hash(item), i))
            .collect();
        keys.par_sort_unstable();
        let mut starts: Vec<u32> = (0..keys.len() as u32)
            .filter(|&i| i == 0 || keys[i as usize - 1].0 != keys[i as usize].0)
            .collect();
        starts.push(keys.len() as u32);
        let order = keys.into_iter().map(|(_, i)| i).collect();
        Groups::Shared { order, starts }
    }

    /// How many groups there are.
    pub fn len(&self) -> usize {
        match self {
            Groups::Single(len) => *len,
            Groups::Shared { starts, .. } => starts.len() - 1,
        }
    }

    /// The items of a group.
    pub fn members(&self, group: u32) -> impl ExactSizeIterator<Item = u32> + '_ {
        // An item on its own stands for a slice of one.
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

    /// The box around a group. (Around all members: hashes may collide.)
    pub fn bounds(&self, group: u32, items: &[Item]) -> Aabb {
        self.members(group)
            .fold(Aabb::EMPTY, |b, i| b.union(items[i as usize].bounds))
    }

    /// What the binary builder sees: one box a group, each a little larger by a share of its own.
    ///
    /// The builder pairs mutual nearest neighbours, pass by pass. Where every box's nearest is the
    /// one before it (a row of equal boxes, boxes that grow from one to the next) there is one
    /// mutual pair, and as many passes as boxes. Uneven sizes make a third of them mutual.
    pub fn boxes(&self, items: &[Item]) -> Vec<obvhs::aabb::Aabb> {
        (0..self.len() as u32)
            .into_par_iter()
            .map(|group| {
                let bounds = self.bounds(group, items);
                let share = UNEVENNESS * unit_float(mix(u64::from(group)));
                let grown = (bounds.max - bounds.min) * share;
                // Where the sum overflows the box was as large as numbers are.
                let max = (bounds.max + grown).min(Vec3::MAX);
                obvhs::aabb::Aabb::new(bounds.min.into(), max.into())
            })
            .collect()
    }
}
