//! Majorants: coarse upper bounds of a density, so that a ray can skip empty or thin regions (Szirmay-Kalos, Tóth and
//! Magdics 2011; Pharr, Jakob and Humphreys 2023, §11.4.4).

use crate::math::{UVec3, Vec3};

/// Maximum number of cells along an axis. Traversing them costs about as much as reading a few voxels.
const MAX_CELLS: u32 = 16;

/// The unit cube divided into cells, each with its maximum density.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Majorants {
    resolution: UVec3,
    /// x varies fastest.
    values: Box<[f32]>,
}

impl Majorants {
    /// Bounds for the interpolated density of the [`super::density_grid::DensityGrid`] with these voxels.
    pub(super) fn new(voxels: UVec3, values: &[f32]) -> Majorants {
        let resolution = voxels.min(UVec3::splat(MAX_CELLS));
        let [x, y, z] = [0, 1, 2].map(|axis| {
            let n = voxels[axis];
            let cells = 0..resolution[axis];
            cells
                .map(move |cell| influence(cell, resolution[axis], n))
                .collect::<Vec<_>>()
        });
        let index = |x: u32, y: u32, z: u32| {
            (z as usize * voxels.y as usize + y as usize) * voxels.x as usize + x as usize
        };
        let mut largest = Vec::with_capacity(x.len() * y.len() * z.len());
        for zs in &z {
            for ys in &y {
                for xs in &x {
                    let rows = zs.clone().flat_map(|z| ys.clone().map(move |y| (y, z)));
                    let all = rows.filter_map(|(y, z)| {
                        values.get(index(xs.start, y, z)..index(xs.end, y, z))
                    });
                    largest.push(all.flatten().fold(0.0f32, |a, &b| a.max(b)));
                }
            }
        }
        Majorants {
            resolution,
            values: largest.into(),
        }
    }

    /// The cells along the ray from `o` in direction `d` up to `t_max`, in order; `o` is in the unit cube.
    pub(super) fn along(&self, o: Vec3, d: Vec3, t_max: f32) -> Cells<'_> {
        let n = self.resolution.as_vec3();
        let (o, d) = (o * n, d * n);
        let cell = o.floor().clamp(Vec3::ZERO, n - Vec3::ONE);
        let far = cell + Vec3::select(d.cmpgt(Vec3::ZERO), Vec3::ONE, Vec3::ZERO);
        let moves = d.cmpne(Vec3::ZERO);
        Cells {
            majorants: self,
            cell: cell.as_ivec3().to_array(),
            next: Vec3::select(moves, (far - o) / d, Vec3::INFINITY).to_array(),
            delta: Vec3::select(moves, d.abs().recip(), Vec3::INFINITY).to_array(),
            step: d.signum().as_ivec3().to_array(),
            t: 0.0,
            t_max,
        }
    }
}

/// The voxels of `n` that affect cell `cell` of `cells`: those inside and, because of interpolation, one more on either
/// side.
fn influence(cell: u32, cells: u32, n: u32) -> std::ops::Range<u32> {
    let edge = |i: u32| u64::from(i) * u64::from(n);
    let cells = u64::from(cells);
    let first = (edge(cell) / cells).saturating_sub(1);
    let last = edge(cell + 1).div_ceil(cells) + 1;
    first as u32..last.min(u64::from(n)) as u32
}

/// A segment of a ray on which the density is bounded.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Piece {
    /// Start distance.
    pub start: f32,
    /// End distance.
    pub end: f32,
    /// Upper bound of the density.
    pub majorant: f32,
}

/// The cells along a ray, by grid traversal (Amanatides and Woo 1987).
#[derive(Clone, Debug)]
pub(super) struct Cells<'a> {
    majorants: &'a Majorants,
    cell: [i32; 3],
    /// The distance at which the ray leaves the cell, by axis.
    next: [f32; 3],
    /// The distance between cell boundaries, by axis.
    delta: [f32; 3],
    step: [i32; 3],
    t: f32,
    t_max: f32,
}

impl Iterator for Cells<'_> {
    type Item = Piece;

    fn next(&mut self) -> Option<Piece> {
        // Also ends if a distance is NaN.
        let more = self.t < self.t_max;
        if !more {
            return None;
        }
        let n = self.majorants.resolution.as_ivec3().to_array();
        let inside = (0..3).all(|i| (0..n[i]).contains(&self.cell[i]));
        if !inside {
            return None;
        }
        let [x, y, z] = self.cell;
        let majorant = self.majorants.values[((z * n[1] + y) * n[0] + x) as usize];
        let [a, b, c] = self.next;
        let axis = if a < b && a < c {
            0
        } else if b < c {
            1
        } else {
            2
        };
        let piece = Piece {
            start: self.t,
            end: self.next[axis].clamp(self.t, self.t_max),
            majorant,
        };
        self.t = piece.end;
        self.cell[axis] += self.step[axis];
        self.next[axis] += self.delta[axis];
        Some(piece)
    }
}

#[cfg(test)]
mod tests {
    use super::super::density_grid::DensityGrid;
    use super::*;
    use proptest::prelude::*;

    fn grid(n: UVec3) -> DensityGrid {
        let count = n.element_product();
        let values = (0..count).map(|i| if i % 7 == 0 { (i % 13) as f32 } else { 0.0 });
        DensityGrid::new(n, values.collect()).unwrap()
    }

    proptest! {
        /// Segments follow each other without gaps, and the density stays below their bounds.
        #[test]
        fn pieces_cover_the_ray_and_bound_the_density(
            n in prop::array::uniform3(1u32..40),
            o in prop::array::uniform3(0.0f32..=1.0),
            d in prop::array::uniform3(prop_oneof![4 => -1.0f32..1.0, 1 => Just(0.0f32)]),
        ) {
            let (o, d) = (Vec3::from_array(o), Vec3::from_array(d));
            prop_assume!(d.length() > 1e-3);
            let grid = grid(UVec3::from_array(n));
            // To the far side of the cube.
            let t_max = (0..3)
                .map(|i| if d[i] > 0.0 { (1.0 - o[i]) / d[i] } else if d[i] < 0.0 { -o[i] / d[i] } else { f32::INFINITY })
                .fold(f32::INFINITY, f32::min);
            let pieces: Vec<Piece> = grid.majorants().along(o, d, t_max).collect();
            let mut t = 0.0;
            for piece in &pieces {
                prop_assert_eq!(piece.start, t);
                t = piece.end;
                for i in 0..=4 {
                    let at = piece.start + (piece.end - piece.start) * i as f32 / 4.0;
                    let density = grid.density(o + d * at);
                    // Interpolation rounds.
                    prop_assert!(density <= piece.majorant * 1.00001 + 1e-5, "{} > {}", density, piece.majorant);
                }
            }
            // Rounding may end the traversal slightly early, at the cube's boundary.
            prop_assert!(t >= t_max * 0.999_99 - 1e-5, "{} of {}", t, t_max);
            prop_assert!(pieces.len() <= 3 * MAX_CELLS as usize);
        }
    }

    #[test]
    fn odd_rays_end() {
        let grid = grid(UVec3::new(3, 20, 1));
        for (o, d) in [
            (Vec3::ZERO, Vec3::ZERO),
            (Vec3::NAN, Vec3::X),
            (Vec3::splat(0.5), Vec3::NAN),
            (Vec3::splat(9.0), Vec3::X),
            (Vec3::ONE, Vec3::new(1e-38, 1.0, -1e38)),
        ] {
            assert!(
                grid.majorants()
                    .along(o, d, f32::INFINITY)
                    .take(1000)
                    .count()
                    < 100
            );
        }
    }
}
