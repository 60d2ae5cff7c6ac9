//! Laws of the realistic camera, on lenses small enough to reason about and on measured images.

use fstop::cameras::{
    BUNDLE, Band, CameraSample, Clip, Compat, FilmGeometry, Form, Realistic, RealisticSpec,
    Shutter, Weighting,
};
use fstop::math::transform::Transform;
use fstop::math::{DVec3, UVec2, Vec2, Vec3};
use fstop::optics::models::ModelKind;
use fstop::optics::pupil::PupilSampling;
use fstop::optics::{Lens, Prescription};

/// The double Gauss of the course, its stop open.
pub(crate) const DGAUSS: &str = "29.475 3.76 1.67 25.2\n84.83 0.12 1 25.2\n19.275 4.025 1.67 23\n\
    40.77 3.275 1.699 23\n12.75 5.705 1 18\n0 4.5 0 17.1\n-14.495 1.18 1.603 17\n\
    40.77 6.065 1.658 20\n-20.385 0.19 1 20\n437.065 3.22 1.717 20\n-39.73 0 1 20\n";

/// The sample lens of docs/scene-language.md §6.6.
const SAMPLE: &str = "35 6 1.5168 24\n-90 4 1 24\n0 10 0 12\n60 5 1.62 22\n-45 20 1 22\n";

pub(crate) fn spec(text: &str, stop: f64, film_distance: Option<f64>, form: Form) -> RealisticSpec {
    let mut prescription = Prescription::parse(text).unwrap();
    prescription.set_stops(stop);
    let distance = film_distance.unwrap_or_else(|| Lens::focused(&prescription, 1000.0).unwrap());
    RealisticSpec {
        lens_name: "singlet.dat".to_string(),
        nominal_focal_length: None,
        lens: Lens::new(&prescription, distance).unwrap(),
        form,
        weighting: Weighting::Physical,
        compat: Compat::None,
        pupil_sampling: PupilSampling::default(),
        model: Default::default(),
        precision: Default::default(),
        stop_shape: None,
        bands: Vec::new(),
        ghosts: false,
        coating: None,
        film_diagonal: None,
        shutter: Shutter::default(),
        shift: [0.0; 2],
        tilt: [0.0; 2],
        autofocus: None,
        exposure: Default::default(),
        clip: Clip::NONE,
    }
}

pub(crate) fn film(x: u32, y: u32, diagonal_mm: f64) -> FilmGeometry {
    FilmGeometry {
        resolution: UVec2::new(x, y),
        diagonal_mm,
    }
}

pub(crate) fn camera(spec: &RealisticSpec, film: &FilmGeometry) -> Realistic {
    Realistic::new(spec, film, &Transform::IDENTITY).unwrap()
}

/// Well-spread samples of the pixels from `low` to `high` and of the lens.
pub(crate) fn samples(count: u32, low: Vec2, high: Vec2) -> impl Iterator<Item = CameraSample> {
    (0..count).map(move |i| {
        // The four-dimensional R sequence (Roberts 2018).
        let r = |k: i32| (0.5 + f64::from(i) / 1.167_303_978_261_418_7f64.powi(k)).fract() as f32;
        CameraSample {
            raster: low + Vec2::new(r(1), r(2)) * (high - low),
            time: 0.5,
            lens: Vec2::new(r(3), r(4)),
            wavelength: 0.5,
        }
    })
}

/// What the pixels from `low` to `high` show of a white scene.
fn white(camera: &Realistic, count: u32, low: Vec2, high: Vec2) -> f64 {
    let weights = samples(count, low, high)
        .filter_map(|s| camera.ray(&s, false))
        .map(|r| f64::from(r.weight));
    weights.sum::<f64>() / f64::from(count)
}

fn white_pixel(camera: &Realistic, x: u32, y: u32) -> f64 {
    let low = UVec2::new(x, y).as_vec2();
    white(camera, 1 << 13, low, low + Vec2::ONE)
}

#[test]
fn agrees_with_pbrt_on_a_white_scene() {
    // docs/scene-language.md §6.6: means of pbrt-v3 images of a white surrounding, whose flat spectrum has
    // Y = 0.99788 there (A.3). Printed to four and three digits.
    const FLAT: f64 = 0.99788;
    let film = film(33, 22, 43.2666);
    let mean = |s: &RealisticSpec| {
        FLAT * white(
            &camera(s, &film),
            1 << 16,
            Vec2::ZERO,
            Vec2::new(33.0, 22.0),
        )
    };
    for (stop, meters, weighting, expected) in [
        (8.0, 10.0, Weighting::Simple, 0.5399),
        (8.0, 1.0, Weighting::Physical, 0.0613),
        (30.0, 1.0, Weighting::Simple, 0.5384),
    ] {
        let mut prescription = Prescription::parse(SAMPLE).unwrap();
        prescription.set_stops(stop);
        let distance = Lens::focused(&prescription, 1000.0 * meters).unwrap();
        let mut s = spec(SAMPLE, stop, Some(distance), Form::Pbrt3);
        s.weighting = weighting;
        let found = mean(&s);
        // Rounding of the printed value, and the sampling error of both.
        assert!((found / expected - 1.0).abs() < 3e-3, "{found} {expected}");
    }
}

#[test]
fn a_small_stop_behind_a_thin_lens_gives_the_cos4_law() {
    // The stop, 2 mm across, is the last surface, so it is its own exit pupil: from a film point at
    // distance Z and field angle θ it fills the projected solid angle A·cos⁴θ/Z² up to the variation
    // of cos⁴θ/Z² over the stop, some (r/Z)² = 4e-4.
    let text = "100 1 1.5 40\n-100 1 1 40\n0 0 0 2\n";
    let (z, diagonal) = (50.0, 60.0);
    let s = spec(text, 2.0, Some(z), Form::Course);
    let c = camera(&s, &film(300, 300, diagonal));
    let area = std::f64::consts::PI;
    let side = diagonal / 2f64.sqrt();
    for x in [150u32, 180, 220, 260, 299] {
        let r = (f64::from(x) + 0.5 - 150.0) / 300.0 * side;
        let cos2 = z * z / (z * z + r * r);
        let expected = area / (z * z) * cos2 * cos2;
        let found = white_pixel(&c, x, 150);
        // 4e-4 of the stop's size, and the sampling error of 2^13 well-spread samples.
        assert!(
            (found / expected - 1.0).abs() < 2e-3,
            "{x}: {found} {expected}"
        );
    }
}

#[test]
fn the_image_is_upright() {
    // A film point right of and above the image's middle looks right and up, in both forms.
    for form in [Form::Course, Form::Pbrt3] {
        let c = camera(&spec(DGAUSS, 5.0, None, form), &film(200, 100, 35.0));
        let ray = |x, y| {
            let s = CameraSample {
                raster: Vec2::new(x, y),
                time: 0.0,
                lens: Vec2::splat(0.5),
                wavelength: 0.5,
            };
            c.ray(&s, false).unwrap().ray
        };
        let middle = ray(100.0, 50.0);
        assert!((middle.d - Vec3::Z).length() < 1e-6);
        assert!(ray(150.0, 50.0).d.x > 0.1 && ray(150.0, 50.0).d.y.abs() < 1e-6);
        assert!(ray(100.0, 10.0).d.y > 0.1);
    }
}

#[test]
fn pupil_sampling_changes_noise_only() {
    let mut s = spec(DGAUSS, 17.1, Some(36.77), Form::Course);
    let film = film(60, 40, 43.2666);
    let mut means = [
        PupilSampling::Concentric,
        PupilSampling::Polar,
        PupilSampling::Rejection,
    ]
    .map(|sampling| {
        s.pupil_sampling = sampling;
        white(
            &camera(&s, &film),
            1 << 16,
            Vec2::ZERO,
            Vec2::new(60.0, 40.0),
        )
    });
    means.sort_by(f64::total_cmp);
    // Weights scatter by some 40 % over the image: rejection's 2^16 samples, which are no longer
    // well spread, leave 1.6e-3 at most, of which this is three.
    assert!(means[2] / means[0] - 1.0 < 5e-3, "{means:?}");
}

#[test]
fn both_forms_make_the_same_image() {
    // The same rays, in millimeters from the front vertex or in meters from the film.
    let film = film(64, 48, 35.0);
    let (a, b) = (
        spec(DGAUSS, 8.0, Some(37.0), Form::Course),
        spec(DGAUSS, 8.0, Some(37.0), Form::Pbrt3),
    );
    let front = a.lens.film_z() as f32;
    let (a, b) = (camera(&a, &film), camera(&b, &film));
    for s in samples(500, Vec2::ZERO, Vec2::new(64.0, 48.0)) {
        match (a.ray(&s, false), b.ray(&s, false)) {
            (Some(a), Some(b)) => {
                assert_eq!((a.weight, a.ray.d), (b.weight, b.ray.d));
                assert!((1000.0 * b.ray.o - Vec3::Z * front - a.ray.o).length() < 1e-4);
            }
            (None, None) => {}
            other => panic!("{other:?}"),
        }
    }
}

#[test]
fn the_kits_disk_loses_what_its_habits_lose() {
    // With compatibility on, fewer samples count, and those that do weigh A·cos⁴θ/Z² with A the
    // area of the rear element.
    let film = film(300, 300, 40.0);
    let mut s = spec(DGAUSS, 17.1, Some(36.77), Form::Course);
    let truth = camera(&s, &film);
    s.compat = Compat::PbrtV2;
    let kit = camera(&s, &film);
    let axis = CameraSample {
        raster: Vec2::splat(150.0),
        time: 0.0,
        lens: Vec2::splat(0.5),
        wavelength: 0.5,
    };
    let expected = std::f64::consts::PI * 100.0 / 36.77f64.powi(2);
    let found = f64::from(kit.ray(&axis, false).unwrap().weight);
    assert!((found / expected - 1.0).abs() < 1e-6);
    let whole = Vec2::splat(300.0);
    let (truth, kit) = (
        white(&truth, 1 << 16, Vec2::ZERO, whole),
        white(&kit, 1 << 16, Vec2::ZERO, whole),
    );
    // The kit's references are 1.5 % darker (../shared measurements); here the film is smaller.
    assert!(kit < truth && kit > 0.95 * truth, "{kit} {truth}");
}

#[test]
fn hither_and_yon_cut_the_ray() {
    let mut s = spec(DGAUSS, 5.0, None, Form::Course);
    s.clip = Clip {
        hither: 100.0,
        yon: 900.0,
    };
    let c = camera(&s, &film(100, 100, 35.0));
    let sample = CameraSample {
        raster: Vec2::new(80.0, 30.0),
        time: 0.0,
        lens: Vec2::splat(0.5),
        wavelength: 0.5,
    };
    let ray = c.ray(&sample, false).unwrap().ray;
    assert!((ray.o.z - 100.0).abs() < 1e-4);
    assert!((ray.at(ray.t_max).z - 900.0).abs() < 1e-3);
}

#[test]
fn the_report_says_what_was_set() {
    let film = film(300, 300, 70.0);
    let mut s = spec(DGAUSS, 17.1, Some(36.77), Form::Course);
    let text = camera(&s, &film).describe(&film).join("\n");
    assert!(
        text.contains("focal length 50.358 mm, effective f/2.04 (stop 17.1 mm)"),
        "{text}"
    );
    assert!(
        text.contains("36.7700 mm behind the last surface"),
        "{text}"
    );
    assert!(!text.contains("model"), "{text}");
    assert!(camera(&s, &film).warnings().is_empty());
    s.model = ModelKind::Thick;
    let text = camera(&s, &film).describe(&film).join("\n");
    assert!(text.contains("the lens model `thick`"), "{text}");
    let near = spec(DGAUSS, 17.1, Some(30.0), Form::Course);
    assert!(camera(&near, &film).warnings()[0].contains("no object"));
    // A stop 60 mm in front of a lens of 50 mm: near objects lie between them.
    let text = "0 60 0 40\n50 5 1.5 30\n-50 0 1 30\n";
    let inside = spec(text, 20.0, Some(500.0), Form::Course);
    assert!(camera(&inside, &film).warnings()[0].contains("inside itself"));
}

/// Two rims of 10 and 8 mm in front of a wider stop: the stop alone would give f/5, the light is that of the narrower rim.
#[test]
fn the_f_number_is_that_of_the_light() {
    let text = "0 1e-9 0 20\n50 1e-9 1.5 8\ninf 0 1 26\n";
    let mut s = spec(text, 20.0, Some(100.0), Form::Course);
    let film = film(30, 20, 20.0);
    let said = |s: &RealisticSpec| camera(s, &film).describe(&film).join("\n");
    // 100 mm over 8 mm; the sine of the small angle is 1e-3 less than its tangent.
    assert!(said(&s).contains("f/12.5"), "{}", said(&s));
    s.compat = Compat::PbrtV2;
    assert!(said(&s).contains("f/12."), "{}", said(&s));
    // Through a scale a stop of 26.1 mm becomes 26.099999999999998 mm, and is said to be 26.1 mm.
    s.lens = Lens::new(
        &Prescription::parse("0 0 0 26.099999999999998\n").unwrap(),
        50.0,
    )
    .unwrap();
    assert!(said(&s).contains("(stop 26.1 mm)"), "{}", said(&s));
}

/// A pinhole of a nanometer lets through as much light for its area as one of a millimeter.
#[test]
fn the_smallest_stops_lose_no_light() {
    for stop in [1.0, 1e-2, 1e-3, 3e-4, 1e-4, 1e-5, 1e-6] {
        let s = spec(DGAUSS, stop, Some(36.77), Form::Course);
        let film = film(8, 8, 4.0);
        let c = camera(&s, &film);
        let all: Vec<CameraSample> = samples(1 << 12, Vec2::ZERO, Vec2::splat(8.0)).collect();
        let mut rays = [None; BUNDLE];
        let mut sum = 0.0;
        for bundle in all.chunks(BUNDLE) {
            c.rays(bundle, false, &mut rays);
            sum += rays[..bundle.len()]
                .iter()
                .flatten()
                .map(|r| f64::from(r.weight))
                .sum::<f64>();
        }
        let pupil = s.lens.paraxial().exit_pupil.unwrap();
        let away = s.lens.film_z() - pupil.z;
        let expected = std::f64::consts::PI * (0.5 * pupil.diameter / away).powi(2);
        let found = sum / all.len() as f64;
        // The corner's cos⁴ is 0.4 % less, and so much light again is off the paraxial value.
        assert!(
            (found / expected - 1.0).abs() < 1e-2,
            "{stop}: {found} {expected}"
        );
        assert!(c.warnings().is_empty());
    }
    let film = film(8, 8, 4.0);
    let too_fine = camera(&spec(DGAUSS, 1e-7, Some(36.77), Form::Course), &film);
    assert!(
        too_fine.warnings()[0].contains("too fine"),
        "{:?}",
        too_fine.warnings()
    );
}

/// Bundles of any composition: the rays made one at a time but for rounding, and the same bits whatever the
/// others of a bundle are.
#[test]
fn rays_side_by_side_are_the_rays_alone() {
    let film = film(640, 480, 35.0);
    for (form, clip, model, sampling, bands) in [
        (
            Form::Course,
            (50.0, 900.0),
            ModelKind::Exact,
            PupilSampling::Concentric,
            0,
        ),
        (
            Form::Pbrt3,
            (f64::NEG_INFINITY, f64::INFINITY),
            ModelKind::Exact,
            PupilSampling::Polar,
            3,
        ),
        (
            Form::Course,
            (f64::NEG_INFINITY, 1e4),
            ModelKind::Thick,
            PupilSampling::Rejection,
            0,
        ),
        (
            Form::Pbrt3,
            (f64::NEG_INFINITY, f64::INFINITY),
            ModelKind::Thin,
            PupilSampling::Concentric,
            0,
        ),
    ] {
        let mut s = spec(DGAUSS, 8.0, Some(37.0), form);
        (s.clip.hither, s.clip.yon) = clip;
        s.model = model;
        s.pupil_sampling = sampling;
        s.bands = Band::all(&colored(), 37.0).unwrap();
        s.bands.truncate(bands);
        // Camera space in mm or in meters; render space has its origin near the camera.
        let unit: f32 = if form == Form::Course { 1.0 } else { 1e-3 };
        let place = Transform::translate(f64::from(unit) * DVec3::new(3.0, -4.0, 5.0))
            * Transform::rotate(40.0, DVec3::new(1.0, 2.0, 3.0));
        let c = Realistic::new(&s, &film, &place).unwrap();
        let samples: Vec<CameraSample> = samples(640, Vec2::ZERO, Vec2::new(640.0, 480.0))
            .enumerate()
            .map(|(i, s)| CameraSample {
                wavelength: (i as f32 * 0.618).fract(),
                ..s
            })
            .collect();
        for with in [false, true] {
            let (mut rays, mut fewer) = ([None; BUNDLE], [None; BUNDLE]);
            let mut passed = 0;
            for bundle in samples.chunks(BUNDLE) {
                c.rays(bundle, with, &mut rays);
                let rays = &rays[..bundle.len()];
                let other: Vec<CameraSample> = bundle.iter().rev().step_by(3).copied().collect();
                c.rays(&other, with, &mut fewer);
                for (a, b) in rays.iter().rev().step_by(3).zip(&fewer) {
                    assert_eq!(format!("{a:?}"), format!("{b:?}"));
                }
                for (sample, ray) in bundle.iter().zip(rays) {
                    // Rays at the very rim may differ.
                    let (Some(a), Some(b)) = (ray, c.ray(sample, with)) else {
                        continue;
                    };
                    passed += 1;
                    // PupilTarget and tracing in single precision (see `optics::lanes::tests`), after up to
                    // a meter of way to the first clip plane.
                    assert!((a.ray.o - b.ray.o).length() < unit * 2e-3, "{a:?} {b:?}");
                    assert!((a.ray.d - b.ray.d).length() < 1e-5);
                    assert!((a.weight / b.weight - 1.0).abs() < 1e-5 && a.tint == b.tint);
                    let t_max = [a.ray.t_max, b.ray.t_max];
                    assert!(t_max[0] == t_max[1] || (t_max[0] / t_max[1] - 1.0).abs() < 1e-5);
                    assert_eq!(a.ray.time, b.ray.time);
                    assert_eq!(
                        (a.differentials.is_some(), b.differentials.is_some()),
                        (with, with)
                    );
                    let Some((da, db)) = a.differentials.zip(b.differentials) else {
                        continue;
                    };
                    // A pixel is 44 um, a thousandth of the focal length; rounding is 1e-7 of 1.
                    for (near, far, o) in [
                        (da.rx_d - a.ray.d, db.rx_d - b.ray.d, da.rx_o - db.rx_o),
                        (da.ry_d - a.ray.d, db.ry_d - b.ray.d, da.ry_o - db.ry_o),
                    ] {
                        assert!((near - far).length() < 1e-6, "{near} {far}");
                        assert!(o.length() < unit * 2e-4, "{model:?} {o}");
                    }
                }
            }
            assert!(passed > 300, "{passed}");
        }
    }
}

/// The double Gauss with Abbe numbers of usual glasses.
fn colored() -> Prescription {
    let mut prescription = Prescription::parse(DGAUSS).unwrap();
    prescription.set_stops(8.0);
    for s in &mut prescription.surfaces {
        s.abbe = (s.index > 1.0).then_some(if s.index > 1.65 { 35.0 } else { 60.0 });
    }
    prescription
}

#[test]
fn dispersion_leaves_a_white_sky_white() {
    let film = film(300, 200, 43.0);
    let plain = spec(DGAUSS, 8.0, Some(37.0), Form::Pbrt3);
    let mut s = plain.clone();
    s.bands = Band::all(&colored(), 37.0).unwrap();
    let bands = s.bands.iter().map(|band| {
        let mut alone = plain.clone();
        alone.lens = band.lens.clone();
        (band.tint, camera(&alone, &film))
    });
    let bands: Vec<_> = bands.collect();
    let colored = camera(&s, &film);
    assert!(!camera(&plain, &film).disperses() && colored.disperses());
    let mean = |camera: &Realistic, count: u32| {
        let samples = samples(count, Vec2::ZERO, Vec2::new(300.0, 200.0));
        let mut sum = DVec3::ZERO;
        for (i, s) in samples.enumerate() {
            // A fifth number, well spread with the other four.
            let wavelength = (0.5 + i as f64 * 0.618_033_988_749_895).fract() as f32;
            let ray = camera.ray(&CameraSample { wavelength, ..s }, false);
            sum += ray.map_or(DVec3::ZERO, |r| (r.tint * r.weight).as_dvec3());
        }
        sum / f64::from(count)
    };
    let seen = mean(&colored, 1 << 17);
    // What each band's lens lets through by itself, whose pupil differs from the d line's by some percent in blue.
    let parts = bands
        .iter()
        .map(|(tint, camera)| tint.as_dvec3() * mean(camera, 1 << 13));
    let expected = parts.sum::<DVec3>() / bands.len() as f64;
    // 2^17 samples whose tints have a standard deviation of 1.3 would leave 0.4 % if nothing were stratified.
    assert!(
        (seen / expected - 1.0).abs().max_element() < 1e-2,
        "{expected} {seen}"
    );
}

#[test]
fn bands_go_their_own_ways() {
    let film = film(300, 200, 43.0);
    let mut s = spec(DGAUSS, 8.0, Some(37.0), Form::Pbrt3);
    s.bands = Band::all(&colored(), 37.0).unwrap();
    let c = camera(&s, &film);
    let ray = |wavelength: f32| {
        let raster = Vec2::new(20.5, 30.5);
        let sample = CameraSample {
            raster,
            time: 0.5,
            lens: Vec2::new(0.3, 0.6),
            wavelength,
        };
        c.ray(&sample, false).unwrap()
    };
    let (blue, red) = (ray(0.0), ray(0.999));
    assert!(blue.tint.z > 2.0 && red.tint.x > 2.0);
    // Some hundredths of a degree.
    let angle = (blue.ray.d - red.ray.d).length();
    assert!(angle > 1e-4 && angle < 1e-2, "{angle}");
    let text = c.describe(&film).join("\n");
    assert!(text.contains("dispersion in 12 bands"), "{text}");
}
