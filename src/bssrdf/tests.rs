//! Probes of planes and spheres, whose hits and areas are known.

use super::table::tests::water;
use super::*;
use crate::bsdf::testing::{flat_hit, random};
use statrs::distribution::{ChiSquared, ContinuousCDF};

/// Probability that correct code fails the chi-squared test; samples are fixed, so a pass is permanent.
const FALSE_ALARM: f64 = 1e-4;

fn bssrdf(albedos: [f32; 3], lengths: [f32; 3]) -> Bssrdf<'static> {
    let hit = flat_hit(Vec3::Z);
    // A frame rotated from the plane's own axes, around the same normal.
    let frame = Frame::from_normal_and_tangent(Vec3::Z, Vec3::new(0.6, 0.8, 0.0));
    let channels = std::array::from_fn(|c| {
        TabulatedChannel::new(water().row(albedos[c]), lengths[c], finest_length(&hit))
    });
    Bssrdf::new(&hit, frame, Profile::Tabulated(channels), water().exit())
}

#[test]
fn probes_meet_a_plane_with_their_density() {
    let bssrdf = bssrdf([0.3, 0.9, 0.99], [1.0, 0.5, 0.4]);
    let nearest_reach = (0..3).map(|c| bssrdf.profile.reach(c).unwrap());
    let end = nearest_reach.fold(f32::INFINITY, f32::min);
    // Bins of equal width in the square root of the distance up to the reach of all channels, and one for everything
    // else: probes along the plane, and the far tails.
    let (bins, samples) = (40, 100_000);
    let bin = |r: f32| ((r / end).sqrt() * bins as f32) as usize;
    let mut observed = vec![0.0; bins + 1];
    for i in 0..samples {
        let (uc, u) = random(i);
        let met = bssrdf.probe(uc, u).filter(|probe| probe.d.z != 0.0);
        let r = met.map(|probe| {
            let t = -probe.o.z / probe.d.z;
            assert!((0.0..=probe.length).contains(&t));
            (probe.o + t * probe.d).length()
        });
        observed[r.map_or(bins, |r| bin(r).min(bins))] += 1.0;
    }
    let mut expected = vec![0.0; bins + 1];
    let steps = 400 * bins;
    for i in 0..steps {
        let s = (i as f32 + 0.5) / steps as f32;
        let r = end * s * s;
        let density = bssrdf.pdf(Vec3::new(0.0, r, 0.0), Vec3::Z) * 2.0 * PI * r;
        let width = end * 2.0 * s / steps as f32;
        expected[bin(r)] += f64::from(density * width) * samples as f64;
    }
    let rest = samples as f64 - expected.iter().sum::<f64>();
    // Half of the probes are along the plane; the tails hold a few hundredths.
    assert!((0.5..0.55).contains(&(rest / samples as f64)), "{rest}");
    expected[bins] = rest;
    let terms = observed.iter().zip(&expected);
    let statistic: f64 = terms
        .map(|(o, e): (&f64, &f64)| (o - e) * (o - e) / e)
        .sum();
    let p = 1.0 - ChiSquared::new(bins as f64).unwrap().cdf(statistic);
    assert!(
        p > FALSE_ALARM,
        "χ² {statistic}, p {p:e}\n{observed:?}\n{expected:?}"
    );
}

/// ∫ of a function of the chord over a sphere of radius R is its integral over the plane up to 2R:
/// the area between two chords is 2π d dd. So a sphere returns as much light as a plane.
#[test]
fn a_sphere_returns_the_effective_albedo() {
    let (albedos, lengths) = ([0.5, 0.9, 0.98], [0.02, 0.01, 0.005]);
    let effective = albedos.map(|albedo| water().row(albedo).effective_albedo());
    check_sphere(&bssrdf(albedos, lengths), effective);
    let hit = flat_hit(Vec3::Z);
    let frame = Frame::from_normal(Vec3::Z);
    let lengths = Rgb::from_array(lengths);
    let normalized = Bssrdf::normalized(&hit, frame, Rgb::from_array(albedos), lengths, 1.4);
    check_sphere(&normalized, albedos);
}

fn check_sphere(bssrdf: &Bssrdf, effective: [f32; 3]) {
    let center = -Vec3::Z;
    let samples = 200_000;
    let (mut sum, mut square) = (glam::DVec3::ZERO, glam::DVec3::ZERO);
    for i in 0..samples {
        let (uc, u) = random(i);
        let Some(probe) = bssrdf.probe(uc, u) else {
            continue;
        };
        let o = (probe.o - center).as_dvec3();
        let b = o.dot(probe.d.as_dvec3());
        let discriminant = b * b - o.length_squared() + 1.0;
        let mut weight = glam::DVec3::ZERO;
        for t in [-b - discriminant.sqrt(), -b + discriminant.sqrt()] {
            if (0.0..=f64::from(probe.length)).contains(&t) {
                let n = (o + t * probe.d.as_dvec3()).as_vec3();
                let p = center + n;
                weight += (bssrdf.value(p) / bssrdf.pdf(p, n)).as_dvec3();
            }
        }
        sum += weight;
        square += weight * weight;
    }
    for (c, albedo) in effective.into_iter().enumerate() {
        let n = samples as f64;
        let mean = sum[c] / n;
        let error = ((square[c] / n - mean * mean) / n).sqrt();
        let albedo = f64::from(albedo);
        // Probes are limited to the distance within which 0.999 of the light exits; plus four standard errors. (With
        // the densities that pbrt-v3 counts, channels of lengths 4 : 2 : 1 would lose 2 % of the longest.)
        let (low, high) = (0.9985 * albedo - 4.0 * error, albedo + 4.0 * error);
        assert!((low..high).contains(&mean), "{mean} ± {error} for {albedo}");
    }
}

#[test]
fn media_of_any_scale_give_finite_numbers() {
    for length in [0.0, 1e-30, 1e-4, 1e4, 1e30, f32::INFINITY, f32::NAN] {
        for albedo in [-1.0, 0.0, 1e-6, 1.0, f32::NAN] {
            let bssrdf = bssrdf([albedo, 0.5, 1.0], [length, length, 1.0]);
            for i in 0..200 {
                let (uc, u) = random(i);
                let Some(probe) = bssrdf.probe(uc, u) else {
                    continue;
                };
                assert!(!probe.length.is_nan() && (0.0..1.0).contains(&probe.choice));
                let at = probe.o + 0.5 * probe.length * probe.d;
                if at.is_finite() {
                    assert!(bssrdf.pdf(at, Vec3::Z) >= 0.0);
                    assert!(bssrdf.value(at).cmpge(Vec3::ZERO).all());
                }
            }
        }
    }
}

#[test]
fn light_enters_without_loss_or_gain() {
    use crate::bsdf::testing::{direction, sky_by_sampling};
    use crate::bsdf::{Bsdf, Lobe};
    for eta in [0.8, 1.0, 1.33, 2.5] {
        let hit = flat_hit(Vec3::Z);
        let mut bsdf = Bsdf::new(hit.n, &hit.shading);
        bsdf.add(Lobe::SubsurfaceExit(SubsurfaceExit::new(eta)));
        let sky = sky_by_sampling(&bsdf, direction(0.0, 0.0), 40).x / (eta * eta);
        // Standard error of 40³ stratified samples of a function that drops abruptly at grazing angles.
        assert!((sky - 1.0).abs() < 2e-3, "η {eta}: {sky}");
    }
}
