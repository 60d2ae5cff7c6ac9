//! Reading the stop's shape: `"string aperture"`, `"integer blades"` and `"float bladerotation"` of `Camera "realistic"`.

use crate::assets::image_data::{Encoding, ImageData};
use crate::budget::Budget;
use crate::math::color::linear_from_srgb;
use crate::optics::StopShape;
use crate::optics::stop_shape::{MAX_BLADES, StopImage, StopPolygon};
use crate::params::ParamReader;

/// The shape asked for; `None` for a round stop, and where what is asked for cannot be had, which is reported.
pub(super) fn from_params(params: &ParamReader) -> Option<StopShape> {
    let aperture = params.string("aperture", "circular");
    let rotation = rotation(params);
    let turned = |polygon: fn(f64) -> StopPolygon| Some(StopShape::Polygon(polygon(rotation)));
    if aperture != "circular" && params.find_integer("blades").is_some() {
        params.warn("blades", format!("blades are those of a circular aperture; that of \"{aperture}\" is not made of them"));
    }
    let shape = match aperture {
        "circular" => blades(params, rotation),
        "gaussian" => Some(StopShape::Gaussian),
        "square" => turned(StopPolygon::square),
        "pentagon" => turned(StopPolygon::pentagon),
        "star" => turned(StopPolygon::star),
        // No image's name is without an ending.
        name if !name.contains('.') => {
            params.error(
                "aperture",
                format!(
                    "no shape is called \"{name}\": expected circular (with \"integer blades\" for a polygon), gaussian, square, pentagon, star, or the name of an image"
                ),
            );
            None
        }
        _ => image(params),
    };
    if rotation != 0.0 && !matches!(shape, Some(StopShape::Polygon(_))) {
        params.warn("bladerotation", "there is no polygon to turn");
    }
    shape
}

/// Degrees.
fn rotation(params: &ParamReader) -> f64 {
    let rotation = params.float("bladerotation", 0.0);
    if rotation.is_finite() {
        return rotation;
    }
    params.warn(
        "bladerotation",
        format!("{rotation} is no angle in degrees: 0 is used"),
    );
    0.0
}

/// A diaphragm; 0 blades, the default, leave the stop round.
fn blades(params: &ParamReader, rotation: f64) -> Option<StopShape> {
    let count = params.integer("blades", 0);
    let polygon = usize::try_from(count)
        .ok()
        .filter(|n| (3..=MAX_BLADES).contains(n));
    if count != 0 && polygon.is_none() {
        params.warn(
            "blades",
            format!(
                "{count} blades make no polygon of 3 to {MAX_BLADES} corners: the stop is round"
            ),
        );
    }
    polygon.map(|n| StopShape::Polygon(StopPolygon::of_blades(n, rotation)))
}

/// Transmission is the mean of red, green and blue, as in pbrt-v4.
fn image(params: &ParamReader) -> Option<StopShape> {
    // A file that does not exist has been reported.
    let path = params.file("aperture")?;
    let image = match ImageData::load(&path, &Budget::new(None)) {
        Ok(image) => image,
        Err(e) => {
            params.file_error("aperture", e.to_string(), e.is_failure);
            return None;
        }
    };
    let gray = |texel: &crate::math::Rgb| {
        let linear = match image.encoding {
            Encoding::Srgb => texel.to_array().map(linear_from_srgb),
            Encoding::Linear => texel.to_array(),
        };
        linear.iter().sum::<f32>() / 3.0
    };
    if image
        .texels()
        .iter()
        .map(gray)
        .any(|t| !(0.0..=1.0).contains(&t))
    {
        params.warn("aperture", "the image has values outside 0 to 1, which stand for nothing and everything let through");
    }
    StopImage::new(image.width, image.texels().iter().map(gray)).map(StopShape::ImageData)
}
