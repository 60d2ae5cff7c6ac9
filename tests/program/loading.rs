//! What only shows when a scene's files are loaded or its rays are followed: where it is reported,
//! and when.

use crate::common::program::{Run, fstop_in};
use std::ffi::OsStr;
use std::path::PathBuf;

/// A folder with a scene `s.pbrt` in it, gone with the test.
struct Folder(tempfile::TempDir);

impl Folder {
    fn new() -> Folder {
        Folder(tempfile::tempdir().expect("a temporary folder"))
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    fn write(&self, name: &str, content: impl AsRef<[u8]>) {
        std::fs::write(self.path(name), content).expect("a file");
    }

    /// `fstop ARGUMENTS` in the folder.
    fn run<A: AsRef<OsStr>>(&self, arguments: impl IntoIterator<Item = A>) -> Run {
        fstop_in(self.0.path(), arguments)
    }
}

/// What only shows when files are loaded: check and render say the same of it, at the place that
/// names the file.
#[test]
fn broken_files_are_reported_where_they_are_named() {
    let folder = Folder::new();
    for name in ["bad.png", "bad.ply", "bad.bsdf"] {
        folder.write(name, "no such thing");
    }
    folder.write("bad.obj", "v 0 0 0\nf 1 2 9\n");
    folder.write("zero.png", "");
    for (line, place, words) in [
        (
            "Texture \"t\" \"spectrum\" \"imagemap\" \"string filename\" \"bad.png\"\n\
             Material \"matte\" \"texture Kd\" \"t\"\nShape \"sphere\"",
            "s.pbrt:3:53\n",
            "error: cannot decode 'bad.png'",
        ),
        (
            // By way of another texture, and a float one.
            "Texture \"t\" \"float\" \"imagemap\" \"string filename\" \"bad.png\"\n\
             Texture \"u\" \"float\" \"scale\" \"texture tex1\" \"t\"\n\
             Material \"matte\" \"texture bumpmap\" \"u\"\nShape \"sphere\"",
            "s.pbrt:3:50\n",
            "error: cannot decode 'bad.png'",
        ),
        (
            "LightSource \"infinite\" \"string mapname\" \"zero.png\"",
            "s.pbrt:3:41\n",
            "error: cannot decode 'zero.png'",
        ),
        (
            "Shape \"plymesh\" \"string filename\" \"bad.ply\"",
            "s.pbrt:3:35\n",
            "error: bad.ply: ",
        ),
        (
            "ObjectBegin \"o\"\nShape \"objmesh\" \"string filename\" \"bad.obj\"\nObjectEnd",
            "s.pbrt:4:35\n",
            "error: bad.obj: ",
        ),
        (
            "Material \"fourier\" \"string bsdffile\" \"bad.bsdf\"\nShape \"sphere\"",
            "s.pbrt:3:38\n",
            "error: cannot use the BSDF file 'bad.bsdf': it does not start with SCATFUN",
        ),
    ] {
        let text = format!("WorldBegin\nLightSource \"point\"\n{line}\nWorldEnd\n");
        folder.write("s.pbrt", text);
        let check = folder.run(["check", "s.pbrt"]);
        assert_eq!(check.code, 2, "{line}\n{}{}", check.stdout, check.stderr);
        assert!(check.stdout.contains("(1 error)"), "{}", check.stdout);
        for part in [place, words, "^^^"] {
            assert!(check.stderr.contains(part), "{part}\n{}", check.stderr);
        }
        let render = folder.run(["render", "s.pbrt", "-o", "a.exr"]);
        assert_eq!((render.code, &render.stderr), (2, &check.stderr), "{line}");
        assert!(!folder.path("a.exr").exists());
    }
}

/// What nothing in the image uses does not stop it.
#[test]
fn a_broken_image_nobody_uses_is_a_warning() {
    let folder = Folder::new();
    folder.write("bad.png", "no such thing");
    let scene = "Film \"image\" \"integer xresolution\" 8 \"integer yresolution\" 6\nWorldBegin\n\
                 LightSource \"infinite\"\nTexture \"t\" \"spectrum\" \"imagemap\" \"string filename\" \
                 \"bad.png\"\nMakeNamedMaterial \"m\" \"string type\" \"matte\" \"texture Kd\" \"t\"\n\
                 Shape \"sphere\"\nWorldEnd\n";
    folder.write("s.pbrt", scene);
    let check = folder.run(["check", "s.pbrt"]);
    assert_eq!(check.stdout, "s.pbrt: ok (1 warning)\n", "{}", check.stderr);
    let render = folder.run(["s.pbrt", "--spp", "1", "-o", "a.exr"]);
    assert_eq!(render.code, 0, "{}", render.stderr);
    for run in [check, render] {
        let words = "warning: cannot decode 'bad.png'";
        assert!(run.stderr.contains(words), "{}", run.stderr);
        assert!(run.stderr.contains("s.pbrt:4:53\n"), "{}", run.stderr);
    }
}

/// A film's file name is wrong where it stands, unless `-o` names another.
#[test]
fn a_films_file_name_is_checked_at_its_place() {
    let folder = Folder::new();
    let scene = "Film \"image\" \"string filename\" \"a.gif\"\n \"integer xresolution\" 8 \
                 \"integer yresolution\" 6\nWorldBegin\nLightSource \"infinite\"\nWorldEnd\n";
    folder.write("s.pbrt", scene);
    let check = folder.run(["check", "s.pbrt"]);
    assert_eq!(check.code, 2, "{}", check.stdout);
    assert!(check.stderr.contains("must end in"), "{}", check.stderr);
    assert!(check.stderr.contains("s.pbrt:1:32\n"), "{}", check.stderr);
    let render = folder.run(["render", "s.pbrt"]);
    assert_eq!((render.code, render.stderr), (2, check.stderr));
    let elsewhere = folder.run(["s.pbrt", "-o", "a.exr", "--spp", "1"]);
    assert_eq!(elsewhere.code, 0, "{}", elsewhere.stderr);
    folder.write("s.pbrt", scene.replace("a.gif", "no/a.exr"));
    let nowhere = folder.run(["render", "s.pbrt"]);
    let (code, said) = (nowhere.code, nowhere.stderr);
    assert!(
        code == 74 && said.contains("no folder `no`") && said.contains("s.pbrt:1:32\n"),
        "{said}"
    );
}

/// Samples without a finite value are counted and located, the same for any tiles.
#[test]
fn samples_that_are_not_finite_are_located() {
    let folder = Folder::new();
    // Finite each, but not their product.
    let scene = "Film \"image\" \"integer xresolution\" 8 \"integer yresolution\" 6\nWorldBegin\n\
                 LightSource \"infinite\" \"rgb L\" [3e38 3e38 3e38] \"rgb scale\" [10 10 10]\nWorldEnd\n";
    folder.write("s.pbrt", scene);
    let crop = ["--crop", ".5,1,.5,1", "--spp", "2"];
    for tiles in ["1", "3", "100"] {
        let options = ["s.pbrt", "-o", "a.exr", "--tile-size", tiles];
        let run = folder.run(options.iter().chain(&crop));
        assert_eq!(run.code, 0, "{}", run.stderr);
        let words = "warning: 24 of the samples were negative or not finite, and count as black; \
                     the first is sample 0 of pixel 4, 3 (both from 0), \
                     in the light from beyond the scene at depth 0";
        assert!(run.stderr.contains(words), "{}", run.stderr);
    }
    // Such a sky in a mirror, and such a sun on a wall.
    let wall = |material: &str, light: &str| {
        let shape = format!("Material \"{material}\" Shape \"sphere\" \"float radius\" 9");
        let world = format!("Translate 0 0 10\n{shape}\nWorldEnd");
        scene.replace("infinite", light).replace("WorldEnd", &world)
    };
    let (mirror, matte) = (wall("mirror", "infinite"), wall("matte", "distant"));
    let sky = "in the light from beyond the scene at depth 1";
    for (integrator, scene, words) in [
        ("path", &mirror, sky),
        ("whitted", &mirror, sky),
        ("path", &matte, "at a `matte` at depth 0"),
        ("directlighting", &matte, "at a `matte` at depth 0"),
        ("volpath", &matte, "at a `matte` at depth 0"),
    ] {
        folder.write("s.pbrt", format!("Integrator \"{integrator}\"\n{scene}"));
        let run = folder.run(["s.pbrt", "-o", "a.exr", "--spp", "2"]);
        let last = format!("the first is sample 0 of pixel 0, 0 (both from 0), {words}");
        assert!(run.stderr.contains(&last), "{integrator}: {}", run.stderr);
    }
}

/// A sample that its light path makes infinite is found again with that path, which depends on the pass: with one of another pass there would be nothing to be
/// found.
#[test]
fn samples_of_an_error_goal_are_located_with_their_light_paths() {
    let folder = Folder::new();
    // Joints of vertices that are close to each other are more than a float holds.
    let scene = r#"
        MakeNamedMedium "fog" "string type" "homogeneous" "color sigma_a" [.5 .5 .5] "color sigma_s" [3 2 1] "float g" [0.5]
        LookAt 0 .8 -1  0 .05 0  0 1 0
        Camera "perspective" "float fov" [40]
        Film "image" "integer xresolution" [16] "integer yresolution" [16]
        PixelFilter "box"
        Sampler "random" "integer pixelsamples" [128]
        Integrator "bdpt" "integer maxdepth" [5]
        WorldBegin
        Scale .2 .2 .2
        AttributeBegin
            MediumInterface "fog" "fog"
            LightSource "point" "point from" [-.25 1 0] "color I" [1e36 1e36 1e36]
        AttributeEnd
        AttributeBegin
            MediumInterface "fog" ""
            Material "none"
            Shape "trianglemesh" "integer indices" [0 2 3 0 3 1  4 5 7 4 7 6  0 4 6 0 6 2  1 3 7 1 7 5  0 1 5 0 5 4  2 6 7 2 7 3]
                "point P" [-1.25 0.125 -1  1 0.125 -1  -1.25 1.75 -1  1 1.75 -1  -1.25 0.125 1  1 0.125 1  -1.25 1.75 1  1 1.75 1]
        AttributeEnd
        Material "matte" "color Kd" [.5 .5 .5]
        Shape "trianglemesh" "integer indices" [0 1 2 0 2 3] "point P" [-4 0 -4  4 0 -4  4 0 4  -4 0 4]
        WorldEnd"#;
    folder.write("s.pbrt", scene);
    let run = folder.run(["s.pbrt", "-o", "a.exr", "--error", "9%"]);
    let words = "the first is sample 100 of pixel 15, 3 (both from 0), at a `matte` at depth 0";
    assert!(run.stderr.contains(words), "{}", run.stderr);
}

/// Light that is finite where it arrives, but not all of it together: paths from such a light are counted, and not left out in
/// silence.
#[test]
fn light_paths_that_are_not_finite_are_counted() {
    let folder = Folder::new();
    // 4π of the intensity are more than a float holds; a square of the distance less is not.
    let scene = |integrator: &str| {
        format!(
            "Integrator \"{integrator}\" Film \"image\" \"integer xresolution\" 8 \"integer yresolution\" 8\n\
             WorldBegin LightSource \"point\" \"rgb I\" [1e38 1e38 1e38]\n\
             Material \"plastic\" Shape \"sphere\" \"float radius\" 1e6\nWorldEnd\n"
        )
    };
    for (integrator, counted) in [("path", false), ("bdpt", true)] {
        folder.write("s.pbrt", scene(integrator));
        let run = folder.run(["s.pbrt", "-o", "a.exr", "--spp", "4"]);
        assert_eq!(run.code, 0, "{}", run.stderr);
        let said = run.stderr.contains("not finite, and count as black");
        assert_eq!(said, counted, "{integrator}: {}", run.stderr);
    }
}

/// The last frame's broken mesh is found before the first is rendered.
#[test]
fn later_frames_are_checked_before_the_first_is_rendered() {
    let folder = Folder::new();
    folder.write("bad.ply", "no such thing");
    let frame = |content: &str| {
        format!(
            "Film \"image\" \"integer xresolution\" 64 \"integer yresolution\" 64\n\
             WorldBegin\nLightSource \"infinite\"\n{content}\nWorldEnd\n"
        )
    };
    let bad = "Shape \"plymesh\" \"string filename\" \"bad.ply\"";
    let scene = frame("Shape \"sphere\"") + &frame("") + &frame(bad);
    folder.write("s.pbrt", scene);
    // At a million samples a pixel the first frame would outlast the test's patience.
    let options = ["s.pbrt", "-o", "a.exr", "--spp", "1000000"];
    let run = folder.run(options);
    assert_eq!(run.code, 2, "{}", run.stderr);
    assert!(run.stderr.contains("s.pbrt:14:35\n"), "{}", run.stderr);
    assert!(!folder.path("a.exr").exists());
}

/// What `--keep-going` is for: each of these lines names a file that is missing or broken, at the line
/// and column given.
const BROKEN: [(&str, &str); 9] = [
    (
        "Texture \"a\" \"spectrum\" \"imagemap\" \"string filename\" \"nowhere.png\"",
        ":53\n",
    ),
    (
        "Texture \"b\" \"float\" \"imagemap\" \"string filename\" \"bad.png\"",
        ":50\n",
    ),
    (
        "Shape \"plymesh\" \"string filename\" \"a/nowhere.ply\"",
        ":35\n",
    ),
    ("Shape \"plymesh\" \"string filename\" \"bad.ply\"", ":35\n"),
    ("Include \"b/nowhere.pbrt\"", ":9\n"),
    (
        "LightSource \"infinite\" \"string mapname\" \"c/nowhere.exr\"",
        ":41\n",
    ),
    (
        "LightSource \"projection\" \"string mapname\" \"bad.png\"",
        ":43\n",
    ),
    (
        "LightSource \"point\" \"spectrum I\" \"d/nowhere.spd\"",
        ":34\n",
    ),
    (
        "ObjectBegin \"o\" Shape \"objmesh\" \"string filename\" \"e/nowhere.obj\" ObjectEnd",
        ":51\n",
    ),
];

/// A scene in which a ball shows texture `a`, with the broken lines from line 4 on.
fn broken_scene(folder: &Folder) {
    for name in ["bad.png", "bad.ply"] {
        folder.write(name, "no such thing");
    }
    let lines = BROKEN.map(|(line, _)| line).join("\n");
    let text = format!(
        "Camera \"perspective\" \"float fov\" 20\n\
         Film \"image\" \"integer xresolution\" 8 \"integer yresolution\" 8\n\
         WorldBegin\n{lines}\n\
         Material \"matte\" \"texture Kd\" \"a\" \"texture sigma\" \"b\"\nTranslate 0 0 3\nShape \"sphere\"\nWorldEnd\n"
    );
    folder.write("s.pbrt", text);
}

#[test]
fn keep_going_renders_the_rest_of_a_scene_with_broken_files() {
    let folder = Folder::new();
    broken_scene(&folder);
    let refused = folder.run(["render", "s.pbrt", "-o", "a.exr"]);
    assert_eq!(refused.code, 2, "{}", refused.stderr);
    assert!(!folder.path("a.exr").exists());
    for quiet in [None, Some("--quiet")] {
        let command = ["render", "s.pbrt", "-o", "a.exr", "--keep-going"];
        let kept = folder.run(command.into_iter().chain(quiet));
        assert_eq!(kept.code, 1, "{}", kept.stderr);
        assert!(folder.path("a.exr").exists());
        std::fs::remove_file(folder.path("a.exr")).expect("an image");
        // The same is said of every file, whether the scene is refused or not.
        for said in [&refused.stderr, &kept.stderr] {
            for (number, (line, column)) in (4..).zip(BROKEN) {
                let place = format!("s.pbrt:{number}{column}");
                assert!(said.contains(&place), "{place} {line}\n{said}");
            }
        }
        let summary = "warning: rendered in spite of 9 errors";
        assert!(kept.stderr.contains(summary), "{}", kept.stderr);
    }
}

/// What pbrt-v3 puts in the place of an image: a gray of 0.5.
#[test]
fn the_stand_in_for_an_image_is_gray() {
    let folder = Folder::new();
    folder.write(
        "s.pbrt",
        "Film \"image\" \"integer xresolution\" 8 \"integer yresolution\" 8\n\
         Camera \"perspective\" \"float fov\" 20\nIntegrator \"path\" \"integer maxdepth\" 1\nWorldBegin\n\
         LightSource \"infinite\"\n\
         Texture \"t\" \"spectrum\" \"imagemap\" \"string filename\" \"nowhere.exr\"\n\
         Material \"matte\" \"texture Kd\" \"t\"\nTranslate 0 0 3\nShape \"sphere\"\nWorldEnd\n",
    );
    let run = folder.run([
        "render",
        "s.pbrt",
        "--keep-going",
        "-o",
        "a.exr",
        "--spp",
        "64",
    ]);
    assert_eq!(run.code, 1, "{}", run.stderr);
    let image = fstop::film::read(&folder.path("a.exr"))
        .expect("an image")
        .image;
    let mean = image.pixels.iter().map(|p| p.x).sum::<f32>() / image.pixels.len() as f32;
    // A convex body under a white sky shows its albedo; 4096 samples of a Monte Carlo estimate with a
    // standard deviation below 0.3.
    assert!((mean - 0.5).abs() < 0.02, "{mean}");
}

#[test]
fn keep_going_is_not_for_what_pbrt_stops_at() {
    let folder = Folder::new();
    broken_scene(&folder);
    let strict = folder.run(["render", "s.pbrt", "--keep-going", "--strict"]);
    assert_eq!(strict.code, 2);
    assert!(
        strict.stderr.contains("cannot be used with"),
        "{}",
        strict.stderr
    );
    // Where pbrt-v3 stops, there is nothing to go on with.
    let text = std::fs::read_to_string(folder.path("s.pbrt")).expect("the scene");
    for (mistake, said) in [
        ("Translate 0 zero 3", "three numbers"),
        ("Translat 0 0 3", "expected a directive"),
        ("Shape \"sphere\" \"float radius\" [ 1 \"2\" ]", "mixed"),
        ("WorldEnd WorldEnd Translate", "three numbers"),
    ] {
        folder.write("m.pbrt", text.replace("Translate 0 0 3", mistake));
        let run = folder.run(["render", "m.pbrt", "--keep-going", "-o", "a.exr"]);
        assert_eq!(run.code, 2, "{mistake}\n{}", run.stderr);
        assert!(run.stderr.contains(said), "{mistake}\n{}", run.stderr);
        assert!(!folder.path("a.exr").exists());
    }
    // Nothing is missing: nothing is said.
    folder.write(
        "w.pbrt",
        "Film \"image\" \"integer xresolution\" 4 \"integer yresolution\" 4\n\
         WorldBegin\nLightSource \"infinite\"\nWorldEnd\n",
    );
    let run = folder.run(["render", "w.pbrt", "--keep-going", "-o", "a.exr", "--quiet"]);
    assert_eq!((run.code, run.stderr.as_str()), (0, ""));
}

#[test]
fn a_missing_lens_becomes_a_pinhole() {
    let folder = Folder::new();
    folder.write(
        "s.pbrt",
        "Film \"image\" \"integer xresolution\" 8 \"integer yresolution\" 8\n\
         Camera \"realistic\" \"string lensfile\" \"nowhere.dat\" \"float aperturediameter\" 5\n\
         WorldBegin\nLightSource \"infinite\"\nWorldEnd\n",
    );
    let refused = folder.run(["render", "s.pbrt", "-o", "a.exr"]);
    assert_eq!(refused.code, 2, "{}", refused.stderr);
    let kept = folder.run(["render", "s.pbrt", "-o", "a.exr", "--keep-going"]);
    assert_eq!(kept.code, 1, "{}", kept.stderr);
    assert!(
        kept.stderr.contains("perspective camera, pinhole"),
        "{}",
        kept.stderr
    );
    assert!(kept.stderr.contains("s.pbrt:2:38"), "{}", kept.stderr);
}

/// Frames that name one file for their images get one each.
#[test]
fn frames_do_not_overwrite_each_other() {
    let folder = Folder::new();
    let frame = "Film \"image\" \"integer xresolution\" 4 \"integer yresolution\" 4 \"string filename\" \"a.exr\"\n\
         WorldBegin\nLightSource \"infinite\"\nWorldEnd\n";
    folder.write("s.pbrt", frame.repeat(3));
    let run = folder.run(["render", "s.pbrt"]);
    assert_eq!(run.code, 0, "{}", run.stderr);
    for name in ["a.exr", "a.2.exr", "a.3.exr"] {
        assert!(folder.path(name).exists(), "{name}");
    }
    for said in [
        "`a.2.exr` is used for frame 2",
        "s.pbrt:5:",
        "`a.3.exr` is used for frame 3",
        "s.pbrt:9:",
    ] {
        assert!(run.stderr.contains(said), "{said}\n{}", run.stderr);
    }
    assert_eq!(folder.run(["render", "s.pbrt", "--strict"]).code, 2);
}
