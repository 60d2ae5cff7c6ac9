//! Where in its image a light is bright: cells of the image, chosen by what shines through them.

use super::light_map::LightMap;
use crate::math::color::luminance;
use crate::math::stepped::SteppedDensities;
use crate::math::{Rgb, Vec2};

/// Least and most cells along a side: few enough texels are divided, many are gathered.
const SIDES: [usize; 2] = [64, 1024];

/// Probabilities of the cells of an image.
#[derive(Clone, Debug)]
pub(super) struct MapDensity {
    /// One density: of the rows.
    rows: SteppedDensities,
    /// One for each row.
    columns: SteppedDensities,
}

/// A cell, chosen.
pub(super) struct Cell {
    /// Column and row.
    pub(super) index: [usize; 2],
    /// The position inside, in [0, 1)².
    pub(super) inside: Vec2,
    /// Its probability.
    pub(super) probability: f32,
}

impl Cell {
    /// The position (u, v) in the image of `density`.
    pub(super) fn position(&self, density: &MapDensity) -> Vec2 {
        let [column, row] = self.index.map(|i| i as f32);
        let [columns, rows] = density.cells().map(|n| n as f32);
        (Vec2::new(column, row) + self.inside) / Vec2::new(columns, rows)
    }

    /// Its corners (u, v) in the image of `density`.
    pub(super) fn corners(&self, density: &MapDensity) -> [[f64; 2]; 2] {
        let cells = density.cells();
        [0, 1].map(|i| [0, 1].map(|k| (self.index[k] + i) as f64 / cells[k] as f64))
    }
}

impl MapDensity {
    /// By the mean luminance of the image in each cell times `measure` of the cell's corners (u, v), which gives its solid
    /// angle. No cell that has light is left out.
    pub(super) fn new(map: &LightMap, measure: impl Fn([f64; 2], [f64; 2]) -> f64) -> MapDensity {
        let luminances = luminances(map);
        // Powers of two, as the image's sides are.
        let [columns, rows] =
            [map.width, map.height].map(|texels| (2 * texels).clamp(SIDES[0], SIDES[1]));
        let mut density = MapDensity {
            rows: SteppedDensities::new(1),
            columns: SteppedDensities::new(columns),
        };
        let mut sums = Vec::with_capacity(rows);
        for y in 0..rows {
            let values: Vec<f64> = (0..columns)
                .map(|x| {
                    let corner =
                        |x: usize, y: usize| [x as f64 / columns as f64, y as f64 / rows as f64];
                    let (low, high) = (corner(x, y), corner(x + 1, y + 1));
                    mean(&luminances, low, high) * measure(low, high)
                })
                .collect();
            sums.push(values.iter().sum());
            density.columns.push(&values);
        }
        density.rows = SteppedDensities::new(rows);
        density.rows.push(&sums);
        density
    }

    /// Columns and rows.
    pub(super) fn cells(&self) -> [usize; 2] {
        [self.columns.cells(), self.rows.cells()]
    }

    /// A cell by `u` in [0, 1)².
    pub(super) fn sample(&self, u: Vec2) -> Cell {
        let (row, y, row_probability) = self.rows.locate(0, u.y);
        let (column, x, probability) = self.columns.locate(row, u.x);
        Cell {
            index: [column, row],
            inside: Vec2::new(x, y),
            probability: row_probability * probability,
        }
    }

    /// Density per area of the image of (u, v) in [0, 1]², where [`MapDensity::sample`] is even inside its cell.
    pub(super) fn at(&self, uv: Vec2) -> f32 {
        let [columns, rows] = self.cells();
        self.cell_at(uv).probability * (columns * rows) as f32
    }

    /// The cell of (u, v) in [0, 1]², and its probability.
    pub(super) fn cell_at(&self, uv: Vec2) -> Cell {
        let cells = self.cells();
        let index = [0, 1].map(|k| ((uv[k] * cells[k] as f32) as usize).min(cells[k] - 1));
        let [column, row] = index;
        let probability = self.rows.probability(0, row) * self.columns.probability(row, column);
        Cell {
            index,
            inside: Vec2::splat(0.5),
            probability,
        }
    }
}

/// The luminances of the texels' magnitudes: a negative channel, which a damaged image may have, must not hide a positive one.
fn luminances(map: &LightMap) -> LightMap {
    let texels = map.texels.iter().map(|t| Rgb::splat(luminance(t.abs())));
    LightMap {
        texels: texels.collect(),
        ..*map
    }
}

/// Mean over a cell. Inside each half of a texel the interpolation is bilinear, and its mean is its value at the middle.
fn mean(luminances: &LightMap, low: [f64; 2], high: [f64; 2]) -> f64 {
    let size = [high[0] - low[0], high[1] - low[1]];
    let texels = [luminances.width, luminances.height];
    let [across, down] =
        [0, 1].map(|k| ((2.0 * size[k] * texels[k] as f64).round() as usize).max(1));
    let mut sum = 0.0;
    for y in 0..down {
        for x in 0..across {
            let u = low[0] + size[0] * (x as f64 + 0.5) / across as f64;
            let v = low[1] + size[1] * (y as f64 + 0.5) / down as f64;
            sum += f64::from(luminances.lookup(Vec2::new(u as f32, v as f32)).x);
        }
    }
    sum / (across * down) as f64
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::hash::{mix2, unit_float};

    /// Mostly black.
    fn sparse(width: usize, height: usize) -> LightMap {
        let texel = |i: u64| match mix2(i, 3) % 16 {
            0 => Rgb::new(unit_float(mix2(i, 4)), 0.0, 1e-3),
            1 if i.is_multiple_of(5) => Rgb::new(-2.0, 2.0, 0.0),
            _ => Rgb::ZERO,
        };
        let texels = (0..(width * height) as u64).map(texel);
        LightMap::new(width, height, texels.collect()).unwrap()
    }

    /// Any measure that is not the same everywhere.
    fn measure(low: [f64; 2], high: [f64; 2]) -> f64 {
        (high[0] * high[0] - low[0] * low[0] + 1.0) * (high[1] - low[1])
    }

    #[test]
    fn cells_with_light_have_a_density_that_sums_to_one() {
        // The last has cells of four halves of texels.
        for (width, height) in [(1, 1), (5, 3), (32, 128), (1024, 2)] {
            let map = sparse(width, height);
            let density = MapDensity::new(&map, measure);
            let n = 1 << 18;
            let mut sum = 0.0;
            for i in 0..n {
                let u = [1, 2].map(|k| unit_float(mix2(i, k)));
                let uv = Vec2::from_array(u);
                let at = density.at(uv);
                assert!(
                    at > 0.0 || map.lookup(uv) == Rgb::ZERO,
                    "{width} {height} {uv}"
                );
            }
            let [columns, rows] = density.cells();
            for i in 0..columns * rows {
                let cell = Vec2::new((i % columns) as f32 + 0.5, (i / columns) as f32 + 0.5);
                let at = density.at(cell / Vec2::new(columns as f32, rows as f32));
                sum += f64::from(at) / (columns * rows) as f64;
            }
            // Products of two single-precision numbers.
            assert!((sum - 1.0).abs() < 1e-5, "{width} {height}: {sum}");
        }
    }

    #[test]
    fn samples_lie_in_their_cell() {
        let density = MapDensity::new(&sparse(64, 16), measure);
        let mut agree = 0;
        for i in 0..10_000 {
            let [x, y] = [1, 2].map(|k| unit_float(mix2(i, k)));
            let cell = density.sample(Vec2::new(x, y));
            let [low, high] = cell.corners(&density);
            let at = cell.position(&density);
            for k in 0..2 {
                // A rounding up to the border.
                assert!(f64::from(at[k]) >= low[k] && f64::from(at[k]) <= high[k]);
            }
            let found = density.cell_at(at);
            agree += i32::from(found.index == cell.index && found.probability == cell.probability);
        }
        assert!(agree > 9_990, "{agree}");
    }

    /// Half the light in one of 32 × 16 texels.
    #[test]
    fn bright_cells_are_chosen_more_often() {
        let mut texels = vec![Rgb::ONE; 512];
        texels[5 * 32 + 9] = Rgb::splat(511.0);
        let map = LightMap::new(32, 16, texels).unwrap();
        let even = |low: [f64; 2], high: [f64; 2]| (high[0] - low[0]) * (high[1] - low[1]);
        let density = MapDensity::new(&map, even);
        // The interpolation has its light within a texel of the center.
        let near = |at: Vec2| (at.x * 32.0 - 9.5).abs() < 1.0 && (at.y * 16.0 - 5.5).abs() < 1.0;
        let n = 256;
        let count = (0..n * n).filter(|i| {
            let u = (Vec2::new((i % n) as f32, (i / n) as f32) + 0.5) / n as f32;
            near(density.sample(u).position(&density))
        });
        // Twice the two texels' width and height is a 128th of the rest; steps of 16 bits and the grid are below 1 %.
        let share = count.count() as f64 / f64::from(n * n);
        assert!((share - (0.5 + 0.5 / 128.0)).abs() < 0.01, "{share}");
    }
}
