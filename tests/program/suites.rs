//! `fstop suite` and `fstop compare` of folders, as someone meets them who tests a renderer: what is found, what goes wrong and
//! is told, and what is never lost.

#[cfg(unix)]
use crate::common::program::is_heard;
use crate::common::program::{Run, fstop_in};
use fstop::film::read;
#[cfg(unix)]
use fstop::film::{FilmMetadata, Image, write};
#[cfg(unix)]
use fstop::glam::{UVec2, Vec3};
use serde_json::Value;
use std::path::{Path, PathBuf};

/// 40 × 40 pixels, light that bounces, a moment to render.
const SCENE: &str = r#"
Integrator "path" "integer maxdepth" [3]
Sampler "halton" "integer pixelsamples" [16]
Film "image" "integer xresolution" [40] "integer yresolution" [40]
LookAt 0 0 5  0 0 0  0 1 0
Camera "perspective" "float fov" [40]
WorldBegin
LightSource "infinite" "rgb L" [1 1 1]
Material "matte" "rgb Kd" [KD KD KD]
Shape "sphere" "float radius" [1]
WorldEnd
"#;

const FSTOP: &str =
    "{fstop} render {scene} -o {output} --seed {seed} --spp {spp} --variance --threads 1";

/// A folder with scenes and a suite, gone with the test.
struct Folder(tempfile::TempDir);

impl Folder {
    /// With two scenes, one below a folder.
    fn new(suite: &str) -> Folder {
        let folder = Folder(tempfile::tempdir().expect("a temporary folder"));
        std::fs::create_dir(folder.path("glass")).expect("a folder");
        folder.scene("ball.pbrt", "0.5");
        folder.scene("glass/ball.pbrt", "0.3");
        folder.write("suite.toml", suite);
        folder
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    fn write(&self, name: &str, text: &str) {
        std::fs::write(self.path(name), text).expect("a file");
    }

    fn text(&self, name: &str) -> String {
        let text = std::fs::read_to_string(self.path(name));
        text.unwrap_or_else(|error| panic!("{name}: {error}"))
    }

    fn scene(&self, name: &str, kd: &str) {
        self.write(name, &SCENE.replace("KD", kd));
    }

    fn run(&self, arguments: &[&str]) -> Run {
        fstop_in(
            self.0.path(),
            [&["suite", "run", "suite.toml"], arguments].concat(),
        )
    }

    /// What a build server runs, with its variables: the exit code and what it says of errors.
    #[cfg(unix)]
    fn shell(&self, script: &str) -> (i32, String) {
        let program = Path::new(env!("CARGO_BIN_EXE_fstop"));
        let folders = std::env::var("PATH").unwrap();
        let path = format!("{}:{folders}", program.parent().unwrap().display());
        let mut shell = std::process::Command::new("sh");
        let shell = shell.args(["-e", "-c", script]).current_dir(self.0.path());
        shell.env("PATH", path);
        shell.env("GITHUB_SHA", "0123").env("CI_COMMIT_SHA", "0123");
        shell.env("GITHUB_STEP_SUMMARY", self.path("step.md"));
        let output = shell.output().expect("a shell");
        let said = String::from_utf8_lossy(&output.stderr).into_owned();
        (output.status.code().expect("an exit code"), said)
    }

    /// Runs, and returns the exit code and the results.
    fn results(&self, arguments: &[&str]) -> (i32, Value) {
        let run = self.run(&[&["--json", "--quiet"], arguments].concat());
        let value = serde_json::from_str(&run.stdout);
        (
            run.code,
            value.unwrap_or_else(|e| panic!("{e}: {}\n{}", run.stdout, run.stderr)),
        )
    }
}

fn suite(more: &str) -> String {
    format!(
        "[suite]\nspp = 16\n{more}\n[renderer.fstop]\ncommand = \"{FSTOP}\"\n\
         [[scene]]\nfile = \"ball.pbrt\"\n[[scene]]\nfile = \"glass/ball.pbrt\"\n"
    )
}

/// Names and statuses.
fn statuses(results: &Value) -> Vec<(&str, &str)> {
    let rows = results["results"].as_array().expect("rows").iter();
    rows.map(|row| {
        (
            row["name"].as_str().unwrap(),
            row["status"].as_str().unwrap(),
        )
    })
    .collect()
}

fn detail(results: &Value, index: usize) -> &str {
    results["results"][index]["detail"]
        .as_str()
        .expect("a text")
}

/// From nothing to a baseline, to agreement, to a change that is found, shown and accepted.
#[test]
fn a_change_is_found_named_and_accepted() {
    let folder = Folder::new(&suite(""));
    let (code, results) = folder.results(&[]);
    assert_eq!(
        (code, statuses(&results)),
        (1, vec![("ball", "new"), ("glass/ball", "new")])
    );
    let (code, results) = folder.results(&["--update"]);
    assert_eq!(code, 0, "{results}");
    assert_eq!(
        statuses(&results),
        [("ball", "accepted"), ("glass/ball", "accepted")]
    );

    // The baseline is the mean of four runs, and says so.
    let reference = read(&folder.path("suite-references/glass/ball.exr")).expect("a reference");
    assert_eq!(
        (reference.runs, reference.spp, reference.pool),
        (Some(4), Some(16), Some(4))
    );
    assert_eq!(reference.freedom, Some(4.0 * 14.0));

    let (code, results) = folder.results(&[]);
    assert_eq!(
        (code, statuses(&results)),
        (0, vec![("ball", "agree"), ("glass/ball", "agree")])
    );
    // Holm: each of two images has half of 1 %.
    assert_eq!(results["level"], 0.005);

    // 10 % more light from one ball.
    folder.scene("glass/ball.pbrt", "0.33");
    let (code, results) = folder.results(&[]);
    assert_eq!(
        (code, statuses(&results)),
        (1, vec![("ball", "agree"), ("glass/ball", "changed")])
    );
    // What one has spent of it is left to the other.
    assert_eq!(results["level"], 0.01);
    assert!(
        detail(&results, 1).starts_with("The images differ: "),
        "{results}"
    );
    let page = results["results"][1]["page"].as_str().expect("a page");
    assert_eq!(page, "pages/glass/ball.html");
    let page = folder.text(&format!("suite-results/{page}"));
    // With its folders: there are two balls.
    assert!(page.contains("images/glass/ball.exr <span>and</span>"));
    let index = folder.text("suite-results/index.html");
    assert!(index.contains("<a href=\"pages/glass/ball.html\">glass/ball</a>"));
    assert_eq!(index.matches("<img alt=").count(), 6);
    assert!(!index.contains("http"));

    let (code, results) = folder.results(&["--update"]);
    assert_eq!(
        (code, statuses(&results)),
        (0, vec![("ball", "agree"), ("glass/ball", "accepted")])
    );
    assert_eq!(folder.results(&[]).0, 0);
}

/// The images agree, but what was asked for was not done.
#[test]
fn a_reference_that_cannot_be_written_is_told() {
    let folder = Folder::new(&suite(""));
    folder.results(&["--update"]);
    let reference = folder.path("suite-references/ball.exr");
    let mut permissions = reference.metadata().expect("a reference").permissions();
    permissions.set_readonly(true);
    std::fs::set_permissions(&reference, permissions).expect("permissions");
    let run = folder.run(&["--update=all", "--only", "ball"]);
    assert_eq!(run.code, 1, "{}", run.stdout);
    assert!(run.stdout.contains("no new reference: "), "{}", run.stdout);
    assert!(run.stdout.contains("read-only"), "{}", run.stdout);
}

#[test]
fn build_servers_and_pull_requests_read_it() {
    let folder = Folder::new(&suite("name = \"a & <b>\""));
    folder.results(&["--update"]);
    folder.scene("ball.pbrt", "0.6");
    std::fs::remove_file(folder.path("suite-references/glass/ball.exr")).expect("a reference");
    assert_eq!(folder.results(&[]).0, 1);
    let xml = folder.text("suite-results/junit.xml");
    assert!(xml.contains("<testsuite name=\"a &amp; &lt;b&gt;\" tests=\"2\" failures=\"2\" errors=\"0\" skipped=\"0\" time="), "{xml}");
    assert!(
        xml.contains("name=\"ball\"")
            && xml.contains("<failure type=\"changed\" message=\"The images differ: ")
    );
    assert!(xml.contains("<failure type=\"new\" message=\"There is no reference.\">"));
    for tag in [
        "testsuites",
        "testsuite",
        "testcase",
        "failure",
        "system-out",
    ] {
        let opened =
            xml.matches(&format!("<{tag}>")).count() + xml.matches(&format!("<{tag} ")).count();
        assert_eq!(opened, xml.matches(&format!("</{tag}>")).count(), "{tag}");
    }
    let markdown = folder.text("suite-results/summary.md");
    assert!(
        markdown.starts_with("### a &amp; &lt;b&gt;: 1 changed, 1 new\n"),
        "{markdown}"
    );
    assert!(markdown.contains("| ≠ changed | ball | The images differ: "));
    assert!(markdown.contains("| + new | glass/ball | There is no reference. |"));
}

/// A folder of results is of one run at a time: two would compare each other's images.
#[cfg(unix)]
#[test]
fn runs_at_once_need_folders_of_their_own() {
    // Ten seconds at most, whatever goes wrong.
    let wait = "for i in $(seq 1000); do [ -e wait ] || break; sleep 0.01; done";
    let slowly = format!("sh -c '{wait}; exec \\\"$0\\\" \\\"$@\\\"' {FSTOP}");
    let folder = Folder::new(&suite("").replace(FSTOP, &slowly));
    folder.write("wait", "");
    let (first, second) = std::thread::scope(|scope| {
        let first = scope.spawn(|| folder.run(&["--update", "--quiet"]));
        // It renders, so that it holds the folder.
        let begun = folder.path("suite-results/runs/images");
        while !begun.exists() && !first.is_finished() {
            std::thread::sleep(std::time::Duration::from_millis(2));
        }
        let second = folder.run(&["--quiet"]);
        std::fs::remove_file(folder.path("wait")).expect("a file");
        (first.join().expect("no panic"), second)
    });
    assert_eq!(first.code, 0, "{}", first.stderr);
    assert_eq!(second.code, 74, "{}", second.stderr);
    let said = "another run writes its results there";
    assert!(second.stderr.contains(said), "{}", second.stderr);
    assert_eq!(folder.run(&["--quiet"]).code, 0);
}

/// An image that is compared with itself agrees.
#[test]
fn references_are_not_where_images_are_written() {
    for (output, references, code) in [
        ("r", "r/images", 2),
        ("r", "ball/../r/images", 2),
        ("r", "r/runs/images", 2),
        ("r", "r/kept", 0),
        (".", "suite-references", 0),
    ] {
        let folder = Folder::new(&suite(&format!(
            "output = \"{output}\"\nreferences = \"{references}\""
        )));
        std::fs::create_dir(folder.path("ball")).expect("a folder");
        let run = folder.run(&["--update", "--quiet"]);
        assert_eq!(run.code, code, "{output} {references}: {}", run.stderr);
        let said = "lies where the suite's images are written";
        assert_eq!(run.stderr.contains(said), code == 2, "{}", run.stderr);
    }
}

/// An image without anything to compare is no reference.
#[cfg(unix)]
#[test]
fn a_reference_has_finite_pixels() {
    let command = "cp broken.exr {output}";
    let folder = Folder::new(&format!(
        "[renderer.x]\ncommand = \"{command}\"\n[[scene]]\nfile = \"ball.pbrt\"\n"
    ));
    let broken = |pixels: usize| {
        let mut image = Image::black(UVec2::new(8, 8));
        image.pixels[..pixels].fill(Vec3::NAN);
        let path = folder.path("broken.exr");
        write(&path, &image, &FilmMetadata::default()).expect("a file");
    };
    broken(64);
    let (code, results) = folder.results(&["--update"]);
    assert_eq!(code, 1, "{results}");
    let notes = results["results"][0]["notes"].to_string();
    assert!(
        notes.contains("none of its pixels has a finite value"),
        "{results}"
    );
    assert!(!folder.path("suite-references/ball.exr").exists());
    broken(3);
    let (code, results) = folder.results(&["--update"]);
    let notes = results["results"][0]["notes"].to_string();
    assert!(
        code == 0 && notes.contains("3 pixels of the new reference"),
        "{results}"
    );
}

/// One that fails, hangs, writes nothing, something else or too little does not keep the others from theirs.
#[cfg(unix)]
#[test]
fn renderers_go_wrong_one_by_one() {
    let wrong = [
        ("gone", "no-such-renderer {output}"),
        ("fails", "sh -c 'echo out of light; exit 3' {output}"),
        ("hangs", "sh -c 'sleep 60 & sleep 60' {output}"),
        ("writes-nothing", "sh -c 'echo done' {output}"),
        ("no-image", "sh -c 'echo words > \"$0\"' {output}"),
        (
            "screen",
            "sh -c '\"$1\" render \"$2\" -o \"$0.png\" --spp 1 --quiet && mv \"$0.png\" \"$0\"' {output} {fstop} {scene}",
        ),
        (
            "small",
            "{fstop} render {scene} -o {output} --spp 16 --variance --crop 0,0.5,0,1",
        ),
    ];
    let mut text = suite("timeout = 20");
    for (name, command) in wrong {
        let command = command.replace('\\', "\\\\").replace('"', "\\\"");
        let (renderer, timeout) = (
            format!("[renderer.{name}]\ncommand = \"{command}\"\n"),
            if name == "hangs" { "timeout = 0.5" } else { "" },
        );
        text += &format!(
            "{renderer}[[scene]]\nname = \"{name}\"\nfile = \"ball.pbrt\"\nrenderer = \"{name}\"\nreference = \"suite-references/ball.exr\"\n{timeout}\n"
        );
    }
    let text = text.replace("[[scene]]\nfile", "[[scene]]\nrenderer = \"fstop\"\nfile");
    let folder = Folder::new(&text);
    folder.results(&["--update", "--only", "ball,glass/ball"]);
    let (code, results) = folder.results(&[]);
    assert_eq!(code, 1);
    let expected = [
        ("ball", "agree", "The images agree: "),
        ("glass/ball", "agree", "The images agree: "),
        (
            "gone",
            "failed",
            "cannot start `no-such-renderer`: there is no such program",
        ),
        (
            "fails",
            "failed",
            "the command failed (exit code 3)\nout of light\n",
        ),
        (
            "hangs",
            "failed",
            "the command did not end within 0.5 s, and was stopped\n",
        ),
        (
            "writes-nothing",
            "failed",
            "the command ended well, but wrote no image to ",
        ),
        ("no-image", "failed", "the command wrote no image: "),
        (
            "screen",
            "failed",
            "the command wrote an image for a screen ",
        ),
        (
            "small",
            "changed",
            "the images differ in size: A is 20 × 40 pixels, B 40 × 40",
        ),
    ];
    for (index, (name, status, start)) in expected.into_iter().enumerate() {
        assert_eq!(statuses(&results)[index], (name, status), "{results:#}");
        assert!(
            detail(&results, index).starts_with(start),
            "{}",
            detail(&results, index)
        );
    }
    let xml = folder.text("suite-results/junit.xml");
    assert!(
        xml.contains("tests=\"9\" failures=\"1\" errors=\"6\""),
        "{xml}"
    );
}

#[test]
fn references_are_the_ones_that_were_accepted() {
    let folder = Folder::new(&suite(""));
    folder.results(&["--update"]);
    let reference = folder.path("suite-references/ball.exr");
    std::fs::copy(folder.path("suite-references/glass/ball.exr"), &reference).expect("a reference");
    let (code, results) = folder.results(&[]);
    assert_eq!(
        (code, statuses(&results)),
        (1, vec![("ball", "failed"), ("glass/ball", "agree")])
    );
    assert!(
        detail(&results, 0).contains("is not the one that was accepted: its SHA-256 is "),
        "{results}"
    );
    // It is replaced by what the program makes, on demand.
    let (code, results) = folder.results(&["--update"]);
    assert_eq!((code, statuses(&results)[0]), (0, ("ball", "accepted")));

    // A hash in the suite file itself is kept up to date, and nothing else of it is touched.
    let text = suite("# mine") + &format!("sha256 = '{}' # of glass\n", "0".repeat(64));
    folder.write("suite.toml", &text);
    assert_eq!(
        statuses(&folder.results(&[]).1)[1],
        ("glass/ball", "failed")
    );
    assert_eq!(folder.results(&["--update"]).0, 0);
    let written = folder.text("suite.toml");
    assert!(
        written.contains("# mine\n")
            && written.ends_with("\" # of glass\n")
            && !written.contains("000000000"),
        "{written}"
    );
    assert_eq!(folder.results(&[]).0, 0);

    // A scene that goes leaves its reference, which is not passed over in silence.
    let one = suite("").replace("[[scene]]\nfile = \"glass/ball.pbrt\"\n", "");
    folder.write("suite.toml", &one);
    let (code, results) = folder.results(&[]);
    assert_eq!(
        (code, statuses(&results)),
        (1, vec![("ball", "agree"), ("glass/ball.exr", "missing")])
    );
    assert_eq!(folder.results(&["--update"]).0, 0);
    assert_eq!(statuses(&folder.results(&[]).1), [("ball", "agree")]);
    assert!(folder.path("suite-references/glass/ball.exr").exists());
}

/// Each commit has its share of the rate, and the same one the same again.
#[test]
fn commits_share_the_rate() {
    let folder = Folder::new(&suite("commits = \"commits.json\"\nalpha = 0.02"));
    folder.results(&["--update", "--commit", "first"]);
    let alpha = |commit: &str| {
        let (_, results) = folder.results(&["--commit", commit]);
        (
            results["commit"]["number"].as_u64().unwrap(),
            results["alpha"].as_f64().unwrap(),
        )
    };
    let share = |k: f64| 0.02 * 6.0 / (std::f64::consts::PI * k).powi(2);
    for (commit, number) in [("first", 1), ("second", 2), ("third", 3), ("second", 2)] {
        let (found, alpha) = alpha(commit);
        assert_eq!(found, number);
        // A few roundings.
        assert!(
            (alpha / share(number as f64) - 1.0).abs() < 1e-12,
            "{alpha}"
        );
    }
    let run = folder.run(&["--commit", "fourth", "--quiet"]);
    assert!(
        run.stdout
            .contains("the share of commit 4 of the 0.02 of all commits to come"),
        "{}",
        run.stdout
    );
    // Nothing is wrong with the suite where a file cannot be read or written.
    folder.write("suite.toml", &suite("commits = \"none/commits.json\""));
    let run = folder.run(&[]);
    assert_eq!(run.code, 74, "{}", run.stderr);
    #[cfg(unix)]
    {
        let sums = folder.path("suite-references/SHA256SUMS");
        std::fs::remove_file(&sums).expect("hashes");
        std::os::unix::fs::symlink("SHA256SUMS", &sums).expect("a link");
        folder.write("suite.toml", &suite(""));
        let run = folder.run(&[]);
        assert_eq!(run.code, 74, "{}", run.stderr);
    }
}

#[test]
fn plans_propose_samples_that_find_it() {
    let folder = Folder::new(&suite(""));
    let plan = |arguments: &[&str]| {
        let all = [
            &["suite", "plan", "suite.toml", "--only", "ball"],
            arguments,
        ]
        .concat();
        let run = fstop_in(folder.0.path(), all);
        assert_eq!(run.code, 0, "{}\n{}", run.stdout, run.stderr);
        run.stdout
    };
    let text = plan(&["--difference", "0.1%", "--block", "32"]);
    assert!(
        text.contains("will find 0.10 %, with a new reference of 4 runs of "),
        "{text}"
    );
    let proposed = |difference: &str| -> u64 {
        let plan = plan(&["--json", "--difference", difference]);
        let plan: Value = serde_json::from_str(&plan).expect("JSON");
        let step = &plan["scenes"][0]["with_a_new_reference"];
        let found = step["found"]["relative_difference"].as_f64().unwrap();
        assert!(found <= plan["difference"].as_f64().unwrap());
        step["spp"].as_u64().expect("samples")
    };
    // A quarter of the difference takes sixteen times the samples, rounded to powers of two.
    let (coarse, fine) = (proposed("0.16%"), proposed("0.04%"));
    assert!([8, 16, 32].contains(&(fine / coarse)), "{coarse} {fine}");
    // What is larger than what the pilot finds is no reason to take next to none.
    assert_eq!(proposed("5%"), 16);
    // And it is so: rendered with them, and a reference of four such runs beside it, as much would be found. Well-distributed
    // samples do better than 1/spp.
    let spp = proposed("0.1%");
    assert!(spp > 16);
    let text = suite("").replace("spp = 16", &format!("spp = {spp}"));
    folder.write("suite.toml", &text);
    folder.results(&["--update"]);
    let (_, results) = folder.results(&["--only", "ball"]);
    let found = &results["results"][0]["comparison"]["findable"];
    let found = found.as_array().unwrap();
    let block = found.iter().find(|found| found["side"] == 32);
    let found = block.expect("blocks of 32")["relative_difference"].as_f64();
    assert!(found.unwrap() < 0.001, "{found:?}");
}

/// Every mistake has its line, and all are told at once.
#[test]
fn suite_files_are_read_with_care() {
    let folder = Folder::new("");
    let said = |text: &str| {
        folder.write("suite.toml", text);
        let run = folder.run(&[]);
        assert_eq!(run.code, 2, "{text}\n{}", run.stderr);
        assert!(run.stdout.is_empty());
        run.stderr
    };
    let scene = "[[scene]]\nfile = \"ball.pbrt\"\n";
    let renderer = format!("[renderer.fstop]\ncommand = \"{FSTOP}\"\n");
    for (text, message, place) in [
        (String::new(), "the suite has no scenes", "1:1"),
        ("[suite".to_owned(), "unclosed table", "1:7"),
        (
            format!("{scene}{renderer}[suite]\nalhpa = 1\n"),
            "did you mean `alpha`?",
            "6:1",
        ),
        (
            format!("{scene}{renderer}[suite]\nalpha = 1.5\n"),
            "expected a probability above 0 and below 1",
            "6:9",
        ),
        (
            format!("{scene}{renderer}[suite]\ncorrection = \"hulm\"\n"),
            "is none of holm, sidak",
            "6:14",
        ),
        (
            format!("{scene}{renderer}[suite]\nseeds = [1, 1]\n"),
            "a seed is there twice",
            "6:9",
        ),
        (
            format!("{scene}{renderer}[suite]\nseeds = [7]\nbaseline_seeds = [7, 8]\n"),
            "share the seed 7",
            "7:18",
        ),
        (
            format!("{scene}{renderer}[suite]\nspp = -1\n"),
            "invalid value: integer `-1`",
            "6:7",
        ),
        (scene.to_owned(), "the suite has no renderer", "1:1"),
        (
            format!("{scene}renderer = \"fstpo\"\n{renderer}"),
            "did you mean `fstop`?",
            "3:12",
        ),
        (
            format!("[[scene]]\nfile = \"bal.pbrt\"\n{renderer}"),
            "there is no file `bal.pbrt` beside the suite",
            "2:8",
        ),
        (
            format!("{scene}name = \"../../etc/x\"\n{renderer}"),
            "cannot name an image's files",
            "3:8",
        ),
        (
            format!("{scene}{scene}{renderer}"),
            "there are two scenes named `ball`",
            "4:8",
        ),
        (
            format!("{scene}sha256 = \"12\"\n{renderer}"),
            "64 hexadecimal digits",
            "3:10",
        ),
        (
            format!("{scene}timeout = 0\n{renderer}"),
            "expected a positive number of seconds",
            "3:11",
        ),
        (
            format!("{scene}[renderer.x]\ncommand = \"x {{scene}}\"\n"),
            "it has no {output}",
            "4:11",
        ),
        (
            format!("{scene}[renderer.x]\ncommand = [\"x\", \"{{out}}\"]\n"),
            "there is no placeholder {out}",
            "4:11",
        ),
        (
            format!("{scene}seeds = [1, 2]\n[renderer.x]\ncommand = \"x {{output}}\"\n"),
            "the command has no {seed}",
            "3:9",
        ),
    ] {
        let said = said(&text);
        assert!(said.contains(message), "{text}\n---\n{said}");
        assert!(
            said.contains(&format!("suite.toml:{place}")),
            "{place}: {text}\n---\n{said}"
        );
    }
    let both = said(&format!("{scene}timeout = 0\nspp = 0\n{renderer}"));
    assert!(
        both.contains("seconds") && both.contains("expected 1 or more"),
        "{both}"
    );
    let all = said(&format!(
        "{scene}name = \"..\"\ntimeout = 0\nsha256 = \"12\"\nspq = 1\n[[scene]]\nspp = 1\n[[scene]]\nsed = 1\n[suite]\nalpha = 2\nalhpa = 1\n{renderer}"
    ));
    for message in [
        "cannot name an image's files",
        "seconds",
        "64 hexadecimal digits",
        "unknown field `spq`",
        "unknown field `sed`",
        "missing field `file`",
        "unknown field `alhpa`",
    ] {
        assert!(all.contains(message), "{message}\n{all}");
    }
    assert_eq!(all.matches("missing field").count(), 1, "{all}");
    // Nothing is missing that was only misspelled.
    let misspelled = "[[scnee]]\nfile = \"ball.pbrt\"\n";
    for text in [
        format!("{misspelled}{renderer}"),
        format!("[[scene]]\nfiel = \"ball.pbrt\"\n{renderer}"),
        format!("{scene}[rendrer.fstop]\ncommand = \"x {{scene}} {{output}}\"\n"),
        format!("{scene}[renderer.fstop]\ncomand = \"x {{scene}} {{output}}\"\n"),
    ] {
        let said = said(&text);
        assert!(said.contains("unknown field"), "{text}\n---\n{said}");
        for untrue in ["missing field", "no scenes", "no renderer"] {
            assert!(!said.contains(untrue), "{text}\n---\n{said}");
        }
    }
    // What is missing is no reason to keep the rest back.
    let all = said(&format!(
        "{scene}timeout = 0\n[renderer.x]\n[suite]\nalpha = 2\n"
    ));
    for message in ["missing field `command`", "seconds", "a probability"] {
        assert!(all.contains(message), "{message}\n{all}");
    }
    assert!(!all.contains("no renderer"), "{all}");
    let unknown: String = (0..500).map(|i| format!("k{i} = 1\n")).collect();
    let many = said(&format!("{scene}{unknown}{renderer}"));
    assert_eq!(many.matches("unknown field").count(), 99, "{many}");
    assert!(many.contains("error: … and more"), "{many}");
    let types = said("[[scene]]\nfile = 3\n[[scene]]\nspp = \"x\"\n[suite]\nalpha = \"a\"\n");
    assert!(types.matches("invalid type").count() == 3, "{types}");
    std::fs::write(folder.path("suite.toml"), [b'a', 0xff]).expect("a file");
    assert!(folder.run(&[]).stderr.contains("this is not UTF-8 text"));
    let run = fstop_in(folder.0.path(), ["suite", "run", "gone.toml"]);
    assert_eq!(run.code, 2);
    assert!(
        run.stderr
            .contains("cannot read `gone.toml`: there is no such file"),
        "{}",
        run.stderr
    );
    folder.write("suite.toml", &suite(""));
    let run = folder.run(&["--only", "bal"]);
    assert!(
        run.code == 2 && run.stderr.contains("no scene `bal`; did you mean `ball`?"),
        "{}",
        run.stderr
    );
}

/// What has been rendered is kept, and in the reports, when the rest is interrupted.
#[cfg(target_os = "linux")]
#[test]
fn what_is_done_is_not_lost() {
    let text = suite("")
        .replace(
            "[[scene]]\nfile = \"glass",
            "[[scene]]\nrenderer = \"slow\"\nfile = \"glass",
        )
        .replace("[[scene]]\nfile", "[[scene]]\nrenderer = \"fstop\"\nfile")
        + "[renderer.slow]\ncommand = \"sh -c 'touch started; sleep 60' {output}\"\n";
    let folder = Folder::new(&text);
    let mut child = std::process::Command::new(env!("CARGO_BIN_EXE_fstop"))
        .args(["suite", "run", "suite.toml", "--quiet"])
        .current_dir(folder.0.path())
        .stdout(std::process::Stdio::null())
        .spawn()
        .expect("the program starts");
    let begun = std::time::Instant::now();
    while !folder.path("started").exists() {
        // A busy machine takes its time.
        assert!(begun.elapsed().as_secs() < 60, "nothing started");
        std::thread::sleep(std::time::Duration::from_millis(20));
    }
    let id = child.id().to_string();
    // A shell's background jobs ignore Ctrl-C.
    let signal = if is_heard("-INT") { "-INT" } else { "-TERM" };
    let killed = std::process::Command::new("kill")
        .args([signal, &id])
        .status();
    assert!(killed.expect("kill").success());
    assert_eq!(child.wait().expect("an end").code(), Some(130));
    let results: Value =
        serde_json::from_str(&folder.text("suite-results/results.json")).expect("JSON");
    assert_eq!(
        statuses(&results),
        [("ball", "new"), ("glass/ball", "not run")]
    );
    assert!(folder.path("suite-results/images/ball.exr").exists());
}

/// Runs of a renderer that knows no variances: their scatter is the variance.
#[cfg(unix)]
#[test]
fn other_renderers_need_no_variances() {
    let command = "{fstop} render {scene} -o {output} --seed {seed} --spp {spp} --threads 1";
    let folder = Folder::new(&suite("seeds = [1, 2, 3, 4]").replace(FSTOP, command));
    assert_eq!(folder.results(&["--update"]).0, 0);
    let reference = read(&folder.path("suite-references/ball.exr")).expect("a reference");
    assert_eq!((reference.runs, reference.freedom), (Some(4), None));
    let (code, results) = folder.results(&[]);
    assert_eq!(code, 0, "{results:#}");
    folder.scene("ball.pbrt", "0.55");
    assert_eq!(statuses(&folder.results(&[]).1)[0], ("ball", "changed"));
}

/// 8 × 8 gray pixels, with variances or without, whose file says nothing of samples.
#[cfg(unix)]
fn unsaid(folder: &Folder, name: &str, variance: Option<f32>) {
    let mut image = Image::black(UVec2::new(8, 8));
    image.pixels.fill(Vec3::splat(0.5));
    image.variance = variance.map(|variance| vec![Vec3::splat(variance); 64]);
    // Read as unknown.
    let unknown = FilmMetadata::default();
    write(&folder.path(name), &image, &unknown).expect("a file");
}

/// What the command was told counts for an image that does not say it: in its row, on its page, and in a reference of one run.
#[cfg(unix)]
#[test]
fn pages_say_what_rows_say() {
    let told = "[suite]\nspp = 32\nbaseline_seeds = [5]\n[renderer.x]\n\
                command = ['sh', '-c', 'cp image.exr $0', '{output}', '{seed}', '{spp}']\n\
                [[scene]]\nfile = \"ball.pbrt\"\n";
    let folder = Folder::new(told);
    unsaid(&folder, "image.exr", Some(1e-4));
    assert_eq!(folder.results(&["--update"]).0, 0);
    let reference = read(&folder.path("suite-references/ball.exr")).expect("a reference");
    assert_eq!(reference.spp, Some(32));
    let (code, results) = folder.results(&["--pages", "--no-flip"]);
    assert_eq!(code, 0, "{results:#}");
    let page = folder.text("suite-results/pages/ball.html");
    assert_eq!(page.matches("32 samples a pixel").count(), 2, "{page}");

    // A command that is told nothing takes nobody knows how many, in however many runs.
    let untold = told.replace(", '{spp}'", "").replace("[5]", "[5, 6]");
    let folder = Folder::new(&untold);
    unsaid(&folder, "image.exr", Some(1e-4));
    let (code, results) = folder.results(&["--update"]);
    assert_eq!(code, 0, "{results:#}");
    let accepted = detail(&results, 0);
    assert!(!accepted.contains("samples a pixel"), "{accepted}");
    let reference = read(&folder.path("suite-references/ball.exr")).expect("a reference");
    assert_eq!((reference.spp, reference.runs), (None, Some(2)));
}

/// A reference's file is of the format that its name says.
#[cfg(unix)]
#[test]
fn references_are_of_the_format_of_their_name() {
    let suite = "[suite]\nbaseline_seeds = [5]\n[renderer.x]\nextension = \"pfm\"\n\
                 command = ['sh', '-c', 'cp image.pfm $0', '{output}', '{seed}']\n\
                 [[scene]]\nfile = \"ball.pbrt\"\n";
    let folder = Folder::new(suite);
    unsaid(&folder, "image.pfm", None);
    let (code, results) = folder.results(&["--update"]);
    assert_eq!(code, 0, "{results:#}");
    let bytes = std::fs::read(folder.path("suite-references/ball.exr")).expect("a reference");
    assert!(bytes.starts_with(&[0x76, 0x2f, 0x31, 0x01]));

    // One elsewhere, without a hash: no option writes one, so it is said.
    std::fs::rename(
        folder.path("suite-references/ball.exr"),
        folder.path("own.exr"),
    )
    .expect("a file");
    std::fs::remove_dir_all(folder.path("suite-references")).expect("a folder");
    folder.write("suite.toml", &format!("{suite}reference = \"own.exr\"\n"));
    let (_, results) = folder.results(&[]);
    let notes = results["results"][0]["notes"].to_string();
    assert!(notes.contains("add `sha256 = "), "{notes}");
    assert!(!notes.contains("--update=all"), "{notes}");
}

fn copy(from: &Path, to: PathBuf) {
    std::fs::create_dir_all(to.parent().expect("a folder")).expect("a folder");
    std::fs::copy(from, to).expect("a copy");
}

#[test]
fn folders_are_compared_by_names() {
    let folder = Folder::new(&suite(""));
    folder.results(&["--update"]);
    folder.results(&[]);
    let images = folder.path("suite-results/images");
    for (from, base, new) in [
        ("ball.exr", true, true),
        ("glass/ball.exr", true, false),
        ("glass/ball.exr", false, true),
    ] {
        let name = match (base, new) {
            (true, false) => "below/gone.exr",
            (false, true) => "below/came.exr",
            _ => "below/stayed.exr",
        };
        if base {
            copy(
                &folder.path("suite-references").join(from),
                folder.path("base").join(name),
            );
        }
        if new {
            copy(&images.join(from), folder.path("new").join(name));
        }
    }
    // Of two materials.
    copy(
        &folder.path("suite-references/ball.exr"),
        folder.path("base/below/turned.exr"),
    );
    copy(
        &images.join("glass/ball.exr"),
        folder.path("new/below/turned.exr"),
    );
    let options = [
        "--json",
        "--report",
        "out",
        "--html",
        "i.html",
        "--junit",
        "j.xml",
        "--markdown",
        "m.md",
        "--no-flip",
    ];
    let run = fstop_in(
        folder.0.path(),
        [&["compare", "base", "new"], &options[..]].concat(),
    );
    let results: Value =
        serde_json::from_str(&run.stdout).unwrap_or_else(|e| panic!("{e} {}", run.stderr));
    assert_eq!(run.code, 1);
    let expected = [
        ("below/came.exr", "new"),
        ("below/gone.exr", "missing"),
        ("below/stayed.exr", "agree"),
        ("below/turned.exr", "changed"),
    ];
    assert_eq!(statuses(&results), expected);
    // Two pairs share the rate.
    assert_eq!(results["images"], 2);
    // 0.3 against 0.5: the new one is A, and darker.
    assert!(
        detail(&results, 3).contains("darker in A"),
        "{}",
        detail(&results, 3)
    );
    for file in [
        "out/index.html",
        "out/pages/below/turned.exr.html",
        "out/junit.xml",
        "i.html",
        "j.xml",
        "m.md",
    ] {
        assert!(!folder.text(file).is_empty(), "{file}");
    }
    // Images that are there already take no time, not even less.
    assert!(!folder.text("j.xml").contains("-0.000"));
    let same = fstop_in(folder.0.path(), ["compare", "base", "base", "--no-flip"]);
    assert_eq!(same.code, 0, "{}", same.stdout);
    let mixed = fstop_in(folder.0.path(), ["compare", "base", "suite.toml"]);
    assert!(
        mixed.code == 2 && mixed.stderr.contains("two images or two folders"),
        "{}",
        mixed.stderr
    );
}

/// The blocks of code in one language, of a page or a part of it. Those of lists are moved to the left.
#[cfg(unix)]
fn blocks(page: &str, language: &str) -> Vec<String> {
    let fence = format!("```{language}\n");
    let parts: Vec<&str> = page.split(&fence).collect();
    let blocks = parts.windows(2).map(|pair| {
        let indent = pair[0].len() - pair[0].trim_end_matches(' ').len();
        let block = pair[1].split("```").next().unwrap_or_default();
        let lines = block.trim_end_matches(' ').lines();
        lines
            .map(|line| line.get(indent..).unwrap_or("").to_owned() + "\n")
            .collect()
    });
    blocks.collect()
}

#[cfg(unix)]
fn page(name: &str) -> String {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join(name);
    std::fs::read_to_string(file).expect("the page")
}

/// What a shell is given of a build server's file: the lines below `key`, less what installs.
#[cfg(unix)]
fn script(yaml: &str, key: &str) -> String {
    let after = yaml.split_once(key).expect("a script").1;
    let indent = |line: &str| line.len() - line.trim_start().len();
    let lines = after.lines().skip(1);
    let first = indent(lines.clone().next().expect("a line"));
    let lines = lines.take_while(|line| indent(line) >= first);
    lines
        .map(|line| line.trim().trim_start_matches("- ").to_owned() + "\n")
        .collect()
}

/// The page's suite, and the commands of its examples for build servers.
#[cfg(unix)]
#[test]
fn the_examples_of_the_page_work() {
    let text = page("docs/suites.md");
    let suites = blocks(&text, "toml");
    let folder = Folder::new(&suites[0]);
    std::fs::create_dir(folder.path("scenes")).expect("a folder");
    folder.scene("scenes/ball.pbrt", "0.5");
    folder.scene("scenes/prism.pbrt", "0.2");
    let shell = |script: &str| folder.shell(script);
    for commands in &blocks(&text, "sh")[..2] {
        let (code, said) = shell(commands);
        assert_eq!(code, 0, "{commands}{said}");
    }
    let servers = blocks(&text, "yaml");
    let [github, gitlab] = [
        script(&servers[0], "run: |"),
        script(&servers[1], "  script:"),
    ];
    assert!(
        github.lines().count() == 4 && gitlab.lines().count() == 1,
        "{github}{gitlab}"
    );
    for (script, server) in [(&github, "GitHub"), (&gitlab, "GitLab")] {
        assert_eq!(shell(script).0, 0, "{server}: {}", shell(script).1);
    }
    assert!(folder.text("step.md").contains("2 agree"));
    // And a change turns both red.
    folder.scene("scenes/prism.pbrt", "0.25");
    assert_eq!((shell(&github).0, shell(&gitlab).0), (1, 1));
    assert!(
        folder
            .text("step.md")
            .contains("| ≠ changed | glass/prism |")
    );
    // The other renderers' command lines are read, at least.
    let all = suites[1].clone() + "[[scene]]\nfile = \"scenes/ball.pbrt\"\nrenderer = \"fstop\"\n";
    folder.write("suite.toml", &all);
    let (code, said) = shell("fstop suite run suite.toml --quiet");
    assert_eq!(code, 1, "{said}");
}

/// The way of `docs/guide.md` from nothing to a build server's page, less what installs.
#[cfg(unix)]
#[test]
fn the_whole_way_works_as_it_is_written() {
    let guide = page("docs/guide.md");
    let way = guide.split_once("## The whole way").expect("a section").1;
    let way = way.split("\n## ").next().unwrap_or_default();
    let commands = blocks(way, "sh");
    let [install, render, update, run] = &commands[..] else {
        panic!("{commands:?}");
    };
    assert!(install.ends_with("cargo install --path . --locked\n"));
    let folder = Folder::new(&blocks(way, "toml")[0]);
    // The scene that is there after the first step, with a 25th of the pixels.
    let scene = page("scenes/cornell/cornell.pbrt").replace("[ 300 ]", "[ 60 ]");
    std::fs::create_dir_all(folder.path("scenes/cornell")).expect("a folder");
    folder.write("scenes/cornell/cornell.pbrt", &scene);
    for command in [render, update, run] {
        let (code, said) = folder.shell(command);
        assert_eq!(code, 0, "{command}{said}");
    }
    assert!(folder.path("cornell.png").exists() && folder.path("cornell.exr").exists());
    assert!(
        folder
            .path("suite-references/scenes/cornell/cornell.exr")
            .exists()
    );
    let server = blocks(way, "yaml");
    assert!(server[0].contains("cargo install --locked --git ADDRESS fstop\n"));
    let server = script(&server[0], "run: |");
    assert_eq!(folder.shell(&server).0, 0, "{server}");
    // A wall that is greener is found, and shown where the last step looks.
    folder.write(
        "scenes/cornell/cornell.pbrt",
        &scene.replace(".12 .45 .15", ".12 .6 .15"),
    );
    assert_eq!(folder.shell(&server).0, 1);
    let index = folder.text("suite-results/index.html");
    assert!(
        index.contains("pages/scenes/cornell/cornell.html"),
        "{index}"
    );
    assert!(
        folder
            .path("suite-results/pages/scenes/cornell/cornell.html")
            .exists()
    );
}

/// The line for Mitsuba 3 in `docs/suites.md`, where there is one: two scenes, two seeds.
#[cfg(unix)]
#[test]
fn mitsuba_is_tested_by_the_line_of_the_page() {
    let found = std::process::Command::new("mitsuba").arg("--help").output();
    if found.is_err() {
        println!("skipped: no `mitsuba` in the path");
        return;
    }
    const SCENE: &str = r#"<scene version="3.0.0"><default name="spp" value="64"/><default name="seed" value="0"/>
        <integrator type="path"/> <emitter type="constant"/>
        <sensor type="perspective">
            <transform name="to_world"><lookat origin="0,0,5" target="0,0,0" up="0,1,0"/></transform>
            <sampler type="independent"><integer name="sample_count" value="$spp"/><integer name="seed" value="$seed"/></sampler>
            <film type="hdrfilm"><integer name="width" value="64"/><integer name="height" value="64"/>
                <string name="pixel_format" value="rgb"/><rfilter type="box"/></film>
        </sensor>
        <shape type="sphere"><bsdf type="diffuse"><rgb name="reflectance" value="KD"/></bsdf></shape></scene>"#;
    let text = page("docs/suites.md");
    let line = text
        .lines()
        .find(|line| line.starts_with("command = \"mitsuba"));
    let folder = Folder::new(&format!(
        "[suite]\nseeds = [1, 2]\n[renderer.mitsuba]\n{}\n[[scene]]\nfile = \"a.xml\"\n[[scene]]\nfile = \"b.xml\"\n",
        line.expect("its line")
    ));
    folder.write("a.xml", &SCENE.replace("KD", "0.5"));
    folder.write("b.xml", &SCENE.replace("KD", "0.3"));
    assert_eq!(folder.results(&["--update"]).0, 0);
    let (code, results) = folder.results(&[]);
    assert_eq!(code, 0, "{results:#}");
    folder.write("b.xml", &SCENE.replace("KD", "0.303"));
    let (_, results) = folder.results(&[]);
    assert_eq!(statuses(&results), [("a", "agree"), ("b", "changed")]);
}

/// pbrt-v3's images of our scenes are a suite of 72, some of them rendered here: tests/scenes/references.rs has all with more samples.
/// Seeds are fixed, so that chance enters only where the program's random numbers change.
#[test]
fn our_own_references_agree() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    if !root.join("refimages/suite.toml").exists() {
        // The package has none of these images.
        println!("skipped: no refimages");
        return;
    }
    let output = tempfile::tempdir().expect("a temporary folder");
    let place = output.path().display().to_string();
    let some = [
        "cam_perspective",
        "int_direct_one",
        "light_spot",
        "mat_uber",
        "shape_curve",
        "tex_imagemap",
        "realistic_dgauss50_full",
    ];
    let only = some.iter().flat_map(|name| ["--only", name]);
    let options = ["--quiet", "--no-flip", "-o", &place];
    let words = { ["suite", "run", "refimages/suite.toml"].into_iter() }
        .chain(only)
        .chain(options);
    let run = fstop_in(root, words);
    assert_eq!(run.code, 0, "{}\n{}", run.stdout, run.stderr);
    assert!(run.stdout.contains(": 7 agree\n"), "{}", run.stdout);
    let suite = std::fs::read_to_string(root.join("refimages/suite.toml")).expect("a suite");
    assert_eq!(suite.matches("[[scene]]").count(), 72);
}
