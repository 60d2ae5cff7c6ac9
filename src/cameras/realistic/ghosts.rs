//! Ghosts in an image: light that enters the lens at a point of its first surface, is reflected twice and comes to the film where it does
//! not belong ([`crate::optics::ghosts`]).
//!
//! It is followed from the lens: a point y of the first surface within its rim is drawn evenly from the rim's disk, of density
//! p = n_z/(π R²) per area of the surface; the caller chooses where light comes to y from; one pair of surfaces is drawn, of probability q; the ray is
//! traced through these reflections, and a share w of its light arrives. Reflections conserve étendue over the squared index as refractions do. So with the
//! importance per étendue k/P of `connection.rs` light of radiance L and density d per solid angle brings
//!
//! L/d · cos θ/p · k/P · w/q
//!
//! to a pixel of area P that it lands in. Camera rays make no such paths, and nothing is weighed against them.
//!
//! Pairs are drawn by the light that they bring to the film from a sky that is white all over, and a part of them evenly. That changes noise only.

use super::{Realistic, camera_from_lens};
use crate::cameras::camera_transform::Placement;
use crate::cameras::connection::Landing;
use crate::math::distribution::Distribution1D;
use crate::math::frame::Frame;
use crate::math::ray::Ray;
use crate::math::sampling::{concentric_disk, cosine_hemisphere};
use crate::math::{DVec3, Rgb, Vec2, Vec3};
use crate::optics::LensRay;
use crate::optics::entrance::{Cap, FilmWindow};
use crate::surface::ReferencePoint;

/// Rays that are traced to find out what pairs bring, over all pairs; at least so many for each.
const SURVEY: usize = 1 << 16;
const MIN_RAYS: usize = 1 << 8;

/// The part of the choice that is even: a pair that the sky hardly sees may be all that a lamp makes.
const EVEN_SHARE: f64 = 0.2;

/// What ghosts need beside the camera.
#[derive(Clone, Debug)]
pub(super) struct GhostSampling {
    cap: Cap,
    /// Of the film's own points.
    window: FilmWindow,
    pairs: Vec<(usize, usize)>,
    choice: Distribution1D,
}

/// A point of the first surface, where light enters.
#[derive(Clone, Copy, Debug)]
pub struct GhostEntry {
    /// The point, its normal toward the scene, in render space.
    pub point: ReferencePoint,
    /// The same in lens coordinates; the normal leans toward the film.
    y: DVec3,
    n: DVec3,
    /// The inverse of the point's density, mm².
    area: f64,
    placement: Placement,
    band: usize,
}

impl Realistic {
    /// Returns `true` if its surfaces reflect.
    pub(in super::super) fn has_ghosts(&self) -> bool {
        self.main.ghosts.is_some() && self.connects()
    }

    /// Finds out which pairs of surfaces bring light between these corners, in raster coordinates.
    pub(in super::super) fn prepare_ghosts(&mut self, window: [Vec2; 2]) {
        let window = self.window(window);
        let made = || {
            let ghosts = self.main.ghosts.as_deref().filter(|_| self.connects())?;
            let cap = Cap::new(&self.main.lens)?;
            let pairs: Vec<(usize, usize)> = ghosts.pairs().collect();
            let count = (SURVEY / pairs.len().max(1)).max(MIN_RAYS);
            let rays: Vec<LensRay<f64>> = sky(&cap, count).collect();
            let brought = |pair: &(usize, usize)| -> f64 {
                let arrivals = rays.iter().filter_map(|ray| ghosts.trace(ray, *pair));
                let seen = arrivals.filter(|arrival| window.holds(arrival.film));
                seen.map(|arrival| arrival.light.iter().sum::<f64>()).sum()
            };
            let brought: Vec<f64> = pairs.iter().map(brought).collect();
            let even = EVEN_SHARE / (1.0 - EVEN_SHARE) * brought.iter().sum::<f64>();
            let even = even / pairs.len().max(1) as f64;
            Some(GhostSampling {
                cap,
                window,
                choice: Distribution1D::new(brought.iter().map(|light| (light + even) as f32)),
                pairs,
            })
        };
        self.ghost_sampling = made().filter(|made| !made.pairs.is_empty()).map(Box::new);
    }

    /// See [`crate::cameras::Camera::ghost_entry`].
    pub(in super::super) fn ghost_entry(
        &self,
        time: f32,
        wavelength: f32,
        u: Vec2,
    ) -> Option<GhostEntry> {
        let sampling = self.ghost_sampling.as_deref()?;
        let (y, n, area) = sampling.cap.point(concentric_disk(u).as_dvec2())?;
        let placement = self.transform.placement(time);
        let p = camera_from_lens(&self.spec).transform_point3(y);
        // Toward the scene: the z axes of camera and lens are opposite.
        let normal = placement.normal(DVec3::new(-n.x, -n.y, n.z));
        Some(GhostEntry {
            point: ReferencePoint {
                p: placement.placed(p).as_vec3(),
                n: normal.as_vec3(),
                time,
                ..Default::default()
            },
            y,
            n,
            area,
            placement: placement.into_owned(),
            band: self.band(wavelength),
        })
    }

    /// See [`crate::cameras::Camera::ghost`].
    pub(in super::super) fn ghost(&self, entry: &GhostEntry, wi: Vec3, u: f32) -> Option<Landing> {
        let sampling = self.ghost_sampling.as_deref()?;
        let optics = self.of_band(entry.band);
        let ghosts = optics.ghosts.as_deref()?;
        let d = entry.placement.direction(-wi);
        let d = DVec3::new(d.x, d.y, -d.z);
        let (d, length) = (d.normalize(), d.length());
        let cosine = entry.n.dot(d);
        let enters = cosine > 0.0;
        if !enters {
            return None;
        }
        let (pair, probability, _) = sampling.choice.sample_discrete(u);
        let ray = LensRay {
            o: entry.y.to_array(),
            d: d.to_array(),
        };
        let arrival = ghosts.trace(&ray, *sampling.pairs.get(pair)?)?;
        let LensRay { o, d: out } = arrival.ray;
        let behind = [0, 1, 2].map(|i| o[i] - out[i]);
        let film = match &self.tilted {
            None => arrival.film,
            Some(tilted) => tilted.from_flat(arrival.film, behind),
        };
        if !sampling.window.holds(film) || self.is_behind(film, behind) {
            return None;
        }
        let etendue = entry.area * cosine * self.solid_angle_in_lens(&entry.placement, d, length);
        let importance = self.importance(optics) * etendue / f64::from(probability);
        let light = arrival.light.map(|share| (share * importance) as f32);
        let landing = Landing {
            raster: self.raster(film),
            importance: Rgb::from(light) * optics.band_tint,
            density: 0.0,
        };
        landing.importance.is_finite().then_some(landing)
    }

    /// Solid angle in lens coordinates about the unit direction `d` over that in render space, of which a unit direction had `length` in camera space.
    ///
    /// A linear map M multiplies solid angles by |det M|/|M d|³, and areas across d by |det M|/|M d|.
    fn solid_angle_in_lens(&self, placement: &Placement, d: DVec3, length: f64) -> f64 {
        let length = length * self.camera_unit();
        self.area_across(placement, d) / (length * length)
    }
}

impl GhostEntry {
    /// The part of a `shadow` ray from the point that the camera's clip planes leave; `None` where they hide its end.
    pub fn clipped(&self, shadow: &Ray) -> Option<Ray> {
        self.placement.clipped(shadow)
    }
}

/// So many rays from a white sky onto the first surface.
fn sky(cap: &Cap, count: usize) -> impl Iterator<Item = LensRay<f64>> {
    (0..count).filter_map(|i| {
        // Four coordinates of the R sequence (Roberts 2018).
        let r = |k: i32| (0.5 + (i + 1) as f64 / 1.167_303_978_261_418_7f64.powi(k)).fract() as f32;
        let (y, n, _) = cap.point(concentric_disk(Vec2::new(r(1), r(2))).as_dvec2())?;
        let toward = cosine_hemisphere(Vec2::new(r(3), r(4)));
        let d = Frame::from_normal(n.as_vec3()).to_world(toward).as_dvec3();
        Some(LensRay::new(y.to_array(), d.to_array()))
    })
}

#[cfg(test)]
mod tests;
