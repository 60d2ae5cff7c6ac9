//! The lenses of `tests/golden` and their golden data (tests/golden/README.md), for the tests of the optics.

use fstop::optics::{Prescription, Surface};
use serde_json::Value;
use std::path::PathBuf;

/// All but `noct_58_f0.95`, which is aspheric and has tests of its own (`tests/optics/asphere_golden.rs`).
/// `_at_` is a zoom of the file before it.
pub(crate) const LENSES: [&str; 16] = [
    "canon_uw_14",
    "course_dgauss_100",
    "dgauss_50",
    "dgauss_50_film_in_glass",
    "fisheye_10",
    "fisheye_206",
    "nikon_50_f1.2",
    "petzval_50",
    "retrofocus_35",
    "telephoto_250",
    "tessar_100",
    "triplet_50",
    "wide_22",
    "zoom_80_200_at_194",
    "zoom_80_200_at_81.55",
    "zoom_80_200_wide",
];

/// A lens and what others computed for it.
pub(crate) struct Golden {
    pub name: &'static str,
    pub prescription: Prescription,
    pub data: Value,
}

impl Golden {
    /// All of [`LENSES`].
    pub(crate) fn all() -> impl Iterator<Item = Golden> {
        LENSES.into_iter().map(|name| {
            let (prescription, data) = read(name);
            Golden {
                name,
                prescription,
                data,
            }
        })
    }

    /// Those with spots, too, which are quadratures of the earlier generator.
    pub(crate) fn with_spots() -> impl Iterator<Item = Golden> {
        Golden::all().filter(|g| has_spots(&g.data))
    }

    /// The surfaces with the stop at `scale` of its diameter.
    pub(crate) fn surfaces(&self, scale: f64) -> Vec<Surface> {
        let mut surfaces = self.prescription.surfaces.clone();
        for s in surfaces.iter_mut().filter(|s| s.is_stop) {
            s.aperture *= scale;
        }
        surfaces
    }
}

/// Are there spots in the data of a lens?
pub(crate) fn has_spots(data: &Value) -> bool {
    data.pointer("/fields/0/spot_rms_um").is_some()
}

/// The prescription and the golden data of the lens `name`.
pub(crate) fn read(name: &str) -> (Prescription, Value) {
    let folder = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("tests/golden");
    let text = std::fs::read_to_string(folder.join(format!("{name}.json")));
    let text = text.expect("golden data of the project");
    let (lens, zoom) = match name.split_once("_at_") {
        Some((lens, zoom)) => (lens, Some(zoom.parse().expect("a zoom"))),
        None => (name, None),
    };
    let prescription = Prescription::read(&folder.join(format!("{lens}.dat")));
    let prescription = prescription.expect("a lens of the project");
    let prescription = { prescription.at_position(zoom, f64::INFINITY) }.expect("a zoom of it");
    (
        prescription,
        serde_json::from_str(&text).expect("golden data are JSON"),
    )
}

/// The number at the JSON pointer `path`.
pub(crate) fn number(data: &Value, path: &str) -> f64 {
    let found = data.pointer(path).and_then(Value::as_f64);
    found.unwrap_or_else(|| panic!("no {path}"))
}
