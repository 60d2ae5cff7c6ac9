//! Photons in a balanced k-d tree (Bentley 1975; Jensen 2001, §6): those near a point are found whatever the radius, which
//! differs from pixel to pixel, and however far the scene extends.
//!
//! The tree is the order of the photons in their array: the middle one of a range divides it, those before it have
//! lower coordinates along its axis, those behind it higher ones. That order is determined by the photons as they were given, so
//! sums over neighbors do not depend on the number of threads that sort.

use crate::math::{Rgb, Vec3};

/// A range of so few photons is not divided.
const LEAF: usize = 8;

/// A range of so many is sorted by two threads.
const SHARED: usize = 1 << 13;

/// Light that arrives at a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Photon {
    /// Where, render space.
    pub p: Vec3,
    /// The axis that it divides its range by: 0 to 2.
    axis: u32,
    /// Unit direction that the light comes from.
    pub wi: Vec3,
    /// Its flux, if it were the only one of its iteration.
    pub flux: Rgb,
}

impl Photon {
    /// From direction `wi`.
    pub(super) fn new(p: Vec3, wi: Vec3, flux: Rgb) -> Photon {
        let axis = 0;
        Photon { p, axis, wi, flux }
    }
}

/// The photons of an iteration.
#[derive(Debug, Default)]
pub struct PhotonMap {
    photons: Vec<Photon>,
}

impl PhotonMap {
    /// Replaces the photons by those of `parts`, one part after the other. The memory stays.
    pub fn fill<'p>(&mut self, parts: impl Iterator<Item = &'p [Photon]> + Clone) {
        self.photons.clear();
        let count: usize = parts.clone().map(<[Photon]>::len).sum();
        if count > self.photons.capacity() {
            self.photons.reserve(count + count / 2);
        }
        parts.for_each(|part| self.photons.extend_from_slice(part));
        arrange(&mut self.photons);
    }

    /// Visits all photons that are not farther than `radius` from `p`, in an order that depends on the map alone.
    pub(super) fn visit(&self, p: Vec3, radius: f32, mut visit: impl FnMut(&Photon)) {
        near(&self.photons, p, radius * radius, &mut visit);
    }
}

/// Puts the photons in the order of the tree.
fn arrange(photons: &mut [Photon]) {
    if photons.len() <= LEAF {
        return;
    }
    let (mut low, mut high) = (Vec3::INFINITY, Vec3::NEG_INFINITY);
    for photon in &*photons {
        (low, high) = (low.min(photon.p), high.max(photon.p));
    }
    let axis = (high - low).max_position();
    let middle = photons.len() / 2;
    let by_axis = |a: &Photon, b: &Photon| a.p[axis].total_cmp(&b.p[axis]);
    let (before, divider, behind) = photons.select_nth_unstable_by(middle, by_axis);
    divider.axis = axis as u32;
    if before.len() < SHARED {
        arrange(before);
        arrange(behind);
    } else {
        rayon::join(|| arrange(before), || arrange(behind));
    }
}

/// Visits photons whose squared distance is at most `most`. Differences along an axis are rounded as in distances, so that none
/// is lost at the rim.
fn near(mut photons: &[Photon], p: Vec3, most: f32, visit: &mut impl FnMut(&Photon)) {
    let is_near = |photon: &&Photon| p.distance_squared(photon.p) <= most;
    while photons.len() > LEAF {
        let (before, rest) = photons.split_at(photons.len() / 2);
        let [divider, behind @ ..] = rest else { return };
        Some(divider).filter(is_near).map(&mut *visit);
        let axis = divider.axis as usize;
        let beyond = p[axis] - divider.p[axis];
        let reaches_over = beyond * beyond <= most;
        let (own, other) = if beyond < 0.0 {
            (before, behind)
        } else {
            (behind, before)
        };
        if reaches_over {
            near(other, p, most, visit);
        }
        photons = own;
    }
    photons.iter().filter(is_near).for_each(visit);
}
