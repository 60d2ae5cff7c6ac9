//! Which light paths have been traced.

use std::ops::Range;

/// A set of numbers of light paths: disjoint ranges with gaps between them, in order.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct PathSet {
    ranges: Vec<Range<u64>>,
    count: u64,
}

impl PathSet {
    /// Its ranges.
    pub fn ranges(&self) -> &[Range<u64>] {
        &self.ranges
    }

    /// How many there are.
    pub fn count(&self) -> u64 {
        self.count
    }

    /// Adds ranges, no two of which overlap. Returns `false`, and adds nothing, if some of them are there already.
    pub fn insert_all(&mut self, new: &[Range<u64>]) -> bool {
        let is_new = !new.iter().any(|new| self.overlaps(new));
        is_new && new.iter().all(|new| self.insert(new.clone()))
    }

    /// The first range that ends at or after `start`.
    fn place(&self, start: u64) -> usize {
        self.ranges.partition_point(|range| range.end < start)
    }

    fn overlaps(&self, new: &Range<u64>) -> bool {
        let mut neighbors = self.ranges[self.place(new.start)..].iter().take(2);
        neighbors.any(|range| range.start < new.end && new.start < range.end && !new.is_empty())
    }

    /// Adds a range. Returns `false`, and adds nothing, if some of it are there already.
    pub fn insert(&mut self, new: Range<u64>) -> bool {
        if new.is_empty() {
            return true;
        }
        if self.overlaps(&new) {
            return false;
        }
        let at = self.place(new.start);
        self.count += new.end - new.start;
        let touches = |i: usize, edge: fn(&Range<u64>) -> u64, at: u64| {
            self.ranges.get(i).is_some_and(|range| edge(range) == at)
        };
        let left = touches(at, |range| range.end, new.start);
        let right = touches(at + usize::from(left), |range| range.start, new.end);
        match (left, right) {
            (true, true) => self.ranges[at].end = self.ranges.remove(at + 1).end,
            (true, false) => self.ranges[at].end = new.end,
            (false, true) => self.ranges[at].start = new.start,
            (false, false) => self.ranges.insert(at, new),
        }
        true
    }

    /// What is not there of `wanted`.
    pub fn missing(&self, wanted: Range<u64>) -> Vec<Range<u64>> {
        let mut found = Vec::new();
        let mut next = wanted.start;
        let ranges = self.ranges[self.place(wanted.start)..].iter();
        for range in ranges.take_while(|range| range.start < wanted.end) {
            if next < range.start {
                found.push(next..range.start);
            }
            next = next.max(range.end);
        }
        if next < wanted.end {
            found.push(next..wanted.end);
        }
        found
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        /// As a list of flags does it.
        #[test]
        fn ranges_are_a_set(ranges in prop::collection::vec((0u64..40, 0u64..9), 0..30)) {
            let (mut set, mut flags) = (PathSet::default(), [false; 50]);
            for (start, length) in ranges {
                let range = start..start + length;
                let cells = &mut flags[start as usize..(start + length) as usize];
                let is_new = !cells.contains(&true);
                prop_assert_eq!(set.insert(range), is_new);
                if is_new {
                    cells.fill(true);
                }
            }
            // All or nothing of several at once.
            let (before, free) = (set.clone(), set.missing(0..60));
            let with_one_that_is_there = [free.clone(), set.ranges().to_vec()].concat();
            prop_assert_eq!(set.insert_all(&with_one_that_is_there), before.count() == 0);
            if before.count() > 0 {
                prop_assert_eq!(&set, &before);
                prop_assert!(set.insert_all(&free));
            }
            prop_assert_eq!(set.missing(0..60).len(), 0);
            let set = before;
            let missing: Vec<u64> = set.missing(3..47).into_iter().flatten().collect();
            let expected: Vec<u64> = (3..47).filter(|i| !flags[*i as usize]).collect();
            prop_assert_eq!(missing, expected);
            prop_assert_eq!(set.count(), flags.iter().filter(|flag| **flag).count() as u64);
            let gaps = set.ranges().windows(2).all(|pair| pair[0].end < pair[1].start);
            prop_assert!(gaps && set.ranges().iter().all(|range| !range.is_empty()));
        }
    }
}
