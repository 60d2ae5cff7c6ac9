use super::table::rows;
use super::*;
use crate::optics::Prescription;

/// A doublet with a cemented surface, a stop, and a meniscus: six surfaces that reflect.
const LENS: &str = "60 6 1.62 30\n-50 2 1.7 30\n-200 3 0 30\n0 2 0 18\n-80 3 1.52 26\n200 4 0 26\n45 3 1.6 26\n90 30 0 26\n";

fn lens() -> Lens {
    focused(&Prescription::parse(LENS).unwrap())
}

fn focused(prescription: &Prescription) -> Lens {
    let film_distance = Lens::focused(prescription, f64::INFINITY).unwrap();
    Lens::new(prescription, film_distance).unwrap()
}

fn ray(x: f64, y: f64, degrees: f64) -> LensRay<f64> {
    let (sin, cos) = degrees.to_radians().sin_cos();
    LensRay::new([x, y, 0.0], [0.0, sin, cos])
}

#[test]
fn every_two_surfaces_that_reflect_make_a_ghost() {
    let lens = lens();
    let pairs: Vec<_> = Ghosts::new(lens.clone(), None).pairs().collect();
    assert_eq!(pairs.len(), 7 * 6 / 2);
    // The stop reflects nothing.
    assert!(pairs.iter().all(|&(i, j)| i < j && i != 3 && j != 3));
}

/// One after the other by spheres in space and Snell's law for vectors: another way than from vertex to vertex.
fn brute_force(lens: &Lens, ray: &LensRay<f64>, turns: &[usize]) -> Option<[f64; 2]> {
    let surfaces = lens.surfaces();
    let vertices: Vec<f64> = surfaces
        .iter()
        .scan(0.0, |z, s| Some(std::mem::replace(z, *z + s.thickness)))
        .collect();
    let dot = |a: [f64; 3], b: [f64; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
    let (mut o, mut d, mut k, mut step, mut turned) = (ray.o, ray.d, 0isize, 1isize, 0);
    while (0..surfaces.len() as isize).contains(&k) {
        let i = k as usize;
        let s = &surfaces[i];
        let before = if i == 0 { 1.0 } else { surfaces[i - 1].index };
        let (p, n) = if s.radius.is_finite() && s.radius != 0.0 {
            let center = [0.0, 0.0, vertices[i] + s.radius];
            let oc = [o[0], o[1], o[2] - center[2]];
            let b = dot(oc, d);
            let root = (b * b - dot(oc, oc) + s.radius * s.radius).sqrt();
            let at = |t: f64| [o[0] + t * d[0], o[1] + t * d[1], o[2] + t * d[2]];
            // Of the two, that nearer to the vertex.
            let [near, far] = [at(-b - root), at(-b + root)];
            let off = |p: [f64; 3]| (p[2] - vertices[i]).abs();
            let p = if off(near) <= off(far) { near } else { far };
            (
                p,
                [
                    p[0] / s.radius,
                    p[1] / s.radius,
                    (p[2] - center[2]) / s.radius,
                ],
            )
        } else {
            let t = (vertices[i] - o[2]) / d[2];
            (
                [o[0] + t * d[0], o[1] + t * d[1], vertices[i]],
                [0.0, 0.0, 1.0],
            )
        };
        if !p.iter().all(|x| x.is_finite()) || p[0].hypot(p[1]) > 0.5 * s.aperture {
            return None;
        }
        o = p;
        let c = dot(d, n);
        if turns.get(turned) == Some(&i) {
            d = [0, 1, 2].map(|a| d[a] - 2.0 * c * n[a]);
            (step, turned) = (-step, turned + 1);
        } else {
            let mu = if step > 0 {
                before / s.index
            } else {
                s.index / before
            };
            let k = 1.0 - mu * mu * (1.0 - c * c);
            if k < 0.0 {
                return None;
            }
            d = [0, 1, 2].map(|a| mu * d[a] + (k.sqrt() * c.signum() - mu * c) * n[a]);
        }
        k += step;
    }
    let t = (lens.film_z() - o[2]) / d[2];
    (d[2] > 0.0).then_some([o[0] + t * d[0], o[1] + t * d[1]])
}

#[test]
fn ghosts_are_where_brute_force_has_them() {
    let lens = lens();
    let ghosts = Ghosts::new(lens.clone(), None);
    let mut compared = 0;
    for pair in ghosts.pairs() {
        for (x, y, degrees) in [
            (0.0, 1.0, 0.0),
            (2.0, -3.0, 4.0),
            (-5.0, 6.0, 9.0),
            (1.0, 8.0, -3.0),
        ] {
            let ray = ray(x, y, degrees);
            let found = ghosts.trace(&ray, pair).map(|arrival| arrival.film);
            let expected = brute_force(&lens, &ray, &[pair.1, pair.0]);
            assert_eq!(found.is_some(), expected.is_some(), "{pair:?} {ray:?}");
            if let (Some(a), Some(b)) = (found, expected) {
                // Points up to 1e3 mm away after 16 surfaces: some hundred roundings of 1e-13.
                assert!(
                    (a[0] - b[0]).hypot(a[1] - b[1]) < 1e-9 * (1.0 + a[0].hypot(a[1])),
                    "{pair:?}"
                );
                compared += 1;
            }
        }
    }
    assert!(compared > 40, "{compared}");
}

/// Close to the axis rays meet where the paraxial focus is.
#[test]
fn ghosts_are_sharp_where_paraxial_rays_meet() {
    let lens = lens();
    let ghosts = Ghosts::new(lens.clone(), None);
    let mut compared = 0;
    for row in rows(&ghosts, 0.0) {
        let pair = (row.surfaces[0] - 1, row.surfaces[1] - 1);
        // Moved to the focus the film has a point.
        let Some(focus) = row
            .focus
            .filter(|focus| focus.abs() < 1e4 && lens.film_distance() + focus > 0.1)
        else {
            continue;
        };
        let prescription = Prescription::parse(LENS).unwrap();
        let there = Lens::new(&prescription, lens.film_distance() + focus).unwrap();
        let moved = Ghosts::new(there.clone(), None);
        let [_, y] = moved.trace(&ray(0.0, 1e-3, 0.0), pair).unwrap().film;
        // A micrometer from the axis aberrations are 1e-9 of it, times up to 1e4 mm of way and 1e-3 mm of height.
        assert!(y.abs() < 1e-8 * (1.0 + focus.abs()), "{row:?}: {y}");
        compared += 1;
    }
    // The others are sharp in front of the last surface, where no film can be.
    assert!(compared > 4, "{compared}");
}

#[test]
fn no_light_is_lost_or_made() {
    let lens = lens();
    let coating = "1.38@550".parse().ok();
    for coating in [None, coating] {
        let ghosts = Ghosts::new(lens.clone(), coating);
        let mut all = Balance::default();
        for (x, y, degrees) in [
            (0.0, 0.5, 0.0),
            (2.0, -3.0, 4.0),
            (-5.0, 6.0, 9.0),
            (1.0, 14.0, 2.0),
        ] {
            let ray = ray(x, y, degrees);
            let balance = ghosts.balance(&ray, 1e-8);
            assert!((balance.sum() - 1.0).abs() < 1e-12, "{balance:?}");
            assert!(balance.left < 1e-4, "{balance:?}");
            all.transmitted += balance.transmitted;
            all.ghosts += balance.ghosts;
            all.stopped += balance.stopped;
            // Two reflections are what there is of ghosts, but for those with four and more, each of 4 to 6 %: 1e-5 of the light.
            let twice: f64 = { ghosts.pairs() }
                .filter_map(|pair| ghosts.trace(&ray, pair))
                .map(|arrival| arrival.light[0])
                .sum();
            assert!(twice <= balance.ghosts + 1e-12);
            assert!(
                balance.ghosts - twice < 0.1 * balance.ghosts + 1e-5,
                "{twice} {balance:?}"
            );
            let direct = ghosts
                .trace_direct(&ray)
                .map_or(0.0, |arrival| arrival.light[0]);
            assert!((direct - balance.transmitted).abs() < 1e-15);
        }
        assert!(
            all.transmitted > 1.0 && all.ghosts > 1e-4 && all.stopped > 0.1,
            "{all:?}"
        );
    }
}

/// 4 % at each surface, 1.3 % with a layer: ghosts fade by its square.
#[test]
fn coatings_take_ghosts_away() {
    let lens = lens();
    let sum = |coating| {
        let ghosts = Ghosts::new(lens.clone(), coating);
        rows(&ghosts, 0.0).iter().map(|row| row.light).sum::<f64>()
    };
    let (bare, coated) = (sum(None), sum("1.38@550".parse().ok()));
    assert!(
        coated < 0.3 * bare && coated > 0.01 * bare,
        "{bare} {coated}"
    );
}

/// A plane-parallel plate before the film sends its image back and forth: the ghost is where a plate three times as thick has it.
#[test]
fn a_plates_ghost_is_known() {
    let plate = Prescription::parse("inf 4 1.5 40\ninf 10 1 40\n").unwrap();
    let lens = Lens::new(&plate, 10.0).unwrap();
    let ghosts = Ghosts::new(lens.clone(), None);
    let ray = ray(0.0, 0.0, 10.0);
    let Arrival { film: p, light, .. } = ghosts.trace(&ray, (0, 1)).unwrap();
    let sine = 10.0f64.to_radians().sin() / 1.5;
    let inside = sine / (1.0 - sine * sine).sqrt();
    let expected = 12.0 * inside + 10.0 * 10.0f64.to_radians().tan();
    assert!((p[1] - expected).abs() < 1e-12, "{p:?} {expected}");
    let r = Boundary {
        from: 1.0,
        into: 1.5,
        coating: None,
    }
    .reflectance(10.0f64.to_radians().cos(), D_LINE);
    assert!((light[0] - (1.0 - r).powi(2) * r * r).abs() < 1e-14);
    // Parallel light stays parallel.
    assert_eq!(rows(&ghosts, 0.0)[0].focus, None);
}

#[test]
fn what_is_transmitted_is_what_each_surface_leaves() {
    // On the axis of a plate all rays are alike: 4 % at each side.
    let plate = Prescription::parse("inf 4 1.5 40\ninf 10 1 40\n").unwrap();
    let plate = Lens::new(&plate, 10.0).unwrap();
    let found = table(&Ghosts::new(plate.clone(), None), 20.0);
    assert!((found.transmitted - 0.96f64.powi(2)).abs() < 1e-12);
    // A lens: no less bright than by the share at its steepest rays, and as the T-number goes, by its root.
    let lens = lens();
    let found = table(&Ghosts::new(lens.clone(), None), 0.0);
    let without = crate::optics::f_number::working_number(&lens, 1.0).unwrap();
    let ratio = without / found.t_number.unwrap();
    assert!((ratio * ratio / found.transmitted - 1.0).abs() < 1e-12);
    assert!((0.4..0.9).contains(&found.transmitted), "{found:?}");
}

/// A file that says of each surface between air and glass what the option says of all.
#[test]
fn a_coating_of_the_file_is_that_of_the_surface() {
    let text = |coating: &str| {
        format!("50 5 1.6 60 20{coating}\n-40 2 1.7 30 20\n-200 80 1 0 20{coating}\n")
    };
    let rows_of = |text: String, default: Option<&str>| {
        let prescription = Prescription::parse(&text).unwrap();
        let lens = focused(&prescription);
        let default = default.map(|text| text.parse().unwrap());
        table(&Ghosts::new(lens.clone(), default), 3.0)
    };
    let by_option = rows_of(text(""), Some("1.38@550"));
    assert_eq!(rows_of(text(" coating=1.38@550"), None), by_option);
    // What the file says goes before.
    assert_eq!(rows_of(text(" coating=1.38@550"), Some("2@700")), by_option);
    assert_ne!(rows_of(text(""), None), by_option);
}

/// From the film as from the scene, for each color.
#[test]
fn light_keeps_the_same_both_ways() {
    let lens = lens();
    let colors = [611.0, 549.0, 465.0];
    let ghosts = Ghosts::new(lens.clone(), "1.38@520".parse().ok()).at(colors);
    let mut compared = 0;
    for (x, y, degrees) in [(0.0, 0.5, 0.0), (2.0, -3.0, 4.0), (-4.0, 5.0, 9.0)] {
        let there = ghosts.trace_direct(&ray(x, y, degrees)).unwrap();
        let [x, y] = there.film;
        let from = [x, y, lens.film_z()];
        let back = LensRay::new(from, there.ray.d.map(|d| -d));
        let found = ghosts.through(&back).unwrap();
        for (a, b) in found.iter().zip(there.light) {
            // The law is exact; the ray back is the same but for rounding.
            assert!((a - b).abs() < 1e-12, "{found:?} {there:?}");
            compared += 1;
        }
        // A layer for green loses red and blue.
        assert!(found[1] > found[0] && found[1] > found[2], "{found:?}");
    }
    assert_eq!(compared, 9);
}

/// A gaussian stop dims a ghost at each of the three times that its light crosses it.
#[test]
fn an_image_of_the_stop_counts_at_each_crossing() {
    let open = lens();
    let shaped = open.clone().with_stop_shape(StopShape::Gaussian);
    let [open, shaped] = [open, shaped].map(|lens| Ghosts::new(lens, None));
    let ray = ray(0.5, 2.0, 1.0);
    let dimming = |pair| {
        let [a, b] = [&open, &shaped].map(|ghosts| ghosts.trace(&ray, pair).unwrap().light[0]);
        b / a
    };
    // Both surfaces on one side of the stop, number 3, and on two.
    let direct =
        shaped.trace_direct(&ray).unwrap().light[0] / open.trace_direct(&ray).unwrap().light[0];
    let (once, thrice) = (dimming((0, 2)), dimming((2, 4)));
    assert!(
        direct < 0.999 && once < 1.0 && thrice < once,
        "{direct} {once} {thrice}"
    );
    assert!(
        (shaped.through(&LensRay::new([0.0, 1.0, 80.0], [0.0, 0.0, -1.0])))
            == open.through(&LensRay::new([0.0, 1.0, 80.0], [0.0, 0.0, -1.0]))
    );
}

/// Light that comes from behind a fisheye's front vertex goes through it, and into its ghosts.
#[test]
fn light_from_beyond_a_right_angle_enters() {
    let text = "20 20 1.6 39\ninf 10 1 39\n";
    let lens = Lens::new(&Prescription::parse(text).unwrap(), 10.0).unwrap();
    let ghosts = Ghosts::new(lens.clone(), None);
    let (sin, cos) = 100f64.to_radians().sin_cos();
    // To the front at 60 degrees from its axis.
    let (y, z) = (
        20.0 * 60f64.to_radians().sin(),
        20.0 - 20.0 * 60f64.to_radians().cos(),
    );
    let ray = LensRay::new([0.0, y, z], [0.0, -sin, cos]);
    let direct = ghosts.trace_direct(&ray);
    let expected = lens.tracer().to_film(&ray);
    assert_eq!(direct.is_some(), expected.is_ok());
    let balance = ghosts.balance(&ray, 1e-9);
    // Nothing is stopped before it has entered.
    assert!(
        balance.stopped < 1.0 && balance.returned > 0.05,
        "{balance:?}"
    );
    assert!((balance.sum() - 1.0).abs() < 1e-12);
}
