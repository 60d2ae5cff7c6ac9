//! The numbers by which Cryptomattes know what a ray meets.

use crate::accel::{Standing, Thing};
use crate::film::MatteId;

/// By material, shape and instance; empty where no matte is wanted.
#[derive(Clone, Debug, Default)]
pub struct Mattes {
    materials: Vec<MatteId>,
    shapes: Vec<MatteId>,
    instances: Vec<MatteId>,
}

impl Mattes {
    /// Of materials, shapes and instances that are called so.
    pub fn new(materials: &[String], shapes: &[String], instances: &[String]) -> Mattes {
        let numbers = |names: &[String]| names.iter().map(|name| MatteId::of(name)).collect();
        Mattes {
            materials: numbers(materials),
            shapes: numbers(shapes),
            instances: numbers(instances),
        }
    }

    /// Those of [`crate::film::Layer::MATTES`].
    pub(super) fn of(&self, thing: Thing) -> [MatteId; 2] {
        let material = { thing.material() }.and_then(|id| self.materials.get(id.index()));
        let standing = match thing.standing() {
            Standing::Shape(number) => self.shapes.get(number as usize),
            Standing::Instance(number) => self.instances.get(number as usize),
        };
        [material, standing].map(|number| number.copied().unwrap_or_default())
    }
}
