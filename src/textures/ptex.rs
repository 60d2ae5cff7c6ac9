//! `ptex`.

use super::{Constant, TextureValue};
use crate::params::ParamReader;

/// Ptex files (per-face pictures of subdivision surfaces) are not read: a warning, and a grey of
/// 0.5 in their place, as pbrt-v3 takes for pictures it cannot read. Parameters: string `filename`,
/// float `gamma`.
pub(super) fn from_params<V: TextureValue>(reader: &ParamReader) -> Constant<V> {
    reader.accept("filename");
    reader.accept("gamma");
    reader.warn(
        "filename",
        "Ptex files are not read: 0.5 everywhere is used",
    );
    Constant {
        value: V::splat(0.5),
    }
}
