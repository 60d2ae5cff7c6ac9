//! The numbers by which Cryptomattes know what a ray meets.

use crate::accel::Standing;
use crate::film::MatteId;
use crate::handles::MaterialId;

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

    pub(super) fn material(&self, id: Option<MaterialId>) -> MatteId {
        let number = id.and_then(|id| self.materials.get(id.index()));
        number.copied().unwrap_or_default()
    }

    pub(super) fn standing(&self, standing: Standing) -> MatteId {
        let number = match standing {
            Standing::Shape(number) => self.shapes.get(number as usize),
            Standing::Instance(number) => self.instances.get(number as usize),
        };
        number.copied().unwrap_or_default()
    }
}
