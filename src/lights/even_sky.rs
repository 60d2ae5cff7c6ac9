//! Sampling of an infinite light of constant radiance, by the receiver's cosine.
//!
//! The geometric normal of a surface decides which hemisphere contributes, the shading normal gives the cosine (Pharr, Jakob and Humphreys 2016,
//! §9.1). Where the shading normal is tilted, light contributes that comes from behind it. BSDF sampling finds none of that, so light
//! sampling has to.

use crate::math::frame::{Frame, coordinate_system};
use crate::math::sampling::{
    UNIFORM_SPHERE_PDF, concentric_disk, cosine_hemisphere, cosine_hemisphere_pdf, uniform_sphere,
};
use crate::math::{Vec2, Vec3};
use crate::surface::{ReceiverSide, ReferencePoint};

/// The part of the directions that is chosen uniformly where BSDF sampling does not compete (MIS): the cosine vanishes at the horizon,
/// but perhaps not what is scattered.
const UNIFORM_SHARE: f32 = 0.125;

/// The smallest part behind a shading normal that has samples of its own: a tilt of 11 degrees. Below that the sky's densities, which are made for
/// classes of normals, cover it.
const MIN_BEHIND: f32 = 0.01;

/// The share of the samples that go behind the normal, over the part of an even sky's irradiance that comes from there. The others follow the sky,
/// which may be brightest there, too.
const BEHIND_SHARE: f32 = 0.5;

/// A direction and its density: by the cosine at a surface, on the sides that count; uniform in a medium.
pub(super) fn sample(from: &ReferencePoint, u: Vec2) -> (Vec3, f32) {
    let uniform = uniform_share(from);
    let wi = if u.x < uniform {
        uniform_sphere(Vec2::new(u.x / uniform, u.y))
    } else {
        let x = (u.x - uniform) / (1.0 - uniform);
        let by_cosine = |y| around(normal(from), Vec2::new(x, y));
        match from.receiver_side {
            ReceiverSide::Front => toward(from.n, by_cosine(u.y)),
            ReceiverSide::Back => toward(-from.n, by_cosine(u.y)),
            _ if u.y < 0.5 => by_cosine(2.0 * u.y),
            _ => -by_cosine(2.0 * u.y - 1.0),
        }
    };
    (wi, pdf(from, wi))
}

/// Density of [`sample`].
pub(super) fn pdf(from: &ReferencePoint, wi: Vec3) -> f32 {
    let by_cosine = cosine_hemisphere_pdf(normal(from).dot(wi).abs());
    let side = from.n.dot(wi);
    let by_cosine = match from.receiver_side {
        ReceiverSide::Front if side < 0.0 => 0.0,
        ReceiverSide::Back if side > 0.0 => 0.0,
        ReceiverSide::Front | ReceiverSide::Back => by_cosine,
        ReceiverSide::NoMis | ReceiverSide::BothSides => 0.5 * by_cosine,
    };
    let uniform = uniform_share(from);
    uniform * UNIFORM_SPHERE_PDF + (1.0 - uniform) * by_cosine
}

fn uniform_share(from: &ReferencePoint) -> f32 {
    match from.receiver_side {
        _ if from.n == Vec3::ZERO => 1.0,
        ReceiverSide::NoMis => UNIFORM_SHARE,
        _ => 0.0,
    }
}

/// The normal by whose cosine light counts.
fn normal(from: &ReferencePoint) -> Vec3 {
    match from.receiver_side {
        ReceiverSide::NoMis => from.n,
        _ => from.shading_n,
    }
}

fn around(n: Vec3, u: Vec2) -> Vec3 {
    Frame::from_normal(n).to_world(cosine_hemisphere(u))
}

/// `d`, or the opposite where that is on the side of `n`.
fn toward(n: Vec3, d: Vec3) -> Vec3 {
    if d.dot(n) < 0.0 { -d } else { d }
}

/// The part of a sky that lies behind a tilted shading normal, on the side of the true one that counts: a lune.
#[derive(Clone, Copy, Debug)]
pub(super) struct BehindNormal {
    /// The true normal, turned to the side that counts.
    n: Vec3,
    /// The opposite of the shading normal.
    away: Vec3,
    /// The cosine between the true and the shading normal: below 0 where the ray meets one from its front and the other from behind.
    cosine: f32,
    /// The part of the irradiance that comes from here, if the sky is even.
    part: f32,
}

impl BehindNormal {
    /// `None` where there is little of it.
    #[inline]
    pub(super) fn new(from: &ReferencePoint) -> Option<BehindNormal> {
        let n = match from.receiver_side {
            ReceiverSide::Front => from.n,
            ReceiverSide::Back => -from.n,
            ReceiverSide::NoMis | ReceiverSide::BothSides => return None,
        };
        let cosine = from.shading_n.dot(n);
        let part = 0.5 * (1.0 - cosine);
        let is_tilted = part > MIN_BEHIND && n != Vec3::ZERO;
        is_tilted.then_some(BehindNormal {
            n,
            away: -from.shading_n,
            cosine,
            part,
        })
    }

    /// A direction from this part by the cosine, if these numbers choose it.
    pub(super) fn sample(&self, u: Vec2) -> Option<Vec3> {
        let share = BEHIND_SHARE * self.part;
        if u.x >= share {
            return None;
        }
        let across = (self.n + self.cosine * self.away).try_normalize();
        let across = across.unwrap_or_else(|| coordinate_system(self.away).0);
        // In the disk below the hemisphere the lune lies between half of an ellipse and half of the circle: half a disk, narrowed and shifted.
        let disk = concentric_disk(Vec2::new(u.x / share, u.y));
        let widest = (1.0 - disk.y * disk.y).max(0.0).sqrt();
        let x = self.cosine * widest + (1.0 - self.cosine) * disk.x.abs();
        let z = (widest * widest - x * x).max(0.0).sqrt();
        Some(x * across + disk.y * self.away.cross(across) + z * self.away)
    }

    /// The numbers for the sky's samples, if they do not.
    pub(super) fn rest(&self, u: Vec2) -> Vec2 {
        let share = BEHIND_SHARE * self.part;
        Vec2::new((u.x - share) / (1.0 - share), u.y)
    }

    /// The density of `d` where the sky's samples have the density `of_sky`.
    pub(super) fn pdf(&self, d: Vec3, of_sky: f32) -> f32 {
        let by_cosine = if self.n.dot(d) > 0.0 {
            // The integral of this is the part.
            cosine_hemisphere_pdf(self.away.dot(d))
        } else {
            0.0
        };
        BEHIND_SHARE * by_cosine + (1.0 - BEHIND_SHARE * self.part) * of_sky
    }
}
