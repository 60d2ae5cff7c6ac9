//! How the view changes with focus: the breathing of a lens, zoom by zoom.

use super::f_number::t_number;
use super::lens::Lens;
use super::prescription::Prescription;
use serde::Serialize;

/// A lens at one zoom and focus.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct BreathingRow {
    /// What the zoom is set to; `None` of a lens that does not zoom.
    pub zoom: Option<f64>,
    /// From the film to the plane of focus, mm; infinite (`null` in JSON) for the first row.
    pub distance: f64,
    /// From the last vertex to the film, mm.
    pub film_distance: f64,
    /// Focal length, mm.
    pub focal_length: f64,
    /// From the film to the pinhole with the same view near the axis, mm; see [`Lens::pinhole_focal_length`].
    pub pinhole_focal_length: Option<f64>,
    /// Focal length over the diameter of the entrance pupil.
    pub f_number: Option<f64>,
    /// See [`t_number`]; of this zoom, its groups as at this focus.
    pub t_number: Option<f64>,
    /// How much narrower the view is than that at infinity: the part by which the pinhole is farther from the film.
    pub breathing: Option<f64>,
}

/// Distances from the film, meters.
const DISTANCES: [f64; 10] = [f64::INFINITY, 10.0, 5.0, 3.0, 2.0, 1.5, 1.0, 0.7, 0.5, 0.3];

/// One row for each zoom of the file and each distance that the lens can be focused at.
pub fn rows(prescription: &Prescription) -> Vec<BreathingRow> {
    let zooms = prescription
        .positions
        .as_ref()
        .map_or(&[][..], |p| p.zooms());
    let zooms: Vec<Option<f64>> = match zooms {
        [] => vec![None],
        zooms => zooms.iter().copied().map(Some).collect(),
    };
    zooms
        .into_iter()
        .flat_map(|zoom| of_zoom(prescription, zoom))
        .collect()
}

fn of_zoom(prescription: &Prescription, zoom: Option<f64>) -> Vec<BreathingRow> {
    let mut at_infinity = None;
    let mut rows = Vec::new();
    for distance in DISTANCES.map(|meters| 1e3 * meters) {
        let Some(mut row) = row(prescription, zoom, distance) else {
            continue;
        };
        if distance == f64::INFINITY {
            at_infinity = row.pinhole_focal_length;
        }
        let relative = |f: f64| Some(f / at_infinity? - 1.0);
        row.breathing = row.pinhole_focal_length.and_then(relative);
        rows.push(row);
    }
    rows
}

fn row(prescription: &Prescription, zoom: Option<f64>, distance: f64) -> Option<BreathingRow> {
    let prescription = prescription.at_position(zoom, distance).ok()?;
    let lens = Lens::new(&prescription, Lens::focused(&prescription, distance).ok()?).ok()?;
    Some(BreathingRow {
        zoom,
        distance,
        film_distance: lens.film_distance(),
        focal_length: lens.paraxial().cardinals?.focal_length,
        pinhole_focal_length: lens.pinhole_focal_length(),
        f_number: lens.paraxial().f_number,
        t_number: t_number(&prescription, 1.0),
        breathing: None,
    })
}

/// The rows as lines of text.
pub fn text(rows: &[BreathingRow]) -> String {
    let cell = |value: Option<f64>, decimals: usize| {
        value.map_or("-".to_string(), |v| format!("{v:.decimals$}"))
    };
    let mut text = "    zoom  focus (m)  film (mm)  focal length  view of pinhole      f/      T  breathing (%)\n".to_string();
    for r in rows {
        text += &format!(
            "{:>8}  {:>9.2}  {:>9.3}  {:>12.3}  {:>15}  {:>6}  {:>5}  {:>13}\n",
            cell(r.zoom, 1),
            1e-3 * r.distance,
            r.film_distance,
            r.focal_length,
            cell(r.pinhole_focal_length, 3),
            cell(r.f_number, 2),
            cell(r.t_number, 2),
            cell(r.breathing.map(|b| 100.0 * b), 2),
        );
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A thin lens with the stop at it is a pinhole where it stands: focused nearer it is farther from the film.
    #[test]
    fn a_lens_that_moves_as_a_whole_breathes_by_its_extension() {
        let p = Prescription::parse("0 0 0 10\n50 0 2 25.1\ninf 0 1 30\n").unwrap();
        let rows = rows(&p);
        assert_eq!(rows.len(), DISTANCES.len());
        for r in &rows {
            let v = r.film_distance;
            assert!((r.pinhole_focal_length.unwrap() - v).abs() < 1e-9);
            assert!((r.breathing.unwrap() - (v / 50.0 - 1.0)).abs() < 1e-10);
            assert!((r.focal_length - 50.0).abs() < 1e-9);
        }
        assert!(rows[9].breathing.unwrap() > 0.2);
        assert!(text(&rows).lines().count() == 11);
    }

    /// Two thin lenses of 100 and -80 mm: the table is the textbooks' formula at each zoom, and a focus group moves.
    #[test]
    fn a_zoom_has_its_rows_by_zoom() {
        let p = Prescription::parse(
            "zoom 150 250\ngap D 40 55\n0 0 0 10\n100 0 2 30\ninf D 1 30\n-80 0 2 30\ninf 0 1 30\n",
        )
        .unwrap();
        let rows = rows(&p);
        for (zoom, d) in [(150.0, 40.0), (250.0, 55.0)] {
            // 1/f = 1/f1 + 1/f2 - d/(f1 f2).
            let f = 1.0 / (1.0 / 100.0 - 1.0 / 80.0 + d / 8000.0);
            let of_zoom: Vec<_> = rows.iter().filter(|r| r.zoom == Some(zoom)).collect();
            assert!(of_zoom.len() > 3);
            for r in of_zoom {
                assert!((r.focal_length / f - 1.0).abs() < 1e-12, "{r:?}");
            }
        }
    }
}
