//! Lenses of optiland, saved as JSON (`save_optiland_file`).
//!
//! `surface_group.surfaces` from the object to the film, with `thickness` or the place `cs.z` of their vertices, `geometry` of type Plane,
//! StandardGeometry or EvenAsphere (`radius`, `conic`, `coefficients` of r², r⁴, …), `material_post` of type IdealMaterial (`index`), AbbeMaterial (`index`,
//! `abbe`) or a named one (`name`), `is_stop` and a round `aperture`; `aperture`, `fields` and `wavelengths` of the whole say what is left open. What the tracer
//! cannot do is an error that names its surface.

use super::design::light::{Beam, Field, FieldKind};
use super::design::{Aperture, Design, DesignSurface, Medium, asphere_term};
use super::glass::Glasses;
use super::json::{note, unreadable};
use super::{Prescription, PrescriptionError};
use serde_json::Value;

/// Returns `true` if this is such a lens.
pub(super) fn is_file(text: &str) -> bool {
    text.contains("\"surface_group\"")
}

/// Reads the text of a file, with the glasses that it may name.
pub fn parse(text: &str, glasses: &Glasses) -> Result<Prescription, PrescriptionError> {
    let value: Value =
        serde_json::from_str(&without_infinities(text)).map_err(|e| unreadable(&e))?;
    let surfaces = value["surface_group"]["surfaces"].as_array();
    let Some([object, between @ .., film]) = surfaces.map(Vec::as_slice) else {
        return Err(PrescriptionError::Empty);
    };
    let mut design = Design {
        unit: 1.0,
        ..Design::default()
    };
    for (i, (entry, next)) in between
        .iter()
        .zip(between.iter().skip(1).chain([film]))
        .enumerate()
    {
        match surface(i + 1, entry, next, glasses) {
            Ok(surface) => design.surfaces.push(surface),
            Err(message) => {
                let message = format!("surface {}: {message}", i + 1);
                design.notes.errors.push(note(i + 1, message));
            }
        }
    }
    if let (Some(o), Some(first)) = (vertex(object), between.first().and_then(vertex)) {
        design.light.object_distance = first - o;
    }
    match medium(&object["material_post"], glasses) {
        _ if object["material_post"].is_null() => {}
        Ok(medium) => design.object_medium = medium,
        Err(message) => design
            .notes
            .errors
            .push(note(0, format!("the object: {message}"))),
    }
    let radius = film["geometry"]["radius"].as_f64();
    design.film_curvature = radius.filter(|r| *r != 0.0).map_or(0.0, f64::recip);
    light(&value, &mut design);
    design.prescription()
}

/// Python writes what is not finite as words that JSON lacks: null instead of them.
fn without_infinities(text: &str) -> String {
    let mut found = String::with_capacity(text.len());
    let mut in_text = false;
    let mut rest = text;
    while let Some(i) = rest.find(['"', '\\', 'I', 'N', '-']) {
        found.push_str(&rest[..i]);
        rest = &rest[i..];
        let word = ["-Infinity", "Infinity", "NaN"]
            .into_iter()
            .find(|w| rest.starts_with(w));
        let taken = match (in_text, word) {
            (false, Some(word)) => {
                found.push_str("null");
                word.len()
            }
            // What is escaped ends no text.
            (true, _) if rest.starts_with('\\') => {
                1 + rest[1..].chars().next().map_or(0, char::len_utf8)
            }
            _ => {
                in_text ^= rest.starts_with('"');
                1
            }
        };
        if in_text || word.is_none() || taken == 1 {
            found.push_str(&rest[..taken]);
        }
        rest = &rest[taken..];
    }
    found.push_str(rest);
    found
}

/// Where its vertex lies; `None` at infinity.
fn vertex(entry: &Value) -> Option<f64> {
    entry["geometry"]["cs"]["z"].as_f64()
}

fn surface(
    row: usize,
    entry: &Value,
    next: &Value,
    glasses: &Glasses,
) -> Result<DesignSurface, String> {
    let geometry = &entry["geometry"];
    let mut surface = DesignSurface {
        line: 1,
        row,
        is_stop: entry["is_stop"].as_bool().unwrap_or(false),
        ..DesignSurface::default()
    };
    for axis in ["x", "y", "rx", "ry", "rz"] {
        if geometry["cs"][axis].as_f64().is_some_and(|x| x != 0.0) {
            return Err(format!("it is tilted or decentered ({axis})"));
        }
    }
    let kind = geometry["type"].as_str().unwrap_or("");
    if !matches!(kind, "Plane" | "StandardGeometry" | "EvenAsphere") {
        return Err(format!(
            "a geometry of type {kind:.40} cannot be traced; expected Plane, StandardGeometry or EvenAsphere"
        ));
    }
    // null is infinite.
    surface.set_radius(geometry["radius"].as_f64().unwrap_or(f64::INFINITY));
    surface.asphere.conic = geometry["conic"].as_f64().unwrap_or(0.0);
    if kind == "EvenAsphere" {
        for (i, c) in geometry["coefficients"]
            .as_array()
            .into_iter()
            .flatten()
            .enumerate()
        {
            let c = c.as_f64().ok_or("a coefficient that is no number")?;
            asphere_term(&mut surface, 2 * (i + 1), c)?;
        }
    }
    let between = vertex(next).zip(vertex(entry)).map(|(b, a)| b - a);
    // Rays are traced by the places of vertices, from which a thickness follows to their last digit; it may be of an earlier state of the lens.
    let thickness = match (entry["thickness"].as_f64(), between) {
        (Some(thickness), Some(between))
            if (thickness - between).abs() > 1e-9 * (1.0 + between.abs()) =>
        {
            Some(between)
        }
        (thickness, between) => thickness.or(between),
    };
    surface.thickness = thickness.ok_or("expected a finite thickness")?;
    let model = entry["interaction_model"]["type"].as_str();
    if let Some(other) = model.filter(|model| *model != "RefractiveReflectiveModel") {
        return Err(format!(
            "an interaction of type {other:.40} cannot be traced"
        ));
    }
    if entry["interaction_model"]["is_reflective"].as_bool() == Some(true)
        || entry["is_reflective"].as_bool() == Some(true)
    {
        return Err("mirrors cannot be traced".to_string());
    }
    surface.medium = medium(&entry["material_post"], glasses)?;
    let aperture = &entry["aperture"];
    if !aperture.is_null() {
        let radii = ["r_max", "r_min"].map(|name| aperture[name].as_f64());
        surface.aperture = match radii {
            [Some(radius), None | Some(0.0)] => Aperture::Radius(radius),
            _ => return Err("only apertures that are whole circles can be traced".to_string()),
        };
    }
    Ok(surface)
}

fn medium(material: &Value, glasses: &Glasses) -> Result<Medium, String> {
    // The index may be an array of one number.
    let number = |name: &str| {
        let value = &material[name];
        value.as_f64().or(value[0].as_f64())
    };
    match material["type"].as_str().unwrap_or("") {
        "IdealMaterial" => match number("index") {
            Some(1.0) => Ok(Medium::default()),
            index => Medium::model("", index.ok_or("a material without an index")?, 0.0),
        },
        "AbbeMaterial" => {
            let index = number("index").ok_or("a material without an index")?;
            Medium::model("", index, number("abbe").unwrap_or(0.0))
        }
        kind => match material["name"].as_str() {
            Some(name) => Medium::named(name, glasses),
            None => Err(format!("a material of type {kind:.40} without a name")),
        },
    }
}

/// Beam, fields and the primary wavelength.
fn light(value: &Value, design: &mut Design) {
    let light = &mut design.light;
    let aperture = &value["aperture"];
    if let Some(x) = aperture["value"].as_f64() {
        light.beam = match aperture["type"].as_str().unwrap_or("") {
            "EPD" => Beam::EntrancePupil(x),
            "imageFNO" | "paraxialImageFNO" => Beam::FNumber(x),
            "imageNA" => Beam::FNumber(0.5 / x),
            "objectNA" => Beam::ObjectAperture(x),
            _ => Beam::Stop,
        };
        if aperture["type"] == "float_by_stop_size"
            && let Some(stop) = design.surfaces.iter_mut().find(|s| s.is_stop)
        {
            stop.semi_diameter = 0.5 * x;
        }
    }
    let fields = &value["fields"];
    let definition = &fields["field_definition"]["field_type"];
    let kind = definition
        .as_str()
        .or(fields["field_type"].as_str())
        .unwrap_or("");
    light.kind = match kind.to_ascii_lowercase() {
        kind if kind.contains("image") => FieldKind::ImageHeight,
        kind if kind.contains("object") => FieldKind::ObjectHeight,
        _ => FieldKind::Angle,
    };
    for field in fields["fields"].as_array().into_iter().flatten() {
        let [x, y, compression] = ["x", "y", "vy"].map(|name| field[name].as_f64().unwrap_or(0.0));
        light.fields.push(Field {
            height: x.hypot(y).copysign(y),
            through: [compression - 1.0, 1.0 - compression],
        });
    }
    let all = value["wavelengths"]["wavelengths"].as_array();
    let primary = all.into_iter().flatten().find(|w| w["is_primary"] == true);
    design.wavelength = primary.and_then(|w| {
        let unit = if w["unit"] == "nm" { 1e-3 } else { 1.0 };
        Some((1, w["value"].as_f64()? * unit))
    });
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn infinities_become_null_outside_of_texts() {
        for (text, expected) in [
            (
                r#"{"a": Infinity, "b": -Infinity, "NaN": [NaN, -1, 1e-5]}"#,
                r#"{"a": null, "b": null, "NaN": [null, -1, 1e-5]}"#,
            ),
            (
                r#"{"In \" Infinity\\": Infinity}"#,
                r#"{"In \" Infinity\\": null}"#,
            ),
            ("\"é\\é Infinity", "\"é\\é Infinity"),
            ("-", "-"),
        ] {
            assert_eq!(without_infinities(text), expected);
        }
    }
}
