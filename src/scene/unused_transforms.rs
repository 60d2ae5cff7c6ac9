//! Transformations before the world block that nothing uses. A camera takes the transformation in force at its own
//! directive, and `WorldBegin` resets it; without a `Camera`, pbrt-v3 looks from the origin along z
//! (docs/scene-language.md §2.3).

use super::interpreter::Interpreter;
use super::transforms::Ctm;
use crate::syntax::{Diagnostic, DirectiveKind, Span};

/// The first transformation since the last directive that used one.
#[derive(Debug, Default)]
pub(super) struct UnusedTransform(Option<(&'static str, Span)>);

impl UnusedTransform {
    /// Records a directive of the options block.
    pub(super) fn note(&mut self, kind: &DirectiveKind, span: Span) {
        use DirectiveKind as D;
        match kind {
            D::Translate(_)
            | D::Scale(_)
            | D::Rotate { .. }
            | D::LookAt { .. }
            | D::Transform(_)
            | D::ConcatTransform(_)
            | D::CoordSysTransform(_) => {
                self.0.get_or_insert((kind.word(), span));
            }
            D::Identity | D::Camera(_) | D::CoordinateSystem(_) | D::MakeNamedMedium(_) => {
                self.0 = None;
            }
            _ => {}
        }
    }
}

impl Interpreter<'_> {
    /// Warns, at the start of the world, about transformations without effect.
    pub(super) fn check_transforms(&mut self) {
        let UnusedTransform(unused) = std::mem::take(&mut self.unused_transform);
        let Some((word, span)) = unused else { return };
        if self.current.ctm == Ctm::IDENTITY {
            return;
        }
        let (reason, help) = match self.options.camera {
            None => (
                "no `Camera` follows it before `WorldBegin`",
                "a transformation places the camera that is described after it: add for example \
                 `Camera \"perspective\"`",
            ),
            Some(_) => (
                "it stands after the `Camera`",
                "a transformation places the camera that is described after it",
            ),
        };
        let message = format!("`{word}` has no effect: {reason}");
        self.diagnostics
            .push(Diagnostic::warning(message).at(span).with_help(help));
    }
}

#[cfg(test)]
mod tests {
    use crate::scene::{ReadSettings, read_scene};
    use crate::syntax::SourceMap;

    /// The warnings for an options block.
    fn warnings(options: &str) -> Vec<String> {
        let sources = SourceMap::new();
        let text = format!("{options} WorldBegin LightSource \"point\" WorldEnd");
        let main = sources.add_text("test.pbrt", text);
        let (_, diagnostics) = read_scene(&sources, main, &ReadSettings::default());
        let kept = diagnostics.kept().into_iter();
        kept.map(|found| {
            assert!(found.span.is_some());
            found.message
        })
        .collect()
    }

    #[test]
    fn a_transformation_without_a_camera_after_it_is_told() {
        const LOOK: &str = "LookAt 0 0 5  0 0 0  0 1 0";
        const CAMERA: &str = "Camera \"perspective\"";
        let alone = "`LookAt` has no effect: no `Camera` follows it before `WorldBegin`";
        assert_eq!(warnings(&format!("{LOOK} Scale -1 1 1")), [alone]);
        let late = "`LookAt` has no effect: it stands after the `Camera`";
        assert_eq!(warnings(&format!("{CAMERA} {LOOK}")), [late]);
        let used = [
            format!("Scale -1 1 1 {LOOK} {CAMERA}"),
            format!("{CAMERA} Rotate 90 1 0 0 CoordinateSystem \"up\""),
            format!("{CAMERA} Translate 1 0 0 Identity"),
            format!("{CAMERA} Transform [1 0 0 0  0 1 0 0  0 0 1 0  0 0 0 1]"),
            format!("{CAMERA} Scale 2 2 2 MakeNamedMedium \"m\" \"string type\" \"homogeneous\""),
            String::new(),
        ];
        for options in used {
            assert_eq!(warnings(&options), [""; 0], "{options}");
        }
    }

    /// Each frame of a file has its own.
    #[test]
    fn what_a_frame_used_does_not_count_for_the_next() {
        let first =
            "Translate 0 0 5 Camera \"perspective\" WorldBegin LightSource \"point\" WorldEnd";
        assert_eq!(warnings(first).len(), 0);
        assert_eq!(warnings(&format!("{first} Translate 0 0 5")).len(), 1);
    }
}
