//! All rings as one table of numbers, looked up by film point: for a number alone, or for a bundle side by
//! side without a branch between them.

use super::mapping::Spot;
use super::ring::Ring;
use crate::optics::real::{Index, Plain};

/// Numbers of a ring before its corners: inner and outer radius, one over their difference, and the
/// middle's x at the inner radius and its change to the outer.
const HEADER: usize = 5;

/// Numbers of a corner: (x, y) at the inner radius, and their change to the outer.
const CORNER: usize = 4;

/// Parts into which the reach may be divided to find rings.
const MAX_PARTS: usize = 1024;

/// The polygons of all rings, in precision `B`.
#[derive(Clone, Debug)]
pub(super) struct PupilTable<B> {
    /// Equal parts of the reach in a millimeter.
    parts_per_mm: B,
    /// For each part the first ring that may serve it.
    first: Vec<B>,
    /// How many rings beyond the first may serve a part at most.
    steps: usize,
    /// Outer radius of each ring.
    outer: Vec<B>,
    /// For each ring [`HEADER`] numbers and [`CORNER`] for each corner.
    rows: Vec<B>,
    stride: usize,
    /// Triangles in half a turn.
    triangles: usize,
}

/// Points of the exit pupil's plane.
#[derive(Clone, Copy, Debug)]
pub(in crate::optics) struct Spread<T: Index> {
    /// (x, y), mm.
    pub point: [T; 2],
    /// The area that each represents, mm².
    pub area: T,
    /// Which film points any light reaches; elsewhere the other numbers mean nothing.
    pub lit: T::Mask,
}

impl<B: Plain> PupilTable<B> {
    /// Of `rings`, by film radius, all with as many corners, for film radii up to `reach` mm.
    pub(super) fn new(rings: &[Ring], reach: f64) -> PupilTable<B> {
        let corners = rings.first().map_or(2, |ring| ring.corners.len());
        let mut parts = 4 * rings.len() + 1;
        let first_rings = |parts: usize| -> Vec<usize> {
            let first = |i: usize| {
                // A little early, so that a radius whose part is rounded up still finds its ring.
                let radius = reach * i as f64 / parts as f64 * (1.0 - 1e-6);
                rings.partition_point(|r| r.radii[1] < radius)
            };
            (0..=parts).map(first).collect()
        };
        let most = |first: &[usize]| {
            let steps = first.windows(2).map(|pair| pair[1] - pair[0]);
            steps.max().unwrap_or(0)
        };
        let mut first = first_rings(parts);
        // Where light ends lie two boundaries, however narrow the parts.
        while most(&first) > 2 && 2 * parts <= MAX_PARTS {
            parts *= 2;
            first = first_rings(parts);
        }
        let mut rows = Vec::with_capacity(rings.len() * (HEADER + CORNER * corners));
        for ring in rings {
            let (center, [inner, outer]) = (ring.center, ring.radii);
            let change = center.to - center.from;
            rows.extend([inner, outer, 1.0 / (outer - inner), center.from, change]);
            rows.extend(ring.corners.iter().flat_map(|c| {
                let [x, y] = c.from;
                [x, y, c.to[0] - x, c.to[1] - y]
            }));
        }
        let mut outer: Vec<f64> = rings.iter().map(|r| r.radii[1]).collect();
        if rings.is_empty() {
            // A ring that serves no film radius: what is beyond the table's end would be read as 0.
            outer.push(-1.0);
            rows.extend([1.0, -1.0]);
            rows.resize(HEADER + CORNER * corners, 0.0);
        }
        let rounded = |values: Vec<f64>| values.into_iter().map(B::round_from).collect();
        PupilTable {
            parts_per_mm: B::round_from(parts as f64 / reach),
            steps: most(&first),
            first: rounded(first.iter().map(|i| *i as f64).collect()),
            outer: rounded(outer),
            rows: rounded(rows),
            stride: HEADER + CORNER * corners,
            triangles: corners - 1,
        }
    }

    /// The `spot` of the region of the film point (x, y) mm, at `radius` mm from the axis.
    #[inline(always)]
    pub(super) fn point<T: Index<Base = B>>(
        &self,
        film: &[T; 2],
        radius: T,
        spot: &Spot<T>,
    ) -> Spread<T> {
        let (zero, one) = (T::constant(B::ZERO), T::constant(B::ONE));
        let ring = self.ring(radius);
        let [inner, outer, per_width, center, drift] = T::row(&self.rows, [(ring, self.stride)], 0);
        let within = (radius - inner).at_least(B::ZERO);
        let lit = within & (outer - radius).at_least(B::ZERO);
        let t = (radius - inner) * per_width;
        let t = T::select(t.greater(B::ZERO), t, zero);
        let t = T::select(t.at_most(B::ONE), t, one);
        // The triangle between two corners, and where on its outer side.
        let (triangle, s) = spot
            .half
            .times(B::round_from(self.triangles as f64))
            .place(self.triangles - 1);
        let at = [(ring, self.stride), (triangle, CORNER)];
        let [ax, ay, adx, ady, bx, by, bdx, bdy] = T::row(&self.rows, at, HEADER);
        let (ax, ay) = (ax + t * adx, ay + t * ady);
        let (bx, by) = (bx + t * bdx, by + t * bdy);
        let x = center + t * drift + spot.radius * (ax + s * (bx - ax));
        let y = spot.side * spot.radius * (ay + s * (by - ay));
        // Each triangle of either half is met as often as any other.
        let area = (ax * by - ay * bx).times(B::round_from(self.triangles as f64));
        // Where the film is in the bowl of the last surface, regions become slivers without any.
        let lit = lit & area.greater(B::ZERO);
        // Along and across the film point's azimuth; on the axis any will do.
        let on_axis = radius.at_most(B::ZERO);
        let scale = one / T::select(on_axis, one, radius);
        let cos = T::select(on_axis, one, film[0] * scale);
        let sin = film[1] * scale;
        Spread {
            point: [cos * x - sin * y, sin * x + cos * y],
            area,
            lit,
        }
    }

    /// The ring of a film radius within reach, if any is.
    #[inline(always)]
    fn ring<T: Index<Base = B>>(&self, radius: T) -> T::Place {
        let (part, _) = radius
            .times(self.parts_per_mm)
            .place(self.first.len().saturating_sub(2));
        let last = self.outer.len().saturating_sub(1);
        let [mut ring] = T::row(&self.first, [(part, 1)], 0);
        for _ in 0..self.steps {
            let (at, _) = ring.place(last);
            let [outer] = T::row(&self.outer, [(at, 1)], 0);
            let beyond = (radius - outer).greater(B::ZERO);
            ring = T::select(beyond, ring.plus(B::ONE), ring);
        }
        ring.place(last).0
    }
}
