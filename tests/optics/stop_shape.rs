//! Stops that are not round, in the camera: how much light they let through, and what out-of-focus points look like.

use fstop::cameras::{
    BUNDLE, Camera, CameraRay, CameraSample, CameraSpec, Clip, Compat, FilmGeometry, Form,
    Precision, RealisticSpec, Shutter, Weighting,
};
use fstop::math::transform::Transform;
use fstop::math::{UVec2, Vec2};
use fstop::optics::models::ModelKind;
use fstop::optics::pupil::PupilSampling;
use fstop::optics::stop_shape::{StopImage, StopPolygon};
use fstop::optics::{Cause, Lens, Prescription, StopShape};

/// A biconvex lens of f = 49 mm with its stop behind it.
fn lens(stop: f64, focus: f64) -> Lens {
    let text = format!("50 5 1.5168 30\n-50 2 1 30\n0 0 0 {stop}\n");
    let prescription = Prescription::parse(&text).expect("a lens");
    let film_distance = Lens::focused(&prescription, focus).expect("a focus");
    Lens::new(&prescription, film_distance).expect("a film")
}

/// Pixels across the film.
const ACROSS: u32 = 33;

struct Setup {
    lens: Lens,
    diagonal: f64,
    model: ModelKind,
    precision: Precision,
}

impl Setup {
    fn camera(&self, stop_shape: Option<StopShape>) -> Camera {
        let spec = RealisticSpec {
            lens_name: "biconvex.dat".to_string(),
            nominal_focal_length: None,
            lens: self.lens.clone(),
            form: Form::Course,
            weighting: Weighting::Physical,
            compat: Compat::None,
            pupil_sampling: PupilSampling::default(),
            model: self.model,
            bands: Vec::new(),
            ghosts: false,
            coating: None,
            precision: self.precision,
            stop_shape,
            film_diagonal: None,
            shutter: Shutter::default(),
            shift: [0.0; 2],
            tilt: [0.0; 2],
            autofocus: None,
            exposure: Default::default(),
            clip: Clip::NONE,
        };
        let film = FilmGeometry {
            resolution: UVec2::splat(ACROSS),
            diagonal_mm: self.diagonal,
        };
        let spec = CameraSpec::Realistic(Box::new(spec));
        Camera::new(&spec, &film, &Transform::IDENTITY).expect("a camera")
    }
}

/// Total weight of the rays from the raster point `at` that `counts`, over the number of samples.
fn light(camera: &Camera, at: Vec2, samples: u32, counts: impl Fn(&CameraRay) -> bool) -> f64 {
    let all: Vec<CameraSample> = (0..samples)
        .map(|i| {
            // The R2 sequence (Roberts 2018).
            let r = |a: f64| (0.5 + f64::from(i) * a).fract() as f32;
            CameraSample {
                raster: at,
                time: 0.5,
                lens: Vec2::new(r(0.754_877_666_246_692_8), r(0.569_840_290_998_053_3)),
                wavelength: 0.5,
            }
        })
        .collect();
    let mut sum = 0.0;
    for bundle in all.chunks(BUNDLE) {
        let mut rays = [None; BUNDLE];
        camera.rays(bundle, false, &mut rays);
        sum += rays
            .iter()
            .flatten()
            .filter(|ray| counts(ray))
            .map(|ray| f64::from(ray.weight))
            .sum::<f64>();
    }
    sum / f64::from(samples)
}

/// Every shape, and the part of the circle's light that it lets through.
fn shapes() -> Vec<(StopShape, f64)> {
    let polygon = |p: StopPolygon| (StopShape::Polygon(p), p.area());
    let e = (-1.0f64).exp();
    let gray = StopImage::new(512, std::iter::repeat_n(0.25, 512 * 512)).expect("an image");
    vec![
        polygon(StopPolygon::of_blades(3, 0.0)),
        polygon(StopPolygon::of_blades(5, 17.0)),
        polygon(StopPolygon::of_blades(6, 0.0)),
        polygon(StopPolygon::of_blades(9, -20.0)),
        polygon(StopPolygon::square(0.0)),
        polygon(StopPolygon::pentagon(0.0)),
        polygon(StopPolygon::star(0.0)),
        // The mean of exp(−r²) − 1/e over the disk is 1 − 2/e, at its middle it is 1 − 1/e.
        (StopShape::Gaussian, (1.0 - 2.0 * e) / (1.0 - e)),
        (StopShape::ImageData(gray), 0.25),
    ]
}

#[test]
fn irradiance_on_the_axis_falls_by_the_area() {
    // Areas by formula: a triangle's is 3√3/4 r², a hexagon's twice as much, the square's r².
    let pi = std::f64::consts::PI;
    for (polygon, area) in [
        (StopPolygon::of_blades(3, 5.0), 0.75 * 3f64.sqrt()),
        (StopPolygon::of_blades(6, 5.0), 1.5 * 3f64.sqrt()),
        (StopPolygon::square(5.0), 1.0),
    ] {
        assert!((polygon.area() - area / pi).abs() < 1e-15);
    }
    let mut setup = Setup {
        lens: lens(4.0, f64::INFINITY),
        diagonal: 1e-3,
        model: ModelKind::Exact,
        precision: Precision::Single,
    };
    let middle = Vec2::splat(0.5 * ACROSS as f32);
    for (model, precision) in [
        (ModelKind::Exact, Precision::Single),
        (ModelKind::Exact, Precision::Double),
        (ModelKind::Thick, Precision::Double),
    ] {
        setup.model = model;
        setup.precision = precision;
        let round = light(&setup.camera(None), middle, 1 << 15, |_| true);
        for (shape, part) in shapes() {
            let found = light(&setup.camera(Some(shape.clone())), middle, 1 << 15, |_| {
                true
            });
            // Of 32768 well-spread samples a perimeter of four radii cuts a few hundred; cos⁴ at f/12 and the pupil's
            // aberration are below a thousandth.
            let error = found / round - part;
            assert!(
                error.abs() < 3e-3,
                "{model} {precision:?} {shape:?}: {error}"
            );
        }
    }
}

/// What passes the tracer of a lens with blades is what passes the round one, inside the polygon.
#[test]
fn blades_end_rays_at_the_stop() {
    let round = lens(10.0, 1000.0);
    let shape = StopShape::Polygon(StopPolygon::of_blades(3, 0.0));
    let bladed = round.clone().with_stop_shape(shape.clone());
    let stop_z = round.length();
    let (mut passed, mut ended) = (0, 0);
    for i in 0..400 {
        let p = [
            f64::from(i % 20) * 0.55 - 5.2,
            f64::from(i / 20) * 0.55 - 5.2,
        ];
        let at = [p[0], p[1], stop_z];
        let open = shape.transmission(p.map(|x| x / 5.0)) > 0.0;
        let (a, b) = (
            round.trace_from_film([1.0, 2.0], at),
            bladed.trace_from_film([1.0, 2.0], at),
        );
        assert_eq!(bladed.stop_transmission([1.0, 2.0], at) > 0.0, open);
        if a.is_ok() && open {
            assert_eq!(a, b);
            passed += 1;
        } else if a.is_ok() {
            let blocked = b.expect_err("a blade is in the way");
            assert_eq!((blocked.surface, blocked.cause), (2, Cause::Vignetted));
            ended += 1;
        }
    }
    assert!(passed > 80 && ended > 80, "{passed} {ended}");
    assert_eq!(round.stop_transmission([1.0, 2.0], [9.0, 9.0, stop_z]), 1.0);
}

/// An out-of-focus point shows the stop: upright behind the plane of focus, upside down in front of it.
#[test]
fn out_of_focus_points_show_the_stop_the_right_way_round() {
    // Focused at half a meter; the circle of confusion of a point at infinity is 1 mm, half as much farther than that nearby.
    for (distance, turned) in [(1e6, 0.0), (290.0, 180.0)] {
        for precision in [Precision::Single, Precision::Double] {
            let setup = Setup {
                lens: lens(8.0, 500.0),
                diagonal: 2.2,
                model: ModelKind::Exact,
                precision,
            };
            // A small ball on the axis; a tenth of the stop across, seen from the lens.
            let hits = |ray: &CameraRay| {
                let (o, d) = (ray.ray.o.as_dvec3(), ray.ray.d.as_dvec3());
                let p = o + d * ((distance - o.z) / d.z);
                p.x.hypot(p.y) < 6e-4 * distance
            };
            let middle = Vec2::splat(0.5 * ACROSS as f32);
            let toward = |camera: &Camera, radius: f64, direction: f64| {
                let (sin, cos) = direction.to_radians().sin_cos();
                // Raster y runs down.
                let at = middle + Vec2::new((radius * cos) as f32, (-radius * sin) as f32);
                light(camera, at, 1 << 12, hits)
            };
            // How large the blur is, in pixels: where a round stop's ends.
            let round = setup.camera(None);
            let full = toward(&round, 0.0, 0.0);
            let size = (1..200)
                .map(|i| 0.1 * f64::from(i))
                .find(|r| toward(&round, *r, 90.0) < 0.5 * full)
                .expect("an end");
            assert!(size > 3.0, "{size}");
            for rotation in [0.0, 25.0] {
                let triangle = StopPolygon::of_blades(3, rotation);
                let camera = setup.camera(Some(StopShape::Polygon(triangle)));
                for i in 0..24 {
                    let direction = 15.0 * f64::from(i);
                    // Corners at 90°, 210° and 330°, sides half as far out, half-way between.
                    let from_corner = (direction - 90.0 - rotation - turned).rem_euclid(120.0);
                    let edge = 0.5 / (from_corner - 60.0).to_radians().cos();
                    let inside = toward(&camera, 0.75 * edge * size, direction);
                    let outside = toward(&camera, (edge + 0.2) * size, direction);
                    let what = format!("{distance} {precision:?} {rotation} {direction}");
                    assert!(inside > 0.4 * full, "{what}: {inside} of {full}");
                    assert!(outside < 0.15 * full, "{what}: {outside} of {full}");
                }
            }
        }
    }
}

/// pbrt-v4's image of a stop is upright as seen from behind the camera: what its top covers is missing on top of the blur of a
/// distant point.
#[test]
fn a_image_is_upright() {
    let setup = Setup {
        lens: lens(8.0, 500.0),
        diagonal: 2.2,
        model: ModelKind::Exact,
        precision: Precision::Single,
    };
    // Black but for the upper left quarter.
    let texels = (0..64 * 64).map(|i| if i % 64 < 32 && i / 64 < 32 { 1.0 } else { 0.0 });
    let image = StopImage::new(64, texels).expect("an image");
    let camera = setup.camera(Some(StopShape::ImageData(image)));
    let hits = |ray: &CameraRay| {
        let d = ray.ray.d.as_dvec3();
        d.x.hypot(d.y) < 6e-4 * d.z
    };
    let middle = 0.5 * ACROSS as f32;
    let at = |x: f32, y: f32| light(&camera, Vec2::new(middle + x, middle + y), 1 << 12, hits);
    let lit = at(-4.0, -4.0);
    assert!(lit > 0.0);
    for (x, y) in [(4.0, -4.0), (-4.0, 4.0), (4.0, 4.0)] {
        assert!(at(x, y) < 0.02 * lit, "{x} {y}");
    }
}
