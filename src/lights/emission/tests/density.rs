//! Rays bring the flux of their light and have the density that is said of them; lights are chosen by their power.

use super::*;
use crate::lights::LightMap;

/// A ray tells where a light without area is.
fn place(light: &Light) -> Vec3 {
    let ray = (0..1000).find_map(|i| light.emit(&SCENE, Vec2::ZERO, random(i, 9)));
    ray.map_or(Vec3::NAN, |ray| ray.p)
}

/// What a light without area sends in the direction `d` of its rays, through [`Light::sample`] or [`Light::escaped`].
fn shining(light: &Light, place: Vec3, d: Vec3) -> Rgb {
    if light.is_at_infinity() {
        return light.escaped(-d);
    }
    // The distance is 1 but for rounding.
    let sample = light.sample(&reference(place + d), Vec2::ZERO);
    sample.map_or(Rgb::ZERO, |s| s.radiance)
}

/// The integral of that over all directions.
fn flux_by_directions(light: &Light) -> f64 {
    let side = 512;
    let place = place(light);
    let mut sum = 0.0;
    for i in 0..side * side {
        let corner = Vec2::new((i % side) as f32, (i / side) as f32);
        let d = uniform_sphere((corner + random(i, 1)) / side as f32);
        sum += total(shining(light, place, d));
    }
    let sphere = 4.0 * std::f64::consts::PI / (side * side) as f64;
    let disk = match light.is_at_infinity() {
        true => std::f64::consts::PI * f64::from(SCENE.radius * SCENE.radius),
        false => 1.0,
    };
    sum * sphere * disk
}

#[test]
fn rays_bring_the_flux_of_their_light() {
    let mut failed = vec![];
    for case in cases() {
        let mut mean = Mean::default();
        for i in 0..20_000 {
            let emission = case.light.emit(&SCENE, random(i, 2), random(i, 3));
            mean.add(emission.map_or(0.0, |e| total(e.flux())));
        }
        let power = total(case.light.power(SCENE.radius));
        let off = (mean.value() - power).abs();
        // Five standard errors: one false alarm in a million cases.
        let noise = 5.0 * mean.error();
        check!(
            failed,
            off <= noise + case.power_error * power,
            "{}: {} ± {} but {power}",
            case.name,
            mean.value(),
            mean.error()
        );
        if matches!(case.light, Light::DiffuseArea(_) | Light::Distant(_)) {
            continue;
        }
        let expected = flux_by_directions(&case.light);
        // A jittered grid of 512² points over functions with edges: the narrowest light with a sharp one has 3 % of the
        // sphere, with some 300 of its 8000 points at the edge, each off by half, by chance: 0.1 %. A few times that, for
        // the steps of interpolation.
        check!(
            failed,
            (mean.value() - expected).abs() <= noise + 6e-3 * expected,
            "{}: {} ± {} but {expected}",
            case.name,
            mean.value(),
            mean.error()
        );
        // All have some, to which the noise is small.
        check!(
            failed,
            expected > 0.0 && mean.error() < 0.05 * expected,
            "{}",
            case.name
        );
    }
    assert!(failed.is_empty(), "{failed:#?}");
}

/// The density of each ray is what is said of it afterwards.
#[test]
fn rays_carry_their_density() {
    let mut failed = vec![];
    for case in cases() {
        let (mut rays, mut agree) = (0, 0);
        for i in 0..2000 {
            let Some(emission) = case.light.emit(&SCENE, random(i, 4), random(i, 5)) else {
                continue;
            };
            let EmissionDensity {
                position,
                direction,
            } = case.light.emission_density(&SCENE, emission.n, emission.d);
            rays += 1;
            // Normals are rounded; angles of image skies lose a few 1e-6 over sin θ.
            let same = |a: f32, b: f32| (a / b - 1.0).abs() < 1e-3;
            agree += i32::from(
                same(position, emission.density.position)
                    && same(direction, emission.density.direction),
            );
            assert!((emission.d.length() - 1.0).abs() < 1e-5);
            let on_surface = matches!(case.light, Light::DiffuseArea(_));
            assert_eq!(emission.n != Vec3::ZERO, on_surface);
            let (ray, side) = (emission.ray(0.5), emission.n.dot(emission.d).signum());
            let above = side * (ray.o - emission.p).dot(emission.n);
            assert!(ray.time == 0.5 && ray.d == emission.d && (above > 0.0) == on_surface);
            if case.light.is_at_infinity() {
                let out = (emission.p - SCENE.center).length() / SCENE.radius;
                check!(failed, out > 1.0 && out < 1.5, "{}: {out}", case.name);
            }
        }
        // All but those that rounding moves over a cell's border.
        check!(
            failed,
            agree >= rays - 10 && rays > 1000,
            "{}: {agree} of {rays}",
            case.name
        );
    }
    assert!(failed.is_empty(), "{failed:#?}");
}

/// Directions in the frame of the normal.
const BINS: [usize; 2] = [16, 32];

fn bin(d: Vec3) -> usize {
    let height = ((1.0 - d.z) * 0.5 * BINS[0] as f32) as usize;
    let turn = (crate::math::angle::turns(d.x, d.y) * BINS[1] as f32) as usize;
    height.min(BINS[0] - 1) * BINS[1] + turn.min(BINS[1] - 1)
}

#[test]
fn directions_follow_their_density() {
    let mut failed = vec![];
    for case in cases() {
        if matches!(case.light, Light::Distant(_)) {
            continue;
        }
        let is_area = matches!(case.light, Light::DiffuseArea(_));
        let n = 20_000;
        let (mut observed, mut expected) = (vec![0.0; 512], vec![0.0; 512]);
        for i in 0..n {
            if let Some(e) = case.light.emit(&SCENE, random(i, 6), random(i, 7)) {
                let local = match is_area {
                    true => Frame::from_normal(e.n).to_local(e.d),
                    false => e.d,
                };
                observed[bin(local)] += 1.0;
            }
        }
        let mut all = 0.0;
        // 14² points in each bin, each somewhere in its square: edges may run along the grid.
        let grid = [14 * BINS[0], 14 * BINS[1]];
        let each = 4.0 * std::f64::consts::PI / (grid[0] * grid[1]) as f64;
        let normal = if is_area { Vec3::Z } else { Vec3::ZERO };
        let place = place(&case.light);
        for i in 0..grid[0] * grid[1] {
            let corner = Vec2::new((i / grid[1]) as f32, (i % grid[1]) as f32);
            let at = corner + random(i as u64, 20);
            let d = uniform_sphere(at / Vec2::new(grid[0] as f32, grid[1] as f32));
            let density = case.light.emission_density(&SCENE, normal, d).direction;
            let density = f64::from(density) * each;
            all += density;
            // What is chosen where the light is black is no ray.
            if is_area || total(shining(&case.light, place, d)) > 0.0 {
                expected[bin(d)] += density * n as f64;
            }
        }
        // A grid of a hundred thousand points over steps and edges; see above.
        check!(failed, (all - 1.0).abs() < 5e-3, "{}: {all}", case.name);
        let (mut rest, mut chi2, mut degrees) = ([0.0; 2], 0.0, 0.0);
        for (o, e) in observed.iter().zip(&expected) {
            if *e < 20.0 {
                rest = [rest[0] + o, rest[1] + e];
            } else {
                chi2 += (o - e) * (o - e) / e;
                degrees += 1.0;
            }
        }
        let off: f64 = rest[0] - rest[1];
        check!(
            failed,
            off.abs() < 5.0 * rest[1].sqrt() + 5.0,
            "{}: {rest:?}",
            case.name
        );
        // Wilson and Hilferty's quantile of chi-square for one false alarm in a million; expected counts, good to 0.7
        // percent (as 20² points in a bin are to 0.5), add 5e-5 × n at most: 1.
        let k = 2.0 / (9.0 * degrees);
        let quantile = degrees * (1.0 - k + 4.75 * f64::sqrt(k)).powi(3);
        check!(
            failed,
            chi2 < quantile + 1.0,
            "{}: {chi2} over {degrees}",
            case.name
        );
    }
    assert!(failed.is_empty(), "{failed:#?}");
}

/// Where on the light a sample came from.
#[test]
fn samples_know_their_end() {
    let mut failed = vec![];
    for case in cases() {
        for i in 0..200 {
            let from = reference(Vec3::new(0.2, 2.5, 1.5) * random(i, 14).x);
            let u = random(i, 15);
            let sample = case.light.sample(&from, u);
            let Some((again, end)) = case.light.sample_with_end(&from, u) else {
                assert!(sample.is_none());
                continue;
            };
            let sample = sample.unwrap();
            assert_eq!((sample.wi, sample.pdf), (again.wi, again.pdf));
            assert_eq!(sample.radiance, again.radiance);
            if !case.light.is_at_infinity() {
                // Single-precision coordinates of some units.
                let away = end.p - from.p;
                let off = (away.normalize() - sample.wi).length();
                check!(
                    failed,
                    off < 1e-6 + 1e-6 / away.length(),
                    "{}: {off}",
                    case.name
                );
            }
            let on_surface = matches!(case.light, Light::DiffuseArea(_));
            assert_eq!(end.n.length() > 0.5, on_surface, "{}", case.name);
        }
    }
    assert!(failed.is_empty(), "{failed:#?}");
}

/// Every ray of a light that is sampled exactly represents all of its flux.
#[test]
fn what_can_be_exact_is() {
    let even = placements().into_iter().filter(|(_, _, even)| *even);
    for (placement, transform, _) in even {
        let white = LightMap::new(8, 4, vec![Rgb::ONE; 32]);
        // Probabilities of about 1/64 are in steps of a 65535th, twice: up to a percent; and cells of a 64th of the
        // projector's side get darker toward the corners by some percent.
        for (name, mut light, spread) in [
            ("spot", spot(40.0, 15.0, transform), 1e-4),
            ("wide spot", spot(150.0, 100.0, transform), 1e-4),
            ("projection", projection(None, 45.0, transform), 0.06),
            ("even map", goniometric(white, transform), 0.015),
        ] {
            light.prepare_emission();
            let rays = (0..1000).filter_map(|i| light.emit(&SCENE, Vec2::ZERO, random(i, 16)));
            for ray in rays {
                let off = total(ray.flux()) / total(light.power(1.0)) - 1.0;
                assert!(off.abs() < spread, "{placement} {name}: {off}");
            }
        }
    }
}

/// A map that is dark but for a spot costs few rays.
#[test]
fn images_are_followed() {
    for light in [
        goniometric(lone_texel(32, 16), turn()),
        projection(lone_texel(32, 16), 60.0, turn()),
    ] {
        let moment = |light: &Light| {
            let mut mean = Mean::default();
            for i in 0..20_000 {
                let emission = light.emit(&SCENE, Vec2::ZERO, random(i, 17));
                mean.add(emission.map_or(0.0, |e| total(e.flux())));
            }
            mean.squares / mean.n / (mean.value() * mean.value())
        };
        let mut prepared = light.clone();
        prepared.prepare_emission();
        // 1 is perfect. Cells are a quarter of a texel's peak across.
        assert!(moment(&prepared) < 1.5, "{}", moment(&prepared));
        assert!(moment(&light) > 30.0, "{}", moment(&light));
    }
}

#[test]
fn lights_are_chosen_by_power() {
    let lights: Vec<Light> = cases().into_iter().map(|case| case.light).collect();
    for lights in [&lights[..], &lights[..1], &[]] {
        for radius in [0.0, 6.0, 1e20, f32::INFINITY] {
            let choice = EmitterChoice::new(lights, radius);
            let pmfs = (0..lights.len()).map(|i| choice.pmf(LightId(i as u32)));
            let sum: f64 = pmfs.map(f64::from).sum();
            // Some hundred single-precision probabilities.
            assert!((sum - 1.0).abs() < 1e-5 || lights.is_empty(), "{sum}");
            assert_eq!(choice.pmf(LightId(lights.len() as u32)), 0.0);
            let n = 1 << 16;
            let mut counts = vec![0.0; lights.len()];
            for i in 0..n {
                let Some((light, pmf, rest)) = choice.sample((i as f32 + 0.5) / n as f32) else {
                    assert!(lights.is_empty());
                    continue;
                };
                assert_eq!(pmf, choice.pmf(light));
                assert!(pmf > 0.0 && (0.0..1.0).contains(&rest));
                counts[light.index()] += 1.0;
            }
            for (i, count) in counts.into_iter().enumerate() {
                // Equally spaced numbers: off by one at each end.
                let expected = choice.pmf(LightId(i as u32)) * n as f32;
                assert!((count - expected).abs() <= 2.0, "{i}: {count} {expected}");
            }
        }
    }
}
