//! One scene for each class of light path, against pbrt-v3's `bdpt` (`path` and `mlt` for some): lights without area, with area
//! and at infinity, off mirrors, through smooth and rough glass, in media, through holes, in instances and in motion.
//!
//! Scenes and references (`refimages/census`) are small, 40 × 40 pixels, and made like those of [`crate::references`]. Blocks
//! of 8 and 32 pixels and the whole image are compared. Single pixels are not: few light paths come to a dim one, so its
//! variance is known from few numbers, and its distribution is far from normal.
//!
//! **False alarms.** [`ALPHA`] bounds the probability for one scene and all its tests together: 0.6 % for all scenes, thrown once for
//! each change of the program's random numbers.
//!
//! **What is found.** With twice the samples of [`SAMPLES`], a bias of 0.5 % over an image, 1 % over a quarter of it and 2 to 5 %
//! in the median block of 8 × 8 pixels; with these, at most √2 times as much, as part of the noise is the reference's.

use crate::common::rendering::{Render, explain};
use fstop::compare::{Estimate, Options, compare};
use fstop::film::{Image, PixelBounds, read};
use fstop::math::Rgb;
use fstop::math::color::luminance;
use std::path::Path;

/// False-alarm rate of one scene.
const ALPHA: f64 = 1e-4;

/// Samples in an image at most, all pixels and runs together: about a quarter of a second each on one core.
const SAMPLES: f64 = if cfg!(debug_assertions) { 1e5 } else { 2e5 };

/// A Markov chain's neighboring pixels vary together: the variance of a block of 8 × 8 is up to this many times that of
/// independent ones (4 to 8, from the scatter of the chains).
const CHAINED: f32 = 8.0;

/// Scenes with a few paths that are far brighter than the others, and how many times more samples they need.
const HEAVY: &[(&str, f64)] = &[
    // Its sphere shows the caustic through glass and by a lamp of two triangles.
    ("areatri_glassball_bdpt", 8.0),
    ("twolights_glassball_bdpt", 8.0),
    // So few samples are bright in a dark block above its mirror that not even their variance is known.
    ("areasphere_sdsmirror_bdpt", 8.0),
];

/// Blocks whose light is less than this part of the mean are made black: it is what a few of a hundred thousand paths bring, and
/// no variance is known where there was none of them.
const DARK: f32 = 1e-3;

/// Makes the blocks that are [`DARK`] in the reference black in both images.
fn blacken(reference: &mut Image, ours: &mut Image) {
    const SIDE: u32 = 8;
    let light = |image: &Image, block: PixelBounds| -> f32 {
        let sum: f32 = block.pixels().map(|p| luminance(image.pixel(p))).sum();
        sum / block.area() as f32
    };
    let mean = light(reference, reference.bounds);
    let blocks: Vec<PixelBounds> = reference.bounds.tiles(SIDE).collect();
    for block in blocks {
        if light(reference, block) >= DARK * mean || light(ours, block) >= 2.0 * DARK * mean {
            continue;
        }
        for image in [&mut *reference, &mut *ours] {
            for i in block.pixels().filter_map(|p| image.bounds.index(p)) {
                image.pixels[i] = Rgb::ZERO;
                image.variance.as_mut().expect("both have variances")[i] = Rgb::ZERO;
            }
        }
    }
}

/// Renders the scene and panics with a table where the image is not the reference's.
pub(crate) fn check(name: &str) {
    if crate::common::is_left_out("refimages") {
        return;
    }
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let file = root.join("refimages/census").join(name);
    let loaded = read(&file.with_extension("exr")).unwrap_or_else(|error| panic!("{error}"));
    let spp = f64::from(loaded.spp.expect("the reference counts its samples"));
    let reference_runs = f64::from(loaded.runs.expect("and its runs"));
    let scene = root
        .join("tests/scenes/census")
        .join(name)
        .with_extension("pbrt");
    let more = HEAVY.iter().find(|(heavy, _)| *heavy == name);
    let samples = SAMPLES * more.map_or(1.0, |(_, times)| *times);
    let runs = samples / (spp * loaded.image.pixels.len() as f64);
    let mut render = Render::as_good_as(&loaded.image, &scene, runs.round().max(2.0) as u32);
    let mut reference = Image {
        bounds: render.image.bounds,
        ..loaded.image
    };
    blacken(&mut reference, &mut render.image);
    if name.ends_with("_mlt") {
        let variances = reference
            .variance
            .as_mut()
            .expect("references have variances");
        variances
            .iter_mut()
            .for_each(|variance| *variance *= CHAINED);
    }
    let options = Options {
        alpha: ALPHA,
        blocks: vec![8, 32],
        ..Options::default()
    };
    let reference = Estimate {
        image: &reference,
        freedom: reference_runs - 1.0,
        pool: None,
        samples: None,
        light_paths: None,
    };
    let picture = render.estimate();
    let comparison =
        compare(&picture, &reference, &options).unwrap_or_else(|e| panic!("{name}: {e}"));
    assert!(
        comparison.agrees(),
        "{}",
        explain(name, &picture, &reference, &options, &comparison)
    );
}

/// One test for each scene.
macro_rules! scenes {
    ($($name:ident,)*) => {
        $(
            #[test]
            fn $name() {
                check(stringify!($name));
            }
        )*

        /// No scene is left out.
        #[test]
        fn every_scene_is_compared() {
            let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/scenes/census");
            for entry in std::fs::read_dir(folder).expect("the scenes are part of the project") {
                let path = entry.expect("a file").path();
                let name = path.file_stem().and_then(|name| name.to_str()).unwrap_or_default();
                if path.extension().is_some_and(|e| e == "pbrt") && !name.ends_with("_sppm") {
                    assert!([$(stringify!($name)),*].contains(&name), "{name}");
                }
            }
        }
    };
}

scenes! {
    areadisk_direct_bdpt,
    areadisk_prism_bdpt,
    areasphere_bulb_bdpt,
    areasphere_camerainglass_bdpt,
    areasphere_direct_bdpt,
    areasphere_environment_path,
    areasphere_glassball_bdpt,
    areasphere_glassball_mlt,
    areasphere_noneemitter_path,
    areasphere_rr_path,
    areasphere_sdsmirror_bdpt,
    areasphere_sdsmirror_path,
    areasphere_subsurface_path,
    areatri_direct_bdpt,
    areatri_glassball_bdpt,
    areatri_onesided_bdpt,
    distant_direct_bdpt,
    distant_glassball_bdpt,
    distant_instances_bdpt,
    distant_mirrorring_bdpt,
    goniometric_direct_bdpt,
    goniometric_glassslab_bdpt,
    goniometric_mirrorring_bdpt,
    infinite_direct_bdpt,
    infinite_glassball_bdpt,
    manylights_power_bdpt,
    manylights_uniform_bdpt,
    point_bulb_bdpt,
    point_direct_bdpt,
    point_glassball_bdpt,
    point_glossyring_bdpt,
    point_medium_bdpt,
    point_mirrorring_bdpt,
    projection_direct_bdpt,
    projection_glassball_bdpt,
    projection_mirrorpanel_bdpt,
    spot_alphasheet_bdpt,
    spot_camerainmedium_bdpt,
    spot_causticbounce_bdpt,
    spot_direct_bdpt,
    spot_glassball_bdpt,
    spot_glassball_mlt,
    spot_leak_bdpt,
    spot_maxdepth0_bdpt,
    spot_maxdepth1_bdpt,
    spot_maxdepth2_bdpt,
    spot_maxdepth3_bdpt,
    spot_mediumcaustic_bdpt,
    spot_mirrorball_bdpt,
    spot_mirrorpanel_bdpt,
    spot_motionglass_bdpt,
    spot_roughglass_bdpt,
    spot_translucent_bdpt,
    spot_twoballs_bdpt,
    sun_direct_bdpt,
    sun_glassball_bdpt,
    twolights_glassball_bdpt,
}
