//! Connections: from a point of the scene through the camera to its film, as light tracing wants them and bidirectional
//! path tracing with one vertex on the camera.
//!
//! A pixel is the integral of radiance over étendue, dA⊥ dω, times the pixel's importance I. The camera estimates it by rays
//! of density q per étendue and weight W, so I = W q. A connection from x draws a direction of density p per solid angle
//! and finds the film point; what it counts for is I/p, and κ = q/p is what multiple importance sampling
//! wants to know: in [`Landing::density`] for a connection, its inverse in [`Camera::connection_density`] for a ray of the camera.
//! Both are per area across the ray at x, and so measured in render space.
//!
//! Through a pinhole, q and p are infinite in the same way. A point of a thin lens is drawn alike for both; what is left is
//! how the area across the ray at x is magnified to the film, by the pinhole or that point of the lens:
//!
//! | camera | κ in camera space; A the area of a pixel |
//! |---|---|
//! | `perspective` | 1/(A cos³θ r²), A on the plane at distance 1, r from x to the point of the lens, θ to the axis there |
//! | `orthographic` | 1/(A cosθ) |
//! | `environment` | 1/(Δφ Δθ sinθ r²), pixels of Δφ by Δθ |
//!
//! and W = 1, so importance and κ are the same. Camera space may be scaled, sheared or mirrored in the scene: an area across the
//! ray changes by |det M|/|M d| under the linear map M, for unit directions d. `realistic` is in
//! `realistic/connection.rs`.
//!
//! Sources: Veach, *Robust Monte Carlo Methods for Light Transport Simulation*, 1997, §8.3 and §10; Pharr, Jakob and
//! Humphreys 2016, §16.1.

use super::camera_transform::Placement;
use super::realistic::Traced;
use super::{BUNDLE, Camera, CameraRay, CameraSample, GhostEntry};
use crate::math::ray::Ray;
use crate::math::{DVec2, DVec3, Rgb, Vec2, Vec3};
use crate::surface::ReferencePoint;
use arrayvec::ArrayVec;
use std::borrow::Cow;

/// Through which part of the lens and of the spectrum to connect; all from 0 to 1.
#[derive(Clone, Copy, Debug)]
pub struct LensSample {
    /// Point of the lens, in the unit square; only a camera that has one ([`Camera::has_lens`]) looks at it.
    pub lens: Vec2,
    /// Part of the spectrum; only a camera that disperses ([`Camera::disperses`]) looks at it.
    pub wavelength: f32,
}

/// A direction from a point of the scene toward the camera, before it is known where on the film it lands.
#[derive(Clone, Copy, Debug)]
pub struct Aim {
    /// Unit direction in render space, from the point toward the camera.
    pub wi: Vec3,
    /// What must be free for light to arrive: from the point to the lens, or to the plane `hither`.
    pub shadow: Ray,
    way: Way,
}

/// What is known of the rest of the way.
#[derive(Clone, Copy, Debug)]
enum Way {
    /// All, without tracing anything.
    Known(Landing),
    /// The ray to the lens of a realistic camera.
    Lens(Traced),
}

impl Aim {
    fn to_lens(&self) -> Option<Traced> {
        match self.way {
            Way::Known(_) => None,
            Way::Lens(traced) => Some(traced),
        }
    }
}

/// Where on the film light lands, and what it counts for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Landing {
    /// Point of the film, raster coordinates; may lie outside the image.
    pub raster: Vec2,
    /// Radiance that arrives along [`Aim::wi`] counts for this times the cosine at the point, for a pixel that is the mean
    /// over its square (a box filter), in each channel; per area, in render space. It holds also where the
    /// camera itself makes no such ray.
    pub importance: Rgb,
    /// κ: the density with which the camera makes this ray, over that with which a connection does, both per area across the
    /// ray at the point, in render space, and the film point uniform in a pixel. 0 where the camera makes no such ray.
    pub density: f32,
}

/// How a camera without traced lenses sees a point, in camera space.
#[derive(Clone, Copy, Debug)]
pub(super) struct Hit {
    /// Where the camera's ray starts.
    pub origin: DVec3,
    /// The point of the film.
    pub raster: DVec2,
    /// κ.
    pub density: f64,
}

impl Camera {
    /// Returns `true` if connections can be made. They cannot by a camera placed by a projection, nor by a `realistic`
    /// one whose rays are not those of its lens: `compat pbrt-v2` and the models `thick` and `thin`.
    pub fn connects(&self) -> bool {
        match self {
            Camera::Projective(c) => c.placement(0.0).is_some(),
            Camera::Environment(c) => c.placement(0.0).is_some(),
            Camera::Realistic(c) => c.connects(),
        }
    }

    /// Gets ready for connections whose light lands between these two corners, in raster coordinates, which is where it counts: what is
    /// rendered and the reach of the filter around it. Only `realistic` needs it, to know where to aim; it then finds no light elsewhere, and
    /// none at all before. Some tenths of a second.
    pub fn prepare_connections(&mut self, window: [Vec2; 2]) {
        if let Camera::Realistic(c) = self {
            c.prepare_connections(window);
        }
    }

    /// Gets ready for [`Camera::shift`] of points that are seen between these two corners, in raster coordinates: not those of
    /// connections, whose window may be a part of the image. Only `realistic` needs it. Some tenths of a second.
    pub fn prepare_motion(&mut self, window: [Vec2; 2]) {
        if let Camera::Realistic(c) = self {
            c.prepare_motion(window);
        }
    }

    /// Draws a direction from a point of the scene, at its time, toward the camera; `None` where the camera sees nothing of it.
    pub fn aim(&self, from: &ReferencePoint, sample: &LensSample) -> Option<Aim> {
        if let Camera::Realistic(c) = self {
            let (wi, shadow, traced) = c.aim(from, sample)?;
            let way = Way::Lens(traced);
            return Some(Aim { wi, shadow, way });
        }
        let (placement, x, hit) = self.seen(from.p, from.time, sample.lens)?;
        let density = (hit.density * placement.area_across(x - hit.origin)) as f32;
        let landing = Landing {
            raster: hit.raster.as_vec2(),
            importance: Rgb::splat(density),
            density,
        };
        let (wi, shadow) = toward(from, &placement, x, hit.origin)?;
        // Infinite at the poles of the environment camera, and where a point lies on the lens.
        density.is_finite().then_some(Aim {
            wi,
            shadow,
            way: Way::Known(landing),
        })
    }

    /// Where light lands that runs along `aim`; `None` where it ends in the lens, or so far off the image that it counts for no
    /// pixel.
    pub fn land(&self, aim: &Aim) -> Option<Landing> {
        match (&aim.way, self) {
            (Way::Known(landing), _) => Some(*landing),
            (Way::Lens(traced), Camera::Realistic(c)) => c.land(traced),
            (Way::Lens(_), _) => None,
        }
    }

    /// The same for up to [`BUNDLE`] of them, in order, whatever the others are; those of `realistic` in single precision.
    pub fn land_all(&self, aims: &[Aim], out: &mut ArrayVec<Option<Landing>, BUNDLE>) {
        if let Camera::Realistic(c) = self {
            // Aims of this camera are all of them rays to its lens.
            let traced = aims.iter().take(BUNDLE).filter_map(Aim::to_lens);
            c.land_all(&traced.collect::<ArrayVec<_, BUNDLE>>(), out);
            return;
        }
        out.clear();
        out.extend(aims.iter().take(BUNDLE).map(|aim| self.land(aim)));
    }

    /// Returns `true` if it makes ghosts: a `realistic` one that is asked to, and that light paths can be joined to.
    pub fn has_ghosts(&self) -> bool {
        matches!(self, Camera::Realistic(c) if c.has_ghosts())
    }

    /// Gets ready for ghosts that land between these two corners, in raster coordinates. Some hundredths of a second.
    pub fn prepare_ghosts(&mut self, window: [Vec2; 2]) {
        if let Camera::Realistic(c) = self {
            c.prepare_ghosts(window);
        }
    }

    /// Draws a point by `u` where light enters the lens at `time`, to become a ghost; `None` if this camera makes none, or is not ready.
    pub fn ghost_entry(&self, time: f32, wavelength: f32, u: Vec2) -> Option<GhostEntry> {
        match self {
            Camera::Realistic(c) => c.ghost_entry(time, wavelength, u),
            Camera::Projective(_) | Camera::Environment(_) => None,
        }
    }

    /// Where light lands that comes to `entry` from the unit direction `wi`, by one pair of reflections that is drawn by `u`: radiance
    /// counts for [`Landing::importance`] over the density per solid angle of `wi`, without another cosine.
    pub fn ghost(&self, entry: &GhostEntry, wi: Vec3, u: f32) -> Option<Landing> {
        match self {
            Camera::Realistic(c) => c.ghost(entry, wi, u),
            Camera::Projective(_) | Camera::Environment(_) => None,
        }
    }

    /// From where on the film the render-space point at the first of `ends` is seen at the first of these times to where the second is at the second:
    /// pixels to the right and down, through the middle of the lens. `None` where one of them is not seen.
    pub fn shift(&self, ends: [Vec3; 2], times: [f32; 2]) -> Option<Vec2> {
        let [start, end] = ends;
        let shift = self.raster_of(end, times[1])? - self.raster_of(start, times[0])?;
        Some(match self {
            Camera::Environment(c) => c.shorter_way(shift),
            Camera::Projective(_) | Camera::Realistic(_) => shift,
        })
    }

    /// Where on the film a render-space point is seen at `time`, through the middle of the lens.
    fn raster_of(&self, p: Vec3, time: f32) -> Option<Vec2> {
        const MIDDLE: Vec2 = Vec2::splat(0.5);
        let Camera::Realistic(lens) = self else {
            let (_, _, hit) = self.seen(p, time, MIDDLE)?;
            return Some(hit.raster.as_vec2());
        };
        let from = ReferencePoint {
            p,
            time,
            ..Default::default()
        };
        let middle = LensSample {
            lens: MIDDLE,
            wavelength: 0.5,
        };
        lens.seen_at(&from, &middle)
    }

    /// Other film points, up to `reach` pixels (fewer than there are in half the image) outside the image, that have the ray of `raster`: those of an
    /// environment camera, whose image closes around and over the poles. A pixel whose filter reaches outside the image is lit through them too.
    pub fn raster_copies(&self, raster: Vec2, reach: f32) -> ArrayVec<Vec2, 8> {
        match self {
            Camera::Environment(c) => c.raster_copies(raster, reach),
            Camera::Projective(_) | Camera::Realistic(_) => ArrayVec::new(),
        }
    }

    /// 1/κ: the density with which a connection from `p`, which the camera's `ray` of `sample` meets, makes the same ray,
    /// over that with which the camera does; both as in [`Landing::density`]. 0 where no connection makes it.
    pub fn connection_density(&self, sample: &CameraSample, ray: &CameraRay, p: Vec3) -> f32 {
        if let Camera::Realistic(c) = self {
            let density = c.connection_density(sample, ray, p);
            return density.filter(|x| x.is_finite()).unwrap_or(0.0) as f32;
        }
        let Some((placement, x, hit)) = self.seen(p, ray.ray.time, sample.lens) else {
            return 0.0;
        };
        let density = hit.density * placement.area_across(x - hit.origin);
        if density > 0.0 {
            (1.0 / density) as f32
        } else {
            0.0
        }
    }

    /// The camera at `time`, the camera-space point at `p`, and how it is seen, without traced lenses.
    #[inline(always)]
    fn seen(&self, p: Vec3, time: f32, lens: Vec2) -> Option<(Cow<'_, Placement>, DVec3, Hit)> {
        let placement = match self {
            Camera::Projective(c) => c.placement(time)?,
            Camera::Environment(c) => c.placement(time)?,
            Camera::Realistic(_) => return None,
        };
        let x = placement.point(p);
        let hit = match self {
            Camera::Projective(c) => c.hit(x, lens)?,
            Camera::Environment(c) => c.hit(x),
            Camera::Realistic(_) => return None,
        };
        Some((placement, x, hit))
    }
}

/// Direction and shadow ray from a point, `x` in camera space, to `y`, where the camera's ray starts; `None` where clip planes
/// hide the point.
pub(super) fn toward(
    from: &ReferencePoint,
    placement: &Placement,
    x: DVec3,
    y: DVec3,
) -> Option<(Vec3, Ray)> {
    let end = placement.end(x, y)?;
    let wi = (end - from.p.as_dvec3()).try_normalize()?.as_vec3();
    let end = end.as_vec3();
    let mut shadow = from.shadow_ray_to(end, Vec3::ZERO, Vec3::ZERO);
    // No surface lies at the end that must not be met.
    shadow.t_max = shadow.o.distance(end);
    Some((wi, shadow))
}

#[cfg(test)]
mod proof;
#[cfg(test)]
mod tests;
