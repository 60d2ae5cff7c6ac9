//! Radial profiles of scattering media, tabulated over albedo and distance
//! (Pharr, Jakob and Humphreys 2016, §11.4.2 and §15.5.4).

use super::beam_diffusion::BeamDiffusion;
use crate::bsdf::subsurface_exit::SubsurfaceExit;
use crate::math::spline::{self, Weights};
use rayon::prelude::*;
use std::f64::consts::PI;

/// Number of tabulated albedos, as in pbrt-v3.
const ALBEDOS: usize = 100;

/// Number of tabulated distances, as in pbrt-v3: 0, then from 0.0025 to 200 mean free paths.
const RADII: usize = 64;

/// Profiles for one mean scattering cosine and one refractive index, tabulated over albedo and distance in mean free
/// paths.
#[derive(Clone, Debug, PartialEq)]
pub struct ProfileTable {
    albedos: Vec<f32>,
    radii: Vec<f32>,
    /// 2πr E(r) for each albedo: the density of light per unit of distance.
    profile: Vec<f32>,
    /// Its cumulative integral.
    integral: Vec<f32>,
    /// The whole integral for each albedo: the fraction of the light that exits again.
    effective_albedos: Vec<f32>,
    exit: SubsurfaceExit,
}

impl ProfileTable {
    /// The table for a medium with mean scattering cosine `g` (-1…1) and refractive index `eta`, positive, relative to
    /// the outside. Takes some 10 ms on one core.
    pub fn new(g: f32, eta: f32) -> ProfileTable {
        // Dense near 1, where a little absorption makes a large difference.
        let last = (ALBEDOS - 1) as f64;
        let albedo = |i: usize| (1.0 - (-8.0 * i as f64 / last).exp()) / (1.0 - (-8f64).exp());
        let albedos: Vec<f32> = (0..ALBEDOS).map(|i| albedo(i) as f32).collect();
        let outward = std::iter::successors(Some(2.5e-3), |r| Some(r * 1.2));
        let radii: Vec<f32> = std::iter::once(0.0).chain(outward).take(RADII).collect();
        let medium = BeamDiffusion::new(f64::from(g), f64::from(eta));
        let single: Vec<f64> = radii.iter().map(|&r| medium.single(f64::from(r))).collect();
        let rows = albedos.par_iter().map(|&albedo| {
            let density = |(&r, &single): (&f32, &f64)| {
                let r = f64::from(r);
                (2.0 * PI * r * medium.exitance(f64::from(albedo), r, single)) as f32
            };
            let profile: Vec<f32> = radii.iter().zip(&single).map(density).collect();
            let integral = spline::integrals(&radii, |i| profile[i]);
            (profile, integral)
        });
        let rows: Vec<_> = rows.collect();
        let (profile, integral): (Vec<_>, Vec<_>) = rows.into_iter().unzip();
        ProfileTable {
            effective_albedos: integral.iter().map(|row| row[RADII - 1]).collect(),
            albedos,
            radii,
            profile: profile.concat(),
            integral: integral.concat(),
            exit: SubsurfaceExit::new(eta),
        }
    }

    /// The lobe by which light enters the medium.
    pub fn exit(&self) -> SubsurfaceExit {
        self.exit
    }

    /// The profile at `albedo`; values outside 0…1 are clamped, and NaN is taken as 0.
    pub fn row(&self, albedo: f32) -> Row<'_> {
        let albedo = if albedo > 0.0 { albedo.min(1.0) } else { 0.0 };
        let weights = Weights::new(&self.albedos, albedo);
        let effective = weights.map_or(0.0, |w| w.sum(|i| self.effective_albedos[i]).max(0.0));
        Row {
            table: self,
            weights,
            effective,
        }
    }

    /// The single-scattering albedo for which the medium returns the fraction `effective` of the light (0…1); the
    /// nearest possible one if there is none (§11.4.2).
    pub fn invert(&self, effective: f32) -> f32 {
        spline::invert(&self.albedos, &self.effective_albedos, effective).unwrap_or(0.0)
    }
}

/// The profile at one albedo. Distances are in mean free paths.
#[derive(Clone, Copy, Debug)]
pub struct Row<'a> {
    table: &'a ProfileTable,
    weights: Option<Weights>,
    effective: f32,
}

impl Row<'_> {
    /// The fraction of the light that exits again.
    pub fn effective_albedo(&self) -> f32 {
        self.effective
    }

    /// 2πr E(r), which integrates to the effective albedo; 0 beyond the table.
    pub fn density(&self, r: f32) -> f32 {
        let Some((weights, at)) = self.weights.zip(Weights::new(&self.table.radii, r)) else {
            return 0.0;
        };
        let value = |i: usize| at.sum(|j| self.table.profile[i * RADII + j]);
        weights.sum(value).max(0.0)
    }

    /// Samples a distance with density [`Row::density`] over the effective albedo; `None` if no light exits. `u` in [0,
    /// 1).
    pub fn sample(&self, u: f32) -> Option<f32> {
        let weights = self.weights?;
        let mixed = |table: &[f32], j: usize| weights.sum(|i| table[i * RADII + j]);
        let ProfileTable {
            profile,
            integral,
            radii,
            ..
        } = self.table;
        let drawn = spline::sample(radii, |j| mixed(profile, j), |j| mixed(integral, j), u)?;
        Some(drawn.x)
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use std::sync::OnceLock;

    /// Milk in water, computed once for all tests.
    pub(crate) fn water() -> &'static ProfileTable {
        static TABLE: OnceLock<ProfileTable> = OnceLock::new();
        TABLE.get_or_init(|| ProfileTable::new(0.0, 1.33))
    }

    #[test]
    fn profiles_integrate_to_the_effective_albedo() {
        for albedo in [0.01, 0.3, 0.7, 0.95, 0.999, 1.0] {
            let row = water().row(albedo);
            let steps = 200_000;
            let end = water().radii[RADII - 1];
            // Equal steps in the square root of the distance resolve the steep beginning.
            let width = end.sqrt() / steps as f32;
            let mut sum = 0.0;
            for i in 0..steps {
                let s = (i as f32 + 0.5) * width;
                sum += f64::from(row.density(s * s) * 2.0 * s * width);
            }
            // Single precision of the table.
            let effective = f64::from(row.effective_albedo());
            assert!(
                (sum - effective).abs() < 1e-4 * effective,
                "{albedo}: {sum} for {effective}"
            );
        }
    }

    #[test]
    fn inversion_gives_the_effective_albedo_back() {
        for k in 1..100 {
            let wanted = k as f32 / 100.0;
            let found = water().row(water().invert(wanted)).effective_albedo();
            let most = water().row(1.0).effective_albedo();
            assert!((found - wanted.min(most)).abs() < 1e-4, "{wanted}: {found}");
        }
        assert_eq!(water().invert(-1.0), 0.0);
        assert_eq!(water().invert(f32::NAN), 0.0);
        assert_eq!(water().invert(2.0), 1.0);
    }

    #[test]
    fn black_media_return_nothing() {
        for albedo in [0.0, -1.0, f32::NAN] {
            let row = water().row(albedo);
            assert_eq!((row.effective_albedo(), row.sample(0.5)), (0.0, None));
            assert_eq!(row.density(1.0), 0.0);
        }
    }

    #[test]
    fn distances_follow_the_profile() {
        // The fraction of the light within the u-quantile is u.
        for albedo in [0.2, 0.9, 1.0] {
            let row = water().row(albedo);
            for k in 0..20 {
                let u = (k as f32 + 0.5) / 20.0;
                let r = row.sample(u).unwrap();
                let steps = 20_000;
                let width = r.sqrt() / steps as f32;
                let part: f64 = (0..steps)
                    .map(|i| (i as f32 + 0.5) * width)
                    .map(|s| f64::from(row.density(s * s) * 2.0 * s * width))
                    .sum();
                let share = part / f64::from(row.effective_albedo());
                // Single precision of the table and of the sums.
                assert!(
                    (share - f64::from(u)).abs() < 2e-4,
                    "{albedo}: {share} for {u}"
                );
            }
        }
    }
}
