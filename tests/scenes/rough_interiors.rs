//! Rough boundaries below which light is scattered, around nothing or around a lamp: emission is seen through them as through glass, and
//! nothing else. `bdpt` has strategies that could see more, and weights that could count on it.

use crate::common::rendering::{Render, explain};
use fstop::compare::{Options, compare};

/// False-alarm rate of one comparison; there are eight.
const ALPHA: f64 = 1e-4;

/// Of which nearly nothing comes back, so that what is seen through it is most of the image.
const SKIN: &str = "Material \"subsurface\" \"rgb sigma_a\" [9 9 9] \"rgb sigma_s\" [1 1 1] \
                    \"float uroughness\" [.4] \"float vroughness\" [.4]\n";

const LAMP: &str = "AttributeBegin Translate 0 0 2 AreaLightSource \"diffuse\" \"rgb L\" [4 4 4] \
                    \"bool twosided\" \"true\" Material \"matte\" \"rgb Kd\" [0 0 0] \
                    Shape \"disk\" \"float radius\" [1] AttributeEnd\n";

/// Behind the camera, and above what it sees.
const WALLS: &str = "AttributeBegin Material \"matte\" \"rgb Kd\" [.8 .8 .8] Translate 0 0 -5 Shape \"disk\" \"float radius\" [6] \
                     Translate 0 2 5 Rotate 90 1 0 0 Shape \"disk\" \"float radius\" [4] AttributeEnd\n";

fn render(integrator: &str, world: &str) -> Render {
    let text = format!(
        "LookAt 0 0 -4  0 0 0  0 1 0\nCamera \"perspective\" \"float fov\" [40]\n\
         Film \"image\" \"integer xresolution\" [24] \"integer yresolution\" [24]\n\
         Sampler \"random\" \"integer pixelsamples\" [256]\n\
         Integrator \"{integrator}\" \"integer maxdepth\" [6]\nWorldBegin\n{world}WorldEnd\n"
    );
    Render::of_text(&text, 1)
}

fn same_with_bdpt(name: &str, world: &str) {
    let options = Options {
        alpha: ALPHA,
        blocks: vec![4, 24],
        ..Options::default()
    };
    let (path, bdpt) = (render("path", world), render("bdpt", world));
    let (a, b) = (bdpt.estimate(), path.estimate());
    let comparison = compare(&a, &b, &options).expect("images of one size");
    assert!(
        comparison.agrees(),
        "{}",
        explain(name, &a, &b, &options, &comparison)
    );
}

fn disk(z: f32) -> String {
    format!(
        "AttributeBegin {SKIN} Translate 0 0 {z} Shape \"disk\" \"float radius\" [1.2] AttributeEnd\n"
    )
}

#[test]
fn a_lamp_behind_a_disk() {
    same_with_bdpt("lamp", &format!("{LAMP}{}", disk(0.0)));
}

#[test]
fn walls_lit_through_a_disk() {
    same_with_bdpt("walls", &format!("{LAMP}{WALLS}{}", disk(0.0)));
}

/// What the lamp has lit is not seen through the disk.
#[test]
fn a_wall_behind_a_disk() {
    let wall = "AttributeBegin Material \"matte\" Translate 0 0 3 Shape \"disk\" \"float radius\" [5] AttributeEnd\n";
    same_with_bdpt("wall", &format!("{LAMP}{wall}{}{WALLS}", disk(0.5)));
}

#[test]
fn a_lamp_behind_two_disks() {
    same_with_bdpt("two", &format!("{LAMP}{}{}{WALLS}", disk(0.0), disk(1.0)));
}

/// A candle.
#[test]
fn a_lamp_in_a_ball() {
    let ball =
        format!("AttributeBegin {SKIN} Shape \"sphere\" \"float radius\" [1] AttributeEnd\n");
    let lamp = "AttributeBegin AreaLightSource \"diffuse\" \"rgb L\" [9 9 9] Shape \"sphere\" \"float radius\" [.2] AttributeEnd\n";
    same_with_bdpt("candle", &format!("{lamp}{ball}{WALLS}"));
}

/// With lights that only one of the strategies finds.
#[test]
fn lights_without_area_behind_a_disk() {
    for (name, light) in [
        (
            "point",
            "LightSource \"point\" \"point from\" [.3 0 2] \"rgb I\" [9 9 9]\n",
        ),
        ("sky", "LightSource \"infinite\" \"rgb L\" [.4 .5 .6]\n"),
        (
            "distant",
            "LightSource \"distant\" \"point from\" [.3 .2 2] \"rgb L\" [2 2 2]\n",
        ),
    ] {
        same_with_bdpt(name, &format!("{light}{}{WALLS}", disk(0.0)));
    }
}
