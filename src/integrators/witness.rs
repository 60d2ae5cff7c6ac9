//! Looks at what paths meet first, counts what they do, or locates the vertex at which radiance stopped being finite: such a sample is
//! traced again with a [`Watch`].

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

/// Looks at paths for layers, or records where radiance stopped being finite, or counts.
///
/// Two cache lines, the first of which is all that most paths need: those of a whole wave are to fit in the L1 cache.
#[derive(Debug, Default)]
#[repr(C, align(64))]
pub struct Watch {
    /// What the path meets first, if layers are wanted. Only integrators that trace a path fill it.
    pub sight: Sight,
    /// If layers of light are wanted: what the path brings, by them.
    pub parts: Option<Box<LightParts>>,
    /// What is told of every step, if anything is.
    report: Option<Box<Report>>,
}

#[derive(Debug)]
enum Report {
    Counts(Counts),
    Offender(Offender),
}

/// Where radiance stopped being finite.
#[derive(Debug, Default)]
struct Offender {
    last: Option<Place>,
    wrong: bool,
}

impl Watch {
    /// One that counts, from `counts` on.
    pub fn counting(counts: Counts) -> Watch {
        Watch::reporting(Report::Counts(counts))
    }

    /// One that looks for the [place](Watch::offender) where radiance stops being finite.
    pub fn searching() -> Watch {
        Watch::reporting(Report::Offender(Offender::default()))
    }

    fn reporting(report: Report) -> Watch {
        Watch {
            report: Some(Box::new(report)),
            ..Watch::default()
        }
    }

    /// Looks at the next path for these layers.
    #[inline(always)]
    pub fn look(&mut self, layers: LayerSet) {
        self.sight.restart(layers.contains(Layer::Uv));
        if layers.lights() > 0 {
            **self.parts.get_or_insert_default() = LightParts::default();
        }
    }

    /// What the path has met, if it has met anything and has told all of it.
    #[inline(always)]
    pub fn found(&self) -> Option<&FirstSurfaces> {
        self.sight.known()?
    }

    /// Returns `true` if it is known that the path has met nothing.
    #[inline(always)]
    pub fn is_empty(&self) -> bool {
        { self.sight.known() }.is_some_and(|found| found.is_none())
    }

    /// What the path, of which that is known, has met.
    #[inline(always)]
    pub fn first(&self) -> &FirstSurfaces {
        self.sight.first()
    }

    /// The counts, of one that counts.
    pub fn counts(&self) -> Option<&Counts> {
        match self.report.as_deref() {
            Some(Report::Counts(counts)) => Some(counts),
            _ => None,
        }
    }

    /// Counts, where that is asked for.
    #[inline(always)]
    pub fn count(&mut self, add: impl FnOnce(&mut Counts)) {
        if let Some(Report::Counts(counts)) = self.report.as_deref_mut() {
            add(counts);
        }
    }

    /// Returns `true` if layers are wanted, and the path has not told them all yet.
    pub(super) fn is_looking(&self) -> bool {
        self.sight.is_looking()
    }

    /// Returns `true` if it wants to know of every step, and not only of what is met first.
    pub(super) fn reports(&self) -> bool {
        self.report.is_some() || self.parts.is_some()
    }

    /// The first point whose light is not finite, or the last one of the path where the path's
    /// whole `radiance` is finite but negative; `None` where the path met nothing.
    pub fn offender(self) -> Option<Place> {
        match self.report.as_deref() {
            Some(Report::Offender(offender)) => offender.last,
            _ => None,
        }
    }

    /// The path has reached a vertex, with the `radiance` collected at those before it.
    #[cold]
    pub(super) fn arrive(&mut self, place: Place, radiance: Rgb) {
        match self.report.as_deref_mut() {
            Some(Report::Counts(counts)) => counts.arrive(place),
            Some(Report::Offender(offender)) => offender.arrive(place, radiance),
            None => {}
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
        self.count(|counts| counts.shadow(light, is_lit));
    }
}

impl Offender {
    fn arrive(&mut self, place: Place, radiance: Rgb) {
        // What is wrong on arrival went wrong at the vertex before.
        self.wrong |= !radiance.is_finite();
        if !self.wrong {
            self.last = Some(place);
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
            let mut watch = Watch::searching();
            for (depth, radiance) in [(0, Rgb::ZERO), (1, Rgb::ONE), (2, bad), (3, Rgb::ONE)] {
                watch.arrive(place(depth), radiance);
            }
            assert_eq!(watch.offender(), Some(place(1)));
        }
        assert_eq!(Watch::searching().offender(), None);
    }

    #[test]
    fn one_takes_two_lines_of_a_cache() {
        assert_eq!((size_of::<Watch>(), align_of::<Watch>()), (128, 64));
        let thing = std::mem::offset_of!(Watch, sight) + Sight::HOT;
        assert!(thing <= 64, "{thing}");
    }
}
