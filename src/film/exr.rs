//! OpenEXR: scene-linear images with their variance and metadata on how they were rendered.
//!
//! Channels `R` `G` `B`, and `var.R` `var.G` `var.B` if the image has variances: a layer named `var` to other programs.
//! All are 32-bit floats: half floats would round a variance below 6e-8 to zero and a mean by more than a
//! well-converged render's noise. Scan lines in ZIP blocks of 16, data window = crop window, display window = full
//! image, Rec. 709 primaries.

use super::{FilmMetadata, Image, Photograph};
use crate::math::{DMat4, Rgb};
use ::exr::meta::attribute::{AttributeValue, Chromaticities};
use ::exr::prelude::{
    AnyChannel, AnyChannels, Blocks, Compression, Encoding, Error, FlatSamples, ImageAttributes,
    IntegerBounds, Layer, LayerAttributes, LineOrder, Text, Vec2, WritableImage,
};
use std::io::Cursor;

/// Encodes the whole file in memory.
///
/// # Errors
/// Fails if the encoder does, for example for an image without pixels.
pub(super) fn encode(image: &Image, metadata: &FilmMetadata) -> Result<Vec<u8>, Error> {
    let size = image.bounds.size();
    let encoding = Encoding {
        compression: Compression::ZIP16,
        blocks: Blocks::ScanLines,
        line_order: LineOrder::Increasing,
    };
    let layer = Layer::new(
        (size.x as usize, size.y as usize),
        layer_attributes(image, metadata),
        encoding,
        AnyChannels::sort(channels(image).into_iter().collect()),
    );
    let mut file = ::exr::prelude::Image::from_layer(layer);
    file.attributes = image_attributes(image);
    let mut bytes = Vec::new();
    // In parallel it would start as many threads as RAYON_NUM_THREADS says, even a hundred thousand.
    file.write()
        .non_parallel()
        .to_buffered(Cursor::new(&mut bytes))?;
    sort_attributes(&mut bytes)?;
    Ok(bytes)
}

fn channels(image: &Image) -> Vec<AnyChannel<FlatSamples>> {
    let channel = |name: &str, pixels: &[Rgb], i: usize| {
        AnyChannel::new(
            name,
            FlatSamples::F32(pixels.iter().map(|p| p[i]).collect()),
        )
    };
    let mut channels: Vec<_> = ["R", "G", "B"]
        .iter()
        .zip(0..)
        .map(|(n, i)| channel(n, &image.pixels, i))
        .collect();
    if let Some(variance) = &image.variance {
        channels.extend(
            ["var.R", "var.G", "var.B"]
                .iter()
                .zip(0..)
                .map(|(n, i)| channel(n, variance, i)),
        );
    }
    channels
}

fn image_attributes(image: &Image) -> ImageAttributes {
    let size = Vec2(image.resolution.x as usize, image.resolution.y as usize);
    let mut attributes = ImageAttributes::new(IntegerBounds::new((0, 0), size));
    // Rec. 709 primaries and D65, as sRGB.
    attributes.chromaticities = Some(Chromaticities {
        red: Vec2(0.64, 0.33),
        green: Vec2(0.3, 0.6),
        blue: Vec2(0.15, 0.06),
        white: Vec2(0.3127, 0.329),
    });
    attributes
}

fn layer_attributes(image: &Image, metadata: &FilmMetadata) -> LayerAttributes {
    let mut attributes = LayerAttributes {
        layer_position: Vec2(image.bounds.min.x as i32, image.bounds.min.y as i32),
        software_name: Some(text(&metadata.software)),
        world_to_camera: Some(matrix(&metadata.world_to_camera)),
        world_to_normalized_device: metadata.world_to_ndc.as_ref().map(matrix),
        ..LayerAttributes::default()
    };
    let spp = i32::try_from(metadata.spp).unwrap_or(i32::MAX);
    let mut add = |name: &str, value: AttributeValue| attributes.other.insert(text(name), value);
    add("spp", AttributeValue::I32(spp));
    if let Some(error) = metadata.relative_error {
        add("relativeError", AttributeValue::F32(error as f32));
    }
    // EXR has no 64-bit integers.
    add(
        "seed",
        AttributeValue::Text(text(&metadata.seed.to_string())),
    );
    add("scene", AttributeValue::Text(text(&metadata.scene)));
    if let Some(lens) = &metadata.lens {
        add("lens", AttributeValue::Text(text(lens)));
    }
    if let Some(photograph) = &metadata.photograph {
        note(photograph, &mut attributes);
    }
    attributes
}

/// OpenEXR's standard attributes of cameras and lenses (<https://openexr.com/en/latest/StandardAttributes.html>), and two of our own,
/// `depthOfField` and `hyperfocalDistance`, in meters as its `focus` is.
fn note(photograph: &Photograph, attributes: &mut LayerAttributes) {
    let p = photograph;
    let infinite = p.focused_at_infinity.then_some(f64::INFINITY);
    let single = |value: Option<f64>| value.map(|v| v as f32);
    attributes.aperture = single(p.f_number);
    attributes.focus = single(p.focus.or(infinite));
    attributes.exposure = single(p.exposure_time);
    attributes.iso_speed = single(p.iso);
    let mut add = |name: &str, value: AttributeValue| attributes.other.insert(text(name), value);
    let numbers = [
        ("tStop", p.t_number),
        ("nominalFocalLength", p.focal_length),
        ("effectiveFocalLength", p.focal_length),
        ("pinholeFocalLength", p.pinhole_focal_length),
        ("entrancePupilOffset", p.entrance_pupil),
        ("sensorPhotositePitch", Some(p.pixel_pitch)),
        ("hyperfocalDistance", p.hyperfocal),
    ];
    for (name, value) in numbers {
        if let Some(value) = single(value) {
            add(name, AttributeValue::F32(value));
        }
    }
    let pair = |[x, y]: [f64; 2]| AttributeValue::FloatVec2(Vec2(x as f32, y as f32));
    add("sensorCenterOffset", pair(p.sensor_offset));
    add("sensorOverallDimensions", pair(p.sensor));
    if let Some(near) = p.near {
        add("depthOfField", pair([near, p.far.unwrap_or(f64::INFINITY)]));
    }
    add("lensModel", AttributeValue::Text(text(&p.lens)));
}

/// EXR strings are bytes; UTF-8 is today's convention.
fn text(s: &str) -> Text {
    Text::from_slice_unchecked(s.as_bytes())
}

/// Imath multiplies row vectors from the left and stores row by row: the same sixteen numbers in the same order as for
/// column vectors stored column by column.
fn matrix(m: &DMat4) -> [f32; 16] {
    m.to_cols_array().map(|v| v as f32)
}

/// Sorts the header's attributes alphabetically.
///
/// The encoder keeps custom attributes in a hash map and writes them in its order, which differs from run to run; equal
/// renders must be equal files. The length stays the same, so the offsets after the header remain valid.
fn sort_attributes(bytes: &mut [u8]) -> Result<(), Error> {
    // Four bytes of magic number and four of version come first.
    const START: usize = 8;
    let mut attributes = Vec::new();
    let mut at = START;
    while *bytes.get(at).ok_or_else(broken)? != 0 {
        let end = attribute_end(bytes, at).ok_or_else(broken)?;
        attributes.push(bytes.get(at..end).ok_or_else(broken)?.to_vec());
        at = end;
    }
    // Each starts with its name and a zero byte, so whole attributes compare like their names.
    attributes.sort();
    bytes
        .get_mut(START..at)
        .ok_or_else(broken)?
        .copy_from_slice(&attributes.concat());
    Ok(())
}

/// The end of the attribute that starts at `start`: name, 0, type, 0, length in four bytes, value.
fn attribute_end(bytes: &[u8], start: usize) -> Option<usize> {
    let after_zero =
        |from: usize| Some(from + bytes.get(from..)?.iter().position(|&b| b == 0)? + 1);
    let length = after_zero(after_zero(start)?)?;
    let value = length + 4;
    let length = u32::from_le_bytes(bytes.get(length..value)?.try_into().ok()?);
    Some(value + length as usize)
}

fn broken() -> Error {
    Error::Invalid("header written by the encoder".into())
}
