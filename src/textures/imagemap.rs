//! `imagemap`.

use super::mipmap::{Filter, Mipmap, Wrap};
use super::{Compiler, Mapping, TextureClass, TextureValue, Textures};
use crate::assets::image_data::{Encoding, ImageData};
use crate::math::color::linear_from_srgb;
use crate::math::transform::Transform;
use crate::params::{NamedFile, ParamReader};
use crate::surface::TexturePoint;
use std::path::Path;

/// An image, filtered over the footprint. A float texture of a color image is the luminance
/// of its encoded values, decoded afterwards.
///
/// Parameters: string `filename`; string `wrap` `repeat` (`black`, `clamp`); float `scale` 1,
/// multiplied after decoding; bool `gamma`: decode by the sRGB curve (true for .png, .tga and
/// .jpg, false for .exr, .pfm and .hdr, else by what the file is); bool `trilinear` false (EWA); float `maxanisotropy` 8; a 2-D mapping.
/// Files in pbrt-v2's language: *float* `gamma` 1, value = (scale · texel)^gamma.
/// (s, t) = (0, 0) is the image's lower-left corner; of an .exr in v2's language, its upper-left.
/// An image that cannot be read counts as one texel of 0.5.
#[derive(Clone, Debug)]
pub struct Imagemap {
    /// From points to (s, t).
    pub mapping: Mapping,
    /// The image; `None` where none was given or found.
    pub file: Option<NamedFile>,
    /// Everything that shapes the filtered image besides the file.
    pub settings: ImageSettings,
    /// Position of the filtered image, once it is prepared.
    pub map: usize,
}

/// How a file becomes a filtered image: textures that agree in it share one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ImageSettings {
    /// What lies outside the unit square.
    pub wrap: Wrap,
    /// How footprints are filtered.
    pub filter: Filter,
    /// From stored to texture values.
    pub decoding: Decoding,
    /// `true` if t = 0 is the image's top row.
    pub top_first: bool,
}

/// From stored to texture values.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Decoding {
    /// pbrt-v3: the sRGB curve, if any, then the factor.
    Scaled {
        /// `true` if values are decoded by the sRGB curve first.
        srgb: bool,
        /// Factor.
        scale: f32,
    },
    /// The same of a file whose name does not tell what it is: the sRGB curve where files of its kind are encoded by it.
    ScaledAsFile {
        /// Factor.
        scale: f32,
    },
    /// pbrt-v2: the factor first, then the power.
    Power {
        /// Factor.
        scale: f32,
        /// Exponent.
        gamma: f32,
    },
}

/// The sRGB curve at what eight-bit images hold: a power for each texel took longer than all else of loading.
struct SrgbBytes([(f32, f32); 256]);

impl SrgbBytes {
    fn new() -> SrgbBytes {
        SrgbBytes(std::array::from_fn(|i| {
            let stored = i as f32 / 255.0;
            (stored, linear_from_srgb(stored))
        }))
    }

    fn linear(&self, stored: f32) -> f32 {
        // A conversion that saturates: also for what is no number, or far too large.
        match self.0.get((stored * 255.0 + 0.5) as usize) {
            Some(&(exactly, linear)) if exactly == stored => linear,
            _ => linear_from_srgb(stored),
        }
    }
}

impl Decoding {
    /// For an image that is encoded like this by convention.
    fn of(self, encoding: Encoding) -> Decoding {
        match self {
            Decoding::ScaledAsFile { scale } => Decoding::Scaled {
                srgb: encoding == Encoding::Srgb,
                scale,
            },
            known => known,
        }
    }

    fn apply<V: TextureValue>(self, stored: V, bytes: &SrgbBytes) -> V {
        match self {
            Decoding::Scaled { srgb: true, scale } => stored.map(|v| bytes.linear(v)) * scale,
            Decoding::Scaled { srgb: false, scale }
            | Decoding::ScaledAsFile { scale }
            | Decoding::Power { scale, gamma: 1.0 } => stored * scale,
            // A negative base has no real power; such texels are black.
            Decoding::Power { scale, gamma } => (stored * scale).map(|v| v.max(0.0).powf(gamma)),
        }
    }
}

impl<V: TextureValue> TextureClass<V> for Imagemap {
    fn from_params(reader: &ParamReader, ctm: &Transform) -> Imagemap {
        if !reader.has("filename") {
            reader.error(
                "filename",
                "an imagemap needs a \"string filename\": a gray of 0.5 is used",
            );
        }
        let name = Path::new(reader.string("filename", ""));
        let extension = name
            .extension()
            .and_then(|e| e.to_str())
            .unwrap_or_default()
            .to_ascii_lowercase();
        let wrap = match reader.one_of("wrap", &["repeat", "black", "clamp"]) {
            "black" => Wrap::Black,
            "clamp" => Wrap::Clamp,
            _ => Wrap::Repeat,
        };
        let max_anisotropy = reader.float("maxanisotropy", 8.0) as f32;
        let filter = match reader.boolean("trilinear", false) {
            true => Filter::Trilinear,
            false => Filter::Ewa { max_anisotropy },
        };
        let scale = reader.float("scale", 1.0) as f32;
        let decoding = if reader.means_v2("gamma") {
            let gamma = reader.float("gamma", 1.0) as f32;
            Decoding::Power { scale, gamma }
        } else {
            let is_srgb = matches!(&*extension, "png" | "tga" | "jpg" | "jpeg");
            let tells = is_srgb || matches!(&*extension, "exr" | "pfm" | "hdr");
            let srgb = reader.boolean("gamma", is_srgb);
            match tells || reader.has("gamma") {
                true => Decoding::Scaled { srgb, scale },
                false => Decoding::ScaledAsFile { scale },
            }
        };
        Imagemap {
            mapping: Mapping::from_params(reader, ctm),
            file: reader.named_file("filename"),
            settings: ImageSettings {
                wrap,
                filter,
                decoding,
                top_first: extension == "exr" && reader.means_v2("filename"),
            },
            map: 0,
        }
    }

    fn prepare(&mut self, compiler: &mut Compiler) {
        self.mapping.place(compiler.render_from_world);
        self.map = compiler.map(self.file.as_ref(), self.settings);
    }

    fn evaluate(&self, textures: &Textures, at: &TexturePoint) -> V {
        V::mipmap(textures, self.map).lookup(&self.mapping.coordinates(at))
    }
}

impl ImageSettings {
    /// The filtered image; of one gray texel where there is no image.
    pub(super) fn mipmap<V: TextureValue>(&self, image: Option<&ImageData>) -> Mipmap<V> {
        let bytes = SrgbBytes::new();
        let Some(image) = image else {
            return Mipmap::new(
                1,
                1,
                vec![self.decoding.apply(V::splat(0.5), &bytes)],
                self.wrap,
                self.filter,
            );
        };
        let decoding = self.decoding.of(image.encoding);
        let (width, height) = (image.width, image.height);
        let mut texels = Vec::with_capacity(width * height);
        for t in 0..height {
            let row = if self.top_first { t } else { height - 1 - t };
            texels.extend(
                (0..width).map(|s| decoding.apply(V::from_texel(image.pixel(s, row)), &bytes)),
            );
        }
        Mipmap::new(width, height, texels, self.wrap, self.filter)
    }
}
