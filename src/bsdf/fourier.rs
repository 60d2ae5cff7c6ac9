//! Tabulated isotropic BSDFs as splines of Fourier series (Pharr, Jakob and Humphreys 2016, §8.6 and
//! §14.1.4; Jakob et al. 2014). Directions are local.
//!
//! The cosines follow pbrt's convention: μi is that of the incident light's direction of travel, which points toward
//! the surface, μo that of the outgoing direction; so μi μo < 0 is reflection.

use super::lobe::TableLobe;
use super::lobe_sample::LobeSample;
use crate::assets::bsdf_file::{BsdfFile, Series};
use crate::math::spline::{self, Weights};
use crate::math::{Rgb, Vec2, Vec3};
use arrayvec::ArrayVec;
use std::f64::consts::PI;
use std::fmt;

/// Number of cosines computed at a time, so that sums over them are over arrays.
const CHUNK: usize = 64;

/// Series of up to this length are combined once before they are inverted; longer ones, as of glossy surfaces at
/// grazing angles, are summed in each step.
const MIXED: usize = 1024;

/// A tabulated BSDF.
#[derive(Clone, PartialEq)]
pub struct FourierTable {
    file: BsdfFile,
    /// a₀ of luminance for each pair, μo varying more slowly: the mean over azimuth.
    means: Vec<f32>,
    /// Cumulative integrals over μi of the splines through `means`, for each μo.
    integrals: Vec<f32>,
}

impl fmt::Debug for FourierTable {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let BsdfFile { eta, channels, .. } = self.file;
        let count = self.file.cosines.len();
        write!(
            f,
            "FourierTable {{ η {eta}, {channels} channels, {count} cosines }}"
        )
    }
}

/// The Fourier series of one pair of directions and one channel, as a weighted sum of tabulated ones.
type Terms<'a> = ArrayVec<(f32, &'a [f32]), 16>;

impl FourierTable {
    /// From the contents of a file.
    pub fn new(file: BsdfFile) -> FourierTable {
        let mean = |s: &Series| match s.length {
            0 => 0.0,
            _ => file.coefficients[s.start],
        };
        let means: Vec<f32> = file.series.iter().map(mean).collect();
        let rows = means.chunks(file.cosines.len());
        let integrals = rows
            .flat_map(|row| spline::integrals(&file.cosines, |i| row[i]))
            .collect();
        FourierTable {
            file,
            means,
            integrals,
        }
    }

    /// Returns `true` if nothing is scattered at all.
    pub fn is_black(&self) -> bool {
        self.means.iter().all(|&a| a <= 0.0)
    }

    /// The series at these cosines in `channel`; empty if a cosine is outside the table.
    fn terms(&self, mu_i: f32, mu_o: f32, channel: usize) -> Terms<'_> {
        let mut terms = Terms::new();
        let n = self.file.cosines.len();
        let at = |mu| Weights::new(&self.file.cosines, mu);
        let Some((inward, outward)) = at(mu_i).zip(at(mu_o)) else {
            return terms;
        };
        for (o, weight_o) in outward.terms() {
            for (i, weight_i) in inward.terms() {
                let Series { start, length } = self.file.series[o * n + i];
                let start = start + channel * length;
                let weight = weight_o * weight_i;
                if weight != 0.0 && length > 0 {
                    terms.push((weight, &self.file.coefficients[start..start + length]));
                }
            }
        }
        terms
    }

    /// Factor from the tabulated BSDF times |μi| to the BSDF for radiance, including the scaling of radiance for
    /// transmission.
    fn scale(&self, mu_i: f32, mu_o: f32) -> f32 {
        let medium = if mu_i * mu_o > 0.0 {
            self.eta(mu_o).powi(-2)
        } else {
            1.0
        };
        if mu_i != 0.0 {
            medium / mu_i.abs()
        } else {
            0.0
        }
    }

    /// Relative refractive index: that of the opposite side over that on the side of cosine `mu_o`.
    fn eta(&self, mu_o: f32) -> f32 {
        if mu_o > 0.0 {
            self.file.eta
        } else {
            self.file.eta.recip()
        }
    }

    /// ∫ of luminance times |μi| over all incident directions.
    fn whole(&self, mu_o: f32) -> f32 {
        let n = self.file.cosines.len();
        let whole = |weights: Weights| weights.sum(|o| self.integrals[o * n + n - 1]);
        2.0 * std::f32::consts::PI * Weights::new(&self.file.cosines, mu_o).map_or(0.0, whole)
    }
}

/// A lobe that scatters according to a table.
pub type FourierLobe<'a> = TableLobe<'a, FourierTable>;

impl FourierLobe<'_> {
    /// Value in 1/sr, for radiance.
    pub fn f(&self, wo: Vec3, wi: Vec3) -> Rgb {
        let (mu_i, mu_o) = (-wi.z, wo.z);
        let cos_phi = cos_azimuth(-wi, wo);
        let value = |channel| evaluate(&self.table.terms(mu_i, mu_o, channel), cos_phi);
        let luminance = value(0).max(0.0);
        let scale = self.table.scale(mu_i, mu_o);
        if self.table.file.channels == 1 {
            return luminance * scale * self.share;
        }
        let (red, blue) = (value(1), value(2));
        let green = 1.39829 * luminance - 0.100913 * blue - 0.297375 * red;
        (Rgb::new(red, green, blue) * scale).max(Rgb::ZERO) * self.share
    }

    /// Density of [`FourierLobe::sample`] per solid angle.
    pub fn pdf(&self, wo: Vec3, wi: Vec3) -> f32 {
        let terms = self.table.terms(-wi.z, wo.z, 0);
        let value = evaluate(&terms, cos_azimuth(-wi, wo));
        let whole = self.table.whole(wo.z);
        if whole > 0.0 && value > 0.0 {
            value / whole
        } else {
            0.0
        }
    }

    /// Samples a direction in proportion to luminance times cosine: first μi from the spline of the means, then the
    /// azimuth from the series there.
    pub fn sample(&self, wo: Vec3, u: Vec2) -> Option<LobeSample> {
        let FourierTable {
            file,
            means,
            integrals,
        } = self.table;
        let n = file.cosines.len();
        let outward = Weights::new(&file.cosines, wo.z)?;
        let mixed = |table: &[f32], i: usize| outward.sum(|o| table[o * n + i]);
        let drawn = spline::sample(
            &file.cosines,
            |i| mixed(means, i),
            |i| mixed(integrals, i),
            u.y,
        )?;
        let mu_i = drawn.x;
        let phi = sample_azimuth(&self.table.terms(mu_i, wo.z, 0), u.x)?;
        let (sin, cos) = phi.sin_cos();
        // `wo` rotated by φ and tilted to μi; at the pole any azimuth will do.
        let sine = (1.0 - mu_i * mu_i).max(0.0).sqrt();
        let across = wo.truncate().try_normalize().unwrap_or(Vec2::X);
        let toward = Vec2::new(cos, sin).rotate(across);
        let wi = -(sine * toward).extend(mu_i);
        let wi = wi.try_normalize()?;
        let sample = LobeSample::evaluated(wi, self.pdf(wo, wi), || self.f(wo, wi))?;
        Some(match wi.z * wo.z < 0.0 {
            true => sample.transmitted(self.table.eta(wo.z)),
            false => sample,
        })
    }
}

/// Cosine of the difference of azimuths; 1 if one of them is undefined.
fn cos_azimuth(a: Vec3, b: Vec3) -> f32 {
    let (a, b) = (a.truncate(), b.truncate());
    let lengths = (a.length_squared() * b.length_squared()).sqrt();
    if lengths > 0.0 {
        (a.dot(b) / lengths).clamp(-1.0, 1.0)
    } else {
        1.0
    }
}

/// Σ over all series of their weights times Σ aₖ cₖ, where `factors` gives c₀, c₁, … in turn.
fn sum(terms: &[(f32, &[f32])], mut factors: impl FnMut() -> f64) -> f64 {
    let longest = terms
        .iter()
        .map(|(_, series)| series.len())
        .max()
        .unwrap_or(0);
    let mut total = 0.0;
    for start in (0..longest).step_by(CHUNK) {
        let mut chunk = [0.0f32; CHUNK];
        let count = CHUNK.min(longest - start);
        chunk[..count]
            .iter_mut()
            .for_each(|c| *c = factors() as f32);
        for (weight, series) in terms {
            let part = series.get(start..).unwrap_or_default();
            let products: f32 = part.iter().zip(&chunk).map(|(a, c)| a * c).sum();
            total += f64::from(weight * products);
        }
    }
    total
}

/// cos 0, cos φ, cos 2φ, … by the recurrence cos (k+1)φ = 2 cos φ cos kφ − cos (k−1)φ, in double precision so that
/// errors stay small over thousands of terms.
fn cosines(cos_phi: f64) -> impl FnMut() -> f64 {
    let (mut before, mut now) = (cos_phi, 1.0);
    move || {
        let this = now;
        (before, now) = (now, 2.0 * cos_phi * now - before);
        this
    }
}

/// Value of a series.
fn evaluate(terms: &[(f32, &[f32])], cos_phi: f32) -> f32 {
    sum(terms, cosines(f64::from(cos_phi))) as f32
}

/// Samples an azimuth in 0…2π in proportion to a series, by inversion: the series is even, so one half of the circle is
/// searched and a bit of `u` says which. `None` if its mean is not positive.
fn sample_azimuth(terms: &Terms, u: f32) -> Option<f32> {
    let longest = terms.iter().map(|(_, series)| series.len()).max()?;
    if longest > MIXED {
        return invert(terms, u);
    }
    let mut mixed = [0.0f32; MIXED];
    for (weight, series) in terms {
        for (sum, a) in mixed.iter_mut().zip(*series) {
            *sum += weight * a;
        }
    }
    invert(&[(1.0, &mixed[..longest])], u)
}

fn invert(terms: &[(f32, &[f32])], u: f32) -> Option<f32> {
    let mean = sum(terms, {
        let mut first = 1.0;
        move || std::mem::replace(&mut first, 0.0)
    });
    if mean.is_nan() || mean <= 0.0 {
        return None;
    }
    let (half, mirrored) = if u < 0.5 {
        (2.0 * u, false)
    } else {
        (2.0 * u - 1.0, true)
    };
    let t = spline::solve(f64::from(half), f64::from(half), |t| {
        let phi = PI * t;
        let value = sum(terms, cosines(phi.cos()));
        // ∫ of Σ aₖ cos kφ is a₀ φ + Σ aₖ sin(kφ)/k.
        let (sin, cos) = phi.sin_cos();
        let (mut before, mut now, mut k) = (-sin, 0.0, 0.0);
        let integral = sum(terms, || {
            let this = if k == 0.0 { phi } else { now / k };
            (before, now) = (now, 2.0 * cos * now - before);
            k += 1.0;
            this
        });
        (integral / (PI * mean), value / mean)
    });
    let phi = (PI * t) as f32;
    Some(if mirrored {
        2.0 * std::f32::consts::PI - phi
    } else {
        phi
    })
}

#[cfg(test)]
pub(crate) mod tests;
