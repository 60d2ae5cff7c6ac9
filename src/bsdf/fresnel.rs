//! Fresnel reflectance of smooth boundaries (Pharr, Jakob and Humphreys 2016, §8.2.1).

use crate::math::Rgb;

/// Fresnel reflectance of a boundary, by the materials on its two sides.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Fresnel {
    /// Reflects everything.
    NoOp,
    /// Between two dielectrics; `eta_i` is the refractive index on the normal's side.
    Dielectric {
        /// Index on the normal's side.
        eta_i: f32,
        /// Index on the other side.
        eta_t: f32,
    },
    /// Conductor in vacuum, per color channel.
    Conductor {
        /// Real part of the refractive index.
        eta: Rgb,
        /// Imaginary part (extinction).
        k: Rgb,
    },
    /// The Disney BSDF's blend of a dielectric in vacuum and a metal (Burley 2015, §4).
    Disney {
        /// Reflectance of the metal at normal incidence; by Schlick's approximation it is white at grazing angles.
        r0: Rgb,
        /// Fraction of the metal.
        metallic: f32,
        /// Refractive index of the dielectric.
        eta: f32,
    },
}

impl Fresnel {
    /// Reflectance for unpolarized light incident at signed cosine `cos_i` to the normal.
    pub fn evaluate(&self, cos_i: f32) -> Rgb {
        match *self {
            Fresnel::NoOp => Rgb::ONE,
            Fresnel::Dielectric { eta_i, eta_t } => Rgb::splat(dielectric(cos_i, eta_i, eta_t)),
            Fresnel::Conductor { eta, k } => conductor(cos_i.abs(), eta, k),
            Fresnel::Disney { r0, metallic, eta } => {
                let glass = Rgb::splat(dielectric(cos_i, 1.0, eta));
                glass.lerp(r0.lerp(Rgb::ONE, schlick_weight(cos_i)), metallic)
            }
        }
    }
}

/// Unpolarized reflectance of a dielectric boundary: light with `cos_i` > 0 is incident on the side of index `eta_i`,
/// with `cos_i` < 0 on the other. 1 for total internal reflection. Without a branch.
#[inline(always)]
pub fn dielectric(cos_i: f32, eta_i: f32, eta_t: f32) -> f32 {
    let (eta_i, eta_t) = if cos_i > 0.0 {
        (eta_i, eta_t)
    } else {
        (eta_t, eta_i)
    };
    let cos_i = cos_i.abs().min(1.0);
    let sin_t = eta_i / eta_t * (1.0 - cos_i * cos_i).max(0.0).sqrt();
    let cos_t = (1.0 - sin_t * sin_t).max(0.0).sqrt();
    let parallel = (eta_t * cos_i - eta_i * cos_t) / (eta_t * cos_i + eta_i * cos_t);
    let perpendicular = (eta_i * cos_i - eta_t * cos_t) / (eta_i * cos_i + eta_t * cos_t);
    let partial = 0.5 * (parallel * parallel + perpendicular * perpendicular);
    if sin_t >= 1.0 { 1.0 } else { partial }
}

/// Unpolarized reflectance of a conductor of complex index `eta` + i `k` in vacuum, at cosine `cos_i` in 0…1.
pub fn conductor(cos_i: f32, eta: Rgb, k: Rgb) -> Rgb {
    let cos = cos_i.clamp(0.0, 1.0);
    let cos2 = cos * cos;
    let sin2 = 1.0 - cos2;
    let (eta2, k2) = (eta * eta, k * k);
    let t0 = eta2 - k2 - sin2;
    let a2_plus_b2 = (t0 * t0 + 4.0 * eta2 * k2).map(f32::sqrt);
    let t1 = a2_plus_b2 + cos2;
    let a = (0.5 * (a2_plus_b2 + t0)).max(Rgb::ZERO).map(f32::sqrt);
    let t2 = 2.0 * cos * a;
    let perpendicular = contrast(t1, t2);
    let t3 = cos2 * a2_plus_b2 + sin2 * sin2;
    let t4 = t2 * sin2;
    let parallel = perpendicular * contrast(t3, t4);
    0.5 * (parallel + perpendicular)
}

/// (a − b)/(a + b), 1 if both are 0.
fn contrast(a: Rgb, b: Rgb) -> Rgb {
    let sum = a + b;
    Rgb::select(sum.cmpgt(Rgb::ZERO), (a - b) / sum, Rgb::ONE)
}

/// Weight of white in Schlick's approximation of Fresnel reflectance, (1 − cos)⁵; 1 for a cosine
/// below 0 (Schlick 1994; Pharr, Jakob and Humphreys 2016, equation 8.21).
pub fn schlick_weight(cos: f32) -> f32 {
    (1.0 - cos).clamp(0.0, 1.0).powi(5)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn glass_reflects_four_percent_head_on() {
        // ((1.5 − 1) / (1.5 + 1))² = 0.04 from either side.
        assert!((dielectric(1.0, 1.0, 1.5) - 0.04).abs() < 1e-6);
        assert!((dielectric(-1.0, 1.0, 1.5) - 0.04).abs() < 1e-6);
    }

    #[test]
    fn nothing_of_the_parallel_part_returns_at_brewsters_angle() {
        // tan θ = 1.5: the mean of both polarizations is half the perpendicular part's square,
        // ((cos²θ − sin²θ))² / 2 there.
        let theta = 1.5f32.atan();
        let expected = 0.5 * (theta.cos().powi(2) - theta.sin().powi(2)).powi(2);
        assert!((dielectric(theta.cos(), 1.0, 1.5) - expected).abs() < 1e-6);
    }

    #[test]
    fn light_is_trapped_beyond_the_critical_angle() {
        let critical = (1.0f32 / 1.5).asin();
        assert_eq!(dielectric(-(critical + 1e-3).cos(), 1.0, 1.5), 1.0);
        assert!(dielectric(-(critical - 1e-2).cos(), 1.0, 1.5) < 1.0);
    }

    #[test]
    fn both_ways_through_a_boundary_lose_the_same() {
        for i in 1..100 {
            let sin_i = i as f32 / 100.0;
            let (cos_i, cos_t) = (
                (1.0 - sin_i * sin_i).sqrt(),
                (1.0 - (sin_i / 1.5).powi(2)).sqrt(),
            );
            // A few roundings of values up to 1.5.
            assert!((dielectric(cos_i, 1.0, 1.5) - dielectric(-cos_t, 1.0, 1.5)).abs() < 1e-5);
        }
    }

    #[test]
    fn a_conductor_without_extinction_is_a_dielectric() {
        for i in 1..=100 {
            let cos = i as f32 / 100.0;
            let f = conductor(cos, Rgb::splat(1.5), Rgb::ZERO).x;
            assert!((f - dielectric(cos, 1.0, 1.5)).abs() < 1e-5);
        }
    }

    #[test]
    fn a_conductor_reflects_by_the_textbook_value_head_on() {
        // ((η − 1)² + k²) / ((η + 1)² + k²).
        let (eta, k) = (Rgb::new(0.2, 0.92, 1.1), Rgb::new(3.9, 2.45, 2.14));
        let expected = ((eta - 1.0) * (eta - 1.0) + k * k) / ((eta + 1.0) * (eta + 1.0) + k * k);
        assert!((conductor(1.0, eta, k) - expected).abs().max_element() < 1e-6);
    }
}
