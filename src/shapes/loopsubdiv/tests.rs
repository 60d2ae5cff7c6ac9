//! Laws of the refined topology and of the limit surface.

use super::topology::{NONE, Topology};
use super::*;
use crate::math::Vec3;
use crate::params::testing::read;
use std::collections::HashMap;

/// A solid of eight triangles with six vertices of four neighbors.
fn octahedron() -> LoopSubdivSpec {
    let positions = [DVec3::X, DVec3::Y, DVec3::Z];
    LoopSubdivSpec {
        levels: 0,
        positions: positions.iter().flat_map(|&p| [p, -p]).collect(),
        // Outward: x y z, with every reflection turning the order round.
        triangles: (0..8)
            .map(|i: u32| {
                let [x, y, z] = [i & 1, 2 + (i >> 1 & 1), 4 + (i >> 2 & 1)];
                if i.count_ones().is_multiple_of(2) {
                    [x, y, z]
                } else {
                    [y, x, z]
                }
            })
            .collect(),
    }
}

/// An open grid of `n` × `n` squares in the plane z = 0, bent by `bend`.
fn grid(n: u32, bend: impl Fn(f64, f64) -> f64) -> LoopSubdivSpec {
    let at = |i, j| j * (n + 1) + i;
    let mut positions = Vec::new();
    for j in 0..=n {
        for i in 0..=n {
            let (x, y) = (f64::from(i) / f64::from(n), f64::from(j) / f64::from(n));
            positions.push(DVec3::new(x, y, bend(x, y)));
        }
    }
    let cells = (0..n * n).map(|c| (c % n, c / n));
    LoopSubdivSpec {
        levels: 0,
        positions,
        triangles: cells
            .flat_map(|(i, j)| {
                [
                    [at(i, j), at(i + 1, j), at(i + 1, j + 1)],
                    [at(i, j), at(i + 1, j + 1), at(i, j + 1)],
                ]
            })
            .collect(),
    }
}

/// Three fans of triangles on one edge, a Möbius strip, a pillow of two triangles, two
/// tetrahedra that share a vertex only.
fn awkward() -> Vec<Vec<[u32; 3]>> {
    let tetrahedron = |v: [u32; 4]| {
        [[0, 1, 2], [0, 3, 1], [0, 2, 3], [1, 3, 2]].map(|t: [usize; 3]| t.map(|i| v[i]))
    };
    vec![
        vec![[0, 1, 2], [1, 0, 3], [0, 1, 4], [0, 1, 5]],
        vec![
            [0, 1, 2],
            [2, 1, 3],
            [2, 3, 4],
            [4, 3, 0],
            [4, 0, 1],
            [0, 2, 1],
        ],
        vec![[0, 1, 2], [2, 1, 0]],
        [tetrahedron([0, 1, 2, 3]), tetrahedron([0, 4, 5, 6])].concat(),
        vec![[0, 1, 2], [0, 1, 2], [3, 3, 4]],
        vec![[5, 5, 5]],
        vec![],
    ]
}

fn some_positions(n: usize) -> Vec<DVec3> {
    (0..n)
        .map(|i| {
            DVec3::new(
                (i as f64).sin(),
                (2.3 * i as f64).cos(),
                (i * i) as f64 * 0.1,
            )
        })
        .collect()
}

/// Twins are each other's, and rings what the triangles say.
fn check_topology(t: &Topology) {
    for (h, &twin) in (0..).zip(&t.twins) {
        if twin != NONE {
            assert_eq!(t.twins[twin as usize], h);
            assert_eq!((t.origin(twin), t.target(twin)), (t.target(h), t.origin(h)));
        }
    }
    for (i, vertex) in (0..).zip(&t.vertices) {
        assert_eq!(t.origin(vertex.start), i);
        let mut ring = Vec::new();
        t.ring(vertex, |n| ring.push(n));
        assert_eq!(ring.len() as u32, vertex.valence);
        assert!(!ring.contains(&i));
    }
}

#[test]
fn refining_keeps_twins_rings_and_holes() {
    let solids = [octahedron(), grid(3, |_, _| 0.0)];
    let awkward = awkward().into_iter().map(|triangles| LoopSubdivSpec {
        levels: 0,
        positions: some_positions(7),
        triangles,
    });
    for spec in solids.into_iter().chain(awkward) {
        let mut topology = ControlMesh::new(&spec.triangles, &spec.positions).topology;
        check_topology(&topology);
        let holes = |t: &Topology| t.twins.iter().filter(|&&t| t == NONE).count();
        let euler = |t: &Topology| {
            let edges = (t.twins.len() + holes(t)) / 2;
            t.vertices.len() as i64 - edges as i64 + t.triangles.len() as i64
        };
        for _ in 0..3 {
            let finer = topology.refine();
            check_topology(&finer);
            assert_eq!(finer.triangles.len(), 4 * topology.triangles.len());
            assert_eq!(holes(&finer), 2 * holes(&topology));
            assert_eq!(euler(&finer), euler(&topology));
            topology = finer;
        }
    }
}

#[test]
fn what_is_no_manifold_is_said_and_ends() {
    let warnings = |triangles: &[[u32; 3]]| {
        let spec = LoopSubdivSpec {
            levels: 2,
            positions: some_positions(7),
            triangles: triangles.to_vec(),
        };
        let mesh = spec.subdivide();
        assert!(mesh.positions.iter().all(|p| p.is_finite()));
        assert_eq!(mesh.normals.len(), mesh.positions.len());
        mesh.warnings.join("; ")
    };
    let said: Vec<String> = awkward().iter().map(|t| warnings(t)).collect();
    assert!(said[0].contains("no manifold: 2 edges"), "{}", said[0]);
    assert!(said[1].contains("no manifold"), "{}", said[1]);
    assert_eq!((said[2].as_str(), said[3].as_str()), ("", ""));
    assert!(
        said[4].contains("1 of 3 triangles") && said[4].contains("6 edges"),
        "{}",
        said[4]
    );
    assert!(said[5].contains("1 of 1 triangles"));
}

/// The mean of the corners' neighbors, the slow way: for closed meshes.
fn brute_refine(triangles: &[[u32; 3]], p: &[DVec3]) -> (Vec<[u32; 3]>, Vec<DVec3>) {
    let mut opposite: HashMap<(u32, u32), Vec<u32>> = HashMap::new();
    for t in triangles {
        for j in 0..3 {
            let (a, b) = (t[j], t[(j + 1) % 3]);
            opposite
                .entry((a.min(b), a.max(b)))
                .or_default()
                .push(t[(j + 2) % 3]);
        }
    }
    let mut finer: Vec<DVec3> = (0..p.len() as u32)
        .map(|i| {
            let around = opposite.keys().filter(|(a, b)| *a == i || *b == i);
            let ring: Vec<DVec3> = around.map(|(a, b)| p[(a + b - i) as usize]).collect();
            let n = ring.len() as f64;
            let weight = if n == 3.0 {
                3.0 / 16.0
            } else {
                3.0 / (8.0 * n)
            };
            p[i as usize] * (1.0 - n * weight) + weight * ring.iter().sum::<DVec3>()
        })
        .collect();
    let mut edges: Vec<_> = opposite.into_iter().collect();
    edges.sort();
    let mut number = HashMap::new();
    for ((a, b), across) in edges {
        number.insert((a, b), finer.len() as u32);
        let [a, b, c, d] = [a, b, across[0], across[1]].map(|i| p[i as usize]);
        finer.push((a + b) * 0.375 + (c + d) * 0.125);
    }
    let middle = |a: u32, b: u32| number[&(a.min(b), a.max(b))];
    let cut = triangles.iter().flat_map(|&[a, b, c]| {
        let (ab, bc, ca) = (middle(a, b), middle(b, c), middle(c, a));
        [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]
    });
    (cut.collect(), finer)
}

#[test]
fn positions_are_those_of_the_rules_applied_the_slow_way() {
    let spec = octahedron();
    let control = ControlMesh::new(&spec.triangles, &spec.positions);
    let (mut topology, mut positions) = (control.topology, control.positions);
    let (mut triangles, mut expected) = (topology.triangles.clone(), positions.clone());
    for _ in 0..3 {
        let finer = topology.refine();
        positions = topology.refined_positions(&finer, &positions);
        topology = finer;
        (triangles, expected) = brute_refine(&triangles, &expected);
        // In no particular order.
        for p in &positions {
            assert!(expected.iter().any(|q| (*p - *q).length() < 1e-14));
        }
        assert_eq!(positions.len(), expected.len());
    }
    assert_eq!(triangles.len(), topology.triangles.len());
}

#[test]
fn the_limit_of_inner_vertices_does_not_depend_on_the_levels() {
    let wavy = grid(5, |x, y| (7.0 * x).sin() * (5.0 * y).cos());
    let inner = |i: usize| (1..5).contains(&(i % 6)) && (1..5).contains(&(i / 6));
    for (spec, fixed) in [(octahedron(), (0..6).collect()), {
        let inner: Vec<usize> = (0..36).filter(|&i| inner(i)).collect();
        (wavy, inner)
    }] {
        let at = |levels| {
            LoopSubdivSpec {
                levels,
                ..spec.clone()
            }
            .subdivide()
        };
        // Vertices keep their order but for that of their first use.
        let control = ControlMesh::new(&spec.triangles, &spec.positions);
        let number = |i: usize| {
            let found = control
                .positions
                .iter()
                .position(|&p| p == spec.positions[i]);
            found.unwrap()
        };
        let (coarse, fine) = (at(0), at(4));
        for i in fixed {
            let i = number(i);
            assert!((coarse.positions[i] - fine.positions[i]).length() < 1e-13);
            // Tangents are taken from neighbors at their limits, not from the mesh before: those of
            // a coarse mesh are rough.
            let cos = coarse.normals[i].dot(fine.normals[i]);
            assert!(cos > 0.95, "{cos}");
        }
    }
}

#[test]
fn normals_stand_on_the_surface_against_the_turning_sense() {
    for spec in [octahedron(), grid(4, |x, y| (3.0 * x * y).sin())] {
        let mesh = LoopSubdivSpec { levels: 5, ..spec }.subdivide();
        for t in &mesh.indices {
            let [a, b, c] = t.map(|i| mesh.positions[i as usize]);
            let flat = (b - a).cross(c - a).normalize();
            for i in t {
                // Triangles of 1/32 of the control mesh's turn by some hundredths between each
                // other; corners of the open grid by more, as pbrt-v3's rules there are rough.
                let n = mesh.normals[*i as usize].as_dvec3();
                assert!(flat.dot(n) < -0.9, "{flat} {n}");
            }
        }
    }
}

#[test]
fn planes_stay_planes_and_boundaries_lines() {
    let mesh = LoopSubdivSpec {
        levels: 3,
        ..grid(3, |x, y| 0.5 * x - y)
    }
    .subdivide();
    let n = DVec3::new(0.5, -1.0, -1.0).normalize();
    for (p, normal) in mesh.positions.iter().zip(&mesh.normals) {
        assert!(p.dot(n).abs() < 1e-15);
        assert!((normal.as_dvec3() - n).length() < 1e-6, "{normal}");
        assert!(p.x > -1e-15 && p.x < 1.0 + 1e-15);
    }
}

#[test]
fn limits_of_boundaries_are_pbrt_v3s() {
    // Two of the three corners of a lone triangle, after no level: 3/5 of it, 1/5 of its neighbors.
    let spec = LoopSubdivSpec {
        levels: 0,
        positions: vec![DVec3::ZERO, DVec3::X, DVec3::Y],
        triangles: vec![[0, 1, 2]],
    };
    let mesh = spec.subdivide();
    assert!((mesh.positions[0] - DVec3::new(0.2, 0.2, 0.0)).length() < 1e-15);
    assert!((mesh.normals[0] + Vec3::Z).length() < 1e-6);
}

#[test]
fn parameters_are_read_and_checked() {
    let reading = |params: &str| read("loopsubdiv", params, LoopSubdivSpec::from_params);
    let body = "\"integer indices\" [0 1 2] \"point P\" [0 0 0 1 0 0 0 1 0]";
    let levels = |params: &str| reading(&format!("{params} {body}")).value.unwrap().levels;
    assert_eq!(levels(""), 3);
    assert_eq!(
        levels("\"integer nlevels\" 2 \"string scheme\" \"loop\""),
        2
    );
    assert_eq!(levels("\"integer levels\" 1 \"integer nlevels\" 2"), 1);
    // 4¹² triangles are 2²⁴, the next level 2²⁶.
    let outcome = reading(&format!("\"integer nlevels\" 20 {body}"));
    assert_eq!((outcome.value, outcome.errors), (None, 1));
    assert!(
        outcome.messages[0].contains("12 is the most"),
        "{:?}",
        outcome.messages
    );
    let outcome = reading(&format!("\"integer nlevels\" -1 {body}"));
    assert_eq!((outcome.value.unwrap().levels, outcome.warnings), (0, 1));
    let outcome = reading("\"integer indices\" [0 1 3] \"point P\" [0 0 0 1 0 0 0 1 0]");
    assert!(outcome.value.is_none() && outcome.errors == 1);
    assert!(outcome.text.contains("vertex 3"));
    assert!(reading("\"integer indices\" [0 1 2]").value.is_none());
    assert!(reading("\"point P\" [0 0 0]").value.is_none());
}
