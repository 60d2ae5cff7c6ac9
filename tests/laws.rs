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
    for shape in [BALL, cube] {
        for albedo in [0.0, 0.5, 0.8] {
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

/// A medium that absorbs nothing in a white sky is as invisible as a body: where the radiance is 1
/// all around, scattering replaces 1 by 1. Dense and thin, forward, back, coloured, of one density
/// and of many, behind no surface and behind glass, around the camera.
#[test]
fn a_medium_that_absorbs_nothing_cannot_be_seen_in_a_white_sky() {
    let volpath = "Integrator \"volpath\" \"integer maxdepth\" [1000] \"float rrthreshold\" [0]";
    let sky = "LightSource \"infinite\" \"rgb L\" [1 1 1]\n";
    let fog = |sigma: &str, g: f32| {
        format!(
            "{sky}MakeNamedMedium \"m\" \"string type\" \"homogeneous\" \"rgb sigma_a\" [0 0 0] \
             \"rgb sigma_s\" [{sigma}] \"float g\" [{g}]\nMediumInterface \"m\" \"\"\n"
        )
    };
    let empty = format!("Material \"\"\n{BALL}");
    let glass = format!("Material \"glass\" \"rgb Kr\" [1 1 1] \"rgb Kt\" [1 1 1]\n{BALL}");
    for (name, sigma, g) in [
        ("thin", ".1 .1 .1", 0.0),
        ("dense", "3 3 3", 0.6),
        ("coloured", ".05 .5 2", -0.5),
    ] {
        let fog = fog(sigma, g);
        check(name, OUTSIDE, volpath, &format!("{fog}{empty}"), 1.0);
        let inside = "LookAt 0 0 -2  0 0 0  0 1 0";
        let world = format!("{fog}{empty}MediumInterface \"\" \"m\"");
        check(name, inside, volpath, &world, 1.0);
        check(name, OUTSIDE, volpath, &format!("{fog}{glass}"), 1.0);
    }
    let cloud = format!(
        "{sky}MakeNamedMedium \"m\" \"string type\" \"heterogeneous\" \"rgb sigma_a\" [0 0 0] \
         \"rgb sigma_s\" [2 2 2] \"integer nx\" 3 \"integer ny\" 2 \"integer nz\" 2 \
         \"float density\" [1 0 3 0 0 1  .2 1 0 1 2 0] \"point p0\" [-2 -2 -2] \"point p1\" [2 2 2]\n\
         MediumInterface \"m\" \"\"\n"
    );
    check("cloud", OUTSIDE, volpath, &format!("{cloud}{empty}"), 1.0);
}

/// Beer's law along camera rays and shadow rays, through borders of media that are empty surfaces.
#[test]
fn what_only_absorbs_dims_by_beers_law() {
    let volpath = "Integrator \"volpath\"";
    let sky = "LightSource \"infinite\" \"rgb L\" [1 1 1]\n";
    // From far away all rays cross the slab nearly straight: 1/cos 0.05° − 1 = 4e-7.
    let far = "LookAt 0 0 -5000  0 0 0  0 1 0\nScale 400 400 1";
    let slab = "Material \"\"\nTranslate 0 0 -2 ReverseOrientation Shape \"disk\" \"float radius\" 99\n\
                ReverseOrientation Translate 0 0 4 Shape \"disk\" \"float radius\" 99\n";
    let medium = |kind: &str| {
        format!(
            "MakeNamedMedium \"m\" \"string type\" {kind} \"rgb sigma_a\" [.3 .3 .3] \
             \"rgb sigma_s\" [0 0 0]\nMediumInterface \"m\" \"\"\n"
        )
    };
    let even = medium("\"homogeneous\"");
    // Constant between the centres of the first and last voxels, z = −3 and 3.
    let grid = medium(
        "\"heterogeneous\" \"integer nz\" 2 \"float density\" [1 1] \
         \"point p0\" [-1e4 -1e4 -6] \"point p1\" [1e4 1e4 6]",
    );
    for (name, medium) in [("homogeneous", &even), ("heterogeneous", &grid)] {
        let left = (-0.3f64 * 4.0).exp();
        check(name, far, volpath, &format!("{sky}{medium}{slab}"), left);
        // A floor behind the slab, lit through it from straight above: twice the way.
        let floor = "MediumInterface \"\" \"\"\nMaterial \"matte\" \"rgb Kd\" [1 1 1]\n\
                     Translate 0 0 3 Shape \"disk\" \"float radius\" 99\n";
        let sun = "LightSource \"distant\" \"point from\" [0 0 -1] \"point to\" [0 0 0]\n";
        let expected = left * left / std::f64::consts::PI;
        check(
            name,
            far,
            volpath,
            &format!("{sun}{medium}{slab}{floor}"),
            expected,
        );
        // `path` sees no medium, and surfaces without material are in its light's way.
        let path = "Integrator \"path\"";
        check(name, far, path, &format!("{sky}{medium}{slab}"), 1.0);
        check(name, far, path, &format!("{sun}{medium}{slab}{floor}"), 0.0);
    }
}
