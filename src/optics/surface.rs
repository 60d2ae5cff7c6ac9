//! One row of a lens prescription: a spherical or plane surface, and the space behind it.

/// A surface of revolution about the lens axis. Lengths in millimetres; the z axis points from
/// the scene to the film.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Surface {
    /// Radius of curvature; positive where the centre lies on the film side; infinite for a plane.
    pub radius: f64,
    /// Distance along the axis to the next surface; for the last one see
    /// [`super::Prescription::film_distance`].
    pub thickness: f64,
    /// Refractive index of the space behind the surface (toward the film), at the d line.
    pub index: f64,
    /// Abbe number V_d of that space; `None` for air and where the file does not give one.
    pub abbe: Option<f64>,
    /// Full clear diameter: a ray farther from the axis where it meets the surface is blocked.
    pub aperture: f64,
    /// An aperture stop: a plane that refracts nothing and whose diameter the photographer sets.
    pub is_stop: bool,
}

impl Surface {
    /// 1/radius; 0 for a plane.
    pub fn curvature(&self) -> f64 {
        1.0 / self.radius
    }

    /// z of the surface at distance `r` from the axis, relative to its vertex. Beyond the equator
    /// of a sphere: the equator's.
    pub fn sag(&self, r: f64) -> f64 {
        let r = r.abs().min(self.radius.abs());
        let c = self.curvature();
        // Without cancellation for weak curvature: c r² / (1 + √(1 − c² r²)).
        c * r * r / (1.0 + (1.0 - c * c * r * r).max(0.0).sqrt())
    }

    /// Half the clear diameter, or what of it the sphere reaches.
    pub fn clear_radius(&self) -> f64 {
        (0.5 * self.aperture).min(self.radius.abs())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sag_is_exact_for_weak_and_strong_curvature() {
        let s = |radius| Surface {
            radius,
            thickness: 1.0,
            index: 1.5,
            abbe: None,
            aperture: 20.0,
            is_stop: false,
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
}
