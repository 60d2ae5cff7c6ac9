//! The film behind the lens, and the angle of view it gives.

use super::chief::ChiefFinder;
use serde::Serialize;

/// A rectangular film.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Film {
    /// Long side, mm.
    pub width: f64,
    /// Short side, mm.
    pub height: f64,
}

impl Film {
    /// 36 mm × 24 mm.
    pub const FULL_FRAME: Film = Film {
        width: 36.0,
        height: 24.0,
    };

    /// Of proportions 3:2 and this diagonal, mm.
    pub fn of_diagonal(diagonal: f64) -> Film {
        let scale = diagonal / Film::FULL_FRAME.diagonal();
        Film {
            width: 36.0 * scale,
            height: 24.0 * scale,
        }
    }

    /// Its diagonal, mm.
    pub fn diagonal(&self) -> f64 {
        self.width.hypot(self.height)
    }

    /// Diameter of the blur that still passes for a point, mm: the diagonal over 1500, the usual
    /// convention (Zeiss, "Depth of field and bokeh", 2010).
    pub fn circle_of_confusion(&self) -> f64 {
        self.diagonal() / 1500.0
    }
}

/// Full angles of view in degrees, from real chief rays; `None` where the lens does not cover the film.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct FieldOfView {
    /// Along the long side.
    pub horizontal: Option<f64>,
    /// Along the short side.
    pub vertical: Option<f64>,
    /// From corner to corner.
    pub diagonal: Option<f64>,
}

impl FieldOfView {
    /// With the chief rays of a lens.
    pub fn new(chief: &ChiefFinder, film: Film) -> FieldOfView {
        let full = |height: f64| {
            let ray = chief.find(height).filter(|r| r.passes)?;
            Some(2.0 * ray.field_angle().to_degrees())
        };
        FieldOfView {
            horizontal: full(0.5 * film.width),
            vertical: full(0.5 * film.height),
            diagonal: full(0.5 * film.diagonal()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::optics::{Lens, Prescription};

    #[test]
    fn a_pinhole_sees_what_geometry_says() {
        let lens = Lens::new(&Prescription::parse("0 0 0 0.01\n").unwrap(), 18.0).unwrap();
        let view = FieldOfView::new(&ChiefFinder::new(&lens), Film::FULL_FRAME);
        // The long side of 36 mm, 18 mm behind the hole.
        assert!((view.horizontal.unwrap() - 90.0).abs() < 1e-9);
        assert!((view.vertical.unwrap() - 2.0 * (12.0f64 / 18.0).atan().to_degrees()).abs() < 1e-9);
    }

    #[test]
    fn a_film_is_known_by_its_diagonal() {
        let film = Film::of_diagonal(43.266615);
        assert!((film.width - 36.0).abs() < 1e-6 && (film.height - 24.0).abs() < 1e-6);
        assert!((film.circle_of_confusion() - 0.02884).abs() < 1e-5);
    }
}
