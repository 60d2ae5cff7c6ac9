//! What a ray has met, as layers tell things apart.

use crate::handles::MaterialId;

/// What stands in a scene by itself.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Standing {
    /// A shape, by [`PrimitiveAttributes::shape`](super::PrimitiveAttributes::shape).
    Shape(u32),
    /// An instance of an object, by its number among all that were added.
    Instance(u32),
}

/// A material, and what stands in a scene with it: equal numbers for equal ones, so that a comparison tells whether two samples show the same.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Thing(u64);

impl Thing {
    /// Says that what stands there is an instance. There are fewer shapes than this: each takes more than a byte.
    const INSTANCE: u32 = 1 << 31;

    /// Of this material, if any, and as part of that.
    #[inline(always)]
    pub fn new(material: Option<MaterialId>, standing: Standing) -> Thing {
        let material = material.map_or(0, |id| u64::from(id.0) + 1);
        let standing = match standing {
            Standing::Shape(number) => number & !Thing::INSTANCE,
            Standing::Instance(number) => number | Thing::INSTANCE,
        };
        Thing(material << 32 | u64::from(standing))
    }

    /// Its material.
    pub fn material(self) -> Option<MaterialId> {
        let id = (self.0 >> 32).checked_sub(1)?;
        Some(MaterialId(id as u32))
    }

    /// What stands there.
    pub fn standing(self) -> Standing {
        let standing = self.0 as u32;
        match standing & Thing::INSTANCE {
            0 => Standing::Shape(standing),
            _ => Standing::Instance(standing & !Thing::INSTANCE),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn things_are_what_they_were_made_of() {
        let materials = [
            None,
            Some(MaterialId(0)),
            Some(MaterialId(7)),
            Some(MaterialId(u32::MAX - 1)),
        ];
        for material in materials {
            for standing in [0, 3, (1 << 31) - 1]
                .into_iter()
                .flat_map(|n| [Standing::Shape(n), Standing::Instance(n)])
            {
                let thing = Thing::new(material, standing);
                assert_eq!((thing.material(), thing.standing()), (material, standing));
            }
        }
    }
}
