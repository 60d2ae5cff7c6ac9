//! Light transport: from a camera ray to the radiance that arrives along it.
//!
//! One file per integrator, named as the scene file names it. What they share — direct light at a
//! surface, and the recursion over perfect mirrors and glass — is in [`direct`] and [`specular`].

mod ambientocclusion;
mod context;
mod differentials;
mod direct;
mod directlighting;
mod path;
mod specular;
mod subsurface;
mod vertex;
mod volpath;
mod whitted;
pub mod witness;

use crate::lights::{LightGroups, LightSelector};
use crate::math::Rgb;
use crate::math::ray::{Ray, RayDifferentials};
use crate::params::{Dialect, ParamReader};
use crate::samplers::SampleStream;
use crate::syntax::Span;
use crate::world::World;
use context::{Context, Lights};
use witness::Watch;

pub use ambientocclusion::AmbientOcclusion;
pub use directlighting::DirectLighting;
pub use path::{MediaSeen, Path};
pub use volpath::VolPath;
pub use whitted::Whitted;

/// More surfaces without material than this in a row end a path: such a pile is a modelling
/// error, and a ray that never gets anywhere would otherwise never return.
pub const MAX_NULL_SURFACES: u32 = 4096;

/// An integrator as the scene asks for it.
#[derive(Clone, Debug, PartialEq)]
pub enum IntegratorSpec {
    /// `Integrator "path"`, and what fstop renders in its place.
    Path(Path),
    /// `Integrator "volpath"`, and what fstop renders in its place.
    VolPath(VolPath),
    /// `Integrator "directlighting"`.
    DirectLighting(DirectLighting),
    /// `Integrator "whitted"`.
    Whitted(Whitted),
    /// `Integrator "ambientocclusion"`.
    AmbientOcclusion(AmbientOcclusion),
}

impl IntegratorSpec {
    /// Does it model participating media?
    pub fn sees_media(&self) -> bool {
        matches!(self, IntegratorSpec::VolPath(_))
    }

    /// The integrator that renders the same through pbrt-v2's volumes, of which `seen` is seen. `volpath` sees all of them
    /// as it is, `ambientocclusion` none.
    pub fn through_volumes(self, seen: MediaSeen) -> IntegratorSpec {
        let direct = |max_depth| Path {
            max_depth,
            direct_only: true,
            ..Path::default()
        };
        let path = match self {
            IntegratorSpec::Path(path) => path,
            IntegratorSpec::DirectLighting(integrator) => direct(integrator.max_depth),
            IntegratorSpec::Whitted(integrator) => direct(integrator.max_depth),
            other => return other,
        };
        IntegratorSpec::VolPath(VolPath {
            path: Path {
                media: seen,
                ..path
            },
        })
    }

    /// The most scattering events of a path; `None` for what does not show light.
    pub fn max_depth(&self) -> Option<u32> {
        match self {
            IntegratorSpec::Path(path) => Some(path.max_depth),
            IntegratorSpec::VolPath(volpath) => Some(volpath.path.max_depth),
            IntegratorSpec::DirectLighting(direct) => Some(direct.max_depth),
            IntegratorSpec::Whitted(whitted) => Some(whitted.max_depth),
            IntegratorSpec::AmbientOcclusion(_) => None,
        }
    }

    /// Does it follow light that wanders inside materials?
    pub fn looks_inside(&self) -> bool {
        match self {
            IntegratorSpec::Path(_) | IntegratorSpec::VolPath(_) => true,
            IntegratorSpec::DirectLighting(_)
            | IntegratorSpec::Whitted(_)
            | IntegratorSpec::AmbientOcclusion(_) => false,
        }
    }
}

/// Integrator and the pixels it is confined to.
#[derive(Clone, Debug, PartialEq)]
pub struct IntegratorSettings {
    /// Which one, with its parameters.
    pub spec: IntegratorSpec,
    /// `pixelbounds`: x0, x1, y0, y1; pixels outside are left black.
    pub pixel_bounds: Option<[i32; 4]>,
    /// Where the scene names it; `None` where it names none.
    pub place: Option<Span>,
    /// What the scene asks for, where that follows light from its sources and `spec` does not.
    pub light_tracer: Option<LightTracer>,
}

/// An integrator that finds light along paths from its sources, in whose place another renders.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LightTracer {
    /// Its name in the scene file.
    pub name: &'static str,
    /// The name of the one that renders.
    pub stand_in: &'static str,
    /// How its image differs, where no light is missing.
    pub difference: &'static str,
}

impl LightTracer {
    /// What is said of each; pbrt-v2's have names of their own.
    fn named(name: &str, dialect: Dialect) -> Option<LightTracer> {
        let (name, stand_in) = match (name, dialect) {
            // These two see media and let light through surfaces without material; `sppm` does not.
            ("bdpt", _) => ("bdpt", "volpath"),
            ("mlt", _) => ("mlt", "volpath"),
            ("sppm", _) => ("sppm", "path"),
            ("photonmap", Dialect::V2) => ("photonmap", "path"),
            ("exphotonmap", Dialect::V2) => ("exphotonmap", "path"),
            _ => return None,
        };
        Some(LightTracer {
            name,
            stand_in,
            difference: match stand_in {
                "volpath" => ": the same image, other noise",
                _ => ", which has none of its bias",
            },
        })
    }
}

/// Every integrator name a scene may use, for "did you mean".
pub const NAMES: &[&str] = &[
    "path",
    "volpath",
    "directlighting",
    "whitted",
    "ambientocclusion",
    "bdpt",
    "mlt",
    "sppm",
    "photonmap",
    "exphotonmap",
    "irradiancecache",
    "igi",
    "dipolesubsurface",
    "useprobes",
    "diffuseprt",
    "glossyprt",
];

impl IntegratorSettings {
    /// What a file without an integrator gets: `path` in v3, `directlighting` in v2.
    pub fn default_for(dialect: Dialect) -> IntegratorSettings {
        let spec = match dialect {
            Dialect::V2 => IntegratorSpec::DirectLighting(DirectLighting::default()),
            Dialect::V3 => IntegratorSpec::Path(Path::default()),
        };
        IntegratorSettings {
            spec,
            pixel_bounds: None,
            place: None,
            light_tracer: None,
        }
    }

    /// Reads an `Integrator` or `SurfaceIntegrator` directive. Those that are not modeled are rendered by
    /// `path` or `volpath`; what is to be said of a [`LightTracer`] depends on the world.
    pub fn from_params(reader: &ParamReader) -> IntegratorSettings {
        let spec = match reader.kind() {
            "path" => IntegratorSpec::Path(Path::from_params(reader)),
            "directlighting" => IntegratorSpec::DirectLighting(DirectLighting::from_params(reader)),
            "whitted" => IntegratorSpec::Whitted(Whitted::from_params(reader)),
            "volpath" => IntegratorSpec::VolPath(VolPath::from_params(reader)),
            "bdpt" | "mlt" => {
                read_and_ignore(reader);
                IntegratorSpec::VolPath(VolPath::from_params(reader))
            }
            "sppm" => {
                read_and_ignore(reader);
                IntegratorSpec::Path(Path {
                    mirrors_apart: true,
                    ..Path::from_params(reader)
                })
            }
            "ambientocclusion" => {
                IntegratorSpec::AmbientOcclusion(AmbientOcclusion::from_params(reader))
            }
            "photonmap" | "exphotonmap" if reader.dialect() == Dialect::V2 => {
                read_and_ignore(reader);
                IntegratorSpec::Path(Path::from_params(reader))
            }
            "igi" | "irradiancecache" | "dipolesubsurface" if reader.dialect() == Dialect::V2 => {
                reader.note(format!(
                    "`{}` is rendered by `path`, which has none of its bias",
                    reader.kind()
                ));
                read_and_ignore(reader);
                IntegratorSpec::Path(Path::from_params(reader))
            }
            "useprobes" | "diffuseprt" | "glossyprt" if reader.dialect() == Dialect::V2 => {
                reader.warn(
                    "",
                    format!(
                        "`{}` shows a few spherical harmonics of the light; `path` shows all of it",
                        reader.kind()
                    ),
                );
                read_and_ignore(reader);
                IntegratorSpec::Path(Path::from_params(reader))
            }
            _ => {
                reader.unknown_kind(NAMES);
                IntegratorSpec::Path(Path::from_params(reader))
            }
        };
        IntegratorSettings {
            spec,
            pixel_bounds: pixel_bounds(reader),
            place: Some(reader.kind_span()),
            light_tracer: LightTracer::named(reader.kind(), reader.dialect()),
        }
    }
}

/// Parameters of integrators whose work `path` does: legal, and without effect on the image.
fn read_and_ignore(reader: &ParamReader) {
    const WITHOUT_EFFECT: &[&str] = &[
        "bootstrapsamples",
        "chains",
        "mutationsperpixel",
        "largestepprobability",
        "sigma",
        "iterations",
        "numiterations",
        "photonsperiteration",
        "imagewritefrequency",
        "radius",
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
        "indirectphotons",
    ];
    for name in WITHOUT_EFFECT {
        reader.accept(name);
    }
}

/// `pixelbounds`: four integers x0 x1 y0 y1.
fn pixel_bounds(reader: &ParamReader) -> Option<[i32; 4]> {
    let values = reader.integers("pixelbounds")?;
    let Ok(v) = <[f64; 4]>::try_from(values) else {
        reader.ignored(
            "pixelbounds",
            "`pixelbounds` takes four integers: x0 x1 y0 y1",
        );
        return None;
    };
    Some(v.map(|x| x as i32))
}

/// `maxdepth` as a count; negative values count as zero, with a warning.
pub(crate) fn max_depth(reader: &ParamReader) -> u32 {
    reader.integer_within("maxdepth", 5, 0..=i64::from(u32::MAX >> 1)) as u32
}

/// An integrator ready to run.
#[derive(Debug)]
pub struct Integrator {
    spec: IntegratorSpec,
    lights: Lights,
}

impl Integrator {
    /// Prepares the sampling of the world's lights.
    pub fn new(spec: &IntegratorSpec, world: &World) -> Integrator {
        let strategy = match spec {
            IntegratorSpec::Path(path) => Some(path.light_strategy),
            IntegratorSpec::VolPath(volpath) => Some(volpath.path.light_strategy),
            _ => None,
        };
        let (_, radius) = world.geometry.bounds().bounding_sphere();
        let lights = world.sampled_lights();
        let (selected, grouped) = match strategy {
            Some(_) => (lights, &[][..]),
            None => (&[][..], lights),
        };
        Integrator {
            spec: spec.clone(),
            lights: Lights {
                selector: LightSelector::new(selected, strategy.unwrap_or_default(), radius),
                groups: LightGroups::new(grouped),
            },
        }
    }

    /// Radiance along a camera ray.
    pub fn radiance(
        &self,
        world: &World,
        ray: Ray,
        differentials: Option<&RayDifferentials>,
        stream: &mut SampleStream,
    ) -> Rgb {
        self.trace((world, stream, None), ray, differentials)
    }

    /// Like [`Integrator::radiance`], reporting every path vertex to `watch`.
    pub fn watched(
        &self,
        world: &World,
        ray: Ray,
        differentials: Option<&RayDifferentials>,
        stream: &mut SampleStream,
        watch: &mut Watch,
    ) -> Rgb {
        self.trace((world, stream, Some(watch)), ray, differentials)
    }

    fn trace(
        &self,
        (world, stream, watch): (&World, &mut SampleStream, Option<&mut Watch>),
        ray: Ray,
        differentials: Option<&RayDifferentials>,
    ) -> Rgb {
        let context = Context {
            world,
            lights: &self.lights,
            stream,
            watch,
        };
        match &self.spec {
            IntegratorSpec::Path(path) => path.radiance::<false>(context, ray, differentials),
            IntegratorSpec::VolPath(volpath) => volpath.radiance(context, ray, differentials),
            IntegratorSpec::DirectLighting(direct) => direct.radiance(context, ray, differentials),
            IntegratorSpec::Whitted(whitted) => whitted.radiance(context, ray, differentials),
            IntegratorSpec::AmbientOcclusion(ambient) => {
                ambient.radiance(context, ray, differentials)
            }
        }
    }
}
