//! Caustics and other light that no path from the camera can find: from lights without area, through smooth glass or
//! off mirrors (Veach 1997, §8.3.2: the paths that only light tracing samples).

use crate::cameras::Camera;
use crate::integrators::LightTracer;
use crate::materials::Material;
use crate::scene::Frame;
use crate::syntax::{Diagnostic, Diagnostics};

const NOT_JOINED: &str = "light paths are joined to `perspective`, `orthographic`, `environment` and `realistic` cameras, but not with \
     `thick` and `thin` lens models, `compat` \"pbrt-v2\", a projection among the camera's transformations, or `samplepixelcenter`";

const NO_GHOSTS: &str = "`sppm`, `ambientocclusion` and `samplepixelcenter` have none; the lens is as dark as its reflections make it";

const GIVE_AREA: &str =
    "an `AreaLightSource` on a small shape instead of the light is found, with some noise";

const SEND_PHOTONS: &str = "`Integrator \"sppm\"` finds it, a little blurred";

/// Reports the substitute for an integrator that traces light: a warning if that loses light, otherwise a note.
///
/// Another warning where paths are traced from the lights, but not joined to the camera.
pub(super) fn warn(frame: &Frame, camera: Option<&Camera>, diagnostics: &Diagnostics) {
    let integrator = &frame.options.integrator;
    let is_continuous = super::filter(&frame.options).is_continuous();
    if camera.is_some_and(Camera::has_ghosts)
        && !(is_continuous && integrator.spec.has_light_pass())
    {
        let warning = Diagnostic::warning("the image has no ghosts").with_help(NO_GHOSTS);
        diagnostics.push(placed(warning, frame));
    }
    let joined = camera.is_none_or(Camera::connects) && is_continuous;
    if integrator.spec.traces_light()
        && !joined
        && let Some(light) = lost_light(frame, false)
    {
        let message = format!("no light path comes to this camera: the image lacks {light}");
        let help = match has_media(frame) {
            true => NOT_JOINED.to_string(),
            false => format!("{NOT_JOINED}; {SEND_PHOTONS}, through any camera"),
        };
        diagnostics.push(placed(Diagnostic::warning(message).with_help(help), frame));
        return;
    }
    let Some(LightTracer { name, stand_in }) = integrator.light_tracer else {
        return;
    };
    let diagnostic = match lost_light(frame, integrator.spec.traces_light()) {
        None => Diagnostic::note(format!(
            "`{name}` is rendered by `{stand_in}`, which has none of its bias"
        )),
        Some(light) => Diagnostic::warning(format!(
            "`{name}` is rendered by `{stand_in}`, which cannot find {light}: the image lacks it"
        ))
        .with_help(instead(frame)),
    };
    diagnostics.push(placed(diagnostic, frame));
}

/// Notes the same for integrators that lose this light in pbrt-v3 too.
pub(super) fn note(frame: &Frame, diagnostics: &Diagnostics) {
    if frame.options.integrator.light_tracer.is_some() {
        return;
    }
    if frame.options.integrator.spec.gathers_photons() {
        return;
    }
    let bidirectional = frame.options.integrator.spec.traces_light();
    if let Some(light) = lost_light(frame, bidirectional) {
        let message = format!("the image lacks {light}, as pbrt-v3's does with this integrator");
        let help = match bidirectional {
            true => instead(frame),
            false => format!("`bdpt` finds it; under `path` or `volpath` {GIVE_AREA}"),
        };
        diagnostics.push(placed(Diagnostic::note(message).with_help(help), frame));
    }
}

/// What to write where paths from both ends do not find the light. Photons are not scattered by media.
fn instead(frame: &Frame) -> String {
    match has_media(frame) {
        true => GIVE_AREA.to_string(),
        false => format!("{SEND_PHOTONS}; {GIVE_AREA}"),
    }
}

fn has_media(frame: &Frame) -> bool {
    frame.media.camera.is_some() || !frame.media.interfaces.is_empty()
}

fn placed(diagnostic: Diagnostic, frame: &Frame) -> Diagnostic {
    Diagnostic {
        span: frame.options.integrator.place,
        ..diagnostic
    }
}

/// Describes the light that is not found, by paths from the camera or from both ends; `None` if there is none.
fn lost_light(frame: &Frame, bidirectional: bool) -> Option<String> {
    // One bounce at the smooth surface, one at the surface it lights, and one where that is seen.
    let most = frame.options.integrator.spec.max_depth()?;
    let deep = most >= 2 + u32::from(bidirectional);
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
    let receives = has_media(frame) || materials.iter().any(|material| material.scatters_widely());
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
    use crate::syntax::{Diagnostic, Diagnostics, SourceMap, diagnostic::Severity};

    const SPOT: &str = "LightSource \"spot\" ";
    const FLOOR: &str = "Material \"matte\" Shape \"disk\" ";
    const GLASS: &str = "Material \"glass\" Shape \"sphere\" ";

    /// The diagnostics of `check` about light paths: severity and message.
    fn said(integrator: &str, world: &str) -> Vec<(Severity, String)> {
        let found = diagnostics(integrator, world).into_iter();
        found.map(|found| (found.severity, found.message)).collect()
    }

    fn diagnostics(integrator: &str, world: &str) -> Vec<Diagnostic> {
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
        super::warn(&scene.frames[0], None, &diagnostics);
        for found in diagnostics.kept() {
            assert_eq!(found.span.is_some(), integrator.contains("Integrator"));
        }
        diagnostics.kept()
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
        for name in ["photonmap", "exphotonmap"] {
            let of = |world: &[&str]| {
                let said = said(&format!("SurfaceIntegrator \"{name}\""), &world.concat());
                assert_eq!(said.len(), 1, "{said:?}");
                said.first().map(|(severity, _)| *severity)
            };
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
    }

    /// Bidirectional paths find caustics, but not those that are seen in a mirror or through glass.
    #[test]
    fn bdpt_has_a_note_where_caustics_are_seen_by_caustics() {
        let world = [SPOT, FLOOR, GLASS].concat();
        for (depth, noted) in [(2, false), (3, true)] {
            let integrator = format!("Integrator \"bdpt\" \"integer maxdepth\" [{depth}]");
            let said = said(&integrator, &world);
            let of_them = said.iter().filter(|(_, words)| words.contains("again"));
            assert_eq!(of_them.count(), usize::from(noted), "{depth}: {said:?}");
        }
        assert_eq!(severity("bdpt", &[SPOT, FLOOR].concat()), None);
        assert_eq!(severity("mlt", &[SPOT, FLOOR].concat()), None);
    }

    /// Photons find what paths from both ends do not, through any camera, but not in media.
    #[test]
    fn sppm_is_named_where_it_finds_the_light() {
        let named = |settings: &str, world: &[&str]| {
            let found = diagnostics(settings, &world.concat());
            let helps = found.iter().flat_map(|found| &found.help);
            assert_eq!(found.len(), 1, "{found:?}");
            helps.filter(|help| help.contains("\"sppm\"")).count() == 1
        };
        let fog =
            "MakeNamedMedium \"fog\" \"string type\" \"homogeneous\" MediumInterface \"\" \"fog\" ";
        let centers = "Sampler \"halton\" \"bool samplepixelcenter\" \"true\" Integrator \"bdpt\" \"integer maxdepth\" [2]";
        for settings in [
            "Integrator \"bdpt\"",
            "SurfaceIntegrator \"photonmap\"",
            centers,
        ] {
            assert!(named(settings, &[SPOT, FLOOR, GLASS]), "{settings}");
            assert!(!named(settings, &[fog, SPOT, FLOOR, GLASS]), "{settings}");
        }
    }

    #[test]
    fn cameras_that_light_paths_do_not_reach_are_warned_of() {
        let world = [SPOT, FLOOR, GLASS].concat();
        let of = |rest: &str| said(&format!("{rest} Integrator \"bdpt\""), &world);
        let centers = "Sampler \"halton\" \"bool samplepixelcenter\" \"true\"";
        let warned = |said: &[(Severity, String)]| {
            said.iter().any(|(severity, words)| {
                *severity == Severity::Warning
                    && words.contains("no light path comes to this camera")
            })
        };
        assert!(warned(&of(centers)));
        assert!(!warned(&of("Sampler \"halton\"")));
    }

    /// Photons come from any light to any surface.
    #[test]
    fn no_light_is_lost_to_photons() {
        assert!(said("Integrator \"sppm\"", &[SPOT, FLOOR, GLASS].concat()).is_empty());
    }

    #[test]
    fn every_light_without_area_counts_that_shines() {
        for light in ["point", "spot", "distant", "goniometric", "projection"] {
            let world = |rest: &str| format!("LightSource \"{light}\" {rest} {FLOOR}{GLASS}");
            assert_eq!(
                severity("path", &world("")),
                Some(Severity::Note),
                "{light}"
            );
            let black = world("\"rgb scale\" [0 0 0]");
            assert_eq!(severity("path", &black), None, "{light}");
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
            let expected = smooth.then_some(Severity::Note);
            assert_eq!(severity("path", &world), expected, "{material}");
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
