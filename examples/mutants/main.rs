//! A test of the test: does a small suite find bugs that are known to be there?
//!
//! `cargo run --release --features studies --example mutants` copies the sources, puts the bugs of `bugs.toml` into them, all at once, each switched on by
//! a number in the environment (mutant schemata: R. Untch, A. Offutt and M. Harrold, "Mutation analysis using mutant schemata",
//! ISSTA 1993), builds that once, and runs the suite below for each bug, with a seed of its own. Writes `docs/generated/mutants.md`.
//! An argument is a folder for the copy, its build and what was found so far: a run that was interrupted goes on.
//!
//! Only scenes whose picture a bug changes, be it a bit of one pixel, are rendered with it: a render is a pure function of scene and seed.
//!
//! A bug counts if it changes the light by 1 % or more on 5 % of a scene's pixels or more, as measured in blocks of 8 × 8 pixels of renders of
//! one seed, with the bug and without, where that is also three standard errors. Other rules are applied to the same images. Those with a
//! threshold are given the best that it can be: the strictest that raises no alarm among the [`CLEAN`] runs without a bug.

#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    reason = "a panic is an answer here"
)]
#![allow(clippy::print_stderr)]

use fstop::film::{Image, PixelBounds, read};
use fstop::math::color::luminance;
use serde::{Deserialize, Serialize};
use serde_json::Value;
use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

/// Scenes of `tests/scenes/reference`, of 64 × 64 pixels and less.
const SCENES: [&str; 45] = [
    "cam_environment",
    "cam_perspective_dof",
    "filter_gaussian",
    "filter_mitchell",
    "filter_triangle",
    "int_ao",
    "int_bdpt",
    "int_cornell_path",
    "int_direct_all",
    "int_direct_one",
    "int_path_rr",
    "int_veach_mis",
    "int_volpath_ball",
    "int_volpath_fog",
    "int_whitted",
    "light_area_disk_sphere",
    "light_area_tri_cylinder",
    "light_goniometric",
    "light_infinite_const",
    "light_infinite_map",
    "light_point",
    "light_projection",
    "light_spot",
    "light_twosided_scale",
    "mat_bump",
    "mat_disney_a",
    "mat_disney_b",
    "mat_glass_rough",
    "mat_glass_smooth",
    "mat_kdsubsurface",
    "mat_matte",
    "mat_metal_aniso",
    "mat_mirror",
    "mat_mix",
    "mat_plastic",
    "mat_substrate",
    "mat_subsurface",
    "mat_translucent",
    "mat_uber",
    "realistic_dgauss50_full",
    "tex_basic",
    "tex_imagemap",
    "tex_mappings",
    "tex_minification",
    "tex_procedural",
];

/// Samples a pixel.
const SPP: u32 = 256;

/// A bug that acts in more scenes is looked for in those that it changes most, pixel by pixel.
const MOST_SCENES: usize = 8;

/// Samples a pixel of the pictures that tell whether a bug acts in a scene at all.
const PROBE: u32 = 8;

/// Runs without a bug.
const CLEAN: usize = 12;

/// Least change of a block's light that counts, and of how many.
const CHANGE: (f64, f64) = (0.01, 0.05);

#[derive(Deserialize)]
struct Bugs {
    bug: Vec<Bug>,
}

#[derive(Deserialize)]
struct Bug {
    file: String,
    expression: String,
    becomes: Vec<String>,
}

/// The function that says which bug is on; it is put into `src/math/mod.rs`.
const SWITCH: &str = r#"
/// The number of the bug that is on; none is 0.
pub fn mutant() -> u32 {
    static NUMBER: std::sync::OnceLock<u32> = std::sync::OnceLock::new();
    let read = || std::env::var("FSTOP_MUTANT").ok().and_then(|n| n.parse().ok());
    *NUMBER.get_or_init(|| read().unwrap_or(0))
}
"#;

fn main() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let place = std::env::args().nth(1);
    let place = place.map_or_else(|| root.join("target/mutants"), PathBuf::from);
    let bugs = std::fs::read_to_string(root.join("examples/mutants/bugs.toml")).expect("the bugs");
    let bugs: Bugs = toml::from_str(&bugs).unwrap_or_else(|error| panic!("{error}"));
    let program = built(root, &place, &bugs.bug);
    let suite = Suite::new(root, &place, program);
    let all: Vec<usize> = (0..SCENES.len()).collect();
    let done = Done::read(&place);
    let clean = |n: usize| {
        let seen = || (0.0, suite.seen(0, 1000 + n, &all));
        done.or_do(&format!("clean {n}"), seen).1
    };
    let clean: Vec<Seen> = (1..=CLEAN).map(clean).collect();
    let names = bugs.bug.iter().flat_map(|bug| {
        bug.becomes
            .iter()
            .map(move |new| format!("`{}` → `{new}` ({})", bug.expression, bug.file))
    });
    let probes = suite.probes(0).expect("pictures without a bug");
    let truth = suite.of_one_seed(0, &all);
    let mut rows = Vec::new();
    for (number, name) in (1..).zip(names) {
        let try_it = || {
            // A program that fails needs no statistics to be found: such a bug is not counted.
            let after = suite.probes(number);
            let acting = after.map_or_else(Vec::new, |after| acting(&probes, &after));
            if acting.is_empty() {
                return (0.0, Seen::default());
            }
            let images = suite.of_one_seed(number, &acting);
            let shares =
                std::iter::zip(&acting, &images).map(|(&i, image)| changed(&truth[i], image));
            let share = shares.fold(0.0, f64::max);
            (share, suite.seen(number, 2000 + number, &acting))
        };
        let (share, seen) = done.or_do(&name, try_it);
        let found = if seen.suite { "found" } else { "not found" };
        eprintln!("{number}: {share:.3} {name}: {found}");
        rows.push((name, share, seen));
    }
    let page = page(&clean, &rows);
    std::fs::write(root.join("docs/generated/mutants.md"), page).expect("the page");
}

/// The scenes whose pictures differ, at most [`MOST_SCENES`]: those with the most pixels that do.
fn acting(before: &[Image], after: &[Image]) -> Vec<usize> {
    let differing = |(before, after): (&Image, &Image)| {
        let pixels = before.pixels.iter().zip(&after.pixels);
        pixels.filter(|(before, after)| before != after).count()
    };
    let counts = before.iter().zip(after).map(differing);
    let mut acting: Vec<(usize, usize)> = counts.zip(0..).filter(|(count, _)| *count > 0).collect();
    acting.sort_by_key(|(count, scene)| (std::cmp::Reverse(*count), *scene));
    let mut scenes: Vec<usize> = acting.into_iter().map(|(_, scene)| scene).collect();
    scenes.truncate(MOST_SCENES);
    scenes
}

/// What was found, line by line in a file, so that a run that was interrupted goes on.
struct Done {
    file: PathBuf,
    before: BTreeMap<String, (f64, Seen)>,
}

impl Done {
    fn read(place: &Path) -> Done {
        let file = place.join("done.jsonl");
        let text = std::fs::read_to_string(&file).unwrap_or_default();
        let before = text
            .lines()
            .filter_map(|line| serde_json::from_str(line).ok());
        let before = before.collect();
        Done { file, before }
    }

    /// What was found of this before, or is found by trying it.
    fn or_do(&self, name: &str, work: impl FnOnce() -> (f64, Seen)) -> (f64, Seen) {
        if let Some(found) = self.before.get(name) {
            return found.clone();
        }
        let found = work();
        let line = serde_json::to_string(&(name, &found)).expect("numbers");
        let file = std::fs::OpenOptions::new()
            .append(true)
            .create(true)
            .open(&self.file);
        let written = file.and_then(|mut file| writeln!(file, "{line}"));
        written.expect("a file that grows");
        found
    }
}

/// The program with all bugs in it. Files that are there and the same are left alone, so that nothing is built twice.
fn built(root: &Path, place: &Path, bugs: &[Bug]) -> PathBuf {
    let copy = place.join("source");
    let mut files = vec!["Cargo.toml".into(), "Cargo.lock".into()];
    for folder in ["src", "benches", "examples"] {
        below(root, Path::new(folder), &mut files);
    }
    let mut stale = Vec::new();
    if copy.join("src").is_dir() {
        below(&copy, Path::new("src"), &mut stale);
    }
    for file in stale.iter().filter(|file| !files.contains(file)) {
        std::fs::remove_file(copy.join(file)).expect("a file that is gone");
    }
    for file in &files {
        let bytes = std::fs::read(root.join(file)).expect("a file");
        let bytes = match String::from_utf8(bytes) {
            Ok(text) => with_bugs(file, text, bugs).into_bytes(),
            Err(other) => other.into_bytes(),
        };
        let to = copy.join(file);
        if std::fs::read(&to).is_ok_and(|there| there == bytes) {
            continue;
        }
        std::fs::create_dir_all(to.parent().expect("a folder")).expect("a folder");
        std::fs::write(to, bytes).expect("a copy");
    }
    let target = place.join("target");
    let built = Command::new("cargo")
        .args([
            "build",
            "--release",
            "--locked",
            "--bin",
            "fstop",
            "--target-dir",
        ])
        .arg(&target)
        .current_dir(&copy)
        .status();
    assert!(built.expect("cargo").success());
    target.join("release/fstop")
}

/// A source file with its bugs, which are numbered through all files, and the switch where it belongs.
fn with_bugs(file: &Path, mut text: String, bugs: &[Bug]) -> String {
    let code = &text[..text.find("#[cfg(test)]\nmod tests").unwrap_or(text.len())];
    let mut number = 1;
    let mut places = Vec::new();
    for bug in bugs {
        if Path::new(&bug.file) == file {
            let found: Vec<usize> = { code.match_indices(&bug.expression) }
                .map(|(at, _)| at)
                .collect();
            assert_eq!(found.len(), 1, "{}: {}", bug.file, bug.expression);
            places.push((found[0], bug.expression.len(), choice(bug, number)));
        }
        number += bug.becomes.len();
    }
    places.sort();
    // From the last on, so that those before stay where they are.
    for (at, length, choice) in places.into_iter().rev() {
        text.replace_range(at..at + length, &choice);
    }
    match file == Path::new("src/math/mod.rs") {
        true => text + SWITCH,
        false => text,
    }
}

/// The expression, or what it becomes by the bug that is on.
fn choice(bug: &Bug, first: usize) -> String {
    let mut choice = "(match crate::math::mutant() { ".to_owned();
    for (number, new) in (first..).zip(&bug.becomes) {
        let _ = write!(choice, "{number} => {{ {new} }} ");
    }
    let _ = write!(choice, "_ => {{ {} }} }})", bug.expression);
    choice
}

/// The files of a folder and those below it.
fn below(root: &Path, folder: &Path, files: &mut Vec<PathBuf>) {
    for entry in std::fs::read_dir(root.join(folder)).expect("a folder") {
        let entry = entry.expect("an entry");
        let path = folder.join(entry.file_name());
        match entry.file_type().expect("a kind").is_dir() {
            true => below(root, &path, files),
            false => files.push(path),
        }
    }
}

fn copy_folder(from: &Path, to: &Path) {
    std::fs::create_dir_all(to).expect("a folder");
    for entry in std::fs::read_dir(from).expect("a folder") {
        let entry = entry.expect("an entry");
        let to = to.join(entry.file_name());
        if entry.file_type().expect("a kind").is_dir() {
            copy_folder(&entry.path(), &to);
        } else {
            std::fs::copy(entry.path(), to).expect("a copy");
        }
    }
}

/// What each rule says of one run of the suite.
#[derive(Clone, Default, Serialize, Deserialize)]
struct Seen {
    /// `fstop suite run`.
    suite: bool,
    /// Mitsuba's.
    mitsuba: bool,
    /// Of each scene that was rendered: which, the PSNR, and the share of pixels of which a channel differs by more than 2 % of the reference's brightest.
    numbers: Vec<(usize, f64, f64)>,
}

struct Suite {
    folder: PathBuf,
    program: PathBuf,
}

impl Suite {
    /// With references of four runs without a bug.
    fn new(root: &Path, place: &Path, program: PathBuf) -> Suite {
        let folder = place.join("suite");
        let _ = std::fs::remove_dir_all(&folder);
        copy_folder(&root.join("tests/scenes/reference"), &folder.join("scenes"));
        let suite = Suite { folder, program };
        suite.run(0, (1, SPP), &["--update=all"]);
        suite
    }

    /// With a seed and so many samples.
    fn run(&self, bug: usize, (seed, spp): (usize, u32), options: &[&str]) -> Value {
        let mut text = format!(
            "[suite]\nalpha = 0.01\nspp = {spp}\nseeds = [{seed}]\nbaseline_seeds = [11, 12, 13, 14]\n[renderer.fstop]\n\
             command = \"{{fstop}} render {{scene}} -o {{output}} --seed {{seed}} --spp {{spp}} --variance --quiet\"\n"
        );
        for scene in SCENES {
            let _ = write!(
                text,
                "[[scene]]\nname = \"{scene}\"\nfile = \"scenes/{scene}.pbrt\"\n"
            );
        }
        std::fs::write(self.folder.join("suite.toml"), text).expect("a suite");
        let run = Command::new(&self.program)
            .args([
                "suite",
                "run",
                "suite.toml",
                "--json",
                "--quiet",
                "--no-flip",
            ])
            .args(options)
            .current_dir(&self.folder)
            .env("FSTOP_MUTANT", bug.to_string())
            .stderr(Stdio::inherit())
            .output()
            .expect("the program");
        serde_json::from_slice(&run.stdout).expect("results")
    }

    /// Pictures of some of the scenes, of a folder.
    fn images(&self, folder: &str, scenes: &[usize]) -> Vec<Image> {
        let file = |scene: &usize| {
            self.folder
                .join(folder)
                .join(format!("{}.exr", SCENES[*scene]))
        };
        scenes.iter().map(|scene| image(&file(scene))).collect()
    }

    /// The small pictures of all scenes with a bug; `None` if the program fails with it.
    fn probes(&self, bug: usize) -> Option<Vec<Image>> {
        let file = self.folder.join("probe.exr");
        let probe = |scene: &&str| {
            let rendered = Command::new(&self.program)
                .arg("render")
                .arg(self.folder.join(format!("scenes/{scene}.pbrt")))
                .arg("-o")
                .arg(&file)
                .args(["--quiet", "--spp", &PROBE.to_string()])
                .env("FSTOP_MUTANT", bug.to_string())
                .stderr(Stdio::null())
                .status();
            let success = rendered.expect("the program").success();
            success.then(|| image(&file))
        };
        SCENES.iter().map(probe).collect()
    }

    fn run_some(&self, bug: usize, seed: usize, spp: u32, scenes: &[usize]) -> Value {
        let names: Vec<&str> = scenes.iter().map(|&scene| SCENES[scene]).collect();
        self.run(bug, (seed, spp), &["--only", &names.join(",")])
    }

    fn seen(&self, bug: usize, seed: usize, scenes: &[usize]) -> Seen {
        let results = self.run_some(bug, seed, SPP, scenes);
        let rows = results["results"].as_array().expect("rows");
        let pairs = std::iter::zip(
            self.images("suite-results/images", scenes),
            self.images("suite-references", scenes),
        );
        let pairs: Vec<(Image, Image)> = pairs.collect();
        let measured = |(&scene, (image, reference)): (&usize, &(Image, Image))| {
            let (psnr, share) = numbers(image, reference);
            (scene, psnr, share)
        };
        Seen {
            suite: rows.iter().any(|row| row["status"] == "changed"),
            mitsuba: pairs
                .iter()
                .any(|(image, reference)| !mitsuba(image, reference)),
            numbers: scenes.iter().zip(&pairs).map(measured).collect(),
        }
    }

    /// Images that differ by the bug alone.
    fn of_one_seed(&self, bug: usize, scenes: &[usize]) -> Vec<Image> {
        self.run_some(bug, 1, SPP, scenes);
        self.images("suite-results/images", scenes)
    }
}

fn image(file: &Path) -> Image {
    read(file)
        .unwrap_or_else(|error| panic!("{}: {error}", file.display()))
        .image
}

/// The share of a picture's pixels in blocks whose light differs by [`CHANGE`].
fn changed(before: &Image, after: &Image) -> f64 {
    let light = |image: &Image, block: PixelBounds| -> (f64, f64) {
        let variances = image.variance.as_ref().expect("variances");
        let indices = block.pixels().filter_map(|pixel| image.bounds.index(pixel));
        let values =
            indices.map(|i| (luminance(image.pixels[i]), variances[i].element_sum() / 3.0));
        values.fold((0.0, 0.0), |(light, variance), (l, v)| {
            (light + f64::from(l), variance + f64::from(v))
        })
    };
    let differs = |block: &PixelBounds| {
        let ((a, var_a), (b, var_b)) = (light(before, *block), light(after, *block));
        (b - a).abs() >= (CHANGE.0 * a).max(3.0 * (var_a + var_b).sqrt()) && b != a
    };
    let blocks = before.bounds.tiles(8).filter(differs);
    blocks.map(|block| block.area()).sum::<usize>() as f64 / before.pixels.len() as f64
}

/// The rule of the tests of Mitsuba 3 (`src/render/tests/test_renders.py`), as we read it: a z-test of each pixel, with the reference's
/// variance of a pixel, at 1 % shared by Šidák; images agree if 99.75 % of the pixels do.
fn mitsuba(image: &Image, reference: &Image) -> bool {
    let count = image.pixels.len() as f64;
    let level = 1.0 - 0.99f64.powf(1.0 / count);
    // Ours is the variance of a mean of four times as many samples.
    let variances = reference.variance.as_ref().expect("variances");
    let agree =
        |((a, b), variance): ((&fstop::math::Rgb, &fstop::math::Rgb), &fstop::math::Rgb)| {
            (0..3)
                .filter(|&i| {
                    let error = (4.0 * f64::from(variance[i])).sqrt().max(1e-4);
                    let z = (f64::from(a[i]) - f64::from(b[i])) / error;
                    fstop::compare::two_sided_p(z, f64::INFINITY) > level
                })
                .count()
        };
    let values = image.pixels.iter().zip(&reference.pixels).zip(variances);
    let agreeing: usize = values.map(agree).sum();
    agreeing as f64 / 3.0 >= 0.9975 * count
}

/// See [`Seen::numbers`].
fn numbers(image: &Image, reference: &Image) -> (f64, f64) {
    let most = reference
        .pixels
        .iter()
        .map(|p| p.max_element())
        .fold(0.0, f32::max);
    let pairs = || image.pixels.iter().zip(&reference.pixels);
    let squares: f64 = pairs()
        .map(|(a, b)| f64::from((*a - *b).length_squared()))
        .sum();
    let mse = squares / (3.0 * image.pixels.len() as f64);
    let psnr = 10.0 * (f64::from(most).powi(2) / mse).log10();
    let differs = |(a, b): &(&fstop::math::Rgb, &fstop::math::Rgb)| {
        (**a - **b).abs().max_element() > 0.02 * most
    };
    (
        psnr,
        pairs().filter(differs).count() as f64 / image.pixels.len() as f64,
    )
}

/// Its name, and whether it raises an alarm.
type Rule<'a> = (&'a str, &'a dyn Fn(&Seen) -> bool);

fn page(clean: &[Seen], rows: &[(String, f64, Seen)]) -> String {
    let of_clean = |scene: usize| clean.iter().map(move |seen| seen.numbers[scene]);
    let least = |scene| {
        of_clean(scene)
            .map(|(_, psnr, _)| psnr)
            .fold(f64::INFINITY, f64::min)
    };
    let most = |scene| {
        of_clean(scene)
            .map(|(_, _, share)| share)
            .fold(0.0, f64::max)
    };
    let psnr = |seen: &Seen| {
        seen.numbers
            .iter()
            .any(|&(scene, psnr, _)| psnr < least(scene))
    };
    let idiff = |seen: &Seen| {
        seen.numbers
            .iter()
            .any(|&(scene, _, share)| share > most(scene))
    };
    let rules: [Rule; 4] = [
        ("`fstop suite`, α = 1 %", &|seen| seen.suite),
        ("Mitsuba's z-test", &|seen| seen.mitsuba),
        ("PSNR, tuned for each scene", &psnr),
        (
            "share of pixels off by 2 % (`idiff -fail -failpercent`), tuned",
            &idiff,
        ),
    ];
    let counted: Vec<_> = rows
        .iter()
        .filter(|(_, share, _)| *share >= CHANGE.1)
        .collect();
    let mut page = format!(
        "# Known bugs, and who finds them\n\nWritten by `cargo run --release --features studies --example mutants`: {} bugs in shading and sampling \
         (`examples/mutants/bugs.toml`), of which {} change the light by 1 % or more on 5 % of the pixels of a scene or more. {} scenes \
         at {SPP} samples, references of four runs, a seed for each bug. The tuned thresholds are those of {CLEAN} runs \
         without a bug, with which they raise no alarm.\n\n| rule | found, of {} | alarms in {CLEAN} runs without a bug |\n|---|--:|--:|\n",
        rows.len(),
        counted.len(),
        SCENES.len(),
        counted.len(),
    );
    for (name, rule) in rules {
        let found = counted.iter().filter(|(_, _, seen)| rule(seen)).count();
        let percent = 100.0 * found as f64 / counted.len().max(1) as f64;
        let alarms = clean.iter().filter(|seen| rule(seen)).count();
        let _ = writeln!(page, "| {name} | {found} ({percent:.0} %) | {alarms} |");
    }
    page += "\nEach bug, the largest share of a scene's pixels that it changes by 1 % or more, and who finds it:\n\n| bug | pixels | suite | Mitsuba | PSNR | idiff |\n|---|--:|---|---|---|---|\n";
    for (name, share, seen) in rows {
        let marks = rules.map(|(_, rule)| if rule(seen) { "✓" } else { "" });
        let name = name.replace('|', "\\|");
        let _ = writeln!(
            page,
            "| {name} | {:.0} % | {} |",
            100.0 * share,
            marks.join(" | ")
        );
    }
    page
}
