//! Files that scenes refer to: meshes and pictures.

pub mod mesh;
pub mod obj;
pub mod ply;
