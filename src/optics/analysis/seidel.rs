//! Seidel's sums: what each surface adds to the aberrations of third order.
//!
//! From a marginal and a chief ray of Gaussian optics (Welford, *Aberrations of Optical Systems*, 1986, chapter 8, in the notation of
//! Hopkins, *Wave Theory of Aberrations*, 1950): with A = n(u + yc) of the marginal ray, Ā of the chief ray, H = n(ūy − uȳ) and Δ the
//! change at the surface,
//!
//! S_I = −A² y Δ(u/n), S_II = −AĀ y Δ(u/n), S_III = −Ā² y Δ(u/n), S_IV = −H² c Δ(1/n),
//! S_V = −Ā \[Ā² y Δ(1/n²) − (H + Āy) ȳ c Δ(1/n)\];
//!
//! C_I = A y Δ(δn/n) and C_II = Ā y Δ(δn/n) with δn = n_F − n_C. A surface that departs by G r⁴ from the sphere at its vertex adds
//! 8 G Δn y⁴ (ȳ/y)^j to the first four but S_IV and to S_V, j = 0, 1, 2, 3. All are millimeters of optical path: the wavefront at the
//! rim is off by S_I/8 for spherical aberration, S_II/2 for coma, S_III/2 for astigmatism, (S_III + S_IV)/4 for the field's curvature
//! and S_V/2 for distortion, and rays land off by these over n′u′.

use super::object::ObjectPlane;
use crate::optics::dispersion::{AbbeModel, LINE_C, LINE_F, index_at};
use crate::optics::lens::Lens;
use crate::optics::surface::Surface;
use serde::Serialize;
use std::iter::Sum;

/// What a surface, or the lens, adds; mm of optical path.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct SeidelTerms {
    /// S_I.
    pub spherical: f64,
    /// S_II.
    pub coma: f64,
    /// S_III.
    pub astigmatism: f64,
    /// S_IV, Petzval's.
    pub petzval: f64,
    /// S_V.
    pub distortion: f64,
    /// C_I, between the lines F and C; 0 where the file knows no dispersion.
    pub axial_color: f64,
    /// C_II.
    pub lateral_color: f64,
}

impl SeidelTerms {
    /// In the order of the fields.
    pub fn values(&self) -> [f64; 7] {
        [
            self.spherical,
            self.coma,
            self.astigmatism,
            self.petzval,
            self.distortion,
            self.axial_color,
            self.lateral_color,
        ]
    }
}

impl Sum for SeidelTerms {
    fn sum<I: Iterator<Item = SeidelTerms>>(terms: I) -> SeidelTerms {
        terms.fold(SeidelTerms::default(), |a, b| SeidelTerms {
            spherical: a.spherical + b.spherical,
            coma: a.coma + b.coma,
            astigmatism: a.astigmatism + b.astigmatism,
            petzval: a.petzval + b.petzval,
            distortion: a.distortion + b.distortion,
            axial_color: a.axial_color + b.axial_color,
            lateral_color: a.lateral_color + b.lateral_color,
        })
    }
}

/// The sums of a lens for the whole stop and one image height.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Seidel {
    /// Height of the Gaussian image of the field's point, mm.
    pub image_height: f64,
    /// Slope of the marginal ray at the film times the index there, n′u′; negative for a real image.
    pub image_slope: f64,
    /// By surface, from the scene.
    pub surfaces: Vec<SeidelTerms>,
    /// Their sum.
    pub sum: SeidelTerms,
}

/// A ray of Gaussian optics: height and slope.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Paraxial {
    y: f64,
    u: f64,
}

impl Paraxial {
    fn times(self, k: f64) -> Paraxial {
        Paraxial {
            y: k * self.y,
            u: k * self.u,
        }
    }

    /// Behind a surface of curvature `c` between indices.
    fn refracted(self, c: f64, [n, next]: [f64; 2]) -> Paraxial {
        let u = (n * self.u - self.y * c * (next - n)) / next;
        Paraxial { u, ..self }
    }

    /// `t` mm on.
    fn moved(self, t: f64) -> Paraxial {
        Paraxial {
            y: self.y + t * self.u,
            ..self
        }
    }

    /// At each surface in front of it, and behind the last.
    fn through(mut self, surfaces: &[Surface]) -> (Vec<Paraxial>, Paraxial) {
        let (mut n, last) = (1.0, surfaces.len().saturating_sub(1));
        let mut met = Vec::with_capacity(surfaces.len());
        for (i, s) in surfaces.iter().enumerate() {
            met.push(self);
            self = self.refracted(s.curvature(), [n, s.index]);
            if i < last {
                self = self.moved(s.thickness);
            }
            n = s.index;
        }
        (met, self)
    }
}

impl Seidel {
    /// Of `lens` with its stop as it is, for a point of `object` whose Gaussian image lies `image_height` mm from the axis; `None` where
    /// the lens makes no image of it.
    pub fn new(lens: &Lens, object: ObjectPlane, image_height: f64) -> Option<Seidel> {
        let surfaces = lens.surfaces();
        let stop = lens.paraxial().stop;
        // From the axial point of the object, and through the middle of the stop.
        let axial = match object.z {
            Some(z) => Paraxial { y: -z, u: 1.0 },
            None => Paraxial { y: 1.0, u: 0.0 },
        };
        let met = |ray: Paraxial| ray.through(surfaces).0[stop].y;
        let high = met(Paraxial { y: 1.0, u: 0.0 });
        let steep = met(Paraxial { y: 0.0, u: 1.0 });
        let middle = Paraxial { y: steep, u: -high };
        let marginal = axial.times(surfaces[stop].clear_radius() / met(axial));
        let image = marginal.through(surfaces).1;
        let at_image = middle.through(surfaces).1;
        let reached = at_image.moved(-image.y / image.u).y;
        let chief = middle.times(image_height / reached);
        let all = [marginal.y, marginal.u, chief.y, chief.u];
        if !all.iter().all(|x| x.is_finite()) || marginal.y == 0.0 && marginal.u == 0.0 {
            return None;
        }
        let lagrange = chief.u * marginal.y - marginal.u * chief.y;
        let (marginal, chief) = (marginal.through(surfaces).0, chief.through(surfaces).0);
        let terms = |(i, s): (usize, &Surface)| {
            let front = i.checked_sub(1).map(|i| &surfaces[i]);
            terms(s, front, [marginal[i], chief[i]], lagrange)
        };
        let surfaces: Vec<SeidelTerms> = surfaces.iter().enumerate().map(terms).collect();
        Some(Seidel {
            image_height,
            image_slope: lens.rear().index * image.u,
            sum: surfaces.iter().copied().sum(),
            surfaces,
        })
    }

    /// Curvature of Petzval's surface, 1/mm: negative where it bends toward the lens. `index` is that behind the lens.
    pub fn petzval_curvature(lens: &Lens) -> f64 {
        let mut n = 1.0;
        let part = |s: &Surface| {
            let front = std::mem::replace(&mut n, s.index);
            s.curvature() * (1.0 / s.index - 1.0 / front)
        };
        lens.rear().index * lens.surfaces().iter().map(part).sum::<f64>()
    }
}

/// n_F − n_C of the space behind a surface, or of the air in front of the first.
fn spread(surface: Option<&Surface>) -> f64 {
    surface.map_or(0.0, |s| {
        let at = |wavelength| index_at(s, wavelength, AbbeModel::NormalLine);
        at(LINE_F) - at(LINE_C)
    })
}

/// What surface `s` behind `front` adds, where it meets these rays.
fn terms(
    s: &Surface,
    front: Option<&Surface>,
    [marginal, chief]: [Paraxial; 2],
    lagrange: f64,
) -> SeidelTerms {
    let (n, next, c) = (front.map_or(1.0, |s| s.index), s.index, s.curvature());
    let (y, bar) = (marginal.y, chief.y);
    let (a, b) = (n * (marginal.u + y * c), n * (chief.u + bar * c));
    let bend = marginal.refracted(c, [n, next]).u / next - marginal.u / n;
    let (inverse, square) = (1.0 / next - 1.0 / n, 1.0 / (next * next) - 1.0 / (n * n));
    let color = spread(Some(s)) / next - spread(front) / n;
    // 8 G Δn, by powers of y and ȳ that need no quotient.
    let aspheric = 8.0 * departure(s) * (next - n);
    SeidelTerms {
        spherical: -a * a * y * bend + aspheric * y.powi(4),
        coma: -a * b * y * bend + aspheric * y.powi(3) * bar,
        astigmatism: -b * b * y * bend + aspheric * y * y * bar * bar,
        petzval: -lagrange * lagrange * c * inverse,
        distortion: -b * (b * b * y * square - (lagrange + b * y) * bar * c * inverse)
            + aspheric * y * bar.powi(3),
        axial_color: a * y * color,
        lateral_color: b * y * color,
    }
}

/// G of G r⁴, 1/mm³: how a surface departs from the sphere of its curvature at the vertex.
fn departure(s: &Surface) -> f64 {
    s.asphere.map_or(0.0, |asphere| {
        let base = (1.0 + asphere.conic) / (8.0 * s.radius.powi(3));
        base + asphere.terms[1] - s.curvature().powi(3) / 8.0
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::optics::Prescription;
    use crate::optics::trace::LensRay;

    fn focused(text: &str) -> Lens {
        let p = Prescription::parse(text).unwrap();
        Lens::new(&p, Lens::focused(&p, f64::INFINITY).unwrap()).unwrap()
    }

    /// Where rays of a distant point land off its Gaussian image, mm: the field's image at `height`, through the point (x, y) of the
    /// entrance pupil.
    fn off(lens: &Lens, height: f64, [x, y]: [f64; 2]) -> [f64; 2] {
        let cardinals = lens.paraxial().cardinals.unwrap();
        let pupil = lens.paraxial().entrance_pupil.unwrap();
        let slope = height / cardinals.focal_length;
        let ray = LensRay::new([x, y, pupil.z], [0.0, slope, 1.0]);
        let out = lens.tracer().to_film_unclipped(&ray).unwrap();
        let t = (lens.film_z() - out.o[2]) / out.d[2];
        [out.o[0] + t * out.d[0], out.o[1] + t * out.d[1] - height]
    }

    /// The third-order law of Welford (8.7): what the sums say of a ray through (ρ, φ), against real rays of a small stop and a small field.
    fn check(lens: &Lens, name: &str) {
        // Fifth order is the square of this of third order, times some tens.
        const SMALL: f64 = 4e-3;
        let edge = 0.3 * lens.paraxial().cardinals.unwrap().focal_length;
        let seidel = Seidel::new(lens, ObjectPlane::INFINITY, edge).unwrap();
        let s = seidel.sum;
        let radius = 0.5 * lens.paraxial().entrance_pupil.unwrap().diameter;
        let size = s.values()[..5].iter().map(|x| x.abs()).fold(0.0, f64::max);
        for (rho, phi) in [
            (0.0, 0.0f64),
            (1.0, 0.0),
            (1.0, std::f64::consts::FRAC_PI_2),
            (0.7, 2.0),
            (0.5, 4.0),
        ] {
            let (sin, cos) = phi.sin_cos();
            let pupil = [SMALL * rho * radius * sin, SMALL * rho * radius * cos];
            let found = off(lens, SMALL * edge, pupil).map(|x| x / SMALL.powi(3));
            let third = [
                s.spherical * rho.powi(3) * sin
                    + s.coma * rho * rho * (2.0 * phi).sin()
                    + (s.astigmatism + s.petzval) * rho * sin,
                s.spherical * rho.powi(3) * cos
                    + s.coma * rho * rho * (2.0 + (2.0 * phi).cos())
                    + (3.0 * s.astigmatism + s.petzval) * rho * cos
                    + s.distortion,
            ];
            for i in 0..2 {
                let expected = third[i] / (2.0 * seidel.image_slope);
                let most = 5e-3 * size / (2.0 * seidel.image_slope.abs());
                assert!(
                    (found[i] - expected).abs() < most,
                    "{name} {rho} {phi}: {} {expected}",
                    found[i]
                );
            }
        }
    }

    #[test]
    fn sums_are_the_third_order_limit_of_real_rays() {
        check(
            &focused("0 5 0 10\n40 4 1.5168 30\n-200 0 1 30\n"),
            "stop in front",
        );
        check(
            &focused("40 4 1.5168 30\n-200 7 1 30\n0 0 0 8\n"),
            "stop behind",
        );
        check(
            &focused("0 5 0 10\n40 4 1.5168 30 k=-0.6 A2=1e-3 A4=2e-6\n-200 0 1 30\n"),
            "aspheric",
        );
        for name in ["triplet_50", "dgauss_50", "tessar_100", "retrofocus_35"] {
            let file = format!("{}/tests/golden/{name}.dat", env!("CARGO_MANIFEST_DIR"));
            let p = Prescription::read(file.as_ref()).unwrap();
            check(
                &Lens::new(&p, Lens::focused(&p, f64::INFINITY).unwrap()).unwrap(),
                name,
            );
        }
    }

    #[test]
    fn an_aplanatic_surface_has_neither_spherical_aberration_nor_coma() {
        // Light in air converging to R(n + 1) behind the surface is brought to R(n + 1)/n in the glass (Born and Wolf §4.2.3).
        let p = Prescription::parse("0 0 0 4\n20 0 1.5 30\n").unwrap();
        let lens = Lens::new(&p, 50.0 / 1.5).unwrap();
        let s = Seidel::new(&lens, ObjectPlane { z: Some(50.0) }, 1.0)
            .unwrap()
            .sum;
        assert!(s.spherical.abs() < 1e-15 && s.coma.abs() < 1e-15, "{s:?}");
        // It is not free of the others.
        assert!(s.petzval.abs() > 1e-6);
    }

    #[test]
    fn a_thin_singlet_has_the_sums_of_the_textbook() {
        // Stop at the lens (Welford §12.3): S_III = H²K and S_IV = H²K/n whatever the bending, S_V = 0; C_I = y²K/V, C_II = 0.
        let lens = focused("0 0 0 0 10\n60 1e-9 1.5168 64.17 30\n-150 0 1 0 30\n");
        let power = 0.5168 * (1.0 / 60.0 + 1.0 / 150.0);
        let seidel = Seidel::new(&lens, ObjectPlane::INFINITY, 10.0).unwrap();
        let lagrange = 5.0 * 10.0 * power;
        let s = seidel.sum;
        for (found, expected) in [
            (s.astigmatism, lagrange * lagrange * power),
            (s.petzval, lagrange * lagrange * power / 1.5168),
            (s.distortion, 0.0),
            (s.lateral_color, 0.0),
        ] {
            assert!((found - expected).abs() < 1e-9, "{found} {expected}");
        }
        // n_F − n_C is (n_d − 1)/V by definition; the formula through it rounds.
        let color = 25.0 * power / 64.17;
        assert!(
            (s.axial_color / color - 1.0).abs() < 1e-6,
            "{} {color}",
            s.axial_color
        );
        // Petzval's radius is −n f.
        let curvature = Seidel::petzval_curvature(&lens);
        assert!((curvature * 1.5168 / power + 1.0).abs() < 1e-9);
    }
}
