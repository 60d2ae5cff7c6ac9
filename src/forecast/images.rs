//! Images of textures and lights, by their headers.

use crate::assets::image_data::{Extent, ImageData};
use crate::assets::ptex::PtexFile;
use crate::budget::Budget;
use crate::files::FileError;
use crate::lights::LightSpec;
use crate::math::Rgb;
use crate::textures::Wanted;

const TEXEL: u64 = size_of::<Rgb>() as u64;

const FLOAT: u64 = size_of::<f32>() as u64;

/// Memory of images, in bytes.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Amount {
    /// As long as they are used.
    pub kept: u64,
    /// For a while, besides.
    pub passing: u64,
}

/// All textures' images, of which `threads` are read at a time.
pub(super) fn textures(wanted: &[Wanted], threads: usize) -> Result<Amount, FileError> {
    let mut kept = 0;
    let mut passing = Vec::new();
    for file in wanted {
        if file.is_ptex {
            // Whose size is known only when its faces are unpacked.
            let loaded = PtexFile::load(&file.path, &Budget::new(None));
            kept += loaded?.bytes() as u64;
            continue;
        }
        let image = ImageData::extent(&file.path)?;
        let level = |value: u64| pyramid(enlarged(&image)) * value;
        let maps = level(FLOAT) * file.floats as u64 + level(TEXEL) * file.spectra as u64;
        let value = if file.spectra > 0 { TEXEL } else { FLOAT };
        // The image is kept until the last of its maps is made.
        let last = level(value).max(enlarging(&image, value));
        let most = image.texels() * TEXEL + maps - level(value) + last;
        let most = most.max(decoding(&image));
        kept += maps;
        passing.push(most - maps);
    }
    passing.sort_unstable_by(|a, b| b.cmp(a));
    let passing = passing.iter().take(threads).sum();
    Ok(Amount { kept, passing })
}

/// Images of lights, which are read one after the other.
pub(super) fn light_maps(lights: &[LightSpec]) -> Result<Amount, FileError> {
    let mut all = Amount::default();
    for file in lights.iter().filter_map(|light| light.map.as_ref()) {
        let image = ImageData::extent(&file.path)?;
        let kept = enlarged(&image) * TEXEL;
        let most = image.texels() * TEXEL + kept.max(enlarging(&image, TEXEL));
        let most = most.max(decoding(&image));
        all.kept += kept;
        all.passing = all.passing.max(most - kept);
    }
    Ok(all)
}

/// What decoding takes: the file, its samples as they are stored and as floats, and the texels.
fn decoding(image: &Extent) -> u64 {
    let texels = image.texels() * TEXEL;
    let first = image.texels() * (image.stored + image.converted);
    // What is stored is let go before the texels are made, where it is converted on the way.
    let last = match image.converted {
        0 => image.texels() * image.stored + texels,
        converted => image.texels() * converted + texels,
    };
    image.file + first.max(last)
}

/// What there is while an image of values of so many bytes is enlarged: first its rows, then its columns.
fn enlarging(image: &Extent, value: u64) -> u64 {
    let wide = (image.width.next_power_of_two() * image.height) as u64;
    match enlarged(image) {
        texels if texels > image.texels() => (image.texels() + wide + texels) * value,
        texels => texels * value,
    }
}

/// Texels of an image whose sides are powers of two.
fn enlarged(image: &Extent) -> u64 {
    (image.width.next_power_of_two() * image.height.next_power_of_two()) as u64
}

/// Texels of all levels, each a quarter of the one before.
fn pyramid(texels: u64) -> u64 {
    texels + texels.div_ceil(3)
}
