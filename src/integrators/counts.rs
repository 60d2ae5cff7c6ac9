//! Counts of what paths do (`--stats`): each worker has its own while it renders a block of samples, and hands them over at
//! its end. No lock, atomic or allocation per ray; if nobody asked, one test of a pointer that is there anyway.

use super::witness::{Met, Place};
use crate::handles::LightId;
use crate::world::World;

/// What paths from the camera have done.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Counts {
    /// Vertices on surfaces, by material; the last on surfaces without one.
    pub surfaces: Vec<u64>,
    /// Vertices in media.
    pub in_media: u64,
    /// Rays that left the scene.
    pub escaped: u64,
    /// Shadow rays to lights, by light; the second number those that nothing blocked.
    pub shadows: Vec<[u64; 2]>,
    /// Rays of `ambientocclusion` after the camera's.
    pub occlusion: u64,
    /// Paths, by the number of scattering events before their last vertex.
    pub lengths: Vec<u64>,
    /// Camera rays that the lens blocked: they have no path.
    pub blocked: u64,
    depth: usize,
}

impl Counts {
    /// Nothing yet, of a world.
    pub fn new(world: &World) -> Counts {
        Counts {
            surfaces: vec![0; world.materials.len() + 1],
            shadows: vec![[0; 2]; world.lights.len()],
            ..Counts::default()
        }
    }

    /// Rays that paths were extended by.
    pub fn rays(&self) -> u64 {
        self.surfaces.iter().sum::<u64>() + self.in_media + self.escaped
    }

    /// Number of paths.
    pub fn paths(&self) -> u64 {
        self.lengths.iter().sum()
    }

    pub(super) fn arrive(&mut self, place: Place) {
        self.depth = place.depth as usize;
        let without = self.surfaces.len() - 1;
        match place.met {
            Met::Surface(id) => self.surfaces[id.map_or(without, |id| id.index())] += 1,
            Met::Medium => self.in_media += 1,
            Met::Background => self.escaped += 1,
        }
    }

    pub(super) fn shadow(&mut self, light: LightId, is_lit: bool) {
        self.shadows[light.index()][usize::from(is_lit)] += 1;
    }

    /// The path is over.
    pub fn end_path(&mut self) {
        let depth = std::mem::take(&mut self.depth);
        if self.lengths.len() <= depth {
            // Grows to the longest path, once in a while.
            self.lengths.resize(depth + 1, 0);
        }
        self.lengths[depth] += 1;
    }

    /// Adds those of another worker.
    pub fn add(&mut self, other: &Counts) {
        let longest = self.lengths.len().max(other.lengths.len());
        self.lengths.resize(longest, 0);
        let pairs = self.lengths.iter_mut().zip(&other.lengths);
        pairs.for_each(|(sum, n)| *sum += n);
        let pairs = self.surfaces.iter_mut().zip(&other.surfaces);
        pairs.for_each(|(sum, n)| *sum += n);
        let pairs = self.shadows.as_flattened_mut().iter_mut();
        let pairs = pairs.zip(other.shadows.as_flattened());
        pairs.for_each(|(sum, n)| *sum += n);
        self.in_media += other.in_media;
        self.escaped += other.escaped;
        self.occlusion += other.occlusion;
        self.blocked += other.blocked;
    }
}
