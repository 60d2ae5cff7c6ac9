//! The caustic of a lamp without area on the film of a 50 mm double Gauss: light is traced from the lamp through a glass ball, off the
//! floor and through the lens.

use crate::common::rendering::Render;
use fstop::math::color::luminance;
use std::path::Path;

/// The spot light, or a sphere of 1 mm radius with the same intensity. A black sheet with a hole is before both, so that they shine on the
/// same: the ball and little around it, all of it in the spot light's even part.
fn scene(spot: bool, spp: u32) -> String {
    let lens =
        Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/scenes/census/lenses/dgauss50.dat");
    let radius = 1e-3;
    let radiance = 32.0 / (std::f64::consts::PI * radius * radius);
    let lamp = match spot {
        true => "LightSource \"spot\" \"point from\" [-2.25 3 0] \"point to\" [-.75 1.125 0] \"rgb I\" [32 32 32] \
                 \"float coneangle\" 34 \"float conedeltaangle\" 4"
            .to_string(),
        false => format!(
            "AttributeBegin AreaLightSource \"diffuse\" \"rgb L\" [{radiance} {radiance} {radiance}] \
             Translate -2.25 3 0 Shape \"sphere\" \"float radius\" {radius} AttributeEnd"
        ),
    };
    format!(
        "LookAt 0 3 -4  0 .25 0  0 1 0\n\
         Camera \"realistic\" \"string lensfile\" \"{}\" \"float aperturediameter\" 17.1 \"float focusdistance\" 4.75\n\
         Film \"image\" \"integer xresolution\" 32 \"integer yresolution\" 32 \"float diagonal\" 35\nPixelFilter \"box\"\n\
         Sampler \"random\" \"integer pixelsamples\" {spp}\nIntegrator \"bdpt\" \"integer maxdepth\" 4\nWorldBegin\n{lamp}\n\
         AttributeBegin Material \"matte\" \"rgb Kd\" [0 0 0] Translate -2.25 3 0 Rotate -51.34 0 0 1 Rotate 90 0 1 0\n\
         Shape \"disk\" \"float height\" .25 \"float radius\" 3 \"float innerradius\" .1 AttributeEnd\n\
         AttributeBegin Material \"glass\" Translate -.75 1.125 0 Shape \"sphere\" \"float radius\" .75 AttributeEnd\n\
         Material \"matte\" Shape \"trianglemesh\" \"integer indices\" [0 1 2 0 2 3] \
         \"point P\" [-4 0 -4  4 0 -4  4 0 4  -4 0 4]\nWorldEnd\n",
        lens.display()
    )
}

/// The means of images of `spp` samples with these many seeds, and the standard error of their mean.
fn mean_and_error(spot: bool, spp: u32, seeds: u32) -> (f64, f64) {
    let means: Vec<f64> = { 1..=seeds }
        .map(|seed| {
            let image = Render::of_text(&scene(spot, spp), seed).image;
            let sum: f64 = image.pixels.iter().map(|p| f64::from(luminance(*p))).sum();
            sum / image.pixels.len() as f64
        })
        .collect();
    let count = f64::from(seeds);
    let mean = means.iter().sum::<f64>() / count;
    let squares: f64 = means.iter().map(|m| (m - mean).powi(2)).sum();
    (mean, (squares / (count - 1.0) / count).sqrt())
}

/// No lamp without area is met by a path from the camera: what is seen of it comes through the lens from the light's side. That of a small
/// lamp with an area is the same light.
#[test]
fn a_spot_light_is_a_small_lamp() {
    let (spot, spot_error) = mean_and_error(true, 256, 5);
    let (lamp, lamp_error) = mean_and_error(false, 256, 5);
    let error = spot_error.hypot(lamp_error);
    // 5 standard errors, as five seeds tell little of them: by Student's t with 4 degrees of freedom at most one false alarm in 130.
    let allowed = 0.005 * spot + 5.0 * error;
    assert!(
        (spot - lamp).abs() <= allowed,
        "{spot} and {lamp}, ± {error}"
    );
    assert!(error < 0.01 * spot, "± {error} of {spot} tells nothing");
}
