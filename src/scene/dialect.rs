//! Detects which pbrt version a file was written for (docs/scene-language.md §A).

use crate::params::Dialect;
use crate::syntax::DirectiveKind;

/// The dialect requested on the command line.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum DialectChoice {
    /// Decide from the file.
    #[default]
    Auto,
    /// As requested.
    Fixed(Dialect),
}

/// A reason to read a file as pbrt-v2.
pub const INCLUDE_IN_LIST: &str =
    "it has an `Include` among parameters, which only pbrt-v2 follows";

/// Samplers that pbrt-v3 does not have (docs/scene-language.md §A.2).
const V2_SAMPLERS: [&str; 2] = ["adaptive", "bestcandidate"];

/// The evidence found so far.
#[derive(Clone, Debug, Default)]
pub struct Evidence {
    /// The first directive that only pbrt-v2 has.
    pub v2_directive: Option<&'static str>,
    /// The first sampler that only pbrt-v2 has.
    pub v2_sampler: Option<&'static str>,
    /// `true` if a camera in the course's form was given.
    pub course_camera: bool,
    /// `true` if an `Integrator` directive, which only v3 has, was given.
    pub v3_integrator: bool,
    /// An `Include` among parameters that continue in its file, which only pbrt-v2 follows.
    pub include_in_list: bool,
}

impl Evidence {
    /// Examines a directive of the options block.
    pub fn note(&mut self, kind: &DirectiveKind) {
        if matches!(kind, DirectiveKind::Integrator(_)) {
            self.v3_integrator = true;
        }
        if let DirectiveKind::Sampler(sampler) = kind {
            let known = V2_SAMPLERS
                .into_iter()
                .find(|name| *name == sampler.kind.text);
            self.v2_sampler = self.v2_sampler.or(known);
        }
        if is_v2_only(kind) {
            self.v2_directive = self.v2_directive.or(Some(kind.word()));
        }
    }

    /// The dialect, with the reason if it is pbrt-v2.
    pub fn verdict(&self) -> (Dialect, Option<String>) {
        if let Some(word) = self.v2_directive {
            let reason = format!("it uses `{word}`, which only pbrt-v2 has");
            return (Dialect::V2, Some(reason));
        }
        if let Some(name) = self.v2_sampler.filter(|_| !self.v3_integrator) {
            let reason =
                format!("it has the sampler `{name}`, which only pbrt-v2 has, and no `Integrator`");
            return (Dialect::V2, Some(reason));
        }
        if self.course_camera && !self.v3_integrator {
            let reason = "it has a course-form realistic camera and no `Integrator`";
            return (Dialect::V2, Some(reason.to_string()));
        }
        if self.include_in_list && !self.v3_integrator {
            return (Dialect::V2, Some(INCLUDE_IN_LIST.to_string()));
        }
        (Dialect::V3, None)
    }
}

/// Returns `true` for a directive that pbrt-v3 does not have.
pub fn is_v2_only(kind: &DirectiveKind) -> bool {
    use DirectiveKind as D;
    matches!(
        kind,
        D::SurfaceIntegrator(_) | D::VolumeIntegrator(_) | D::Renderer(_) | D::Volume(_)
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::syntax::{Diagnostics, Parser, SourceMap};

    #[test]
    fn a_sampler_of_v2_without_a_v3_integrator_is_v2() {
        let verdict = |text: &str| {
            let (sources, diagnostics) = (SourceMap::new(), Diagnostics::new());
            let file = sources.add_text("a.pbrt", text.to_string());
            let mut evidence = Evidence::default();
            for directive in Parser::new(&sources, file, &diagnostics) {
                evidence.note(&directive.kind);
            }
            evidence.verdict()
        };
        for name in V2_SAMPLERS {
            let sampler = format!("Sampler \"{name}\"\n");
            let (dialect, reason) = verdict(&sampler);
            assert_eq!(dialect, Dialect::V2);
            assert!(reason.is_some_and(|reason| reason.contains(name)));
            let v3 = verdict(&(sampler + "Integrator \"path\""));
            assert_eq!(v3, (Dialect::V3, None));
        }
        assert_eq!(verdict("Sampler \"random\"").0, Dialect::V3);
    }

    #[test]
    fn course_camera_with_a_v3_integrator_is_v3() {
        let evidence = Evidence {
            course_camera: true,
            v3_integrator: true,
            ..Evidence::default()
        };
        assert_eq!(evidence.verdict().0, Dialect::V3);
        let evidence = Evidence {
            course_camera: true,
            ..Evidence::default()
        };
        assert_eq!(evidence.verdict().0, Dialect::V2);
        let evidence = Evidence {
            include_in_list: true,
            ..Evidence::default()
        };
        assert_eq!(evidence.verdict().0, Dialect::V2);
        let evidence = Evidence {
            include_in_list: true,
            v3_integrator: true,
            ..Evidence::default()
        };
        assert_eq!(evidence.verdict().0, Dialect::V3);
        let evidence = Evidence {
            v2_directive: Some("Renderer"),
            v3_integrator: true,
            ..Evidence::default()
        };
        assert_eq!(evidence.verdict().0, Dialect::V2);
    }
}
