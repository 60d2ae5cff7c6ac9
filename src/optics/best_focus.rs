//! Focusing by real rays: the film where the axial spot is smallest.
//!
//! Gaussian focus is that of rays next to the axis. With spherical aberration the whole beam is narrowest elsewhere, in fast
//! lenses by up to 0.8 mm, and that is where a photographer, who looks at the image, puts the film. The mean square
//! height of rays on a plane is a quadratic function of the plane's z, so its minimum needs no search (Welford,
//! *Aberrations of Optical Systems*, §9.6).

use super::bisection::bisect;
use super::focus::{self, FocusError};
use super::lens::Lens;
use super::prescription::Prescription;
use super::trace::{LensRay, LensTracer};

/// Rays of the axial beam, at radii that share its cross-section evenly. The narrowest plane changes by 1e-4 of its
/// distance from the Gaussian one when there are ten times as many.
const RAYS: usize = 512;

/// The film distance, mm behind the last vertex, that gives the smallest root mean square spot of the axial point `distance`
/// mm from the film (infinity is allowed), at the stops as they are. The Gaussian value where no ray gets through.
pub fn film_distance(prescription: &Prescription, distance: f64) -> Result<f64, FocusError> {
    let gaussian = Lens::focused(prescription, distance)?;
    let search = Search {
        tracer: LensTracer::new(&prescription.surfaces),
        length: prescription.length(),
        distance,
    };
    focus::checked(search.solve(gaussian), distance)
}

struct Search {
    tracer: LensTracer<f64>,
    length: f64,
    distance: f64,
}

impl Search {
    /// The film distance that is its own narrowest plane: moving the film moves the object, which is at a fixed distance from
    /// it. Secant method from the Gaussian value.
    fn solve(&self, gaussian: f64) -> f64 {
        let error = |q: f64| self.narrowest(q).map(|best| best - q);
        let Some(mut last_error) = error(gaussian) else {
            return gaussian;
        };
        let mut last = gaussian;
        let mut at = gaussian + last_error;
        // Superlinear: a handful of steps reach rounding; a lens too odd to settle keeps its last good value.
        for _ in 0..20 {
            let Some(e) = error(at) else { return last };
            let slope = (e - last_error) / (at - last);
            (last, last_error) = (at, e);
            let step = -e / slope;
            // At infinity the error falls to 0 in one step and leaves no slope.
            if !step.is_finite() || e.abs() <= 1e-13 * at.abs() {
                break;
            }
            at += step;
        }
        last
    }

    /// Where behind the last vertex the beam of the object point is narrowest, the film being at `film_distance`.
    fn narrowest(&self, film_distance: f64) -> Option<f64> {
        let object_z = self.length + film_distance - self.distance;
        let edge = self.edge(object_z)?;
        // Height h + z s of every ray: Σ (h + z s)² is least at z = −Σ h s / Σ s².
        let (mut product, mut square) = (0.0, 0.0);
        for i in 0..RAYS {
            let y = edge * ((i as f64 + 0.5) / RAYS as f64).sqrt();
            let Some(out) = self.trace(object_z, y) else {
                continue;
            };
            let slope = out.d[1] / out.d[2];
            let height = out.o[1] - slope * (out.o[2] - self.length);
            product += height * slope;
            square += slope * slope;
        }
        let z = -product / square;
        z.is_finite().then_some(z)
    }

    /// The ray of the object point that crosses the front vertex plane at `y`.
    fn trace(&self, object_z: f64, y: f64) -> Option<LensRay<f64>> {
        let at = [0.0, y, 0.0];
        let ray = if object_z.is_finite() {
            LensRay::through([0.0, 0.0, object_z], at)
        } else {
            LensRay {
                o: at,
                d: [0.0, 0.0, 1.0],
            }
        };
        self.tracer.to_film(&ray).ok()
    }

    /// The radius of the axial beam on the front vertex plane; `None` where nothing gets through.
    fn edge(&self, object_z: f64) -> Option<f64> {
        let passes = |y: f64| self.trace(object_z, y).is_some();
        // From a nanometer outward, doubling: 60 steps reach beyond any lens.
        let mut low = 1e-6;
        if !passes(low) {
            return None;
        }
        let mut high = low;
        for _ in 0..60 {
            high = 2.0 * low;
            if !passes(high) {
                break;
            }
            low = high;
        }
        let [low, _] = bisect([low, high], 50, passes);
        Some(low)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A fast biconvex lens, with much spherical aberration.
    const FAST: &str = "50 10 1.5168 30\n-50 2 1 30\n0 0 0 24\n";

    fn rms(prescription: &Prescription, film_distance: f64, distance: f64) -> f64 {
        let search = Search {
            tracer: LensTracer::new(&prescription.surfaces),
            length: prescription.length(),
            distance,
        };
        let object_z = search.length + film_distance - distance;
        let edge = search.edge(object_z).unwrap();
        let heights = (0..200).map(|i| {
            let out = search
                .trace(object_z, edge * ((f64::from(i) + 0.5) / 200.0).sqrt())
                .unwrap();
            let z = search.length + film_distance - out.o[2];
            out.o[1] + z * out.d[1] / out.d[2]
        });
        (heights.map(|h| h * h).sum::<f64>() / 200.0).sqrt()
    }

    #[test]
    fn no_other_film_gives_a_smaller_spot() {
        let p = Prescription::parse(FAST).unwrap();
        for distance in [300.0, 1000.0, f64::INFINITY] {
            let best = film_distance(&p, distance).unwrap();
            // Spherical aberration of a positive lens is undercorrected: nearer than Gaussian focus.
            assert!(best < Lens::focused(&p, distance).unwrap() - 0.1);
            // Moving the film, the object staying where it is: compare at the same object.
            let object = |film: f64| distance + (film - best);
            let least = rms(&p, best, distance);
            for shift in [-0.02, 0.02] {
                let moved = best + shift;
                assert!(rms(&p, moved, object(moved)) > least, "{distance} {shift}");
            }
        }
    }

    #[test]
    fn a_narrow_beam_has_gaussian_focus() {
        let mut p = Prescription::parse(FAST).unwrap();
        p.set_stops(0.01);
        for distance in [500.0, f64::INFINITY] {
            let best = film_distance(&p, distance).unwrap();
            // Longitudinal aberration goes with the square of the beam: 1e-7 of that of the full one.
            assert!((best - Lens::focused(&p, distance).unwrap()).abs() < 1e-6);
        }
    }

    #[test]
    fn what_has_no_gaussian_focus_has_no_best_one() {
        let p = Prescription::parse("-50 3 1.5 20\n50 0 1 20\n").unwrap();
        assert!(film_distance(&p, 1000.0).is_err());
        let p = Prescription::parse(FAST).unwrap();
        assert!(film_distance(&p, 10.0).is_err());
        assert!(film_distance(&p, f64::NAN).is_err());
    }
}
