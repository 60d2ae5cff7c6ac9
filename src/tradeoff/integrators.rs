//! Integrators that can take the place of a scene's own.

use crate::integrators::{Bdpt, IntegratorSpec, MediaSeen, Path, Sppm, VolPath};

/// The first disc of photon mapping, relative to the sphere around the scene: a few pixels where the image shows all of it.
const DISC: f32 = 0.01;

/// The value of `sppm` among the settings, which is a biased method.
pub(crate) const BIASED: &str = "sppm";

/// The other integrators that show light along whole paths, with the limits of the scene's own and the name that a scene
/// gives them. There are none for an integrator that shows part of the light on purpose. Photons are gathered from discs
/// relative to `radius`, that of the sphere around the scene (world units).
pub(super) fn others(own: &IntegratorSpec, radius: f32) -> Vec<(&'static str, IntegratorSpec)> {
    let Some((own, path)) = path_of(own) else {
        return Vec::new();
    };
    let max_depth = path.max_depth;
    let sppm = Sppm {
        max_depth,
        // Counts of samples are those of iterations.
        iterations: 1,
        photons: None,
        radius: first_disc(radius),
    };
    let bdpt = IntegratorSpec::Bdpt(Bdpt::from(path.clone()));
    let volpath = IntegratorSpec::VolPath(VolPath { path: path.clone() });
    let mut others = vec![
        ("path", IntegratorSpec::Path(path)),
        ("volpath", volpath),
        ("bdpt", bdpt),
        (BIASED, IntegratorSpec::Sppm(sppm)),
    ];
    // Without media `volpath` is `path`, and with them `path` is another image.
    let tracer = |name: &str| name == "path" || name == "volpath";
    others.retain(|(name, _)| *name != own && !(tracer(name) && tracer(own)));
    others
}

/// The name of an integrator and a path tracer with its limits.
fn path_of(spec: &IntegratorSpec) -> Option<(&'static str, Path)> {
    let limited = |max_depth| Path {
        max_depth,
        ..Path::default()
    };
    let (name, path) = match spec {
        IntegratorSpec::Path(path) => ("path", path.clone()),
        IntegratorSpec::VolPath(VolPath { path }) => ("volpath", path.clone()),
        IntegratorSpec::Bdpt(bdpt) => {
            let light_strategy = bdpt.light_strategy;
            let path = limited(bdpt.max_depth);
            (
                "bdpt",
                Path {
                    light_strategy,
                    ..path
                },
            )
        }
        IntegratorSpec::Sppm(sppm) => (BIASED, limited(sppm.max_depth)),
        _ => return None,
    };
    (!path.direct_only && path.media == MediaSeen::All).then_some((name, path))
}

/// The radius of photon mapping's first disc; that of pbrt-v3 for a scene without extent.
fn first_disc(radius: f32) -> f32 {
    let disc = DISC * radius;
    if disc.is_normal() { disc } else { 1.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names(own: &IntegratorSpec) -> Vec<&'static str> {
        others(own, 2.0).into_iter().map(|(name, _)| name).collect()
    }

    #[test]
    fn each_integrator_of_whole_paths_has_the_others() {
        let path = Path::default();
        let volpath = VolPath { path: path.clone() };
        let bdpt = IntegratorSpec::Bdpt(Bdpt::from(path.clone()));
        assert_eq!(names(&bdpt), ["path", "volpath", "sppm"]);
        assert_eq!(names(&IntegratorSpec::VolPath(volpath)), ["bdpt", "sppm"]);
        assert_eq!(names(&IntegratorSpec::Path(path.clone())), ["bdpt", "sppm"]);
        // One bounce on purpose: no other integrator shows that.
        let direct_only = true;
        let short = Path {
            direct_only,
            ..path
        };
        assert!(names(&IntegratorSpec::Path(short)).is_empty());
    }

    #[test]
    fn limits_are_kept_and_discs_fit_the_scene() {
        let max_depth = 17;
        let own = IntegratorSpec::Path(Path {
            max_depth,
            ..Path::default()
        });
        for (name, spec) in others(&own, 2.0) {
            assert_eq!(spec.max_depth(), Some(17), "{name}");
            if let IntegratorSpec::Sppm(sppm) = spec {
                assert_eq!(sppm.radius, 2.0 * DISC);
            }
        }
        for nonsense in [0.0, f32::INFINITY, f32::NAN] {
            assert_eq!(first_disc(nonsense), 1.0);
        }
    }
}
