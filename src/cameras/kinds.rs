//! The types of cameras: one table for names, the reader and the dispatch.

use super::camera_transform::CameraTransform;
use super::*;

/// What `perspective`, `orthographic` and `environment` have in common; `realistic` has methods of its own.
pub(super) trait OrdinaryCamera {
    /// Camera space to render space.
    fn transform(&mut self) -> &mut CameraTransform;

    /// See [`Camera::has_lens`].
    fn has_lens(&self) -> bool;

    /// See [`Camera::describe`].
    fn describe(&self, film: &FilmGeometry) -> Vec<String>;

    /// See [`Camera::set_motion`].
    fn set_motion(&mut self, motion: Motion) {
        self.transform().set_motion(motion);
    }

    /// See [`Camera::disperses`].
    fn disperses(&self) -> bool {
        false
    }

    /// See [`Camera::warnings`].
    fn warnings(&self) -> Vec<String> {
        Vec::new()
    }
}

macro_rules! camera_types {
    ($($name:literal => $Type:ident($Spec:ident),)*) => {
        /// The type names a scene may give, for "did you mean".
        pub const CAMERA_NAMES: &[&str] = &[$($name,)*];

        /// A camera as the scene file describes it.
        #[derive(Clone, Debug)]
        pub enum CameraSpec {
            $(#[doc = concat!("`", $name, "`")] $Type(Box<$Spec>),)*
        }

        impl CameraSpec {
            /// Reads the camera; `None` where none can be made (reported).
            pub(super) fn read(params: &ParamReader) -> Option<CameraSpec> {
                match params.kind() {
                    $($name => {
                        let spec: Option<$Spec> = $Spec::from_params(params).into();
                        spec.map(|spec| CameraSpec::$Type(Box::new(spec)))
                    })*
                    _ => {
                        params.unknown_kind(CAMERA_NAMES);
                        None
                    }
                }
            }
        }

        /// A camera ready to make rays.
        #[derive(Clone, Debug)]
        pub enum Camera {
            $(#[doc = concat!("`", $name, "`")] $Type(Box<$Type>),)*
        }

        impl Camera {
            /// Puts `spec` behind `film`; `render_from_camera` places it (camera space in the units of
            /// the camera: scene units, but see [`RealisticSpec`]).
            pub fn new(
                spec: &CameraSpec,
                film: &FilmGeometry,
                render_from_camera: &Transform,
            ) -> Result<Camera, CameraError> {
                if film.resolution.x == 0 || film.resolution.y == 0 {
                    return Err(CameraError::EmptyFilm);
                }
                if !render_from_camera.is_invertible() {
                    return Err(CameraError::SingularTransform);
                }
                Ok(match spec {
                    $(CameraSpec::$Type(spec) => {
                        Camera::$Type(Box::new($Type::new(spec, film, render_from_camera)?))
                    })*
                })
            }

            /// Lets the camera move through render space while its shutter is open; `motion` takes camera
            /// space to render space.
            pub fn set_motion(&mut self, motion: Motion) {
                match self { $(Camera::$Type(c) => c.set_motion(motion),)* }
            }

            /// Returns `true` if it depends on [`CameraSample::lens`].
            pub fn has_lens(&self) -> bool {
                match self { $(Camera::$Type(c) => c.has_lens(),)* }
            }

            /// Returns `true` if it depends on [`CameraSample::wavelength`].
            pub fn disperses(&self) -> bool {
                match self { $(Camera::$Type(c) => c.disperses(),)* }
            }

            /// What a photographer wants to know before the image is taken on `film`, one fact a line.
            pub fn describe(&self, film: &FilmGeometry) -> Vec<String> {
                match self { $(Camera::$Type(c) => c.describe(film),)* }
            }

            /// What looks wrong although an image can be made: a lens focused inside itself, a film
            /// inside glass, an image larger than the image circle.
            pub fn warnings(&self) -> Vec<String> {
                match self { $(Camera::$Type(c) => c.warnings(),)* }
            }

            /// The ray for `sample`; `None` where no light can arrive (a vignetted ray), which counts as
            /// a black sample. `want_differentials` asks for the rays of the neighboring pixels; asking
            /// never changes whether the sample counts.
            pub fn ray(&self, sample: &CameraSample, want_differentials: bool) -> Option<CameraRay> {
                match self { $(Camera::$Type(c) => c.ray(sample, want_differentials).into(),)* }
            }
        }
    };
}

// A new type: its file, which gives the two types, their `from_params`, `new` and `ray`, and implements
// `OrdinaryCamera`, and a line here.
camera_types! {
    "perspective" => Perspective(PerspectiveSpec),
    "realistic" => Realistic(RealisticSpec),
    "orthographic" => Orthographic(OrthographicSpec),
    "environment" => Environment(EnvironmentSpec),
}
