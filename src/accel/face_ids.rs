//! Face indices of triangles in their original meshes (Ptex).

/// The face indices of a level's meshes that have them. Kept apart from the meshes, which have no room for them: few
/// scenes use Ptex.
#[derive(Default)]
pub(super) struct FaceIds {
    /// By the index of the mesh's first triangle within the level, ascending.
    meshes: Vec<(u32, Box<[u32]>)>,
}

impl FaceIds {
    /// Appends those of a mesh; `ids` may be empty.
    pub(super) fn push(&mut self, first: u32, ids: Vec<u32>) {
        if !ids.is_empty() {
            self.meshes.push((first, ids.into()));
        }
    }

    /// The face of triangle `i` of the mesh that starts with triangle `first`; 0 if the mesh has no face indices.
    #[inline]
    pub(super) fn of(&self, first: u32, i: usize) -> u32 {
        match self.meshes.is_empty() {
            true => 0,
            false => self.find(first, i).unwrap_or(0),
        }
    }

    fn find(&self, first: u32, i: usize) -> Option<u32> {
        let mesh = self.meshes.binary_search_by_key(&first, |(f, _)| *f).ok()?;
        self.meshes.get(mesh)?.1.get(i).copied()
    }

    /// Memory in bytes.
    pub(super) fn bytes(&self) -> usize {
        let ids = self.meshes.iter().map(|(_, ids)| size_of_val(&ids[..]));
        ids.sum::<usize>() + size_of_val(&self.meshes[..])
    }
}
