//! Point spread functions over field, depth and color: what image simulation convolves with.
//!
//! By geometric optics: the rays of one object point, evenly over its beam, where they meet the film. A point is known by the film
//! height at which its chief ray of the d line lands, and by its depth.

use super::beam::Beam;
use super::chief::ChiefFinder;
use super::film::Film;
use super::object::ObjectPlane;
use crate::optics::dispersion::{AbbeModel, LINE_C, LINE_D, LINE_F};
use crate::optics::lens::Lens;
use crate::optics::prescription::Prescription;
use crate::optics::pupil::{ExitPupil, RINGS};
use crate::optics::trace::LensRay;

/// Wavelengths, µm: red, yellow, blue.
pub const COLORS: [f64; 3] = [LINE_C, LINE_D, LINE_F];
/// Film heights, in parts of half the film's diagonal.
pub const FIELDS: [f64; 5] = super::SPOT_FIELDS;

/// The lens for each of [`COLORS`], on one film.
#[derive(Clone, Debug)]
pub struct ColorLenses {
    lenses: [Lens; 3],
    pupil: ExitPupil,
    corner: f64,
}

/// One ray of an object point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PointRay {
    /// In front of the lens, toward it.
    pub ray: LensRay<f64>,
    /// Where it meets the film, mm: x, and y away from the axis; not relative to the chief ray.
    pub film: [f64; 2],
}

impl ColorLenses {
    /// Of `prescription` with its film `film_distance` mm behind it; all colors alike where its file says nothing of dispersion. `None` where that
    /// makes no lens.
    pub fn new(prescription: &Prescription, film_distance: f64, film: Film) -> Option<ColorLenses> {
        let of = |wavelength: f64| {
            // The file's own index is that of the d line.
            let lens = match wavelength == LINE_D {
                true => prescription.clone(),
                false => prescription.at_wavelength(wavelength, AbbeModel::NormalLine),
            };
            Lens::new(&lens, film_distance).ok()
        };
        let [red, yellow, blue] = COLORS.map(of);
        let lenses = [red?, yellow?, blue?];
        let corner = 0.5 * film.diagonal();
        // The corner itself must lie within the last ring.
        let pupil = ExitPupil::new(&lenses[1], corner * (1.0 + 1e-6), RINGS);
        Some(ColorLenses {
            lenses,
            pupil,
            corner,
        })
    }

    /// One for each color.
    pub fn lenses(&self) -> &[Lens; 3] {
        &self.lenses
    }

    /// The rays of the point of `object` imaged at `field` (a part of half the diagonal), for each color, on a grid of `across`² over its beam; none where
    /// no light gets there.
    pub fn rays(&self, field: f64, object: ObjectPlane, across: usize) -> [Vec<PointRay>; 3] {
        let main = &self.lenses[1];
        let chief = ChiefFinder::new(main).find(field * self.corner);
        let beam = chief.and_then(|chief| Beam::new(main, &self.pupil, &chief, object));
        let Some(beam) = beam else {
            return [const { Vec::new() }; 3];
        };
        let through = |lens: &Lens| {
            let grid = beam.grid(lens, across).into_iter();
            let ray = |(p, film)| PointRay {
                ray: beam.ray(p),
                film,
            };
            grid.map(ray).collect()
        };
        [0, 1, 2].map(|i| through(&self.lenses[i]))
    }
}

/// Point spread functions as an image of tiles: fields from left to right, depths from top to bottom.
#[derive(Clone, Debug, PartialEq)]
pub struct PsfGrid {
    /// Pixels of a tile's side.
    pub tile: usize,
    /// Size of a pixel on the film, mm.
    pub pitch: f64,
    /// Pixels across and down.
    pub size: [usize; 2],
    /// Light in each pixel for each of [`COLORS`], row by row from the top: the sum over a tile is 1, or 0 where no light gets there. Up is away from
    /// the axis.
    pub light: [Vec<f32>; 3],
}

impl PsfGrid {
    /// Of some depths. Pixels are so large that the widest of all just fits.
    pub fn new(lenses: &ColorLenses, depths: &[ObjectPlane], tile: usize) -> PsfGrid {
        /// Rays across a beam: some 30 for a pixel of a blur that fills a tile.
        const ACROSS: usize = 256;
        let mut points = Vec::new();
        for depth in depths {
            for field in FIELDS {
                let height = field * lenses.corner;
                let around = |rays: Vec<PointRay>| -> Vec<[f64; 2]> {
                    rays.iter()
                        .map(|r| [r.film[0], r.film[1] - height])
                        .collect()
                };
                points.push(lenses.rays(field, *depth, ACROSS).map(around));
            }
        }
        let all = points.iter().flatten().flatten().flatten();
        let widest = all.fold(0.0, |most: f64, x| most.max(x.abs()));
        // A perfect point has some size, too.
        let pitch = 2.0 * widest.max(1e-6) * (1.0 + 1e-9) / tile as f64;
        let size = [tile * FIELDS.len(), tile * depths.len()];
        let mut light = [0, 1, 2].map(|_| vec![0.0f32; size[0] * size[1]]);
        for (i, colors) in points.iter().enumerate() {
            let corner = [tile * (i % FIELDS.len()), tile * (i / FIELDS.len())];
            for (pixels, spot) in light.iter_mut().zip(colors) {
                let part = 1.0 / spot.len().max(1) as f32;
                for [x, y] in spot {
                    let at = |x: f64| (x / pitch + 0.5 * tile as f64) as usize;
                    let [column, row] = [at(*x), at(-*y)].map(|k| k.min(tile - 1));
                    pixels[(corner[1] + row) * size[0] + corner[0] + column] += part;
                }
            }
        }
        PsfGrid {
            tile,
            pitch,
            size,
            light,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A thin lens of f = 100 mm at f/20 whose glass disperses, focused on infinity.
    fn lenses() -> ColorLenses {
        let p =
            Prescription::parse("0 0 0 0 5\n100 1e-6 1.5168 64.17 30\n-100 0 1 0 30\n").unwrap();
        let distance = Lens::focused(&p, f64::INFINITY).unwrap();
        ColorLenses::new(&p, distance, Film::of_diagonal(10.0)).unwrap()
    }

    #[test]
    fn tiles_hold_all_the_light_and_grow_with_defocus() {
        let lenses = lenses();
        let near = ObjectPlane { z: Some(-1000.0) };
        let grid = PsfGrid::new(&lenses, &[ObjectPlane::INFINITY, near], 32);
        assert_eq!(grid.size, [160, 64]);
        for pixels in &grid.light {
            for i in 0..10 {
                let (column, row) = (32 * (i % 5), 32 * (i / 5));
                let rows = (row..row + 32).flat_map(|r| &pixels[r * 160 + column..][..32]);
                let sum: f32 = rows.sum();
                // Some 50,000 additions of single precision.
                assert!((sum - 1.0).abs() < 1e-3, "{i}: {sum}");
            }
        }
        // At a meter the image lies f²/900 mm behind the film: a disk of 5 f/1000 = 0.5 mm across, less the 3 % that the lens' f is short of 100 mm.
        let across = 32.0 * grid.pitch;
        assert!((across - 0.484).abs() < 0.03, "{across}");
    }

    #[test]
    fn colors_land_apart_where_the_glass_disperses() {
        let lenses = lenses();
        let blur = |rays: &[PointRay]| {
            rays.iter()
                .map(|r| r.film[0].hypot(r.film[1]))
                .fold(0.0, f64::max)
        };
        let [red, yellow, blue] = lenses.rays(0.0, ObjectPlane::INFINITY, 64);
        // Focal lengths differ by 1/V of theirs, 1.5 mm in all: radii of some 0.01 and 0.03 mm at f/20.
        assert!(blur(&red) > 2.0 * blur(&yellow) && blur(&blue) > 2.0 * blur(&yellow));
        // Toward the lens.
        assert!(yellow.iter().all(|r| r.ray.d[2] > 0.99));
    }
}
