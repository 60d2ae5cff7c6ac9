//! Focusing by moving the whole lens before the film.
//!
//! Gaussian optics of a thick lens (Born and Wolf §4.4; pbrt 3rd edition §6.4.3 solves the same
//! equation): with f the focal length in front, n' the index behind the lens, s from the object to the
//! front and s' from the rear principal plane to the film, 1/s + n'/s' = 1/f.

use super::paraxial::Cardinals;
use super::report::length_text;

/// Why a lens cannot be focused.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum FocusError {
    /// The object is too near for a sharp image at any position of the lens.
    #[error(
        "cannot focus at {asked:.2} mm: the least distance from the film to the plane of focus is {minimum:.2} mm for this lens"
    )]
    TooNear {
        /// The distance asked for, mm.
        asked: f64,
        /// The least one possible, mm.
        minimum: f64,
    },
    /// The lens makes no real image.
    #[error("cannot focus: the lens has {}, so it makes no image on a film", match .focal_length { Some(f) => format!("a focal length of {} mm", length_text(*f)), None => "no focal length".to_string() })]
    NoImage {
        /// Focal length in mm, `None` for an afocal lens.
        focal_length: Option<f64>,
    },
    /// The image lies inside or in front of the lens.
    #[error(
        "cannot focus at {} mm: the image would lie {} mm in front of the last lens surface",
        length_text(*.asked),
        length_text(*.inside)
    )]
    InsideLens {
        /// The distance asked for, mm.
        asked: f64,
        /// How far inside, mm.
        inside: f64,
    },
    /// A tilted film for which no distance was found.
    #[error("cannot focus at {} mm: with a film tilted like this no distance was found at which that point is sharp", length_text(*.asked))]
    Unsettled {
        /// The distance asked for, mm.
        asked: f64,
    },
}

/// Distance from the last vertex to the film, mm, that brings the plane `distance` mm from the
/// *film* into focus. Of the two solutions the one with the lens nearer the film is taken.
pub fn film_distance_for_focus(
    cardinals: Option<Cardinals>,
    distance: f64,
) -> Result<f64, FocusError> {
    let c = imaging(cardinals)?;
    let f = c.focal_length;
    // The part of the distance outside the gap between the principal planes: s + s'.
    let gap = c.rear_principal_plane - c.front_principal_plane;
    let outside = distance - gap;
    // With D = s + s': s² − (D + f − n'f) s + D f = 0, of which the larger root has the lens nearer the film.
    let sum = outside - f * (c.index_behind - 1.0);
    let discriminant = sum * sum - 4.0 * f * outside;
    // Negative `outside` solves the equation too, with a virtual object. Catches NaN.
    if !(discriminant >= 0.0 && sum > 0.0) && outside != f64::INFINITY {
        return Err(FocusError::TooNear {
            asked: distance,
            minimum: minimum_focus_distance(cardinals)?,
        });
    }
    let extension = if outside.is_finite() {
        let object = 0.5 * (sum + discriminant.sqrt());
        // Newton's form, where nothing cancels: the object is at least f (1 + √n') away.
        c.index_behind * f * (f / (object - f))
    } else {
        0.0
    };
    checked(c.back_focal_distance + extension, distance)
}

/// As [`film_distance_for_focus`], with the plane of focus `distance` mm in front of the *first
/// vertex*.
pub fn film_distance_for_object(
    cardinals: Option<Cardinals>,
    distance: f64,
) -> Result<f64, FocusError> {
    let c = imaging(cardinals)?;
    // From the object to the front focal point; Newton's form x x' = n' f².
    let x = distance + c.front_focal_point;
    if x.is_nan() || x <= 0.0 {
        return Err(FocusError::TooNear {
            asked: distance,
            minimum: -c.front_focal_point,
        });
    }
    checked(
        c.back_focal_distance + c.index_behind * c.focal_length * (c.focal_length / x),
        distance,
    )
}

/// Where the plane of focus lies for a film `film_distance` mm behind the last vertex: its z in lens
/// coordinates, −∞ where the film is at the focal point; `None` where no real object in front of
/// the lens is sharp.
pub fn plane_of_focus(cardinals: &Cardinals, film_distance: f64) -> Option<f64> {
    let behind = film_distance - cardinals.back_focal_distance;
    let power = cardinals.index_behind * cardinals.focal_length * cardinals.focal_length;
    let z = cardinals.front_focal_point - power / behind;
    // A film nearer than the focal point asks for an object behind the lens. Rounding of the
    // focal point itself must not count as nearer.
    if behind.abs() <= 1e-12 * cardinals.focal_length.abs() {
        return Some(f64::NEG_INFINITY);
    }
    (behind > 0.0).then_some(z)
}

/// The plane that is sharp on a film that is tilted: the points of lens coordinates with n·p = d.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SharpPlane {
    /// n, of any length.
    pub normal: [f64; 3],
    /// d.
    pub distance: f64,
}

impl SharpPlane {
    /// z where it meets the axis; `None` where it does not.
    pub fn on_axis(&self) -> Option<f64> {
        Some(self.distance / self.normal[2]).filter(|z| z.is_finite())
    }
}

/// Of a film z = z₀ + αx + βy whose point on the axis, z₀, lies `film_distance` mm behind the last vertex; `slopes` are α and β.
///
/// With x the distance of an object in front of the front focal point and x′ that of its image behind the rear one, Newton's x x′ = n′f² and the
/// magnification −f/x take the film's plane to x (x′₀) = n′f² + f (αX + βY): film, object and the principal planes meet in one
/// line (Scheimpflug), and however the film is moved along the axis, the object's plane turns about αX + βY = −n′f in the
/// front focal plane, the hinge (Merklinger, *Focusing the View Camera*, chapter 5).
pub fn sharp_plane(cardinals: &Cardinals, film_distance: f64, slopes: [f64; 2]) -> SharpPlane {
    let f = cardinals.focal_length;
    let behind = film_distance - cardinals.back_focal_distance;
    SharpPlane {
        normal: [f * slopes[0], f * slopes[1], behind],
        distance: behind * cardinals.front_focal_point - cardinals.index_behind * f * f,
    }
}

/// How far from the axis the line lies about which the plane of focus turns when a film with these `slopes` is moved along it, mm.
pub fn hinge_distance(cardinals: &Cardinals, slopes: [f64; 2]) -> f64 {
    (cardinals.index_behind * cardinals.focal_length / slopes[0].hypot(slopes[1])).abs()
}

/// The least distance from film to plane of focus at which the lens can give a sharp image, mm:
/// f (1 + √n')², four focal lengths in air, and the gap between the principal planes.
pub fn minimum_focus_distance(cardinals: Option<Cardinals>) -> Result<f64, FocusError> {
    let c = imaging(cardinals)?;
    let lengths = (1.0 + c.index_behind.sqrt()).powi(2);
    Ok(lengths * c.focal_length + (c.rear_principal_plane - c.front_principal_plane))
}

fn imaging(cardinals: Option<Cardinals>) -> Result<Cardinals, FocusError> {
    match cardinals {
        Some(c) if c.focal_length > 0.0 => Ok(c),
        other => Err(FocusError::NoImage {
            focal_length: other.map(|c| c.focal_length),
        }),
    }
}

pub(super) fn checked(film_distance: f64, asked: f64) -> Result<f64, FocusError> {
    if film_distance > 0.0 {
        Ok(film_distance)
    } else {
        Err(FocusError::InsideLens {
            asked,
            inside: -film_distance,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::optics::{Paraxial, Prescription};

    /// A film in glass: the plane that the film is put for is the plane in focus, and a film at infinity
    /// focus lies at the rear focal point.
    #[test]
    fn a_film_in_glass_is_focused_by_its_index() {
        let text = "50 100 1.5 20\n";
        let prescription = Prescription::parse(text).unwrap();
        let paraxial = Paraxial::new(&prescription.surfaces);
        let c = paraxial.cardinals.unwrap();
        // A single surface: f = R/(n − 1) in front, n f behind.
        assert!((c.focal_length - 100.0).abs() < 1e-12);
        assert!((c.rear_focal_point - 150.0).abs() < 1e-12);
        for distance in [600.0, 10_000.0, 1e6] {
            let film = film_distance_for_focus(Some(c), distance).unwrap();
            let plane = plane_of_focus(&c, film).unwrap();
            // Gauss: n/s' + 1/s = 1/f, to rounding of numbers that differ by `distance`.
            assert!(
                ((film - plane) / distance - 1.0).abs() < 1e-9,
                "{film} {plane}"
            );
        }
        let minimum = minimum_focus_distance(Some(c)).unwrap();
        assert!(film_distance_for_focus(Some(c), minimum * (1.0 + 1e-12)).is_ok());
        assert!(film_distance_for_focus(Some(c), minimum * (1.0 - 1e-9)).is_err());
        assert_eq!(film_distance_for_focus(Some(c), f64::INFINITY), Ok(150.0));
    }

    /// The sample lens of docs/scene-language.md §6.6, whose values were measured on pbrt-v3.
    const SAMPLE: &str = "35 6 1.5168 24\n-90 4 1 24\n0 10 0 12\n60 5 1.62 22\n-45 20 1 22\n";

    fn sample() -> Option<Cardinals> {
        let p = Prescription::parse(SAMPLE).unwrap();
        Paraxial::new(&p.surfaces).cardinals
    }

    #[test]
    fn agrees_with_pbrt_on_the_sample_lens() {
        let c = sample();
        // pbrt derives the cardinal points from a real ray 0.043 mm off the axis: 1e-5 relative.
        assert!((c.unwrap().focal_length / 28.63796 - 1.0).abs() < 1e-5);
        for (distance, expected) in [(10_000.0, 16.57488), (1000.0, 17.36226)] {
            let q = film_distance_for_focus(c, distance).unwrap();
            assert!((q / expected - 1.0).abs() < 1e-5, "{q} {expected}");
        }
        // Near the least distance the square root amplifies that: 0.3 % of its argument.
        let q = film_distance_for_focus(c, 115.0).unwrap();
        assert!((q / 39.47572 - 1.0).abs() < 1e-3, "{q}");
        assert!((minimum_focus_distance(c).unwrap() / 113.609 - 1.0).abs() < 1e-5);
    }

    #[test]
    fn too_near_names_the_least_distance() {
        let c = sample();
        let error = film_distance_for_focus(c, 100.0).unwrap_err();
        assert!(
            matches!(error, FocusError::TooNear { minimum, .. } if (minimum - 113.609).abs() < 1e-2)
        );
        assert!(error.to_string().contains("113.6"));
        assert!(film_distance_for_focus(c, f64::NAN).is_err());
        assert!(film_distance_for_focus(c, -5.0).is_err());
    }

    #[test]
    fn infinity_focuses_at_the_focal_point() {
        let c = sample();
        let bfd = c.unwrap().back_focal_distance;
        assert!((film_distance_for_focus(c, f64::INFINITY).unwrap() - bfd).abs() < 1e-12);
        assert_eq!(plane_of_focus(&c.unwrap(), bfd), Some(f64::NEG_INFINITY));
        assert_eq!(plane_of_focus(&c.unwrap(), bfd - 1.0), None);
    }

    #[test]
    fn plane_of_focus_inverts_focusing() {
        let c = sample();
        let length = Prescription::parse(SAMPLE).unwrap().length();
        for distance in [150.0, 1000.0, 1e6] {
            let q = film_distance_for_focus(c, distance).unwrap();
            let z = plane_of_focus(&c.unwrap(), q).unwrap();
            // Rounding of the film distance, some 1e-15, over its distance from the focal point.
            assert!(((length + q - z) / distance - 1.0).abs() < 1e-9);
        }
    }

    /// Points of the plane are imaged onto the film by the thick lens' equations; the plane meets the film's where Scheimpflug says, and the hinge
    /// lies in it for every distance.
    #[test]
    fn the_sharp_plane_of_a_tilted_film_is_its_image() {
        let c = sample().unwrap();
        let length = Prescription::parse(SAMPLE).unwrap().length();
        let slopes = [0.03, 0.12];
        for q in [16.3, 17.0, 20.0] {
            let plane = sharp_plane(&c, q, slopes);
            let [a, b, n] = plane.normal;
            let on_plane = |x: f64, y: f64| (plane.distance - a * x - b * y) / n;
            for [x, y] in [[0.0, 0.0], [30.0, -80.0], [-200.0, 150.0]] {
                let z = on_plane(x, y);
                // The image of (x, y, z).
                let from_focus = c.front_focal_point - z;
                let behind = c.index_behind * c.focal_length.powi(2) / from_focus;
                let film = [x, y].map(|v| -v * c.focal_length / from_focus);
                let there = q + slopes[0] * film[0] + slopes[1] * film[1];
                // Rounding of distances of a meter or so.
                assert!((c.back_focal_distance + behind - there).abs() < 1e-9);
            }
            // Up the direction of the tilt: both planes at their principal plane.
            let steepest = slopes[0].hypot(slopes[1]);
            let film_height = (c.rear_principal_plane - length - q) / steepest;
            let [u, v] = slopes.map(|s| s / steepest * film_height);
            assert!((on_plane(u, v) - c.front_principal_plane).abs() < 1e-9);
            let hinge = -hinge_distance(&c, slopes);
            let [u, v] = slopes.map(|s| s / steepest * hinge);
            assert!((on_plane(u, v) - c.front_focal_point).abs() < 1e-9);
        }
    }

    #[test]
    fn diverging_and_afocal_lenses_are_refused() {
        let p = Prescription::parse("-50 3 1.5 20\n50 0 1 20\n").unwrap();
        let c = Paraxial::new(&p.surfaces).cardinals;
        assert!(matches!(
            film_distance_for_focus(c, 1000.0),
            Err(FocusError::NoImage {
                focal_length: Some(_)
            })
        ));
        assert!(matches!(
            film_distance_for_focus(None, 1000.0),
            Err(FocusError::NoImage { focal_length: None })
        ));
    }
}
