//! Films, tiles and files in combination.

use super::*;
use crate::math::DMat4;
use crate::output::OutputError;
use glam::DVec3;
use std::path::Path;

/// A film with some hundred different sample values per pixel, rendered in tiles of `side` pixels that are merged in
/// the order given by `order`.
fn expose(side: u32, order: impl Fn(&mut Vec<PixelBounds>)) -> Film {
    let spec = FilmSpec {
        resolution: UVec2::new(37, 21),
        scale: 1.5,
        ..FilmSpec::default()
    };
    let mut film = Film::new(&spec);
    let mut tiles: Vec<PixelBounds> = film.bounds().tiles(side).collect();
    order(&mut tiles);
    for bounds in tiles {
        let mut tile = spec.tile(bounds);
        for pixel in bounds.pixels() {
            for sample in 0..100 {
                let phase = (pixel.x * 7 + pixel.y * 13) as f32 + sample as f32 * 0.618;
                let value = Rgb::new(phase.sin().abs(), phase.cos() - 0.2, 1e-3 * phase);
                tile.add_sample(pixel, value.max(Rgb::ZERO), 0.3);
            }
        }
        film.merge(tile);
    }
    film
}

fn metadata() -> FilmMetadata {
    FilmMetadata {
        white_luminance: None,
        pixel_aspect: Some(0.75),
        freedom: Some(14.0),
        pool: Some(4),
        world_to_camera: Some(DMat4::from_translation(DVec3::new(1.0, 2.0, 3.0))),
        world_to_ndc: Some(DMat4::from_scale(DVec3::new(0.5, 0.25, 2.0))),
        spp: 100,
        relative_error: Some(0.25),
        confidence: Some(0.95),
        error_bound: Some(0.5),
        runs: None,
        light_paths: Some(LightPathUse {
            per_sample: 0.125,
            joined: 0.03125,
        }),
        denoised: None,
        manifests: Vec::new(),
        light_layers: Vec::new(),
        seed: u64::MAX,
        scene: "caf\u{e9} \u{65e5}.pbrt".into(),
        lens: Some("dgauss.50mm.dat".into()),
        photograph: None,
        software: "fstop 0.0.0".into(),
    }
}

#[test]
fn tile_size_and_order_leave_no_trace() {
    let reference = expose(64, |_| ()).develop();
    let reversed = expose(8, |tiles| tiles.reverse()).develop();
    let shuffled = expose(5, |tiles| {
        tiles.sort_by_key(|t| (t.min.x * 31 + t.min.y * 17) % 23)
    })
    .develop();
    assert_eq!(reference, reversed);
    assert_eq!(reference, shuffled);
}

#[test]
fn negative_means_become_black_and_scale_applies() {
    let spec = FilmSpec {
        resolution: UVec2::ONE,
        scale: 3.0,
        ..FilmSpec::default()
    };
    let mut film = Film::new(&spec);
    let mut tile = spec.tile(film.bounds());
    tile.add_sample(UVec2::ZERO, Rgb::new(1.0, 2.0, 0.0), 1.0);
    tile.add_sample(UVec2::ZERO, Rgb::new(0.0, 4.0, 0.5), -1.0);
    film.merge(tile);
    let image = film.develop();
    // Means (½, −1, −¼); sample variances of {1,0}, {2,−4}, {0,−½} are ½, 18, ⅛, halved for the mean.
    assert_eq!(image.pixel(UVec2::ZERO), Rgb::new(1.5, 0.0, 0.0));
    assert_eq!(
        image.variance.unwrap()[0],
        Rgb::new(0.25, 9.0, 0.0625) * 9.0
    );
}

#[test]
fn exr_comes_back_bit_for_bit() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("out.exr");
    let mut spec = FilmSpec {
        resolution: UVec2::new(40, 30),
        ..FilmSpec::default()
    };
    spec.set_crop(&[0.25, 0.75, 0.5, 1.0]).unwrap();
    let mut film = Film::new(&spec);
    let mut tile = spec.tile(film.bounds());
    for pixel in film.bounds().pixels() {
        tile.add_sample(pixel, pixel.as_vec2().extend(0.1) * 1e5, 1.0);
        tile.add_sample(pixel, Rgb::new(1e-7, 0.3, 0.7), 1.0);
    }
    film.merge(tile);
    let image = film.develop();
    write(&path, &image, &metadata()).unwrap();
    let loaded = read(&path).unwrap();
    assert_eq!(loaded.image, image);
    assert_eq!((loaded.spp, loaded.runs), (Some(100), None));
    assert_eq!(loaded.light_paths, metadata().light_paths);

    let plain = Image {
        variance: None,
        independent: None,
        ..image
    };
    write(&path, &plain, &metadata()).unwrap();
    assert_eq!(read(&path).unwrap().image, plain);
}

#[test]
fn exr_header_is_what_other_programs_look_for() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("out.exr");
    write(&path, &expose(8, |_| ()).develop(), &metadata()).unwrap();
    let meta = ::exr::meta::MetaData::read_from_file(&path, true).unwrap();
    let header = &meta.headers[0];
    let names: Vec<String> = header
        .channels
        .list
        .iter()
        .map(|c| c.name.to_string())
        .collect();
    assert_eq!(names, ["B", "G", "R", "var.B", "var.G", "var.R"]);
    let own = &header.own_attributes;
    // Imath's row-vector layout: translation in the last row of four.
    assert_eq!(own.world_to_camera.unwrap()[12..], [1.0, 2.0, 3.0, 1.0]);
    assert_eq!(own.world_to_normalized_device.unwrap()[5], 0.25);
    assert_eq!(own.white_luminance, None);
    assert_eq!(
        own.software_name.as_ref().unwrap().to_string(),
        "fstop 0.0.0"
    );
    let text = |name: &str| match &own.other[&::exr::prelude::Text::from(name)] {
        ::exr::meta::attribute::AttributeValue::Text(t) => {
            String::from_utf8(t.as_slice().to_vec()).unwrap()
        }
        other => panic!("{name} is {other:?}"),
    };
    assert_eq!(text("seed"), u64::MAX.to_string());
    assert_eq!(text("scene"), metadata().scene);
    assert_eq!(text("lens"), "dgauss.50mm.dat");
}

/// OpenEXR's standard attributes, under its names and in its units; what there is none of is not written.
#[test]
fn exr_header_says_how_the_camera_was_set() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("out.exr");
    let photograph = Photograph {
        lens: "dgauss.50mm.dat".into(),
        f_number: Some(5.6),
        t_number: Some(5.75),
        working_number: Some(5.875),
        focal_length: Some(50.5),
        nominal_focal_length: Some(51.0),
        field_of_view: Some([38.5, 26.25]),
        pinhole_focal_length: Some(52.5),
        entrance_pupil: Some(48.0),
        focused_at_infinity: true,
        near: Some(12.5),
        exposure_time: Some(0.125),
        pixel_pitch: 6.0,
        sensor: [36.0, 24.0],
        sensor_offset: [-2000.0, 500.0],
        ..Photograph::default()
    };
    let noted = FilmMetadata {
        photograph: Some(photograph.clone()),
        white_luminance: Some(4000.0),
        ..metadata()
    };
    write(&path, &expose(8, |_| ()).develop(), &noted).unwrap();
    let meta = ::exr::meta::MetaData::read_from_file(&path, true).unwrap();
    let own = &meta.headers[0].own_attributes;
    assert_eq!(own.aperture, Some(5.6));
    assert_eq!(own.focus, Some(f32::INFINITY));
    assert_eq!(own.exposure, Some(0.125));
    assert_eq!(own.iso_speed, None);
    assert_eq!(own.white_luminance, Some(4000.0));
    use ::exr::meta::attribute::AttributeValue::{F32, FloatVec2};
    let other = |name: &str| own.other.get(&::exr::prelude::Text::from(name));
    for (name, value) in [
        ("tStop", 5.75),
        ("workingFNumber", 5.875),
        ("nominalFocalLength", 51.0),
        ("effectiveFocalLength", 50.5),
        ("pinholeFocalLength", 52.5),
        ("entrancePupilOffset", 48.0),
        ("sensorPhotositePitch", 6.0),
    ] {
        assert_eq!(other(name), Some(&F32(value)), "{name}");
    }
    let pair = |x, y| FloatVec2(::exr::prelude::Vec2(x, y));
    assert_eq!(other("sensorCenterOffset"), Some(&pair(-2000.0, 500.0)));
    assert_eq!(other("fieldOfView"), Some(&pair(38.5, 26.25)));
    assert_eq!(other("depthOfField"), Some(&pair(12.5, f32::INFINITY)));
    assert_eq!(other("hyperfocalDistance"), None);
    // Shards carry it as JSON, which knows no infinity.
    let json = serde_json::to_string(&photograph).unwrap();
    assert_eq!(
        serde_json::from_str::<Photograph>(&json).unwrap(),
        photograph
    );
}

#[test]
fn equal_images_are_equal_files() {
    let folder = tempfile::tempdir().unwrap();
    let image = expose(8, |_| ()).develop();
    for name in ["out.exr", "out.png", "out.pfm", "out.tga"] {
        let path = folder.path().join(name);
        // Five hash maps in five orders: six attributes would stay the same by chance once in 10^11.
        let files: Vec<Vec<u8>> = (0..5)
            .map(|_| {
                write(&path, &image, &metadata()).unwrap();
                std::fs::read(&path).unwrap()
            })
            .collect();
        assert!(files.iter().all(|f| *f == files[0]), "{name}");
    }
    // No temporary files remain.
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 4);
}

#[test]
fn png_holds_the_crop_only() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("crop.PNG");
    let mut image = Image::black(UVec2::new(8, 8));
    image.bounds = PixelBounds::new(UVec2::new(2, 3), UVec2::new(4, 6));
    image.pixels = (0..6)
        .map(|i| Rgb::new(i as f32 / 5.0, 0.18, 2.0))
        .collect();
    write(&path, &image, &metadata()).unwrap();
    let png = ::image::open(&path).unwrap().into_rgb8();
    assert_eq!(png.dimensions(), (2, 3));
    assert_eq!(png.get_pixel(0, 0).0, [0, 118, 255]);
    assert_eq!(png.get_pixel(1, 2).0, [255, 118, 255]);
}

#[test]
fn impossible_outputs_are_refused_beforehand() {
    let folder = tempfile::tempdir().unwrap();
    let in_folder = |name: &str| folder.path().join(name);
    for bad in [
        in_folder("picture"),
        in_folder("picture.jpg"),
        in_folder("missing/picture.exr"),
    ] {
        let message = check_output(&bad).unwrap_err().to_string();
        assert!(message.starts_with(&bad.display().to_string()), "{message}");
        assert!(write(&bad, &Image::black(UVec2::ONE), &metadata()).is_err());
    }
    std::fs::create_dir(in_folder("folder.exr")).unwrap();
    assert!(matches!(
        check_output(&in_folder("folder.exr")),
        Err(WriteError::Output(OutputError::IsFolder(_)))
    ));
    check_output(&in_folder("picture.exr")).unwrap();
    assert!(check_output(Path::new("")).is_err());
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);
}

#[cfg(unix)]
#[test]
fn permissions_are_those_of_any_new_file() {
    use std::os::unix::fs::PermissionsExt;
    let folder = tempfile::tempdir().unwrap();
    let mode = |name: &str| {
        std::fs::metadata(folder.path().join(name))
            .unwrap()
            .permissions()
            .mode()
    };
    write(
        &folder.path().join("picture.png"),
        &Image::black(UVec2::ONE),
        &metadata(),
    )
    .unwrap();
    std::fs::write(folder.path().join("other"), "").unwrap();
    assert_eq!(mode("picture.png"), mode("other"));
}

#[test]
fn what_is_no_image_is_an_error() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("x.exr");
    assert!(read(&path).is_err());
    std::fs::write(&path, b"not an exr").unwrap();
    assert!(matches!(read(&path), Err(ReadError::Exr { .. })));
    // One color is no gray, whether alone or not.
    for channels in [["R"].as_slice(), &["B"], &["G", "R"], &["A", "R"]] {
        use ::exr::prelude::{AnyChannel, AnyChannels, FlatSamples, Image, WritableImage};
        let channel = |name: &&str| AnyChannel::new(*name, FlatSamples::F32(vec![1.0; 2]));
        let channels = AnyChannels::sort(channels.iter().map(channel).collect());
        let file = Image::from_channels((2, 1), channels);
        file.write().to_file(&path).expect("a file");
        assert!(matches!(read(&path), Err(ReadError::Partial { .. })));
    }
}
