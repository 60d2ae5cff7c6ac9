//! Every scene of `tests/scenes/reference` against pbrt-v3's image of it in `refimages`.
//!
//! The references are means of 16 to 64 independent runs of pbrt-v3 with the random sampler, with the
//! variance of that mean (written by us from its output; `refimages/README.md`). Each scene is
//! rendered at its own samples per pixel, as often as it takes to reach [`SAMPLES`] or to have no more noise than the reference, and
//! compared by t-tests on pixels, on blocks of 8 and of 32 pixels and on the whole image.
//!
//! **False alarms.** [`ALPHA`] bounds, for one scene and all its tests together, the probability that
//! a renderer of the right expectation fails: 1e-4, so 0.9 % for the 87 scenes. Seeds are fixed, so
//! this is thrown once for each change of the program's random numbers, not at each run of the tests.
//!
//! **Tables.** The tests write `docs/generated/references.md`, with what is left out, and fail where it is out of date (`tests/scenes/references/table.rs` says how).
//!
//! **What is found.** With 1 to 2 % noise per pixel on either side, a bias of 0.3 % over an image,
//! 0.5 % over a quarter of it, 2 % over a block of 8 × 8 pixels, or 15 % in one pixel.

mod table;

use crate::common::rendering::{Render, explain};
use fstop::compare::{Comparison, Estimate, Options, compare};
use fstop::film::{Image, read};
use fstop::math::color::luminance;
use fstop::math::{Rgb, UVec2};
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use table::{Entry, Reason};

/// False-alarm rate of one scene.
const ALPHA: f64 = 1e-4;

/// Samples in an image at most, all pixels and runs together: about a second each on one core. An
/// unoptimized program gets fewer.
const SAMPLES: f64 = if cfg!(debug_assertions) { 2e5 } else { 1.5e6 };

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

fn scene_file(name: &str) -> PathBuf {
    root()
        .join("tests/scenes/reference")
        .join(name)
        .with_extension("pbrt")
}

fn reference_file(name: &str) -> PathBuf {
    root().join("refimages").join(name).with_extension("exr")
}

/// A scene and what must be known about its reference.
struct Case {
    name: &'static str,
    /// Pixels that one of the reference's samples falls on: pbrt-v3 adds each sample to all pixels
    /// within its filter's radius. So a pixel there has met that many times more samples than ours,
    /// which importance-sample the filter, and is correlated with its neighbors.
    splat: f32,
    /// Pixels where pbrt-v3 is known to be wrong.
    left_out: LeftOut,
    /// False where pbrt-v3's integrator ignores `Sampler`, and the reference's samples are of
    /// another kind.
    own_samples: bool,
    /// Differences up to this fraction of a value do not count.
    tolerance: f64,
    /// Sides of the blocks of pixels that are compared.
    blocks: &'static [u32],
}

/// Pixels that are not compared.
enum LeftOut {
    None,
    /// Those that change by more than a twentieth when lines with this text are taken out of the scene.
    Showing(&'static str),
    /// Those in columns and rows from here on.
    From(UVec2),
    /// Those in columns and rows from the first point up to, and without, the second.
    Within(UVec2, UVec2),
}

/// `Shape "cone"`: pbrt-v3 solves for the hit in single precision and, unlike its spheres and
/// cylinders, does not move the point onto the surface. The discriminant cancels, more so the
/// farther and smaller the cone, by more than its error bound knows of, so that shadow rays start
/// inside. Its arithmetic done again step by step has 3 % of the shadow rays blocked by the cone itself
/// near the base of `shape_instancing`'s and 60 % near the tip, where the reference is dark;
/// for a convex body they should be none.
const SHADOWED_CONES: LeftOut = LeftOut::Showing("Shape \"cone\"");

/// A quadric under a mirroring transformation: in pbrt-v3 rays see its light on one side and
/// light sampling sends it to the other (docs/scene-language.md §4.5). Two of the four disks light the floor
/// before the right half of the image wrongly.
const MIRRORED_DISKS: LeftOut = LeftOut::From(UVec2::new(16, 26));

/// Where the glass ball of `int_sppm` stands on the floor. pbrt-v3's photons also count for a point
/// when they land on the ball itself within the radius of 0.08, going in and coming out: a bright
/// rim around the contact, up to four times what the floor there receives. It would shrink away with
/// more iterations. With photons kept there our image is the reference's in these pixels too.
const GLASS_PHOTONS: LeftOut = LeftOut::Within(UVec2::new(38, 55), UVec2::new(53, 61));

/// How far `shape_alpha` may be off: light under a quad with holes for shadow rays only depends on the
/// weights of multiple importance sampling and on the density of light samples. In its quarter of the
/// image that makes 0.3 % (measured for `docs/compatibility.md`).
const SHADOW_HOLES: f64 = 0.004;

/// How far `mat_kdsubsurface` may be off: pbrt-v3 loses 1.4 % of the red light that comes out of its ball (measured for
/// `docs/compatibility.md`, "Subsurface light below curved surfaces"). `mat_subsurface` is held to noise alone.
const LOST_BELOW_A_BALL: f64 = 0.014;

/// What is left out, one for each of the constants above; `docs/compatibility.md` explains each under this heading.
const REASONS: &[Reason] = &[
    Reason {
        name: "SHADOWED_CONES",
        what: "Shadows that cones cast on themselves",
    },
    Reason {
        name: "MIRRORED_DISKS",
        what: "Light of mirrored quadrics",
    },
    Reason {
        name: "GLASS_PHOTONS",
        what: "Photons at the foot of a glass ball",
    },
];

/// What was left out of a scene.
struct Left {
    pixels: usize,
    of: usize,
    /// Our light over pbrt-v3's, in luminance.
    ratio: f64,
}

impl Case {
    const PLAIN: Case = Case {
        name: "",
        splat: 1.0,
        left_out: LeftOut::None,
        own_samples: true,
        tolerance: 1e-5,
        blocks: &[1, 8, 32],
    };

    /// Renders the scene and panics with a table where the image is not the reference's.
    fn check(&self) {
        let name = self.name;
        let loaded = read(&reference_file(name)).unwrap_or_else(|error| panic!("{error}"));
        let (spp, runs) = (loaded.spp, loaded.runs);
        let (spp, reference_runs) = spp.zip(runs).expect("the reference counts its samples");
        let runs = SAMPLES / (f64::from(spp) * loaded.image.pixels.len() as f64);
        let runs = runs.round().max(1.0) as u32;
        let mut render = Render::as_good_as(&loaded.image, &scene_file(name), runs);
        if self.own_samples {
            assert_eq!(
                render.spp,
                f64::from(spp),
                "{name}: the scene's samples per pixel"
            );
        }

        // pbrt-v3 was made to write PFM files, which do not know where the crop window lies.
        let mut reference = Image {
            bounds: render.image.bounds,
            ..loaded.image
        };
        blacken(&mut reference, &mut render.image);
        self.spread(&mut reference);
        let left_out = self.leave_out(&mut render.image, &mut reference);

        let options = Options {
            alpha: ALPHA,
            relative_tolerance: self.tolerance,
            blocks: self.blocks.to_vec(),
            ..Options::default()
        };
        // A mutation or a photon pass is worth less or more than one of our samples.
        let samples = self
            .own_samples
            .then_some(f64::from(spp) * f64::from(reference_runs));
        let freedom = f64::from(reference_runs) - 1.0;
        let (picture, reference) = (
            render.estimate(),
            Estimate {
                image: &reference,
                freedom,
                pool: None,
                samples,
                light_paths: None,
            },
        );
        let comparison =
            compare(&picture, &reference, &options).unwrap_or_else(|e| panic!("{name}: {e}"));
        assert!(
            comparison.agrees(),
            "{}",
            explain(name, &picture, &reference, &options, &comparison)
        );
        table::record(&entries(), REASONS, name, self.row(&comparison, left_out));
    }

    /// The cells of `docs/generated/references.md` after the scene's name.
    fn row(&self, comparison: &Comparison, left_out: Option<Left>) -> [String; 4] {
        let source = std::fs::read_to_string(scene_file(self.name)).expect("read before");
        let channels = &comparison.metrics.channels;
        let ratios = channels.map(|means| match means.b {
            0.0 => "black".to_owned(),
            _ => format!("{:.4}", means.ratio),
        });
        let errors = channels.iter().filter_map(|means| means.ratio_error);
        let error = errors.filter(|e| e.is_finite()).fold(0.0, f64::max);
        let p = comparison.verdict.p();
        let p = if p < 0.01 {
            format!("{p:.1e}")
        } else {
            format!("{p:.2}")
        };
        let left_out = left_out.map_or_else(String::new, |left| {
            format!(
                "{} pixels of {}, {:.3} there",
                left.pixels, left.of, left.ratio
            )
        });
        let ratios = format!("{} ± {error:.4}", ratios.join(", "));
        [table::description(&source), ratios, p, left_out]
    }

    /// Makes the reference's variance that of independent pixels with the samples of one pixel each.
    fn spread(&self, reference: &mut Image) {
        let variance = reference
            .variance
            .as_mut()
            .expect("references have variances");
        variance.iter_mut().for_each(|v| *v *= self.splat);
    }

    /// Blackens what is not to be compared in both images.
    fn leave_out(&self, picture: &mut Image, reference: &mut Image) -> Option<Left> {
        let bounds = picture.bounds;
        let out: Vec<bool> = match self.left_out {
            LeftOut::None => return None,
            LeftOut::From(corner) => bounds.pixels().map(|p| p.cmpge(corner).all()).collect(),
            LeftOut::Within(low, high) => bounds
                .pixels()
                .map(|p| p.cmpge(low).all() && p.cmplt(high).all())
                .collect(),
            LeftOut::Showing(text) => self.showing(text),
        };
        // What is left must be worth the name.
        let share = out.iter().filter(|&&out| out).count() as f64 / out.len() as f64;
        assert!(
            (0.001..0.5).contains(&share),
            "{}: {share} of the pixels left out",
            self.name
        );
        let light = |image: &Image| -> f64 {
            let pixels = image.pixels.iter().zip(&out).filter(|(_, out)| **out);
            pixels.map(|(&p, _)| f64::from(luminance(p))).sum()
        };
        let left = Left {
            pixels: out.iter().filter(|&&out| out).count(),
            of: out.len(),
            ratio: light(picture) / light(reference),
        };
        for image in [picture, reference] {
            let variance = image.variance.as_mut().expect("both have variances");
            for i in (0..out.len()).filter(|&i| out[i]) {
                image.pixels[i] = Rgb::ZERO;
                variance[i] = Rgb::ZERO;
            }
        }
        Some(left)
    }

    /// Where the things whose lines have `text` show. From renders of their own, with other seeds
    /// than the image's: noise that chose pixels by their own values would bias what is left.
    fn showing(&self, text: &str) -> Vec<bool> {
        const OTHER_SEED: u32 = 1001;
        let scene = scene_file(self.name);
        let source = std::fs::read_to_string(&scene).expect("the scene is part of the project");
        let lines = source.lines().filter(|line| !line.contains(text));
        let mut changed = lines.collect::<Vec<_>>().join("\n");
        for folder in ["lenses", "textures", "geometry"] {
            let path = root().join("tests/scenes/reference").join(folder);
            changed = changed.replace(&format!("\"{folder}/"), &format!("\"{}/", path.display()));
        }
        let with = Render::new(&scene, OTHER_SEED, 1, &[]).image;
        let without = Render::of_text(&changed, OTHER_SEED).image;
        let differs =
            |(a, b): (&Rgb, &Rgb)| (*a - *b).abs().max_element() > 0.05 * a.max(*b).max_element();
        with.pixels
            .iter()
            .zip(&without.pixels)
            .map(differs)
            .collect()
    }
}

/// pbrt-v3 keeps its sums as XYZ in single precision; a channel that is black comes back as some
/// 1e-7 of the others, without noise. Where both images are black to 1e-6 both are made black.
fn blacken(reference: &mut Image, ours: &mut Image) {
    const BLACK: f32 = 1e-6;
    for i in 0..reference.pixels.len().min(ours.pixels.len()) {
        for c in 0..3 {
            if reference.pixels[i][c].abs() < BLACK && ours.pixels[i][c].abs() < BLACK {
                reference.pixels[i][c] = 0.0;
                ours.pixels[i][c] = 0.0;
                for image in [&mut *reference, &mut *ours] {
                    if let Some(variance) = &mut image.variance {
                        variance[i][c] = 0.0;
                    }
                }
            }
        }
    }
}

/// One test for each scene, with what differs from [`Case::PLAIN`].
macro_rules! scenes {
    ($($name:ident $({ $($field:ident: $value:expr),* })?,)*) => {
        /// Names, and what follows them below.
        const SCENES: &[(&str, &str)] =
            &[$((stringify!($name), concat!($($(stringify!($field: $value), ";",)*)?))),*];
        $(
            #[test]
            fn $name() {
                if crate::common::is_left_out("refimages") {
                    return;
                }
                #[allow(clippy::needless_update, reason = "some scenes name every field")]
                Case { name: stringify!($name), $($($field: $value,)*)? ..Case::PLAIN }.check();
            }
        )*
    };
}

scenes! {
    cam_environment,
    cam_orthographic,
    cam_perspective,
    cam_perspective_dof,
    cam_screenwindow_crop,
    course_dgauss { left_out: SHADOWED_CONES },
    course_fisheye { left_out: SHADOWED_CONES },
    course_telephoto { left_out: SHADOWED_CONES },
    course_wide { left_out: SHADOWED_CONES },
    extreme_grazing,
    extreme_huge_ground,
    extreme_scale_1e4,
    extreme_scale_1em3,
    extreme_translate,
    filter_gaussian { splat: 16.0 },
    filter_mitchell { splat: 16.0 },
    filter_sinc { splat: 36.0 },
    filter_triangle { splat: 12.0 },
    int_ao,
    int_bdpt,
    int_cornell_path,
    int_direct_all,
    int_direct_one,
    int_mlt { own_samples: false },
    int_path_rr,
    int_sppm { left_out: GLASS_PHOTONS },
    int_veach_mis,
    int_volpath_ball,
    int_volpath_fog,
    int_whitted,
    light_area_disk_sphere,
    light_area_tri_cylinder,
    light_blackbody_spectrum,
    light_distant,
    light_goniometric,
    light_infinite_const,
    light_infinite_map,
    light_point,
    light_projection,
    light_spot,
    light_twosided_scale,
    mat_bump,
    mat_disney_a,
    mat_disney_b,
    mat_glass_rough,
    mat_glass_smooth,
    mat_kdsubsurface { tolerance: LOST_BELOW_A_BALL },
    mat_matte,
    mat_metal_aniso,
    mat_metal_default,
    mat_metal_etak,
    mat_mirror,
    mat_mix,
    mat_plastic,
    mat_substrate,
    mat_subsurface,
    mat_translucent,
    mat_uber,
    realistic_dgauss100_full,
    realistic_dgauss50_full,
    realistic_dgauss50_stopped,
    realistic_fisheye10_full,
    realistic_focus_0p7m,
    realistic_focus_20m,
    realistic_focus_fisheye_1m,
    realistic_simpleweight_false,
    realistic_simpleweight_true,
    realistic_tele250_full,
    realistic_wide22_full,
    realistic_wide22_stopped,
    shape_alpha { tolerance: SHADOW_HOLES },
    shape_curve,
    shape_heightfield,
    shape_instancing { left_out: SHADOWED_CONES },
    shape_loopsubdiv,
    shape_motionblur,
    shape_nurbs,
    shape_orientation { left_out: MIRRORED_DISKS },
    shape_plymesh,
    shape_quadrics1,
    shape_quadrics2 { left_out: SHADOWED_CONES },
    shape_trianglemesh,
    tex_basic,
    tex_imagemap,
    tex_mappings,
    tex_minification,
    tex_procedural,
}

/// The scenes with the names of what they leave out.
fn entries() -> Vec<Entry> {
    let left_out = |fields: &str| {
        let field = |field: &str| {
            let (name, value) = field.split_once(':')?;
            (name.trim() == "left_out").then(|| value.trim().to_owned())
        };
        fields.split(';').find_map(field)
    };
    let entry = |&(name, fields): &(&'static str, &str)| Entry {
        name,
        left_out: left_out(fields),
    };
    SCENES.iter().map(entry).collect()
}

/// The committed tables hold each scene and what follows from their rows.
#[test]
fn the_tables_are_current() {
    table::check(&entries(), REASONS);
}

/// No scene is forgotten, and no reference is left without its scene.
#[test]
fn every_scene_and_every_reference_is_used() {
    if crate::common::is_left_out("refimages") {
        return;
    }
    let listed: BTreeSet<String> = SCENES.iter().map(|(name, _)| name.to_string()).collect();
    let found = |folder: &str, extension: &str| -> BTreeSet<String> {
        let entries =
            std::fs::read_dir(root().join(folder)).expect("the folder is part of the project");
        let paths = entries.map(|entry| entry.expect("a readable entry").path());
        let files = paths.filter(|path| path.extension().is_some_and(|e| e == extension));
        files
            .filter_map(|path| {
                path.file_stem()
                    .map(|stem| stem.to_string_lossy().into_owned())
            })
            .collect()
    };
    assert_eq!(found("tests/scenes/reference", "pbrt"), listed);
    assert_eq!(found("refimages", "exr"), listed);
}
