//! Subsurface scattering: light that enters a surface at one point and leaves it at another, by separable BSSRDFs
//! (Pharr, Jakob and Humphreys 2016, §11.4 and §15.4).
//!
//! S(po, ωo, pi, ωi) = (1 − F(cosθo)) Sp(|po − pi|) Sw(ωi): Fresnel transmission at either end, and a profile of the
//! distance in between. The factor for ωo belongs to the surface's own BSDF, which has sampled transmission; [`Bssrdf`]
//! is Sp, and [`crate::bsdf::subsurface_exit`] is Sw.

mod beam_diffusion;
mod profile;
mod table;

pub use profile::{NormalizedChannel, Profile, TabulatedChannel};
pub use table::ProfileTable;

use crate::bsdf::subsurface_exit::SubsurfaceExit;
use crate::math::frame::Frame;
use crate::math::{Rgb, Vec2, Vec3};
use crate::surface::SurfaceHit;
use std::f32::consts::PI;

/// Shortest mean free path, in units of the hit point's position error: shorter ones cannot be resolved, and neither
/// could the image.
const FINEST_IN_ERRORS: f32 = 16.0;

/// Probabilities of probing along the frame's s, t and n: most exits are found along the normal.
const AXIS_CHANCES: [f32; 3] = [0.25, 0.25, 0.5];

/// The BSSRDF at a point where light leaves; describes where it may have entered.
#[derive(Clone, Copy, Debug)]
pub struct Bssrdf<'a> {
    p: Vec3,
    frame: Frame,
    profile: Profile<'a>,
    /// Probe radius of each channel; 0 for a channel that returns no light.
    reach: [f32; 3],
    exit: SubsurfaceExit,
}

/// A line segment along which to look for the other point.
#[derive(Clone, Copy, Debug)]
pub struct Probe {
    /// Where it starts.
    pub o: Vec3,
    /// Unit direction.
    pub d: Vec3,
    /// Its length.
    pub length: f32,
    /// A sample in [0, 1) to choose among the intersections.
    pub choice: f32,
}

/// The shortest length at which subsurface scattering can be distinguished from surface scattering at a point.
pub fn finest_length(surface: &SurfaceHit) -> f32 {
    // At the origin itself positions are exact; one over the square of the length, times a large density, must stay
    // finite.
    (FINEST_IN_ERRORS * surface.p_error.max_element()).max(1e-15)
}

impl<'a> Bssrdf<'a> {
    /// At `surface` with the shading frame `frame`; where light enters, it is scattered as `exit` describes.
    pub fn new(
        surface: &SurfaceHit,
        frame: Frame,
        profile: Profile<'a>,
        exit: SubsurfaceExit,
    ) -> Bssrdf<'a> {
        Bssrdf {
            p: surface.p,
            frame,
            profile,
            reach: std::array::from_fn(|channel| profile.reach(channel).unwrap_or(0.0)),
            exit,
        }
    }

    /// Burley's normalized diffusion (the Disney material): `albedo` is the fraction of entering light that exits
    /// again, `distance` the scale of the shorter exponential in scene units, `eta` the medium's relative refractive
    /// index, positive.
    pub fn normalized(
        surface: &SurfaceHit,
        frame: Frame,
        albedo: Rgb,
        distance: Rgb,
        eta: f32,
    ) -> Bssrdf<'a> {
        let finest = finest_length(surface);
        let channels =
            std::array::from_fn(|c| NormalizedChannel::new(albedo[c], distance[c], finest));
        let exit = SubsurfaceExit::new(eta);
        Bssrdf::new(surface, frame, Profile::Normalized(channels), exit)
    }

    /// Samples a probe segment along one of the three axes, at a radius sampled for one of the three channels
    /// (§15.4.2). `None` if no light exits. `uc` and `u` in [0, 1).
    pub fn probe(&self, uc: f32, u: Vec2) -> Option<Probe> {
        let Frame { s, t, n } = self.frame;
        let ([x, y, z], uc) = match uc {
            uc if uc < 0.5 => ([s, t, n], uc * 2.0),
            uc if uc < 0.75 => ([t, n, s], (uc - 0.5) * 4.0),
            uc => ([n, s, t], (uc - 0.75) * 4.0),
        };
        let scaled = uc * 3.0;
        let channel = (scaled as usize).min(2);
        let r = self.profile.sample(channel, u.x)?;
        let reach = self.reach[channel];
        if r >= reach {
            return None;
        }
        let (sin, cos) = (2.0 * PI * u.y).sin_cos();
        let half = ((reach - r) * (reach + r)).sqrt();
        Some(Probe {
            o: self.p + r * (x * cos + y * sin) - half * z,
            d: z,
            length: 2.0 * half,
            choice: scaled - channel as f32,
        })
    }

    /// The density per area with which [`Bssrdf::probe`] hits the surface at `p`, whose unit geometric normal is `n`:
    /// the sum over all axes and channels (multiple importance sampling with the balance heuristic). A channel whose
    /// probes end before they reach `p` does not contribute; pbrt-v3 counts its density all the same, and so loses
    /// light where a surface curves away.
    pub fn pdf(&self, p: Vec3, n: Vec3) -> f32 {
        let d = self.frame.to_local(p - self.p);
        let distance = d.length();
        let cosines = self.frame.to_local(n).abs();
        let mut pdf = 0.0;
        for axis in 0..3 {
            let projected = Vec2::new(d[(axis + 1) % 3], d[(axis + 2) % 3]).length();
            let reaching = (0..3).filter(|&c| distance <= self.reach[c]);
            let channels: f32 = reaching.map(|c| self.profile.pdf(c, projected)).sum();
            pdf += AXIS_CHANCES[axis] * cosines[axis] * channels / 3.0;
        }
        pdf
    }

    /// Sp: the fraction of the light entering at `p` that exits here, per area.
    pub fn value(&self, p: Vec3) -> Rgb {
        self.profile.value((p - self.p).length())
    }

    /// The lobe by which light enters there.
    pub fn exit(&self) -> SubsurfaceExit {
        self.exit
    }
}

#[cfg(test)]
mod tests;
