//! Few triangles and quadrics: one ray, many rays and the tree find the same.

use super::*;
use crate::math::instruction_set::InstructionSet;
use crate::shapes::cylinder::Cylinder;
use crate::shapes::disk::Disk;

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

/// Spheres: one within another, one touching a plane, some in one place; from the ninth on squeezed.
fn balls(count: usize) -> Vec<CompiledShape> {
    let places = [
        Transform::translate(DVec3::new(0.2, 0.1, 0.3)) * Transform::scale(DVec3::splat(0.5)),
        Transform::translate(DVec3::new(0.2, 0.1, 0.3)) * Transform::scale(DVec3::splat(0.25)),
        Transform::translate(DVec3::new(-0.5, 0.5, 0.25)) * Transform::scale(DVec3::splat(0.25)),
        Transform::translate(DVec3::new(-0.5, 0.5, 0.25)) * Transform::scale(DVec3::splat(-0.25)),
        Transform::translate(DVec3::new(-0.5, 0.5, 0.25)) * Transform::scale(DVec3::splat(0.25)),
        Transform::scale(DVec3::splat(40.0)),
        Transform::translate(DVec3::new(1.0, 0.5, 0.0)) * Transform::scale(DVec3::splat(1e-3)),
        Transform::translate(DVec3::new(0.9, -0.4, -0.3)) * Transform::scale(DVec3::splat(0.1)),
        Transform::scale(DVec3::new(0.3, 0.6, 0.3)),
        Transform::translate(DVec3::X) * Transform::scale(DVec3::new(0.3, 0.6, 0.3)),
    ];
    places.into_iter().take(count).map(full_sphere).collect()
}

/// A disk in the plane of the grid, and a cylinder.
fn others() -> [CompiledShape; 2] {
    let forms = [
        Form::Disk(Disk::new(0.0, 0.7, 0.1, 360.0)),
        Form::Cylinder(Cylinder::new(0.4, -0.2, 0.6, 300.0)),
    ];
    let quadric = |form| Quadric::new(form, Transform::IDENTITY, false);
    forms.map(|form| CompiledShape::Quadric(Box::new(quadric(form))))
}

#[test]
fn one_ray_and_many_and_the_tree_find_the_same() {
    let mesh = |data: MeshData| vec![compiled(&data, &Transform::IDENTITY)];
    let soups = [16, 17, 19, 21].map(|n| mesh(soup(n, 0.7, n as u64)));
    let grids = [grid(2, 4), grid(3, 2), grid(4, 1)].map(mesh);
    let with = |data, round: Vec<CompiledShape>| mesh(data).into_iter().chain(round).collect();
    let scenes = soups.into_iter().chain(grids).chain([
        with(grid(1, 2), balls(5)),
        with(grid(2, 2), balls(8).into_iter().chain(others()).collect()),
        with(soup(6, 0.7, 3), others().into()),
        balls(8),
        balls(1),
    ]);
    let (mut hits, mut all_round, mut other_triangles) = (0, 0, 0);
    for (shapes, seed) in scenes.zip(0..) {
        let mut geometry = scene(shapes);
        assert!(geometry.top.few.is_some(), "{seed}");
        let rays = rays(seed);
        let (expected, blocked) = found(&geometry, &rays, 1);
        for set in InstructionSet::available() {
            geometry.top.tree.instructions = set;
            for at_once in [1, 4, 5, 16, 17, 23, 128, rays.len()] {
                let (found, shadows) = found(&geometry, &rays, at_once);
                assert_eq!(found, expected, "{seed}: {at_once} with {}", set.name());
                assert_eq!(shadows, blocked, "{seed}: {at_once} with {}", set.name());
            }
        }
        hits += expected.iter().flatten().count();
        let round = { expected.iter().flatten() }.filter(|(id, _)| !id.is_triangle());
        all_round += round.count();
        geometry.top.few = None;
        let (by_tree, shadows) = found(&geometry, &rays, 1);
        assert_eq!(shadows, blocked, "{seed}");
        for (expected, found) in expected.iter().zip(&by_tree) {
            let distance = |found: &Option<(PrimitiveId, u32)>| found.map(|(_, t)| t);
            assert_eq!(distance(expected), distance(found), "{seed}");
            other_triangles += usize::from(expected != found);
        }
    }
    assert!(hits > 2000 && all_round > 800, "{hits} {all_round}");
    // Next to corners of the grids, where rounding lets a ray meet triangles whose boxes it passes.
    assert!(other_triangles < 10, "{other_triangles}");
}

#[test]
fn more_or_other_shapes_have_a_tree_alone() {
    let few = |shapes| scene(shapes).top.few.is_some();
    let mesh = |data: MeshData| compiled(&data, &Transform::IDENTITY);
    let triangles = |n| mesh(soup(n, 0.1, 1));
    assert!(!few(Vec::new()));
    assert!(!few(vec![triangles(15)]));
    assert!(few(vec![triangles(16)]));
    assert!(few(vec![triangles(21)]));
    // Sixty-six corners, of which none is shared.
    assert!(!few(vec![triangles(22)]));
    assert!(few(vec![mesh(grid(2, 6))]));
    assert!(!few(vec![mesh(grid(2, 6)), triangles(1)]));
    assert!(few(balls(8)));
    // The ninth is no ball.
    assert!(few(balls(9)));
    let others = |n| others().into_iter().cycle().take(n).collect::<Vec<_>>();
    assert!(few(others(2)));
    assert!(!few(others(3)));
    assert!(few(vec![triangles(16), full_sphere(Transform::IDENTITY)]));
    assert!(few(vec![triangles(1), full_sphere(Transform::IDENTITY)]));
}
