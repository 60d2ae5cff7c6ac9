//! The image over the field against golden data computed by others (tests/golden/README.md): chief
//! rays and distortion, solid angle and relative illumination, spots, what limits the axial beam.
//!
//! Integrals over the pupil are deterministic quadratures between its middle and the outline that real
//! rays find ([`crate::limits`]), so their error is the rule's and not noise.

use crate::common::golden_lenses::Golden;
use crate::limits::{Limit, entrance_pupil, film_limits, images_toward_scene, scene_limits};
use fstop::optics::stops::{AxisPoint, exit_pupil};
use fstop::optics::{Cause, Lens, LensRay, LensTracer, Paraxial};
use serde_json::Value;

/// Parts of the stop's diameter, by the golden data's keys.
const STOPS: [(&str, f64); 3] = [("1", 1.0), ("0.5", 0.5), ("0.25", 0.25)];

/// Directions over half a turn. A polygon with twice as many corners is 3e-6 smaller than its
/// circle, and less than 1e-4 at the kinks of a vignetted pupil.
const DIRECTIONS: usize = 721;

impl Golden {
    fn film_z(&self) -> f64 {
        self.data["film_z"].as_f64().unwrap()
    }

    fn lens(&self, scale: f64) -> Lens {
        let mut prescription = self.prescription.clone();
        prescription.surfaces = self.surfaces(scale);
        Lens::new(&prescription, self.film_z() - self.prescription.length()).unwrap()
    }

    fn fields(&self) -> &[Value] {
        self.data["fields"].as_array().unwrap()
    }

    /// The film point's y of the real chief ray's aim on the last vertex plane: the ray from (0, h) that
    /// meets the stop's middle.
    fn chief_target(&self, h: f64) -> f64 {
        let surfaces = &self.prescription.surfaces;
        let stop = surfaces.iter().position(|s| s.is_stop).unwrap();
        let before: f64 = surfaces[..stop].iter().map(|s| s.thickness).sum();
        // The part of the lens from the stop on; its first vertex is the stop's.
        let rear = LensTracer::<f64>::new(&surfaces[stop..]);
        let (film, last) = (self.film_z() - before, self.prescription.length() - before);
        let miss = |y: f64| {
            let ray = LensRay::through([0.0, h, film], [0.0, y, last]);
            rear.to_scene_unclipped(&ray).map(|out| out.o[1])
        };
        // Heights at the stop grow with the aim. Where rays get to the stop at all there are two
        // aims next to each other on either side of its middle.
        let reach = 1.5 * surfaces[surfaces.len() - 1].clear_radius();
        let aims: Vec<f64> = (0..=1000)
            .map(|i| reach * (f64::from(i) / 500.0 - 1.0))
            .collect();
        let around =
            |p: &&[f64]| matches!((miss(p[0]), miss(p[1])), (Ok(a), Ok(b)) if a <= 0.0 && b > 0.0);
        let bracket = aims.windows(2).find(around).unwrap();
        let (mut low, mut high) = (bracket[0], bracket[1]);
        for _ in 0..60 {
            let y = 0.5 * (low + high);
            if miss(y).is_ok_and(|at| at > 0.0) {
                high = y;
            } else {
                low = y;
            }
        }
        0.5 * (low + high)
    }

    /// The chief ray of film height `h` in front of the lens.
    fn chief(&self, h: f64) -> Result<LensRay<f64>, fstop::optics::Blocked> {
        let target = [0.0, self.chief_target(h), self.prescription.length()];
        self.lens(1.0).trace_from_film([0.0, h], target)
    }
}

/// With the axis, degrees.
fn angle(d: [f64; 3]) -> f64 {
    d[0].hypot(d[1]).atan2(-d[2]).to_degrees()
}

fn number(v: &Value) -> f64 {
    v.as_f64().unwrap()
}

fn assert_near(what: &str, found: f64, expected: f64, tolerance: f64) {
    let error = (found - expected).abs();
    assert!(
        error <= tolerance,
        "{what}: {found} against {expected}, error {error:e}"
    );
}

#[test]
fn chief_rays_and_distortion() {
    for g in Golden::all() {
        let f = Paraxial::new(&g.prescription.surfaces)
            .cardinals
            .unwrap()
            .focal_length;
        for field in g.fields() {
            let h = number(&field["h"]);
            let what = format!("{} at {h}", g.name);
            // The golden targets have 1e-9 mm, angles 1e-8 degrees.
            let target = g.chief_target(h);
            assert_near(&what, target, number(&field["chief_target"][1]), 2e-9);
            let chief = g.chief(h).unwrap();
            let found = angle(chief.d);
            assert_near(&what, found, number(&field["chief_object_angle_deg"]), 2e-8);
            if let Some(distortion) = field["distortion_tan_pct"].as_f64() {
                let found = 100.0 * (h / (f * found.to_radians().tan()) - 1.0);
                // 2e-8 degrees are 3.5e-10, relative to the angle at the smallest height, 0.02, and in
                // percent; the golden values have nine digits.
                assert_near(&what, found, distortion, 2e-6);
            }
        }
    }
}

#[test]
fn the_image_circle_ends_where_the_chief_ray_is_blocked() {
    for g in Golden::all() {
        let limit = &g.data["chief_limit"];
        let h = number(&limit["film_height"]);
        // The golden height has 1e-9 mm.
        let (inside, outside) = (g.chief(h * (1.0 - 1e-8)), g.chief(h * (1.0 + 1e-8)));
        let chief = inside.unwrap_or_else(|blocked| panic!("{}: {blocked}", g.name));
        // 1e-8 of the height, times the angle's growth there: up to ten at the rim of a fisheye.
        let expected = number(&limit["object_angle_deg"]);
        assert_near(g.name, angle(chief.d), expected, 1e-7 * expected);
        let blocked = outside.unwrap_err();
        assert_eq!(
            blocked.surface as u64,
            limit["blocking_surface"].as_u64().unwrap(),
            "{}",
            g.name
        );
        assert_eq!(blocked.cause, Cause::Vignetted, "{}", g.name);
        assert_eq!(limit["cause"], "vignetted");
    }
}

/// Area in film-side direction cosines of the pupil that film height `h` sees: its projected solid angle.
fn solid_angle(lens: &Lens, h: f64) -> f64 {
    let plane_z = fstop::optics::pupil::sampling_plane(lens);
    let limits = film_limits(lens, h, plane_z, DIRECTIONS);
    let cosines = |limit: &Limit| {
        let d = [limit.point[0] - h, limit.point[1], plane_z - lens.film_z()];
        let length = d.iter().map(|x| x * x).sum::<f64>().sqrt();
        [d[0] / length, d[1] / length]
    };
    let points: Vec<[f64; 2]> = limits.iter().map(cosines).collect();
    // The trapezoids between the outline and its mirror line: both halves.
    points
        .windows(2)
        .map(|p| (p[0][0] - p[1][0]) * (p[0][1] + p[1][1]))
        .sum::<f64>()
        .abs()
}

#[test]
fn projected_solid_angle_and_relative_illumination() {
    for g in Golden::all() {
        for (key, scale) in STOPS {
            let lens = g.lens(scale);
            let mut axis = None;
            for field in g.fields() {
                let found = solid_angle(&lens, number(&field["h"]));
                let axis = *axis.get_or_insert(found);
                let what = format!("{} stop {key} at {}", g.name, field["h"]);
                // The golden values have 3e-5 where the outline has kinks, ours 1e-4.
                let expected = number(&field["proj_solid_angle_sr"][key]);
                assert_near(&what, found / expected, 1.0, 2e-4);
                let expected = number(&field["rel_illum"][key]);
                assert_near(&what, found / axis / expected, 1.0, 2e-4);
            }
            if key == "1" {
                let index = lens.rear().index;
                let number = 0.5 / (index * (axis.unwrap() / std::f64::consts::PI).sqrt());
                let expected = g.data["effective_f_number_from_area"].as_f64().unwrap();
                assert_near(g.name, number / expected, 1.0, 1e-4);
            }
        }
    }
}

/// Relative tolerance of spot sizes: what is asked for. Most agree to 1e-5; the golden values' own rule
/// converges to some 1e-4 (tests/golden/README.md).
const SPOT: f64 = 1e-3;

/// Two of petzval_50's angular spreads differ by 1.0e-3 and 1.2e-3. Four times as many directions change
/// ours by 1e-5: it is the golden values' rule that has not converged.
fn spread_tolerance(g: &Golden) -> f64 {
    if g.name == "petzval_50" { 1.5e-3 } else { SPOT }
}

/// Nodes and weights on [0, 1] of Gauss's rule (Press et al., *Numerical Recipes*, §4.6).
fn gauss(n: usize) -> Vec<(f64, f64)> {
    (0..n)
        .map(|i| {
            let mut x = (std::f64::consts::PI * (i as f64 + 0.75) / (n as f64 + 0.5)).cos();
            let mut slope = 1.0;
            for _ in 0..20 {
                let (mut p, mut before) = (1.0, 0.0);
                for k in 0..n {
                    let k = k as f64;
                    (p, before) = (((2.0 * k + 1.0) * x * p - k * before) / (k + 1.0), p);
                }
                slope = n as f64 * (x * p - before) / (x * x - 1.0);
                x -= p / slope;
            }
            (0.5 * (1.0 + x), 1.0 / ((1.0 - x * x) * slope * slope))
        })
        .collect()
}

/// Points of the region within `limits`, on the half with y ≥ 0, with their areas: Gauss's rule from the
/// middle outward, the trapezoidal rule around.
fn points(limits: &[Limit]) -> Vec<([f64; 2], f64)> {
    let (Some(first), Some(last)) = (limits.first(), limits.last()) else {
        return Vec::new();
    };
    let center = 0.5 * (first.point[0] + last.point[0]);
    let step = std::f64::consts::PI / (limits.len() - 1) as f64;
    let rule = gauss(16);
    let mut points = Vec::new();
    for (i, limit) in limits.iter().enumerate() {
        let (x, y) = (limit.point[0] - center, limit.point[1]);
        // The line of symmetry counts half.
        let share = if i == 0 || i + 1 == limits.len() {
            0.5
        } else {
            1.0
        };
        for (s, weight) in &rule {
            let area = share * step * weight * s * (x * x + y * y);
            points.push(([center + s * x, s * y], area));
        }
    }
    points
}

/// A parallel beam on its way to the film: weights, positions there and slopes.
struct Spot(Vec<(f64, [f64; 2], [f64; 2])>);

impl Spot {
    /// Of light from `angle` radians off the axis.
    fn new(lens: &Lens, angle: f64) -> Spot {
        let plane_z = lens.paraxial().entrance_pupil.unwrap().z;
        let limits = scene_limits(lens, angle, plane_z, DIRECTIONS);
        let (sin, cos) = angle.sin_cos();
        // In front of the glass, wherever the plane is.
        let back = (plane_z + 200.0) / cos;
        let rays = points(&limits).into_iter().map(|(p, area)| {
            let ray = LensRay::new([p[0] - back * sin, p[1], -200.0], [sin, 0.0, cos]);
            let out = lens.tracer().to_film(&ray).unwrap();
            let slope = [out.d[0] / out.d[2], out.d[1] / out.d[2]];
            let t = lens.film_z() - out.o[2];
            (area, [0, 1].map(|i| out.o[i] + t * slope[i]), slope)
        });
        Spot(rays.collect())
    }

    fn mean(&self, f: impl Fn([f64; 2], [f64; 2]) -> f64) -> f64 {
        let area: f64 = self.0.iter().map(|r| r.0).sum();
        self.0.iter().map(|r| r.0 * f(r.1, r.2)).sum::<f64>() / area
    }

    fn centroid(&self) -> f64 {
        self.mean(|p, _| p[0])
    }

    /// Root mean square distance from the centroid on a film moved by `shift`, mm.
    fn rms(&self, shift: f64) -> f64 {
        let c = self.mean(|p, s| p[0] + shift * s[0]);
        let square = |p: [f64; 2], s: [f64; 2]| {
            (p[0] + shift * s[0] - c).powi(2) + (p[1] + shift * s[1]).powi(2)
        };
        self.mean(square).sqrt()
    }
}

#[test]
fn spots() {
    for g in Golden::with_spots() {
        for (key, scale) in [("1", 1.0), ("0.25", 0.25)] {
            let lens = g.lens(scale);
            for field in g.fields() {
                let what = format!("{} stop {key} at {}", g.name, field["h"]);
                let angle = number(&field["chief_object_angle_deg"]).to_radians();
                let spot = Spot::new(&lens, angle);
                let expected = number(&field["spot_rms_um"][key]);
                assert_near(&what, 1e3 * spot.rms(0.0) / expected, 1.0, SPOT);
                if key == "1" {
                    let expected = number(&field["spot_centroid_y"]);
                    // As above, for fisheye_10 at the rim: 2.4e-3 of the spot's size.
                    assert_near(&what, spot.centroid(), expected, 3e-3 * spot.rms(0.0));
                }
            }
        }
    }
}

#[test]
fn the_best_focus_on_the_axis() {
    for g in Golden::with_spots() {
        let spot = Spot::new(&g.lens(1.0), 0.0);
        // The square of the radius is quadratic in the shift.
        let cross = spot.mean(|p, s| p[0] * s[0] + p[1] * s[1]);
        let shift = -cross / spot.mean(|_, s| s[0] * s[0] + s[1] * s[1]);
        let axis = &g.fields()[0];
        let expected = number(&axis["best_focus_shift"]);
        assert_near(g.name, shift, expected, 1e-3 * expected.abs());
        let expected = number(&axis["best_focus_spot_rms_um"]);
        assert_near(g.name, 1e3 * spot.rms(shift) / expected, 1.0, 1e-3);
    }
}

/// Spread of directions in front of the lens, of all light that a film point gathers.
#[test]
fn angular_spread_in_the_scene() {
    for g in Golden::with_spots() {
        for (key, scale) in [("1", 1.0), ("0.25", 0.25)] {
            let lens = g.lens(scale);
            let plane_z = fstop::optics::pupil::sampling_plane(&lens);
            for field in g.fields() {
                let h = number(&field["h"]);
                let rays: Vec<(f64, [f64; 3])> =
                    points(&film_limits(&lens, h, plane_z, DIRECTIONS))
                        .into_iter()
                        .map(|(p, area)| {
                            let sample = fstop::optics::PupilSample {
                                point: [p[0], p[1], plane_z],
                                area,
                            };
                            let film = [h, 0.0, lens.film_z()];
                            let weight = fstop::optics::pupil::projected_solid_angle(film, &sample);
                            let out = lens.trace_from_film([h, 0.0], sample.point).unwrap();
                            (weight, out.d)
                        })
                        .collect();
                let total: f64 = rays.iter().map(|r| r.0).sum();
                let mean = |i: usize| rays.iter().map(|r| r.0 * r.1[i]).sum::<f64>() / total;
                // The mirror image makes the mean's y vanish.
                let (x, z) = (mean(0), mean(2));
                let axis = [x / x.hypot(z), z / x.hypot(z)];
                let square = |d: [f64; 3]| {
                    let along = d[0] * axis[0] + d[2] * axis[1];
                    let across = d[0] * axis[1] - d[2] * axis[0];
                    (across / along).powi(2) + (d[1] / along).powi(2)
                };
                let rms = (rays.iter().map(|r| r.0 * square(r.1)).sum::<f64>() / total).sqrt();
                let what = format!("{} stop {key} at {h}", g.name);
                let expected = number(&field["scene_rms_mrad"][key]);
                assert_near(&what, 1e3 * rms / expected, 1.0, spread_tolerance(&g));
            }
        }
    }
}

#[test]
fn what_limits_the_axial_beam() {
    for g in Golden::all() {
        let axis = &g.fields()[0];
        let lens = g.lens(1.0);
        let limit = scene_limits(&lens, 0.0, lens.paraxial().entrance_pupil.unwrap().z, 3)[0];
        // The golden diameter has nine digits.
        let expected = number(&axis["real_entrance_beam_diameter"]);
        assert_near(g.name, 2.0 * limit.point[0] / expected, 1.0, 1e-8);
        let surface = axis["onaxis_limiting_surface"].as_u64().unwrap() as usize;
        assert_eq!(limit.blocked.surface, surface, "{}", g.name);
        // By the images of all apertures, the lecture's way: the same one, or one whose image is as
        // large within what aberration makes of it. The double Gauss' stop and a rim in front of it, and
        // nikon_50_f1.2's, differ by less than the beam widens.
        let images = images_toward_scene(lens.surfaces(), AxisPoint::Infinity);
        let smallest = entrance_pupil(lens.surfaces(), AxisPoint::Infinity);
        let excess = images[surface].opening / smallest.opening - 1.0;
        assert!(
            excess < 0.1,
            "{}: {} limits, {excess} above {smallest:?}",
            g.name,
            surface
        );
    }
}

/// Two stops down the images of smallest solid angle are those of the stop, seen from either side.
#[test]
fn stopped_down_the_smallest_images_are_the_pupils() {
    for g in Golden::all() {
        let surfaces = g.surfaces(0.25);
        let golden = &g.data["pupils"]["0.25"];
        let entrance = entrance_pupil(&surfaces, AxisPoint::Infinity);
        let exit = exit_pupil(&surfaces, AxisPoint::At(g.film_z())).unwrap();
        for (image, side) in [(entrance, "entrance"), (exit, "exit")] {
            assert!(
                surfaces[image.surface].is_stop,
                "{} {side}: {image:?}",
                g.name
            );
            for (key, found) in [("z", image.z), ("diameter", image.diameter)] {
                let what = format!("{} {side} {key}", g.name);
                let expected = number(&golden[&format!("{side}_{key}")]);
                assert_near(&what, found, expected, 1e-12 * expected.abs().max(1.0));
            }
        }
    }
}
