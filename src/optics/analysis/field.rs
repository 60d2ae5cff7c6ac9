//! What changes over the field: angle, distortion, brightness, sharpness.

use super::beam::Beam;
use super::chief::{ChiefFinder, ChiefRay};
use super::illumination::projected_solid_angle;
use super::object::ObjectPlane;
use super::spot::Spot;
use super::{Effort, MTF_FREQUENCIES};
use crate::optics::lens::Lens;
use crate::optics::pupil::ExitPupil;
use serde::Serialize;

/// The lens at one film height.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct FieldPoint {
    /// From the axis, mm.
    pub height: f64,
    /// Between the axis and the chief ray in front of the lens, degrees.
    pub field_angle: f64,
    /// Between the axis and the chief ray at the film, degrees.
    pub film_angle: f64,
    /// Image height over that of a lens without distortion (the height grows with the tangent of the field angle, or
    /// with the object's height), minus 1, in per cent; 0 on the axis; `None` beyond 90°.
    pub distortion: Option<f64>,
    /// The same for the height growing with the angle itself, as fisheyes are meant to do; `None` for a near object.
    pub f_theta_distortion: Option<f64>,
    /// Irradiance relative to the middle of the film.
    pub relative_illumination: f64,
    /// Fourth power of the cosine of the field angle; 0 beyond 90°.
    pub cos4_field: f64,
    /// Fourth power of the cosine of the angle at the film.
    pub cos4_film: f64,
    /// Root mean square radius of the spot about its centroid, mm.
    pub spot_rms: Option<f64>,
    /// Geometric modulation transfer at [`MTF_FREQUENCIES`], \[sagittal, tangential\] each.
    pub mtf: Option<[[f64; 2]; 3]>,
}

/// Image height over tangent of the field angle (a focal length), or over object height (a magnification), near the axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ReferenceScale {
    scale: f64,
    object: ObjectPlane,
}

impl ReferenceScale {
    /// Of a lens, measured on the chief ray next to the axis; `corner` is the largest film height. 0 where there is none.
    pub fn new(chief: &ChiefFinder, object: ObjectPlane, corner: f64) -> ReferenceScale {
        let unscaled = ReferenceScale { scale: 1.0, object };
        // Near enough that distortion, which grows as the square of the height, is 1e-8 of the corner's.
        let near = chief.find(1e-4 * corner);
        let scale = near.map_or(0.0, |ray| ray.height / unscaled.ideal_height(&ray));
        ReferenceScale { scale, object }
    }

    /// Where a lens without distortion images what `chief` comes from, mm from the axis.
    pub fn ideal_height(&self, chief: &ChiefRay) -> f64 {
        let ray = &chief.ray;
        match self.object.z {
            Some(z) => {
                let y = ray.o[1] + (z - ray.o[2]) / ray.d[2] * ray.d[1];
                -self.scale * y * chief.height.signum()
            }
            None => self.scale * chief.tangent(),
        }
    }

    fn distortion(&self, chief: &ChiefRay) -> Option<f64> {
        let forward = chief.ray.d[2] < 0.0 || chief.height == 0.0;
        percent_off(chief.height, self.ideal_height(chief)).filter(|_| forward)
    }

    fn f_theta_distortion(&self, chief: &ChiefRay) -> Option<f64> {
        let distant = self.object.z.is_none();
        percent_off(chief.height, self.scale * chief.field_angle()).filter(|_| distant)
    }
}

/// How far a height differs from the ideal one, %; nothing on the axis, `None` where there is no ideal one.
fn percent_off(height: f64, ideal: f64) -> Option<f64> {
    if height == 0.0 {
        return Some(0.0);
    }
    (ideal > 0.0).then(|| 100.0 * (height / ideal - 1.0))
}

/// What a field point is computed from.
pub(super) struct Context<'a> {
    pub lens: &'a Lens,
    pub pupil: &'a ExitPupil,
    pub chief: &'a ChiefFinder<'a>,
    pub scale: ReferenceScale,
    /// Projected solid angle of the pupil seen from the middle of the film.
    pub at_axis: f64,
    pub effort: &'a Effort,
}

impl Context<'_> {
    /// At `height`; `None` where no light arrives or there is no chief ray.
    pub(super) fn point(&self, height: f64) -> Option<FieldPoint> {
        let omega = projected_solid_angle(self.lens, self.pupil, height, self.effort.pupil_samples);
        let chief = self.chief.find(height)?;
        if omega <= 0.0 || self.at_axis <= 0.0 {
            return None;
        }
        let film_angle = ((height - chief.aim) / self.lens.film_distance()).atan();
        let spot = Beam::new(self.lens, self.pupil, &chief, self.scale.object)
            .map(|b| Spot::trace(self.lens, &b, self.effort.rays_across))
            .filter(|s| !s.points.is_empty());
        Some(FieldPoint {
            height,
            field_angle: chief.field_angle().to_degrees(),
            film_angle: film_angle.to_degrees(),
            distortion: self.scale.distortion(&chief),
            f_theta_distortion: self.scale.f_theta_distortion(&chief),
            relative_illumination: omega / self.at_axis,
            cos4_field: chief.field_angle().cos().max(0.0).powi(4),
            cos4_film: film_angle.cos().powi(4),
            spot_rms: spot.as_ref().map(Spot::rms_radius),
            mtf: spot.map(|s| MTF_FREQUENCIES.map(|f| s.mtf(f))),
        })
    }
}
