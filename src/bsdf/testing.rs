//! Statistical tests for BSDFs, and numerical integration over directions.

use super::{Bsdf, BsdfSample};
use crate::math::hash::{mix2, unit_float};
use crate::math::sampling::BELOW_ONE;
use crate::math::{Rgb, Vec2, Vec3};
use crate::surface::{ShadingGeometry, SurfaceHit};
use statrs::distribution::{ChiSquared, ContinuousCDF};
use std::f64::consts::PI;

/// Probability that a correct BSDF fails one chi-squared test. Samples are fixed, so a test that passes once always
/// does; a few dozen tests together have a probability of 1 in 300 of ever failing.
const FALSE_ALARM: f64 = 1e-4;

/// Minimum expected samples in a bin for the chi-squared statistic to follow its distribution.
const MIN_EXPECTED: f64 = 5.0;

/// A flat surface at the origin, normal +z, seen from `wo`.
pub(crate) fn flat_hit(wo: Vec3) -> SurfaceHit {
    let shading = ShadingGeometry {
        n: Vec3::Z,
        dpdu: Vec3::X,
        dpdv: Vec3::Y,
        dndu: Vec3::ZERO,
        dndv: Vec3::ZERO,
    };
    SurfaceHit {
        p: Vec3::ZERO,
        p_error: Vec3::ZERO,
        n: Vec3::Z,
        uv: Vec2::splat(0.5),
        dpdu: Vec3::X,
        dpdv: Vec3::Y,
        shading,
        wo,
        time: 0.0,
        face: 0,
    }
}

/// The direction at `degrees` from the normal +z, with azimuth `azimuth` in degrees.
pub(crate) fn direction(degrees: f32, azimuth: f32) -> Vec3 {
    let (sin, cos) = degrees.to_radians().sin_cos();
    let (sin_phi, cos_phi) = azimuth.to_radians().sin_cos();
    Vec3::new(sin * cos_phi, sin * sin_phi, cos)
}

/// Three independent uniform samples in [0, 1).
pub(crate) fn random(i: u64) -> (f32, Vec2) {
    (
        unit_float(mix2(i, 1)),
        Vec2::new(unit_float(mix2(i, 2)), unit_float(mix2(i, 3))),
    )
}

/// ∫ of `g` over the sphere, by the midpoint rule in the angle to z and in azimuth: `steps` times
/// 2 `steps` points, dense around the poles, where glossy lobes at normal incidence are narrow.
pub(crate) fn integrate(steps: usize, mut g: impl FnMut(Vec3) -> Rgb) -> Rgb {
    let mut sum = glam::DVec3::ZERO;
    visit_sphere(steps, |w, solid_angle| sum += g(w).as_dvec3() * solid_angle);
    sum.as_vec3()
}

/// The points and weights of [`integrate`].
fn visit_sphere(steps: usize, mut visit: impl FnMut(Vec3, f64)) {
    let step = PI / steps as f64;
    for i in 0..steps {
        let (sin, cos) = ((i as f64 + 0.5) * step).sin_cos();
        // Exact for the band, so that the weights add up to 4π.
        let solid_angle = sin * 2.0 * (step / 2.0).sin() * step;
        for j in 0..2 * steps {
            let (sin_phi, cos_phi) = ((j as f64 + 0.5) * step).sin_cos();
            visit(
                Vec3::new((sin * cos_phi) as f32, (sin * sin_phi) as f32, cos as f32),
                solid_angle,
            );
        }
    }
}

/// Radiance toward `wo` under a uniform sky of radiance 1, by integrating [`Bsdf::f`] and adding the specular
/// directions.
pub(crate) fn sky_by_value(bsdf: &Bsdf, wo: Vec3, steps: usize) -> Rgb {
    let mut sum = integrate(steps, |wi| bsdf.f(wo, wi) * wi.z.abs());
    for transmit in [false, true] {
        // Enough equally spaced samples to choose each of up to eight lobes equally often.
        let picks = 840;
        for i in 0..picks {
            if let Some(s) = bsdf.sample_specular(wo, transmit, (i as f32 + 0.5) / picks as f32) {
                sum += s.f * s.wi.z.abs() / (s.pdf * picks as f32);
            }
        }
    }
    sum
}

/// The same by sampling, as an integrator does: the mean of f |cos| / pdf over `n`³ stratified samples.
pub(crate) fn sky_by_sampling(bsdf: &Bsdf, wo: Vec3, n: u64) -> Rgb {
    mean_of_samples(bsdf, wo, n, |s| s.f * (s.wi.z.abs() / s.pdf))
}

/// Mean over `n`³ stratified samples, most strata in the number that chooses the lobe; failed samples count as black.
fn mean_of_samples(bsdf: &Bsdf, wo: Vec3, n: u64, of: impl Fn(&BsdfSample) -> Rgb) -> Rgb {
    let mut sum = glam::DVec3::ZERO;
    for i in 0..n * n * n {
        let (jc, ju) = random(i);
        let cell = |k: u64, of: u64, j: f32| ((k as f32 + j) / of as f32).min(BELOW_ONE);
        let u = Vec2::new(cell(i % (n * n), n * n, ju.x), cell(i / n / n, n, ju.y));
        if let Some(s) = bsdf.sample(wo, jc, u) {
            assert!(s.pdf > 0.0 && s.pdf.is_finite() && s.f.is_finite() && s.wi.is_normalized());
            sum += of(&s).as_dvec3();
        }
    }
    (sum / (n * n * n) as f64).as_vec3()
}

/// Checks by Pearson's chi-squared test that [`Bsdf::sample`] samples non-specular directions with the density of
/// [`Bsdf::pdf`], on a grid of directions; failed samples are one more bin.
pub(crate) fn check_sampling(name: &str, bsdf: &Bsdf, wo: Vec3) {
    // Bins in angle to z and azimuth; each bin's expectation is computed by a midpoint rule of 16 × 16 points.
    let (rows, columns, fine) = (24, 48, 16);
    let samples = 100_000u64;
    let mut observed = vec![0.0f64; rows * columns + 1];
    let bin = |w: Vec3| {
        let row = ((w.z as f64).acos() / PI * rows as f64) as usize;
        let phi = (w.y as f64).atan2(w.x as f64).rem_euclid(2.0 * PI);
        let column = (phi / (2.0 * PI) * columns as f64) as usize;
        row.min(rows - 1) * columns + column.min(columns - 1)
    };
    for i in 0..samples {
        let (uc, u) = random(i);
        let sample = bsdf.sample(wo, uc, u).filter(|s| !s.specular);
        if let Some(s) = sample {
            let said = bsdf.pdf(wo, s.wi);
            // The same formula on directions transformed to the frame and back; narrow lobes magnify the rounding by at
            // most the inverse of their width.
            assert!(
                (said - s.pdf).abs() <= 1e-2 * s.pdf,
                "{name}: pdf {said} at a sample of pdf {}",
                s.pdf
            );
        }
        observed[sample.map_or(rows * columns, |s| bin(s.wi))] += 1.0;
    }
    let mut expected = vec![0.0f64; rows * columns + 1];
    visit_sphere(rows * fine, |w, solid_angle| {
        expected[bin(w)] += bsdf.pdf(wo, w) as f64 * solid_angle * samples as f64;
    });
    let total: f64 = expected.iter().sum();
    // The midpoint rule over the sphere is good to a thousandth for lobes as wide as those tested.
    assert!(
        total <= samples as f64 * 1.001,
        "{name}: the pdf integrates to {}",
        total / samples as f64
    );
    expected[rows * columns] = (samples as f64 - total).max(0.0);
    let (statistic, degrees) = pearson(&observed, &expected);
    let p = 1.0 - ChiSquared::new(degrees).unwrap().cdf(statistic);
    assert!(
        p > FALSE_ALARM,
        "{name}: χ² = {statistic:.1} with {degrees} degrees of freedom, p = {p:.2e}"
    );
}

/// The statistic and its degrees of freedom, with bins of small expectation merged.
fn pearson(observed: &[f64], expected: &[f64]) -> (f64, f64) {
    let (mut statistic, mut bins) = (0.0, 0);
    let (mut pooled_observed, mut pooled_expected) = (0.0, 0.0);
    let mut term = |o: f64, e: f64| {
        statistic += (o - e) * (o - e) / e;
        bins += 1;
    };
    for (&o, &e) in observed.iter().zip(expected) {
        if e < MIN_EXPECTED {
            pooled_observed += o;
            pooled_expected += e;
        } else {
            term(o, e);
        }
    }
    if pooled_expected >= MIN_EXPECTED {
        term(pooled_observed, pooled_expected);
    } else {
        // Too few for the statistic, but no more than the Poisson distribution allows.
        assert!(
            pooled_observed <= pooled_expected + 25.0,
            "{pooled_observed} samples where {pooled_expected:.2} belong"
        );
    }
    (statistic, (bins - 1).max(1) as f64)
}

/// Checks reciprocity, f(wo, wi)/η_o² = f(wi, wo)/η_i², between all directions (Veach 1997, equation 5.14), with the
/// index 1 above the surface and `eta` below.
pub(crate) fn check_reciprocity(name: &str, bsdf: &Bsdf, eta: f32) {
    let scaled = |wo: Vec3, wi: Vec3| {
        let index = if wo.z > 0.0 { 1.0 } else { eta };
        bsdf.f(wo, wi) / (index * index)
    };
    let mut lit = 0;
    for i in 0..4000 {
        let (a, u) = random(i);
        let (b, v) = random(i + 1_000_000);
        // Not along the surface, where cosines in denominators magnify rounding.
        let angle = |a: f32| {
            if a < 0.5 {
                a * 170.0
            } else {
                95.0 + (a - 0.5) * 170.0
            }
        };
        let wo = direction(angle(a), u.x * 360.0);
        let wi = direction(angle(b), v.x * 360.0);
        let (f, g) = (scaled(wo, wi), scaled(wi, wo));
        lit += usize::from(f.max_element() > 0.0);
        // Rounding of the half vector, magnified in the flanks of a narrow lobe.
        assert!(
            (f - g).abs().max_element() <= 1e-4 * f.max_element().max(1.0),
            "{name}: {f} against {g}"
        );
    }
    assert!(lit > 100, "{name}: only {lit} pairs see one another");
}

/// Albedo for light from `wo`: the mean of f |cos| η² / pdf over `n`³ stratified samples, where η² undoes the scaling
/// of radiance between media.
pub(crate) fn albedo(bsdf: &Bsdf, wo: Vec3, n: u64) -> f32 {
    mean_of_samples(bsdf, wo, n, |s| {
        s.f * (s.wi.z.abs() * s.eta * s.eta / s.pdf)
    })
    .max_element()
}
