//! Renders that are killed, stopped and continued: the bits are those of an undisturbed render.

use super::cli::Folder;
#[cfg(unix)]
use crate::common::program::is_heard;
use crate::common::program::{Run, fstop};
use fstop::{Checkpoint, ReadOptions, RenderOptions, Rendered, Scene, Step};
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering::Relaxed};
use std::time::{Duration, Instant};

/// Stratified samples and a real lens.
const LENS: &str = "tests/scenes/valid/realistic_camera.pbrt";
/// Random samples, caustics of a mirror ball.
const BOX: &str = "tests/scenes/reference/int_cornell_path.pbrt";
/// Paths from the lights, too, which end anywhere on the film.
const BOTH_ENDS: &str = "tests/scenes/reference/int_bdpt.pbrt";
/// Light paths that are traced once for the camera paths that are joined to them and for the lens.
const FOG: &str = "tests/scenes/census/point_medium_bdpt.pbrt";
/// Photons, which all pixels share: tiles with their discs.
const PHOTONS: &str = "tests/scenes/reference/int_sppm.pbrt";
/// Ghosts of a lens, which do so, too.
const GHOSTS: &str = "tests/scenes/valid/ghosts.pbrt";

fn arguments<'a>(scene: &'a str, output: &'a str, more: &[&'a str]) -> Vec<&'a str> {
    [&["render", scene, "-o", output, "--variance"], more].concat()
}

fn render(scene: &str, output: &Path, more: &[&str]) -> Run {
    fstop(arguments(scene, &output.display().to_string(), more))
}

/// A render that is under way: it has written work to its checkpoint.
fn started(scene: &str, output: &Path, checkpoint: &Path, more: &[&str]) -> Child {
    started_beyond(4096, scene, output, checkpoint, more)
}

/// The same, when the checkpoint has more than so many bytes, too.
fn started_beyond(
    least: u64,
    scene: &str,
    output: &Path,
    checkpoint: &Path,
    more: &[&str],
) -> Child {
    let size = || checkpoint.metadata().map_or(0, |found| found.len());
    let before = size().max(least);
    let name = output.display().to_string();
    let mut child = { Command::new(env!("CARGO_BIN_EXE_fstop")) }
        .args(arguments(scene, &name, more))
        .stderr(Stdio::piped())
        .spawn()
        .expect("the program");
    let start = Instant::now();
    while size() <= before
        && child.try_wait().expect("a child").is_none()
        && start.elapsed() < Duration::from_secs(60)
    {
        std::thread::sleep(Duration::from_millis(5));
    }
    child
}

/// The bytes of an image rendered without interruption, and of the same killed three times.
fn undisturbed_and_killed(scene: &str, goal: &[&str]) -> [Vec<u8>; 2] {
    let folder = Folder::new();
    let (reference, output) = (folder.path("reference.exr"), folder.path("a.exr"));
    let checkpoint = folder.path("a.fsc");
    let name = checkpoint.display().to_string();
    let run = render(scene, &reference, &[goal, &["--no-checkpoint"]].concat());
    assert_eq!(run.code, 0, "{}", run.stderr);
    let kept = ["--checkpoint", &name, "--checkpoint-every", "0.02s"];
    for threads in ["1", "2", "3"] {
        let more = [goal, &kept, &["--threads", threads]].concat();
        let mut child = started(scene, &output, &checkpoint, &more);
        child.kill().expect("it can be killed");
        let code = child.wait().expect("a child").code();
        // On a machine that is fast enough the last one was done.
        assert!(code.is_none() || code == Some(0), "{code:?}");
    }
    let run = render(scene, &output, &[goal, &kept].concat());
    assert_eq!(run.code, 0, "{}", run.stderr);
    assert_eq!(folder.names(), ["a.exr", "reference.exr"]);
    [reference, output].map(|path| std::fs::read(path).expect("the image"))
}

#[test]
fn a_killed_render_ends_in_the_same_bits() {
    let [undisturbed, killed] = undisturbed_and_killed(LENS, &["--spp", "900"]);
    assert!(undisturbed == killed);
}

#[test]
fn so_does_one_with_layers() {
    let layers = "albedo,normal,depth,position,uv,coc,alpha";
    let [undisturbed, killed] = undisturbed_and_killed(LENS, &["--spp", "400", "--aov", layers]);
    assert!(undisturbed == killed);
}

#[test]
fn so_does_one_with_an_error_goal() {
    let [undisturbed, killed] = undisturbed_and_killed(BOX, &["--error", "12%"]);
    assert!(undisturbed == killed);
}

#[test]
fn so_do_those_with_paths_from_the_lights() {
    for (scene, goal) in [
        (BOTH_ENDS, ["--spp", "40"]),
        (BOTH_ENDS, ["--error", "9%"]),
        (FOG, ["--spp", "200"]),
        (GHOSTS, ["--spp", "400"]),
    ] {
        let [undisturbed, killed] = undisturbed_and_killed(scene, &goal);
        assert!(undisturbed == killed, "{scene} {goal:?}");
    }
}

#[test]
fn so_do_those_with_photons() {
    for goal in [["--spp", "120"], ["--error", "6%"]] {
        let [undisturbed, killed] = undisturbed_and_killed(PHOTONS, &goal);
        assert!(undisturbed == killed, "{goal:?}");
    }
}

/// Some tiles have one iteration more than others then: no sample is taken twice, and no goal looked at.
#[test]
fn a_stop_within_an_iteration_changes_no_bit() {
    let folder = Folder::new();
    for goal in [None, Some(0.3)] {
        let mut options = RenderOptions::default();
        (options.spp, options.error, options.variance) = (Some(20), goal, true);
        if goal.is_some() {
            options.spp = None;
        }
        let render = |options: &RenderOptions, stop_after: u64| {
            let stop = Arc::new(AtomicBool::new(false));
            let mut options = options.clone();
            options.stop = Some(Arc::clone(&stop));
            let scene = Scene::load(PHOTONS, &ReadOptions::default());
            let frame = scene.expect("a scene").into_frames().remove(0);
            let prepared = frame.prepare(&options).expect("a frame");
            let taken = AtomicU64::new(0);
            let rendered = prepared.render(&|step| {
                let stops = matches!(step, Step::Samples { .. })
                    && taken.fetch_add(1, Relaxed) == stop_after;
                stop.fetch_or(stops, Relaxed);
            });
            assert!(prepared.keep().1.is_none());
            rendered
        };
        let whole = render(&options, u64::MAX);
        options.checkpoint = Some(Checkpoint {
            path: folder.path("a.fsc"),
            after: Duration::ZERO,
            every: Duration::from_secs(3600),
            required: true,
        });
        // Of 16 tiles each; the first report is of what there was.
        let mut stops = 0;
        let resumed = loop {
            let rendered = render(&options, [5, 21, 16, 40, 0, 70][stops % 6]);
            if !rendered.stopped {
                break rendered;
            }
            stops += 1;
            assert!(stops < 100);
        };
        assert!(stops > 3, "{stops}");
        let bits = |rendered: &Rendered| {
            let image = &rendered.image;
            let variance = image.variance.clone().expect("asked for");
            (image.pixels.clone(), variance, rendered.passes)
        };
        assert!(bits(&whole) == bits(&resumed));
        std::fs::remove_file(folder.path("a.fsc")).expect("a checkpoint");
    }
}

/// A process that is being started holds the files of the one that starts it until it runs: that is waited for.
#[test]
fn a_checkpoint_is_one_renders_at_a_time() {
    let folder = Folder::new();
    let stop = Arc::new(AtomicBool::new(false));
    let mut options = RenderOptions::default();
    (options.spp, options.stop) = (Some(20), Some(Arc::clone(&stop)));
    options.checkpoint = Some(Checkpoint {
        path: folder.path("a.fsc"),
        after: Duration::ZERO,
        every: Duration::from_secs(3600),
        required: true,
    });
    let prepare = || {
        let scene = Scene::load(PHOTONS, &ReadOptions::default());
        let frame = scene.expect("a scene").into_frames().remove(0);
        frame.prepare(&options)
    };
    let prepared = prepare().expect("a frame");
    let rendered = prepared.render(&|step| {
        stop.fetch_or(matches!(step, Step::Samples { .. }), Relaxed);
    });
    assert!(rendered.stopped && prepared.keep().1.is_none());
    drop(prepared);
    let held = || {
        let file = std::fs::File::open(folder.path("a.fsc")).expect("the checkpoint");
        file.lock().expect("nobody has it");
        file
    };
    let file = held();
    let until_it_runs = std::thread::spawn(move || {
        std::thread::sleep(Duration::from_millis(50));
        drop(file);
    });
    assert!(prepare().is_ok());
    until_it_runs.join().expect("a thread");
    let _in_use = held();
    let refused = prepare().err().expect("it is in use").to_string();
    let reason = "another render is writing this checkpoint";
    assert!(refused.contains(reason), "{refused}");
}

/// Those that stop a render. One that these tests were started to ignore, as by `nohup` or by a shell in the background, is ignored by what they start, too.
#[cfg(unix)]
fn signals() -> Vec<&'static str> {
    let signals = ["-INT", "-TERM", "-USR1", "-HUP"];
    { signals.into_iter() }
        .filter(|signal| is_heard(signal))
        .collect()
}

/// The user of `nohup` wants a render to outlive the terminal.
#[cfg(target_os = "linux")]
#[test]
fn nohup_is_honoured() {
    let folder = Folder::new();
    let output = folder.path("a.exr").display().to_string();
    let mut child = Command::new("nohup")
        .arg(env!("CARGO_BIN_EXE_fstop"))
        .args(arguments(
            LENS,
            &output,
            &["--spp", "2000", "--write-partial", "0.01s"],
        ))
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()
        .expect("nohup");
    let partial = folder.path("a.partial.exr");
    while !partial.exists() && child.try_wait().expect("a child").is_none() {
        std::thread::sleep(Duration::from_millis(2));
    }
    let sent = Command::new("kill")
        .args(["-HUP", &child.id().to_string()])
        .status();
    assert!(sent.is_ok());
    assert_eq!(child.wait().expect("a child").code(), Some(0));
    assert!(folder.path("a.exr").exists());
}

/// SIGTERM and the like: what there is of the image is written beside it, and the same command continues.
#[cfg(unix)]
#[test]
fn a_stopped_render_says_how_it_goes_on() {
    let folder = Folder::new();
    let (reference, output) = (folder.path("reference.exr"), folder.path("a.exr"));
    let checkpoint = folder.path("a.fsc");
    let name = checkpoint.display().to_string();
    let goal = ["--spp", "5000", "--checkpoint", &name];
    let more = [&goal[..], &["--checkpoint-every", "0.02s"]].concat();
    for signal in signals() {
        let child = started(LENS, &output, &checkpoint, &more);
        let id = child.id().to_string();
        let sent = Command::new("kill").args([signal, &id]).status();
        assert!(sent.expect("kill").success());
        let done = child.wait_with_output().expect("a child");
        let said = String::from_utf8_lossy(&done.stderr).into_owned();
        assert_eq!(done.status.code(), Some(75), "{signal}: {said}");
        assert!(said.contains("the same command continues"), "{said}");
        assert_eq!(folder.names(), ["a.fsc", "a.partial.exr"]);
    }
    let partial = fstop::film::read(&folder.path("a.partial.exr")).expect("an image");
    assert!(partial.spp.is_some_and(|spp| (1..5000).contains(&spp)));
    let run = render(LENS, &reference, &["--spp", "64", "--no-checkpoint"]);
    assert_eq!(run.code, 0, "{}", run.stderr);
    // Other settings: refused where they must agree, else replaced.
    let other = ["--spp", "64", "--checkpoint", &name];
    let run = render(LENS, &output, &[&other[..], &["--resume"]].concat());
    assert_eq!(run.code, 2, "{}", run.stderr);
    let differs = "--spp is 64, the checkpoint's is 5000";
    assert!(run.stderr.contains(differs), "{}", run.stderr);
    let run = render(LENS, &output, &other);
    assert_eq!(run.code, 0, "{}", run.stderr);
    assert!(run.stderr.contains(differs), "{}", run.stderr);
    assert_eq!(folder.names(), ["a.exr", "reference.exr"]);
    let [a, b] = [reference, output].map(|path| std::fs::read(path).expect("the image"));
    assert!(a == b);
}

/// A changed scene is another render; a file that is not a checkpoint is left alone; a damaged end is cut off.
#[test]
fn a_checkpoint_knows_what_it_is_of() {
    let folder = Folder::new();
    let scene = folder.path("a.pbrt");
    let text = |fov: u32| {
        format!(
            "Include \"b.pbrt\"\nCamera \"perspective\" \"float fov\" {fov}\nSampler \"random\" \"integer pixelsamples\" 1500\n\
             Film \"image\" \"integer xresolution\" 48 \"integer yresolution\" 48\n\
             WorldBegin\nLightSource \"infinite\"\nTranslate 0 0 4\nShape \"sphere\"\nWorldEnd\n"
        )
    };
    std::fs::write(folder.path("b.pbrt"), "# nothing\n").expect("a file");
    std::fs::write(&scene, text(40)).expect("a file");
    let scene = scene.display().to_string();
    let (output, checkpoint) = (folder.path("a.exr"), folder.path("a.fsc"));
    let name = checkpoint.display().to_string();
    let more = [
        "--checkpoint",
        &name,
        "--checkpoint-every",
        "0.02s",
        "--resume",
    ];
    let reference = folder.path("reference.exr");
    assert_eq!(render(&scene, &reference, &["--no-checkpoint"]).code, 0);

    // A file that holds no whole record yet, of some 14 kB here, may be replaced by any render: it holds no work.
    let mut child = started_beyond(40_000, &scene, &output, &checkpoint, &more);
    child.kill().expect("it can be killed");
    child.wait().expect("a child");
    let kept = std::fs::read(&checkpoint).expect("a checkpoint");
    std::fs::write(folder.path("b.pbrt"), "# something\n").expect("a file");
    let run = render(&scene, &output, &more);
    assert_eq!(run.code, 2, "{}", run.stderr);
    assert!(
        run.stderr.contains("the file `b.pbrt` has changed"),
        "{}",
        run.stderr
    );
    std::fs::write(folder.path("b.pbrt"), "# nothing\n").expect("a file");
    std::fs::write(folder.path("a.pbrt"), text(41)).expect("a file");
    let run = render(&scene, &output, &more);
    assert_eq!(run.code, 2, "{}", run.stderr);
    assert!(
        run.stderr.contains("the file `a.pbrt` has changed"),
        "{}",
        run.stderr
    );
    std::fs::write(folder.path("a.pbrt"), text(40)).expect("a file");
    assert_eq!(std::fs::read(&checkpoint).expect("a checkpoint"), kept);

    let expected = std::fs::read(&reference).expect("the image");
    let longer = [&kept[..], &[7; 40]].concat();
    let mut wrong = kept.clone();
    let middle = wrong.len() / 2;
    wrong[middle] ^= 1;
    for damaged in [longer, kept[..kept.len() - 3].to_vec(), wrong] {
        std::fs::write(&checkpoint, damaged).expect("a file");
        let run = render(&scene, &output, &more);
        assert_eq!(run.code, 0, "{}", run.stderr);
        assert!(std::fs::read(&output).expect("the image") == expected);
        assert!(!checkpoint.exists());
        let said = "of the checkpoint were cut off or are damaged";
        assert!(run.stderr.contains(said), "{}", run.stderr);
    }

    // As a loss of power may leave it.
    std::fs::write(&checkpoint, "").expect("a file");
    let run = render(&scene, &output, &more);
    assert_eq!(run.code, 0, "{}", run.stderr);
    assert!(std::fs::read(&output).expect("the image") == expected);
    assert!(!checkpoint.exists());

    // Of another version: refused where it must agree, else replaced.
    let other = "fstop checkpoint 1\n and more";
    std::fs::write(&checkpoint, other).expect("a file");
    let run = render(&scene, &output, &more);
    assert_eq!(run.code, 2, "{}", run.stderr);
    assert_eq!(std::fs::read_to_string(&checkpoint).expect("a file"), other);
    let run = render(&scene, &output, &more[..4]);
    assert_eq!(run.code, 0, "{}", run.stderr);
    assert!(
        run.stderr.contains("of another version of fstop"),
        "{}",
        run.stderr
    );
    assert!(std::fs::read(&output).expect("the image") == expected);

    for foreign in ["fstop", "a letter to my sister"] {
        std::fs::write(&checkpoint, foreign).expect("a file");
        let run = render(&scene, &output, &more);
        assert_eq!(run.code, 2, "{}", run.stderr);
        assert!(
            run.stderr
                .contains("no checkpoint of this version of fstop"),
            "{}",
            run.stderr
        );
        assert_eq!(
            std::fs::read_to_string(&checkpoint).expect("the file"),
            foreign
        );
    }
}

/// Found before the first sample is taken.
#[test]
fn a_checkpoint_that_cannot_be_made_is_refused_first() {
    let folder = Folder::new();
    let output = folder.path("a.exr");
    let name = folder.path("nowhere/a.fsc").display().to_string();
    let start = Instant::now();
    let run = render(LENS, &output, &["--spp", "1000000", "--checkpoint", &name]);
    assert_eq!(run.code, 74, "{}", run.stderr);
    assert!(run.stderr.contains("there is no folder"), "{}", run.stderr);
    for name in ["a.exr", "a.partial.exr"] {
        let name = folder.path(name).display().to_string();
        let run = render(LENS, &output, &["--spp", "1000000", "--checkpoint", &name]);
        assert_eq!(run.code, 2, "{}", run.stderr);
        assert!(
            run.stderr.contains("an image is written there"),
            "{}",
            run.stderr
        );
    }
    assert!(folder.names().is_empty());
    assert!(start.elapsed() < Duration::from_secs(60));
}

/// A limit of the size of files is as a full disk: the exit code says so, and nothing is left under the image's name.
#[cfg(unix)]
#[test]
fn a_limit_of_the_size_of_files_is_told() {
    let folder = Folder::new();
    let output = folder.path("a.exr").display().to_string();
    let line = r#"ulimit -f 2; TMPDIR="$3" exec "$0" render "$1" -o "$2" --spp 1 --quiet"#;
    let run = { Command::new("sh") }
        .args(["-c", line, env!("CARGO_BIN_EXE_fstop")])
        .arg(Path::new(env!("CARGO_MANIFEST_DIR")).join(BOX))
        .args([&output, &folder.path("").display().to_string()])
        .current_dir(folder.path(""))
        .output()
        .expect("a shell");
    let said = String::from_utf8_lossy(&run.stderr);
    assert_eq!(run.status.code(), Some(74), "{said}");
    assert!(said.contains("cannot write"), "{said}");
    assert!(folder.names().is_empty(), "{:?}", folder.names());
}

/// Where nobody reads what is written, a second interrupt ends the program; two at once are one.
#[cfg(unix)]
#[test]
fn a_second_interrupt_ends_it() {
    let has_pipes = |output: &Path| {
        Command::new("mkfifo")
            .arg(output)
            .status()
            .is_ok_and(|s| s.success())
    };
    let folder = Folder::new();
    let output = folder.path("a.exr");
    if !is_heard("-INT") || !has_pipes(&output) {
        return;
    }
    let mut child = { Command::new(env!("CARGO_BIN_EXE_fstop")) }
        .args(["render", LENS, "-o"])
        .arg(&output)
        .args(["--spp", "1"])
        .stderr(Stdio::null())
        .spawn()
        .expect("the program");
    // A handful of pixels: long before this it waits for a reader.
    std::thread::sleep(Duration::from_secs(2));
    let id = child.id().to_string();
    let mut interrupt = || {
        let sent = Command::new("kill").args(["-INT", &id]).status();
        assert!(sent.expect("kill").success());
        std::thread::sleep(Duration::from_millis(50));
        child.try_wait().expect("a child")
    };
    assert!(interrupt().is_none() && interrupt().is_none(), "it waits");
    std::thread::sleep(Duration::from_millis(400));
    let start = Instant::now();
    let mut ended = interrupt();
    while ended.is_none() && start.elapsed() < Duration::from_secs(20) {
        std::thread::sleep(Duration::from_millis(20));
        ended = child.try_wait().expect("a child");
    }
    let _ = child.kill();
    assert_eq!(ended.and_then(|status| status.code()), Some(130));
}

/// However a folder is spelled, no output takes another one's place.
#[cfg(unix)]
#[test]
fn outputs_are_told_apart_by_their_places() {
    let folder = Folder::new();
    std::os::unix::fs::symlink(folder.path(""), folder.path("link")).expect("a link");
    let path = |name: &str| folder.path(name).display().to_string();
    let (plain, linked) = (path("a.exr"), path("link/a.exr"));
    for (more, said) in [
        (vec!["--checkpoint", &linked], "an image is written there"),
        (vec!["--stats", &linked], "an image is written there"),
        (
            vec!["--stats", &path("link/a.exr.fsc")],
            "the checkpoint has this name",
        ),
        (
            vec!["--checkpoint", &path("c"), "--stats", &path("link/c")],
            "the checkpoint has this name",
        ),
        (vec!["--png", &path("a.partial.png")], ""),
        (vec!["--checkpoint", BOX], "one of the files that are read"),
    ] {
        let run = fstop([&["render", BOX, "-o", &plain, "--spp", "1"], &more[..]].concat());
        let is_refused = run.code == 2 && run.stderr.contains(said);
        assert!(
            is_refused || said.is_empty() && run.code == 0,
            "{more:?}: {}",
            run.stderr
        );
    }
    let png = path("b.png");
    let more = ["--png", &path("b.partial.png")];
    let run = fstop([&["render", BOX, "-o", &png, "--spp", "1"], &more[..]].concat());
    assert_eq!(run.code, 2, "{}", run.stderr);
    assert!(Path::new(BOX).exists());
}
