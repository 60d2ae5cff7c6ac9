//! The types of integrators: one table for names, the reader and the dispatch.

use super::context::Lights;
use super::stand_in::{Finds::*, StandIn};
use super::*;
use crate::samplers::SamplerSpec;

/// What every type of integrator implements besides `from_params`.
pub(super) trait Transport {
    /// Participating media are modeled.
    const MEDIA: bool = false;

    /// Paths continue after diffuse surfaces: lights are chosen by their contribution, and subsurface scattering is modeled.
    const INDIRECT: bool = false;

    /// Paths are traced from the lights, too.
    const TRACES_LIGHT: bool = false;

    /// Ray differentials are followed through mirrors and glass.
    const FOLLOWS_DIFFERENTIALS: bool = false;

    /// Many paths are traced side by side: [`Transport::radiances`].
    const IN_WAVES: bool = false;

    /// Photons are sent from the lights before camera paths are traced, which gather them.
    const PHOTONS: bool = false;

    /// Traces paths from lights and hands what they bring to pixels.
    fn light_paths(
        &self,
        _job: &LightJob,
        _lights: &Lights,
        _paths: impl Iterator<Item = (u64, SampleStream)>,
        _workspace: &mut Workspace,
        _splat: &mut impl FnMut(Splat),
    ) {
    }

    /// Where and with which density light path with these sample points begins; `None` where it does not.
    fn beginning(
        &self,
        _job: &LightJob,
        _lights: &Lights,
        _stream: SampleStream,
    ) -> Option<Beginning> {
        None
    }

    /// Bytes for what an image of so many pixels takes besides its sums.
    fn memory(&self, _pixels: u64) -> u64 {
        0
    }

    /// Radiance along the camera ray.
    fn radiance(&self, context: Context) -> Rgb;

    /// The same for each path of a bundle.
    fn radiances(&self, bundle: Bundle, out: &mut ArrayVec<Rgb, WAVE>) {
        self.radiances_one_by_one(bundle, out);
    }

    /// The same, each path by itself.
    fn radiances_one_by_one(&self, mut bundle: Bundle, out: &mut ArrayVec<Rgb, WAVE>) {
        let paths = 0..bundle.paths.len().min(WAVE);
        out.extend(paths.map(|path| self.radiance(bundle.context(path))));
    }

    /// [`Transport::radiance`] in two parts: that of camera paths alone, and what comes of joining all of them to light paths,
    /// over the share of them that are joined in the image.
    fn radiance_in_parts(&self, context: Context) -> [Rgb; 2] {
        [self.radiance(context), Rgb::ZERO]
    }

    /// The path integrator that finds the same light; `None` if the image is not of light.
    fn path(&self) -> Option<Path>;
}

macro_rules! integrator_types {
    (
        modeled { $($name:literal => $Type:ident,)* }
        replaced { $($other:literal => $stand_in:tt,)* }
    ) => {
        /// Every type that a scene may name, for "did you mean".
        pub const NAMES: &[&str] = &[$($name,)* $($other,)*];

        /// The types that are not modeled.
        pub(super) const STAND_INS: &[(&str, StandIn)] = &[$(($other, StandIn $stand_in),)*];

        /// An integrator as the scene gives it.
        #[derive(Clone, Debug, PartialEq)]
        pub enum IntegratorSpec {
            $(#[doc = concat!("`Integrator \"", $name, "\"`")] $Type($Type),)*
        }

        impl IntegratorSpec {
            pub(super) fn from_params(reader: &ParamReader) -> IntegratorSpec {
                match reader.kind() {
                    $($name => IntegratorSpec::$Type($Type::from_params(reader)),)*
                    _ => stand_in::from_params(reader),
                }
            }

            /// The type as scenes name it.
            pub fn name(&self) -> &'static str {
                match self { $(IntegratorSpec::$Type(_) => $name,)* }
            }

            /// Returns `true` if participating media are modeled.
            pub fn sees_media(&self) -> bool {
                match self { $(IntegratorSpec::$Type(_) => $Type::MEDIA,)* }
            }

            /// Returns `true` if paths continue after diffuse surfaces, and below translucent ones.
            pub fn is_indirect(&self) -> bool {
                match self { $(IntegratorSpec::$Type(_) => $Type::INDIRECT,)* }
            }

            /// Returns `true` if paths are traced from the lights, too.
            pub fn traces_light(&self) -> bool {
                match self { $(IntegratorSpec::$Type(_) => $Type::TRACES_LIGHT,)* }
            }

            /// Returns `true` if ray differentials are followed through mirrors and glass.
            pub fn follows_differentials(&self) -> bool {
                match self { $(IntegratorSpec::$Type(_) => $Type::FOLLOWS_DIFFERENTIALS,)* }
            }

            /// Returns `true` if many paths are traced side by side.
            pub fn goes_in_waves(&self) -> bool {
                match self { $(IntegratorSpec::$Type(_) => $Type::IN_WAVES,)* }
            }

            /// Returns `true` if photons are sent from the lights before camera paths are traced, which gather them.
            pub fn gathers_photons(&self) -> bool {
                match self { $(IntegratorSpec::$Type(_) => $Type::PHOTONS,)* }
            }

            /// Returns `true` if the image is of light, and light may be added to it that is traced otherwise.
            pub fn has_light_pass(&self) -> bool {
                self.path().is_some() && !self.gathers_photons()
            }

            pub(super) fn light_paths(
                &self,
                job: &LightJob,
                lights: &Lights,
                paths: impl Iterator<Item = (u64, SampleStream)>,
                workspace: &mut Workspace,
                splat: &mut impl FnMut(Splat),
            ) {
                match self { $(IntegratorSpec::$Type(i) => i.light_paths(job, lights, paths, workspace, splat),)* }
            }

            pub(super) fn beginning(&self, job: &LightJob, lights: &Lights, stream: SampleStream) -> Option<Beginning> {
                match self { $(IntegratorSpec::$Type(i) => i.beginning(job, lights, stream),)* }
            }

            /// Bytes for what an image of so many pixels takes besides its sums.
            pub fn memory(&self, pixels: u64) -> u64 {
                match self { $(IntegratorSpec::$Type(i) => i.memory(pixels),)* }
            }

            pub(super) fn path(&self) -> Option<Path> {
                match self { $(IntegratorSpec::$Type(i) => i.path(),)* }
            }

            pub(super) fn radiance_in_parts(&self, context: Context) -> [Rgb; 2] {
                match self { $(IntegratorSpec::$Type(i) => i.radiance_in_parts(context),)* }
            }

            pub(super) fn radiances(&self, bundle: Bundle, out: &mut ArrayVec<Rgb, WAVE>) {
                match self { $(IntegratorSpec::$Type(i) => i.radiances(bundle, out),)* }
            }

            #[inline]
            pub(super) fn radiance(&self, context: Context) -> Rgb {
                match self { $(IntegratorSpec::$Type(i) => i.radiance(context),)* }
            }
        }
    };
}

// A new type: its file, which gives `from_params` and implements `Transport`, and a line here.
integrator_types! {
    modeled {
        "path" => Path,
        "volpath" => VolPath,
        "bdpt" => Bdpt,
        "sppm" => Sppm,
        "directlighting" => DirectLighting,
        "whitted" => Whitted,
        "ambientocclusion" => AmbientOcclusion,
    }
    // What renders instead; in pbrt-v2 only or not; which light the integrator finds.
    replaced {
        "mlt" => ("bdpt", false, Same),
        "photonmap" => ("bdpt", true, Caustics),
        "exphotonmap" => ("bdpt", true, Caustics),
        "irradiancecache" => ("path", true, Same),
        "igi" => ("path", true, Same),
        "dipolesubsurface" => ("path", true, Same),
        "useprobes" => ("path", true, Harmonics),
        "diffuseprt" => ("path", true, Harmonics),
        "glossyprt" => ("path", true, Harmonics),
    }
}

impl IntegratorSpec {
    /// The most scattering events of a path; `None` if the image is not of light.
    pub fn max_depth(&self) -> Option<u32> {
        self.path().map(|path| path.max_depth)
    }

    /// Returns `true` if this is a path tracer that light paths may help: see [`Integrator::may_be_assisted`].
    pub fn may_be_assisted(&self) -> bool {
        let path = match self {
            IntegratorSpec::Path(path) | IntegratorSpec::VolPath(VolPath { path }) => path,
            _ => return false,
        };
        // One scattering event at the surface that gathers light, one where that falls.
        path.max_depth >= 2 && !path.direct_only && path.media == MediaSeen::All
    }

    /// What the images of its strategies are called, if it makes any.
    pub fn strategies(&self) -> Vec<String> {
        match self {
            IntegratorSpec::Bdpt(bdpt) => bdpt.strategies(),
            _ => Vec::new(),
        }
    }

    /// Returns `true` if paths begin at lights, whatever becomes of them.
    pub fn begins_at_lights(&self) -> bool {
        self.traces_light() || self.gathers_photons()
    }

    /// The samples of a pixel where the integrator has its own, as in pbrt-v3, whatever the scene's `Sampler` says.
    pub fn own_sampler(&self) -> Option<SamplerSpec> {
        match self {
            IntegratorSpec::Sppm(sppm) => Some(SamplerSpec::sobol(sppm.iterations)),
            _ => None,
        }
    }

    /// The integrator that renders the same through pbrt-v2's volumes, with the light transport in them that `media`
    /// names. `volpath` simulates all of it as it is, `ambientocclusion` none.
    pub fn through_volumes(self, media: MediaSeen) -> IntegratorSpec {
        match self.path() {
            Some(_) if matches!(self, IntegratorSpec::VolPath(_)) => self,
            Some(path) => IntegratorSpec::VolPath(VolPath {
                path: Path { media, ..path },
            }),
            None => self,
        }
    }
}
