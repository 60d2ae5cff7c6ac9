//! Few triangles: one ray, many rays and the tree find the same.

use super::*;
use crate::math::instruction_set::InstructionSet;

/// An even grid of `n` × `n` squares, `copies` times, so that every hit is one of as many; rays through corners meet six times as many.
fn grid(n: u32, copies: usize) -> MeshData {
    let place = |i: u32| DVec3::new(f64::from(i % (n + 1)), f64::from(i / (n + 1)), 0.0) * 0.5;
    let square = |i: u32| {
        let a = i / n * (n + 1) + i % n;
        [[a, a + 1, a + n + 2], [a, a + n + 2, a + n + 1]]
    };
    let once: Vec<[u32; 3]> = (0..n * n).flat_map(square).collect();
    mesh(
        (0..(n + 1) * (n + 1)).map(place).collect(),
        once.repeat(copies),
    )
}

/// From anywhere into the cube, some of them along axes, through corners of the grid, of limited length, or no rays at all.
fn rays(seed: u64) -> Vec<Ray> {
    let mut random = Random(seed);
    let ray = |i: usize| {
        let mut ray = Ray::new(random.cube() * 2.0, random.direction(), 0.0);
        let corner = (random.cube() * 4.0).round() * 0.5 * Vec3::new(1.0, 1.0, 0.0);
        match i % 8 {
            0 => ray.d = [Vec3::X, Vec3::NEG_Y, Vec3::NEG_Z][i / 8 % 3],
            1 => (ray.o, ray.d) = (corner + Vec3::Z, Vec3::NEG_Z),
            2 => ray.d = (corner - ray.o).normalize(),
            3 => ray.t_max = random.next() * 2.0,
            4 if i % 40 == 4 => ray.d.y = f32::NAN,
            4 if i % 40 == 12 => ray.o.x = f32::INFINITY,
            4 => ray.d = Vec3::new(ray.d.x, ray.d.y, 0.0).normalize(),
            _ => ray.d = (random.cube() - ray.o).normalize(),
        }
        ray
    };
    (0..1003).map(ray).collect()
}

type Found = Vec<Option<(PrimitiveId, u32)>>;

/// What rays find, and whether shadow rays find anything, in calls of so many.
fn found(geometry: &Geometry, rays: &[Ray], at_once: usize) -> (Found, Vec<bool>) {
    let mut found = vec![None; rays.len()];
    let mut blocked = found.clone();
    for (rays, (found, blocked)) in rays
        .chunks(at_once)
        .zip(found.chunks_mut(at_once).zip(blocked.chunks_mut(at_once)))
    {
        geometry.closest_of_all(rays, &opaque, found);
        geometry.occluders(rays, &opaque, blocked);
    }
    let known = |found: &Option<ClosestHit>| found.map(|found| (found.id, found.t.to_bits()));
    let is_blocked = |found: &Option<ClosestHit>| found.is_some();
    (
        found.iter().map(known).collect(),
        blocked.iter().map(is_blocked).collect(),
    )
}

#[test]
fn one_ray_and_many_and_the_tree_find_the_same() {
    let meshes = [16, 17, 19, 21].map(|n| soup(n, 0.7, n as u64));
    let meshes = meshes
        .into_iter()
        .chain([grid(2, 4), grid(3, 2), grid(4, 1)]);
    let (mut hits, mut ties) = (0, 0);
    for (data, seed) in meshes.zip(0..) {
        let mut geometry = scene(vec![compiled(&data, &Transform::IDENTITY)]);
        assert!(geometry.top.few.is_some(), "{seed}");
        let rays = rays(seed);
        let (expected, blocked) = found(&geometry, &rays, 1);
        for set in InstructionSet::available() {
            geometry.top.tree.instructions = set;
            for at_once in [1, 4, 5, 16, 17, 128, rays.len()] {
                let (found, shadows) = found(&geometry, &rays, at_once);
                assert_eq!(found, expected, "{seed}: {at_once} with {}", set.name());
                assert_eq!(shadows, blocked, "{seed}: {at_once} with {}", set.name());
            }
        }
        geometry.top.few = None;
        let (by_tree, shadows) = found(&geometry, &rays, 1);
        assert_eq!(shadows, blocked, "{seed}");
        for (expected, found) in expected.iter().zip(&by_tree) {
            let distance = |found: &Option<(PrimitiveId, u32)>| found.map(|(_, t)| t);
            assert_eq!(distance(expected), distance(found), "{seed}");
            // Of equally near ones the tree has whichever it comes to first.
            ties += usize::from(expected != found);
            hits += usize::from(expected.is_some());
        }
    }
    assert!(hits > 1000 && ties > 50, "{hits} {ties}");
}

#[test]
fn fewer_or_more_triangles_or_other_shapes_have_a_tree_alone() {
    let few = |shapes| scene(shapes).top.few.is_some();
    let mesh = |data: MeshData| compiled(&data, &Transform::IDENTITY);
    let triangles = |n| mesh(soup(n, 0.1, 1));
    assert!(!few(vec![triangles(15)]));
    assert!(few(vec![triangles(16)]));
    assert!(few(vec![triangles(21)]));
    // Sixty-six corners, of which none is shared.
    assert!(!few(vec![triangles(22)]));
    assert!(few(vec![mesh(grid(2, 6))]));
    assert!(!few(vec![mesh(grid(2, 6)), triangles(1)]));
    assert!(!few(vec![triangles(16), full_sphere(Transform::IDENTITY)]));
}
