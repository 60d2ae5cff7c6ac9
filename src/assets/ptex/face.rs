//! The face table: the resolution of each face, and its neighbors.

use super::bytes::Bytes;
use super::header::{Header, MeshKind};

/// Bytes per face in the table.
const FACE_BYTES: u64 = 20;

/// Maximum side of a face, as a power of two: the same as for other images, and all indices stay far from overflow.
const MAX_LOG2: i8 = 16;

/// 2ᵘ × 2ᵛ texels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Resolution {
    /// Logarithm to base 2 of the texels along u.
    pub u: u8,
    /// The same along v.
    pub v: u8,
}

impl Resolution {
    /// A single texel.
    pub const ONE: Resolution = Resolution { u: 0, v: 0 };

    /// Texels along u.
    #[inline]
    pub fn width(self) -> usize {
        1 << self.u
    }

    /// Texels along v.
    #[inline]
    pub fn height(self) -> usize {
        1 << self.v
    }

    /// Texels in all.
    pub fn texels(self) -> usize {
        self.width() * self.height()
    }

    pub(super) fn read(bytes: &mut Bytes) -> Result<Resolution, String> {
        let [u, v] = [bytes.u8()?, bytes.u8()?].map(|b| b as i8);
        let valid = |log2: i8| (0..=MAX_LOG2).contains(&log2);
        if !valid(u) || !valid(v) {
            return Err(format!(
                "a resolution of 2^{u} × 2^{v} texels cannot be read"
            ));
        }
        Ok(Resolution {
            u: u as u8,
            v: v as u8,
        })
    }
}

/// The neighbor across an edge.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Neighbor {
    /// Index of the face.
    pub face: u32,
    /// Which of its edges is shared. Quadrilaterals: v = 0, u = 1, v = 1, u = 0. Triangles: v = 0, u + v = 1, u = 0.
    pub edge: u8,
}

/// A face of the mesh.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Face {
    /// Its resolution; constant faces have one too.
    pub resolution: Resolution,
    /// The neighbors' edges, two bits each.
    edges: u8,
    flags: u8,
    /// Below 0 if there is none.
    neighbors: [i32; 4],
    /// Index of its first sample.
    pub(super) first: usize,
}

impl Face {
    const CONSTANT: u8 = 1;
    const EDITED: u8 = 2;
    const CONSTANT_AROUND: u8 = 4;
    const SUBFACE: u8 = 8;

    /// Returns `true` if the face has a single value.
    #[inline]
    pub fn is_constant(&self) -> bool {
        self.flags & Face::CONSTANT != 0
    }

    /// Returns `true` if the face and all its neighbors have the same single value.
    #[inline]
    pub fn is_constant_around(&self) -> bool {
        self.flags & Face::CONSTANT_AROUND != 0
    }

    /// Returns `true` if the face is one of the quadrilaterals that a non-quadrilateral face was split into. Its edges
    /// are half as long as those of whole faces beside it.
    #[inline]
    pub fn is_subface(&self) -> bool {
        self.flags & Face::SUBFACE != 0
    }

    /// Returns `true` if the face was replaced by an edit. Stored reductions are then out of date.
    pub(super) fn is_edited(&self) -> bool {
        self.flags & Face::EDITED != 0
    }

    pub(super) fn mark_edited(&mut self) {
        self.flags |= Face::EDITED;
    }

    /// The neighbor across edge `edge`, of which only the lowest two bits count.
    #[inline]
    pub fn neighbor(&self, edge: u8) -> Option<Neighbor> {
        let edge = edge & 3;
        let face = u32::try_from(self.neighbors[usize::from(edge)]).ok()?;
        Some(Neighbor {
            face,
            edge: self.edges >> (2 * edge) & 3,
        })
    }

    /// Reads a face whose texels have not been placed yet. `number` is for messages.
    pub(super) fn read(bytes: &mut Bytes, header: &Header, number: u32) -> Result<Face, String> {
        let located = |message: String| format!("face {number}: {message}");
        let resolution = Resolution::read(bytes).map_err(located)?;
        let [edges, flags] = [bytes.u8()?, bytes.u8()?];
        let mut neighbors = [0; 4];
        for neighbor in &mut neighbors {
            *neighbor = bytes.i32()?;
        }
        if header.mesh == MeshKind::Triangles {
            neighbors[3] = -1;
            if resolution.u != resolution.v {
                return Err(located("a triangle must be as fine in u as in v".into()));
            }
        }
        let face = Face {
            resolution,
            edges,
            flags,
            neighbors,
            first: 0,
        };
        for neighbor in (0..4).filter_map(|edge| face.neighbor(edge)) {
            if neighbor.face >= header.faces {
                let message = format!(
                    "its neighbor {} does not exist: there are {} faces",
                    neighbor.face, header.faces
                );
                return Err(located(message));
            }
            if neighbor.edge >= header.mesh.edges() {
                return Err(located("its neighbor has three edges, not four".into()));
            }
        }
        Ok(face)
    }
}

/// The face table.
pub(super) fn read(header: &Header, file: &[u8]) -> Result<Vec<Face>, String> {
    if header.faces == 0 {
        return Err("it has no faces".into());
    }
    let section = header.face_table;
    let size = FACE_BYTES * u64::from(header.faces);
    let table = Bytes::from(file, section.start, "face table")?.inflate(section.size, size)?;
    let mut bytes = Bytes::new(&table, "face table");
    (0..header.faces)
        .map(|number| Face::read(&mut bytes, header, number))
        .collect()
}

#[cfg(test)]
mod made;
