//! Sums of weighted texels.

use crate::assets::ptex::{Face, PtexFile, Resolution, Sample, Texels};
use crate::math::Rgb;

/// Numbers of texels, times weights, not yet divided by what counts as 1 in the file.
pub(super) trait Weighted {
    /// The sum over texels of any kind of number, of which `texels` holds those of the face.
    fn of<S: Sample>(&self, texels: &[S], channels: usize) -> Rgb;
}

/// The weighted sum over the texels of `face` at a resolution.
#[inline]
pub(super) fn weighted(
    file: &PtexFile,
    face: &Face,
    at: Resolution,
    weights: &impl Weighted,
) -> Rgb {
    let from = file.position(face, at)..;
    let channels = file.channels;
    match file.texels() {
        Texels::U8(t) => weights.of(t.get(from).unwrap_or_default(), channels),
        Texels::U16(t) => weights.of(t.get(from).unwrap_or_default(), channels),
        Texels::F16(t) => weights.of(t.get(from).unwrap_or_default(), channels),
        Texels::F32(t) => weights.of(t.get(from).unwrap_or_default(), channels),
    }
}

/// A texel with its numbers as they are stored; of one channel, the first.
#[inline(always)]
pub(super) fn texel<S: Sample>(texels: &[S], index: usize, channels: usize) -> Rgb {
    match channels {
        1 => Rgb::X * texels.get(index).map_or(0.0, |s| s.value()),
        _ => match texels.get(3 * index..3 * index + 3) {
            Some(&[r, g, b]) => Rgb::new(r.value(), g.value(), b.value()),
            _ => Rgb::ZERO,
        },
    }
}

/// A single texel.
struct First;

impl Weighted for First {
    fn of<S: Sample>(&self, texels: &[S], channels: usize) -> Rgb {
        texel(texels, 0, channels)
    }
}

/// The single number that a face has, or its mean, as stored.
pub(super) fn mean(file: &PtexFile, face: &Face) -> Rgb {
    weighted(file, face, Resolution::ONE, &First)
}

/// The same as a value.
pub(super) fn constant(file: &PtexFile, face: &Face) -> Rgb {
    mean(file, face) / file.texels().one()
}

/// The mean by weights of a sum over texels, as a value; where no texel weighs anything, that of the face.
pub(super) fn weighted_mean(file: &PtexFile, face: &Face, sum: Rgb, weight: f32) -> Rgb {
    let value = sum / (weight * file.texels().one());
    match value.is_finite() {
        true => value,
        false => constant(file, face),
    }
}
