//! What `fstop lens` tells about a lens: as text, and as JSON through serde.
//!
//! Lengths are millimeters. Every `z` is measured from the front vertex, positive toward the film.
//! What a lens does not have (the focal length of an afocal one, a pupil at infinity) is absent as text
//! and `null` in JSON.

use super::lens::Lens;
use super::paraxial::{FAR, Pupil};
use super::stops::{self, AxisPoint};
use serde::Serialize;
use std::fmt;

/// Everything first-order about a lens, ready to print.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct LensReport {
    /// From the scene to the film.
    pub surfaces: Vec<SurfaceReport>,
    /// From the front vertex to the last.
    pub length: f64,
    /// From the last vertex to the film.
    pub film_distance: f64,
    /// Effective focal length.
    pub effective_focal_length: Option<f64>,
    /// From the last vertex to the rear focal point.
    pub back_focal_distance: Option<f64>,
    /// z of the front focal point: negative in front of the lens.
    pub front_focal_distance: Option<f64>,
    /// z of the rear focal point.
    pub rear_focal_point: Option<f64>,
    /// z of the front principal plane.
    pub front_principal_plane: Option<f64>,
    /// z of the rear principal plane.
    pub rear_principal_plane: Option<f64>,
    /// Effective focal length over entrance pupil diameter.
    pub f_number: Option<f64>,
    /// The stop as the scene sees it.
    pub entrance_pupil: Option<Pupil>,
    /// The stop as the film sees it.
    pub exit_pupil: Option<Pupil>,
    /// Of all apertures' images behind the lens the one that looks smallest from the middle of the film: the exit pupil as
    /// the course's lecture finds it ([`stops`]). That of the stop, unless another rim is narrower.
    pub exit_pupil_by_imaging: Option<ImagedPupilReport>,
    /// `true` if the plane of focus is infinitely far.
    pub focused_at_infinity: bool,
    /// z of the plane of focus; `None` at infinity and where there is none.
    pub plane_of_focus: Option<f64>,
}

/// One row of the prescription.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SurfaceReport {
    /// Radius of curvature; `None` for a plane, a stop among them.
    pub radius: Option<f64>,
    /// To the next surface; 0 for the last.
    pub thickness: f64,
    /// Index of the space behind.
    pub index: f64,
    /// Its Abbe number.
    pub abbe: Option<f64>,
    /// Full clear diameter.
    pub aperture: f64,
    /// `true` if it is an aperture stop.
    pub stop: bool,
    /// Conic constant of an aspheric surface.
    pub conic: Option<f64>,
    /// Its coefficients of r², r⁴ … r¹⁶, r in mm.
    pub aspheric_terms: Option<[f64; 8]>,
    /// z of the vertex.
    pub z: f64,
}

/// A pupil found among the images of all apertures.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct ImagedPupilReport {
    /// The surface whose aperture it is, from 0 at the scene.
    pub surface: usize,
    /// z of the image's center; `None` at infinity.
    pub z: Option<f64>,
    /// The image's diameter; `None` at infinity.
    pub diameter: Option<f64>,
}

impl SurfaceReport {
    /// Radius of curvature, `plane` or `stop`; of a curved surface that is the stop, radius and `S`.
    pub fn radius_text(&self) -> String {
        match (self.stop, self.radius) {
            (true, None) => "stop".to_string(),
            (true, Some(r)) => format!("S {r:.4}"),
            (false, None) => "plane".to_string(),
            (false, Some(r)) => format!("{r:.4}"),
        }
    }

    /// Conic constant and aspheric coefficients, as a lens file has them; `None` for a sphere.
    pub fn shape(&self) -> Option<String> {
        let mut text = format!("k={}", self.conic?);
        for (i, a) in self.aspheric_terms.iter().flatten().enumerate() {
            if *a != 0.0 {
                text += &format!(" A{}={a:e}", 2 * i + 2);
            }
        }
        Some(text)
    }
}

impl LensReport {
    /// Of `lens`, as it is stopped down and focused.
    pub fn new(lens: &Lens) -> LensReport {
        let paraxial = lens.paraxial();
        let cardinals = paraxial.cardinals;
        let mut z = 0.0;
        let surfaces = lens.surfaces().iter().map(|s| {
            let at = z;
            z += s.thickness;
            SurfaceReport {
                radius: Some(s.radius).filter(|r| r.is_finite()),
                thickness: s.thickness,
                index: s.index,
                abbe: s.abbe,
                aperture: s.aperture,
                stop: s.is_stop,
                conic: s.asphere.map(|a| a.conic),
                aspheric_terms: s.asphere.map(|a| a.terms),
                z: at,
            }
        });
        LensReport {
            surfaces: surfaces.collect(),
            length: lens.length(),
            film_distance: lens.film_distance(),
            effective_focal_length: cardinals.map(|c| c.focal_length),
            back_focal_distance: cardinals.map(|c| c.back_focal_distance),
            front_focal_distance: cardinals.map(|c| c.front_focal_point),
            rear_focal_point: cardinals.map(|c| c.rear_focal_point),
            front_principal_plane: cardinals.map(|c| c.front_principal_plane),
            rear_principal_plane: cardinals.map(|c| c.rear_principal_plane),
            f_number: paraxial.f_number,
            entrance_pupil: paraxial.entrance_pupil,
            exit_pupil: paraxial.exit_pupil,
            exit_pupil_by_imaging: exit_pupil_by_imaging(lens),
            focused_at_infinity: lens.plane_of_focus() == Some(f64::NEG_INFINITY),
            plane_of_focus: lens.plane_of_focus().filter(|z| z.is_finite()),
        }
    }
}

fn exit_pupil_by_imaging(lens: &Lens) -> Option<ImagedPupilReport> {
    let image = stops::exit_pupil(lens.surfaces(), AxisPoint::At(lens.film_z()))?;
    let finite = image.z.abs() < FAR;
    Some(ImagedPupilReport {
        surface: image.surface,
        z: finite.then_some(image.z),
        diameter: finite.then_some(image.diameter),
    })
}

impl fmt::Display for ImagedPupilReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match (self.diameter, self.z) {
            (Some(diameter), Some(z)) => write!(f, "{diameter:.4} mm at {z:.4} mm")?,
            _ => write!(f, "at infinity")?,
        }
        write!(f, ", of surface {}", self.surface + 1)
    }
}

impl fmt::Display for LensReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(
            f,
            "surface      radius  thickness    index      V  aperture"
        )?;
        for (i, s) in self.surfaces.iter().enumerate() {
            let radius = s.radius_text();
            let abbe = s.abbe.map_or(String::new(), |v| format!("{v:.1}"));
            writeln!(
                f,
                "{:7} {radius:>11} {:10.4} {:8.5} {abbe:>6} {:9.4}",
                i + 1,
                s.thickness,
                s.index,
                s.aperture
            )?;
            if let Some(shape) = s.shape() {
                writeln!(f, "        {shape}")?;
            }
        }
        writeln!(f, "\nmm; z from the front vertex, positive toward the film")?;
        let diameter = |pupil: Option<Pupil>| pupil.map(|p| p.diameter);
        for (name, value) in [
            ("effective focal length", self.effective_focal_length),
            ("f-number", self.f_number),
            ("back focal distance", self.back_focal_distance),
            ("front focal point z", self.front_focal_distance),
            ("rear focal point z", self.rear_focal_point),
            ("front principal plane z", self.front_principal_plane),
            ("rear principal plane z", self.rear_principal_plane),
            ("entrance pupil z", self.entrance_pupil.map(|p| p.z)),
            ("entrance pupil diameter", diameter(self.entrance_pupil)),
            ("exit pupil z", self.exit_pupil.map(|p| p.z)),
            ("exit pupil diameter", diameter(self.exit_pupil)),
            ("length", Some(self.length)),
            ("film distance", Some(self.film_distance)),
        ] {
            line(f, name, value)?;
        }
        if self.focused_at_infinity {
            writeln!(f, "{:24}{:>12}", "plane of focus z", "infinity")?;
        } else if self.plane_of_focus.is_none() && self.effective_focal_length.is_some() {
            // The film is too close for any object, as where it is put for the best image of a far one.
            writeln!(f, "{:24}{:>12}", "plane of focus z", "beyond infinity")?;
        } else {
            line(f, "plane of focus z", self.plane_of_focus)?;
        }
        match &self.exit_pupil_by_imaging {
            Some(pupil) => writeln!(f, "exit pupil by imaging the stops (lecture): {pupil}"),
            None => Ok(()),
        }
    }
}

fn line(f: &mut fmt::Formatter<'_>, name: &str, value: Option<f64>) -> fmt::Result {
    match value {
        Some(v) => writeln!(f, "{name:24}{v:12.4}"),
        None => writeln!(f, "{name:24}{:>12}", "none"),
    }
}

/// A length as a message says it: six digits, without zeros at the end.
pub fn length_text(mm: f64) -> String {
    let magnitude = mm.abs().max(1.0).log10().floor() as usize;
    let text = format!("{mm:.*}", 5usize.saturating_sub(magnitude));
    // What small lengths have no decimals for is said as it is.
    if mm != 0.0 && mm.abs() < 1e-2 {
        return format!("{mm}");
    }
    match text.contains('.') {
        true => text.trim_end_matches('0').trim_end_matches('.').to_string(),
        false => text,
    }
}

/// A number with so many decimals, and no sign where they are all zeros.
pub fn decimals(value: f64, decimals: usize) -> String {
    let text = format!("{value:.decimals$}");
    match text.strip_prefix('-') {
        Some(zeros) if zeros.bytes().all(|b| matches!(b, b'0' | b'.')) => zeros.to_string(),
        _ => text,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::optics::Prescription;

    #[test]
    fn nothing_has_no_sign() {
        let numbers = [
            (-0.0004, "0.000"),
            (0.0, "0.000"),
            (-0.0006, "-0.001"),
            (-1.25, "-1.250"),
        ];
        for (value, expected) in numbers {
            assert_eq!(decimals(value, 3), expected);
        }
        assert_eq!(
            (decimals(-0.4, 0), decimals(f64::NEG_INFINITY, 2)),
            ("0".into(), "-inf".into())
        );
    }

    #[test]
    fn json_has_the_promised_keys() {
        let p = Prescription::parse("50 5 1.5 60 20\n-50 0 1 0 20\n0 2 0 0 5\n").unwrap();
        let report = LensReport::new(&Lens::new(&p, 60.0).unwrap());
        let json = serde_json::to_value(&report).unwrap();
        for key in [
            "effective_focal_length",
            "back_focal_distance",
            "front_focal_distance",
            "f_number",
        ] {
            assert!(json[key].as_f64().unwrap().is_finite(), "{key}");
        }
        assert_eq!(json["exit_pupil"]["diameter"], 5.0);
        assert_eq!(json["exit_pupil"]["z"], 5.0);
        // 5 mm behind a lens of f = 49: enlarged, and a little farther off.
        assert!(json["entrance_pupil"]["diameter"].as_f64().unwrap() > 5.0);
        let imaged = &json["exit_pupil_by_imaging"];
        assert_eq!((&imaged["surface"], &imaged["z"]), (&2.into(), &5.0.into()));
        assert_eq!(imaged["diameter"], 5.0);
        assert!(report.to_string().ends_with(
            "exit pupil by imaging the stops (lecture): 5.0000 mm at 5.0000 mm, of surface 3\n"
        ));
        assert_eq!(json["surfaces"][0]["abbe"], 60.0);
        assert_eq!(json["surfaces"][2]["stop"], true);
    }

    #[test]
    fn the_narrowest_image_is_the_lectures_exit_pupil_whatever_the_stop_row_says() {
        // The film sees the lens through a hole narrower than the stop; a stop at the front focal point has its image at
        // infinity.
        let report = |text: &str| {
            let p = Prescription::parse(text).unwrap();
            LensReport::new(&Lens::new(&p, 100.0).unwrap()).exit_pupil_by_imaging
        };
        let hole = report("stop 10 1 20\ninf 5 1.5 20\ninf 0 1 4\n").unwrap();
        assert_eq!((hole.surface, hole.z), (2, Some(15.0)));
        let far = report("0 100 0 5\n50 0 1.5 40\ninf 0 1 40\n").unwrap();
        assert_eq!((far.surface, far.z, far.diameter), (0, None, None));
        assert_eq!(far.to_string(), "at infinity, of surface 1");
    }

    #[test]
    fn a_lens_at_infinity_is_focused_there() {
        let p = Prescription::parse("50 5 1.5 20\n-50 0 1 20\n").unwrap();
        let text = |film| LensReport::new(&Lens::new(&p, film).unwrap()).to_string();
        let far = Lens::focused(&p, f64::INFINITY).unwrap();
        assert!(
            text(far).contains("plane of focus z            infinity"),
            "{}",
            text(far)
        );
        assert!(text(far - 1.0).contains("plane of focus z        beyond infinity"));
        // Newton: f² = 2586 mm² over 1 mm in front of the front focal point.
        assert!(
            text(far + 1.0).contains("plane of focus z          -2634"),
            "{}",
            text(far + 1.0)
        );
    }

    #[test]
    fn lengths_are_said_in_six_digits() {
        for (mm, text) in [
            (13.05 * 2.0 - 4e-15, "26.1"),
            (26.099999999999998, "26.1"),
            (40.0, "40"),
            (0.0, "0"),
            (-1.25, "-1.25"),
            (1234567.8, "1234568"),
            (12.345678, "12.3457"),
            (5e-6, "0.000005"),
        ] {
            assert_eq!(length_text(mm), text);
        }
    }

    #[test]
    fn an_afocal_lens_is_reported_without_numbers_it_has_not() {
        let p = Prescription::parse("inf 5 1.5 20\ninf 0 1 20\n").unwrap();
        let report = LensReport::new(&Lens::new(&p, 60.0).unwrap());
        assert!(
            report
                .to_string()
                .contains("effective focal length          none")
        );
        assert!(serde_json::to_value(&report).unwrap()["f_number"].is_null());
    }
}
