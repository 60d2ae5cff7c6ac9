//! Contrast of one object point's image: against frequency, and through focus.
//!
//! By rays it is the Fourier transform of the spot ([`Spot::mtf`]), by waves the autocorrelation of the pupil ([`Wavefront`]). Both are
//! negative where black and white change places: spurious resolution is no contrast.

use super::beam::Beam;
use super::contrast::{Follower, STEP};
use super::spot::Spot;
use super::wavefront::Wavefront;
use crate::optics::LensRay;
use crate::optics::lens::Lens;
use serde::Serialize;

/// Line pairs per mm of the curve through focus.
pub const THROUGH_FOCUS_FREQUENCY: f64 = 30.0;
/// The largest frequency of the curves, line pairs per mm: that of pixels of 5 µm.
pub const LARGEST_FREQUENCY: f64 = 100.0;

/// Contrast at \[a frequency or a shift, sagittal, tangential\].
pub type Contrast = [f64; 3];

/// The curves of one field point.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct MtfCurves {
    /// Film height of the chief ray, mm.
    pub height: f64,
    /// By rays alone, line pairs per mm.
    pub geometric: Vec<Contrast>,
    /// By waves of the d line: \[line pairs per mm, contrast\] across the meridional plane. Empty where too few rays arrive.
    pub wave_sagittal: Vec<[f64; 2]>,
    /// The same along it.
    pub wave_tangential: Vec<[f64; 2]>,
    /// At [`THROUGH_FOCUS_FREQUENCY`], by rays, shifts in mm behind the film.
    pub through_focus: Vec<Contrast>,
    /// Root mean square error of the wavefront about the spot's centroid, waves of the d line.
    pub wavefront_rms: Option<f64>,
}

/// Rays across a beam.
const ACROSS: usize = 64;
/// Cells of the wavefront: fine along the axis at hand, coarse across.
const CELLS: [usize; 2] = [96, 24];

impl MtfCurves {
    /// Of a beam.
    pub fn new(lens: &Lens, beam: &Beam) -> MtfCurves {
        let rays = beam.rays_at_film(lens, ACROSS);
        let spot = Spot::behind(&rays, 0.0);
        let count = (LARGEST_FREQUENCY / STEP) as usize;
        let curve = spot.contrasts(STEP, count).into_iter().enumerate();
        let geometric = curve.map(|(i, [s, t])| [i as f64 * STEP, s, t]).collect();
        // As far as a perfect lens of that aperture takes to lose all contrast, or the spot's own blur.
        let reach = reach(&rays, &spot);
        let about = spot.centroid();
        let wave = |axis: usize| {
            let size = [CELLS[axis], CELLS[1 - axis]];
            Wavefront::new(lens, beam, about, size)
        };
        let waves = [wave(0), wave(1)];
        let curve = |axis: usize| {
            waves[axis]
                .as_ref()
                .map_or_else(Vec::new, |w| by_waves(w, axis))
        };
        MtfCurves {
            height: beam.chief.height,
            geometric,
            wave_sagittal: curve(0),
            wave_tangential: curve(1),
            through_focus: through_focus(&rays, reach),
            wavefront_rms: waves[0].as_ref().map(Wavefront::rms),
        }
    }
}

/// At [`THROUGH_FOCUS_FREQUENCY`], up to `reach` mm before and behind the film. Contrast is followed from frequency zero on where there
/// is most, and from there to either side.
fn through_focus(rays: &[LensRay<f64>], reach: f64) -> Vec<Contrast> {
    let shifts: Vec<f64> = (-20..=20).map(|i| reach * f64::from(i) / 20.0).collect();
    let spots: Vec<Spot> = shifts.iter().map(|s| Spot::behind(rays, *s)).collect();
    let transfers: Vec<_> = spots
        .iter()
        .map(|spot| spot.transfer(THROUGH_FOCUS_FREQUENCY))
        .collect();
    let curve = |axis: usize| -> Vec<f64> {
        let at = |i: usize| transfers[i][axis];
        let size = |i: &usize| at(*i)[0].hypot(at(*i)[1]);
        let most = (0..spots.len()).max_by(|i, j| size(i).total_cmp(&size(j)));
        let most = most.unwrap_or_default();
        let mut contrast = vec![0.0; spots.len()];
        contrast[most] = spots[most].mtf(THROUGH_FOCUS_FREQUENCY)[axis];
        let start = Follower::starting_at(at(most), contrast[most]);
        let mut follow = |sides: &mut dyn Iterator<Item = usize>| {
            let mut follower = start;
            sides.for_each(|i| contrast[i] = follower.next(at(i)));
        };
        follow(&mut (0..most).rev());
        follow(&mut (most + 1..spots.len()));
        contrast
    };
    let [sagittal, tangential] = [curve(0), curve(1)];
    (0..shifts.len())
        .map(|i| [shifts[i], sagittal[i], tangential[i]])
        .collect()
}

fn by_waves(wavefront: &Wavefront, axis: usize) -> Vec<[f64; 2]> {
    let curve = wavefront.frequencies(axis).zip(wavefront.transfer(axis));
    // One beyond the largest, for the curve to continue to the end.
    let mut beyond = false;
    let shown = curve.take_while(|(f, _)| !std::mem::replace(&mut beyond, *f > LARGEST_FREQUENCY));
    shown.map(|(f, contrast)| [f, contrast]).collect()
}

/// How far through focus to look, mm: where defocus alone blurs a point to a line pair and a half, and the spot's blur is as wide.
fn reach(rays: &[LensRay<f64>], spot: &Spot) -> f64 {
    let slopes = rays.iter().map(|r| r.d[0].abs() / r.d[2].abs());
    let steepest = slopes.fold(0.0, f64::max);
    let blur = 1.5 / THROUGH_FOCUS_FREQUENCY + 2.0 * spot.rms_radius();
    Some(blur / (2.0 * steepest))
        .filter(|r| r.is_finite())
        .unwrap_or(1.0)
        .min(20.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::optics::analysis::{ChiefFinder, ObjectPlane};
    use crate::optics::{ExitPupil, Prescription};

    #[test]
    fn contrast_through_focus_is_that_of_a_disc_and_turns_over() {
        // A surface that images perfectly (Descartes' ellipsoid) of n = 1.5 and f' = 60: 1 mm off, the blur is a disc of radius r = tan u' mm whose
        // transfer is 2 J1(x)/x, x = 2πνr: zero at x = 3.8317, −0.1323 at 5.1356.
        let conic = -1.0 / (1.5f64 * 1.5);
        let text = format!("0 0 0 6\n20 0 1.5 40 k={conic}\n");
        let lens = Lens::new(&Prescription::parse(&text).unwrap(), 60.0).unwrap();
        let pupil = ExitPupil::new(&lens, 1.0, 8);
        let chief = ChiefFinder::new(&lens).find(0.0).unwrap();
        let beam = Beam::new(&lens, &pupil, &chief, ObjectPlane::INFINITY).unwrap();
        let curves = MtfCurves::new(&lens, &beam);
        assert!(curves.geometric.iter().all(|c| (c[1] - 1.0).abs() < 1e-9));
        // Where waves are: f/6.7 in air, whose cut-off is 255 lp/mm; linear to 4/π of its part.
        let near = curves.wave_sagittal.iter().find(|w| w[0] > 40.0).unwrap();
        let expected = 1.0 - 1.27 * near[0] * 588e-6 * 60.0 / (1.5 * 6.0);
        assert!((near[1] - expected).abs() < 0.02, "{near:?} {expected}");
        assert!(curves.wavefront_rms.unwrap() < 1e-6);
        // The rim is at tan u' = 3/60, but for the surface's sag.
        let [shift, _, _] = curves.through_focus[40];
        let x = std::f64::consts::TAU * THROUGH_FOCUS_FREQUENCY * shift * 0.05;
        assert!(x > 3.9, "{x}");
        let ends = [curves.through_focus[0], curves.through_focus[40]];
        for [_, s, t] in ends {
            // Beyond the first zero, symmetric about focus but for the sag.
            assert!(s < -0.02 && (s - t).abs() < 5e-3, "{ends:?}");
        }
        assert!((curves.through_focus[20][1] - 1.0).abs() < 1e-9);
    }
}
