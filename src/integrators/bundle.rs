//! What camera paths that are walked one after the other bring: sums, and what is yet to be added to them.
//!
//! Nothing on a path depends on the direct light at its vertices. So it can be deferred until there is enough of it to be computed
//! side by side ([`super::path`]). All terms of a path are added in the order in which it has met them: sums have the bits that they
//! have if nothing is deferred.

use crate::cameras::BUNDLE;
use crate::math::Rgb;
use arrayvec::ArrayVec;

/// Terms that can wait: those of a bundle of paths with two or three vertices to each.
const TERMS: usize = 8 * BUNDLE;

/// The sums of up to [`BUNDLE`] paths.
#[derive(Default)]
pub(super) struct Sums {
    sums: ArrayVec<Rgb, BUNDLE>,
    /// Of all paths, in order.
    waiting: ArrayVec<Term, TERMS>,
}

/// Something to be added to the sum of a path.
#[derive(Clone, Copy)]
struct Term {
    path: u8,
    value: Rgb,
}

/// Place of a term that is not known yet.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Unknown(u32);

impl Sums {
    /// The next path has brought this, up to now or altogether.
    #[inline]
    pub(super) fn begin(&mut self, sum: Rgb) {
        // There is room: sums are taken after as many paths.
        let _ = self.sums.try_push(sum);
    }

    /// Is there room for another term? If not, [`Sums::settle`].
    #[inline]
    pub(super) fn has_room(&self) -> bool {
        !self.waiting.is_full()
    }

    /// The last path has met this light, or none unless it is [set](Sums::set) to something. There must be room.
    #[inline]
    pub(super) fn add(&mut self, value: Rgb) -> Unknown {
        let place = Unknown(self.waiting.len() as u32);
        let path = self.sums.len().wrapping_sub(1) as u8;
        let _ = self.waiting.try_push(Term { path, value });
        place
    }

    /// A term is known.
    #[inline]
    pub(super) fn set(&mut self, term: Unknown, value: Rgb) {
        if let Some(term) = self.waiting.get_mut(term.0 as usize) {
            term.value = value;
        }
    }

    /// Adds the terms that wait, all of which are known.
    ///
    /// Terms of nothing are added, too. They change no bit: a sum that begins as +0 never becomes −0.
    pub(super) fn settle(&mut self) {
        for term in self.waiting.drain(..) {
            if let Some(sum) = self.sums.get_mut(usize::from(term.path)) {
                *sum += term.value;
            }
        }
    }

    /// Takes the sums, path by path, when nothing waits.
    #[inline]
    pub(super) fn take(&mut self) -> ArrayVec<Rgb, BUNDLE> {
        self.sums.take()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn terms_are_added_in_the_order_they_were_met_in() {
        // In any other order single precision gives another sum.
        let terms = [1.0f32, 1e8, 3.0, -1e8, 0.5].map(Rgb::splat);
        let mut expected = Rgb::ZERO;
        terms.iter().for_each(|&term| expected += term);
        for unknown in 0..1u32 << terms.len() {
            let mut sums = Sums::default();
            let mut places = Vec::new();
            for _ in 0..3 {
                sums.begin(Rgb::ZERO);
                for (i, &term) in terms.iter().enumerate() {
                    if unknown >> i & 1 == 1 {
                        places.push((sums.add(Rgb::ZERO), term));
                    } else {
                        sums.add(term);
                    }
                }
            }
            // The last first: when a term becomes known does not matter.
            places
                .iter()
                .rev()
                .for_each(|&(place, term)| sums.set(place, term));
            sums.settle();
            assert_eq!(sums.take()[..], [expected; 3]);
        }
    }

    #[test]
    fn what_stays_unknown_is_nothing_and_a_path_goes_on_after_settling() {
        let mut sums = Sums::default();
        sums.begin(Rgb::ONE);
        while sums.has_room() {
            sums.add(Rgb::ZERO);
        }
        sums.settle();
        assert!(sums.has_room());
        sums.add(Rgb::ONE);
        sums.settle();
        sums.begin(Rgb::ZERO);
        assert_eq!(sums.take()[..], [Rgb::splat(2.0), Rgb::ZERO]);
    }
}
