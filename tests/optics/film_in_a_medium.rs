//! A film in glass or in the vitreous body of an eye: étendue in front of the lens is étendue at the film.
//!
//! Radiance over the squared index stays the same along a ray, so that a white sky puts n'²·∫cosθ dω on a film in a medium
//! of index n' (Boyd, *Radiometry and the Detection of Optical Radiation*, 1983, §5.1).

use crate::realistic_camera::{DGAUSS, camera, film, samples, spec};
use fstop::cameras::{
    BUNDLE, CameraSample, Form, Realistic, RealisticSpec, Weighting, pbrt_pupil_box,
};
use fstop::math::Vec2;
use fstop::optics::analysis::{Effort, Film, LensAnalysis, ObjectPlane};
use fstop::optics::models::ModelKind;
use fstop::optics::{Lens, LensRay, LensReport, Prescription};

/// Gullstrand's exact eye without accommodation, with a pupil of 4 mm (Atchison and Smith, *Optics of the Human Eye*,
/// 2000, appendix 3).
pub(crate) const EYE: &str = "7.7 0.5 1.376 11\n6.8 3.1 1.336 10\nstop 0 1.336 4\n10 0.546 1.386 8\n\
    7.911 2.419 1.406 7\n-5.76 0.635 1.386 7\n-6 17.187 1.336 8\n";

/// `text` with a film in a medium of this index, focused at infinity.
fn in_medium(text: &str, index: f64, stop: f64, form: Form) -> RealisticSpec {
    let mut prescription = Prescription::parse(text).unwrap();
    prescription.set_stops(stop);
    prescription.surfaces.last_mut().unwrap().index = index;
    let distance = Lens::focused(&prescription, f64::INFINITY).unwrap();
    let mut s = spec(text, stop, Some(distance), form);
    s.lens = Lens::new(&prescription, distance).unwrap();
    s
}

/// Étendue, mm² sr, of the rays from all around that land in the square of side `side` mm in the middle of the film, measured
/// where they enter the lens, within `radius` mm of the axis.
fn etendue_in(lens: &Lens, side: f64, radius: f64) -> f64 {
    const COUNT: u32 = 1 << 18;
    let front = &lens.surfaces()[0];
    let focal_length = lens.paraxial().cardinals.unwrap().focal_length;
    // The corner's direction, and room for distortion and the beam's blur.
    let sin_max = (1.2 * side * 0.5f64.sqrt() / focal_length).atan().sin();
    let mut sum = 0.0;
    for s in samples(COUNT, Vec2::ZERO, Vec2::ONE) {
        // A point of the first surface, even over its disk, and a direction by the cosine with the axis.
        let on_disk = |u: f32, turn: f32, radius: f64| {
            let (sin, cos) = (std::f64::consts::TAU * f64::from(turn)).sin_cos();
            let r = radius * f64::from(u).sqrt();
            [r * cos, r * sin]
        };
        let [x, y] = on_disk(s.raster.x, s.raster.y, radius);
        let [l, m] = on_disk(s.lens.x, s.lens.y, sin_max);
        let n = (1.0 - l * l - m * m).sqrt();
        let ray = LensRay::new([x, y, front.sag(x.hypot(y))], [l, m, n]);
        let Ok(out) = lens.tracer().to_film(&ray) else {
            continue;
        };
        let t = (lens.film_z() - out.o[2]) / out.d[2];
        let lands = (0..2).all(|i| (out.o[i] + t * out.d[i]).abs() <= 0.5 * side);
        // The normal of a sphere, of length 1: (−cx, −cy, 1 − cz).
        let c = front.curvature();
        let normal = [-c * x, -c * y, 1.0 - c * front.sag(x.hypot(y))];
        let cosine = l * normal[0] + m * normal[1] + n * normal[2];
        if lands && cosine > 0.0 {
            // dA = dx dy / N_z.
            sum += cosine / normal[2] / n;
        }
    }
    let area = std::f64::consts::PI * radius * radius;
    sum / f64::from(COUNT) * area * (std::f64::consts::PI * sin_max * sin_max)
}

/// What a square image of a white sky shows in the mean, by rays made one at a time and side by side.
fn white(camera: &Realistic, pixels: u32) -> [f64; 2] {
    const COUNT: u32 = 1 << 15;
    let all: Vec<CameraSample> = samples(COUNT, Vec2::ZERO, Vec2::splat(pixels as f32)).collect();
    let alone: f64 = all
        .iter()
        .filter_map(|s| camera.ray(s, false))
        .map(|r| f64::from(r.weight))
        .sum();
    let (mut rays, mut together) = ([None; BUNDLE], 0.0);
    for bundle in all.chunks(BUNDLE) {
        camera.rays(bundle, bundle[0].lens.x < 0.5, &mut rays);
        together += rays[..bundle.len()]
            .iter()
            .flatten()
            .map(|r| f64::from(r.weight))
            .sum::<f64>();
    }
    [alone, together].map(|sum| sum / f64::from(COUNT))
}

/// Both estimates have errors of some 1e-3.
const TOLERANCE: f64 = 5e-3;

#[test]
fn etendue_in_is_etendue_out() {
    let pixels = 16;
    for (text, stop, side, radius, index) in [
        (DGAUSS, 17.1, 20.0, 12.6, 1.0),
        (DGAUSS, 17.1, 20.0, 12.6, 1.336),
        (DGAUSS, 17.1, 20.0, 12.6, 1.5),
        (EYE, 4.0, 4.0, 3.4, 1.0),
        (EYE, 4.0, 4.0, 3.4, 1.336),
        (EYE, 4.0, 4.0, 3.4, 1.5),
    ] {
        let mut s = in_medium(text, index, stop, Form::Pbrt3);
        let expected = etendue_in(&s.lens, side, radius) / (side * side);
        for form in [Form::Course, Form::Pbrt3] {
            s.form = form;
            let film = film(pixels, pixels, side * 2f64.sqrt());
            for found in white(&camera(&s, &film), pixels) {
                assert!(
                    (found / expected - 1.0).abs() < TOLERANCE,
                    "{form:?} {index}: {found} {expected}"
                );
            }
        }
    }
}

/// `simpleweighting` is relative to the middle of the image, as pbrt-v3's is: a white sky shows at most 1 whatever the
/// medium, and it differs from the physical weight by one constant.
#[test]
fn simple_weights_are_relative_whatever_the_medium() {
    for index in [1.0, 1.336, 1.5] {
        let mut s = in_medium(EYE, index, 4.0, Form::Pbrt3);
        let film = film(16, 16, 4.0);
        let physical = white(&camera(&s, &film), 16);
        s.weighting = Weighting::Simple;
        let simple = camera(&s, &film);
        let brightest = samples(4096, Vec2::ZERO, Vec2::splat(16.0))
            .filter_map(|s| simple.ray(&s, false))
            .fold(0.0, |max, r| f32::max(max, r.weight));
        assert!(brightest <= 1.0 + 1e-6 && brightest > 0.7, "{brightest}");
        let area = pbrt_pupil_box::innermost_box_area(&s.lens, 4.0);
        let constant = s.lens.film_distance().powi(2) / (area * index * index);
        for (simple, physical) in white(&simple, 16).into_iter().zip(physical) {
            // Rounding of single precision.
            assert!((simple / physical / constant - 1.0).abs() < 1e-5);
        }
    }
}

/// Next to the axis and stopped down the paraxial models are the lens.
#[test]
fn the_models_have_the_light_of_the_lens() {
    for (text, stop, side) in [(DGAUSS, 2.0, 1.0), (EYE, 0.5, 0.4)] {
        for index in [1.0, 1.336, 1.5] {
            let mut s = in_medium(text, index, stop, Form::Course);
            let film = film(8, 8, side);
            let paraxial = s.lens.paraxial();
            // A parallel beam of the entrance pupil's area over the film area that a unit of solid angle is imaged on.
            let focal_length = paraxial.cardinals.unwrap().focal_length;
            let beam = paraxial.entrance_pupil.unwrap().diameter / focal_length;
            let expected = 0.25 * std::f64::consts::PI * beam * beam;
            for kind in [ModelKind::Exact, ModelKind::Thick, ModelKind::Thin] {
                s.model = kind;
                for found in white(&camera(&s, &film), 8) {
                    assert!(
                        (found / expected - 1.0).abs() < TOLERANCE,
                        "{kind} {index}: {found} {expected}"
                    );
                }
            }
        }
    }
}

/// A small image of a lens in glass by `thick` and `thin` has the directions of the exact one.
#[test]
fn the_models_look_where_the_lens_looks() {
    for index in [1.0, 1.336, 1.5] {
        let mut s = in_medium(EYE, index, 0.05, Form::Course);
        let film = film(64, 64, 0.5);
        let exact = camera(&s, &film);
        for kind in [ModelKind::Thick, ModelKind::Thin] {
            s.model = kind;
            let model = camera(&s, &film);
            let mut compared = 0;
            for sample in samples(500, Vec2::ZERO, Vec2::splat(64.0)) {
                let (Some(a), Some(b)) = (exact.ray(&sample, false), model.ray(&sample, false))
                else {
                    continue;
                };
                compared += 1;
                // In pixels. Distortion at a hundredth of the focal length is some 1e-4 of it, and the thin lens' stop lies
                // elsewhere: 0.05 mm of it through 1 / 17 mm of power are canceled by focus.
                let focal_length = s.lens.paraxial().cardinals.unwrap().focal_length;
                let pitch = 0.5 / 2f64.sqrt() / 64.0;
                let off = f64::from((a.ray.d - b.ray.d).length()) * focal_length / pitch;
                assert!(off < 0.05, "{kind} {index}: {off}");
            }
            assert!(compared > 300, "{compared}");
        }
    }
}

#[test]
fn the_f_number_counts_the_index_at_the_film() {
    // The same beam and the same focal length in front: f/D whatever the medium, for an aplanatic lens.
    for index in [1.0, 1.336, 1.5] {
        let s = in_medium(EYE, index, 1.0, Form::Course);
        let analysis = LensAnalysis::new(
            &s.lens,
            Film::of_diagonal(2.0),
            ObjectPlane::INFINITY,
            &Effort {
                fields: 2,
                rays_across: 16,
                pupil_samples: 1 << 12,
            },
        );
        let paraxial = LensReport::new(&s.lens).f_number.unwrap();
        let effective = analysis.effective_f_number.unwrap();
        // f/15: spherical aberration and the sine are some 1e-3.
        assert!(
            (effective / paraxial - 1.0).abs() < TOLERANCE,
            "{effective} {paraxial}"
        );
    }
}

/// The pinhole that shows the same near the axis: film height over the tangent of the angle at which the chief ray comes in.
#[test]
fn a_pinhole_shows_what_a_lens_before_glass_does() {
    let prescription = Prescription::parse("51.68 0 1.5168 20\n").unwrap();
    let distance = Lens::focused(&prescription, 2000.0).unwrap();
    let lens = Lens::new(&prescription, distance).unwrap();
    let pinhole = lens.pinhole_focal_length().unwrap();
    // The stop is the surface itself, in air: by Snell's law the angle behind it is that in front of it over the index.
    let expected = distance / 1.5168;
    assert!(
        (pinhole / expected - 1.0).abs() < 1e-12,
        "{pinhole} {expected}"
    );
}
