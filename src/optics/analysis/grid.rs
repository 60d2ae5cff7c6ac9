//! The distortion grid: where the crossings of a square grid, as a lens without distortion images them, lie on the film.

use super::film::Film;
use super::maps::LensMaps;
use super::object::ObjectPlane;
use crate::optics::lens::Lens;
use serde::Serialize;

/// One crossing, (x, y) mm from the middle of the film.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct GridPoint {
    /// Without distortion.
    pub ideal: [f64; 2],
    /// By real chief rays; `None` where none gets there.
    pub real: Option<[f64; 2]>,
}

/// A grid over the film.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct DistortionGrid {
    /// Crossings in a row, and rows.
    pub size: [usize; 2],
    /// Row by row.
    pub points: Vec<GridPoint>,
}

impl DistortionGrid {
    /// Of a lens before `film`; `None` where it has no chief rays near its axis.
    pub fn new(lens: &Lens, film: Film, object: ObjectPlane) -> Option<DistortionGrid> {
        const SIZE: [usize; 2] = [13, 9];
        // For a drawing; between them a cubic.
        const NODES: usize = 64;
        let map = LensMaps::with_nodes(lens, film, object, NODES)?.to_lens;
        let at = |length: f64, i: usize, n: usize| length * (i as f64 / (n - 1) as f64 - 0.5);
        let point = |k: usize| {
            let ideal = [
                at(film.width, k % SIZE[0], SIZE[0]),
                at(film.height, k / SIZE[0], SIZE[1]),
            ];
            let factor = map.at(ideal[0].hypot(ideal[1]));
            let real = factor.map(|factor| ideal.map(|x| factor * x));
            GridPoint { ideal, real }
        };
        Some(DistortionGrid {
            size: SIZE,
            points: (0..SIZE[0] * SIZE[1]).map(point).collect(),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::optics::Prescription;

    #[test]
    fn a_hole_bends_no_line() {
        let hole = Lens::new(&Prescription::parse("0 0 0 0.1\n").unwrap(), 30.0).unwrap();
        let grid = DistortionGrid::new(&hole, Film::FULL_FRAME, ObjectPlane::INFINITY).unwrap();
        assert_eq!(grid.points.len(), 13 * 9);
        for p in &grid.points {
            let real = p.real.unwrap();
            // Interpolation between chief rays found to rounding.
            assert!((0..2).all(|i| (p.ideal[i] - real[i]).abs() < 1e-9), "{p:?}");
        }
    }
}
