//! The types of cameras: their names, and what each does.

use super::blur::Blur;
use super::camera_transform::CameraTransform;
use super::*;
use crate::film::Photograph;
use glam::DVec4;

/// The type names a scene may give, for "did you mean".
pub const CAMERA_NAMES: &[&str] = &["perspective", "realistic", "orthographic", "environment"];

/// A camera as the scene file describes it.
#[derive(Clone, Debug)]
pub enum CameraSpec {
    /// `perspective` and `orthographic`
    Projective(Box<ProjectiveSpec>),
    /// `realistic`
    Realistic(Box<RealisticSpec>),
    /// `environment`
    Environment(Box<EnvironmentSpec>),
}

impl CameraSpec {
    /// Reads the camera; `None` where none can be made (reported).
    pub(super) fn read(params: &ParamReader, choices: &CameraChoices) -> Option<CameraSpec> {
        Some(match params.kind() {
            "perspective" | "orthographic" => {
                CameraSpec::Projective(Box::new(ProjectiveSpec::from_params(params)))
            }
            "realistic" => {
                CameraSpec::Realistic(Box::new(RealisticSpec::from_params(params, choices)?))
            }
            "environment" => {
                CameraSpec::Environment(Box::new(EnvironmentSpec::from_params(params)))
            }
            _ => {
                params.unknown_kind(CAMERA_NAMES);
                return None;
            }
        })
    }
}

/// Depths and circles of confusion of many points.
#[derive(Clone, Debug)]
pub struct Depths<'a> {
    camera: &'a Camera,
    /// Where it is the same at all times, and for all points.
    still: Option<Scale>,
}

impl Depths<'_> {
    /// Of the render-space point `p` at `time`.
    #[inline(always)]
    pub fn at(&self, p: Vec3, time: f32) -> DepthAndBlur {
        match &self.still {
            Some(scale) => scale.at(p),
            None => self.at_time(p, time),
        }
    }

    /// Where all is sharp at all times: the dot product of this and a point, with 1 for w, is its depth, so that the depth of a mean of points is the mean of
    /// their depths.
    pub fn of_mean(&self) -> Option<DVec4> {
        let Scale { row, length, .. } = self.still.filter(|scale| scale.blur.is_none())?;
        Some(row / length)
    }

    #[inline(never)]
    fn at_time(&self, p: Vec3, time: f32) -> DepthAndBlur {
        let (transform, blur) = match self.camera {
            Camera::Projective(c) => (c.transform(), c.blur()),
            Camera::Realistic(c) => (c.transform(), c.blur(p, time)),
            Camera::Environment(c) => {
                return DepthAndBlur {
                    depth: c.transform().distance(p, time),
                    coc: 0.0,
                };
            }
        };
        Scale::new(transform, time, blur).at(p)
    }
}

/// What a depth is made with.
#[derive(Clone, Copy, Debug)]
struct Scale {
    /// Takes a point to camera-space z.
    row: DVec4,
    /// Of camera-space z for each unit of the scene.
    length: f64,
    /// If there is any.
    blur: Option<Blur>,
}

impl Scale {
    fn new(transform: &CameraTransform, time: f32, blur: Blur) -> Scale {
        let row = transform.z(time);
        let length = row.truncate().length();
        let blur = Some(blur).filter(|blur| !blur.is_none());
        Scale { row, length, blur }
    }

    #[inline(always)]
    fn at(&self, p: Vec3) -> DepthAndBlur {
        let z = self.row.dot(p.as_dvec3().extend(1.0));
        // Not by `map`, whose function is not always inlined.
        let coc = match &self.blur {
            Some(blur) => blur.diameter(z),
            None => 0.0,
        };
        DepthAndBlur {
            depth: z / self.length,
            coc,
        }
    }
}

/// How far a point is from a camera, and how sharp it is seen.
#[derive(Clone, Copy, Debug, Default)]
pub struct DepthAndBlur {
    /// Distance from the plane through the camera's position across its axis, in scene units, negative behind it: for
    /// `realistic`, whose position is that of its film, from the film's plane. For `environment`, which has no axis, from its
    /// position.
    pub depth: f64,
    /// Diameter in pixels of its circle of confusion, to first order near the axis: of the light to one point of the film, the
    /// width where it passes the point's depth. 0 for `environment`, and for a lens of which no light along the axis is
    /// known.
    pub coc: f64,
}

/// A camera ready to make rays.
#[derive(Clone, Debug)]
pub enum Camera {
    /// `perspective` and `orthographic`
    Projective(Box<Projective>),
    /// `realistic`
    Realistic(Box<Realistic>),
    /// `environment`
    Environment(Box<Environment>),
}

impl Camera {
    /// Puts `spec` behind `film`; `place` takes camera space to render space (camera space in the units of
    /// the camera: scene units, but see [`RealisticSpec`]).
    pub fn new(
        spec: &CameraSpec,
        film: &FilmGeometry,
        place: &Transform,
    ) -> Result<Camera, CameraError> {
        if film.resolution.x == 0 || film.resolution.y == 0 {
            return Err(CameraError::EmptyFilm);
        }
        if !place.is_invertible() {
            return Err(CameraError::SingularTransform);
        }
        Ok(match spec {
            CameraSpec::Projective(s) => Camera::Projective(Projective::new(s, film, place).into()),
            CameraSpec::Realistic(s) => Camera::Realistic(Realistic::new(s, film, place)?.into()),
            CameraSpec::Environment(s) => {
                Camera::Environment(Environment::new(s, film, place).into())
            }
        })
    }

    /// When it lets light in.
    pub fn shutter(&self) -> &Shutter {
        match self {
            Camera::Projective(c) => c.shutter(),
            Camera::Realistic(c) => c.shutter(),
            Camera::Environment(c) => c.shutter(),
        }
    }

    /// Lets the camera move through render space while its shutter is open; `motion` takes camera
    /// space to render space.
    pub fn set_motion(&mut self, motion: Motion) {
        match self {
            Camera::Projective(c) => c.set_motion(motion),
            Camera::Realistic(c) => c.set_motion(motion),
            Camera::Environment(c) => c.set_motion(motion),
        }
    }

    /// Returns `true` if it moves.
    pub fn moves(&self) -> bool {
        match self {
            Camera::Projective(c) => c.transform().moves(),
            Camera::Realistic(c) => c.transform().moves(),
            Camera::Environment(c) => c.transform().moves(),
        }
    }

    /// Returns `true` if it depends on [`CameraSample::lens`].
    pub fn has_lens(&self) -> bool {
        match self {
            Camera::Projective(c) => c.has_lens(),
            Camera::Realistic(_) => true,
            Camera::Environment(_) => false,
        }
    }

    /// Returns `true` if it depends on [`CameraSample::wavelength`].
    pub fn disperses(&self) -> bool {
        matches!(self, Camera::Realistic(c) if c.disperses())
    }

    /// What depths and circles of confusion are made with.
    pub fn depths(&self) -> Depths<'_> {
        let still = match self {
            _ if self.moves() => None,
            Camera::Projective(c) => Some(Scale::new(c.transform(), 0.0, c.blur())),
            Camera::Realistic(c) => {
                { c.even_blur() }.map(|blur| Scale::new(c.transform(), 0.0, blur))
            }
            Camera::Environment(_) => None,
        };
        Depths {
            camera: self,
            still,
        }
    }

    /// What a photographer wants to know before the image is taken on `film`, one fact a line.
    pub fn describe(&self, film: &FilmGeometry) -> Vec<String> {
        match self {
            Camera::Projective(c) => c.describe(film),
            Camera::Realistic(c) => c.describe(film),
            Camera::Environment(_) => {
                vec!["environment camera: all directions, latitude by longitude".to_string()]
            }
        }
    }

    /// What a photographer notes of the image on `film`; `None` without a traced lens.
    pub fn photograph(&self, film: &FilmGeometry) -> Option<Photograph> {
        match self {
            Camera::Realistic(c) => Some(c.photograph(film)),
            Camera::Projective(_) | Camera::Environment(_) => None,
        }
    }

    /// What looks wrong although an image can be made: a lens focused inside itself, a film
    /// inside glass, an image larger than the image circle.
    pub fn warnings(&self) -> Vec<String> {
        match self {
            Camera::Realistic(c) => c.warnings(),
            Camera::Projective(_) | Camera::Environment(_) => Vec::new(),
        }
    }

    /// The ray for `sample`; `None` where no light can arrive (a vignetted ray), which counts as
    /// a black sample. `want_differentials` asks for the rays of the neighboring pixels; asking
    /// never changes whether the sample counts.
    #[cfg(any(test, feature = "internals"))]
    pub fn ray(&self, sample: &CameraSample, want_differentials: bool) -> Option<CameraRay> {
        match self {
            Camera::Projective(c) => Some(c.ray(sample, want_differentials)),
            Camera::Realistic(c) => c.ray(sample, want_differentials),
            Camera::Environment(c) => Some(c.ray(sample, want_differentials)),
        }
    }

    /// The rays for up to [`BUNDLE`] samples, written in order to `rays`, which has room for as many: as [`Camera::ray`] for each, whatever the
    /// others are; those of `realistic` in single precision.
    pub fn rays(
        &self,
        samples: &[CameraSample],
        want_differentials: bool,
        rays: &mut [Option<CameraRay>],
    ) {
        match self {
            Camera::Projective(c) => c.rays(samples, want_differentials, rays),
            Camera::Realistic(c) => c.rays(samples, want_differentials, rays),
            Camera::Environment(c) => {
                for (ray, sample) in rays.iter_mut().zip(samples) {
                    *ray = Some(c.ray(sample, want_differentials));
                }
            }
        }
    }
}
