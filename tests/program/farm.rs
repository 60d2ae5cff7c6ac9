//! `fstop farm`: scripts that bash and Slurm understand, whatever the files are called.

use super::cli::{Folder, LENS};
use crate::common::program::{Run, fstop, fstop_in};
use std::path::Path;
use std::process::Command;

/// A scene of one frame.
const SPHERE: &str = "Film \"image\" \"integer xresolution\" 8 \"integer yresolution\" 8
    WorldBegin LightSource \"infinite\" Shape \"sphere\" WorldEnd\n";

/// What shells and Slurm would take apart.
const NAME: &str = "it's a \"$HOME\" `x` \\ 100%";

fn slurm(folder: &Folder, options: &[&str]) -> Run {
    let scene = Path::new(env!("CARGO_MANIFEST_DIR")).join(LENS);
    let scene = scene.display().to_string();
    let command = ["farm", "slurm", scene.as_str()].into_iter();
    fstop_in(folder.0.path(), command.chain(options.iter().copied()))
}

/// The scripts for an image, which must be valid.
fn scripts(folder: &Folder, stem: &str) -> [String; 2] {
    ["render", "merge"].map(|kind| {
        let name = format!("{stem}.{kind}.sbatch");
        let bash = { Command::new("bash") }
            .args(["-n", &name])
            .current_dir(folder.0.path())
            .output()
            .expect("bash");
        let text = std::fs::read_to_string(folder.path(&name)).expect("the script");
        assert!(
            bash.status.success() && bash.stderr.is_empty(),
            "{bash:?}\n{text}"
        );
        assert!(!text.contains("{{") && !text.contains("}}"), "{text}");
        text
    })
}

#[test]
fn the_scripts_say_what_was_asked_for() {
    let folder = Folder::new();
    let options = [
        ["--shards", "64", "-o", "a.exr", "--requeue"].as_slice(),
        &[
            "--mem",
            "1.5G",
            "--time",
            "1-12",
            "--partition",
            "long,short",
        ],
        &[
            "--cpus",
            "8",
            "--variance",
            "--png",
            "a b.png",
            "--half",
            "--exposure",
            "-1",
            "--",
            "--spp",
            "32",
            "--seed",
            "7",
        ],
    ];
    let run = slurm(&folder, &options.concat());
    assert_eq!(run.code, 0, "{}", run.stderr);
    assert_eq!(folder.names(), ["a.merge.sbatch", "a.render.sbatch"]);
    let [render, merge] = scripts(&folder, "a");
    for line in [
        "#SBATCH --array=1-64",
        "#SBATCH --signal=B:USR1@120",
        "#SBATCH --open-mode=append",
        "#SBATCH --requeue",
        "#SBATCH --mem=1536M",
        "#SBATCH --time=1-12",
        "#SBATCH --partition=long,short",
        "#SBATCH --cpus-per-task=8",
        "options=(--spp 32 --seed 7 --variance)",
        "        scontrol requeue \"$task\"",
    ] {
        assert!(render.lines().any(|l| l == line), "{line}\n{render}");
    }
    // sbatch reads no options below the first command.
    let (_, commands) = render.split_once("\nfstop=").expect("the program");
    assert!(!commands.contains("#SBATCH"), "{render}");
    assert!(merge.contains("$1.shard-$number-of-64.fsc"), "{merge}");
    let line = "merge a -o a.exr --png 'a b.png' --variance --half --exposure=-1";
    assert!(merge.lines().any(|l| l == line), "{merge}");
    let printed: Vec<&str> = run.stdout.lines().collect();
    assert_eq!(printed[0], "job=$(sbatch --parsable a.render.sbatch)");
    assert!(printed[1].contains("--dependency=afterok:"), "{printed:?}");
}

/// Enough for the program alone, and not out of all proportion for a scene of 256 pixels.
#[test]
fn memory_is_forecast() {
    let folder = Folder::new();
    let run = slurm(&folder, &["--shards", "2", "--mem", "auto"]);
    assert_eq!(run.code, 0, "{}", run.stderr);
    for script in scripts(&folder, "realistic_camera") {
        let (_, rest) = script.split_once("#SBATCH --mem=").expect("memory");
        let (mebibytes, _) = rest.split_once("M\n").expect("a unit");
        let mebibytes: u32 = mebibytes.parse().expect("a number");
        assert!((5..200).contains(&mebibytes), "{mebibytes}");
    }
}

#[test]
fn nothing_is_requeued_unasked() {
    let folder = Folder::new();
    let run = slurm(&folder, &["--shards", "2"]);
    assert_eq!(run.code, 0, "{}", run.stderr);
    // Named after the scene, in the current folder.
    let [render, _] = scripts(&folder, "realistic_camera");
    assert!(!render.contains("requeue"), "{render}");
}

/// What a script does with a stand-in for `fstop`: its arguments, a line each.
fn called(script: &str) -> String {
    let text = script.replace(env!("CARGO_BIN_EXE_fstop"), "stand_in");
    let text = format!("stand_in() {{ printf '%s\\n' \"$@\"; }}\n{text}");
    let bash = { Command::new("bash") }
        .args(["-c", &text])
        .env("SLURM_ARRAY_TASK_ID", "2")
        .env("SLURM_ARRAY_JOB_ID", "17")
        .output()
        .expect("bash");
    assert!(bash.status.success(), "{bash:?}\n{text}");
    String::from_utf8(bash.stdout).expect("text")
}

#[test]
fn every_frame_is_merged() {
    let folder = Folder::new();
    let scene = format!("{SPHERE}{SPHERE}");
    std::fs::write(folder.path("two.pbrt"), scene).expect("a scene");
    let options = "farm slurm two.pbrt --shards 1 -o a.exr --png b.png";
    let run = fstop_in(folder.0.path(), options.split(' '));
    assert_eq!(run.code, 0, "{}", run.stderr);
    let [_, merge] = scripts(&folder, "a").map(|script| called(&script));
    let expected = "merge a.shard-1-of-1.fsc -o a.exr --png b.png \
                    merge a.2.shard-1-of-1.fsc -o a.2.exr --png b.2.png";
    assert_eq!(merge.trim_end().replace('\n', " "), expected);
}

/// A stand-in for `fstop` gets the names and options as they were.
#[test]
fn odd_names_survive() {
    let folder = Folder::new();
    let image = format!("{NAME}.exr");
    let run = slurm(&folder, &["--shards", "2", "-o", &image, "--requeue"]);
    assert_eq!(run.code, 0, "{}", run.stderr);
    let [render, merge] = scripts(&folder, NAME).map(|script| called(&script));
    let words: Vec<&str> = render.lines().collect();
    assert_eq!(words[2..4], ["-o", &image]);
    assert_eq!(words[4..6], ["--shard", "2/2"]);
    let shard = |number| format!("{NAME}.shard-{number}-of-2.fsc");
    let expected = ["merge", &shard(1), &shard(2), "-o", &image].join("\n");
    assert_eq!(merge.trim_end(), expected);
}

/// The script passes signals on, waits for what the render makes of them, and asks for the task to go on only if nobody
/// has canceled it.
#[test]
fn signals_are_passed_on() {
    let folder = Folder::new();
    let run = slurm(&folder, &["--shards", "2", "-o", "a.exr", "--requeue"]);
    assert_eq!(run.code, 0, "{}", run.stderr);
    let [render, _] = scripts(&folder, "a");
    // Stand-ins: a render that takes a while to end with 75, and Slurm.
    let stand_ins = "fstop_render() { trap 'sleep 0.2; exit 75' USR1 TERM; sleep 0.5; kill -SIGNAL $$; while :; do sleep 0.05; done; }\n\
                     scontrol() { echo \"scontrol $*\"; }\n";
    for (signal, requeued) in [("USR1", true), ("TERM", false)] {
        let text = render.replace(env!("CARGO_BIN_EXE_fstop"), "fstop_render");
        let text = stand_ins.replace("SIGNAL", signal) + &text;
        let bash = { Command::new("bash") }
            .args(["-c", &text])
            .env("SLURM_ARRAY_TASK_ID", "2")
            .env("SLURM_ARRAY_JOB_ID", "17")
            .output()
            .expect("bash");
        assert_eq!(bash.status.code(), Some(75), "{bash:?}");
        let printed = String::from_utf8_lossy(&bash.stdout);
        assert_eq!(
            printed.contains("scontrol requeue 17_2"),
            requeued,
            "{bash:?}"
        );
    }
}

#[test]
fn what_slurm_would_refuse_is_refused_now() {
    let folder = Folder::new();
    for (options, expected) in [
        (["--shards", "0"].as_slice(), "--shards"),
        (&["--shards", "x"], "--shards"),
        (&["--shards", "2", "--mem", "much"], "expected a size"),
        (&["--shards", "2", "--time", "1h"], "expected minutes"),
        (
            &["--shards", "2", "--time", "3"],
            "two minutes before its limit",
        ),
        (&["--shards", "2", "--partition", "a b"], "sinfo"),
        (&["--shards", "2", "--", "--sppp", "3"], "--sppp"),
        (&["--shards", "2", "--", "-o", "b.exr"], "--output"),
        (&["--shards", "2", "--", "--variance"], "before `--`"),
        (&["--shards", "2", "--", "--half"], "before `--`"),
        (&["--shards", "2", "--", "--crop", "1,2,3"], "--crop"),
        (&["--shards", "2", "--png", "q.tga"], "ending in .png"),
        (&["--shards", "2", "-o", "q.jpg"], "q.jpg"),
        (&["--shards", "2", "--", "--error=1%"], "rounds"),
        (&["--shards", "2", "--", "--time", "9"], "--shard"),
        (&["--shards", "2", "-o", "a\nb.exr"], "control characters"),
        (&[], "--shards"),
    ] {
        let run = slurm(&folder, options);
        assert_eq!(run.code, 2, "{options:?}");
        assert!(run.stderr.contains(expected), "{options:?}\n{}", run.stderr);
    }
    let help = slurm(&folder, &["--shards", "2", "--", "--help"]).stdout;
    let is_help = help.starts_with("Renders a scene") && help.contains("Usage: fstop render [");
    assert!(is_help, "{help}");
    let run = slurm(&folder, &["--shards", "2", "-o", "no/such/a.exr"]);
    assert_eq!(
        run.code, 74,
        "a folder may be missing on this machine alone"
    );
    assert!(run.stderr.contains("no/such"), "{}", run.stderr);
    let photons = format!("Integrator \"sppm\"\n{SPHERE}");
    std::fs::write(folder.path("photons.pbrt"), photons).expect("a scene");
    let options = "farm slurm photons.pbrt --shards 2";
    let run = fstop_in(folder.0.path(), options.split(' '));
    assert_eq!(run.code, 2);
    assert!(run.stderr.contains("cannot be divided"), "{}", run.stderr);
    std::fs::remove_file(folder.path("photons.pbrt")).expect("the file");
    let run = fstop(["farm", "slurm", "no such.pbrt", "--shards", "2"]);
    assert_eq!(run.code, 2);
    assert!(run.stderr.contains("no such.pbrt"), "{}", run.stderr);
    assert!(folder.names().is_empty(), "{:?}", folder.names());
}
