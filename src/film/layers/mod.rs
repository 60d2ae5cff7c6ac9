//! Layers: what an image knows of its pixels besides their color.
//!
//! Of each layer a pixel keeps [sums](sums) over the samples that its color is made of; of `material` and `instance`, which things
//! its samples met and how often ([`coverage`]), for Cryptomatte ([`cryptomatte`]).

mod coverage;
mod cryptomatte;
mod growing;
mod image_layers;
mod planes;
mod rows;
mod sample;
mod sums;

pub(super) use coverage::Coverage;
pub use coverage::ImageMatte;
pub use cryptomatte::{Manifest, MatteId};
pub(crate) use growing::GrowingLayers;
pub use image_layers::{ImageLayer, ImageLayers};
pub use sample::{CameraSample, LayerSample, RenderSpace, SurfaceSample};
pub(super) use sums::{LayerPixels, TileLayers};

use serde::{Deserialize, Serialize};
use std::fmt;

/// A layer of an image.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Layer {
    /// The share of light from everywhere that the first surface which is not perfectly specular sends to the camera, times
    /// what mirrors and glass before it let through; 0 to 1.
    Albedo,
    /// World-space shading normal of the same surface, turned to where the ray came from; components −1 to 1.
    Normal,
    /// Of the first surface, from the plane through the camera's position across its axis; scene units. For `environment`
    /// from the position itself.
    Depth,
    /// World-space position on the first surface.
    Position,
    /// Surface parameters there, as textures see them.
    Uv,
    /// Which materials the pixel shows, and how much of it each covers: a Cryptomatte.
    Material,
    /// The same of instances of objects, and of shapes that are in none.
    Instance,
    /// Where the point of the first surface moves while the shutter is open, in pixels to the right and up.
    Motion,
    /// The image by the groups of its lights (`"string group"`), and of those that have none: light groups.
    Lights,
    /// Diameter in pixels of the circle of confusion that a point of this depth has near the axis of the lens.
    Coc,
    /// The part of the pixel that surfaces cover, glass and mirrors among them; 0 to 1.
    Alpha,
}

impl Layer {
    /// All of them, in the order in which they are listed.
    pub const ALL: [Layer; 11] = [
        Layer::Albedo,
        Layer::Normal,
        Layer::Depth,
        Layer::Position,
        Layer::Uv,
        Layer::Material,
        Layer::Instance,
        Layer::Motion,
        Layer::Lights,
        Layer::Coc,
        Layer::Alpha,
    ];

    /// Those that are Cryptomattes.
    pub const MATTES: [Layer; 2] = [Layer::Material, Layer::Instance];

    /// As `--aov` calls it.
    pub fn name(self) -> &'static str {
        match self {
            Layer::Albedo => "albedo",
            Layer::Normal => "normal",
            Layer::Depth => "depth",
            Layer::Position => "position",
            Layer::Uv => "uv",
            Layer::Material => "material",
            Layer::Instance => "instance",
            Layer::Motion => "motion",
            Layer::Lights => "lights",
            Layer::Coc => "coc",
            Layer::Alpha => "alpha",
        }
    }

    /// The names of its channels in a file, as compositing programs expect them: components behind the layer's name, and
    /// the alpha of the image itself. Those of light groups are called as the scene calls them.
    pub fn channels(self) -> &'static [&'static str] {
        match self {
            Layer::Albedo => &["albedo.R", "albedo.G", "albedo.B"],
            Layer::Normal => &["normal.X", "normal.Y", "normal.Z"],
            Layer::Depth => &["depth.Z"],
            Layer::Position => &["position.X", "position.Y", "position.Z"],
            Layer::Uv => &["uv.U", "uv.V"],
            Layer::Material => &cryptomatte::MATERIAL,
            Layer::Instance => &cryptomatte::OBJECT,
            Layer::Motion => &["motion.X", "motion.Y"],
            Layer::Lights => &[],
            Layer::Coc => &["coc.Y"],
            Layer::Alpha => &["A"],
        }
    }

    fn is_matte(self) -> bool {
        Layer::MATTES.contains(&self)
    }
}

/// The channels of a layer of light.
pub(super) fn light_channels(layer: &str) -> [String; 3] {
    ["R", "G", "B"].map(|component| format!("{layer}.{component}"))
}

/// What the light of lights without a group is called.
pub const NO_GROUP: &str = "rest";

/// Some layers.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct LayerSet {
    layers: u16,
    lights: u8,
}

impl LayerSet {
    /// None.
    pub const NONE: LayerSet = LayerSet {
        layers: 0,
        lights: 0,
    };

    /// The largest number of light groups, with [`NO_GROUP`], or of strategies of `bdpt`.
    pub const MAX_LIGHTS: usize = 26;

    /// These and `layer`.
    #[must_use]
    pub fn with(self, layer: Layer) -> LayerSet {
        LayerSet {
            layers: self.layers | 1 << layer as u16,
            ..self
        }
    }

    /// These, where [`Layer::Lights`] is so many layers if it is among them; at most [`LayerSet::MAX_LIGHTS`].
    #[must_use]
    pub fn with_lights(self, count: usize) -> LayerSet {
        let lights = match self.contains(Layer::Lights) {
            true => count.min(LayerSet::MAX_LIGHTS) as u8,
            false => 0,
        };
        LayerSet { lights, ..self }
    }

    /// How many layers of light there are.
    pub fn lights(self) -> usize {
        self.lights.into()
    }

    /// Returns `true` if `layer` is among them.
    pub fn contains(self, layer: Layer) -> bool {
        self.layers & 1 << layer as u16 != 0
    }

    /// Returns `true` if there is none.
    pub fn is_empty(self) -> bool {
        self.layers == 0
    }

    /// They, in the order of [`Layer::ALL`].
    pub fn iter(self) -> impl Iterator<Item = Layer> {
        { Layer::ALL.into_iter() }.filter(move |layer| self.contains(*layer))
    }

    /// Reads names between commas, in any order.
    ///
    /// # Errors
    /// The first name that no layer has, in a sentence with those that there are.
    pub fn parse(list: &str) -> Result<LayerSet, String> {
        { list.split(',') }.try_fold(LayerSet::NONE, |set, name| {
            let name = name.trim();
            let found = Layer::ALL.into_iter().find(|layer| layer.name() == name);
            let layer = found.ok_or_else(|| {
                let all = Layer::ALL.map(Layer::name).join(", ");
                format!("no layer is called \"{name}\"; there are {all}")
            })?;
            Ok(set.with(layer))
        })
    }

    /// Of these ids of [`Layer::MATTES`] those of layers that are among them, so that nothing else is told apart.
    #[inline(always)]
    fn wanted_ids(self, [material, instance]: [MatteId; 2]) -> [MatteId; 2] {
        let wanted = |layer, id| match self.contains(layer) {
            true => id,
            false => MatteId::default(),
        };
        [
            wanted(Layer::Material, material),
            wanted(Layer::Instance, instance),
        ]
    }

    /// Returns `true` if any is a Cryptomatte.
    pub fn has_mattes(self) -> bool {
        let mut mattes = Layer::MATTES.into_iter();
        mattes.any(|layer| self.contains(layer))
    }

    /// Numbers that are added up for each pixel.
    fn sums(self) -> usize {
        if self.is_empty() {
            return 0;
        }
        4 * self.rows().count() + 3 * self.lights()
    }

    /// The [rows](rows::ROWS) of sums that are wanted: the shared one first.
    fn rows(self) -> impl Iterator<Item = usize> {
        let has = move |row: usize| {
            let mut places = self.iter().filter_map(rows::place);
            row == 0 || places.any(|(own, _)| own == row)
        };
        (0..rows::ROWS).filter(move |row| has(*row))
    }

    /// Bytes of a pixel's sums, where a pixel of a matte shows two things.
    pub fn memory_of_sums(self) -> u64 {
        let mattes = usize::from(self.has_mattes());
        (self.sums() * size_of::<f64>() + 2 * mattes * coverage::ENTRY) as u64
    }

    /// Bytes of a pixel in the image.
    pub fn memory_of_image(self) -> u64 {
        let channels = |layer: Layer| layer.channels().len();
        let channels = self.iter().map(channels).sum::<usize>() + 3 * self.lights();
        (channels * size_of::<f32>()) as u64
    }
}

/// The names, between commas.
impl fmt::Display for LayerSet {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (index, layer) in self.iter().enumerate() {
            let comma = if index > 0 { "," } else { "" };
            write!(f, "{comma}{}", layer.name())?;
        }
        Ok(())
    }
}

/// All layers.
#[cfg(test)]
pub(super) fn all() -> LayerSet {
    let all = Layer::ALL.into_iter().fold(LayerSet::NONE, LayerSet::with);
    all.with_lights(LayerSet::MAX_LIGHTS)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_read_and_written() {
        let again = LayerSet::parse(&all().to_string());
        assert_eq!(
            again.map(|set| set.with_lights(LayerSet::MAX_LIGHTS)),
            Ok(all())
        );
        let some = LayerSet::parse("depth, albedo").unwrap();
        assert_eq!(some.to_string(), "albedo,depth");
        assert_eq!(some.iter().count(), 2);
        let error = LayerSet::parse("albedo,dpeth").unwrap_err();
        assert!(error.contains("\"dpeth\"") && error.contains("depth"));
        assert!(LayerSet::parse("").is_err());
    }
}
