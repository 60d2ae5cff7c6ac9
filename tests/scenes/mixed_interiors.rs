//! Mixes of materials that light wanders below: a disk in a sky, which sees nothing of itself but what
//! comes out of it again, so that the image of a mix is the mix of the parts' images.

use crate::common::rendering::{Render, explain};
use fstop::compare::{Estimate, Options, compare};
use fstop::film::Image;
use fstop::math::Rgb;

/// False-alarm rate of one comparison; there are ten.
const ALPHA: f64 = 1e-4;

/// The parts: with smooth and rough boundaries, long and short paths, and one without inside.
const PARTS: &str = "\
MakeNamedMaterial \"milk\" \"string type\" \"subsurface\" \"rgb sigma_a\" [.2 .5 1] \
  \"rgb sigma_s\" [20 15 10] \"float scale\" [1]
MakeNamedMaterial \"skin\" \"string type\" \"kdsubsurface\" \"rgb Kd\" [.8 .3 .2] \
  \"rgb mfp\" [.1 .05 .02] \"float uroughness\" [.3] \"float vroughness\" [.3]
MakeNamedMaterial \"wax\" \"string type\" \"subsurface\" \"rgb sigma_a\" [1 .3 .1] \
  \"rgb sigma_s\" [5 9 20] \"float uroughness\" [.4] \"float vroughness\" [.2]
MakeNamedMaterial \"clay\" \"string type\" \"disney\" \"rgb color\" [.7 .4 .3] \
  \"rgb scatterdistance\" [.2 .1 .05]
MakeNamedMaterial \"chalk\" \"string type\" \"matte\" \"rgb Kd\" [.6 .7 .8]
MakeNamedMaterial \"leaf\" \"string type\" \"translucent\" \"rgb Ks\" [0 0 0]
";

fn scene(material: &str) -> Render {
    let text = format!(
        "LookAt 0 0 -4  0 0 0  0 1 0\nCamera \"perspective\" \"float fov\" [32]\n\
         Film \"image\" \"integer xresolution\" [32] \"integer yresolution\" [32]\n\
         Sampler \"random\" \"integer pixelsamples\" [64]\n\
         Integrator \"path\" \"integer maxdepth\" [20]\nWorldBegin\n\
         LightSource \"infinite\" \"rgb L\" [.2 .2 .2]\n\
         LightSource \"distant\" \"point from\" [1 2 -1] \"rgb L\" [2 2 2]\n{PARTS}{material}\n\
         Shape \"disk\" \"float radius\" [1]\nWorldEnd\n"
    );
    Render::of_text(&text, 1)
}

fn alone(name: &str) -> Render {
    scene(&format!("NamedMaterial \"{name}\""))
}

fn mixed(first: &str, second: &str, amount: f32) -> Render {
    scene(&format!(
        "Material \"mix\" \"string namedmaterial1\" \"{first}\" \"string namedmaterial2\" \"{second}\" \
         \"rgb amount\" [{amount} {amount} {amount}]"
    ))
}

/// `amount` of one image and the rest of the other.
fn blend(a: &Render, b: &Render, amount: f32) -> Image {
    let rest = 1.0 - amount;
    let pairs = a.image.pixels.iter().zip(&b.image.pixels);
    let blended = |of: fn(&Image) -> Option<&Vec<Rgb>>| -> Option<Vec<Rgb>> {
        let variances = of(&a.image)?.iter().zip(of(&b.image)?);
        let of_sum = variances.map(|(&a, &b)| amount * amount * a + rest * rest * b);
        Some(of_sum.collect())
    };
    Image {
        pixels: pairs.map(|(&a, &b)| amount * a + rest * b).collect(),
        variance: blended(|image| image.variance.as_ref()),
        independent: blended(|image| image.independent.as_ref()),
        ..a.image.clone()
    }
}

fn same(name: &str, a: &Render, b: &Image) {
    let options = Options {
        alpha: ALPHA,
        blocks: vec![4, 16],
        ..Options::default()
    };
    let b = Estimate {
        image: b,
        ..a.estimate()
    };
    let a = a.estimate();
    let comparison = compare(&a, &b, &options).expect("images of one size");
    assert!(
        comparison.agrees(),
        "{}",
        explain(name, &a, &b, &options, &comparison)
    );
}

#[test]
fn all_of_a_part_is_the_part_alone() {
    for (part, other) in [("milk", "chalk"), ("skin", "milk"), ("clay", "wax")] {
        let alone = alone(part).image;
        same(&format!("all_{part}"), &mixed(part, other, 1.0), &alone);
        same(
            &format!("none_but_{part}"),
            &mixed(other, part, 0.0),
            &alone,
        );
    }
}

#[test]
fn a_mix_shows_what_comes_out_of_each_of_its_parts() {
    for (first, second, amount) in [
        ("chalk", "milk", 0.5),
        ("milk", "wax", 0.3),
        ("skin", "wax", 0.5),
        ("leaf", "skin", 0.4),
    ] {
        let expected = blend(&alone(first), &alone(second), amount);
        let name = format!("half_{first}_{second}");
        same(&name, &mixed(first, second, amount), &expected);
    }
}

/// Also where the mix is a part of another.
#[test]
fn parts_of_parts_are_found() {
    let nested = scene(
        "MakeNamedMaterial \"both\" \"string type\" \"mix\" \"string namedmaterial1\" \"skin\" \
         \"string namedmaterial2\" \"wax\"\n\
         Material \"mix\" \"string namedmaterial1\" \"chalk\" \"string namedmaterial2\" \"both\"",
    );
    let both = Render {
        image: blend(&alone("skin"), &alone("wax"), 0.5),
        ..alone("skin")
    };
    same("nested", &nested, &blend(&alone("chalk"), &both, 0.5));
}
