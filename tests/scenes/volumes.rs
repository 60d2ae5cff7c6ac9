//! pbrt-v2's volumes through the whole program, against closed forms and a quadrature.

use crate::common::rendering::Render;
use std::f64::consts::PI;

/// Standard errors an image's mean may be off: one false alarm in 15,000 means.
const SIGMAS: f64 = 4.0;

/// Renders what a camera at (0, 0, −5) sees that looks along +z through a hole of a tenth of a degree, and checks its mean.
fn check(name: &str, integrators: &str, world: &str, expected: f64) {
    let text = format!(
        "LookAt 0 0 -5  0 0 0  0 1 0\nCamera \"perspective\" \"float fov\" [.1]\n\
         Film \"image\" \"integer xresolution\" [16] \"integer yresolution\" [16]\n\
         Sampler \"random\" \"integer pixelsamples\" [256]\n\
         {integrators}\nWorldBegin\n{world}\nWorldEnd\n"
    );
    let image = Render::of_text(&text, 1).image;
    let count = image.pixels.len() as f64;
    let mean = image.pixels.iter().map(|p| f64::from(p.y)).sum::<f64>() / count;
    let variances = image.variance.as_ref().expect("--variance was given");
    let error = variances.iter().map(|v| f64::from(v.y)).sum::<f64>().sqrt() / count;
    // The hole is a thousandth of the box wide, and products are single-precision.
    let allowed = SIGMAS * error + 1e-4 * expected;
    assert!(
        (mean - expected).abs() <= allowed,
        "{name}: {mean} ± {error} where {expected} is right"
    );
    assert!(
        error <= 0.02 * expected,
        "{name}: a test that shows something: {error} of {expected}"
    );
}

/// A box from −1 to 1 with extinction 0.7 and the rest of its parameters.
fn fog(more: &str) -> String {
    format!(
        "Volume \"homogeneous\" \"rgb sigma_a\" [.2 .2 .2] \"rgb sigma_s\" [.5 .5 .5]\n\
         \"point p0\" [-1 -1 -1] \"point p1\" [1 1 1] {more}\n"
    )
}

/// Light from above.
const SUN: &str =
    "LightSource \"distant\" \"point from\" [0 1 0] \"point to\" [0 0 0] \"rgb L\" [3 3 3]\n";
const BLACK: &str = "Material \"matte\" \"rgb Kd\" [0 0 0]\n";

/// What the sun's light scattered once adds up to over the box's depth.
fn sunlit() -> f64 {
    let t = 0.7f64;
    3.0 * 0.5 / (4.0 * PI) * (-t).exp() * (1.0 - (-2.0 * t).exp()) / t
}

/// The same with each surface integrator, in a scene that is smaller than the box too.
#[test]
fn single_means_light_scattered_once() {
    let speck = format!(
        "{BLACK}TransformBegin Translate 0 0 9 Shape \"sphere\" \"float radius\" .1 TransformEnd\n"
    );
    for integrator in ["directlighting", "whitted", "path"] {
        let integrators = format!("SurfaceIntegrator \"{integrator}\" VolumeIntegrator \"single\"");
        check(
            integrator,
            &integrators,
            &format!("{SUN}{speck}{}", fog("")),
            sunlit(),
        );
    }
    let emission = "SurfaceIntegrator \"path\" VolumeIntegrator \"emission\"";
    let glow = fog("\"rgb Le\" [2 2 2]");
    let glowing = 2.0 * (1.0 - (-1.4f64).exp()) / 0.7;
    check(
        "emission",
        emission,
        &format!("{SUN}{speck}{glow}"),
        glowing,
    );
    let single = "SurfaceIntegrator \"path\" VolumeIntegrator \"single\"";
    check(
        "both",
        single,
        &format!("{SUN}{speck}{glow}"),
        glowing + sunlit(),
    );
    // Without a `VolumeIntegrator` it is \"emission\".
    check(
        "default",
        "SurfaceIntegrator \"path\"",
        &format!("{SUN}{speck}{glow}"),
        glowing,
    );
}

/// Two boxes of half the matter each are one; so is a constant grid, in turned space.
#[test]
fn the_same_matter_otherwise_said_gives_the_same_light() {
    let single = "SurfaceIntegrator \"path\" VolumeIntegrator \"single\"";
    let half = "Volume \"homogeneous\" \"rgb sigma_a\" [.1 .1 .1] \"rgb sigma_s\" [.25 .25 .25]\n\
                \"point p0\" [-1 -1 -1] \"point p1\" [1 1 1]\n";
    check(
        "two halves",
        single,
        &format!("{SUN}{half}{half}"),
        sunlit(),
    );
    let grid = "TransformBegin Rotate 90 1 0 0 Scale 2 1 1\n\
                Volume \"volumegrid\" \"rgb sigma_a\" [.1 .1 .1] \"rgb sigma_s\" [.25 .25 .25]\n\
                \"point p0\" [-.5 -1 -1] \"point p1\" [.5 1 1]\n\
                \"integer nx\" 2 \"integer ny\" 1 \"integer nz\" 3 \"float density\" [2 2 2 2 2 2] TransformEnd\n";
    check("grid", single, &format!("{SUN}{grid}"), sunlit());
}

#[test]
fn a_point_light_in_fog_is_the_integral_over_the_ray() {
    // The light stands at (0, 0.5, 0.2), inside the box.
    let n = 100_000;
    let point = |i: i32| {
        let z = -1.0 + 2.0 * (f64::from(i) + 0.5) / f64::from(n);
        let distance2 = 0.25 + (z - 0.2) * (z - 0.2);
        let way = (z + 1.0) + distance2.sqrt();
        // The phase function of Henyey and Greenstein, mean cosine 0.5, of the turn from the light's way to the camera's.
        let cosine = -(z - 0.2) / distance2.sqrt();
        let phase = 0.75 / (4.0 * PI * (1.25 - cosine).powf(1.5));
        0.5 * phase * (-0.7 * way).exp() / distance2
    };
    let expected = (0..n).map(point).sum::<f64>() * 2.0 / f64::from(n);
    let light = "LightSource \"point\" \"point from\" [0 .5 .2]\n";
    let single = "SurfaceIntegrator \"directlighting\" VolumeIntegrator \"single\"";
    check(
        "point light",
        single,
        &format!("{light}{}", fog("\"float g\" .5")),
        expected,
    );
}

/// Fog dims what is seen and what it is lit by, through mirrors and glass too.
#[test]
fn fog_dims_surfaces_and_their_light() {
    let lit = "LightSource \"point\" \"point from\" [0 0 -5]\n";
    let wall = "Material \"matte\" \"rgb Kd\" [1 1 1]\n\
                TransformBegin Translate 0 0 .5 Shape \"disk\" \"float radius\" 9 TransformEnd\n";
    let glass = "Material \"glass\" \"rgb Kr\" [0 0 0] \"float index\" 1 Shape \"sphere\" \"float radius\" .3\n";
    // 1.5 of fog on the way there, the same on the way back.
    let expected = (-2.1f64).exp() / (PI * 5.5 * 5.5);
    for integrator in ["directlighting", "path"] {
        let integrators = format!("SurfaceIntegrator \"{integrator}\" \"integer maxdepth\" 1");
        check(
            integrator,
            &integrators,
            &format!("{lit}{wall}{}", fog("")),
            expected,
        );
    }
    // A sky that the camera sees through a ball that bends nothing.
    let sky = "LightSource \"infinite\"\n";
    let through = format!("{sky}{glass}{}", fog(""));
    check(
        "glass",
        "SurfaceIntegrator \"path\"",
        &through,
        (-1.4f64).exp(),
    );
}

/// `volpath` scatters as often as light does: matter that absorbs nothing cannot be seen in a white sky.
#[test]
fn volpath_follows_light_through_volumes_without_end() {
    let volpath = "Integrator \"volpath\" \"integer maxdepth\" 300 \"float rrthreshold\" 0";
    let cloud = "Volume \"volumegrid\" \"rgb sigma_s\" [2 2 2] \"point p0\" [-1 -1 -1] \"point p1\" [1 1 1]\n\
                 \"integer nx\" 2 \"float density\" [0 1]\n";
    check(
        "white sky",
        volpath,
        &format!("LightSource \"infinite\"\n{cloud}"),
        1.0,
    );
}
