//! Lens files, and what a camera does with a lens that could be read.

use fstop::optics::prescription::{self as files, Glasses, agf, decode};
use fstop::optics::{ExitPupil, Lens, LensReport, Prescription};

/// mm behind the last vertex, where a file does not say.
const FILM_DISTANCE: f64 = 40.0;

pub(super) fn dat(bytes: &[u8]) {
    look_through(Prescription::parse(&String::from_utf8_lossy(bytes)).ok());
}

pub(super) fn zmx(bytes: &[u8]) {
    look_through(files::zmx::parse(&decode(bytes), &Glasses::COMMON).ok());
}

pub(super) fn seq(bytes: &[u8]) {
    look_through(files::seq::parse(&decode(bytes), &Glasses::COMMON).ok());
}

pub(super) fn len(bytes: &[u8]) {
    look_through(files::oslo::parse(&decode(bytes), &Glasses::COMMON).ok());
}

pub(super) fn optbench(bytes: &[u8]) {
    look_through(files::optbench::parse(&decode(bytes), &Glasses::COMMON).ok());
}

/// ISET's and optiland's.
pub(super) fn json(bytes: &[u8]) {
    let text = decode(bytes);
    look_through(files::json::parse(&text).ok());
    look_through(files::optiland::parse(&text, &Glasses::COMMON).ok());
}

pub(super) fn glasses(bytes: &[u8]) {
    for glass in agf::parse(&decode(bytes)).values() {
        assert!(glass.index >= 1.0 && glass.index.is_finite());
    }
}

fn look_through(prescription: Option<Prescription>) {
    let Some(prescription) = prescription else {
        return;
    };
    // Whether it can be focused is its own affair.
    let focused = Lens::focused(&prescription, 2000.0).unwrap_or(FILM_DISTANCE);
    let stated = prescription.film_distance;
    for film_distance in [focused, if stated > 0.0 { stated } else { FILM_DISTANCE }] {
        let Ok(lens) = Lens::new(&prescription, film_distance) else {
            continue;
        };
        let _ = LensReport::new(&lens);
        let pupil = ExitPupil::new(&lens, 20.0, 2);
        for i in 0..8 {
            let at = f64::from(i) / 8.0;
            let Some(sample) = pupil.sample([20.0 * at, 0.0], [at as f32, 0.3].into()) else {
                continue;
            };
            let traced = lens.trace_from_film([20.0 * at, 0.0], sample.point);
            let finite = |ray: &fstop::optics::LensRay<f64>| {
                ray.o.iter().chain(&ray.d).all(|x| x.is_finite())
            };
            assert!(traced.is_err() || traced.as_ref().is_ok_and(finite));
        }
    }
}
