//! Light tracing against camera rays, for every kind of camera.

use super::*;
use crate::cameras::{
    Band, CameraSpec, Clip, Compat, FilmGeometry, Form, Precision, ProjectiveSpec, RealisticSpec,
    Screen, Shutter, ThinLens, Weighting,
};
use crate::math::hash::{mix2, unit_float};
use crate::math::motion::Motion;
use crate::math::transform::Transform;
use crate::math::{DMat4, UVec2};
use crate::optics::stop_shape::StopPolygon;
use crate::optics::{Lens, Prescription, StopShape};

const FILM: FilmGeometry = FilmGeometry {
    resolution: UVec2::new(24, 16),
    diagonal_mm: 35.0,
};

/// Parts of the image that are compared, in x and y.
const TILES: UVec2 = UVec2::new(4, 4);

/// A camera in front of a rectangle that shines on both sides with radiance 1.
struct Case {
    name: &'static str,
    camera: Camera,
    corner: DVec3,
    edges: [DVec3; 2],
    shutter: Shutter,
}

impl Case {
    fn new(name: &'static str, spec: CameraSpec, place: DMat4, quad: [[f64; 3]; 3]) -> Case {
        let [corner, a, b] = quad.map(DVec3::from);
        let mut camera = Camera::new(&spec, &FILM, &Transform::from_matrix(place)).unwrap();
        camera.prepare_connections([Vec2::ZERO, FILM.resolution.as_vec2()]);
        Case {
            name,
            camera,
            corner,
            edges: [a, b],
            shutter: Shutter::default(),
        }
    }

    fn area(&self) -> f64 {
        self.edges[0].cross(self.edges[1]).length()
    }

    fn normal(&self) -> DVec3 {
        self.edges[0].cross(self.edges[1]).normalize()
    }

    fn hit(&self, ray: &Ray) -> Option<DVec3> {
        let (o, d) = (ray.o.as_dvec3(), ray.d.as_dvec3());
        let t = (self.corner - o).dot(self.normal()) / d.dot(self.normal());
        let at = o + t * d - self.corner;
        let [a, b] = self.edges;
        // Edges at a right angle.
        let inside = |e: DVec3| (0.0..=1.0).contains(&(at.dot(e) / e.length_squared()));
        (t > 0.0 && t < f64::from(ray.t_max) && inside(a) && inside(b)).then_some(o + t * d)
    }
}

/// Numbers from 0 to 1 that have nothing to do with each other.
struct Numbers(u64, u64);

impl Numbers {
    fn next(&mut self) -> f32 {
        self.1 += 1;
        unit_float(mix2(self.0, self.1))
    }
}

/// Sums of values and of their squares in every tile.
struct Tiles(Vec<[f64; 2]>);

impl Tiles {
    fn new() -> Tiles {
        Tiles(vec![[0.0; 2]; (TILES.x * TILES.y) as usize])
    }

    fn add(&mut self, raster: Vec2, value: f64) {
        let at = raster / FILM.resolution.as_vec2() * TILES.as_vec2();
        if at.min_element() < 0.0 || at.x >= TILES.x as f32 || at.y >= TILES.y as f32 {
            return;
        }
        let [sum, squares] = &mut self.0[(at.y as u32 * TILES.x + at.x as u32) as usize];
        *sum += value;
        *squares += value * value;
    }

    /// Means of `n` samples and their variances, and those of the whole image.
    fn means(&self, n: f64) -> Vec<[f64; 2]> {
        let mean = |[sum, squares]: [f64; 2]| {
            let mean = sum / n;
            [mean, (squares / n - mean * mean).max(0.0) / n]
        };
        let whole = self
            .0
            .iter()
            .fold([0.0; 2], |a, b| [a[0] + b[0], a[1] + b[1]]);
        self.0
            .iter()
            .chain([&whole])
            .map(|tile| mean(*tile))
            .collect()
    }
}

/// Pixel values summed over each tile: by camera rays, by light tracing, and by both with the balance heuristic, of `n` samples each.
fn pictures(case: &Case, n: u32) -> [Vec<[f64; 2]>; 3] {
    let mut numbers = Numbers(7, 0);
    let next2 = |n: &mut Numbers| Vec2::new(n.next(), n.next());
    let [mut camera, mut light, mut both] = [Tiles::new(), Tiles::new(), Tiles::new()];
    let pixels = f64::from(FILM.resolution.x * FILM.resolution.y);
    // Of one light path's vertex, per area; n paths against n/pixels camera rays in each pixel.
    let density = 1.0 / case.area();
    let share = 1.0 / pixels;
    for _ in 0..n {
        let sample = CameraSample {
            raster: next2(&mut numbers) * FILM.resolution.as_vec2(),
            time: numbers.next(),
            lens: next2(&mut numbers),
            wavelength: numbers.next(),
        };
        if let Some(ray) = case.camera.ray(&sample, false)
            && let Some(p) = case.hit(&ray.ray)
        {
            let value = pixels * f64::from(ray.weight * ray.tint.x);
            let cos = case.normal().dot(ray.ray.d.as_dvec3()).abs();
            let other = case.camera.connection_density(&sample, &ray, p.as_vec3());
            let other = f64::from(other) * density / cos;
            camera.add(sample.raster, value);
            both.add(sample.raster, value * share / (share + other));
        }
        let u = next2(&mut numbers).as_dvec2();
        let p = case.corner + u.x * case.edges[0] + u.y * case.edges[1];
        let from = ReferencePoint {
            p: p.as_vec3(),
            n: case.normal().as_vec3(),
            time: case.shutter.time(numbers.next()),
            ..Default::default()
        };
        let sample = LensSample {
            lens: next2(&mut numbers),
            wavelength: numbers.next(),
        };
        if let Some(aim) = case.camera.aim(&from, &sample)
            && let Some(landing) = case.camera.land(&aim)
        {
            let cos = case.normal().dot(aim.wi.as_dvec3()).abs();
            let value = f64::from(landing.importance.x) * cos / density;
            let other = share * f64::from(landing.density) * cos / density;
            light.add(landing.raster, value);
            both.add(landing.raster, value / (1.0 + other));
        }
    }
    [camera, light, both].map(|tiles| tiles.means(f64::from(n)))
}

fn assert_same(case: &Case, n: u32) {
    assert!(case.camera.connects(), "{}", case.name);
    let [camera, light, both] = pictures(case, n);
    let flux = camera[camera.len() - 1][0];
    assert!(flux > 0.0, "{} sees nothing", case.name);
    for (what, found) in [("light", &light), ("both", &both)] {
        for (tile, (a, b)) in camera.iter().zip(found).enumerate() {
            // Four standard errors of the difference; a tile of a few samples may have too small an estimate of its own, and a
            // hundred-thousandth of the flux is in none to be seen.
            let sigma = (a[1] + b[1]).sqrt();
            assert!(
                (a[0] - b[0]).abs() <= 4.0 * sigma + 1e-5 * flux,
                "{} by {what}, tile {tile}: {} and {}, σ {sigma}",
                case.name,
                a[0],
                b[0]
            );
        }
    }
}

fn projective(spec: ProjectiveSpec) -> CameraSpec {
    CameraSpec::Projective(Box::new(spec))
}

fn lens(radius: f64) -> ThinLens {
    ThinLens {
        radius,
        focal_distance: 4.0,
    }
}

fn perspective(radius: f64) -> ProjectiveSpec {
    ProjectiveSpec {
        fov: Some(60.0),
        lens: lens(radius),
        ..Default::default()
    }
}

fn orthographic(radius: f64) -> ProjectiveSpec {
    ProjectiveSpec {
        fov: None,
        ..perspective(radius)
    }
}

/// Scaled unevenly, sheared, mirrored and moved.
fn skewed() -> DMat4 {
    DMat4::from_cols(
        DVec3::new(-1.5, 0.2, 0.1).extend(0.0),
        DVec3::new(0.3, 0.8, -0.2).extend(0.0),
        DVec3::new(0.1, -0.3, 2.0).extend(0.0),
        DVec3::new(0.4, -0.1, 0.3).extend(1.0),
    )
}

/// A tilted rectangle at some distance ahead, that leaves the image on one side.
const AHEAD: [[f64; 3]; 3] = [[-0.7, -0.9, 2.6], [3.0, 0.3, 0.6], [-0.1, 1.4, -0.2]];

fn cases() -> Vec<Case> {
    let still = DMat4::IDENTITY;
    let screen = Screen {
        window: Some([-0.2, 1.1, -0.7, 0.3]),
        ..Default::default()
    };
    let clip = Clip {
        hither: 2.6,
        yon: 2.9,
    };
    let environment = || CameraSpec::Environment(Box::default());
    let mut moving = Case::new("moving", projective(perspective(0.2)), still, AHEAD);
    let end = Transform::from_matrix(
        DMat4::from_translation(DVec3::new(0.5, 0.2, -0.4)) * DMat4::from_rotation_y(0.3),
    );
    let motion = Motion::new(&Transform::IDENTITY, &end, [0.0, 1.0]);
    moving.camera.set_motion(motion.unwrap());
    let off_center = |spec| ProjectiveSpec {
        screen: screen.clone(),
        ..spec
    };
    let clipped = ProjectiveSpec {
        clip,
        ..perspective(0.2)
    };
    let near_pole = [[-0.4, 1.2, -0.5], [0.9, 0.3, 0.0], [-0.3, 0.9, 0.6]];
    let behind = [[0.9, -0.5, -0.6], [0.1, 0.2, 1.3], [0.3, 0.9, -0.16]];
    vec![
        Case::new("pinhole", projective(perspective(0.0)), still, AHEAD),
        Case::new("thin lens", projective(perspective(0.5)), still, AHEAD),
        Case::new(
            "skewed pinhole",
            projective(perspective(0.0)),
            skewed(),
            AHEAD,
        ),
        Case::new("skewed lens", projective(perspective(0.4)), skewed(), AHEAD),
        Case::new(
            "window",
            projective(off_center(perspective(0.1))),
            still,
            AHEAD,
        ),
        Case::new("clipped", projective(clipped), still, AHEAD),
        Case::new("parallel", projective(orthographic(0.0)), still, AHEAD),
        Case::new(
            "telecentric",
            projective(orthographic(0.9)),
            skewed(),
            AHEAD,
        ),
        Case::new("environment, pole", environment(), still, near_pole),
        Case::new("environment, seam", environment(), skewed(), behind),
        moving,
    ]
}

#[test]
fn light_tracing_makes_the_picture_that_camera_rays_make() {
    for case in cases().into_iter().chain(traced_cases()) {
        // Tenths of a percent of the flux.
        assert_same(&case, 100_000);
    }
}

/// A connection through the same point of the lens undoes the camera's ray, and so does its density.
#[test]
fn connections_undo_camera_rays() {
    for case in cases() {
        let mut numbers = Numbers(3, 0);
        let mut compared = 0;
        for _ in 0..4000 {
            let mut next = || numbers.next();
            let sample = CameraSample {
                raster: Vec2::new(next(), next()) * FILM.resolution.as_vec2(),
                time: next(),
                lens: Vec2::new(next(), next()),
                wavelength: next(),
            };
            let ray = case.camera.ray(&sample, false).unwrap();
            let Some(p) = case.hit(&ray.ray) else {
                continue;
            };
            let from = ReferencePoint {
                p: p.as_vec3(),
                time: ray.ray.time,
                ..Default::default()
            };
            let again = LensSample {
                lens: sample.lens,
                wavelength: sample.wavelength,
            };
            // A point rounded behind a clip plane is no failure, but a rare one.
            let Some(aim) = case.camera.aim(&from, &again) else {
                continue;
            };
            let landing = case.camera.land(&aim).unwrap();
            // The point is rounded to 2⁻²⁴ of its distance, a few pixels of 1/30 rad to 1e-5; near a pole of the environment
            // camera azimuths are as much less certain as the circle is smaller.
            let slack = match case.camera {
                Camera::Environment(_) => {
                    1e-5 / (sample.raster.y / 16.0 * std::f32::consts::PI).sin()
                }
                _ => 2e-5,
            };
            let off = landing.raster - sample.raster;
            let turn = FILM.resolution.x as f32;
            let across = off.x.abs().min((off.x.abs() - turn).abs());
            assert!(across < slack && off.y.abs() < 2e-5, "{}: {off}", case.name);
            let inverse = case.camera.connection_density(&sample, &ray, from.p);
            // Two roundings to f32, and what the point's rounding does.
            assert!(
                (inverse * landing.density - 1.0).abs() < 1e-6,
                "{}",
                case.name
            );
            assert!((aim.wi + ray.ray.d).length() < 1e-6);
            // The shadow ray runs from the point to where the camera's ray starts.
            let end = aim.shadow.o + aim.shadow.d * aim.shadow.t_max;
            assert!(end.distance(ray.ray.o) < 2e-6, "{}", case.name);
            compared += 1;
        }
        assert!(compared > 200, "{}: {compared}", case.name);
    }
}

fn lens_file(name: &str) -> Prescription {
    let root = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/golden/");
    Prescription::read(format!("{root}{name}.dat").as_ref()).unwrap()
}

/// Focused at `focus` mm from the film.
pub(super) fn traced(prescription: &Prescription, focus: f64, form: Form) -> RealisticSpec {
    let distance = Lens::focused(prescription, focus).unwrap();
    RealisticSpec {
        lens_name: String::new(),
        nominal_focal_length: None,
        lens: Lens::new(prescription, distance).unwrap(),
        form,
        weighting: Weighting::Physical,
        compat: Compat::None,
        pupil_sampling: Default::default(),
        model: Default::default(),
        precision: Precision::Single,
        stop_shape: None,
        bands: Vec::new(),
        ghosts: false,
        coating: None,
        film_diagonal: None,
        shift: [0.0; 2],
        tilt: [0.0; 2],
        autofocus: None,
        shutter: Shutter::default(),
        exposure: Default::default(),
        clip: Clip::NONE,
    }
}

/// Traced lenses, in focus and out of it, in the middle and where they vignette.
fn traced_cases() -> Vec<Case> {
    let still = DMat4::IDENTITY;
    let case = |name, spec: RealisticSpec, place, quad| {
        let shutter = spec.shutter;
        let spec = CameraSpec::Realistic(Box::new(spec));
        Case {
            shutter,
            ..Case::new(name, spec, place, quad)
        }
    };
    let ahead = [
        [-300.0, -420.0, 1000.0],
        [900.0, 90.0, 180.0],
        [-30.0, 400.0, -50.0],
    ];
    let edge = [
        [120.0, -60.0, 700.0],
        [120.0, 40.0, 60.0],
        [-20.0, 60.0, 0.0],
    ];
    let near = [[-14.0, -9.0, 40.0], [20.0, 3.0, 6.0], [-3.0, 20.0, 0.0]];
    let meters = |quad: [[f64; 3]; 3]| quad.map(|v| v.map(|x| 1e-3 * x));
    let (gauss, wide, fisheye) = (
        lens_file("dgauss_50"),
        lens_file("wide_22"),
        lens_file("fisheye_10"),
    );
    let course = |p: &Prescription| traced(p, 1000.0, Form::Course);
    let v3 = |p: &Prescription| traced(p, 400.0, Form::Pbrt3);
    let mut in_water = gauss.clone();
    in_water.surfaces.last_mut().unwrap().index = 1.33;
    let mut bands = course(&gauss);
    let shifted = |shift: f64, tint| {
        let mut p = gauss.clone();
        (p.surfaces.iter_mut().filter(|s| s.index > 1.0)).for_each(|s| s.index += shift);
        Band {
            lens: Lens::new(&p, bands.lens.film_distance()).unwrap(),
            wavelength: 0.5,
            tint: Rgb::splat(tint),
        }
    };
    bands.bands = vec![shifted(0.02, 0.5), shifted(-0.02, 1.5)];
    let blades = RealisticSpec {
        stop_shape: Some(StopShape::Polygon(StopPolygon::of_blades(5, 10.0))),
        precision: Precision::Double,
        ..course(&gauss)
    };
    let gaussian = RealisticSpec {
        stop_shape: Some(StopShape::Gaussian),
        ..v3(&wide)
    };
    let simple = RealisticSpec {
        weighting: Weighting::Simple,
        ..v3(&wide)
    };
    let brief = RealisticSpec {
        shutter: Shutter {
            open: 0.25,
            close: 0.75,
        },
        clip: Clip {
            hither: 1.02,
            yon: 1.1,
        },
        ..v3(&gauss)
    };
    let tilted = RealisticSpec {
        tilt: [9.0, 0.0],
        ..course(&gauss)
    };
    let swung = RealisticSpec {
        tilt: [-4.0, 7.0],
        shift: [3.0, -2.0],
        ..v3(&wide)
    };
    let mut moving = case("moving lens", brief.clone(), still, meters(ahead));
    let end = Transform::from_matrix(
        DMat4::from_translation(DVec3::new(0.05, 0.02, -0.04)) * DMat4::from_rotation_y(0.1),
    );
    let motion = Motion::new(&Transform::IDENTITY, &end, [0.0, 1.0]);
    moving.camera.set_motion(motion.unwrap());
    let wide_open = [
        [-900.0, -500.0, 800.0],
        [1500.0, 90.0, 180.0],
        [-50.0, 900.0, -5.0],
    ];
    let aside = [
        [1200.0, -200.0, 500.0],
        [250.0, 30.0, -300.0],
        [-30.0, 300.0, 0.0],
    ];
    vec![
        case("double Gauss", course(&gauss), still, ahead),
        case("its edge", course(&gauss), still, edge),
        case("near its front", course(&gauss), still, near),
        case("skewed lens", v3(&gauss), skewed(), meters(ahead)),
        case("film in water", course(&in_water), still, ahead),
        case("bands", bands, still, ahead),
        case("blades", blades, still, ahead),
        case("gaussian stop", gaussian, still, meters(wide_open)),
        case("simple weighting", simple, skewed(), meters(wide_open)),
        case("clipped lens", brief, still, meters(ahead)),
        case("fisheye", course(&fisheye), still, aside),
        case("tilted film", tilted.clone(), still, ahead),
        case("its edge, tilted", tilted, still, edge),
        case(
            "tilted, swung and shifted",
            swung,
            skewed(),
            meters(wide_open),
        ),
        moving,
    ]
}

#[test]
fn what_lies_behind_the_camera_or_on_it_is_not_aimed_at() {
    let place = Transform::IDENTITY;
    let camera = |spec| Camera::new(&projective(spec), &FILM, &place).unwrap();
    let from = |p: Vec3| ReferencePoint {
        p,
        ..Default::default()
    };
    let sample = LensSample {
        lens: Vec2::splat(0.5),
        wavelength: 0.5,
    };
    for spec in [perspective(0.0), orthographic(0.0), perspective(0.5)] {
        let camera = camera(spec);
        for p in [Vec3::ZERO, Vec3::NEG_Z, Vec3::X, Vec3::splat(f32::NAN)] {
            assert!(camera.aim(&from(p), &sample).is_none(), "{p}");
        }
        assert!(camera.aim(&from(Vec3::Z), &sample).is_some());
    }
    let everywhere = CameraSpec::Environment(Box::default());
    let camera = Camera::new(&everywhere, &FILM, &place).unwrap();
    for p in [Vec3::ZERO, Vec3::Y, Vec3::splat(f32::NAN)] {
        assert!(camera.aim(&from(p), &sample).is_none(), "{p}");
    }
}

#[test]
fn a_projection_in_the_cameras_place_has_no_connections() {
    let mut m = DMat4::IDENTITY;
    m.z_axis.w = 0.1;
    let place = Transform::from_matrix(m);
    let camera = Camera::new(&projective(perspective(0.0)), &FILM, &place).unwrap();
    assert!(!camera.connects());
}
