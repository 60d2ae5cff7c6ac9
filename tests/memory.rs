//! What a mesh takes in memory, counted by the allocator: when all is built, and at most on the way.
//!
//! One test in a binary of its own, so that nothing else allocates meanwhile.

#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    reason = "a panic is an answer here"
)]

use fstop::accel::{Geometry, GeometryBuilder, PrimitiveAttributes};
use fstop::assets::ply;
use fstop::budget::Budget;
use fstop::math::transform::Transform;
use fstop::shapes::CompiledShape;
use fstop::shapes::mesh::TriangleMesh;
use std::alloc::{GlobalAlloc, Layout, System};
use std::io::Write;
use std::sync::atomic::{AtomicUsize, Ordering::Relaxed};

/// Passes everything on to the system and counts bytes.
struct Counting;

static LIVE: AtomicUsize = AtomicUsize::new(0);
static PEAK: AtomicUsize = AtomicUsize::new(0);

// SAFETY: every call is passed on unchanged.
#[expect(unsafe_code, reason = "nothing else counts what a test asks for")]
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        let live = LIVE.fetch_add(layout.size(), Relaxed) + layout.size();
        PEAK.fetch_max(live, Relaxed);
        // SAFETY: as asked.
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, p: *mut u8, layout: Layout) {
        LIVE.fetch_sub(layout.size(), Relaxed);
        // SAFETY: as asked.
        unsafe { System.dealloc(p, layout) }
    }
}

#[global_allocator]
static COUNTING: Counting = Counting;

/// Quads along each side of the square; four million triangles.
const SIDE: u32 = 1414;

/// A wavy square without normals and texture coordinates as a binary PLY file.
fn write_ply(mut file: impl Write) -> std::io::Result<()> {
    write!(
        file,
        "ply\nformat binary_little_endian 1.0\nelement vertex {}\nproperty float x\n\
         property float y\nproperty float z\nelement face {}\n\
         property list uchar int vertex_indices\nend_header\n",
        (SIDE + 1) * (SIDE + 1),
        2 * SIDE * SIDE
    )?;
    for i in 0..(SIDE + 1) * (SIDE + 1) {
        let (x, y) = ((i % (SIDE + 1)) as f32, (i / (SIDE + 1)) as f32);
        for v in [x, y, (0.3 * x).sin() * (0.2 * y).cos()] {
            file.write_all(&v.to_le_bytes())?;
        }
    }
    for i in 0..SIDE * SIDE {
        let corner = i / SIDE * (SIDE + 1) + i % SIDE;
        let [a, b, c, d] = [corner, corner + 1, corner + SIDE + 2, corner + SIDE + 1];
        for face in [[a, b, c], [a, c, d]] {
            file.write_all(&[3])?;
            for v in face {
                file.write_all(&v.to_le_bytes())?;
            }
        }
    }
    file.flush()
}

fn load_and_build(path: &std::path::Path) -> Geometry {
    let data = ply::load(path, &Budget::unlimited()).expect("the file just written");
    let mesh = TriangleMesh::new(data, &Transform::IDENTITY, false);
    let mut builder = GeometryBuilder::default();
    builder.add(
        CompiledShape::Mesh(Box::new(mesh)),
        PrimitiveAttributes::default(),
    );
    builder.build(vec![]).expect("not too many triangles")
}

/// Memory that the process has of the system, in bytes: now, and at most so far. `None` where `/proc` does not tell.
fn resident() -> Option<[f64; 2]> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let of = |name: &str| {
        let line = status.lines().find(|line| line.starts_with(name))?;
        Some(1024.0 * line.split_whitespace().nth(1)?.parse::<f64>().ok()?)
    };
    Some([of("VmRSS:")?, of("VmHWM:")?])
}

#[test]
fn a_bare_mesh_takes_at_most_a_hundred_bytes_a_triangle() {
    // The thread pool's own memory is not the mesh's.
    rayon::join(|| (), || ());
    let file = tempfile::NamedTempFile::new().expect("a temporary file");
    write_ply(std::io::BufWriter::new(file.as_file())).expect("room for 80 MB");
    let before = LIVE.load(Relaxed);
    PEAK.store(before, Relaxed);
    let resident_before = resident();
    let geometry = load_and_build(file.path());
    let (live, peak) = (LIVE.load(Relaxed) - before, PEAK.load(Relaxed) - before);
    let statistics = geometry.statistics();
    assert_eq!(statistics.triangles as u32, 2 * SIDE * SIDE);
    let each = |bytes: usize| bytes as f64 / statistics.triangles as f64;
    println!(
        "bytes a triangle: {:.1} by its own account, {:.1} allocated, {:.1} at most",
        each(statistics.bytes),
        each(live),
        each(peak)
    );
    // Vertices and tree: what issue 5 asks for.
    assert!(each(statistics.bytes) <= 100.0);
    // Nothing is left out of that account but vectors of a few elements, and what rayon's workers
    // keep for themselves.
    let aside = live.abs_diff(statistics.bytes);
    assert!(aside < 64 << 10, "{aside} bytes more or less");
    // There are two copies of the tree while it is joined.
    assert!(each(peak) <= 200.0);
    // The system need not have the room of what is not yet copied, nor of what is.
    if let (Some([before, _]), Some([_, peak])) = (resident_before, resident()) {
        let most = (peak - before) / statistics.triangles as f64;
        println!("bytes a triangle: {most:.1} of the system's at most");
        assert!(most <= 140.0);
    }
}
