//! What each strategy finds, as an image of its own: `visualizestrategies` and `visualizeweights`, for those who want to see what it is
//! good at. The images are in place of [layers of light](crate::film::Layer::Lights).

use crate::film::LayerSet;
use crate::handles::LightLayer;
use crate::math::Rgb;
use crate::params::ParamReader;

/// The largest number of scattering events of a path, as in pbrt-v3.
const MAX_DEPTH: u32 = 5;

/// Room for all: see [`first`].
const _: () = assert!(first(MAX_DEPTH + 1) == LayerSet::MAX_LIGHTS);

/// What the images show.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Shown {
    /// `visualizestrategies`: what the strategy finds by itself.
    Alone,
    /// `visualizeweights`: the same times its weight, which all together are the image.
    Weighted,
}

impl Shown {
    /// Reads the parameters; `visualizeweights` prevails, as in pbrt-v3. Paths become shorter for it.
    pub(super) fn from_params(reader: &ParamReader, max_depth: &mut u32) -> Option<Shown> {
        let alone = reader.boolean("visualizestrategies", false);
        let weighted = reader.boolean("visualizeweights", false);
        let shown = match (alone, weighted) {
            (_, true) => Shown::Weighted,
            (true, false) => Shown::Alone,
            (false, false) => return None,
        };
        if *max_depth > MAX_DEPTH {
            reader.warn(
                "maxdepth",
                format!(
                    "`maxdepth` is {max_depth}: where strategies have images of their own it is {MAX_DEPTH} at most"
                ),
            );
            *max_depth = MAX_DEPTH;
        }
        Some(shown)
    }

    /// What light counts for in its strategy's image, where it counts for `weighted` in the image.
    pub(super) fn of(self, light: Rgb, weighted: Rgb) -> Rgb {
        match self {
            Shown::Weighted => weighted,
            // What no path brings, as an instanced emitter does not.
            Shown::Alone if weighted == Rgb::ZERO => Rgb::ZERO,
            Shown::Alone => light,
        }
    }
}

/// Number of strategies for paths of fewer than so many scattering events: d + 2 for d of them, but one for none, where a light is
/// seen. A point of a light is not joined to the lens itself.
const fn first(depth: u32) -> usize {
    match depth {
        0 => 0,
        d => ((d * (d + 3) - 2) / 2) as usize,
    }
}

/// Where the image of the strategy with `s` vertices from a light is, for paths of so many scattering events.
pub(super) fn layer(depth: u32, s: u32) -> LightLayer {
    LightLayer((first(depth) + s as usize) as u8)
}

/// The names of all images, for paths of at most so many scattering events, as pbrt-v3 calls its files: t is the number of vertices from
/// the camera.
pub(super) fn names(max_depth: u32) -> Vec<String> {
    let of_depth = |depth: u32| {
        let count = first(depth + 1) - first(depth);
        (0..count as u32).map(move |s| format!("bdpt_d{depth:02}_s{s:02}_t{:02}", depth + 2 - s))
    };
    (0..=max_depth).flat_map(of_depth).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn strategies_are_those_of_pbrt() {
        // `bdpt.cpp` has s from 0 to depth + 2, but no image for t = 0, nor for s = t = 1.
        let mut expected = Vec::new();
        for depth in 0..=MAX_DEPTH {
            for s in 0..=depth + 2 {
                let t = depth + 2 - s;
                if t > 0 && (s, t) != (1, 1) {
                    assert_eq!(layer(depth, s).index(), expected.len());
                    expected.push(format!("bdpt_d{depth:02}_s{s:02}_t{t:02}"));
                }
            }
            assert_eq!(names(depth), expected);
        }
    }
}
