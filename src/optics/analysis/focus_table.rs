//! The focusing scale of a lens: film distances, magnifications, depth of field.

use super::film::Film;
use crate::optics::depth_of_field::depth_of_field;
use crate::optics::focus;
use crate::optics::lens::Lens;
use serde::Serialize;

/// The lens focused at one distance by moving it as a whole.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct FocusRow {
    /// From the film to the plane of focus, mm; infinite (`null` in JSON) for the last row.
    pub distance: f64,
    /// From the last vertex to the film, mm.
    pub film_distance: f64,
    /// How much farther that is than for infinity, mm.
    pub extension: f64,
    /// Image size over object size, as a positive number; 0 at infinity.
    pub magnification: f64,
    /// From the film to the nearest plane that is still sharp, mm; `None` without an exit pupil.
    pub near: Option<f64>,
    /// To the farthest; infinite (`null` in JSON) beyond the hyperfocal distance.
    pub far: Option<f64>,
}

/// Distances from the film, meters: those engraved on lenses.
const DISTANCES: [f64; 10] = [0.3, 0.5, 0.7, 1.0, 1.5, 2.0, 3.0, 5.0, 10.0, f64::INFINITY];

/// One row per distance the lens can be focused at; none for a lens that makes no image.
pub fn rows(lens: &Lens, film: Film) -> Vec<FocusRow> {
    DISTANCES
        .iter()
        .filter_map(|meters| row(lens, film, meters * 1e3))
        .collect()
}

/// Focused `distance` mm from the film; `None` where that cannot be.
pub fn row(lens: &Lens, film: Film, distance: f64) -> Option<FocusRow> {
    let cardinals = lens.paraxial().cardinals?;
    let film_distance = focus::film_distance_for_focus(Some(cardinals), distance).ok()?;
    let extension = film_distance - cardinals.back_focal_distance;
    let depth = depth_of_field(lens, film_distance, film.circle_of_confusion());
    Some(FocusRow {
        distance,
        film_distance,
        extension,
        magnification: extension / (cardinals.index_behind * cardinals.focal_length),
        near: depth.map(|depth| depth.near).filter(|&near| near > 0.0),
        far: depth.map(|depth| depth.far),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::optics::Prescription;

    #[test]
    fn depth_of_field_is_that_of_the_thin_lens() {
        // f = 50, stop at the lens, N = 2: hyperfocal distance H = f²/(N c) + f; near and far ends of the distance s
        // from the lens are s(H−f)/(H+s−2f) and s(H−f)/(H−s) (Ray, chapter 22).
        let p = Prescription::parse("0 0 0 25\n50 0 2 25.1\ninf 0 1 30\n").unwrap();
        let lens = Lens::new(&p, 60.0).unwrap();
        let (f, n, c) = (50.0, 2.0, Film::FULL_FRAME.circle_of_confusion());
        let row = row(&lens, Film::FULL_FRAME, 2000.0).unwrap();
        let v = row.film_distance;
        let s = 2000.0 - v;
        let h = f * f / (n * c) + f;
        assert!((row.near.unwrap() - v - s * (h - f) / (h + s - 2.0 * f)).abs() < 1e-6);
        assert!((row.far.unwrap() - v - s * (h - f) / (h - s)).abs() < 1e-6);
        assert!((row.magnification - v / s).abs() < 1e-12);
    }

    #[test]
    fn a_diverging_lens_has_no_focus_table() {
        let p = Prescription::parse("-50 3 1.5 20\n50 0 1 20\n").unwrap();
        assert!(rows(&Lens::new(&p, 60.0).unwrap(), Film::FULL_FRAME).is_empty());
    }
}
