//! Locates the vertex of a path at which its radiance stopped being finite: such a sample is traced again with a
//! [`Watch`]. Or counts what paths do, or looks at what they meet first.

use super::counts::Counts;
use super::{FirstSurfaces, LightParts, Sight};
use crate::film::{Layer, LayerSet};
use crate::handles::{LightId, LightLayer, MaterialId};
use crate::math::Rgb;

/// What a path met.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Met {
    /// A surface; `None` for one without material.
    Surface(Option<MaterialId>),
    /// A particle of a medium.
    Medium,
    /// Nothing: it left the scene.
    Background,
}

/// A vertex of a path.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Place {
    /// Scattering events before it.
    pub depth: u32,
    /// What is there.
    pub met: Met,
}

/// Records where radiance stopped being finite, or counts, or looks.
#[derive(Debug, Default)]
pub struct Watch {
    last: Option<Place>,
    wrong: bool,
    /// If paths are to be counted. Boxed, as `parts`, so that a wave of watches stays in a near cache.
    pub counts: Option<Box<Counts>>,
    /// If layers are wanted: what the path meets first. Only integrators that trace a path fill it.
    pub sight: Option<Sight>,
    /// If layers of light are wanted: what the path brings, by them.
    pub parts: Option<Box<LightParts>>,
}

impl Watch {
    /// One that counts, from `counts` on.
    pub fn counting(counts: Counts) -> Watch {
        Watch {
            counts: Some(Box::new(counts)),
            ..Watch::default()
        }
    }

    /// Looks at the next path for these layers.
    #[inline(always)]
    pub fn look(&mut self, layers: LayerSet) {
        let sight = self.sight.get_or_insert_default();
        sight.restart(layers.contains(Layer::Uv));
        if layers.lights() > 0 {
            **self.parts.get_or_insert_default() = LightParts::default();
        }
    }

    /// What the path has met, if it has met anything and has told all of it.
    #[inline(always)]
    pub fn found(&self) -> Option<&FirstSurfaces> {
        self.sight.as_ref()?.known()?
    }

    /// Returns `true` if it is known that the path has met nothing.
    #[inline(always)]
    pub fn is_empty(&self) -> bool {
        let known = self.sight.as_ref().and_then(Sight::known);
        known.is_some_and(|found| found.is_none())
    }

    /// What the path, of which that is known, has met.
    #[inline(always)]
    pub fn first(&self) -> Option<&FirstSurfaces> {
        self.sight.as_ref().map(Sight::first)
    }

    /// Counts, where that is asked for.
    #[inline(always)]
    pub fn count(&mut self, add: impl FnOnce(&mut Counts)) {
        if let Some(counts) = &mut self.counts {
            add(counts);
        }
    }

    /// Returns `true` if layers are wanted, and the path has not told them all yet.
    pub(super) fn is_looking(&self) -> bool {
        self.sight.as_ref().is_some_and(Sight::is_looking)
    }

    /// Returns `true` if it wants to know of every step, and not only of what is met first.
    pub(super) fn reports(&self) -> bool {
        self.counts.is_some() || self.parts.is_some() || self.sight.is_none()
    }

    /// The first point whose light is not finite, or the last one of the path where the path's
    /// whole `radiance` is finite but negative; `None` where the path met nothing.
    pub fn offender(self) -> Option<Place> {
        self.last
    }

    /// The path has reached a vertex, with the `radiance` collected at those before it.
    #[cold]
    pub(super) fn arrive(&mut self, place: Place, radiance: Rgb) {
        if let Some(counts) = &mut self.counts {
            return counts.arrive(place);
        }
        // What is wrong on arrival went wrong at the vertex before.
        self.wrong |= !radiance.is_finite();
        if !self.wrong {
            self.last = Some(place);
        }
    }

    /// Adds light to its layer, if there are layers of light; only then is `from` called to say which.
    #[inline(always)]
    pub(super) fn part(&mut self, from: impl FnOnce() -> LightLayer, light: Rgb) {
        if let Some(parts) = &mut self.parts {
            parts.add(from(), light);
        }
    }

    /// A shadow ray is sent to a light, or, `is_lit`, has met nothing.
    #[cold]
    pub(super) fn shadow(&mut self, light: LightId, is_lit: bool) {
        if let Some(counts) = &mut self.counts {
            counts.shadow(light, is_lit);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_point_before_the_first_wrong_sum_is_to_blame() {
        let place = |depth| Place {
            depth,
            met: Met::Surface(Some(MaterialId(depth))),
        };
        for bad in [Rgb::NAN, Rgb::INFINITY] {
            let mut watch = Watch::default();
            for (depth, radiance) in [(0, Rgb::ZERO), (1, Rgb::ONE), (2, bad), (3, Rgb::ONE)] {
                watch.arrive(place(depth), radiance);
            }
            assert_eq!(watch.offender(), Some(place(1)));
        }
        assert_eq!(Watch::default().offender(), None);
    }
}
