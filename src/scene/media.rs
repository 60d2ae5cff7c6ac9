//! `MakeNamedMedium`, `MediumInterface` and pbrt-v2's `Volume`.
//!
//! The medium around a light does not matter: paths start at the camera, and keep track of their medium from there.

use super::graphics_state::InterfaceDirective;
use super::interpreter::Interpreter;
use super::materials::named_type;
use super::options::Options;
use crate::handles::{InterfaceId, MediumId};
use crate::media::{MediaSpec, MediumInterface, MediumSpec, VolumeSpec};
use crate::params::{Dialect, TextureNames};
use crate::syntax::{Diagnostic, Name, Span, Typed};
use std::cell::Cell;
use std::collections::HashMap;
use std::rc::Rc;

/// The media of a frame, from the options block on.
#[derive(Debug, Default)]
pub(super) struct NamedMedia {
    spec: MediaSpec,
    names: HashMap<String, MediumId>,
    interfaces: HashMap<MediumInterface, InterfaceId>,
    volumes: Vec<VolumeSpec>,
}

impl NamedMedia {
    /// Returns `true` if any of pbrt-v2's volumes emits.
    pub(super) fn shines(&self) -> bool {
        self.volumes.iter().any(VolumeSpec::shines)
    }
}

impl Interpreter<'_> {
    /// Handles `MakeNamedMedium "name"`, under the transformation at the start time.
    pub(super) fn make_named_medium(&mut self, span: Span, mut typed: Typed) {
        let name = typed.kind.clone();
        let Some(kind) = named_type(&typed.params) else {
            self.diagnostics.push(
                Diagnostic::error(format!(
                    "`MakeNamedMedium \"{}\"` needs one `string type`; ignored",
                    name.text
                ))
                .at(name.span)
                .recoverable()
                .with_help("add for example \"string type\" \"homogeneous\""),
            );
            return;
        };
        typed.kind = kind;
        if self.current.ctm.is_animated() {
            self.warn(
                name.span,
                "a moving medium is held at its start, as in pbrt-v3",
            );
        }
        let (names, ctm) = (TextureNames::default(), self.current.ctm.start);
        let medium = self
            .reading(&names)
            .read("MakeNamedMedium", span, &typed, |reader| {
                MediumSpec::from_params(reader, &ctm)
            });
        let Some(medium) = medium else { return };
        let NamedMedia { spec, names, .. } = &mut self.media;
        spec.media.push(medium);
        let id = MediumId(spec.media.len() as u32 - 1);
        if names.insert(name.text.clone(), id).is_some() {
            let message = format!(
                "medium `{}` is defined again; later uses see this one",
                name.text
            );
            self.warn(name.span, message);
        }
    }

    /// Handles `Volume "type"`, under the transformation at the start time. If the file is explicitly read as pbrt-v3
    /// it is ignored, as has been reported.
    pub(super) fn volume(&mut self, span: Span, typed: &Typed) {
        if self.dialect() == Dialect::V3 {
            return;
        }
        let (names, ctm) = (TextureNames::default(), self.current.ctm.start);
        let volume = self.reading(&names).read("Volume", span, typed, |reader| {
            VolumeSpec::from_params(reader, &ctm)
        });
        self.media.volumes.extend(volume);
    }

    /// Handles `MediumInterface "inside" "outside"`.
    pub(super) fn use_media(&mut self, inside: Name, outside: Name) {
        self.current.state.medium_interface = Some(Rc::new(InterfaceDirective {
            inside,
            outside,
            reported: Cell::new(false),
        }));
    }

    /// The current media, where light begins that a shape or a light source emits.
    pub(super) fn current_media(&self) -> MediumInterface {
        let directive = self.current.state.medium_interface.as_ref();
        directive.map_or_else(MediumInterface::default, |directive| {
            self.resolve(directive)
        })
    }

    /// The medium interface of a shape; `None` if both of its sides are the same.
    pub(super) fn interface_of_shape(&mut self) -> Option<InterfaceId> {
        let interface = self.current_media();
        if !interface.is_transition() {
            return None;
        }
        let NamedMedia {
            spec, interfaces, ..
        } = &mut self.media;
        let id = *interfaces.entry(interface).or_insert_with(|| {
            spec.interfaces.push(interface);
            InterfaceId(spec.interfaces.len() as u32 - 1)
        });
        Some(id)
    }

    /// Looks up the names. An undefined one is an error, reported once, and counts as vacuum.
    fn resolve(&self, directive: &InterfaceDirective) -> MediumInterface {
        let known = &self.media.names;
        let mut missing = Vec::new();
        let mut find = |name: &Name| {
            let found = known.get(&name.text).copied();
            if found.is_none() && !name.text.is_empty() {
                missing.push(name.clone());
            }
            found
        };
        let interface = MediumInterface {
            inside: find(&directive.inside),
            outside: find(&directive.outside),
        };
        // The same name on both sides is a single mistake.
        missing.dedup_by_key(|name| name.span);
        if !directive.reported.replace(true) {
            for name in missing {
                let message = format!("there is no medium `{}`; vacuum is used", name.text);
                let error = Diagnostic::error(message).at(name.span).recoverable();
                let known = known.keys().map(String::as_str);
                self.diagnostics.push_with_nearest(error, &name.text, known);
            }
        }
        interface
    }

    /// The frame's media, at its end. The camera is in the outside medium at that point, wherever its own directive was
    /// (docs/scene-language.md §2.3).
    pub(super) fn take_media(&mut self) -> MediaSpec {
        let directive = self.current.state.medium_interface.clone();
        let outside = directive.and_then(|directive| self.resolve(&directive).outside);
        let NamedMedia {
            mut spec, volumes, ..
        } = std::mem::take(&mut self.media);
        spec.camera = outside;
        // pbrt-v2 has no other media.
        if !volumes.is_empty() {
            spec.camera = Some(MediumId(spec.media.len() as u32));
            spec.media.push(MediumSpec::Volumes(volumes));
        }
        spec
    }

    /// Warns if there are media but the integrator ignores them.
    pub(super) fn check_media(&self, media: &MediaSpec, options: &Options) {
        let used = media.camera.is_some() || !media.interfaces.is_empty();
        if used && !options.integrator.spec.sees_media() {
            let message = "the integrator does not model participating media: they are ignored, \
                           as in pbrt-v3 (`volpath` models them)";
            let warning = Diagnostic::warning(message);
            self.diagnostics.push(match self.integrator_span() {
                Some(span) => warning.at(span),
                None => warning,
            });
        }
    }
}

#[cfg(test)]
mod tests {
    use crate::handles::MediumId;
    use crate::integrators::IntegratorSpec;
    use crate::lights::LightKind;
    use crate::media::MediumInterface;
    use crate::scene::description::Frame;
    use crate::scene::{ReadSettings, read_scene};
    use crate::syntax::SourceMap;

    const MEDIA: &str = "MakeNamedMedium \"a\" \"string type\" \"homogeneous\"
        MakeNamedMedium \"b\" \"string type\" \"homogeneous\" ";

    /// The frame, and the number of errors and warnings.
    fn frame(options: &str, world: &str) -> (Frame, usize, usize) {
        let sources = SourceMap::new();
        let text = format!(
            "Integrator \"volpath\" {MEDIA} {options} WorldBegin LightSource \"point\" {world} WorldEnd"
        );
        let main = sources.add_text("test.pbrt", text);
        let (mut scene, diagnostics) = read_scene(&sources, main, &ReadSettings::default());
        let frame = scene.frames.pop().expect("a frame");
        (frame, diagnostics.errors(), diagnostics.warnings())
    }

    /// Media inside and outside of each shape, if these differ.
    fn borders(frame: &Frame) -> Vec<Option<(Option<u32>, Option<u32>)>> {
        let number = |id: Option<MediumId>| id.map(|id| id.0);
        let of = |&MediumInterface { inside, outside }: &MediumInterface| {
            (number(inside), number(outside))
        };
        let shapes = frame.shapes.iter();
        shapes
            .map(|s| s.interface.map(|i| of(&frame.media.interfaces[i.index()])))
            .collect()
    }

    #[test]
    fn interfaces_follow_the_graphics_state() {
        let world = "Shape \"sphere\"
            AttributeBegin MediumInterface \"a\" \"\" Shape \"sphere\"
            AttributeBegin MediumInterface \"b\" \"a\" Shape \"sphere\" AttributeEnd
            Shape \"sphere\" MediumInterface \"b\" Shape \"sphere\" AttributeEnd
            Shape \"sphere\"";
        let (frame, errors, warnings) = frame("", world);
        assert_eq!((errors, warnings), (0, 0));
        let (a, b) = (Some(0), Some(1));
        let expected = [
            None,
            Some((a, None)),
            Some((b, a)),
            Some((a, None)),
            None,
            None,
        ];
        assert_eq!(borders(&frame), expected);
        assert_eq!(frame.media.interfaces.len(), 2, "the same border is one");
        assert_eq!(frame.media.camera, None);
    }

    /// docs/scene-language.md §2.3: settings of the options block persist, and the camera is created at `WorldEnd`.
    #[test]
    fn the_camera_is_in_what_is_outside_at_the_end() {
        let (outside, errors, _) = frame("MediumInterface \"\" \"b\"", "Shape \"sphere\"");
        assert_eq!((outside.media.camera, errors), (Some(MediumId(1)), 0));
        assert_eq!(borders(&outside), [Some((None, Some(1)))]);
        let world = "MediumInterface \"a\" \"a\" AttributeBegin MediumInterface \"b\" AttributeEnd";
        let (late, ..) = frame("MediumInterface \"\" \"b\"", world);
        assert_eq!(late.media.camera, Some(MediumId(0)));
    }

    #[test]
    fn unknown_names_are_said_once_and_are_vacuum() {
        let world = "MediumInterface \"aa\" \"b\" Shape \"sphere\" Shape \"sphere\"";
        let (frame, errors, _) = frame("", world);
        assert_eq!(errors, 1);
        assert_eq!(borders(&frame), [Some((None, Some(1))); 2]);
    }

    #[test]
    fn a_medium_may_be_defined_after_its_interface_and_again() {
        let world = "MediumInterface \"late\" \"\"
            MakeNamedMedium \"late\" \"string type\" \"homogeneous\" Shape \"sphere\"
            MakeNamedMedium \"late\" \"string type\" \"homogeneous\" Shape \"sphere\"";
        let (frame, errors, warnings) = frame("", world);
        assert_eq!((errors, warnings), (0, 1));
        assert_eq!(
            borders(&frame),
            [Some((Some(2), None)), Some((Some(3), None))]
        );
    }

    /// pbrt's `--quick`: a quarter of the lights' samples, at least one.
    #[test]
    fn a_quick_frame_takes_fewer_samples_of_lights() {
        let world = "LightSource \"infinite\" \"integer samples\" 16
            AreaLightSource \"diffuse\" \"integer samples\" 3 Shape \"sphere\"";
        let (mut frame, ..) = frame(
            "Integrator \"ambientocclusion\" \"integer nsamples\" 64",
            world,
        );
        frame.make_quick();
        let infinite = frame.lights.iter().find_map(|light| match &light.kind {
            LightKind::Infinite(infinite) => Some(infinite.samples),
            _ => None,
        });
        assert_eq!((infinite, frame.area_lights[0].samples), (Some(4), 1));
        assert!(matches!(
            &frame.options.integrator.spec,
            IntegratorSpec::AmbientOcclusion(ambient) if ambient.samples == 1
        ));
    }

    #[test]
    fn other_integrators_say_that_they_see_no_media() {
        let world = "MediumInterface \"a\" \"\" Shape \"sphere\"";
        let (_, errors, warnings) = frame("Integrator \"path\"", world);
        assert_eq!((errors, warnings), (0, 1));
        let (_, _, warnings) = frame("Integrator \"path\"", "Shape \"sphere\"");
        assert_eq!(warnings, 0);
    }
}
