//! Ghosts of a camera against those of its lens.

use super::*;
use crate::cameras::FilmGeometry;
use crate::cameras::realistic::RealisticSpec;
use crate::cameras::realistic::tests::double_gauss;
use crate::math::UVec2;
use crate::math::transform::Transform;
use crate::optics::ghosts::{GhostTable, Ghosts, parallel, reach, table};

const FILM: FilmGeometry = FilmGeometry {
    resolution: UVec2::new(360, 240),
    diagonal_mm: 43.2,
};

/// With a film that light lands on wherever it meets the plane.
fn camera(spec: &RealisticSpec, place: &Transform) -> Realistic {
    let mut camera = Realistic::new(spec, &FILM, place).unwrap();
    camera.prepare_ghosts([Vec2::splat(-1e7), Vec2::splat(1e7)]);
    camera
}

fn reflecting() -> RealisticSpec {
    RealisticSpec {
        ghosts: true,
        ..double_gauss()
    }
}

/// What a pair brings of a lamp: all of it, and its middle, mm.
#[derive(Clone, Copy, Default)]
struct Brought {
    light: f64,
    height: f64,
}

/// What a distant lamp of irradiance 1 toward `wi` brings by each pair, over `count` points of the first surface.
fn of_lamp(camera: &Realistic, wi: Vec3, count: u32) -> Vec<Brought> {
    let sampling = camera.ghost_sampling.as_deref().unwrap();
    let mut all = vec![Brought::default(); sampling.pairs.len()];
    for i in 0..count {
        // The two-dimensional R sequence (Roberts 2018).
        let r =
            |k: i32| (0.5 + f64::from(i + 1) / 1.324_717_957_244_746_f64.powi(k)).fract() as f32;
        let entry = camera.ghost_entry(0.0, 0.5, Vec2::new(r(1), r(2))).unwrap();
        let mut before = 0.0;
        for (k, brought) in all.iter_mut().enumerate() {
            // The middle of the numbers that draw it.
            let probability = sampling.choice.probability(k);
            let u = before + 0.5 * probability;
            before += probability;
            assert_eq!(sampling.choice.sample_discrete(u).0, k);
            let Some(landing) = camera.ghost(&entry, wi, u) else {
                continue;
            };
            let light = f64::from(landing.importance.y * probability) / f64::from(count);
            brought.light += light;
            brought.height += light * camera.film_point(landing.raster)[1];
        }
    }
    for brought in &mut all {
        brought.height /= brought.light;
    }
    all
}

/// Light and height of each ghost are those that `fstop lens --ghosts` prints.
#[test]
fn a_distant_lamps_ghosts_are_those_of_the_table() {
    let camera = camera(&reflecting(), &Transform::IDENTITY);
    let degrees = 6.0f64;
    let (sin, cos) = degrees.to_radians().sin_cos();
    // The lamp's light runs toward +y in lens coordinates.
    let wi = Vec3::new(0.0, -sin as f32, cos as f32);
    let ghosts = Ghosts::new(camera.main.lens.clone(), None);
    let GhostTable { ghosts: rows, .. } = table(&ghosts, degrees);
    let brought = of_lamp(&camera, wi, 1 << 14);
    let radius = reach(&camera.main.lens.surfaces()[0], degrees);
    // Its picture: the share that arrives, of what falls on a disk across the axis.
    let all = parallel(&ghosts, degrees);
    let direct: f64 = { all.iter() }
        .filter_map(|ray| ghosts.trace_direct(ray))
        .map(|arrival| arrival.light[0])
        .sum();
    let disk = std::f64::consts::PI * radius * radius * cos;
    let picture = camera.importance(&camera.main) * disk * direct / all.len() as f64;
    let sampling = camera.ghost_sampling.as_deref().unwrap();
    let pixel = camera.pixel_area().sqrt();
    let (mut compared, mut sums) = (0, [0.0; 2]);
    for row in &rows {
        let pair = (row.surfaces[0] - 1, row.surfaces[1] - 1);
        let at = sampling.pairs.iter().position(|p| *p == pair).unwrap();
        let Brought { light, height } = brought[at];
        sums[0] += row.light;
        sums[1] += light / picture;
        // Of the others the table has too few rays.
        if row.light > 5e-4 {
            assert!(
                (light / picture / row.light - 1.0).abs() < 0.01,
                "{row:?} {}",
                light / picture
            );
            assert!((height - row.height).abs() < pixel, "{row:?} {height}");
            compared += 1;
        }
    }
    assert!(compared > 5, "{compared}");
    // All of them: the table has some hundred rays at the edges of each ghost, which are the ones in doubt.
    assert!((sums[1] / sums[0] - 1.0).abs() < 0.005, "{sums:?}");
}

/// A camera in scaled, sheared space measures the light of a sky as that of another does: étendue is that of its own space.
#[test]
fn a_skewed_camera_has_the_ghosts_of_a_straight_one() {
    let skewed = crate::math::DMat4::from_cols(
        DVec3::new(-1.5, 0.2, 0.1).extend(0.0),
        DVec3::new(0.3, 0.8, -0.2).extend(0.0),
        DVec3::new(0.1, -0.3, 2.0).extend(0.0),
        DVec3::new(0.4, -0.1, 0.3).extend(1.0),
    );
    let spec = reflecting();
    let mean = |place: &Transform| {
        let camera = camera(&spec, place);
        let count = 1 << 17;
        let sum: f64 = (0..count)
            .filter_map(|i| {
                // Five coordinates of the R sequence.
                let r = |k: i32| {
                    (0.5 + f64::from(i + 1) / 1.134_724_138_401_519_5f64.powi(k)).fract() as f32
                };
                let entry = camera.ghost_entry(0.0, 0.5, Vec2::new(r(1), r(2)))?;
                let u = Vec2::new(r(3), r(4));
                let wi = Frame::from_normal(entry.point.n).to_world(cosine_hemisphere(u));
                let density = f64::from(wi.dot(entry.point.n)) / std::f64::consts::PI;
                Some(f64::from(camera.ghost(&entry, wi, r(5))?.importance.y) / density)
            })
            .sum();
        sum / f64::from(count)
    };
    let [a, b] = [Transform::IDENTITY, Transform::from_matrix(skewed)].map(|place| mean(&place));
    // One sample in twenty gets through, of weights that scatter by their mean: 1.5 % with random numbers, and these do better.
    assert!((a / b - 1.0).abs() < 0.02, "{a} {b}");
}

/// What surfaces reflect is missing in the image, and a coating brings it back.
#[test]
fn a_reflecting_lens_is_darker() {
    let bare = reflecting();
    let coated = RealisticSpec {
        coating: "1.38@550".parse().ok(),
        ..bare.clone()
    };
    let cameras = [double_gauss(), bare, coated].map(|spec| camera(&spec, &Transform::IDENTITY));
    let sample = crate::cameras::CameraSample {
        raster: Vec2::new(180.0, 120.0),
        time: 0.0,
        lens: Vec2::new(0.5, 0.6),
        wavelength: 0.5,
    };
    let [open, bare, coated] = cameras.map(|camera| {
        let mut rays = [None];
        camera.rays(&[sample], false, &mut rays);
        let ray = rays[0].unwrap();
        (ray.weight, ray.tint)
    });
    assert_eq!(open.1, Rgb::ONE);
    // The weight, which densities are made of, is the same but for single precision.
    assert!((bare.0 / open.0 - 1.0).abs() < 1e-5);
    assert!((0.45..0.75).contains(&bare.1.y), "{bare:?}");
    assert!((0.9..0.99).contains(&coated.1.y), "{coated:?}");
    // Green passes best.
    assert!(
        coated.1.y > coated.1.x && coated.1.y > coated.1.z,
        "{coated:?}"
    );
    let photograph = |spec: &RealisticSpec| spec.photograph(&FILM).t_number.unwrap();
    let spec = reflecting();
    let (dark, light) = (photograph(&spec), photograph(&double_gauss()));
    let transmitted = Ghosts::new(spec.lens.clone(), None).transmitted()[0];
    assert!(((light / dark).powi(2) / transmitted - 1.0).abs() < 1e-12);
}
