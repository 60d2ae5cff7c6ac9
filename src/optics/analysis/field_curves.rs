//! Field curves: where sagittal and tangential fans of an object point come to a focus, along real chief rays.
//!
//! Coddington's equations (Welford, *Aberrations of Optical Systems*, 1986, §9.5) follow the two foci of an infinitely narrow pencil
//! through a lens. They are the first derivatives of the trace, which dual numbers carry exactly, through aspheres too: the pencil
//! is in focus where the derivative of the landing point by the ray's place in the beam is zero.

use super::beam::Beam;
use super::seidel::Seidel;
use crate::optics::lens::Lens;
use crate::optics::real::Dual;
use crate::optics::trace::LensRay;
use serde::Serialize;

/// The foci of one field point, along the axis from the film: positive behind it, mm.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct FieldFocus {
    /// Film height of the chief ray, mm.
    pub height: f64,
    /// Of rays across the meridional plane; `None` where they stay parallel.
    pub sagittal: Option<f64>,
    /// Of rays in it.
    pub tangential: Option<f64>,
    /// Petzval's surface, on which both would lie without astigmatism, through the sharpest point on the axis.
    pub petzval: Option<f64>,
}

impl FieldFocus {
    /// Of a beam; `axial` is the focus on the axis. `None` where the lens does not pass its chief ray.
    pub fn new(lens: &Lens, beam: &Beam, axial: Option<f64>) -> Option<FieldFocus> {
        let start = beam.ray([Dual::parameter(0.0, 0), Dual::parameter(0.0, 1)]);
        let out: LensRay<Dual> = lens.tracer().to_film_unclipped(&start).ok()?;
        // On the plane z the ray has the coordinate o + (z − o_z) d/d_z: its derivative is zero at the focus.
        let focus = |axis: usize| {
            let slope = out.d[axis] / out.d[2];
            let there = out.o[axis] - out.o[2] * slope;
            let z = -there.by[axis] / slope.by[axis];
            Some(z - lens.film_z()).filter(|z| z.abs() < 1e9)
        };
        let height = beam.chief.height;
        // The sag of a sphere as third order has it: beyond, Petzval's surface is not defined.
        let petzval = |focus: f64| focus + 0.5 * Seidel::petzval_curvature(lens) * height * height;
        Some(FieldFocus {
            height,
            sagittal: focus(0),
            tangential: focus(1),
            petzval: axial.map(petzval),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::optics::analysis::{ChiefFinder, ObjectPlane};
    use crate::optics::{ExitPupil, Prescription};

    fn foci(lens: &Lens, object: ObjectPlane, heights: &[f64]) -> Vec<FieldFocus> {
        let pupil = ExitPupil::new(lens, 25.0, 16);
        let finder = ChiefFinder::new(lens);
        let of = |h: &f64| {
            let beam = Beam::new(lens, &pupil, &finder.find(*h).unwrap(), object).unwrap();
            FieldFocus::new(lens, &beam, Some(0.0)).unwrap()
        };
        heights.iter().map(of).collect()
    }

    /// Coddington's equations for spheres along the chief ray of a distant point, from the film: s and t are the distances along it.
    fn coddington(lens: &Lens, height: f64) -> [f64; 2] {
        let chief = ChiefFinder::new(lens).find(height).unwrap();
        let ray = LensRay {
            o: chief.ray.o,
            d: chief.ray.d.map(|x| -x),
        };
        let mut points = Vec::new();
        let out = lens
            .tracer()
            .visit_to_film(&ray, |_, p| points.push(p))
            .unwrap();
        let t = (lens.film_z() - out.o[2]) / out.d[2];
        points.push([0.0, out.o[1] + t * out.d[1], lens.film_z()]);
        let mut direction = ray.d;
        let (mut n, mut z) = (1.0, 0.0);
        // Vergences n/s and n cos²I/t of the pencil.
        let (mut sagittal, mut tangential) = (0.0f64, 0.0f64);
        for (i, s) in lens.surfaces().iter().enumerate() {
            let p = points[i];
            let c = s.curvature();
            // The normal of a sphere, and the angles with it.
            let normal = [-c * p[0], -c * p[1], 1.0 - c * (p[2] - z)];
            let dot = |d: [f64; 3]| (0..3).map(|k| d[k] * normal[k]).sum::<f64>();
            let next: [f64; 3] = std::array::from_fn(|k| points[i + 1][k] - p[k]);
            let length = next.iter().map(|x| x * x).sum::<f64>().sqrt();
            let refracted = next.map(|x| x / length);
            let (cos, cos2) = (dot(direction), dot(refracted));
            let power = c * (s.index * cos2 - n * cos);
            sagittal += power;
            tangential = (tangential * cos * cos + power) / (cos2 * cos2);
            if i + 1 < lens.surfaces().len() {
                sagittal = 1.0 / (1.0 / sagittal - length / s.index);
                tangential = 1.0 / (1.0 / tangential - length / s.index);
            }
            (direction, n) = (refracted, s.index);
            z += s.thickness;
        }
        // From the last surface along the ray to the focus, less the way to the film, along the axis.
        let last = points[points.len() - 2];
        let way = (lens.film_z() - last[2]) / direction[2];
        [sagittal, tangential].map(|v| (n / v - way) * direction[2])
    }

    #[test]
    fn foci_are_those_of_coddingtons_equations() {
        let file = format!("{}/tests/golden/dgauss_50.dat", env!("CARGO_MANIFEST_DIR"));
        let p = Prescription::read(file.as_ref()).unwrap();
        let lens = Lens::new(&p, Lens::focused(&p, f64::INFINITY).unwrap()).unwrap();
        for height in [5.0, 12.0, 20.0] {
            let [found] = foci(&lens, ObjectPlane::INFINITY, &[height])[..] else {
                panic!()
            };
            let [s, t] = coddington(&lens, height);
            // Two ways to the same number, some 50 mm from where they start.
            assert!((found.sagittal.unwrap() - s).abs() < 1e-9, "{found:?} {s}");
            assert!(
                (found.tangential.unwrap() - t).abs() < 1e-9,
                "{found:?} {t}"
            );
        }
    }

    #[test]
    fn a_thin_lens_curves_the_field_as_the_textbook_says() {
        // Stop at a thin lens of f = 100: in third order sagittal and tangential foci lie h²/2f (1 + 1/n) and h²/2f (3 + 1/n) in front of the
        // film (Welford §8.5, with S_III = H²K, S_IV = H²K/n).
        let p = Prescription::parse("0 0 0 2\n100 1e-9 1.5 60\n-100 0 1 60\n").unwrap();
        let lens = Lens::new(&p, 100.0).unwrap();
        let [near, far] = foci(&lens, ObjectPlane::INFINITY, &[1.0, 2.0])[..] else {
            panic!()
        };
        for (focus, h2) in [(near, 1.0), (far, 4.0)] {
            let unit = -h2 / 200.0;
            // The next order is the square of the field angle of 1 to 2/100.
            assert!(
                (focus.sagittal.unwrap() / unit - (1.0 + 1.0 / 1.5)).abs() < 2e-3,
                "{focus:?}"
            );
            assert!(
                (focus.tangential.unwrap() / unit - (3.0 + 1.0 / 1.5)).abs() < 4e-3,
                "{focus:?}"
            );
            assert!(
                (focus.petzval.unwrap() / unit - 1.0 / 1.5).abs() < 1e-9,
                "{focus:?}"
            );
        }
    }
}
