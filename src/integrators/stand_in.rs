//! Integrators that are not modeled, rendered by `path` or `bdpt` in their place.

use super::kinds::STAND_INS;
use super::{Bdpt, IntegratorSpec, NAMES, Path};
use crate::params::{Dialect, ParamReader};

/// What renders in the place of an integrator, whether only pbrt-v2 has that, and which light it finds.
pub(super) struct StandIn(pub &'static str, pub bool, pub Finds);

/// Which light an integrator finds, compared with the one that renders.
#[derive(PartialEq)]
pub(super) enum Finds {
    /// More: it traces paths from the light sources. See [`LightTracer`].
    Caustics,
    /// The same, with bias.
    Same,
    /// A few spherical harmonics of it.
    Harmonics,
}

/// The name of the type that the reader is at, and its stand-in; `None` for an unknown type.
fn find(reader: &ParamReader) -> Option<&'static (&'static str, StandIn)> {
    let v2 = reader.dialect() == Dialect::V2;
    let known = |(name, stand_in): &&(&str, StandIn)| *name == reader.kind() && (v2 || !stand_in.1);
    STAND_INS.iter().find(known)
}

/// Reads an integrator that is not modeled, as the one that renders in its place; an unknown one, which is an error, as
/// `path`. What a [`LightTracer`] finds in addition depends on the world and is reported when that is known.
pub(super) fn from_params(reader: &ParamReader) -> IntegratorSpec {
    let Some((name, StandIn(by, _, finds))) = find(reader) else {
        reader.unknown_kind(NAMES);
        return IntegratorSpec::Path(Path::from_params(reader));
    };
    match finds {
        Finds::Caustics => {}
        Finds::Same => reader.note(format!(
            "`{name}` is rendered by `{by}`, which has none of its bias"
        )),
        Finds::Harmonics => reader.warn(
            "",
            format!(
                "`{name}` shows a few spherical harmonics of the light; `path` shows all of it"
            ),
        ),
    }
    for parameter in WITHOUT_EFFECT {
        reader.accept(parameter);
    }
    let path = Path::from_params(reader);
    match *by {
        "bdpt" => IntegratorSpec::Bdpt(Bdpt::from(path)),
        _ => IntegratorSpec::Path(path),
    }
}

/// An integrator that traces paths from the light sources, in whose place another renders.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LightTracer {
    /// Its name in the scene file.
    pub name: &'static str,
    /// The name of the one that renders.
    pub stand_in: &'static str,
}

impl LightTracer {
    pub(super) fn from_params(reader: &ParamReader) -> Option<LightTracer> {
        let (name, StandIn(stand_in, _, finds)) = find(reader)?;
        (*finds == Finds::Caustics).then_some(LightTracer { name, stand_in })
    }
}

/// Parameters of these integrators that do not affect the image.
const WITHOUT_EFFECT: &[&str] = &[
    "bootstrapsamples",
    "chains",
    "mutationsperpixel",
    "largestepprobability",
    "sigma",
    "visualizestrategies",
    "visualizeweights",
    "nsamples",
    "cossample",
    "causticphotons",
    "indirectphotons",
    "nused",
    "maxdist",
    "finalgather",
    "finalgathersamples",
    "gatherangle",
    "maxspeculardepth",
    "maxphotondepth",
    "nsets",
    "nlights",
    "rrthreshold",
    "mindist",
    "maxerror",
    "minweight",
    "minpixelspacing",
    "maxpixelspacing",
    "minsamples",
    "maxangledifference",
    "interpolate",
];
