//! Curves that emit, against emitters of other shapes that send the same light, and against
//! themselves where lights are sampled and where they are not.

use crate::common::rendering::{Render, explain};
use fstop::compare::{Options, compare};

/// False-alarm rate of one comparison; there are ten.
const ALPHA: f64 = 1e-4;

/// Strips end where the ray's nearest point on the axis does, tubes where their surface does: farther by
/// a radius times the cotangent of the angle to the axis. Of this lamp, whose ends are 9 times as far
/// from the floor below its middle as that is, it is a ten-thousandth of the light.
const ENDS: f64 = 2e-4;

fn scene(integrator: &str, sides: [&str; 2], lamp: &str) -> Render {
    let text = format!(
        "LookAt 0 1.2 -3  0 .3 0  0 1 0\nCamera \"perspective\" \"float fov\" [40]\n\
         Film \"image\" \"integer xresolution\" [48] \"integer yresolution\" [32]\n\
         Sampler \"random\" \"integer pixelsamples\" [64]\n{integrator}\nWorldBegin\n\
         Material \"plastic\" \"float roughness\" [.2] \"rgb Ks\" [.4 .4 .4]\n{}\n\
         Shape \"trianglemesh\" \"integer indices\" [0 1 2 0 2 3] \
         \"point P\" [-4 0 -4  4 0 -4  4 0 4  -4 0 4]\n\
         Shape \"sphere\" \"float radius\" [.25]\n{}\n\
         AreaLightSource \"diffuse\" \"rgb L\" [9 6 3]\n{lamp}\nWorldEnd\n",
        sides[0], sides[1]
    );
    Render::of_text(&text, 1)
}

/// Panics where two pictures have not the same expectation.
fn same(name: &str, a: &Render, b: &Render, tolerance: f64) {
    let options = Options {
        alpha: ALPHA,
        relative_tolerance: tolerance,
        blocks: vec![8, 32],
        ..Options::default()
    };
    let (a, b) = (a.estimate(), b.estimate());
    let comparison = compare(&a, &b, &options).expect("pictures of one size");
    assert!(
        comparison.agrees(),
        "{}",
        explain(name, &a, &b, &options, &comparison)
    );
    let lit = comparison.metrics.channels.iter().all(|c| c.a > 0.01);
    assert!(lit, "{name}: nothing is lit");
}

const PATH: &str = "Integrator \"path\" \"integer maxdepth\" [3]";
const WHITTED: &str = "Integrator \"whitted\"";
const DIRECT: &str = "Integrator \"directlighting\"";

/// A strip that turns to whoever looks is a glowing tube of its width, in every integrator.
#[test]
fn a_straight_strip_is_a_thin_tube() {
    const AIR: [&str; 2] = ["", ""];
    const FOG: [&str; 2] = [
        "MakeNamedMedium \"fog\" \"string type\" \"homogeneous\" \"rgb sigma_a\" [.02 .02 .02] \
         \"rgb sigma_s\" [.1 .1 .1]\nMediumInterface \"\" \"fog\"",
        "",
    ];
    let tube = "AttributeBegin Translate 0 .7 .3 Rotate 90 0 1 0 \
                Shape \"cylinder\" \"float radius\" [.05] \"float zmin\" [-6] \"float zmax\" [6] \
                AttributeEnd";
    let strip = |kind: &str| {
        format!(
            "Shape \"curve\" \"string type\" \"{kind}\" \"float width\" [.1] \
             \"point P\" [-6 .7 .3  -2 .7 .3  2 .7 .3  6 .7 .3]"
        )
    };
    for (name, integrator, sides, kind) in [
        ("path", PATH, AIR, "flat"),
        ("directlighting", DIRECT, AIR, "cylinder"),
        ("whitted", WHITTED, AIR, "flat"),
        (
            "volpath",
            "Integrator \"volpath\" \"integer maxdepth\" [3]",
            FOG,
            "cylinder",
        ),
    ] {
        let a = scene(integrator, sides, &strip(kind));
        let b = scene(integrator, sides, tube);
        same(&format!("strip_tube_{name}"), &a, &b, ENDS);
    }
}

/// A ribbon shines on the side of its normals, unless both sides do. (It is no rectangle: as in pbrt-v3
/// its width shrinks with the cosine to its normal also where it is seen from along the strip.)
#[test]
fn ribbons_shine_on_the_side_of_their_normals() {
    let ribbon = |n: &str, sides: &str| {
        format!(
            "AreaLightSource \"diffuse\" \"rgb L\" [9 6 3] \"bool twosided\" \"{sides}\"\n\
             Shape \"curve\" \"string type\" \"ribbon\" \"float width\" [.2] \"normal N\" [{n} {n}] \
             \"point P\" [-2 .7 .3  -.7 .7 .3  .7 .7 .3  2 .7 .3]"
        )
    };
    let [up, down, both] = [("0 1 0", "false"), ("0 -1 0", "false"), ("0 1 0", "true")]
        .map(|(n, sides)| scene(DIRECT, ["", ""], &ribbon(n, sides)).image.pixels);
    // The last rows are floor, the camera is above the ribbon.
    let floor = up.len() - 4 * 48..;
    for (i, ((up, down), both)) in up.iter().zip(&down).zip(&both).enumerate() {
        let on_floor = floor.contains(&i);
        assert!(!on_floor || (up.max_element() == 0.0 && down.min_element() > 0.0));
        // The same random numbers choose the same points of the same lamp.
        let off = (*both - *up - *down).abs().max_element();
        assert!(off < 1e-5 * both.max_element().max(1.0), "pixel {i}: {off}");
    }
    assert!(up.iter().any(|p| p.min_element() > 1.0));
}

/// Bent strips of several segments and widths: what light sampling alone finds (`whitted`) is what it
/// finds together with scattered rays (`path`, `directlighting` with one light at a time), also under
/// transformations that keep no angles, and on the strips themselves.
#[test]
fn light_sampling_and_scattered_rays_agree() {
    for (kind, normals) in [
        ("flat", ""),
        ("cylinder", ""),
        ("ribbon", "\"normal N\" [0 -1 0  0 -1 -1  0 -1 0]"),
    ] {
        let lamp = format!(
            "AttributeBegin Translate 0 .5 0 Scale 1.3 .8 1\n\
             Shape \"curve\" \"string type\" \"{kind}\" {normals} \"float width0\" [.2] \
             \"float width1\" [.02] \"point P\" [-1.2 0 0  -1 .8 -.5  -.5 .8 .5  0 .2 -.3 \
             .5 -.3 -.9  .8 .4 .4  1 .3 0]\nAttributeEnd"
        );
        let light = scene(WHITTED, ["", ""], &lamp);
        let path = scene(
            "Integrator \"path\" \"integer maxdepth\" [1]",
            ["", ""],
            &lamp,
        );
        let one = "Integrator \"directlighting\" \"string strategy\" \"one\"";
        let one = scene(one, ["", ""], &lamp);
        same(&format!("bent_{kind}_path"), &light, &path, 1e-5);
        same(&format!("bent_{kind}_one"), &light, &one, 1e-5);
    }
}
