//! Laws of light, through the whole program: pictures whose every pixel is known in closed form.

#[allow(dead_code, reason = "the comparison is for other tests")]
mod common;

use common::Render;
use std::io::Write;

/// Standard errors a picture's mean may be off: one false alarm in 15,000 means.
const SIGMAS: f64 = 4.0;

/// Renders the world with a camera that `look` places, and checks that the mean of each channel is
/// `expected`, but for noise and single precision.
fn check(name: &str, look: &str, integrator: &str, world: &str, expected: f64) {
    let text = format!(
        "{look}\nCamera \"perspective\" \"float fov\" [40]\n\
         Film \"image\" \"integer xresolution\" [24] \"integer yresolution\" [24]\n\
         Sampler \"random\" \"integer pixelsamples\" [64]\n\
         {integrator}\nWorldBegin\n{world}\nWorldEnd\n"
    );
    let mut file = tempfile::Builder::new()
        .suffix(".pbrt")
        .tempfile()
        .expect("a temporary file");
    file.write_all(text.as_bytes()).expect("room for a scene");
    let render = Render::new(file.path(), 1, 1, &[]);
    let image = &render.image;
    let count = image.pixels.len() as f64;
    let variances = image.variance.as_ref().expect("--variance was given");
    for channel in 0..3 {
        let mean = image
            .pixels
            .iter()
            .map(|p| f64::from(p[channel]))
            .sum::<f64>()
            / count;
        let variance = variances.iter().map(|v| f64::from(v[channel])).sum::<f64>();
        let error = variance.sqrt() / count;
        // Radiance is a chain of a dozen single-precision products per bounce.
        let allowed = SIGMAS * error + 1e-5 * expected;
        assert!(
            (mean - expected).abs() <= allowed,
            "{name}: {mean} where {expected} ± {error} is right"
        );
    }
}

const OUTSIDE: &str = "LookAt 0 0 -5  0 0 0  0 1 0";

/// Every path: none is cut short by its depth, and few by roulette.
const LONG: &str = "Integrator \"path\" \"integer maxdepth\" [300] \"float rrthreshold\" [0.01]";

/// A body in a white sky.
fn in_the_sky(material: &str, shape: &str) -> String {
    format!("LightSource \"infinite\" \"rgb L\" [1 1 1]\nMaterial {material}\n{shape}")
}

const BALL: &str = "Shape \"sphere\" \"float radius\" [3]";

#[test]
fn a_convex_body_that_absorbs_nothing_cannot_be_seen_in_a_white_sky() {
    for (name, material) in [
        ("matte", "\"matte\" \"rgb Kd\" [1 1 1]"),
        ("mirror", "\"mirror\" \"rgb Kr\" [1 1 1]"),
        ("glass", "\"glass\" \"rgb Kr\" [1 1 1] \"rgb Kt\" [1 1 1]"),
        (
            "dense glass",
            "\"glass\" \"rgb Kr\" [1 1 1] \"rgb Kt\" [1 1 1] \"float index\" [2.4]",
        ),
    ] {
        let path = "Integrator \"path\" \"integer maxdepth\" [300] \"float rrthreshold\" [0]";
        check(name, OUTSIDE, path, &in_the_sky(material, BALL), 1.0);
    }
}

#[test]
fn nor_can_it_when_it_moves_or_the_camera_does() {
    let moving = format!(
        "ActiveTransform EndTime Translate 1 .5 0 Rotate 130 1 2 0 Scale 1.2 .7 1 \
         ActiveTransform All {BALL}"
    );
    let swing = "ActiveTransform EndTime Rotate 20 0 1 0 Translate .3 0 0 ActiveTransform All\n\
                 LookAt 0 0 -5  0 0 0  0 1 0";
    let path = "Integrator \"path\" \"integer maxdepth\" [300] \"float rrthreshold\" [0]";
    let matte = "\"matte\" \"rgb Kd\" [1 1 1]";
    check("moving", OUTSIDE, path, &in_the_sky(matte, &moving), 1.0);
    check("swung", swing, path, &in_the_sky(matte, BALL), 1.0);
    let glass = "\"glass\" \"rgb Kr\" [1 1 1] \"rgb Kt\" [1 1 1]";
    check(
        "moving glass",
        OUTSIDE,
        path,
        &in_the_sky(glass, &moving),
        1.0,
    );
}

/// A black screen whose edge is drawn across the picture, from one border to the other, covers a
/// point for as much of the time as its edge is past it: half of all.
#[test]
fn what_moves_covers_for_as_long_as_it_is_there() {
    // Half the width of what the camera sees in the plane of the screen.
    let half = 5.0 * 20f64.to_radians().tan();
    let screen = "Shape \"trianglemesh\" \"integer indices\" [0 1 2 0 2 3] \
                  \"point P\" [-20 -9 0  0 -9 0  0 9 0  -20 9 0]";
    let drawn = |from: f64, to: f64, what: &str| {
        format!(
            "ActiveTransform StartTime Translate {from} 0 0 ActiveTransform EndTime \
             Translate {to} 0 0 ActiveTransform All {what}"
        )
    };
    let black = "\"matte\" \"rgb Kd\" [0 0 0]";
    let path = "Integrator \"path\"";
    for (name, times, expected) in [
        ("all of the way", "TransformTimes 0 1", 0.5),
        // From −half to the middle: the edge is past a quarter of the picture's points and times.
        ("half of it", "TransformTimes 0 2", 0.75),
        // Early for a quarter of the time, arrived for another.
        ("with rests", "TransformTimes .25 .75", 0.5),
    ] {
        let look = format!("{times}\n{OUTSIDE}");
        let world = in_the_sky(black, &drawn(-half, half, screen));
        check(name, &look, path, &world, expected);
        // The same as an instance, and as an object's own motion.
        let object = format!("ObjectBegin \"screen\" {screen} ObjectEnd");
        let instance = drawn(-half, half, "ObjectInstance \"screen\"");
        let world = in_the_sky(black, &format!("{object} {instance}"));
        check(name, &look, path, &world, expected);
        let object = drawn(-half, half, screen);
        let object = format!("ObjectBegin \"screen\" {object} ObjectEnd ObjectInstance \"screen\"");
        check(name, &look, path, &in_the_sky(black, &object), expected);
    }
    // And a camera that is drawn the other way.
    let look = format!("{}\n{OUTSIDE}", drawn(-half, half, ""));
    check("camera", &look, path, &in_the_sky(black, screen), 0.5);
}

/// A tenth of the light is lost at each of the bounces that a convex body allows: one.
#[test]
fn a_grey_convex_body_shows_its_albedo() {
    let close = "LookAt 0 0 -3.2  0 0 0  0 1 0";
    for integrator in [
        "Integrator \"path\"",
        "Integrator \"directlighting\"",
        "Integrator \"directlighting\" \"string strategy\" \"one\"",
        "Integrator \"whitted\"",
    ] {
        for (name, material) in [
            ("matte", "\"matte\" \"rgb Kd\" [.9 .9 .9]"),
            ("mirror", "\"mirror\" \"rgb Kr\" [.9 .9 .9]"),
        ] {
            let world = in_the_sky(material, BALL);
            check(name, close, integrator, &world, 0.9);
        }
    }
}

/// Inside a closed surface that emits 1 and reflects a, every direction shows
/// 1 + a + a² + … = 1/(1 − a); direct lighting stops after the first bounce.
#[test]
fn a_closed_furnace_glows_with_the_geometric_series() {
    let inside = "LookAt 0.3 -0.2 0.1  1 0.4 0.5  0 0 1";
    let room = |albedo: f64, shape: &str| {
        format!(
            "ReverseOrientation\nAreaLightSource \"diffuse\" \"rgb L\" [1 1 1]\n\
             Material \"matte\" \"rgb Kd\" [{albedo} {albedo} {albedo}]\n{shape}"
        )
    };
    let cube = "Shape \"trianglemesh\" \
        \"point P\" [-1 -1 -1  1 -1 -1  1 1 -1  -1 1 -1  -1 -1 1  1 -1 1  1 1 1  -1 1 1] \
        \"integer indices\" [0 2 1 0 3 2  4 5 6 4 6 7  0 1 5 0 5 4  2 3 7 2 7 6  1 2 6 1 6 5  0 4 7 0 7 3]";
    // A bowl with a lid, and a waisted tube with two. The disks overlap the rims.
    let bowl = "Translate 0 0 -1 Shape \"paraboloid\" \"float radius\" 2 \"float zmax\" 3 \
        Shape \"disk\" \"float radius\" 2.001 \"float height\" 3";
    let tube = "Shape \"hyperboloid\" \"point p1\" [1.2 -.8 -1] \"point p2\" [1.2 .8 1] \
        Shape \"disk\" \"float radius\" 1.443 \"float height\" 1 \
        ReverseOrientation Shape \"disk\" \"float radius\" 1.443 \"float height\" -1";
    let some = [0.0, 0.5, 0.8];
    for (shape, albedos) in [
        (BALL, &some[..]),
        (cube, &some),
        (bowl, &[0.8]),
        (tube, &[0.8]),
    ] {
        for &albedo in albedos {
            let world = room(albedo, shape);
            let series = 1.0 / (1.0 - albedo);
            check("path", inside, LONG, &world, series);
            let few = "Integrator \"path\" \"integer maxdepth\" [3]";
            let three = 1.0 + albedo + albedo.powi(2) + albedo.powi(3);
            check("path of three", inside, few, &world, three);
            for strategy in ["all", "one"] {
                let direct =
                    format!("Integrator \"directlighting\" \"string strategy\" \"{strategy}\"");
                check("direct", inside, &direct, &world, 1.0 + albedo);
            }
        }
    }
}

/// A Lambertian floor under a point light: Kd/π · I cos θ/d², at any scale of the scene.
#[test]
fn a_point_light_falls_off_with_the_square_of_the_distance() {
    for scale in [1e-4, 1.0, 1e4] {
        // From so high above, compared with the light, that the film sees all but one point.
        let look = format!("LookAt 0 {0} 0  0 0 0  1 0 0", 1e-3 * scale);
        let world = format!(
            "LightSource \"point\" \"rgb I\" [{i} {i} {i}] \"point from\" [{x} {h} 0]\n\
             Material \"matte\" \"rgb Kd\" [.5 .5 .5]\nRotate -90 1 0 0\n\
             Shape \"disk\" \"float radius\" [{scale}]",
            i = 8.0 * scale * scale,
            x = 1.5 * scale,
            h = 2.0 * scale,
        );
        // d² = 1.5² + 2², cos θ = 2/d. The mean over the small square seen differs by 1e-7.
        let expected = 0.5 / std::f64::consts::PI * 8.0 * (2.0 / 2.5) / 6.25;
        check("point", &look, "Integrator \"path\"", &world, expected);
    }
}
