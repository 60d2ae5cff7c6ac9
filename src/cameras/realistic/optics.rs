//! The lens of a realistic camera at one wavelength: where its rays are aimed, and with what they are made.

use super::{Compat, Precision, RealisticSpec};
use crate::cameras::CameraError;
use crate::math::sampling::concentric_disk;
use crate::math::{Rgb, Vec2};
use crate::optics::coating::Coating;
use crate::optics::ghosts::Ghosts;
use crate::optics::models::{LensModel, ModelKind};
use crate::optics::pupil::{ExitPupil, PupilSample, RINGS, TiltedPupil, sampling_plane};
use crate::optics::{Lens, StopShape};

/// The part of the film that needs an exit pupil.
pub(super) struct FilmReach {
    /// Farthest point from the axis, mm, of a film that is not tilted, or of what the lines to a tilted one meet of that plane.
    pub(super) flat: f64,
    /// Of a tilted film: z of its ends, and its farthest point from the axis.
    pub(super) tilted: Option<([f64; 2], f64)>,
}

/// Where rays are aimed.
#[derive(Clone, Debug)]
pub(super) enum PupilTarget {
    /// At the true exit pupil.
    Pupil(Box<ExitPupil>),
    /// At the rear element's disk, flat at its vertex: radius in mm.
    RearDisk(f64),
}

/// The lens at one wavelength, and what makes its rays.
#[derive(Clone, Debug)]
pub(super) struct Optics {
    pub(super) lens: Lens,
    pub(super) aim: PupilTarget,
    /// What a tilted film sees; on the same plane.
    pub(super) tilted: Option<Box<TiltedPupil>>,
    pub(super) model: LensModel,
    /// The lens with its shaped stop, where rays need to be weighed by it: by an image, or because the model traces none.
    pub(super) stop_mask: Option<Box<Lens>>,
    /// See [`crate::cameras::CameraRay::tint`]; without what surfaces reflect.
    pub(super) band_tint: Rgb,
    /// The lens with its shaped stop, if its surfaces reflect.
    pub(super) ghosts: Option<Box<Ghosts>>,
    /// Weight over projected solid angle at the film.
    pub(super) weight_scale: f64,
}

/// The exit pupil is known for film points this many pixels outside the image: the widest reconstruction
/// filter in use, a windowed sinc, reaches four. Farther out everything still works, with more rays lost.
pub(super) const FILTER_REACH: f64 = 4.0;

impl Optics {
    /// Returns `true` if its rays are not made side by side, in single precision.
    pub(super) fn goes_one_by_one(&self, spec: &RealisticSpec) -> bool {
        spec.compat != Compat::None
            || spec.precision == Precision::Double
            || is_too_fine(&spec.lens)
            || self.stop_mask.is_some()
            || self.ghosts.is_some()
    }

    pub(super) fn new(
        spec: &RealisticSpec,
        lens: &Lens,
        band_tint: Rgb,
        reach: &FilmReach,
    ) -> Result<Optics, CameraError> {
        let sampling = spec.pupil_sampling;
        let tilted = |(ends, reach)| TiltedPupil::new(lens, ends, reach, sampling);
        let tilted = reach.tilted.map(tilted).map(Box::new);
        let aim = match spec.compat {
            Compat::None => {
                let plane = tilted.as_ref().map(|tilted| tilted.plane_z());
                let plane = plane.unwrap_or_else(|| sampling_plane(lens));
                let pupil = ExitPupil::on_plane(lens, plane, reach.flat, RINGS);
                PupilTarget::Pupil(Box::new(pupil.with_sampling(sampling)))
            }
            Compat::PbrtV2 => PupilTarget::RearDisk(0.5 * lens.rear().aperture),
        };
        let model = match &aim {
            PupilTarget::Pupil(pupil) => {
                LensModel::new(spec.model, lens, pupil).map_err(CameraError::LensModel)?
            }
            PupilTarget::RearDisk(_) => LensModel::exact(lens, lens.length()),
        };
        let (model, stop_mask) = shaped(model, lens, spec.stop_shape.as_ref());
        Ok(Optics {
            lens: lens.clone(),
            aim,
            tilted,
            model,
            stop_mask,
            band_tint,
            ghosts: None,
            weight_scale: 1.0,
        })
    }

    /// Lets surfaces reflect light of these wavelengths, nm; see [`Ghosts::new`].
    pub(super) fn reflect(&mut self, coating: Option<Coating>, wavelengths: [f64; 3]) {
        let lens = { self.stop_mask.as_deref() }.unwrap_or(self.model.lens());
        let ghosts = Ghosts::new(lens.clone(), coating).at(wavelengths);
        self.ghosts = Some(Box::new(ghosts));
    }

    /// See [`crate::cameras::CameraRay::tint`], for the line from the film point through `pupil`; `None` where surfaces that reflect let no
    /// light through.
    pub(super) fn tint(&self, film: [f64; 2], pupil: [f64; 3]) -> Option<Rgb> {
        let Some(ghosts) = &self.ghosts else {
            return Some(self.band_tint);
        };
        let light = ghosts.through(&self.lens.film_ray(film, pupil))?;
        Some(self.band_tint * Rgb::from(light.map(|share| share as f32)))
    }

    /// Part of the light of a ray that a shaped stop lets pass, where the model does not see to that.
    pub(super) fn transmission(&self, film: [f64; 2], pupil: [f64; 3]) -> f64 {
        let stop_mask = self.stop_mask.as_ref();
        stop_mask.map_or(1.0, |lens| lens.stop_transmission(film, pupil))
    }

    /// Where to send the ray from `film` in space, if the film is tilted; `None` where no light comes from.
    pub(super) fn aim_from(&self, film: [f64; 3], u: Vec2) -> Option<PupilSample> {
        match &self.tilted {
            Some(pupil) if self.has_pupil() => pupil.sample(film, u),
            // A disk, the same for all points.
            _ => self.aim([film[0], film[1]], u),
        }
    }

    /// Returns `true` if it is an exit pupil that is sampled.
    fn has_pupil(&self) -> bool {
        matches!(self.aim, PupilTarget::Pupil(_)) && self.model.kind() != ModelKind::Thin
    }

    /// Where to send the ray from `film`; `None` where no light comes from.
    pub(super) fn aim(&self, film: [f64; 2], u: Vec2) -> Option<PupilSample> {
        match &self.aim {
            PupilTarget::Pupil(pupil) => self.model.sample_pupil(pupil, film, u),
            PupilTarget::RearDisk(radius) => {
                let p = radius * concentric_disk(u).as_dvec2();
                Some(PupilSample {
                    point: [p.x, p.y, self.lens.length()],
                    area: std::f64::consts::PI * radius * radius,
                })
            }
        }
    }
}

/// An aperture narrower than this part of the way to the film is met in double precision: in single precision a ray is
/// off by some millionths of its coordinates there, and light would be lost.
const FINEST_APERTURE: f64 = 1.0 / 262_144.0;

/// Returns `true` if the lens has an aperture too small for rays in single precision.
pub(super) fn is_too_fine(lens: &Lens) -> bool {
    let narrowest = lens.surfaces().iter().map(|s| s.aperture);
    narrowest.fold(f64::INFINITY, f64::min) < FINEST_APERTURE * lens.film_z()
}

/// `model` with a stop of this shape, and the lens that weighs its rays where the model cannot.
fn shaped(
    model: LensModel,
    lens: &Lens,
    shape: Option<&StopShape>,
) -> (LensModel, Option<Box<Lens>>) {
    let Some(shape) = shape else {
        return (model, None);
    };
    let lens = lens.clone().with_stop_shape(shape.clone());
    match (model.kind(), shape) {
        // Exact rays end at blades by themselves.
        (ModelKind::Exact, StopShape::Polygon(_)) => {
            (LensModel::exact(&lens, model.plane_z()), None)
        }
        _ => (model, Some(Box::new(lens))),
    }
}
