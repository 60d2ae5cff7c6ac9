//! Where results go: links, names that no file can have, folders that are gone or full when the image
//! is done. No image is lost, and no half of one is left.

use super::cli::{Folder, MITCHELL, OBJECTS, command, load};
use crate::common::program::{fstop, fstop_in};
use std::ffi::OsString;
use std::io::{BufRead, BufReader, Read};
use std::path::Path;
use std::process::{Child, Command, Stdio};

/// Commands that write a file of each kind to `output`.
fn writers(folder: &Folder, output: &Path, ending: &str) -> Vec<Vec<OsString>> {
    let words = |line: &str| line.split(' ').map(OsString::from).collect::<Vec<_>>();
    let image = folder.path("image.exr");
    if !image.exists() {
        folder.render(OBJECTS, "image.exr", &["--spp", "1"]);
    }
    let mut compare = words("compare --no-flip");
    compare.extend([image.clone().into(), image.into(), "--html".into()]);
    let commands = match ending {
        "exr" => vec![words(&format!("render {OBJECTS} --spp 1 -o"))],
        _ => vec![
            words("lens lenses/wide.22mm.dat --svg"),
            words("lens lenses/wide.22mm.dat --report"),
            words(&format!("tradeoff {OBJECTS} --time 0.1 --html")),
            compare,
        ],
    };
    commands
        .into_iter()
        .map(|mut command| {
            command.push(output.into());
            command
        })
        .collect()
}

#[cfg(unix)]
#[test]
fn what_a_link_leads_to_is_replaced() {
    let folder = Folder::new();
    let (link, target) = (folder.path("link.exr"), folder.path("there/target"));
    std::fs::create_dir(folder.path("there")).expect("a folder");
    std::os::unix::fs::symlink("there/target", &link).expect("a link");
    for ending in ["exr", "html"] {
        for arguments in writers(&folder, &link, ending) {
            std::fs::write(&target, "old").expect("a file");
            let run = fstop(&arguments);
            assert_eq!(run.code, 0, "{arguments:?}\n{}", run.stderr);
            assert!(link.is_symlink(), "{arguments:?} replaced the link");
            let size = target.metadata().expect("the file").len();
            assert!(size > 500, "{arguments:?} left {size} bytes");
            assert_eq!(folder.names(), ["image.exr", "link.exr", "there"]);
        }
    }
}

/// What a command reads, and what another of its options writes.
#[test]
fn no_file_is_overwritten_that_is_read_or_written_besides() {
    let folder = Folder::new();
    folder.render(OBJECTS, "image.exr", &["--spp", "1"]);
    let copy = |from: &str, to: &str| {
        let path = folder.path(to);
        std::fs::copy(from, &path).expect("a copy");
        path
    };
    let image = folder.path("image.exr");
    let scene = copy(OBJECTS, "scene.pbrt");
    let lens = copy("lenses/wide.22mm.dat", "lens.dat");
    let page = folder.path("page");
    let [image, scene, lens, page] = [&image, &scene, &lens, &page].map(|path| path.as_os_str());
    let before = [image, scene, lens].map(|path| std::fs::read(path).expect("a file"));
    let word = std::ffi::OsStr::new;
    let commands = [
        vec![word("compare"), image, image, word("--html"), image],
        vec![word("compare"), image, image, word("--junit"), image],
        vec![
            word("compare"),
            image,
            image,
            word("--html"),
            page,
            word("--markdown"),
            page,
        ],
        vec![word("tradeoff"), scene, word("--html"), scene],
        vec![word("lens"), lens, word("--report"), lens],
        vec![
            word("render"),
            scene,
            word("-o"),
            image,
            word("--stats"),
            scene,
        ],
    ];
    for arguments in commands {
        let run = fstop(&arguments);
        assert_eq!(run.code, 2, "{arguments:?}\n{}", run.stderr);
    }
    let textured = "Texture \"t\" \"color\" \"imagemap\" \"string filename\" \"image.exr\"
        Material \"matte\" \"texture Kd\" \"t\"";
    let sphere = "Film \"image\" WorldBegin Include \"part.png\" Shape \"sphere\" WorldEnd\n";
    std::fs::write(folder.path("part.png"), textured).expect("a file");
    std::fs::write(folder.path("s.pbrt"), [sphere, sphere].concat()).expect("a file");
    for (options, why) in [
        ("-o image.exr", "image.exr: is not overwritten"),
        ("-o ../%/image.exr", "image.exr: is not overwritten"),
        ("-o a.exr --png part.png", "part.png: is not overwritten"),
        (
            "-o a.exr --stats image.exr",
            "image.exr: is not overwritten",
        ),
        (
            "-o a.png --png a.2.png",
            "a.2.png: cannot write: another output",
        ),
    ] {
        let name = folder
            .0
            .path()
            .file_name()
            .expect("a name")
            .to_string_lossy();
        let options = format!("render s.pbrt --spp 1 {options}").replace('%', &name);
        let run = fstop_in(folder.0.path(), options.split(' '));
        assert_eq!(run.code, 2, "{options}\n{}", run.stderr);
        assert!(run.stderr.contains(why), "{options}\n{}", run.stderr);
    }
    // Shards write no unfinished image.
    let unfinished = sphere.replace("part.png", "a.partial.exr");
    std::fs::write(folder.path("a.partial.exr"), textured).expect("a file");
    std::fs::write(folder.path("p.pbrt"), unfinished).expect("a file");
    let whole = ["render", "p.pbrt", "--spp", "1", "-o", "a.exr"];
    let run = fstop_in(folder.0.path(), whole);
    let why = "a.partial.exr: is not overwritten";
    assert!(run.code == 2 && run.stderr.contains(why), "{}", run.stderr);
    let run = fstop_in(folder.0.path(), [&whole[..], &["--shard", "1/1"]].concat());
    assert_eq!(run.code, 0, "{}", run.stderr);
    let after = [image, scene, lens].map(|path| std::fs::read(path).expect("a file"));
    assert!(before == after);
    assert!(!folder.path("page").exists());
}

#[test]
fn each_frame_has_a_name_of_its_own() {
    let folder = Folder::new();
    let frame = |name: &str| {
        format!(
            "Film \"image\" \"integer xresolution\" 4 \"integer yresolution\" 4 \"string filename\" \"{name}\" WorldBegin Shape \"sphere\" WorldEnd\n"
        )
    };
    let scene = ["p.exr", "p.3.exr", "p.exr"].map(frame).concat();
    std::fs::write(folder.path("s.pbrt"), scene).expect("a scene");
    let run = fstop_in(folder.0.path(), ["render", "s.pbrt", "--spp", "1"]);
    assert_eq!(run.code, 0, "{}", run.stderr);
    assert!(
        run.stderr.contains("`p.4.exr` is used for frame 3"),
        "{}",
        run.stderr
    );
    assert_eq!(folder.names(), ["p.3.exr", "p.4.exr", "p.exr", "s.pbrt"]);
}

/// Before anything is rendered, measured or compared, and nothing is left lying about.
#[test]
fn what_cannot_be_written_is_refused_first() {
    let folder = Folder::new();
    let kept = folder.path("kept.exr");
    std::fs::write(&kept, "kept").expect("a file");
    let mut permissions = kept.metadata().expect("the file").permissions();
    permissions.set_readonly(true);
    std::fs::set_permissions(&kept, permissions).expect("permissions");
    let long = "x".repeat(252) + ".exr";
    for (name, why, code) in [
        ("kept.exr", "read-only", 74),
        ("new.exr/", "the name of a folder", 2),
        (long.as_str(), "cannot write", 2),
        ("none/new.exr", "there is no folder", 74),
    ] {
        let output = folder.path(name);
        // At a million samples a pixel, rendering first would not end within the test's patience.
        let options = ["--spp", "1000000"];
        let mut commands = writers(&folder, &output, "html");
        commands.push(command("render", MITCHELL, &output, &options));
        for arguments in commands {
            let run = fstop(&arguments);
            assert_eq!(run.code, code, "{arguments:?}\n{}", run.stderr);
            assert!(run.stderr.contains(why), "{arguments:?}\n{}", run.stderr);
            assert!(!run.stderr.contains("settings"), "{arguments:?}: late");
            assert_eq!(folder.names(), ["image.exr", "kept.exr"]);
        }
    }
    assert_eq!(std::fs::read(&kept).expect("the file"), b"kept");
}

/// Starts a render of `options`, and waits until all outputs were found to be good.
fn started(folder: &Folder, output: &str, options: &[&str]) -> (Child, BufReader<impl Read>) {
    let scene = Path::new(env!("CARGO_MANIFEST_DIR")).join(MITCHELL);
    let mut arguments = command("render", "", Path::new(output), options);
    arguments[1] = scene.into();
    let mut child = Command::new(env!("CARGO_BIN_EXE_fstop"))
        .args(arguments)
        .current_dir(folder.path("here"))
        .env("TMPDIR", folder.path("spare"))
        .stderr(Stdio::piped())
        .spawn()
        .expect("the program starts");
    let mut messages = BufReader::new(child.stderr.take().expect("a pipe"));
    let mut line = String::new();
    while !line.contains("field of view") {
        line.clear();
        assert!(
            messages.read_line(&mut line).expect("text") > 0,
            "no render"
        );
    }
    (child, messages)
}

fn folders(folder: &Folder) {
    for name in ["here", "there", "spare"] {
        std::fs::create_dir(folder.path(name)).expect("a folder");
    }
}

/// The folder has gone while the image was rendered.
#[test]
fn an_image_without_its_folder_is_rescued() {
    let folder = Folder::new();
    folders(&folder);
    std::fs::write(folder.path("here/a.exr"), "another's").expect("a file");
    let (mut child, mut messages) = started(&folder, "../there/a.exr", &["--spp", "256"]);
    std::fs::remove_dir(folder.path("there")).expect("an empty folder");
    let mut said = String::new();
    messages.read_to_string(&mut said).expect("text");
    assert_eq!(child.wait().expect("an end").code(), Some(74), "{said}");
    assert!(
        said.contains("a.exr: cannot write: there is no folder `../there`"),
        "{said}"
    );
    assert!(said.contains("here/a.2.exr` instead"), "{said}");
    assert!(!said.contains("not written"), "{said}");
    assert_eq!(load(&folder.path("here/a.2.exr")).spp, Some(256));
    let other = std::fs::read(folder.path("here/a.exr")).expect("the file");
    assert_eq!(other, b"another's");
}

/// A file system of this many KiB.
#[cfg(target_os = "linux")]
struct Small<'a>(&'a Path);

#[cfg(target_os = "linux")]
impl Small<'_> {
    fn mount(path: &Path, size: u32) -> Option<Small<'_>> {
        let mount = Command::new("mount")
            .args(["-t", "tmpfs", "-o", &format!("size={size}k"), "none"])
            .arg(path)
            .stderr(Stdio::null())
            .status();
        mount
            .is_ok_and(|status| status.success())
            .then_some(Small(path))
    }
}

#[cfg(target_os = "linux")]
impl Drop for Small<'_> {
    fn drop(&mut self) {
        let done = Command::new("umount").arg(self.0).status();
        assert!(done.is_ok_and(|status| status.success()), "still mounted");
    }
}

/// The disk turns out to be full, and the current folder too: the folder for temporary files is the last refuge. One
/// that is nearly full is told of before anything is rendered.
#[cfg(target_os = "linux")]
#[test]
fn an_image_on_a_full_disk_is_rescued() {
    // 64 × 64 pixels take 48 KiB, and are thought to take at least half of that.
    for (size, samples, expected) in [
        (32, "1", ["a.pfm: cannot write: ", "spare/a.pfm` instead"]),
        (
            16,
            "100000000",
            ["a.pfm: cannot write: 16 KiB are free", "needs about 24"],
        ),
    ] {
        let folder = Folder::new();
        folders(&folder);
        let here = folder.path("here");
        let Some(_small) = Small::mount(&here, size) else {
            println!("skipped: this user may not mount a small disk");
            return;
        };
        let scene = Path::new(env!("CARGO_MANIFEST_DIR")).join(MITCHELL);
        let run = Command::new(env!("CARGO_BIN_EXE_fstop"))
            .args(["render", "--spp", samples, "-o", "a.pfm"])
            .arg(scene)
            .current_dir(&here)
            .env("TMPDIR", folder.path("spare"))
            .output()
            .expect("the program starts");
        let said = String::from_utf8_lossy(&run.stderr);
        assert_eq!(run.status.code(), Some(74), "{said}");
        for part in expected {
            assert!(said.contains(part), "{said}");
        }
        let saved = folder.path("spare/a.pfm").metadata();
        assert_eq!(
            saved.is_ok_and(|file| file.len() > 64 * 64 * 12),
            size == 32
        );
        let left: Vec<_> = std::fs::read_dir(&here).expect("a folder").collect();
        assert!(left.is_empty(), "{left:?}");
    }
}

/// Whenever a signal comes, there is a whole image, what there is of one under a name that says so, or none, and
/// nothing else.
#[cfg(unix)]
#[test]
fn nothing_stays_behind_after_a_signal() {
    for signal in ["-INT", "-TERM", "-KILL"] {
        for milliseconds in [0, 60, 120] {
            let folder = Folder::new();
            folders(&folder);
            let (mut child, _messages) = started(&folder, "a.exr", &["--spp", "40"]);
            std::thread::sleep(std::time::Duration::from_millis(milliseconds));
            let id = child.id().to_string();
            let sent = Command::new("kill")
                .args([signal, &id])
                .stderr(Stdio::null())
                .status();
            sent.expect("the command kill");
            child.wait().expect("an end");
            let mut left = std::fs::read_dir(folder.path("here")).expect("a folder");
            if let Some(file) = left.next() {
                let path = file.expect("an entry").path();
                assert!(
                    path.ends_with("a.exr") || path.ends_with("a.partial.exr"),
                    "{path:?}"
                );
                load(&path);
            }
            assert!(left.next().is_none());
        }
    }
}
