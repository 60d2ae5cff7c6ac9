//! Photon mapping: the same bytes for any number of threads, goals that it reaches, and what it refuses.

use super::cli::Folder;
use crate::common::program::fstop;
use fstop::film::read;

/// A ball of glass with its caustic, and one of chalk.
const SCENE: &str = "tests/scenes/reference/int_sppm.pbrt";

fn render(folder: &Folder, options: &[&str]) -> Vec<u8> {
    let output = folder.path("a.exr");
    let name = output.display().to_string();
    let run = fstop([&["render", SCENE, "-o", &name, "--variance"], options].concat());
    assert_eq!(run.code, 0, "{}", run.stderr);
    std::fs::read(output).expect("the image")
}

#[test]
fn threads_and_tiles_change_no_byte() {
    let folder = Folder::new();
    for goal in [["--spp", "4"], ["--error", "80%"]] {
        let ways: [&[&str]; 3] = [
            &["--threads", "1"],
            &["--threads", "2", "--tile-size", "1000"],
            &["--threads", "5", "--tile-size", "7"],
        ];
        let all = ways.map(|way| render(&folder, &[way, &goal[..]].concat()));
        assert!(all[0] == all[1] && all[0] == all[2], "{goal:?}");
    }
}

#[test]
fn seeds_are_independent_and_samples_are_iterations() {
    let folder = Folder::new();
    let [a, b] = ["1", "2"].map(|seed| render(&folder, &["--spp", "3", "--seed", seed]));
    assert!(a != b);
    let loaded = read(&folder.path("a.exr")).expect("an image");
    assert_eq!(loaded.spp, Some(3));
    render(&folder, &["--quick"]);
    // A sixteenth of 64.
    assert_eq!(read(&folder.path("a.exr")).expect("an image").spp, Some(4));
    render(&folder, &["--time", "0.001"]);
    assert_eq!(read(&folder.path("a.exr")).expect("an image").spp, Some(1));
}

#[test]
fn what_cannot_be_divided_is_refused() {
    let folder = Folder::new();
    let output = folder.path("a.exr").display().to_string();
    for (option, remedy) in [
        (&["--shard", "1/2"][..], "--seed"),
        (
            &["--confidence", "95%", "--error", "9%"],
            "leave the option out",
        ),
    ] {
        let run = fstop([&["render", SCENE, "-o", &output][..], option].concat());
        assert_eq!(run.code, 2, "{}", run.stderr);
        assert!(
            run.stderr.contains(option[0]) && run.stderr.contains(remedy),
            "{}",
            run.stderr
        );
    }
}
