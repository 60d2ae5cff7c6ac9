//! Which shapes bring a material of their own.

use crate::syntax::{Param, ParamGroup, ParamList, ParamValue};

/// Returns `true` if these parameters of a shape may change its material. If not, the shape can share the current
/// one; if so, a material is made from both lists with [`super::ParamReader::layered`]. pbrt-v3's
/// rule (docs/scene-language.md §2.4): no material takes arrays, so only single values count, and of those
/// the usual parameters of shapes do not.
pub fn may_change_material(shape: &ParamList) -> bool {
    shape
        .params
        .iter()
        .any(|param| match (param.ty.group(), param.name.as_str()) {
            (ParamGroup::Texture, name) => !matches!(name, "alpha" | "shadowalpha"),
            (ParamGroup::Float, "radius") => false,
            (ParamGroup::String, "filename" | "type" | "scheme") => false,
            _ => is_single(param),
        })
}

fn is_single(param: &Param) -> bool {
    match &param.value {
        // All pairs of an inline spectrum are one value.
        ParamValue::Numbers(numbers) if param.ty == crate::syntax::ParamType::Spectrum => {
            !numbers.is_empty()
        }
        ParamValue::Numbers(numbers) => numbers.len() == param.ty.items(),
        ParamValue::Strings(strings) => strings.len() == 1,
        ParamValue::Bools(bools) => bools.len() == 1,
    }
}
