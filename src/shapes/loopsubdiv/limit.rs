//! Where vertices end up when subdivision never ends, and the normals there (Hoppe et al. 1994;
//! Pharr, Jakob and Humphreys 2016, §3.8.3).

use super::topology::{Topology, Vertex, beta};
use crate::math::{DVec3, Vec3};
use std::f64::consts::{PI, TAU};

/// Positions on the limit surface.
pub(super) fn limit_positions(topology: &Topology, positions: &[DVec3]) -> Vec<DVec3> {
    let limit = |(vertex, &p): (&Vertex, &DVec3)| {
        if vertex.boundary {
            return topology.boundary_mean(vertex, p, positions, 1.0 / 5.0);
        }
        let gamma = 1.0 / (f64::from(vertex.valence) + 3.0 / (8.0 * beta(vertex.valence)));
        topology.ring_mean(vertex, p, positions, gamma)
    };
    topology.vertices.iter().zip(positions).map(limit).collect()
}

/// Unit normals from the positions on the limit surface, on the side from which the triangles turn
/// clockwise, as the rings do.
pub(super) fn limit_normals(topology: &Topology, limit: &[DVec3]) -> Vec<Vec3> {
    // Most vertices have six neighbors.
    let six: [(f64, f64); 6] = std::array::from_fn(|i| (TAU * i as f64 / 6.0).sin_cos());
    let mut ring = Vec::new();
    let normal = |(vertex, &p): (&Vertex, &DVec3)| {
        ring.clear();
        topology.ring(vertex, |i| ring.push(limit[i as usize]));
        let (s, t) = if vertex.boundary {
            boundary_tangents(p, &ring)
        } else {
            let weight = |i: usize| match ring.len() {
                6 => six[i],
                n => (TAU * i as f64 / n as f64).sin_cos(),
            };
            let (mut s, mut t) = (DVec3::ZERO, DVec3::ZERO);
            for (i, &neighbor) in ring.iter().enumerate() {
                let (sin, cos) = weight(i);
                s += cos * (neighbor - p);
                t += sin * (neighbor - p);
            }
            (s, t)
        };
        // Unit length before it is rounded: products of small triangles' sides are tiny.
        s.cross(t).normalize_or_zero().as_vec3()
    };
    topology.vertices.iter().zip(limit).map(normal).collect()
}

/// Tangents along and across a boundary at `p` with the neighbors `ring` from end to end.
fn boundary_tangents(p: DVec3, ring: &[DVec3]) -> (DVec3, DVec3) {
    let (Some(&first), Some(&last)) = (ring.first(), ring.last()) else {
        return (DVec3::ZERO, DVec3::ZERO);
    };
    let across = match *ring {
        [a, b] => a + b - 2.0 * p,
        [_, b, _] => b - p,
        [a, b, c, d] => 2.0 * (b + c) - a - d - 2.0 * p,
        _ => {
            let theta = PI / (ring.len() - 1) as f64;
            let bend = 2.0 * theta.cos() - 2.0;
            let inner = ring.iter().enumerate().skip(1).take(ring.len() - 2);
            let sum: DVec3 = inner
                .map(|(i, &q)| bend * (i as f64 * theta).sin() * q)
                .sum();
            -(theta.sin() * (first + last) + sum)
        }
    };
    (last - first, across)
}
