//! Those who look on while a render runs: a viewer, files of the unfinished picture, counts. The image's bits do not depend on
//! them, nor when it is done.

use super::cli::{Folder, LENS, load};
use super::layers::Channels;
use crate::common::program::{Run, fstop};
use fstop::math::UVec2;
use serde_json::Value;
use std::collections::BTreeMap;
use std::io::{Read, Write};
use std::net::{TcpListener, TcpStream};
use std::path::Path;
use std::process::{Command, Stdio};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

/// A box with a mirror ball.
const BOX: &str = "tests/scenes/reference/int_cornell_path.pbrt";
/// Paths from the lights, too.
const BOTH_ENDS: &str = "tests/scenes/reference/int_bdpt.pbrt";
const DIRECT: &str = "tests/scenes/reference/int_direct_all.pbrt";
const WHITTED: &str = "tests/scenes/reference/int_whitted.pbrt";
/// 16 rays from each point.
const OCCLUSION: &str = "tests/scenes/reference/int_ao.pbrt";

fn render(scene: &str, output: &Path, more: &[&str]) -> Run {
    let output = output.display().to_string();
    let run = fstop([&["render", scene, "-o", &output], more].concat());
    assert_eq!(run.code, 0, "{}", run.stderr);
    run
}

fn bytes(path: &Path) -> Vec<u8> {
    std::fs::read(path).expect("a file")
}

/// What a viewer has of an image.
#[derive(Default)]
struct Shown {
    size: [u32; 2],
    channels: Vec<String>,
    /// By channel and pixel.
    values: BTreeMap<(usize, [u32; 2]), f32>,
    updates: usize,
}

/// The rest of a packet.
struct Packet<'a>(&'a [u8]);

impl Packet<'_> {
    fn take<const N: usize>(&mut self) -> [u8; N] {
        let (first, rest) = self.0.split_first_chunk().expect("enough bytes");
        self.0 = rest;
        *first
    }

    fn number(&mut self) -> u32 {
        u32::from_le_bytes(self.take())
    }

    fn string(&mut self) -> String {
        let end = self.0.iter().position(|byte| *byte == 0).expect("an end");
        let text = String::from_utf8(self.0[..end].to_vec()).expect("text");
        self.0 = &self.0[end + 1..];
        text
    }

    fn strings(&mut self) -> Vec<String> {
        let count = self.number();
        (0..count).map(|_| self.string()).collect()
    }
}

/// Reads packets until there are no more, as tev does.
fn look(mut stream: TcpStream) -> BTreeMap<String, Shown> {
    let mut images = BTreeMap::<String, Shown>::new();
    let mut length = [0; 4];
    while stream.read_exact(&mut length).is_ok() {
        let mut body = vec![0; u32::from_le_bytes(length) as usize - 4];
        stream.read_exact(&mut body).expect("a whole packet");
        let mut packet = Packet(&body);
        let [kind, _grab_focus] = packet.take();
        let name = packet.string();
        match kind {
            4 => {
                let size = [packet.number(), packet.number()];
                let channels = packet.strings();
                let new = Shown {
                    size,
                    channels,
                    ..Shown::default()
                };
                images.insert(name, new);
            }
            6 => update(images.get_mut(&name).expect("it was created"), &mut packet),
            _ => panic!("packet {kind}"),
        }
        assert!(packet.0.is_empty() || kind == 6);
    }
    images
}

fn update(image: &mut Shown, packet: &mut Packet) {
    let channels = packet.strings();
    let [x, y, width, height] = [(); 4].map(|()| packet.number());
    let longs = |packet: &mut Packet| -> Vec<usize> {
        let one = |_| u64::from_le_bytes(packet.take()) as usize;
        channels.iter().map(one).collect()
    };
    let (offsets, strides) = (longs(packet), longs(packet));
    let values: Vec<f32> = { packet.0.chunks(4) }
        .map(|four| f32::from_le_bytes(four.try_into().expect("whole numbers")))
        .collect();
    for (c, name) in channels.iter().enumerate() {
        let channel = { image.channels.iter() }.position(|n| n == name);
        let channel = channel.expect("a channel that was created");
        for i in 0..width * height {
            let at = [x + i % width, y + i / width];
            assert!(at[0] < image.size[0] && at[1] < image.size[1]);
            let value = values[offsets[c] + i as usize * strides[c]];
            image.values.insert((channel, at), value);
        }
    }
    image.updates += 1;
}

/// A viewer of one render.
fn viewer<T: Send + 'static>(
    behave: impl FnOnce(TcpStream) -> T + Send + 'static,
) -> (String, JoinHandle<T>) {
    let listener = TcpListener::bind("127.0.0.1:0").expect("a port");
    let address = listener.local_addr().expect("an address").to_string();
    let thread = std::thread::spawn(move || behave(listener.accept().expect("a call").0));
    (address, thread)
}

/// In one set, in halves, in passes, with light paths, by photons, cropped: what the viewer has at the end is the image.
#[test]
fn a_viewer_has_the_image_at_the_end() {
    let folder = Folder::new();
    let photons = "tests/scenes/reference/int_sppm.pbrt";
    let ways: [(&str, &[&str]); 5] = [
        (BOX, &["--spp", "130"]),
        (
            BOX,
            &["--spp", "8", "--variance", "--crop", "0.3,0.9,0.1,0.7"],
        ),
        (BOX, &["--error", "40%"]),
        (BOTH_ENDS, &["--spp", "4"]),
        (photons, &["--spp", "2"]),
    ];
    for (scene, options) in ways {
        let path = folder.path("a.exr");
        let (address, shown) = viewer(look);
        let seen = [options, &["--display-server", &address]].concat();
        render(scene, &path, &seen);
        let images = shown.join().expect("no wrong packet");
        let shown = &images[&path.display().to_string()];
        assert_eq!(shown.channels, ["R", "G", "B", "samples.Y"]);
        let image = load(&path).image;
        assert_eq!(shown.size, image.resolution.to_array());
        for pixel in image.bounds.pixels() {
            for channel in 0..3 {
                let value = shown.values[&(channel, pixel.to_array())];
                assert_eq!(value, image.pixel(pixel)[channel], "{scene} {pixel}");
            }
        }
        assert_eq!(shown.values.len(), 4 * image.bounds.area(), "{options:?}");
    }
}

/// Its layers, too, under the names that they have in the file, but for Cryptomattes.
#[test]
fn a_viewer_has_the_layers() {
    let folder = Folder::new();
    let path = folder.path("a.exr");
    let (address, shown) = viewer(look);
    let list = "albedo,depth,uv,material,coc,alpha";
    let options = ["--spp", "8", "--aov", list, "--display-server", &address];
    render(BOX, &path, &options);
    let images = shown.join().expect("no wrong packet");
    let shown = &images[&path.display().to_string()];
    let layers = "albedo.R albedo.G albedo.B depth.Z uv.U uv.V coc.Y A";
    let names = format!("R G B samples.Y {layers}");
    assert_eq!(shown.channels.join(" "), names);
    let file = Channels::of(&path);
    for (channel, name) in shown.channels.iter().enumerate() {
        if name == "samples.Y" {
            continue;
        }
        for (index, value) in file.get(name).iter().enumerate() {
            let pixel = [index % file.width, index / file.width].map(|i| i as u32);
            assert_eq!(shown.values[&(channel, pixel)], *value, "{name} {pixel:?}");
        }
    }
}

/// Seen while it grows: before the end there were other values.
#[test]
fn a_viewer_sees_the_picture_grow() {
    let folder = Folder::new();
    let (address, shown) = viewer(look);
    let options = ["--spp", "200", "--display-server", &address];
    render(BOX, &folder.path("a.exr"), &options);
    let images = shown.join().expect("no wrong packet");
    let shown = images.values().next().expect("an image");
    // A whole picture of 64 × 64 pixels is one square, and the last one another.
    assert!(shown.updates >= 4, "{} updates", shown.updates);
}

/// A sky of so many pixels that no socket takes the picture unread (16 MB; buffers take 10 at most).
fn sky(folder: &Folder) -> String {
    let path = folder.path("sky.pbrt");
    let text = "Film \"image\" \"integer xresolution\" [1000] \"integer yresolution\" [1000]\n\
                Camera \"perspective\"\nSampler \"random\" \"integer pixelsamples\" [1]\nWorldBegin\n\
                LightSource \"infinite\" \"rgb L\" [1 2 3]\nWorldEnd\n";
    std::fs::write(&path, text).expect("a scene");
    path.display().to_string()
}

/// A viewer that stalls, resets the connection, lies, or is not there changes no bit, and nobody waits for it.
#[test]
fn a_bad_viewer_harms_nothing() {
    let folder = Folder::new();
    let (scene, path) = (sky(&folder), folder.path("a.exr"));
    let start = Instant::now();
    render(&scene, &path, &[]);
    let (undisturbed, alone) = (bytes(&path), start.elapsed());
    let stall = |stream: TcpStream| {
        std::thread::sleep(Duration::from_secs(60));
        drop(stream);
    };
    let reset = |mut stream: TcpStream| {
        // What is unread when it is closed makes it a reset.
        let _ = stream.read_exact(&mut [0; 10]);
    };
    let lie = |mut stream: TcpStream| {
        let mut buffer = [0xff; 4096];
        while stream.read(&mut buffer).is_ok_and(|n| n > 0) {
            let _ = stream.write_all(&[0xff; 4096]);
        }
    };
    let nobody = {
        let gone = TcpListener::bind("127.0.0.1:0").expect("a port");
        gone.local_addr().expect("an address").to_string()
    };
    let viewers = [
        ("stalls", viewer(stall).0),
        ("resets", viewer(reset).0),
        ("lies", viewer(lie).0),
        ("is not there", nobody),
        ("has no name", "no-such-host.invalid:14158".to_string()),
    ];
    for (what, address) in viewers {
        let start = Instant::now();
        let run = render(&scene, &path, &["--display-server", &address]);
        assert!(bytes(&path) == undisturbed, "{what}");
        // Two seconds are the most that a viewer has at the end; machines that do other things are ten times slower.
        let most = 10 * alone + Duration::from_secs(2 + 5);
        assert!(start.elapsed() < most, "{what}: {:?}", start.elapsed());
        if what == "is not there" {
            assert!(
                run.stderr.contains("--display-server 127.0.0.1:"),
                "{}",
                run.stderr
            );
        }
    }
}

#[test]
fn an_address_has_a_port() {
    for bad in [
        "localhost",
        "localhost:",
        ":14158",
        "localhost:x",
        "localhost:70000",
    ] {
        let run = fstop(["render", BOX, "--display-server", bad]);
        assert_eq!(run.code, 2, "{bad}");
        assert!(run.stderr.contains("expected HOST:PORT"), "{}", run.stderr);
    }
    // Shards make no picture.
    let run = fstop(["render", BOX, "--shard", "1/2", "--write-partial", "1s"]);
    assert_eq!(run.code, 2, "{}", run.stderr);
}

/// Each file of the unfinished picture is whole, and gone when the image is there.
#[test]
fn unfinished_pictures_are_written_whole() {
    let folder = Folder::new();
    let [path, alone] = ["a.exr", "b.exr"].map(|name| folder.path(name));
    let partial = folder.path("a.partial.exr");
    let copies = Folder::new();
    let copy = copies.path("copy.exr");
    render(BOX, &alone, &["--spp", "150"]);
    let mut child = Command::new(env!("CARGO_BIN_EXE_fstop"))
        .args([
            "render",
            BOX,
            "--spp",
            "150",
            "--quiet",
            "--write-partial",
            "0.02s",
            "-o",
        ])
        .arg(&path)
        .stderr(Stdio::null())
        .spawn()
        .expect("the program");
    let mut seen = 0;
    while child.try_wait().expect("a child").is_none() {
        if !partial.exists() {
            continue;
        }
        // One file, whatever takes its place while it is read.
        match std::fs::copy(&partial, &copy) {
            Ok(_) => {
                let found = fstop::film::read(&copy).expect("a whole image");
                assert_eq!(found.image.resolution, UVec2::new(64, 64));
                assert!(found.spp.is_some_and(|spp| (1..=150).contains(&spp)));
                seen += 1;
            }
            // It is gone only when the image is there.
            Err(error) => assert!(path.exists() && !partial.exists(), "{error}"),
        }
    }
    assert!(child.wait().expect("a child").success());
    assert!(seen >= 2, "{seen}");
    assert!(bytes(&path) == bytes(&alone));
    assert_eq!(folder.names(), ["a.exr", "b.exr"]);
}

fn statistics(folder: &Folder, scene: &str, more: &[&str]) -> Value {
    let stats = folder.path("stats.json");
    let name = stats.display().to_string();
    let path = folder.path("a.exr");
    render(scene, &path, more);
    let alone = bytes(&path);
    render(scene, &path, &[more, &["--stats", &name]].concat());
    assert!(bytes(&path) == alone, "{more:?}");
    serde_json::from_slice(&bytes(&stats)).expect("JSON")
}

fn sum(list: &Value, key: &str) -> u64 {
    let list = list.as_array().expect("a list");
    list.iter()
        .map(|one| one[key].as_u64().expect("a count"))
        .sum()
}

/// Whatever is rendered how: every sample has one path, which ends once, and every ray leads to one vertex.
#[test]
fn counts_add_up() {
    let folder = Folder::new();
    let ways: [(&str, &[&str]); 7] = [
        (DIRECT, &["--spp", "2"]),
        (WHITTED, &["--spp", "2"]),
        (OCCLUSION, &["--spp", "2"]),
        (BOX, &["--spp", "4", "--threads", "1"]),
        (BOX, &["--spp", "4", "--threads", "3", "--variance"]),
        (LENS, &["--spp", "100"]),
        (BOTH_ENDS, &["--spp", "2"]),
    ];
    for (scene, options) in ways {
        let stats = statistics(&folder, scene, options);
        let paths = &stats["paths"];
        let count = |value: &Value| value.as_u64().unwrap_or_else(|| panic!("{value}"));
        let lengths = paths["lengths"].as_array().expect("a histogram");
        let ended: u64 = lengths.iter().map(count).sum();
        assert_eq!(ended, count(&paths["count"]));
        let blocked = count(&paths["blocked_by_the_lens"]);
        assert_eq!(
            (ended + blocked) as f64,
            stats["samples"]["all"].as_f64().expect("samples")
        );
        assert_eq!(blocked > 0, scene == LENS, "{blocked}");
        let vertices = &paths["vertices"];
        let met = ["surface", "medium", "escaped"].map(|key| count(&vertices[key]));
        assert_eq!(met.iter().sum::<u64>(), count(&paths["rays"]["path"]));
        let on_materials = sum(&paths["materials"], "vertices");
        assert_eq!(on_materials + count(&vertices["without_material"]), met[0]);
        let shadow = count(&paths["rays"]["shadow"]);
        assert_eq!(sum(&paths["lights"], "shadow_rays"), shadow);
        let unblocked = sum(&paths["lights"], "unblocked");
        let direct = ![LENS, OCCLUSION].contains(&scene);
        assert!(unblocked <= shadow && (unblocked > 0) == direct, "{paths}");
        let open = if scene == OCCLUSION { 16 * met[0] } else { 0 };
        assert_eq!(count(&paths["rays"]["occlusion"]), open);
        assert!(stats["time_s"]["rendering"].as_f64().expect("seconds") > 0.0);
        let is_bdpt = stats["integrator"] == "bdpt";
        assert_eq!(is_bdpt, scene == BOTH_ENDS, "{}", stats["integrator"]);
    }
}

/// A path's last ray can only meet a light: where none has an area, it is not traced.
#[test]
fn no_ray_is_traced_that_could_bring_nothing() {
    let folder = Folder::new();
    let rays = |integrator: &str, depth: u32, light: &str| {
        let text = format!(
            "Integrator \"{integrator}\" \"integer maxdepth\" {depth} Film \"image\" \"integer xresolution\" 8 \"integer yresolution\" 8\n\
             WorldBegin LightSource \"point\"\nShape \"sphere\" \"float radius\" 9\n{light}\nWorldEnd\n"
        );
        std::fs::write(folder.path("s.pbrt"), text).expect("a scene");
        let scene = folder.path("s.pbrt").display().to_string();
        let paths = &statistics(&folder, &scene, &["--spp", "4"])["paths"];
        paths["rays"]["path"].as_u64().expect("a count")
    };
    let samples = 8 * 8 * 4;
    let emitter =
        "AreaLightSource \"diffuse\" Translate 0 0 -8 Shape \"sphere\" \"float radius\" .1";
    for integrator in ["path", "volpath", "bdpt"] {
        assert_eq!(rays(integrator, 1, ""), samples, "{integrator}");
        assert_eq!(rays(integrator, 2, ""), 2 * samples, "{integrator}");
        assert_eq!(rays(integrator, 1, emitter), 2 * samples, "{integrator}");
    }
}

/// The same paths, counted by other threads and tiles.
#[test]
fn counts_do_not_depend_on_threads() {
    let folder = Folder::new();
    let of = |more: &[&str]| {
        let options = [&["--spp", "4"], more].concat();
        statistics(&folder, BOX, &options)["paths"].clone()
    };
    assert_eq!(
        of(&["--threads", "1"]),
        of(&["--threads", "3", "--tile-size", "7"])
    );
}

#[test]
fn statistics_go_where_no_image_goes() {
    let folder = Folder::new();
    let image = folder.path("a.exr").display().to_string();
    let run = fstop(["render", BOX, "-o", &image, "--stats", &image]);
    assert_eq!(run.code, 2, "{}", run.stderr);
    let nowhere = folder.path("no/stats.json").display().to_string();
    let run = fstop(["render", BOX, "-o", &image, "--stats", &nowhere]);
    assert_eq!(run.code, 74, "{}", run.stderr);
    assert!(folder.names().is_empty());
}
