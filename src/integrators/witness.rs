//! Locates the vertex of a path at which its radiance stopped being finite: such a sample is traced again with a
//! [`Watch`].

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

/// A vertex of a path.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Place {
    /// Scattering events before it.
    pub depth: u32,
    /// What is there.
    pub met: Met,
}

/// Records where radiance stopped being finite.
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

    /// The path has reached a vertex, with the `radiance` collected at those before it.
    #[cold]
    pub(super) fn arrive(&mut self, place: Place, radiance: Rgb) {
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
            let mut watch = Watch::default();
            for (depth, radiance) in [(0, Rgb::ZERO), (1, Rgb::ONE), (2, bad), (3, Rgb::ONE)] {
                watch.arrive(place(depth), radiance);
            }
            assert_eq!(watch.offender(), Some(place(1)));
        }
        assert_eq!(Watch::default().offender(), None);
    }
}
