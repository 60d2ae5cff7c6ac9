//! One row of a lens prescription: a surface of revolution, and the space behind it.

use super::asphere::{Asphere, AsphericSurface};
use super::coating::Coating;
use super::dispersion::Dispersion;
use arrayvec::ArrayString;
use std::fmt;

/// The name of a glass, as catalogues and lens files have it: 1 to 24 printed ASCII characters without blanks, and none that mean
/// something in lens files (`#`, `=`, `"`, `,`).
#[derive(Clone, Copy, PartialEq, Eq)]
pub struct GlassName(ArrayString<24>);

impl GlassName {
    /// `None` where the text is no such name.
    pub fn new(text: &str) -> Option<GlassName> {
        let plain = |c: char| c.is_ascii_graphic() && !matches!(c, '#' | '=' | '"' | ',');
        let is_name = !text.is_empty() && text.chars().all(plain);
        ArrayString::from(text)
            .ok()
            .filter(|_| is_name)
            .map(GlassName)
    }

    /// The name.
    pub fn as_str(&self) -> &str {
        &self.0
    }
}

impl fmt::Display for GlassName {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0)
    }
}

impl fmt::Debug for GlassName {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        fmt::Debug::fmt(self.as_str(), f)
    }
}

/// A surface of revolution about the lens axis. Lengths in millimeters; the z axis points from
/// the scene to the film.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Surface {
    /// Radius of curvature; positive where the center lies on the film side; infinite for a plane. Of an aspheric surface:
    /// that of its base sphere.
    pub radius: f64,
    /// Distance along the axis to the next surface; for the last one see
    /// [`super::Prescription::film_distance`].
    pub thickness: f64,
    /// Refractive index of the space behind the surface (toward the film), at the d line.
    pub index: f64,
    /// Abbe number V_d of that space; `None` for air and where the file does not give one.
    pub abbe: Option<f64>,
    /// Dispersion formula of that space where the file gives one; it goes before the Abbe number.
    pub dispersion: Option<Dispersion>,
    /// What the file calls the glass of that space; no number follows from it.
    pub glass: Option<GlassName>,
    /// Full clear diameter: a ray farther from the axis where it meets the surface is blocked.
    pub aperture: f64,
    /// An aperture stop, whose diameter the photographer sets: as a rule a plane that refracts nothing.
    pub is_stop: bool,
    /// Departure from a sphere.
    pub asphere: Option<Asphere>,
    /// The layer on it, where the file says so: [`super::ghosts`] knows it, nothing else does.
    pub coating: Option<Coating>,
}

impl Default for Surface {
    /// A plane in air without an edge.
    fn default() -> Surface {
        Surface {
            radius: f64::INFINITY,
            thickness: 0.0,
            index: 1.0,
            abbe: None,
            dispersion: None,
            glass: None,
            aperture: f64::INFINITY,
            is_stop: false,
            asphere: None,
            coating: None,
        }
    }
}

impl Surface {
    /// Curvature at the vertex, which decides what happens near the axis; 0 for a plane.
    pub fn curvature(&self) -> f64 {
        // The second derivative of A₂ r² adds to that of the base sphere.
        1.0 / self.radius + self.asphere.map_or(0.0, |a| 2.0 * a.terms[0])
    }

    /// Distance from the axis at which the surface ends by itself: at the equator of a sphere.
    fn edge(&self) -> f64 {
        let one_plus_conic = 1.0 + self.asphere.map_or(0.0, |a| a.conic);
        if one_plus_conic > 0.0 {
            self.radius.abs() / one_plus_conic.sqrt()
        } else {
            f64::INFINITY
        }
    }

    /// z of the surface at distance `r` from the axis, relative to its vertex. Beyond the equator
    /// of a sphere: the equator's.
    pub fn sag(&self, r: f64) -> f64 {
        let r = r.abs().min(self.edge());
        if let Some(asphere) = &self.asphere {
            return AsphericSurface::<f64>::new(self.radius, asphere, self.clear_radius()).sag(r);
        }
        let c = self.curvature();
        // Without cancellation for weak curvature: c r² / (1 + √(1 − c² r²)).
        c * r * r / (1.0 + (1.0 - c * c * r * r).max(0.0).sqrt())
    }

    /// Half the clear diameter, or what of it the surface reaches.
    pub fn clear_radius(&self) -> f64 {
        (0.5 * self.aperture).min(self.edge())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sag_is_exact_for_weak_and_strong_curvature() {
        let s = |radius| Surface {
            radius,
            aperture: 20.0,
            ..Surface::default()
        };
        // 3-4-5 triangle: at r = 3 a sphere of radius 5 has fallen behind by 1.
        assert!((s(5.0).sag(3.0) - 1.0).abs() < 1e-15);
        assert!((s(-5.0).sag(3.0) + 1.0).abs() < 1e-15);
        assert_eq!(s(f64::INFINITY).sag(3.0), 0.0);
        // r²/2R, the next term being 1e-17 of it.
        assert!((s(1e9).sag(3.0) / 4.5e-9 - 1.0).abs() < 1e-15);
        assert_eq!(s(5.0).sag(7.0), 5.0);
        assert_eq!(s(-5.0).clear_radius(), 5.0);
    }

    #[test]
    fn an_ellipsoid_ends_later_than_a_sphere_and_a_paraboloid_never() {
        let s = |conic| Surface {
            radius: 5.0,
            aperture: 100.0,
            asphere: Some(Asphere {
                conic,
                ..Asphere::default()
            }),
            ..Surface::default()
        };
        assert!((s(-0.75).clear_radius() - 10.0).abs() < 1e-14);
        assert_eq!(s(-1.0).clear_radius(), 50.0);
        assert!((s(-1.0).sag(10.0) - 10.0).abs() < 1e-14);
        // A₂ bends the vertex.
        let mut bent = s(0.0);
        bent.asphere = Some(Asphere {
            conic: 0.0,
            terms: [0.01, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0],
        });
        assert!((bent.curvature() - 0.22).abs() < 1e-15);
    }
}
