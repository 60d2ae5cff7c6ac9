//! Faces as tests make and write them.

use super::{Face, Resolution};

impl Face {
    /// A face for the writer of tests, with neighbors as (face, edge).
    pub(crate) fn new(resolution: Resolution, neighbors: [Option<(u32, u8)>; 4]) -> Face {
        let edges = (0..4).map(|e| neighbors[e].map_or(0, |(_, edge)| edge << (2 * e)));
        Face {
            resolution,
            edges: edges.fold(0, |all, edge| all | edge),
            flags: 0,
            neighbors: neighbors.map(|n| n.map_or(-1, |(face, _)| face as i32)),
            first: 0,
        }
    }

    pub(crate) fn as_subface(mut self) -> Face {
        self.flags |= Face::SUBFACE;
        self
    }

    pub(crate) fn as_constant(mut self, around: bool) -> Face {
        self.flags |= Face::CONSTANT;
        if around {
            self.flags |= Face::CONSTANT_AROUND;
        }
        self
    }

    /// As in the file.
    pub(crate) fn to_bytes(self) -> Vec<u8> {
        let head = [self.resolution.u, self.resolution.v, self.edges, self.flags];
        let neighbors = self.neighbors.iter().flat_map(|n| n.to_le_bytes());
        head.into_iter().chain(neighbors).collect()
    }
}
