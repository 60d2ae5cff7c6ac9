//! Volumes against closed forms and quadratures.

use super::*;
use crate::math::transform::Transform;
use crate::math::{DVec3, IVec2, Vec3};
use crate::media::VolumeSpec;
use crate::params::Dialect;
use crate::params::testing::{Outcome, Surroundings, read_in};
use crate::samplers::{Sampler, SamplerSpec};

fn spec(kind: &str, params: &str, place: &Transform) -> Outcome<Option<VolumeSpec>> {
    let v2 = Surroundings {
        dialect: Dialect::V2,
        ..Surroundings::default()
    };
    read_in(&v2, kind, params, |reader| {
        VolumeSpec::from_params(reader, place)
    })
}

fn volume(kind: &str, params: &str, place: &Transform) -> Volume {
    let outcome = spec(kind, params, place);
    assert_eq!(
        (outcome.errors, outcome.warnings),
        (0, 0),
        "{}",
        outcome.text
    );
    Volume::new(outcome.value.expect("a volume"), &Transform::IDENTITY)
}

/// Mean and standard error of each channel over `n` streams.
fn mean(n: u32, mut f: impl FnMut(&mut SampleStream) -> Rgb) -> (Rgb, Rgb) {
    let sampler = Sampler::new(&SamplerSpec::random(n), 5);
    let (mut sum, mut squares) = ([0.0f64; 3], [0.0f64; 3]);
    for i in 0..n {
        let value = f(&mut sampler.stream(IVec2::ZERO, i));
        for c in 0..3 {
            sum[c] += f64::from(value[c]);
            squares[c] += f64::from(value[c]) * f64::from(value[c]);
        }
    }
    let n = f64::from(n);
    let channel = |c: usize| {
        let mean = sum[c] / n;
        (
            mean as f32,
            ((squares[c] / n - mean * mean).max(0.0) / n).sqrt() as f32,
        )
    };
    let all = [0, 1, 2].map(channel);
    (
        Rgb::from_array(all.map(|c| c.0)),
        Rgb::from_array(all.map(|c| c.1)),
    )
}

/// Within four standard errors (one false alarm in 15,000), plus rounding.
fn assert_agrees(what: &str, (mean, error): (Rgb, Rgb), expected: [f64; 3]) {
    for c in 0..3 {
        let (mean, error) = (f64::from(mean[c]), f64::from(error[c]));
        let allowed = 4.0 * error + 2e-5 * expected[c].abs() + 1e-6;
        assert!(
            (mean - expected[c]).abs() <= allowed,
            "{what}, channel {c}: {mean} ± {error}, but {}",
            expected[c]
        );
    }
}

/// Through the unit cube and beyond it.
const ALONG_X: Ray = Ray {
    o: Vec3::new(-2.0, 0.5, 0.5),
    d: Vec3::X,
    t_max: f32::INFINITY,
    time: 0.0,
};

#[test]
fn a_slab_obeys_beers_law_and_glows_with_its_saturated_emission() {
    let params = "\"rgb sigma_a\" [.1 .5 2] \"rgb sigma_s\" [.2 0 1] \"rgb Le\" [1 2 3] \
                  \"point p0\" [3 0 1] \"point p1\" [0 1 0]";
    let slab = Volumes::new(vec![volume("homogeneous", params, &Transform::IDENTITY)]);
    let (sigma, emission) = ([0.3, 0.5, 3.0], [1.0, 2.0, 3.0]);
    // The whole slab, half of it up to a surface, none of it; and from a camera inside.
    let inside = Ray {
        o: Vec3::new(1.0, 0.5, 0.5),
        ..ALONG_X
    };
    for (ray, t_max, d) in [
        (ALONG_X, f32::INFINITY, 3.0),
        (ALONG_X, 3.5, 1.5),
        (ALONG_X, 1.5, 0.0),
        (inside, f32::INFINITY, 2.0),
    ] {
        let left = sigma.map(|s: f64| (-s * d).exp());
        let transmittance = mean(4, |stream| slab.transmittance(&ray, t_max, stream));
        assert_agrees("transmittance", transmittance, left);
        let glow = mean(20_000, |stream| slab.emission(&ray, t_max, stream));
        let expected = [0, 1, 2].map(|c| emission[c] * (1.0 - left[c]) / sigma[c]);
        assert_agrees("emission", glow, expected);
    }
    // Without matter in the way: the emission of the whole segment.
    let glow = Volumes::new(vec![volume(
        "homogeneous",
        "\"rgb Le\" [2 2 2]",
        &Transform::IDENTITY,
    )]);
    let emitted = mean(4, |stream| glow.emission(&ALONG_X, f32::INFINITY, stream));
    assert_agrees("pure emission", emitted, [2.0; 3]);
}

#[test]
fn an_exponential_density_has_the_integral_of_its_formula() {
    let params = "\"rgb sigma_a\" [.5 1 2] \"rgb Le\" [1 1 1] \"float a\" 1.5 \"float b\" 2 \
                  \"vector updir\" [1 2 0] \"point p0\" [-1 0 0] \"point p1\" [1 3 1]";
    let haze = Volumes::new(vec![volume("exponential", params, &Transform::IDENTITY)]);
    for (o, d) in [
        (Vec3::new(-3.0, 0.2, 0.5), Vec3::new(1.0, 0.1, 0.05)),
        (Vec3::new(0.5, 5.0, 0.5), Vec3::new(-0.1, -1.0, 0.0)),
        // Along a line of equal density.
        (Vec3::new(-2.0, 3.0, 0.5), Vec3::new(2.0, -1.0, 0.0)),
    ] {
        let ray = Ray::new(o, d.normalize(), 0.0);
        let n = 200_000;
        let (mut depth, mut glow) = (0.0, [0.0; 3]);
        let step = 10.0 / f64::from(n);
        for i in 0..n {
            let p = ray.o.as_dvec3() + ray.d.as_dvec3() * (f64::from(i) + 0.5) * step;
            let inside = p.cmpge(DVec3::new(-1.0, 0.0, 0.0)).all()
                && p.cmple(DVec3::new(1.0, 3.0, 1.0)).all();
            if inside {
                let height = (p - DVec3::new(-1.0, 0.0, 0.0)).dot(DVec3::new(1.0, 2.0, 0.0));
                let density = 1.5 * (-2.0 * height / 5f64.sqrt()).exp();
                depth += density * step;
                for (glow, sigma) in glow.iter_mut().zip([0.5, 1.0, 2.0]) {
                    *glow += density * (-sigma * depth).exp() * step;
                }
            }
        }
        assert!(depth > 0.01, "the ray meets the box: {depth}");
        let left = mean(4, |stream| haze.transmittance(&ray, f32::INFINITY, stream));
        // The quadrature's endpoints are within a step of the box's sides.
        let expected = [0.5, 1.0, 2.0].map(|sigma: f64| (-sigma * depth).exp());
        for (found, expected) in left.0.to_array().into_iter().zip(expected) {
            assert!((f64::from(found) - expected).abs() < 2e-4, "{}", left.0);
        }
        let (emitted, error) = mean(40_000, |stream| haze.emission(&ray, f32::INFINITY, stream));
        for c in 0..3 {
            let difference = f64::from(emitted[c]) - glow[c];
            assert!(
                difference.abs() < 4.0 * f64::from(error[c]) + 2e-4,
                "{emitted} for {glow:?}"
            );
        }
    }
}

/// What is transmitted and what scatters before a distance, in every channel, against Beer's law.
fn assert_flies(
    what: &str,
    volumes: &Volumes,
    ray: &Ray,
    sigma_t: [f64; 3],
    sigma_s: [f64; 3],
    d: f64,
) {
    for throughput in [Rgb::ONE, Rgb::new(1.0, 0.05, 0.3)] {
        let fly = |scattered: bool| {
            mean(60_000, |stream| {
                let (flight, _) = volumes.sample(ray, f32::INFINITY, throughput, stream);
                match flight.scattered.is_some() == scattered {
                    true => flight.weight,
                    false => Rgb::ZERO,
                }
            })
        };
        let left = sigma_t.map(|s| (-s * d).exp());
        assert_agrees(what, fly(false), left);
        let scattered = [0, 1, 2].map(|c| (1.0 - left[c]) * sigma_s[c] / sigma_t[c]);
        assert_agrees(what, fly(true), scattered);
        let estimated = mean(60_000, |stream| {
            volumes.transmittance(ray, f32::INFINITY, stream)
        });
        assert_agrees(what, estimated, left);
    }
}

const COLORED: &str = "\"rgb sigma_a\" [.1 .5 .3] \"rgb sigma_s\" [.6 .1 .5] ";

#[test]
fn a_grid_of_one_density_is_homogeneous() {
    let values = "2 ".repeat(3 * 2 * 4);
    let grid = format!(
        "{COLORED} \"integer nx\" 3 \"integer ny\" 2 \"integer nz\" 4 \"float density\" [{values}]"
    );
    for (kind, params, density) in [
        ("volumegrid", grid.as_str(), 2.0),
        ("homogeneous", COLORED, 1.0),
    ] {
        let volumes = Volumes::new(vec![volume(kind, params, &Transform::IDENTITY)]);
        let (t, s) = ([0.7, 0.6, 0.8], [0.6, 0.1, 0.5]);
        assert_flies(
            kind,
            &volumes,
            &ALONG_X,
            t.map(|v| v * density),
            s.map(|v| v * density),
            1.0,
        );
    }
}

#[test]
fn overlapping_boxes_add_up() {
    // From 0 to 2 and from 1 to 4, one with half the density: 2 + 3/2 lengths of the same matter.
    let place = |from: f64, to: f64, scale: f64| {
        let s = |v: [f64; 3]| v.map(|v| (v * scale).to_string()).join(" ");
        let params = format!(
            "\"rgb sigma_a\" [{}] \"rgb sigma_s\" [{}] \"rgb Le\" [{scale} {scale} {scale}] \
             \"point p0\" [{from} 0 0] \"point p1\" [{to} 1 1]",
            s([0.1, 0.5, 0.3]),
            s([0.6, 0.1, 0.5])
        );
        volume("homogeneous", &params, &Transform::IDENTITY)
    };
    let both = Volumes::new(vec![place(0.0, 2.0, 1.0), place(1.0, 4.0, 0.5)]);
    let (t, s) = ([0.7, 0.6, 0.8], [0.6, 0.1, 0.5]);
    assert_flies("two boxes", &both, &ALONG_X, t, s, 3.5);
    let glow = mean(20_000, |stream| {
        both.emission(&ALONG_X, f32::INFINITY, stream)
    });
    let expected = t.map(|t| (1.0 - (-t * 3.5f64).exp()) / t);
    assert_agrees("emission of two", glow, expected);
}

/// A box is rotated and stretched with its space; coefficients are per world unit.
#[test]
fn a_turned_and_stretched_box_has_its_own_length() {
    let place = Transform::rotate(45.0, DVec3::Z) * Transform::scale(DVec3::new(2.0, 2.0, 1.0));
    let turned = Volumes::new(vec![volume("homogeneous", COLORED, &place)]);
    // Through the corner at the origin, along the diagonal of 2 √2.
    let ray = Ray::new(Vec3::new(0.0, -1.0, 0.5), Vec3::Y, 0.0);
    assert_flies(
        "turned",
        &turned,
        &ray,
        [0.7, 0.6, 0.8],
        [0.6, 0.1, 0.5],
        8f64.sqrt(),
    );
    // The corners to the left and right are √2 from the middle.
    let beside = Ray::new(Vec3::new(1.42, -1.0, 0.5), Vec3::Y, 0.0);
    let left = mean(4, |stream| {
        turned.transmittance(&beside, f32::INFINITY, stream)
    });
    assert_agrees("beside", left, [1.0; 3]);
}

#[test]
fn odd_volumes_have_a_meaning() {
    for (kind, params, errors, warnings, made) in [
        ("homogeneous", "", 0, 0, true),
        ("homogeneous", "\"rgb sigma_a\" [-1 1 1]", 0, 1, true),
        ("homogeneous", "\"rgb Le\" [1e30 1e30 1e30]", 0, 1, true),
        ("homogeneous", "\"point p1\" [0 1 1]", 0, 1, false),
        ("homogeneous", "\"float g\" 3", 0, 1, true),
        ("homogeneous", "\"float density\" 3", 0, 1, true),
        ("exponential", "\"float a\" -1", 0, 1, true),
        ("exponential", "\"float b\" -1e9", 0, 1, true),
        ("exponential", "\"vector updir\" [0 0 0]", 0, 1, true),
        ("volumegrid", "", 1, 0, false),
        ("volumegrid", "\"float density\" [1 2]", 1, 0, false),
        ("volumegrid", "\"float density\" [-1]", 0, 1, true),
        ("homogenous", "", 0, 1, false),
    ] {
        let outcome = spec(kind, params, &Transform::IDENTITY);
        let found = (outcome.errors, outcome.warnings, outcome.value.is_some());
        assert_eq!(
            found,
            (errors, warnings, made),
            "{kind} {params}: {}",
            outcome.text
        );
        let Some(spec) = outcome.value else { continue };
        let volumes = Volumes::new(vec![Volume::new(spec, &Transform::IDENTITY)]);
        let sampler = Sampler::new(&SamplerSpec::random(20), 5);
        for i in 0..20 {
            let mut stream = sampler.stream(IVec2::ZERO, i);
            let left = volumes.transmittance(&ALONG_X, f32::INFINITY, &mut stream);
            assert!(left.min_element() >= 0.0 && left.max_element() <= 1.0);
            let (flight, _) = volumes.sample(&ALONG_X, f32::INFINITY, Rgb::ONE, &mut stream);
            assert!(flight.weight.is_finite() && flight.weight.min_element() >= 0.0);
            assert!(
                volumes
                    .emission(&ALONG_X, f32::INFINITY, &mut stream)
                    .is_finite()
            );
        }
    }
}
