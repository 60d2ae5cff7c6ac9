//! OpenEXR files: the first flat layer's data window, whatever its channels are named.

use super::image_data::{Encoding, ImageData, SizeLimit};
use crate::math::Rgb;
use exr::image::{AnyChannels, FlatSamples};
use exr::meta::MetaData;
use exr::prelude::{ReadChannels, ReadLayers};
use std::io::Cursor;

/// Decodes a whole file.
pub(super) fn read(bytes: &[u8], limit: SizeLimit) -> Result<ImageData, String> {
    check_sizes(bytes, limit)?;
    let image = exr::prelude::read()
        .no_deep_data()
        .largest_resolution_level()
        .all_channels()
        .first_valid_layer()
        .all_attributes()
        .non_parallel()
        .from_buffered(Cursor::new(bytes))
        .map_err(|e| e.to_string())?;
    let layer = image.layer_data;
    let (width, height) = (layer.size.width(), layer.size.height());
    if layer
        .channel_data
        .list
        .iter()
        .any(|c| c.sampling.width() != 1 || c.sampling.height() != 1)
    {
        return Err(
            "it holds subsampled (luminance and chroma) channels, which are not supported".into(),
        );
    }
    let [r, g, b] = choose_channels(&layer.channel_data)?;
    let value =
        |channel: Option<&FlatSamples>, i| channel.map_or(0.0, |samples| sample(samples, i));
    let texels = (0..width * height)
        .map(|i| Rgb::new(value(r, i), value(g, i), value(b, i)))
        .collect();
    ImageData::from_texels(width, height, Encoding::Linear, texels)
        .ok_or_else(|| "it has no pixels".into())
}

/// Width and height of the first layer, and bytes of a texel with all its channels.
pub(super) fn extent(bytes: &[u8]) -> Result<([usize; 2], u64), String> {
    let meta =
        MetaData::read_from_buffered(Cursor::new(bytes), false).map_err(|e| e.to_string())?;
    let header = meta.headers.first().ok_or("it has no layers")?;
    let size = [header.layer_size.width(), header.layer_size.height()];
    Ok((size, header.channels.bytes_per_pixel as u64))
}

/// Checks sizes first, because the decoder allocates whatever the header asks for.
pub(crate) fn check_sizes(bytes: &[u8], limit: SizeLimit) -> Result<(), String> {
    let meta =
        MetaData::read_from_buffered(Cursor::new(bytes), false).map_err(|e| e.to_string())?;
    for header in &meta.headers {
        let size = header.layer_size;
        limit.check_channels(
            size.width(),
            size.height(),
            header.channels.list.len().max(3),
        )?;
    }
    Ok(())
}

/// Layers that hold the image beside those that say something of it, as other programs name them: `ViewLayer.Combined.R`, `beauty.R`.
const IMAGES: [&str; 6] = ["combined", "beauty", "rgba", "rgb", "color", "image"];

/// Returns `true` if the layer of this prefix, which ends with a dot, is called as [`IMAGES`] are.
fn is_image(prefix: &str) -> bool {
    let layer = prefix.trim_end_matches('.').rsplit('.').next();
    layer.is_some_and(|layer| IMAGES.iter().any(|image| image.eq_ignore_ascii_case(layer)))
}

/// What stands before the last part of channels' names, those of the image first.
fn prefixes(names: &[String]) -> Vec<&str> {
    let named = names
        .iter()
        .filter_map(|name| name.rfind('.').map(|dot| &name[..=dot]));
    let mut prefixes: Vec<&str> = std::iter::once("").chain(named).collect();
    // Stable: plain names stay first, and others in their order.
    prefixes.sort_by_key(|prefix| !(prefix.is_empty() || is_image(prefix)));
    prefixes
}

/// The channels that hold red, green and blue (a missing one is 0): those called R, G and B; else
/// those of a layer that is called as [`IMAGES`] are, or the first layer's (`left.R` …); else Y, or the only channel, for all three.
fn choose_channels(
    channels: &AnyChannels<FlatSamples>,
) -> Result<[Option<&FlatSamples>; 3], String> {
    let find = |name: &str| {
        channels
            .list
            .iter()
            .find(|c| c.name.eq_case_insensitive(name))
            .map(|c| &c.sample_data)
    };
    let names: Vec<String> = channels.list.iter().map(|c| c.name.to_string()).collect();
    for prefix in prefixes(&names) {
        let rgb = ["R", "G", "B"].map(|c| find(&format!("{prefix}{c}")));
        if rgb.iter().any(Option::is_some) {
            return Ok(rgb);
        }
        if let Some(y) = find(&format!("{prefix}Y")) {
            return Ok([Some(y); 3]);
        }
    }
    match channels.list.as_slice() {
        [only] => Ok([Some(&only.sample_data); 3]),
        _ => Err(format!(
            "none of its channels ({}) is R, G, B or Y",
            names.join(", ")
        )),
    }
}

/// Sample `i` of a channel; 0 past its end.
fn sample(samples: &FlatSamples, i: usize) -> f32 {
    match samples {
        FlatSamples::F16(v) => v.get(i).map_or(0.0, |h| h.to_f32()),
        FlatSamples::F32(v) => v.get(i).copied().unwrap_or(0.0),
        FlatSamples::U32(v) => v.get(i).map_or(0.0, |&n| n as f32),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// As Blender and others name them.
    #[test]
    fn the_image_comes_before_other_layers() {
        let of = |names: &[&str]| {
            let names: Vec<String> = names.iter().map(|name| name.to_string()).collect();
            prefixes(&names).join(" ")
        };
        let blender = ["ViewLayer.Albedo.R", "ViewLayer.Combined.R"];
        assert_eq!(of(&blender), " ViewLayer.Combined. ViewLayer.Albedo.");
        assert_eq!(of(&["R", "albedo.R", "Beauty.R"]), " Beauty. albedo.");
        assert_eq!(of(&["left.R", "right.R"]), " left. right.");
    }
}
