//! Shards: parts of a render that are merged to the bits of the whole.

use super::cli::Folder;
use crate::common::program::{Run, fstop};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

/// Stratified samples and a real lens.
const LENS: &str = "tests/scenes/valid/realistic_camera.pbrt";
/// The same, of more pixels: a second or two of one processor for 400 samples.
const GAUSS: &str = "tests/scenes/reference/realistic_dgauss50_full.pbrt";
/// Caustics of a mirror ball: its passes take different numbers of samples in different tiles.
const BOX: &str = "tests/scenes/reference/int_cornell_path.pbrt";
/// Paths from the lights, too, which end anywhere on the film.
const BOTH_ENDS: &str = "tests/scenes/reference/int_bdpt.pbrt";
/// Light paths that are traced once for the camera paths that are joined to them and for the lens.
const FOG: &str = "tests/scenes/census/point_medium_bdpt.pbrt";
/// Ghosts of a lens, which do so, too.
const GHOSTS: &str = "tests/scenes/valid/ghosts.pbrt";

fn render(scene: &str, output: &Path, more: &[&str]) -> Run {
    let output = output.display().to_string();
    fstop([&["render", scene, "-o", &output], more].concat())
}

/// Renders shards that must be finished then.
fn shards(scene: &str, output: &Path, range: &str, more: &[&str]) {
    let run = render(scene, output, &[&["--shard", range], more].concat());
    assert_eq!(run.code, 0, "{}", run.stderr);
}

fn merge(files: &[PathBuf], output: &Path, more: &[&str]) -> Run {
    let name = |path: &Path| path.display().to_string();
    let (output, shards) = (name(output), files.iter().map(|file| name(file)));
    let shards: Vec<String> = shards.collect();
    let mut arguments = vec!["merge", "-o", &output];
    arguments.extend(shards.iter().map(String::as_str));
    arguments.extend(more);
    fstop(arguments)
}

/// The files of all shards of `a.exr`.
fn files(folder: &Folder, of: u32) -> Vec<PathBuf> {
    { 1..=of }
        .map(|number| folder.path(&format!("a.shard-{number}-of-{of}.fsc")))
        .collect()
}

fn bytes(path: &Path) -> Vec<u8> {
    std::fs::read(path).expect("the file")
}

/// Any number of shards, rendered in any order and merged in any order, is the image of one process; of a part of the
/// film, too, and of few samples in few pixels.
#[test]
fn shards_are_merged_to_the_bits_of_the_whole() {
    let folder = Folder::new();
    let (reference, output, merged) = (
        folder.path("r.exr"),
        folder.path("a.exr"),
        folder.path("m.exr"),
    );
    let run = render(GAUSS, &reference, &["--spp", "20", "--no-checkpoint"]);
    assert_eq!(run.code, 0, "{}", run.stderr);
    shards(GAUSS, &output, "1-5/5", &["--spp", "20"]);
    let run = merge(&files(&folder, 5), &merged, &[]);
    assert_eq!(run.code, 0, "{}", run.stderr);
    assert!(bytes(&reference) == bytes(&merged));
    for (more, of) in [
        (&["--spp", "100"][..], 7),
        (&["--spp", "70", "--crop", "0.1,0.83,0.4,0.9"], 2),
        (&["--spp", "200", "--crop", "0.5,0.55,0.4,0.45"], 30),
        (&["--spp", "1"], 3),
    ] {
        let run = render(
            LENS,
            &reference,
            &[more, &["--variance", "--no-checkpoint"]].concat(),
        );
        assert_eq!(run.code, 0, "{}", run.stderr);
        let more = [more, &["--variance"]].concat();
        shards(LENS, &output, &format!("2-{of}/{of}"), &more);
        shards(
            LENS,
            &output,
            &format!("1/{of}"),
            &[&more[..], &["--threads", "1"]].concat(),
        );
        let mut shards = files(&folder, of);
        shards.rotate_left(1);
        let run = merge(&shards, &merged, &["--variance"]);
        assert_eq!(run.code, 0, "{}", run.stderr);
        assert!(bytes(&reference) == bytes(&merged), "{more:?}");
    }
    // Nothing is left to do.
    let run = render(
        LENS,
        &output,
        &["--spp", "1", "--variance", "--shard", "1-3/3"],
    );
    assert_eq!(run.code, 0, "{}", run.stderr);
    assert_eq!(
        run.stderr.matches("finished before").count(),
        3,
        "{}",
        run.stderr
    );
    assert!(!output.exists());
}

/// Light paths are divided as well. Their sums are in the files, and a shard that lacks them is damaged.
#[test]
fn light_paths_are_merged_to_the_bits_of_the_whole() {
    let folder = Folder::new();
    let [reference, output, merged] = ["r.exr", "a.exr", "m.exr"].map(|name| folder.path(name));
    for (scene, more, of) in [
        (
            BOTH_ENDS,
            &["--spp", "9", "--crop", "0.2,0.9,0.1,0.8"][..],
            4,
        ),
        (BOTH_ENDS, &["--spp", "1"], 7),
        (FOG, &["--spp", "5", "--crop", "0.2,0.9,0.1,0.8"], 5),
        (GHOSTS, &["--spp", "30"], 3),
    ] {
        let whole = [more, &["--variance", "--no-checkpoint"]].concat();
        let run = render(scene, &reference, &whole);
        assert_eq!(run.code, 0, "{}", run.stderr);
        let more = [more, &["--variance"]].concat();
        shards(scene, &output, &format!("1-{of}/{of}"), &more);
        let run = merge(&files(&folder, of), &merged, &["--variance"]);
        assert_eq!(run.code, 0, "{}", run.stderr);
        assert!(bytes(&reference) == bytes(&merged), "{scene} {more:?}");
    }
    let seven = files(&folder, 7);
    let whole = bytes(&seven[3]);
    std::fs::write(&seven[3], without_light(&whole)).expect("a file");
    let run = merge(&seven, &merged, &["--allow-missing"]);
    assert_eq!(run.code, 2, "{}", run.stderr);
    let damaged = "a.shard-4-of-7.fsc: this file is damaged";
    assert!(run.stderr.contains(damaged), "{}", run.stderr);
    // Missing light is missing work: the others' is the image of fewer paths, not a darker one.
    std::fs::remove_file(&seven[3]).expect("a file");
    let six = [&seven[..3], &seven[4..]].concat();
    assert_eq!(merge(&six, &merged, &[]).code, 1);
    let run = merge(&six, &merged, &["--allow-missing"]);
    assert_eq!(run.code, 0, "{}", run.stderr);
}

#[test]
fn an_error_goal_with_light_paths_is_reached_in_rounds() {
    for (scene, goal) in [(BOTH_ENDS, "12%"), (FOG, "30%")] {
        let folder = Folder::new();
        let [reference, output, merged] = ["r.exr", "a.exr", "m.exr"].map(|name| folder.path(name));
        let plan = folder.path("a.plan").display().to_string();
        let goal = ["--error", goal];
        let whole = [&goal[..], &["--variance", "--no-checkpoint"]].concat();
        let run = render(scene, &reference, &whole);
        assert_eq!(run.code, 0, "{}", run.stderr);
        shards(scene, &output, "1-3/3", &goal);
        for _ in 0..20 {
            let of_plan = ["--plan", &plan, "--variance"];
            let run = merge(&files(&folder, 3), &merged, &of_plan);
            assert!(run.code <= 1, "{}", run.stderr);
            if merged.exists() {
                break;
            }
            let more = [&goal[..], &["--plan", &plan]].concat();
            shards(scene, &output, "1-3/3", &more);
        }
        assert!(bytes(&reference) == bytes(&merged), "{scene}");
    }
}

/// In rounds: shards that know nothing of each other, and a plan between them.
#[test]
fn an_error_goal_is_reached_in_rounds() {
    let folder = Folder::new();
    let (reference, output, merged) = (
        folder.path("r.exr"),
        folder.path("a.exr"),
        folder.path("m.exr"),
    );
    let plan = folder.path("a.plan").display().to_string();
    let goal = ["--error", "12%"];
    let run = render(BOX, &reference, &[&goal[..], &["--no-checkpoint"]].concat());
    assert_eq!(run.code, 0, "{}", run.stderr);
    shards(BOX, &output, "1-16/16", &goal);
    let run = merge(&files(&folder, 16), &merged, &[]);
    assert_eq!(run.code, 2, "{}", run.stderr);
    assert!(
        run.stderr.contains("plan the next round (--plan FILE)"),
        "{}",
        run.stderr
    );
    let mut rounds = 0;
    loop {
        let run = merge(&files(&folder, 16), &merged, &["--plan", &plan]);
        if run.code == 0 {
            break;
        }
        assert_eq!(run.code, 1, "{}", run.stderr);
        rounds += 1;
        let again = bytes(Path::new(&plan));
        merge(&files(&folder, 16), &merged, &["--plan", &plan]);
        assert!(bytes(Path::new(&plan)) == again);
        let next = [&goal[..], &["--plan", &plan]].concat();
        shards(BOX, &output, "1-9/16", &next);
        // The others have not heard of it.
        let run = merge(&files(&folder, 16), &merged, &["--plan", &plan]);
        assert_eq!(run.code, 1, "{}", run.stderr);
        assert!(
            run.stderr.contains("shard 16/16 has finished"),
            "{}",
            run.stderr
        );
        shards(BOX, &output, "10-16/16", &next);
    }
    assert!(rounds > 1);
    // What is good enough is finished by the plan that led to it.
    let next = [&goal[..], &["--shard", "1-16/16", "--plan", &plan]].concat();
    let run = render(BOX, &output, &next);
    assert_eq!(run.code, 0, "{}", run.stderr);
    assert_eq!(
        run.stderr.matches("finished before").count(),
        16,
        "{}",
        run.stderr
    );
    assert!(bytes(&reference) == bytes(&merged));
    // A plan of another seed.
    let other = ["--seed", "1", "--shard", "1/16", "--plan", &plan];
    let run = render(BOX, &output, &[&goal[..], &other].concat());
    assert_eq!(run.code, 2, "{}", run.stderr);
    assert!(
        run.stderr
            .contains("the plan of another render: --seed is 1"),
        "{}",
        run.stderr
    );
}

/// A shard that is killed goes on where it was.
#[test]
fn a_killed_shard_is_continued() {
    let folder = Folder::new();
    let (reference, output, merged) = (
        folder.path("r.exr"),
        folder.path("a.exr"),
        folder.path("m.exr"),
    );
    // One thread takes more than a second for a shard: it is killed long before its end.
    let goal = ["--spp", "400"];
    let run = render(
        GAUSS,
        &reference,
        &[&goal[..], &["--no-checkpoint"]].concat(),
    );
    assert_eq!(run.code, 0, "{}", run.stderr);
    let kept = [&goal[..], &["--checkpoint-every", "0.02s"]].concat();
    let [first, _] = [0, 1].map(|shard| files(&folder, 2)[shard].clone());
    let name = output.display().to_string();
    let slowly = [
        "render",
        GAUSS,
        "-o",
        &name,
        "--shard",
        "1/2",
        "--threads",
        "1",
    ];
    let arguments = [&slowly[..], &kept].concat();
    let mut child = { Command::new(env!("CARGO_BIN_EXE_fstop")) }
        .args(arguments)
        .stderr(Stdio::null())
        .spawn()
        .expect("the program");
    let start = Instant::now();
    let size = || first.metadata().map_or(0, |found| found.len());
    while size() < 8192 && start.elapsed() < Duration::from_secs(60) {
        std::thread::sleep(Duration::from_millis(5));
    }
    child.kill().expect("it can be killed");
    child.wait().expect("a child");
    shards(GAUSS, &output, "2/2", &kept);
    let run = merge(&files(&folder, 2), &merged, &[]);
    assert_eq!(run.code, 1, "{}", run.stderr);
    assert!(
        run.stderr.contains("shard 1/2 is not finished"),
        "{}",
        run.stderr
    );
    // What there is of it.
    let run = merge(&files(&folder, 2), &merged, &["--allow-missing"]);
    assert_eq!(run.code, 0, "{}", run.stderr);
    assert!(
        run.stderr.contains("not all of the image"),
        "{}",
        run.stderr
    );
    shards(GAUSS, &output, "1/2", &kept);
    let run = merge(&files(&folder, 2), &merged, &[]);
    assert_eq!(run.code, 0, "{}", run.stderr);
    assert!(bytes(&reference) == bytes(&merged));
}

/// A loss of power may leave a file with nothing in it.
#[test]
fn an_empty_file_is_no_shard_yet() {
    let folder = Folder::new();
    let [first, second] = [0, 1].map(|shard| files(&folder, 2)[shard].clone());
    std::fs::write(&first, "").expect("a file");
    let output = folder.path("a.exr");
    shards(GAUSS, &output, "1-2/2", &["--spp", "1"]);
    let run = merge(&[first, second], &output, &[]);
    assert_eq!(run.code, 0, "{}", run.stderr);
}

/// What does not belong together is named.
#[test]
fn mixtures_are_refused() {
    let folder = Folder::new();
    let (output, merged) = (folder.path("a.exr"), folder.path("m.exr"));
    let goal = ["--spp", "4"];
    shards(LENS, &output, "1-3/3", &goal);
    let three = files(&folder, 3);
    let refuses = |files: &[PathBuf], code: i32, what: &str| {
        let run = merge(files, &merged, &[]);
        assert_eq!(run.code, code, "{}", run.stderr);
        assert!(run.stderr.contains(what), "{what}: {}", run.stderr);
        assert!(!merged.exists());
    };
    refuses(&three[1..], 1, "shard 1/3 is missing");
    refuses(
        &[&three[..], &three[1..2]].concat(),
        2,
        "both are shard 2/3",
    );
    shards(LENS, &output, "1/2", &goal);
    refuses(
        &[three[1].clone(), files(&folder, 2)[0].clone()],
        2,
        "the shards (1/2, 2/3)",
    );
    shards(
        LENS,
        &folder.path("b.exr"),
        "3/3",
        &["--spp", "4", "--seed", "5"],
    );
    let other = folder.path("b.shard-3-of-3.fsc");
    let mixture = [&three[..2], &[other]].concat();
    refuses(
        &mixture,
        2,
        "different renders, which differ in --seed (0, 5)",
    );
    // The shard of another render is not overwritten either.
    let run = render(LENS, &output, &["--spp", "5", "--shard", "1/3"]);
    assert_eq!(run.code, 2, "{}", run.stderr);
    assert!(
        run.stderr.contains("--spp is 5, the checkpoint's is 4"),
        "{}",
        run.stderr
    );

    let whole = bytes(&three[0]);
    std::fs::write(&three[0], "a letter").expect("a file");
    refuses(&three, 2, "no checkpoint of this version of fstop");
    std::fs::write(&three[0], &whole[..whole.len() / 2]).expect("a file");
    refuses(&three, 1, "shard 1/3 is not finished");
    let mut damaged = whole.clone();
    let middle = damaged.len() / 2;
    damaged[middle] ^= 1;
    std::fs::write(&three[0], &damaged).expect("a file");
    refuses(&three, 1, "of the file were cut off or are damaged");
    // As large a lie as fits into a number: refused before anything is done about it.
    for lie in ["\"of\":4294967295", "\"of\":0", "\"of\":2"] {
        std::fs::write(&three[0], forged(&whole, "\"of\":3", lie)).expect("a file");
        let what = match lie.ends_with('2') {
            true => "the shards (1/2, 2/3)",
            false => "impossible things",
        };
        refuses(&three, 2, what);
    }
    let resolution = "\"resolution\":[4294967295,1]";
    let found = String::from_utf8_lossy(&whole).into_owned();
    let start = found.find("\"resolution\"").expect("a film");
    let end = start + found[start..].find(']').expect("its end") + 1;
    let lie = forged(&whole, &found[start..end], resolution);
    std::fs::write(&three[0], lie).expect("a file");
    refuses(&three, 2, "impossible things");
    // What says that it is finished, but is not.
    let cut = without_a_record(&whole);
    std::fs::write(&three[0], cut).expect("a file");
    refuses(&three, 2, "this file is damaged");
    std::fs::write(&three[0], &damaged).expect("a file");
    // All of it is rendered again, whatever the tiles of the others.
    shards(
        LENS,
        &output,
        "1/3",
        &[&goal[..], &["--tile-size", "8"]].concat(),
    );
    let run = merge(&three, &merged, &[]);
    assert_eq!(run.code, 0, "{}", run.stderr);
}

/// After the first line.
const HEADER: usize = b"fstop checkpoint 5\n".len();

/// A record with its length and checksum.
fn framed(body: &[u8]) -> Vec<u8> {
    let length = (body.len() as u32).to_le_bytes();
    let mut crc = flate2::Crc::new();
    crc.update(&length);
    crc.update(body);
    [&length[..], body, &crc.sum().to_le_bytes()].concat()
}

/// The end of the record that starts at `start`.
fn end_of(file: &[u8], start: usize) -> usize {
    let length = file[start..start + 4].try_into().expect("four bytes");
    start + u32::from_le_bytes(length) as usize + 8
}

/// A checkpoint whose header says something else.
fn forged(file: &[u8], from: &str, to: &str) -> Vec<u8> {
    let end = end_of(file, HEADER);
    let header = String::from_utf8_lossy(&file[HEADER + 4..end - 4]).into_owned();
    assert!(header.contains(from), "{from} in {header}");
    let header = framed(header.replace(from, to).as_bytes());
    [&file[..HEADER], &header, &file[end..]].concat()
}

/// A checkpoint without its first record after the header.
fn without_a_record(file: &[u8]) -> Vec<u8> {
    let header = end_of(file, HEADER);
    [&file[..header], &file[end_of(file, header)..]].concat()
}

/// A checkpoint without its sums of splats, whose records begin with a 5.
fn without_light(file: &[u8]) -> Vec<u8> {
    let (mut at, mut out) = (HEADER, file[..HEADER].to_vec());
    while at < file.len() {
        let end = end_of(file, at);
        // The header's is a brace.
        if file[at + 4] != 5 {
            out.extend(&file[at..end]);
        }
        at = end;
    }
    assert!(out.len() < file.len());
    out
}

#[test]
fn what_cannot_be_divided_is_refused() {
    let output = Path::new("a.exr");
    for (more, what) in [
        (&["--shard", "0/3"][..], "K/N"),
        (&["--shard", "1/3", "--time", "3"], "cannot be used with"),
        (&["--plan", "a.plan"], "--shard"),
        (&["--shard", "auto"], "neither Slurm"),
        (
            &["--shard", "1/3", "--error", "9%", "--plan", "no.plan"],
            "no.plan: cannot read",
        ),
    ] {
        let run = render(LENS, output, more);
        assert_eq!(run.code, 2, "{more:?}: {}", run.stderr);
        assert!(run.stderr.contains(what), "{more:?}: {}", run.stderr);
    }
}
