//! What a shard's file says of the image: enough to make it without the scene.

use crate::film::{FilmMetadata, FilmSpec, LayerSet, LightShare};
use crate::math::UVec2;
use serde::{Deserialize, Serialize};
use std::fmt;

/// One of the equal parts that a render is divided into.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub struct Shard {
    /// From 1.
    pub number: u32,
    /// How many there are.
    pub of: u32,
}

impl Shard {
    /// Most shards of one render.
    pub const MOST: u32 = 100_000;

    /// Returns `true` if there is such a shard.
    pub fn is_valid(&self) -> bool {
        (1..=self.of).contains(&self.number) && self.of <= Shard::MOST
    }
}

impl fmt::Display for Shard {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}/{}", self.number, self.of)
    }
}

/// What all shards of a render agree on, and which of them this is.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Facts {
    /// Which.
    pub shard: Shard,
    /// The film.
    pub film: FilmFacts,
    /// The pixels that are rendered: from x, y to below x, y.
    pub sampled: [UVec2; 2],
    /// What the image's file says of it.
    pub metadata: FilmMetadata,
    /// Samples of every pixel, if there is no goal.
    pub spp: u32,
    /// Rendered in passes until then.
    pub goal: Option<GoalFacts>,
    /// Rendered in two halves, whose numbers of samples add up to `spp`.
    #[serde(default)]
    pub halved: bool,
    /// The samples of a pixel depend on each other.
    #[serde(default)]
    pub are_dependent: bool,
    /// If paths are traced from the lights, the scale of their [`crate::film::Splats`], and how many there are.
    pub splats: Option<(i32, LightShare)>,
    /// A shard's light paths are those of its own camera samples.
    pub are_paired: bool,
}

/// See [`FilmSpec`].
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct FilmFacts {
    /// Width and height in pixels.
    pub resolution: UVec2,
    /// x0, x1, y0, y1 as fractions.
    pub crop_window: [f64; 4],
    /// Factor of finished pixels.
    pub scale: f32,
    /// Layers.
    #[serde(default)]
    pub layers: LayerSet,
}

/// The goal of an adaptive render.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct GoalFacts {
    /// Relative error.
    pub error: f64,
    /// With this confidence.
    #[serde(default)]
    pub confidence: Option<f64>,
    /// Most samples a pixel.
    pub max_spp: u32,
}

impl FilmFacts {
    /// Of this film.
    pub fn of(film: &FilmSpec) -> FilmFacts {
        FilmFacts {
            resolution: film.resolution,
            crop_window: film.crop_window,
            scale: film.scale,
            layers: film.layers,
        }
    }

    /// The film, which no more samples are added to.
    pub fn spec(&self) -> FilmSpec {
        FilmSpec {
            resolution: self.resolution,
            crop_window: self.crop_window,
            scale: self.scale,
            layers: self.layers,
            ..FilmSpec::default()
        }
    }
}
