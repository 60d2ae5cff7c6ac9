//! Many curves: the tree against testing every segment.

use super::*;
use crate::shapes::curve::{Bezier, CurveKind, CurveSpec};

fn tuft(n: usize) -> Vec<CurveSpec> {
    let mut random = Random(7);
    (0..n)
        .map(|_| {
            let root = random.cube().as_dvec3();
            let mut step = || random.cube().as_dvec3() * 0.3;
            CurveSpec {
                kind: CurveKind::Cylinder,
                segments: vec![Bezier([root, root + step(), root + step(), root + step()])],
                normals: vec![],
                width: [0.02, 0.005],
                split_depth: 3,
            }
        })
        .collect()
}

fn placed(specs: &[CurveSpec], transform: &Transform) -> Vec<CompiledShape> {
    let place = |spec: &CurveSpec| CompiledShape::Curves(Box::new(spec.place(transform, false)));
    specs.iter().map(place).collect()
}

#[test]
fn the_tree_finds_the_nearest_of_many_curves() {
    let specs = tuft(300);
    let geometry = scene(placed(&specs, &Transform::IDENTITY));
    assert_eq!(geometry.statistics().curve_segments, 300);
    let alone: Vec<Geometry> = specs
        .iter()
        .map(|spec| scene(placed(std::slice::from_ref(spec), &Transform::IDENTITY)))
        .collect();
    let mut random = Random(8);
    let mut met = 0;
    for _ in 0..600 {
        let o = random.direction() * 4.0;
        let ray = Ray::new(o, (random.cube() - o).normalize(), 0.0);
        let found = geometry.intersect(&ray, &opaque);
        let expected = alone
            .iter()
            .filter_map(|g| g.intersect(&ray, &opaque))
            .min_by(|a, b| a.t.total_cmp(&b.t));
        assert_eq!(found.map(|h| h.t), expected.map(|h| h.t));
        assert_eq!(geometry.occluded(&ray, &opaque), found.is_some());
        met += usize::from(found.is_some());
    }
    assert!(met > 100, "{met}");
}

#[test]
fn instances_and_uneven_places_show_the_same_curves() {
    let specs = tuft(100);
    let place = Transform::translate(DVec3::new(300.0, -20.0, 5.0))
        * Transform::rotate(30.0, DVec3::ONE)
        * Transform::scale(DVec3::new(2.0, 1.0, 0.5));
    let direct = scene(placed(&specs, &place));
    let instance = instanced(placed(&specs, &Transform::IDENTITY), &place);
    let mut random = Random(9);
    let (mut met, mut differ) = (0, 0);
    for _ in 0..1000 {
        let (from, to) = (
            random.direction().as_dvec3() * 4.0,
            random.cube().as_dvec3(),
        );
        let (o, to) = (place.point(from).as_vec3(), place.point(to).as_vec3());
        let ray = Ray::new(o, (to - o).normalize(), 0.0);
        match (
            direct.intersect(&ray, &opaque),
            instance.intersect(&ray, &opaque),
        ) {
            (Some(a), Some(b)) if (a.t - b.t).abs() < 1e-3 => met += 1,
            (None, None) => {}
            // Rays that graze an edge.
            _ => differ += 1,
        }
    }
    assert!(met > 100 && differ < 10, "{met} {differ}");
}
