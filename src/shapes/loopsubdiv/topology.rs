//! Which triangle is beside which, and how that is when every triangle is cut into four.
//!
//! Half-edges (Mäntylä 1988): number 3 f + j leads from corner j of triangle f to corner j + 1, and
//! its twin is the same edge in the triangle beside it, the other way round. All steps are loops
//! over arrays: a finer mesh's twins follow from the coarser one's by arithmetic.

use crate::math::DVec3;

/// No twin: the edge is a boundary.
pub(super) const NONE: u32 = u32::MAX;

/// Valence of vertices that subdivision makes: inside, and on a boundary.
const REGULAR: [u32; 2] = [6, 4];

/// A vertex as subdivision sees it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Vertex {
    /// One of the half-edges that leave it.
    pub start: u32,
    /// Neighbors.
    pub valence: u32,
    /// Lies on a boundary.
    pub boundary: bool,
}

/// Triangles with their neighbors.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Topology {
    /// Corners.
    pub triangles: Vec<[u32; 3]>,
    /// The other side of each half-edge, or [`NONE`].
    pub twins: Vec<u32>,
    /// The vertices.
    pub vertices: Vec<Vertex>,
}

/// What a scene file gives, put in order.
pub(super) struct ControlMesh {
    pub topology: Topology,
    pub positions: Vec<DVec3>,
    /// What was wrong with it.
    pub warnings: Vec<String>,
}

impl ControlMesh {
    /// Every corner must be a position.
    pub(super) fn new(triangles: &[[u32; 3]], positions: &[DVec3]) -> ControlMesh {
        let mut warnings = Vec::new();
        let proper = |t: &&[u32; 3]| t[0] != t[1] && t[1] != t[2] && t[2] != t[0];
        let mut kept: Vec<[u32; 3]> = triangles.iter().filter(proper).copied().collect();
        if kept.len() < triangles.len() {
            let left_out = triangles.len() - kept.len();
            warnings.push(format!(
                "{left_out} of {} triangles have a corner twice and are left out",
                triangles.len()
            ));
        }
        // Vertices of no triangle have no place on the surface.
        let mut numbers = vec![NONE; positions.len()];
        let mut used = Vec::new();
        for corner in kept.iter_mut().flatten() {
            let number = &mut numbers[*corner as usize];
            if *number == NONE {
                *number = used.len() as u32;
                used.push(positions[*corner as usize]);
            }
            *corner = *number;
        }
        let (twins, unmatched) = pair(&kept);
        if unmatched > 0 {
            warnings.push(format!(
                "the mesh is no manifold: {unmatched} edges belong to more than two triangles, or \
                 to two that turn the same way; the surface is open there"
            ));
        }
        let mut topology = Topology {
            triangles: kept,
            twins,
            vertices: Vec::new(),
        };
        topology.vertices = topology.found_vertices(used.len());
        ControlMesh {
            topology,
            positions: used,
            warnings,
        }
    }
}

/// Twins of all half-edges, and how many half-edges lack one although other triangles have their
/// edge.
fn pair(triangles: &[[u32; 3]]) -> (Vec<u32>, usize) {
    let ends = |h: u32| {
        let (t, j) = (&triangles[h as usize / 3], h as usize % 3);
        (t[j], t[(j + 1) % 3])
    };
    let edge = |h: u32| {
        let (a, b) = ends(h);
        (a.min(b), a.max(b))
    };
    let mut order: Vec<u32> = (0..3 * triangles.len() as u32).collect();
    order.sort_unstable_by_key(|&h| (edge(h), h));
    let mut twins = vec![NONE; order.len()];
    let mut unmatched = 0;
    for group in order.chunk_by(|&a, &b| edge(a) == edge(b)) {
        // The first half-edge one way with the first one the other way, and so on.
        let (forward, backward): (Vec<u32>, Vec<u32>) =
            group.iter().partition(|&&h| ends(h).0 < ends(h).1);
        for (&a, &b) in forward.iter().zip(&backward) {
            twins[a as usize] = b;
            twins[b as usize] = a;
        }
        if group.len() > 1 {
            unmatched += forward.len().abs_diff(backward.len());
        }
    }
    (twins, unmatched)
}

/// The next half-edge of the same triangle.
pub(super) fn next(h: u32) -> u32 {
    if h % 3 == 2 { h - 2 } else { h + 1 }
}

/// The one before.
pub(super) fn previous(h: u32) -> u32 {
    if h.is_multiple_of(3) { h + 2 } else { h - 1 }
}

impl Topology {
    /// The vertex that half-edge `h` leaves.
    pub(super) fn origin(&self, h: u32) -> u32 {
        self.triangles[h as usize / 3][h as usize % 3]
    }

    /// The vertex it leads to.
    pub(super) fn target(&self, h: u32) -> u32 {
        self.origin(next(h))
    }

    fn twin(&self, h: u32) -> Option<u32> {
        let twin = self.twins[h as usize];
        (twin != NONE).then_some(twin)
    }

    /// The half-edge that leaves the same vertex on the far side of the triangle beside `h`. As
    /// twins turn opposite ways, no two half-edges have the same one: whoever walks on ends at a
    /// boundary or comes back.
    fn turn_forward(&self, h: u32) -> Option<u32> {
        self.twin(h).map(next)
    }

    /// The other way round.
    fn turn_backward(&self, h: u32) -> Option<u32> {
        self.twin(previous(h))
    }

    /// The neighbors of a vertex in turn; those of a boundary vertex from one end of the boundary
    /// to the other.
    pub(super) fn ring(&self, vertex: &Vertex, mut visit: impl FnMut(u32)) {
        if !vertex.boundary {
            let mut h = vertex.start;
            loop {
                visit(self.target(h));
                match self.turn_forward(h) {
                    Some(next) if next != vertex.start => h = next,
                    _ => return,
                }
            }
        }
        let mut h = self.last_forward(vertex.start);
        visit(self.target(h));
        loop {
            visit(self.origin(previous(h)));
            match self.turn_backward(h) {
                Some(next) => h = next,
                None => return,
            }
        }
    }

    /// The last half-edge before a boundary, or the one before `start` itself.
    fn last_forward(&self, start: u32) -> u32 {
        let mut h = start;
        while let Some(next) = self.turn_forward(h) {
            if next == start {
                break;
            }
            h = next;
        }
        h
    }

    /// So many vertices, from triangles and twins.
    fn found_vertices(&self, count: usize) -> Vec<Vertex> {
        let mut starts = vec![NONE; count];
        // As in pbrt-v3 the last triangle of a vertex counts, where there are several fans.
        for h in 0..self.twins.len() as u32 {
            starts[self.origin(h) as usize] = h;
        }
        let vertex = |start: u32| {
            let mut vertex = Vertex {
                start,
                valence: 0,
                boundary: self.turn_forward(self.last_forward(start)).is_none(),
            };
            let mut valence = 0;
            self.ring(&vertex, |_| valence += 1);
            vertex.valence = valence;
            vertex
        };
        starts.into_iter().map(vertex).collect()
    }

    /// Every triangle cut into four: triangle f becomes 4 f + j at its corners j and 4 f + 3 in the
    /// middle. Vertices stay, with their numbers, and each edge adds one.
    pub(super) fn refine(&self) -> Topology {
        let mut finer = Topology {
            triangles: vec![[0; 3]; 4 * self.triangles.len()],
            twins: vec![NONE; 4 * self.twins.len()],
            vertices: Vec::with_capacity(self.vertices.len() + self.twins.len() * 2 / 3),
        };
        let corner_child = |h: u32| 3 * (4 * (h / 3) + h % 3);
        // The half-edge from the corner, at the start of the coarse half-edge `h`.
        let first_half = |h: u32| corner_child(h) + h % 3;
        // The one to the next corner, at its end.
        let second_half = |h: u32| corner_child(next(h)) + h % 3;
        finer
            .vertices
            .extend(self.vertices.iter().map(|vertex| Vertex {
                start: first_half(vertex.start),
                ..*vertex
            }));
        let mut middles = vec![NONE; self.twins.len()];
        for h in 0..self.twins.len() as u32 {
            let twin = self.twin(h);
            middles[h as usize] = match twin.map(|t| middles[t as usize]) {
                Some(known) if known != NONE => known,
                _ => {
                    finer.vertices.push(Vertex {
                        start: 3 * (4 * (h / 3) + 3) + h % 3,
                        valence: REGULAR[usize::from(twin.is_none())],
                        boundary: twin.is_none(),
                    });
                    finer.vertices.len() as u32 - 1
                }
            };
            if let Some(twin) = twin {
                finer.twins[first_half(h) as usize] = second_half(twin);
                finer.twins[second_half(h) as usize] = first_half(twin);
            }
        }
        for (f, corners) in self.triangles.iter().enumerate() {
            let middle = |j: usize| middles[3 * f + j];
            for j in 0..3 {
                let (after, before) = ((j + 1) % 3, (j + 2) % 3);
                let child = &mut finer.triangles[4 * f + j];
                child[j] = corners[j];
                child[after] = middle(j);
                child[before] = middle(before);
                finer.triangles[4 * f + 3][j] = middle(j);
                // Across the middle triangle's sides.
                let (outer, inner) = (3 * (4 * f + j) + after, 3 * (4 * f + 3) + before);
                finer.twins[outer] = inner as u32;
                finer.twins[inner] = outer as u32;
            }
        }
        finer
    }

    /// Positions of `finer`'s vertices, which [`Topology::refine`] made from this.
    pub(super) fn refined_positions(&self, finer: &Topology, positions: &[DVec3]) -> Vec<DVec3> {
        let mut refined = Vec::with_capacity(finer.vertices.len());
        for (vertex, &p) in self.vertices.iter().zip(positions) {
            refined.push(if vertex.boundary {
                self.boundary_mean(vertex, p, positions, 1.0 / 8.0)
            } else {
                self.ring_mean(vertex, p, positions, beta(vertex.valence))
            });
        }
        let at = |vertex: u32| positions[vertex as usize];
        for vertex in &finer.vertices[self.vertices.len()..] {
            // The middle triangle's half-edge j starts in the middle of the coarse one's edge j.
            let h = 3 * (vertex.start / 12) + vertex.start % 3;
            let ends = at(self.origin(h)) + at(self.target(h));
            let across = |h: u32| at(self.origin(previous(h)));
            refined.push(match self.twin(h) {
                None => 0.5 * ends,
                Some(twin) => 3.0 / 8.0 * ends + 1.0 / 8.0 * (across(h) + across(twin)),
            });
        }
        refined
    }

    /// Each neighbor with `weight`, and what is left of 1 for `p` itself.
    pub(super) fn ring_mean(
        &self,
        vertex: &Vertex,
        p: DVec3,
        positions: &[DVec3],
        weight: f64,
    ) -> DVec3 {
        let mut sum = DVec3::ZERO;
        self.ring(vertex, |i| sum += positions[i as usize]);
        (1.0 - f64::from(vertex.valence) * weight) * p + weight * sum
    }

    /// The two neighbors along the boundary with `weight` each, and what is left of 1 for `p`.
    pub(super) fn boundary_mean(
        &self,
        vertex: &Vertex,
        p: DVec3,
        positions: &[DVec3],
        weight: f64,
    ) -> DVec3 {
        let (mut first, mut last) = (None, p);
        self.ring(vertex, |i| {
            last = positions[i as usize];
            first.get_or_insert(last);
        });
        (1.0 - 2.0 * weight) * p + weight * (first.unwrap_or(p) + last)
    }
}

/// Warren's weight of a neighbor, as pbrt-v3 has it (Pharr, Jakob and Humphreys 2016, §3.8.2).
pub(super) fn beta(valence: u32) -> f64 {
    match valence {
        3 => 3.0 / 16.0,
        n => 3.0 / (8.0 * f64::from(n)),
    }
}
