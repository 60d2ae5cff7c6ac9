//! Depth of field: between which planes the blur on the film is below a limit.
//!
//! By the paraxial cone from the exit pupil: each end of the depth of focus behind the lens is the image of one end of the depth of field
//! (Ray, *Applied Photographic Optics*, 3rd edition, chapter 22).

use super::focus;
use super::lens::Lens;

/// Planes of a lens at its focus, by their distance from the film, mm.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DepthOfField {
    /// The nearest plane that is still sharp; 0 where the pupil is no wider than the blur.
    pub near: f64,
    /// The farthest; infinite beyond the hyperfocal distance.
    pub far: f64,
    /// The nearest focus that leaves infinity sharp; infinite for a lens that is never so, `None` for one focused through its pupil.
    pub hyperfocal: Option<f64>,
}

/// Of `lens` with the film `film_distance` mm behind it, for a blur of `circle` mm across; `None` without cardinal points or an exit
/// pupil.
pub fn depth_of_field(lens: &Lens, film_distance: f64, circle: f64) -> Option<DepthOfField> {
    let cardinals = lens.paraxial().cardinals?;
    let pupil = lens.paraxial().exit_pupil?;
    let film_z = lens.length() + film_distance;
    // To the plane that is sharp on a film so far behind the lens.
    let conjugate = |distance: f64| {
        let from_film = |z: f64| film_z - z;
        focus::plane_of_focus(&cardinals, distance).map_or(f64::INFINITY, from_film)
    };
    let away = (film_z - pupil.z).abs();
    // The planes whose cones are `circle` wide where the film is.
    let toward = circle * away / (pupil.diameter + circle);
    let behind = (pupil.diameter > circle).then(|| circle * away / (pupil.diameter - circle));
    Some(DepthOfField {
        near: behind.map_or(0.0, |shift| conjugate(film_distance + shift)),
        far: conjugate(film_distance - toward),
        hyperfocal: hyperfocal(lens, circle),
    })
}

/// The film that is `circle` blurred by what is infinitely far: q − b = k (q − e), with b the back focal distance, e the exit pupil's
/// distance behind the last vertex and k = c/(D + c).
fn hyperfocal(lens: &Lens, circle: f64) -> Option<f64> {
    let cardinals = lens.paraxial().cardinals?;
    let pupil = lens.paraxial().exit_pupil?;
    let k = circle / (pupil.diameter + circle);
    let exit = pupil.z - lens.length();
    let distance = (cardinals.back_focal_distance - k * exit) / (1.0 - k);
    let z = focus::plane_of_focus(&cardinals, distance)?;
    (distance > exit).then(|| lens.length() + distance - z)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::optics::Prescription;

    const CIRCLE: f64 = 0.03;

    /// A thin lens with the stop at it: f = 50, N = 2; H = f²/(N c) + f from the lens (Ray, chapter 22).
    #[test]
    fn a_thin_lens_has_the_textbooks_depth() {
        let p = Prescription::parse("0 0 0 25\n50 0 2 25.1\ninf 0 1 30\n").unwrap();
        let (f, n) = (50.0, 2.0);
        let h = f * f / (n * CIRCLE) + f;
        for v in [50.5, 51.0, 55.0] {
            let lens = Lens::new(&p, v).unwrap();
            let s = f * v / (v - f);
            let depth = depth_of_field(&lens, lens.film_distance(), CIRCLE).unwrap();
            assert!((depth.near - v - s * (h - f) / (h + s - 2.0 * f)).abs() < 1e-6 * s);
            assert!((depth.far - v - s * (h - f) / (h - s)).abs() < 1e-6 * s);
            let from_lens = depth.hyperfocal.unwrap();
            // The film behind a lens focused at H: f H/(H − f).
            assert!(
                (from_lens - h - f * h / (h - f)).abs() < 1e-6 * h,
                "{from_lens}"
            );
        }
    }

    /// At the hyperfocal distance the far end is infinity, and half of it is the near one (measured from the lens, thin).
    #[test]
    fn focused_at_the_hyperfocal_distance_infinity_is_sharp() {
        let root = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/golden/dgauss_50.dat");
        let mut p = Prescription::read(root.as_ref()).unwrap();
        p.set_stops(4.0);
        let at = |distance| {
            let lens = Lens::new(&p, Lens::focused(&p, distance).unwrap()).unwrap();
            depth_of_field(&lens, lens.film_distance(), CIRCLE)
        };
        let h = at(3000.0).unwrap().hyperfocal.unwrap();
        for (part, infinite) in [(1.0 + 1e-9, true), (1.0 - 1e-4, false)] {
            let far = at(part * h).unwrap().far;
            // Beyond a thousand kilometers it is infinite within rounding.
            assert_eq!(far > 1e9, infinite, "{far}");
        }
    }
}
