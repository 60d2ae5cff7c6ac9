//! Ray aberration curves: how far the rays of a fan land from the chief ray.

use super::beam::Beam;
use crate::optics::lens::Lens;
use serde::Serialize;

/// Transverse ray aberrations of one object point. Pupil coordinates are relative to half the height of the axial
/// beam, so that curves of vignetted beams are shorter.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Fan {
    /// Film height of the chief ray, mm.
    pub height: f64,
    /// \[pupil coordinate, y error in mm\] of rays in the meridional plane.
    pub tangential: Vec<[f64; 2]>,
    /// \[pupil coordinate, x error in mm\] of rays across it.
    pub sagittal: Vec<[f64; 2]>,
}

/// Rays of a fan.
const RAYS: usize = 128;

impl Fan {
    /// Of `beam`; `axial_radius` is half the height of the axial one.
    pub fn trace(lens: &Lens, beam: &Beam, axial_radius: f64) -> Fan {
        let fan = |axis: usize| {
            let [low, high] = beam.extent[axis];
            let error = |i: usize| {
                let mut p = [0.0; 2];
                p[axis] = low + (high - low) * i as f64 / RAYS as f64;
                let at = beam.on_film(lens, p)?;
                let error = [at[0], at[1] - beam.chief.height];
                Some([p[axis] / axial_radius, error[axis]])
            };
            (0..=RAYS).filter_map(error).collect()
        };
        Fan {
            height: beam.chief.height,
            tangential: fan(1),
            sagittal: fan(0),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::optics::analysis::{ChiefFinder, ObjectPlane};
    use crate::optics::{ExitPupil, Prescription};

    #[test]
    fn a_parabola_of_defocus_is_a_straight_line() {
        // A weak thin lens, f = 1000, stop 2 mm; the film 10 mm inside the focus: every ray is off by
        // its height times 10/1000, and the pupil is the stop.
        let p = Prescription::parse("0 1e-9 0 2\n500 1e-9 1.5 20\ninf 0 1 20\n").unwrap();
        let lens = Lens::new(&p, 990.0).unwrap();
        let pupil = ExitPupil::new(&lens, 1.0, 8);
        let chief = ChiefFinder::new(&lens).find(0.0).unwrap();
        let beam = Beam::new(&lens, &pupil, &chief, ObjectPlane::INFINITY).unwrap();
        // The rectangle is a few per cent larger than the beam.
        assert!(
            (beam.half_height() - 1.0).abs() < 0.1,
            "{}",
            beam.half_height()
        );
        let fan = Fan::trace(&lens, &beam, 1.0);
        assert!(fan.tangential.len() > 100);
        for [x, error] in fan.tangential.iter().chain(&fan.sagittal) {
            // Spherical aberration, some y³/f².
            assert!((error - x * 0.01).abs() < 5e-6, "{x} {error}");
        }
    }
}
