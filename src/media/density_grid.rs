//! A density sampled on a grid over the unit cube, interpolated, with upper bounds (majorants).

use super::majorants::Majorants;
use crate::math::float::floors;
use crate::math::transform::Transform;
use crate::math::{DVec3, UVec3, Vec3};
use crate::params::ParamReader;
use wide::f32x4;

/// A box this many mean free paths across is as dense as single precision can resolve; denser voxels are thinned to it.
/// It also bounds the number of steps of a ray.
const MAX_FREE_PATHS: f64 = 1e5;

/// A density over the unit cube, trilinear between the centers of its voxels and 0 beyond them.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct DensityGrid {
    resolution: UVec3,
    /// x varies fastest, then y, then z; finite and at least 0.
    values: Vec<f32>,
    majorants: Majorants,
}

impl DensityGrid {
    /// Reads `density`. `None`, after reporting an error, if the densities are missing or their number is not that of
    /// the voxels.
    pub(super) fn from_params(
        reader: &ParamReader,
        resolution: UVec3,
        sigma_t: f32,
        world_from_grid: &Transform,
    ) -> Option<DensityGrid> {
        let values = densities(reader, sigma_t, world_from_grid)?;
        let count = values.len();
        let grid = DensityGrid::new(resolution, values);
        if grid.is_none() {
            let [x, y, z] = resolution.to_array();
            reader.error(
                "density",
                format!("`density` has {count} values, but `nx` × `ny` × `nz` is {x} × {y} × {z}"),
            );
        }
        grid
    }

    /// `None` if the number of values is not the product of the resolution, or is 0.
    pub(super) fn new(resolution: UVec3, values: Vec<f32>) -> Option<DensityGrid> {
        let [x, y, z] = resolution.to_array().map(|n| n as usize);
        let count = x.checked_mul(y)?.checked_mul(z)?;
        if count == 0 || values.len() != count {
            return None;
        }
        let majorants = Majorants::new(resolution, &values);
        Some(DensityGrid {
            resolution,
            values,
            majorants,
        })
    }

    /// Upper bounds of the density along a ray.
    pub(super) fn majorants(&self) -> &Majorants {
        &self.majorants
    }

    /// The largest value.
    pub(super) fn largest(&self) -> f32 {
        self.values.iter().fold(0.0, |a, &b| a.max(b))
    }

    /// Like [`DensityGrid::density`], but constant beyond the centers of the outermost voxels, as in pbrt-v2.
    pub(super) fn extended_density(&self, p: Vec3) -> f32 {
        let half = 0.5 / self.resolution.as_vec3();
        self.density(p.clamp(half, Vec3::ONE - half))
    }

    /// The density at a point of the unit cube.
    pub(super) fn density(&self, p: Vec3) -> f32 {
        // Voxel centers have integer coordinates.
        let q = p * self.resolution.as_vec3() - Vec3::splat(0.5);
        let q = f32x4::new([q.x, q.y, q.z, 0.0]);
        let low = floors(q);
        let [fx, fy, fz, _] = (q - f32x4::from_i32x4(low)).to_array();
        let [x, y, z, _] = low.to_array();
        let [a, b] = self.around([x, y, z]).map(f32x4::new);
        let [a, b, c, d] = (a + (b - a) * f32x4::splat(fx)).to_array();
        let (a, b) = (a + (b - a) * fy, c + (d - c) * fy);
        a + (b - a) * fz
    }

    /// The values of eight neighbors: four with this x and four with the next, y running first.
    #[inline(always)]
    fn around(&self, low: [i32; 3]) -> [[f32; 4]; 2] {
        let [nx, ny, nz] = self.resolution.to_array();
        let [x, y, z] = low.map(|v| v as u32);
        // Negative coordinates wrap to huge ones.
        if x < nx - 1 && y < ny - 1 && z < nz - 1 {
            let (row, plane) = (nx as usize, nx as usize * ny as usize);
            let first = z as usize * plane + y as usize * row + x as usize;
            let value = |i| self.values.get(first + i).copied().unwrap_or(0.0);
            return [0, 1].map(|i| [i, i + row, i + plane, i + plane + row].map(value));
        }
        let value = |i: u32, [j, k]: [u32; 2]| {
            self.voxel(x.wrapping_add(i), y.wrapping_add(j), z.wrapping_add(k))
        };
        [0, 1].map(|i| [[0, 0], [1, 0], [0, 1], [1, 1]].map(|jk| value(i, jk)))
    }

    /// The value of a voxel; 0 outside the grid.
    fn voxel(&self, x: u32, y: u32, z: u32) -> f32 {
        let n = self.resolution;
        if x >= n.x || y >= n.y || z >= n.z {
            return 0.0;
        }
        let i = (z as usize * n.y as usize + y as usize) * n.x as usize + x as usize;
        self.values.get(i).copied().unwrap_or(0.0)
    }
}

/// `nx`, `ny` and `nz`.
pub(super) fn resolution(reader: &ParamReader) -> UVec3 {
    let along = |name| reader.integer_within(name, 1, 1..=i64::from(i32::MAX)) as u32;
    UVec3::new(along("nx"), along("ny"), along("nz"))
}

/// The values of `density`, made finite, non-negative and no denser than can be resolved.
fn densities(reader: &ParamReader, sigma_t: f32, world_from_grid: &Transform) -> Option<Vec<f32>> {
    let Some(given) = reader.floats("density") else {
        reader.error(
            "density",
            format!("`{}` needs `float density` values", reader.kind()),
        );
        return None;
    };
    let across = [DVec3::X, DVec3::Y, DVec3::Z]
        .map(|axis| world_from_grid.vector(axis).length())
        .iter()
        .sum::<f64>();
    let largest = MAX_FREE_PATHS / (f64::from(sigma_t) * across);
    let largest = if largest > 0.0 {
        largest
    } else {
        f64::INFINITY
    };
    let largest = largest.min(f64::from(f32::MAX));
    let (mut wrong, mut dense) = (None, None);
    let used = |(i, &value): (usize, &f64)| {
        if value > largest && value.is_finite() {
            dense = dense.or(Some(i));
            largest as f32
        } else if value.is_finite() && value >= 0.0 {
            value as f32
        } else {
            wrong = wrong.or(Some(i));
            0.0
        }
    };
    let values = given.iter().enumerate().map(used).collect();
    if let Some(i) = wrong {
        let value = given.get(i).copied().unwrap_or_default();
        let message = format!("a density is {value}: 0 is used where it is negative or not finite");
        reader.warn_item("density", i, message);
    }
    if let Some(i) = dense {
        let message = format!(
            "densities above {largest:e} are taken as that: a ray would get through 1/100,000 of the box"
        );
        reader.warn_item("density", i, message);
    }
    Some(values)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::hash::{mix2, unit_float};

    #[test]
    fn interpolates_between_voxel_centers_and_ends_outside() {
        let grid =
            DensityGrid::new(UVec3::new(2, 1, 3), vec![1.0, 2.0, 3.0, 4.0, 5.0, 6.0]).unwrap();
        let at = |x, y, z| grid.density(Vec3::new(x, y, z));
        assert_eq!(at(0.25, 0.5, 0.5 / 3.0), 1.0);
        assert_eq!(at(0.75, 0.5, 0.5), 4.0);
        assert!((at(0.5, 0.5, 0.5) - 3.5).abs() < 1e-6);
        // Half a voxel beyond the last center: half of the density, as in pbrt-v3.
        assert!((at(1.0, 0.5, 0.5) - 2.0).abs() < 1e-6);
        assert!((at(0.25, 0.0, 0.5) - 1.5).abs() < 1e-6);
        assert_eq!(at(5.0, 0.5, 0.5), 0.0);
    }

    #[test]
    fn what_is_linear_in_each_coordinate_is_kept_between_centers() {
        let n = UVec3::new(5, 4, 3);
        let density = |p: Vec3| (1.0 + p.x) * (2.0 - 0.3 * p.y) * (1.0 + 0.5 * p.z);
        let centers = (0..n.element_product()).map(|i| {
            let (x, y, z) = (i % n.x, i / n.x % n.y, i / (n.x * n.y));
            density(UVec3::new(x, y, z).as_vec3())
        });
        let grid = DensityGrid::new(n, centers.collect()).unwrap();
        for i in 0..2000 {
            let r = |k: u64| unit_float(mix2(i, k));
            let at = Vec3::new(r(1), r(2), r(3)) * (n - UVec3::ONE).as_vec3();
            let found = grid.density((at + 0.5) / n.as_vec3());
            // Eight roundings of numbers up to 20.
            assert!((found - density(at)).abs() < 2e-5, "{at}: {found}");
        }
    }

    #[test]
    fn a_wrong_number_of_values_makes_no_grid() {
        assert!(DensityGrid::new(UVec3::new(2, 2, 2), vec![0.0; 7]).is_none());
        assert!(DensityGrid::new(UVec3::new(0, 2, 2), vec![]).is_none());
        assert!(DensityGrid::new(UVec3::splat(u32::MAX), vec![]).is_none());
    }
}
