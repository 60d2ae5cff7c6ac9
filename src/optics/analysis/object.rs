//! What the lens looks at.

use crate::optics::lens::Lens;

/// The plane whose image the film shows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ObjectPlane {
    /// Its z; `None` at infinity.
    pub z: Option<f64>,
}

impl ObjectPlane {
    /// Infinitely far.
    pub const INFINITY: ObjectPlane = ObjectPlane { z: None };

    /// The plane of Gaussian focus; infinity for a lens focused on nothing real, whose image of a distant object is what
    /// there is to look at.
    pub fn in_focus(lens: &Lens) -> ObjectPlane {
        ObjectPlane {
            z: lens.plane_of_focus().filter(|z| z.is_finite()),
        }
    }

    /// `distance` mm from the film.
    pub fn at_distance(lens: &Lens, distance: f64) -> ObjectPlane {
        ObjectPlane {
            z: distance.is_finite().then(|| lens.film_z() - distance),
        }
    }
}
