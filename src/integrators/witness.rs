//! Watching a path, to say where its radiance stopped being a number.
//!
//! A sample that comes to nothing finite is taken again with a [`Watch`]; all others are walked
//! [`Unwatched`], which costs nothing.

use crate::handles::MaterialId;
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

/// A point of a path.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Place {
    /// Scattering events before it.
    pub depth: u32,
    /// What is there.
    pub met: Met,
}

/// Is told of every point of a path.
pub trait Witness {
    /// The path has come to a point, with the `radiance` gathered at those before it.
    fn arrive(&mut self, place: Place, radiance: Rgb);
}

/// Nobody looks.
pub struct Unwatched;

impl Witness for Unwatched {
    #[inline(always)]
    fn arrive(&mut self, _: Place, _: Rgb) {}
}

/// Remembers where radiance stopped being finite.
#[derive(Debug, Default)]
pub struct Watch {
    last: Option<Place>,
    wrong: bool,
}

impl Watch {
    /// The first point whose light is not finite, or the last one of the path where the path's
    /// whole `radiance` is finite but negative; `None` where the path met nothing.
    pub fn offender(self) -> Option<Place> {
        self.last
    }
}

impl Witness for Watch {
    fn arrive(&mut self, place: Place, radiance: Rgb) {
        // What is wrong on arrival went wrong at the point before.
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
            let mut watch = Watch::default();
            for (depth, radiance) in [(0, Rgb::ZERO), (1, Rgb::ONE), (2, bad), (3, Rgb::ONE)] {
                watch.arrive(place(depth), radiance);
            }
            assert_eq!(watch.offender(), Some(place(1)));
        }
        assert_eq!(Watch::default().offender(), None);
    }
}
