//! Caustics and other light that no path from the camera can find: from lights without area, through smooth glass or
//! off mirrors (Veach 1997, §8.3.2: the paths that only light tracing samples).

use crate::integrators::LightTracer;
use crate::materials::Material;
use crate::scene::Frame;
use crate::syntax::{Diagnostic, Diagnostics};

const GIVE_AREA: &str =
    "an `AreaLightSource` on a small shape instead of the light is found, with some noise";

/// Reports the substitute for an integrator that traces light: a warning if that loses light, otherwise a note.
pub(super) fn warn(frame: &Frame, diagnostics: &Diagnostics) {
    let integrator = &frame.options.integrator;
    let Some(LightTracer { name, stand_in }) = integrator.light_tracer else {
        return;
    };
    let diagnostic = match lost_light(frame) {
        None => Diagnostic::note(format!(
            "`{name}` is rendered by `{stand_in}`, which has none of its bias"
        )),
        Some(light) => Diagnostic::warning(format!(
            "`{name}` is rendered by `{stand_in}`, which cannot find {light}: the image lacks it"
        ))
        .with_help(GIVE_AREA),
    };
    diagnostics.push(placed(diagnostic, frame));
}

/// Notes the same for integrators that lose this light in pbrt-v3 too.
pub(super) fn note(frame: &Frame, diagnostics: &Diagnostics) {
    if frame.options.integrator.light_tracer.is_some() {
        return;
    }
    if let Some(light) = lost_light(frame) {
        let message = format!("the image lacks {light}, as pbrt-v3's does with this integrator");
        let help = match frame.options.integrator.spec.traces_light() {
            true => GIVE_AREA.to_string(),
            false => format!("`bdpt` finds it; under `path` or `volpath` {GIVE_AREA}"),
        };
        diagnostics.push(placed(Diagnostic::note(message).with_help(help), frame));
    }
}

fn placed(diagnostic: Diagnostic, frame: &Frame) -> Diagnostic {
    Diagnostic {
        span: frame.options.integrator.place,
        ..diagnostic
    }
}

/// Describes the light that is not found; `None` if there is none.
fn lost_light(frame: &Frame) -> Option<String> {
    let spec = &frame.options.integrator.spec;
    // One bounce at the smooth surface, one at the surface it lights, and one where that is seen.
    let bidirectional = spec.traces_light();
    let deep = spec.max_depth()? >= 2 + u32::from(bidirectional);
    let lights = names(frame.lights.iter().filter_map(|light| light.delta_name()));
    if !deep || lights.is_empty() {
        return None;
    }
    let mut used = vec![false; frame.materials.len()];
    let objects = frame.instances.iter();
    let instanced = objects.filter_map(|instance| frame.objects.get(instance.object.index()));
    let shapes = instanced.flat_map(|object| &object.shapes);
    for id in frame.shapes.iter().chain(shapes).filter_map(|s| s.material) {
        used[id.index()] = true;
    }
    let all = frame.materials.iter();
    let materials: Vec<&Material> = all
        .zip(used)
        .filter_map(|(m, used)| used.then_some(m))
        .collect();
    let smooth = materials.iter().filter(|m| m.is_smooth(&frame.materials));
    let smooth = names(smooth.map(|material| material.name()));
    let media = &frame.media;
    let media = media.camera.is_some() || !media.interfaces.is_empty();
    let receives = media || materials.iter().any(|material| material.scatters_widely());
    (receives && !smooth.is_empty()).then(|| {
        let (lights, smooth) = (listed(&lights), listed(&smooth));
        let light = format!("the light of {lights} lights off or through {smooth}");
        match bidirectional {
            true => format!("{light} where it is seen off or through them again"),
            false => light,
        }
    })
}

/// Each name once, in order of appearance.
fn names<S: Into<String>>(all: impl Iterator<Item = S>) -> Vec<String> {
    let mut names: Vec<String> = Vec::new();
    for name in all.map(Into::into) {
        if !names.contains(&name) {
            names.push(name);
        }
    }
    names
}

/// Formats a list as `a`, `b` and `c`, in backticks.
fn listed(names: &[String]) -> String {
    let quoted: Vec<String> = names.iter().map(|name| format!("`{name}`")).collect();
    match quoted.split_last() {
        Some((last, rest)) if !rest.is_empty() => format!("{} and {last}", rest.join(", ")),
        _ => quoted.concat(),
    }
}

#[cfg(test)]
mod tests {
    use crate::scene::{ReadSettings, read_scene};
    use crate::syntax::{Diagnostics, SourceMap, diagnostic::Severity};

    const SPOT: &str = "LightSource \"spot\" ";
    const FLOOR: &str = "Material \"matte\" Shape \"disk\" ";
    const GLASS: &str = "Material \"glass\" Shape \"sphere\" ";

    /// The diagnostics of `check` about light paths: severity and message.
    fn said(integrator: &str, world: &str) -> Vec<(Severity, String)> {
        let sources = SourceMap::new();
        let text = format!("{integrator} WorldBegin {world} WorldEnd");
        let main = sources.add_text("test.pbrt", text);
        let (scene, read) = read_scene(&sources, main, &ReadSettings::default());
        assert!(
            !read.has_errors(),
            "{}",
            read.render(&sources, crate::syntax::Style::Plain)
        );
        let diagnostics = Diagnostics::new();
        super::note(&scene.frames[0], &diagnostics);
        super::warn(&scene.frames[0], &diagnostics);
        for found in diagnostics.kept() {
            assert_eq!(found.span.is_some(), integrator.contains("Integrator"));
        }
        let kept = diagnostics.kept().into_iter();
        kept.map(|found| (found.severity, found.message)).collect()
    }

    fn severity(integrator: &str, world: &str) -> Option<Severity> {
        let said = said(&format!("Integrator \"{integrator}\""), world);
        assert!(said.len() <= 1, "{said:?}");
        said.first().map(|(severity, _)| *severity)
    }

    #[test]
    fn light_tracers_warn_where_light_is_lost_and_only_there() {
        use Severity::{Note, Warning};
        let emitter = "AttributeBegin AreaLightSource \"diffuse\" Shape \"sphere\" AttributeEnd ";
        let sky = "LightSource \"infinite\" ";
        for name in ["bdpt", "mlt", "sppm"] {
            let of = |world: &[&str]| severity(name, &world.concat());
            assert_eq!(of(&[SPOT, FLOOR, GLASS]), Some(Warning), "{name}");
            assert_eq!(of(&[emitter, sky, FLOOR, GLASS]), Some(Note));
            assert_eq!(of(&[SPOT, FLOOR]), Some(Note));
            // There is nothing for the light to fall on.
            assert_eq!(of(&[SPOT, GLASS]), Some(Note));
            // The material is defined, but no shape uses it.
            assert_eq!(of(&[SPOT, FLOOR, "Material \"mirror\" "]), Some(Note));
            let object = format!("ObjectBegin \"o\" {GLASS} ObjectEnd ");
            assert_eq!(of(&[SPOT, &object, FLOOR]), Some(Note));
            let placed = format!("{object} ObjectInstance \"o\" ");
            assert_eq!(of(&[SPOT, &placed, FLOOR]), Some(Warning));
        }
        let shallow = "bdpt\" \"integer maxdepth\" [1] \"string lightsamplestrategy\" \"power";
        assert_eq!(
            severity(shallow, &[SPOT, FLOOR, GLASS].concat()),
            Some(Note)
        );
    }

    #[test]
    fn every_light_without_area_counts_that_shines() {
        for light in ["point", "spot", "distant", "goniometric", "projection"] {
            let world = |rest: &str| format!("LightSource \"{light}\" {rest} {FLOOR}{GLASS}");
            assert_eq!(
                severity("bdpt", &world("")),
                Some(Severity::Warning),
                "{light}"
            );
            let black = world("\"rgb scale\" [0 0 0]");
            assert_eq!(severity("bdpt", &black), Some(Severity::Note), "{light}");
        }
    }

    #[test]
    fn a_material_is_smooth_where_a_part_of_it_is() {
        let rough = "\"float uroughness\" [.1] \"float vroughness\" [.1]";
        let mix = |second: &str| {
            format!(
                "MakeNamedMaterial \"a\" \"string type\" \"matte\" MakeNamedMaterial \"b\" {second} \
                 Material \"mix\" \"string namedmaterial1\" \"a\" \"string namedmaterial2\" \"b\""
            )
        };
        for (material, smooth) in [
            ("Material \"mirror\"".to_string(), true),
            ("Material \"mirror\" \"rgb Kr\" [0 0 0]".to_string(), false),
            (format!("Material \"glass\" {rough}"), false),
            (
                format!("Material \"glass\" {rough} \"float eta\" [1]"),
                true,
            ),
            ("Material \"uber\"".to_string(), false),
            ("Material \"uber\" \"rgb Kr\" [.1 .1 .1]".to_string(), true),
            ("Material \"uber\" \"rgb Kt\" [.1 .1 .1]".to_string(), true),
            (
                "Material \"uber\" \"rgb opacity\" [.5 .5 .5]".to_string(),
                true,
            ),
            (
                "Material \"metal\" \"float roughness\" [0]".to_string(),
                false,
            ),
            (
                "Material \"plastic\" \"float roughness\" [0]".to_string(),
                false,
            ),
            ("Material \"translucent\"".to_string(), false),
            (
                "Material \"disney\" \"float spectrans\" [1]".to_string(),
                false,
            ),
            ("Material \"hair\"".to_string(), false),
            ("Material \"subsurface\"".to_string(), true),
            (format!("Material \"kdsubsurface\" {rough}"), false),
            (mix("\"string type\" \"glass\""), true),
            (mix("\"string type\" \"none\""), true),
            (mix("\"string type\" \"plastic\""), false),
            (
                mix("\"string type\" \"mirror\"") + " \"rgb amount\" [1 1 1]",
                false,
            ),
        ] {
            let world = format!("{SPOT}{FLOOR}{material} Shape \"sphere\"");
            let expected = match smooth {
                true => Severity::Warning,
                false => Severity::Note,
            };
            assert_eq!(severity("bdpt", &world), Some(expected), "{material}");
        }
    }

    /// pbrt-v3's `path` misses the same light.
    #[test]
    fn other_integrators_have_a_note() {
        let world = [SPOT, "LightSource \"point\" ", FLOOR, GLASS].concat();
        for name in ["path", "volpath", "directlighting", "whitted"] {
            assert_eq!(severity(name, &world), Some(Severity::Note), "{name}");
            assert_eq!(severity(name, &[SPOT, FLOOR].concat()), None);
        }
        assert_eq!(severity("ambientocclusion", &world), None);
        let [(_, message)] = &said("", &world)[..] else {
            panic!("one note")
        };
        let words = "the light of `spot` and `point` lights off or through `glass`";
        assert!(message.contains(words), "{message}");
    }
}
