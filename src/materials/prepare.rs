//! What materials need before rays meet them, beyond textures.

use super::{Material, MaterialKind};
use crate::bssrdf::ProfileTable;
use std::collections::BTreeMap;
use std::sync::Arc;

/// Makes the scattering profiles of all materials: those alike in `g` and `eta` share a table.
pub fn prepare(materials: &mut [Material]) {
    let mut tables: BTreeMap<[u32; 2], Arc<ProfileTable>> = BTreeMap::new();
    let mut make = |g: f32, eta: f32| {
        let table = tables.entry([g, eta].map(f32::to_bits));
        Arc::clone(table.or_insert_with(|| Arc::new(ProfileTable::new(g, eta))))
    };
    for material in materials {
        match &mut material.kind {
            MaterialKind::Subsurface(m) => m.interior.prepare(&mut make),
            MaterialKind::KdSubsurface(m) => m.interior.prepare(&mut make),
            _ => {}
        }
    }
}
