//! Shapes: files of meshes by their headers, what the text describes by placing it, one shape at a time.

use super::tree;
use crate::accel::memory;
use crate::budget::Budget;
use crate::files::FileError;
use crate::math::transform::Transform;
use crate::scene::Frame;
use crate::scene::description::ShapeEntity;
use crate::shapes::{CompiledShape, MeshExtent, ShapeKind, Site};
use rayon::prelude::*;

/// The allocator keeps freed blocks below this, in bytes (glibc's least M_MMAP_THRESHOLD).
const SMALL: u64 = 128 << 10;

/// What all shapes come to, in bytes where nothing else is said.
#[derive(Clone, Debug, Default)]
pub(super) struct Shapes {
    /// Number of shapes, those of objects included.
    pub all: usize,
    /// In double precision, while they are placed.
    pub compiled: u64,
    /// Of these, in blocks so small that the allocator keeps them when they are freed.
    pub small: u64,
    /// As trees refer to them.
    pub stored: u64,
    /// What reading files takes for a while.
    pub loading: u64,
    /// All trees.
    pub trees: u64,
    /// What building the largest tree takes, besides.
    pub largest_tree: u64,
    /// Number of lights that shapes form.
    pub emitters: usize,
}

/// What one shape comes to.
#[derive(Clone, Copy, Debug, Default)]
struct Share {
    compiled: u64,
    stored: u64,
    loading: u64,
    primitives: usize,
    emitters: usize,
}

/// Adds up all shapes and instances; `threads` files are read at a time.
pub(super) fn survey(frame: &Frame, threads: usize, need_faces: bool) -> Result<Shapes, FileError> {
    let mut shapes = Shapes::default();
    let mut loading = Vec::new();
    let instances = frame.instances.len();
    let objects = frame.objects.iter().map(|object| (&object.shapes, 0));
    for (level, instances) in objects.chain([(&frame.shapes, instances)]) {
        let shares = level.par_iter().map(|shape| share(shape, need_faces));
        let shares: Vec<Share> = shares.collect::<Result<_, FileError>>()?;
        let mut primitives = instances;
        for share in &shares {
            shapes.compiled += share.compiled;
            shapes.stored += share.stored;
            shapes.small += if share.compiled < SMALL {
                share.compiled
            } else {
                0
            };
            shapes.emitters += share.emitters;
            primitives += share.primitives;
            loading.push(share.loading);
        }
        shapes.all += shares.len();
        shapes.stored += (instances * memory::INSTANCE) as u64;
        let [done, building] = tree(primitives);
        let building = building + (instances * memory::PLACING_INSTANCE) as u64;
        shapes.trees += done;
        shapes.largest_tree = shapes.largest_tree.max(building.saturating_sub(done));
    }
    loading.sort_unstable_by(|a, b| b.cmp(a));
    shapes.loading = loading.iter().take(threads).sum();
    Ok(shapes)
}

fn share(shape: &ShapeEntity, need_faces: bool) -> Result<Share, FileError> {
    let emits = shape.area_light.is_some();
    match &shape.spec.kind {
        ShapeKind::Quadric(_) => Ok(Share {
            compiled: memory::QUADRIC as u64,
            stored: memory::STORED_QUADRIC as u64,
            primitives: 1,
            emitters: usize::from(emits),
            loading: 0,
        }),
        ShapeKind::PlyMesh(file) | ShapeKind::ObjMesh(file) => {
            let mesh = file.extent()?;
            Ok(of_mesh(&mesh, emits, need_faces))
        }
        _ => Ok(of_text(shape, emits, need_faces)),
    }
}

fn of_mesh(mesh: &MeshExtent, emits: bool, need_faces: bool) -> Share {
    let faces = if need_faces { mesh.faces } else { 0 };
    Share {
        compiled: mesh.compiled(),
        stored: mesh.stored() + 4 * faces,
        // The file, and faces before they are triangles.
        loading: mesh.file + 16 * mesh.triangles,
        primitives: mesh.triangles as usize,
        emitters: if emits { mesh.triangles as usize } else { 0 },
    }
}

/// A shape that the text describes, by placing it.
fn of_text(shape: &ShapeEntity, emits: bool, need_faces: bool) -> Share {
    let site = Site {
        level_from_object: &Transform::IDENTITY,
        reverse_orientation: false,
        budget: &Budget::unlimited(),
    };
    match shape.spec.compile(&site) {
        Ok(CompiledShape::Mesh(mesh)) => of_mesh(&MeshExtent::of(&mesh.data), emits, need_faces),
        Ok(CompiledShape::Curves(curves)) => {
            let pieces = curves.stored(0, 0).map(|segment| segment.pieces());
            Share {
                compiled: curves.bytes() as u64,
                stored: (curves.segments.len() * memory::CURVE_SEGMENT + memory::CURVE) as u64,
                primitives: pieces.sum(),
                ..Share::default()
            }
        }
        // What cannot be placed is left out.
        Ok(CompiledShape::Quadric(_)) | Err(_) => Share::default(),
    }
}
