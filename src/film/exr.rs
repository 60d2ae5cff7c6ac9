//! OpenEXR: scene-linear images with their variance and metadata on how they were rendered.
//!
//! Channels `R` `G` `B`, and `var.R` `var.G` `var.B` if the image has variances: a layer named `var` to other programs. Where
//! these are pooled, those of independent samples are in the layer `independent`. Layers that were asked for have channels
//! of the names in [`Layer::channels`](super::Layer::channels).
//! All are 32-bit floats if [`Encoding::half`] does not say otherwise: half floats would round a variance below 6e-8 to zero and a mean by more than a
//! well-converged render's noise. Scan lines in ZIP blocks of 16, data window = crop window, display window = full
//! image, Rec. 709 primaries.

use super::encoding::half;
use super::layers::light_channels;
use super::zip_block;
use super::{Encoding, FilmMetadata, Image, LayerSet, Photograph};
use crate::math::{DMat4, Rgb, UVec2};
use ::exr::block::BlockIndex;
use ::exr::block::chunk::{Chunk, CompressedBlock, CompressedScanLineBlock};
use ::exr::block::writer::{ChunkWriter, ChunksWriter, write_chunks_with};
use ::exr::meta::attribute::{AttributeValue, Chromaticities};
use ::exr::meta::attribute::{ChannelDescription, SampleType};
use ::exr::meta::header::Header;
use ::exr::meta::{BlockDescription, Headers, MetaData};
use ::exr::prelude::{
    Compression, Error, ImageAttributes, IntegerBounds, LayerAttributes, LineOrder, Text, Vec2,
};
use rayon::prelude::*;
use std::borrow::Cow;
use std::io::{Cursor, Seek, Write};

/// Names of the channels of [`Image::pixels`].
pub(super) const CHANNELS: [&str; 3] = ["R", "G", "B"];

/// Of [`Image::variance`].
pub(super) const VARIANCES: [&str; 3] = ["var.R", "var.G", "var.B"];

/// Of [`Image::independent`].
pub(super) const INDEPENDENT: [&str; 3] = ["independent.R", "independent.G", "independent.B"];

/// Writes a file: lines straight from the image, blocks of them compressed on the rayon pool that this is called from, if any.
///
/// # Errors
/// Fails if the encoder does, for example for an image without pixels, and if `file` does.
pub(super) fn encode(
    image: &Image,
    metadata: &FilmMetadata,
    encoding: &Encoding,
    file: &mut (impl Write + Seek),
) -> Result<(), Error> {
    let channels = channels(image, metadata, encoding);
    let size = image.bounds.size();
    let header = Header::new(
        Text::default(),
        (size.x as usize, size.y as usize),
        { channels.iter() }
            .map(|channel| ChannelDescription::named(text(&channel.name), channel.kind()))
            .collect(),
    );
    let blocks = BlockDescription::ScanLines;
    let header = header
        .with_encoding(Compression::ZIP16, blocks, LineOrder::Increasing)
        .with_attributes(layer_attributes(image, metadata))
        .with_shared_attributes(image_attributes(image, metadata));
    let headers: Headers = [header].into_iter().collect();
    let beginning = beginning(headers.clone())?;
    write_chunks_with(&mut *file, headers, true, |meta, file| {
        compress(image, &channels, &meta, file)
    })?;
    file.rewind()?;
    Ok(file.write_all(&beginning)?)
}

/// A channel of the file.
struct Channel<'a> {
    name: Cow<'static, str>,
    values: Values<'a>,
    /// In half floats.
    halves: bool,
}

/// The values of a channel, of all pixels.
#[derive(Clone, Copy)]
enum Values<'a> {
    /// A component of colors.
    Component(&'a [Rgb], usize),
    /// By themselves; none where all are 0.
    Plane(&'a [f32]),
}

impl Channel<'_> {
    fn kind(&self) -> SampleType {
        if self.halves {
            SampleType::F16
        } else {
            SampleType::F32
        }
    }

    /// Writes pixels from number `first` on, in the file's order of bytes.
    fn write(&self, first: usize, width: usize, bytes: &mut [u8]) {
        let pixels = first..first + width;
        match self.values {
            Values::Component(all, component) => {
                let line = all.get(pixels).unwrap_or_default().iter();
                // A component that is known from here on.
                match component {
                    0 => self.write_each(line.map(|value| value.x), bytes),
                    1 => self.write_each(line.map(|value| value.y), bytes),
                    _ => self.write_each(line.map(|value| value.z), bytes),
                }
            }
            Values::Plane(all) => match all.get(pixels) {
                Some(line) => self.write_each(line.iter().copied(), bytes),
                None => bytes.fill(0),
            },
        }
    }

    #[inline(always)]
    fn write_each(&self, values: impl Iterator<Item = f32>, bytes: &mut [u8]) {
        if self.halves {
            for (bytes, value) in bytes.as_chunks_mut().0.iter_mut().zip(values) {
                *bytes = half(value).to_le_bytes();
            }
        } else {
            for (bytes, value) in bytes.as_chunks_mut().0.iter_mut().zip(values) {
                *bytes = value.to_le_bytes();
            }
        }
    }
}

/// The channels, in the file's order.
fn channels<'a>(
    image: &'a Image,
    metadata: &FilmMetadata,
    encoding: &Encoding,
) -> Vec<Channel<'a>> {
    let own = [
        (&CHANNELS, Some(&image.pixels), encoding.halves(None)),
        (&VARIANCES, image.variance.as_ref(), false),
        (&INDEPENDENT, image.independent.as_ref(), false),
    ];
    let own = { own.into_iter() }
        .filter_map(|(names, values, halves)| Some((&names[..], values?, halves)));
    let own = own.flat_map(|(names, values, halves)| {
        let channel = move |(component, name): (usize, &&'static str)| Channel {
            name: Cow::Borrowed(name),
            values: Values::Component(values, component),
            halves,
        };
        names.iter().enumerate().map(channel)
    });
    let plane = |halves: bool| {
        move |(name, plane): (&&'static str, &'a [f32])| Channel {
            name: Cow::Borrowed(name),
            values: Values::Plane(plane),
            halves,
        }
    };
    let means = image.layers.means().flat_map(|mean| {
        let halves = encoding.halves(Some(mean.layer));
        let planes = mean.layer.channels().iter().zip(mean.channels());
        planes.map(plane(halves))
    });
    let mattes = image.layers.mattes.iter().flat_map(|matte| {
        let planes = matte.channels.iter().map(Vec::as_slice);
        let planes = matte.layer.channels().iter().zip(planes);
        planes.map(plane(false))
    });
    let lights = metadata.light_layers.iter().zip(&image.layers.lights);
    let lights = lights.flat_map(|(layer, values)| {
        let channel = move |(component, name): (usize, String)| Channel {
            name: Cow::Owned(name),
            values: Values::Component(values, component),
            halves: encoding.halves(None),
        };
        light_channels(layer).into_iter().enumerate().map(channel)
    });
    let mut channels: Vec<_> = own.chain(means).chain(mattes).chain(lights).collect();
    channels.sort_by(|a, b| a.name.cmp(&b.name));
    channels
}

/// Pixels that threads encode at a time, each counted as often as a block of them is in memory: as it is, as it is compressed, as
/// that is found, and as it is written.
pub(crate) fn pixels_encoded(size: UVec2, threads: usize) -> u64 {
    const LINES: u64 = 16;
    let lines = u64::from(size.y).next_multiple_of(LINES);
    4 * u64::from(size.x) * lines.min(LINES * threads as u64)
}

/// What a thread uses for one block after the other.
#[derive(Default)]
struct Buffers {
    plain: Vec<u8>,
    zip: zip_block::Memory,
}

/// Writes all blocks, in order, as many compressed at a time as there are threads.
fn compress(
    image: &Image,
    channels: &[Channel],
    meta: &MetaData,
    file: &mut impl ChunksWriter,
) -> Result<(), Error> {
    let header = meta.headers.first().ok_or_else(broken)?;
    let first_line = header.own_attributes.layer_position.y();
    let chunk = |(buffers, (place, index)): (&mut Buffers, (usize, BlockIndex))| {
        fill_block(image, channels, index, &mut buffers.plain);
        let block = CompressedScanLineBlock {
            y_coordinate: first_line + index.pixel_position.y() as i32,
            compressed_pixels_le: zip_block::compress(&buffers.plain, &mut buffers.zip),
        };
        let chunk = Chunk {
            layer_index: index.layer,
            compressed_block: CompressedBlock::ScanLine(block),
        };
        (place, chunk)
    };
    // Outside, rayon would start as many threads as RAYON_NUM_THREADS says, even a hundred thousand.
    let threads = rayon::current_thread_index().map(|_| rayon::current_num_threads());
    let mut buffers = Vec::new();
    buffers.resize_with(threads.unwrap_or(1), Buffers::default);
    let mut blocks = meta.enumerate_ordered_header_block_indices();
    loop {
        let some: Vec<_> = blocks.by_ref().take(buffers.len()).collect();
        if some.is_empty() {
            return Ok(());
        }
        let chunks: Vec<_> = match threads {
            Some(_) => buffers.par_iter_mut().zip(some).map(chunk).collect(),
            None => buffers.iter_mut().zip(some).map(chunk).collect(),
        };
        for (place, chunk) in chunks {
            file.write_chunk(place, chunk)?;
        }
    }
}

/// The block's pixels: of each line one channel after the other (OpenEXR, "File Layout", section on scan line blocks).
fn fill_block(image: &Image, channels: &[Channel], index: BlockIndex, bytes: &mut Vec<u8>) {
    let width = image.bounds.size().x as usize;
    let line: usize = { channels.iter() }
        .map(|channel| channel.kind().bytes_per_sample() * width)
        .sum();
    let (first, lines) = (index.pixel_position.y(), index.pixel_size.y());
    bytes.resize(line * lines, 0);
    let mut rest = &mut bytes[..];
    for y in first..first + lines {
        for channel in channels {
            let count = channel.kind().bytes_per_sample() * width;
            let (own, others) = std::mem::take(&mut rest).split_at_mut(count);
            channel.write(y * width, width, own);
            rest = others;
        }
    }
}

fn image_attributes(image: &Image, metadata: &FilmMetadata) -> ImageAttributes {
    let size = Vec2(image.resolution.x as usize, image.resolution.y as usize);
    let mut attributes = ImageAttributes::new(IntegerBounds::new((0, 0), size));
    // Rec. 709 primaries and D65, as sRGB.
    attributes.chromaticities = Some(Chromaticities {
        red: Vec2(0.64, 0.33),
        green: Vec2(0.3, 0.6),
        blue: Vec2(0.15, 0.06),
        white: Vec2(0.3127, 0.329),
    });
    // Files with others are not valid.
    if let Some(aspect) = { metadata.pixel_aspect }.filter(|ratio| (1e-6..=1e6).contains(ratio)) {
        attributes.pixel_aspect = aspect;
    }
    attributes
}

fn layer_attributes(image: &Image, metadata: &FilmMetadata) -> LayerAttributes {
    let mut attributes = LayerAttributes {
        layer_position: Vec2(image.bounds.min.x as i32, image.bounds.min.y as i32),
        white_luminance: metadata.white_luminance,
        software_name: Some(text(&metadata.software)),
        world_to_camera: metadata.world_to_camera.as_ref().map(matrix),
        world_to_normalized_device: metadata.world_to_ndc.as_ref().map(matrix),
        ..LayerAttributes::default()
    };
    let spp = i32::try_from(metadata.spp).unwrap_or(i32::MAX);
    let mut add = |name: &str, value: AttributeValue| attributes.other.insert(text(name), value);
    // A mean of files that do not say it has none.
    if spp > 0 {
        add("spp", AttributeValue::I32(spp));
    }
    if let Some(error) = metadata.relative_error {
        add("relativeError", AttributeValue::F32(error as f32));
    }
    if let Some(confidence) = metadata.confidence {
        add("confidence", AttributeValue::F32(confidence as f32));
    }
    if let Some(bound) = metadata.error_bound {
        add("relativeErrorBound", AttributeValue::F32(bound as f32));
    }
    if let Some(freedom) = metadata.freedom {
        add("degreesOfFreedom", AttributeValue::F32(freedom as f32));
    }
    if let Some(side) = metadata.pool.and_then(|side| i32::try_from(side).ok()) {
        add("variancePool", AttributeValue::I32(side));
    }
    if let Some(light_paths) = metadata.light_paths {
        add("lightPaths", AttributeValue::F32(light_paths.per_sample));
        add("joinedPaths", AttributeValue::F32(light_paths.joined));
    }
    if let Some(runs) = metadata.runs.and_then(|runs| i32::try_from(runs).ok()) {
        add("runs", AttributeValue::I32(runs));
    }
    let wanted =
        { image.layers.mattes.iter() }.fold(LayerSet::NONE, |set, matte| set.with(matte.layer));
    for manifest in &metadata.manifests {
        for (name, value) in manifest.attributes(wanted) {
            add(&name, AttributeValue::Text(text(&value)));
        }
    }
    if let Some(by) = &metadata.denoised {
        add("denoised", AttributeValue::Text(text(by)));
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

/// OpenEXR's standard attributes of cameras and lenses (<https://openexr.com/en/latest/StandardAttributes.html>), and four of our own:
/// `depthOfField` and `hyperfocalDistance`, in meters as its `focus` is, `workingFNumber`, and `fieldOfView` in degrees.
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
        ("workingFNumber", p.working_number),
        ("nominalFocalLength", p.nominal_focal_length),
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
    if let Some(angles) = p.field_of_view {
        add("fieldOfView", pair(angles));
    }
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

/// The bytes of a file up to the end of its header's attributes, sorted alphabetically.
///
/// The encoder keeps custom attributes in a hash map and writes them in its order, which differs from run to run; equal
/// renders must be equal files. The length is the same, so the offsets after the header are, too.
fn beginning(headers: Headers) -> Result<Vec<u8>, Error> {
    // Four bytes of magic number and four of version come first.
    const START: usize = 8;
    let mut bytes = Vec::new();
    let nothing_more = |_, _: &mut ChunkWriter<_>| Err(Error::Aborted);
    match write_chunks_with(Cursor::new(&mut bytes), headers, true, nothing_more) {
        Err(Error::Aborted) => {}
        done => done?,
    }
    let mut attributes = Vec::new();
    let mut at = START;
    while *bytes.get(at).ok_or_else(broken)? != 0 {
        let end = attribute_end(&bytes, at).ok_or_else(broken)?;
        attributes.push(bytes.get(at..end).ok_or_else(broken)?);
        at = end;
    }
    // Each starts with its name and a zero byte, so whole attributes compare like their names.
    attributes.sort();
    let start = bytes.get(..START).ok_or_else(broken)?;
    Ok([start, &attributes.concat()].concat())
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
