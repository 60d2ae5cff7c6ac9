//! Where to aim: the part of the exit pupil that a film point sees light through.
//!
//! Most rays toward the rear element end at some rim. For each of a number of rings of film
//! radius the rays that pass are found by tracing, and the smallest ellipse around them on one plane is
//! kept; samples are drawn uniformly from the ellipse, and their weight carries its area. The
//! ellipse holds every ray that passes, so the expectation is that of sampling everything.
//!
//! The plane is that of the paraxial exit pupil, where the region hardly moves within a ring. The
//! paraxial pupil disk itself would not do (pupil aberration moves the true one off it by up to half
//! its light), nor the rear element's disk at its vertex (the rim of a curved surface lies elsewhere;
//! a wide-angle lens loses its corners). pbrt's boxes (3rd edition §6.4.5) waste a quarter of the
//! rays or more, and miss a stop of a hundredth of a millimetre altogether, because they look for it with
//! random rays. Here the search starts from the ray through the middle of all apertures and walks outward.

use super::lens::Lens;
use crate::math::Vec2;
use crate::math::sampling::concentric_disk;

/// An ellipse on the sampling plane, its axes along and across the film point's azimuth.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ellipse {
    /// Distance of the centre from the lens axis, in the direction of the film point, mm.
    pub center: f64,
    /// Semi-axis along that direction, mm.
    pub along: f64,
    /// Semi-axis across it, mm.
    pub across: f64,
}

impl Ellipse {
    /// In mm².
    pub fn area(&self) -> f64 {
        std::f64::consts::PI * self.along * self.across
    }

    /// Is the point (along, across) within `scale` times the ellipse?
    fn holds(&self, p: [f64; 2]) -> bool {
        let (x, y) = ((p[0] - self.center) / self.along, p[1] / self.across);
        x * x + y * y <= 1.0
    }
}

/// A point of the exit pupil to aim at.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PupilSample {
    /// Where, in lens coordinates.
    pub point: [f64; 3],
    /// Area it was drawn from uniformly, mm², on a plane perpendicular to the axis.
    pub area: f64,
}

/// The ellipse of one ring of film radii. Within the ring it moves with the film point.
#[derive(Clone, Copy, Debug)]
struct Ring {
    /// At the ring's inner radius.
    ellipse: Ellipse,
    /// Movement of the centre with the film radius.
    drift: f64,
}

/// For every film radius, the region of the exit pupil to sample.
#[derive(Clone, Debug)]
pub struct ExitPupil {
    plane_z: f64,
    film_z: f64,
    ring_width: f64,
    rings: Vec<Option<Ring>>,
    rear: Rear,
}

/// Rings between the axis and the largest film radius. With 64 the ellipses of neighbouring rings overlap
/// to about 99 % (pbrt uses as many); twice as many gain 1 % of the rays at twice the setup.
pub const RINGS: usize = 64;

/// Directions in which the boundary is sought, over half a turn: the other half is its mirror image.
const DIRECTIONS: usize = 48;

/// The boundary is bisected to this part of its distance from the middle.
const BOUNDARY_TOLERANCE: f64 = 1e-4;

/// The ellipse is made larger by this: covers what bends outward between two directions, and
/// between the two radii of a ring. Costs 0.6 % of the rays.
const MARGIN: f64 = 3e-3;

impl ExitPupil {
    /// Finds the regions for film points up to `max_radius` mm from the axis, in `rings` rings.
    pub fn new(lens: &Lens, max_radius: f64, rings: usize) -> ExitPupil {
        let rings = rings.max(1);
        let plane_z = sampling_plane(lens);
        let ring_width = max_radius.max(f64::MIN_POSITIVE) / rings as f64;
        let rear = Rear::new(lens);
        // At the ends and in the middle of every ring.
        let boundaries: Vec<Vec<[f64; 2]>> = (0..=2 * rings)
            .map(|i| boundary(lens, 0.5 * i as f64 * ring_width, plane_z))
            .collect();
        let rings = (0..rings)
            .map(|i| {
                let b = &boundaries[2 * i..2 * i + 3];
                let search = RingSearch {
                    lens,
                    plane_z,
                    inner: i as f64 * ring_width,
                    width: ring_width,
                    drift: match (middle_of(&b[0]), middle_of(&b[2])) {
                        (Some(inner), Some(outer)) => (outer - inner) / ring_width,
                        _ => 0.0,
                    },
                };
                search.ring([&b[0], &b[1], &b[2]], &rear)
            })
            .collect();
        ExitPupil {
            plane_z,
            film_z: lens.film_z(),
            ring_width,
            rings,
            rear,
        }
    }

    /// z of the plane that is sampled.
    pub fn plane_z(&self) -> f64 {
        self.plane_z
    }

    /// The region for film points `radius` mm from the axis; `None` where no light arrives.
    /// Beyond the largest radius: everything the rear element lets through.
    pub fn region(&self, radius: f64) -> Option<Ellipse> {
        let ring = (radius / self.ring_width) as usize;
        match self.rings.get(ring) {
            Some(region) => region.map(|r| Ellipse {
                center: r.ellipse.center + r.drift * (radius - ring as f64 * self.ring_width),
                ..r.ellipse
            }),
            None => self.rear.region(radius, self.plane_z, self.film_z),
        }
    }

    /// Maps `u` in the unit square to the region of the film point (x, y) mm: evenly, and
    /// continuously, so that well-spread numbers stay well spread. `None` where no light arrives.
    pub fn sample(&self, film: [f64; 2], u: Vec2) -> Option<PupilSample> {
        let radius = film[0].hypot(film[1]);
        let ellipse = self.region(radius)?;
        let disk = concentric_disk(u).as_dvec2();
        let x = ellipse.center + ellipse.along * disk.x;
        let y = ellipse.across * disk.y;
        let (cos, sin) = if radius > 0.0 {
            (film[0] / radius, film[1] / radius)
        } else {
            (1.0, 0.0)
        };
        Some(PupilSample {
            point: [cos * x - sin * y, sin * x + cos * y, self.plane_z],
            area: ellipse.area(),
        })
    }

    /// Projected solid angle ∫cosθ dω, in steradians, that a sample of area `area` stands for, seen
    /// from the film point: area·cos⁴θ/Z², the factor between radiance and irradiance.
    pub fn projected_solid_angle(&self, film: [f64; 2], sample: &PupilSample) -> f64 {
        projected_solid_angle([film[0], film[1], self.film_z], sample)
    }
}

/// Projected solid angle of `sample`'s area seen from `film` across a film perpendicular to the axis.
pub fn projected_solid_angle(film: [f64; 3], sample: &PupilSample) -> f64 {
    let d: [f64; 3] = std::array::from_fn(|i| sample.point[i] - film[i]);
    let z2 = d[2] * d[2];
    let distance2 = d[0] * d[0] + d[1] * d[1] + z2;
    // cos²θ = Z²/d², so A cos⁴θ/Z² = A Z²/d⁴.
    sample.area * z2 / (distance2 * distance2)
}

/// The plane to sample on: the paraxial exit pupil's, a very distant one for a telecentric lens,
/// and the rear vertex' where the pupil lies too near the film.
fn sampling_plane(lens: &Lens) -> f64 {
    // A plane a million film distances away sees all film points alike, and its points still have
    // ten digits.
    let far = 1e6 * lens.film_distance();
    let Some(pupil) = lens.paraxial().exit_pupil else {
        return lens.film_z() - far;
    };
    let distance = lens.film_z() - pupil.z;
    // Nearer than a quarter of the film distance the region would spread with the film radius.
    if distance.abs() < 0.25 * lens.film_distance() {
        lens.length()
    } else {
        lens.film_z() - distance.clamp(-far, far)
    }
}

/// The rear element as the film sees it.
#[derive(Clone, Copy, Debug)]
struct Rear {
    radius: f64,
    /// z of vertex and rim.
    ends: [f64; 2],
    sag_curvature: f64,
}

impl Rear {
    fn new(lens: &Lens) -> Rear {
        let rear = lens.rear();
        let radius = rear.clear_radius();
        Rear {
            radius,
            ends: [lens.length(), lens.length() + rear.sag(radius)],
            sag_curvature: rear.curvature(),
        }
    }

    /// A circle on the plane `plane_z` around all lines from the film point through the element's
    /// cap, which lies in a cylinder between vertex and rim.
    fn region(&self, film_radius: f64, plane_z: f64, film_z: f64) -> Option<Ellipse> {
        // A disk at z is seen on the plane enlarged by k about the film point.
        let disk = |z: f64| {
            let k = (plane_z - film_z) / (z - film_z);
            (film_radius * (1.0 - k), self.radius * k.abs())
        };
        let ((c0, r0), (c1, r1)) = (disk(self.ends[0]), disk(self.ends[1]));
        let (low, high) = ((c0 - r0).min(c1 - r1), (c0 + r0).max(c1 + r1));
        let radius = 0.5 * (high - low).max(2.0 * r0).max(2.0 * r1);
        (radius.is_finite() && radius > 0.0).then_some(Ellipse {
            center: 0.5 * (low + high),
            along: radius,
            across: radius,
        })
    }

    /// The point of the cap above (x, y).
    fn point(&self, x: f64, y: f64) -> [f64; 3] {
        let r2 = x * x + y * y;
        let c = self.sag_curvature;
        [
            x,
            y,
            self.ends[0] + c * r2 / (1.0 + (1.0 - c * c * r2).max(0.0).sqrt()),
        ]
    }
}

/// Where the line from the film point (radius, 0) through `p` meets the plane.
fn on_plane(radius: f64, film_z: f64, p: [f64; 3], plane_z: f64) -> [f64; 2] {
    let k = (plane_z - film_z) / (p[2] - film_z);
    [radius + k * (p[0] - radius), k * p[1]]
}

/// Points on the boundary of the rays that pass, for the film point (radius, 0), on the plane
/// `plane_z`: the half with y ≥ 0, each just outside. Empty where no ray passes.
pub fn boundary(lens: &Lens, radius: f64, plane_z: f64) -> Vec<[f64; 2]> {
    let film = [radius, 0.0];
    let passes = |p: [f64; 2]| lens.trace_from_film(film, [p[0], p[1], plane_z]).is_ok();
    let Some(middle) = middle(lens, radius, plane_z).filter(|x| passes([*x, 0.0])) else {
        return Vec::new();
    };
    // The first step is found by doubling from next to nothing, the others from their neighbour.
    let mut step = 1e-9 * lens.rear().clear_radius();
    (0..=DIRECTIONS)
        .map(|i| {
            let (sin, cos) = (std::f64::consts::PI * i as f64 / DIRECTIONS as f64).sin_cos();
            let at = |t: f64| [middle + t * cos, t * sin.max(0.0)];
            step = first_outside(|t| passes(at(t)), step);
            at(step)
        })
        .collect()
}

/// The smallest t, to [`BOUNDARY_TOLERANCE`] and not below, where `inside` ends; `inside(0)` holds.
/// Brackets it from `guess`, by steps that double each time, then bisects.
fn first_outside(inside: impl Fn(f64) -> bool, guess: f64) -> f64 {
    let (mut low, mut high) = (guess, guess);
    let mut factor: f64 = 1.0 / 64.0;
    // Factors 1 + 2^k/64 leave the range of f64 within 60 steps either way.
    if inside(guess) {
        for _ in 0..60 {
            high = low * (1.0 + factor);
            if !inside(high) {
                break;
            }
            (low, factor) = (high, 2.0 * factor);
        }
    } else {
        for _ in 0..60 {
            low = high / (1.0 + factor);
            if inside(low) {
                break;
            }
            (high, factor) = (low, 2.0 * factor);
        }
    }
    for _ in 0..60 {
        if high - low <= BOUNDARY_TOLERANCE * high {
            break;
        }
        let t = 0.5 * (low + high);
        if inside(t) {
            low = t;
        } else {
            high = t;
        }
    }
    high
}

/// Where on the plane the ray in the meridional plane goes that passes all apertures with most
/// room, relative to their radii. `None` where no ray gets through the glass at all. The ray may
/// still be vignetted: then all of the meridional ones are.
fn middle(lens: &Lens, radius: f64, plane_z: f64) -> Option<f64> {
    let rear = Rear::new(lens);
    let film = [radius, 0.0];
    // The worst of the relative heights: each grows outward on both sides of its zero, so their
    // maximum has one valley, however narrow (a stop of a micrometre).
    let worst = |x: f64| {
        let ray = lens.film_ray(film, rear.point(x, 0.0));
        lens.tracer()
            .largest_relative_height(&ray)
            .unwrap_or(f64::INFINITY)
    };
    let scan = 64;
    let at = |i: usize| rear.radius * (2.0 * i as f64 / scan as f64 - 1.0);
    let (best, value) = (0..=scan)
        .map(|i| (i, worst(at(i))))
        .min_by(|a, b| a.1.total_cmp(&b.1))?;
    if !value.is_finite() {
        return None;
    }
    let x = valley(
        worst,
        at(best.saturating_sub(1)),
        at(best),
        at((best + 1).min(scan)),
    );
    let p = on_plane(radius, lens.film_z(), rear.point(x, 0.0), plane_z)[0];
    p.is_finite().then_some(p)
}

/// The lowest point of `f` between `a` and `c`, where `b` between them is lower than both ends:
/// golden section (Press et al., *Numerical Recipes*, §10.2), with infinite values allowed.
fn valley(f: impl Fn(f64) -> f64, mut a: f64, mut b: f64, mut c: f64) -> f64 {
    const GOLDEN: f64 = 0.381_966_011_250_105;
    let mut lowest = f(b);
    // 60 steps narrow the bracket by 3e-13.
    for _ in 0..60 {
        let right = c - b > b - a;
        let x = if right {
            b + GOLDEN * (c - b)
        } else {
            b - GOLDEN * (b - a)
        };
        let value = f(x);
        match (value < lowest, right) {
            (true, true) => (a, b) = (b, x),
            (true, false) => (c, b) = (b, x),
            (false, true) => c = x,
            (false, false) => a = x,
        }
        lowest = lowest.min(value);
    }
    b
}

/// The middle of a region's extent along the azimuth.
fn middle_of(boundary: &[[f64; 2]]) -> Option<f64> {
    let low = boundary.iter().map(|p| p[0]).reduce(f64::min)?;
    let high = boundary.iter().map(|p| p[0]).reduce(f64::max)?;
    Some(0.5 * (low + high))
}

/// The search for one ring's ellipse.
struct RingSearch<'a> {
    lens: &'a Lens,
    plane_z: f64,
    inner: f64,
    width: f64,
    drift: f64,
}

impl RingSearch<'_> {
    /// The ellipse around the boundaries at the ring's inner, middle and outer radius, made
    /// larger until no probe outside it passes.
    fn ring(&self, boundaries: [&[[f64; 2]]; 3], rear: &Rear) -> Option<Ring> {
        let mut points = Vec::new();
        for (i, boundary) in boundaries.into_iter().enumerate() {
            let radius = self.inner + 0.5 * i as f64 * self.width;
            points.extend(boundary.iter().map(|p| self.undrifted(radius, *p)));
        }
        // What the walk along the boundary did not see (a second part of the region, a corner
        // between two directions), probes do.
        points.extend(
            self.probes_over_the_element(rear)
                .filter(|(radius, p)| self.passes(*radius, *p))
                .map(|(radius, p)| self.undrifted(radius, p)),
        );
        let mut ellipse = enclosing_ellipse(&points)?;
        for _ in 0..4 {
            let before = points.len();
            points.extend(probes_around(&ellipse).enumerate().filter_map(|(i, p)| {
                let radius = self.radius(i);
                self.passes(radius, [p[0] + self.drift * (radius - self.inner), p[1]])
                    .then_some([p[0], p[1].abs()])
            }));
            if points.len() == before {
                break;
            }
            ellipse = enclosing_ellipse(&points)?;
        }
        Some(Ring {
            ellipse,
            drift: self.drift,
        })
    }

    /// Where `p`, seen from film radius `radius`, would lie at the ring's inner radius.
    fn undrifted(&self, radius: f64, p: [f64; 2]) -> [f64; 2] {
        [p[0] - self.drift * (radius - self.inner), p[1]]
    }

    /// A film radius in the ring, well spread over `i`.
    fn radius(&self, i: usize) -> f64 {
        self.inner + self.width * (0.5 + i as f64 * 0.618_033_988_749_895).fract()
    }

    fn passes(&self, radius: f64, p: [f64; 2]) -> bool {
        let point = [p[0], p[1], self.plane_z];
        self.lens.trace_from_film([radius, 0.0], point).is_ok()
    }

    /// Points all over the rear element's half with y ≥ 0, in sunflower order.
    fn probes_over_the_element(&self, rear: &Rear) -> impl Iterator<Item = (f64, [f64; 2])> {
        const PROBES: usize = 96;
        let rear = *rear;
        (0..PROBES).map(move |i| {
            let r = rear.radius * ((i as f64 + 0.5) / PROBES as f64).sqrt();
            let (sin, cos) = (2.399_963_229_728_653 * i as f64).sin_cos();
            let radius = self.radius(i);
            let cap = rear.point(r * cos, r * sin.abs());
            (
                radius,
                on_plane(radius, self.lens.film_z(), cap, self.plane_z),
            )
        })
    }
}

/// Points just outside the ellipse.
fn probes_around(ellipse: &Ellipse) -> impl Iterator<Item = [f64; 2]> {
    const PROBES: usize = 64;
    let e = *ellipse;
    (0..PROBES).map(move |i| {
        let (sin, cos) = (std::f64::consts::PI * (i as f64 + 0.5) / PROBES as f64).sin_cos();
        // Alternately at the rim and 2 % beyond it.
        let s = if i % 2 == 0 { 1.0005 } else { 1.02 };
        [e.center + s * e.along * cos, s * e.across * sin]
    })
}

/// A small ellipse, centred on the y = 0 axis, around points given by their half with y ≥ 0; `None`
/// for no points. For each ratio of the axes the best circle after scaling y, and of the ratios the
/// one with the least area.
fn enclosing_ellipse(points: &[[f64; 2]]) -> Option<Ellipse> {
    let (mut low, mut high, mut top) = (f64::INFINITY, f64::NEG_INFINITY, 0.0f64);
    for p in points {
        (low, high, top) = (low.min(p[0]), high.max(p[0]), top.max(p[1]));
    }
    if !(high - low).is_finite() || !top.is_finite() {
        return None;
    }
    // Regions thinner than this part of their length are as good as lines.
    let width = (0.5 * (high - low)).max(1e-6 * top).max(f64::MIN_POSITIVE);
    let height = top.max(1e-6 * width);
    let fit = |log_ratio: f64| {
        let ratio = height / width * log_ratio.exp();
        let farthest = |center: f64| {
            let distance2 = |p: &[f64; 2]| {
                let (x, y) = (p[0] - center, p[1] / ratio);
                x * x + y * y
            };
            points.iter().map(distance2).fold(0.0, f64::max)
        };
        let center = valley_coarse(farthest, low, high);
        let radius = farthest(center).sqrt().max(f64::MIN_POSITIVE) * (1.0 + MARGIN);
        Ellipse {
            center,
            along: radius,
            across: radius * ratio,
        }
    };
    // The axes' ratio is the box' to within a factor of e, for any convex region.
    let best = valley_coarse(|k| fit(k).area(), -1.0, 1.0);
    let ellipse = fit(best);
    debug_assert!(points.iter().all(|p| ellipse.holds(*p)));
    Some(ellipse)
}

/// Lowest point of a function with one valley, to 1e-4 of the bracket: less than the margin.
fn valley_coarse(f: impl Fn(f64) -> f64, mut a: f64, mut b: f64) -> f64 {
    const RATIO: f64 = 0.618_033_988_749_895;
    let (mut x, mut y) = (b - RATIO * (b - a), a + RATIO * (b - a));
    let (mut fx, mut fy) = (f(x), f(y));
    for _ in 0..18 {
        if fx < fy {
            (b, y, fy) = (y, x, fx);
            x = b - RATIO * (b - a);
            fx = f(x);
        } else {
            (a, x, fx) = (x, y, fy);
            y = a + RATIO * (b - a);
            fy = f(y);
        }
    }
    0.5 * (a + b)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::optics::Prescription;
    use proptest::prelude::*;

    const DGAUSS: &str = "29.475 3.76 1.67 25.2\n84.83 0.12 1 25.2\n19.275 4.025 1.67 23\n\
        40.77 3.275 1.699 23\n12.75 5.705 1 18\n0 4.5 0 17.1\n-14.495 1.18 1.603 17\n\
        40.77 6.065 1.658 20\n-20.385 0.19 1 20\n437.065 3.22 1.717 20\n-39.73 0 1 20\n";

    fn lens(text: &str, stop: f64, film_distance: f64) -> Lens {
        let mut p = Prescription::parse(text).unwrap();
        p.set_stops(stop);
        Lens::new(&p, film_distance).unwrap()
    }

    /// Well-spread points of the unit square: the R2 sequence (Roberts 2018).
    fn spread(count: u32) -> impl Iterator<Item = Vec2> {
        (0..count).map(|i| {
            let r = |a: f64| (0.5 + f64::from(i) * a).fract() as f32;
            Vec2::new(r(0.754_877_666_246_692_8), r(0.569_840_290_998_053_3))
        })
    }

    /// Mean projected solid angle of samples of `region`, and the fraction that passes.
    fn mean(
        lens: &Lens,
        film: [f64; 2],
        samples: impl Fn(Vec2) -> Option<PupilSample>,
    ) -> (f64, f64) {
        let count = 1 << 15;
        let (mut sum, mut passed) = (0.0, 0.0);
        for sample in spread(count).filter_map(samples) {
            if lens.trace_from_film(film, sample.point).is_ok() {
                sum += projected_solid_angle([film[0], film[1], lens.film_z()], &sample);
                passed += 1.0;
            }
        }
        (sum / f64::from(count), passed / f64::from(count))
    }

    /// Samples everything the rear element lets through.
    fn everything(lens: &Lens) -> ExitPupil {
        let mut all = ExitPupil::new(lens, 1e-3, 1);
        all.rings.clear();
        all
    }

    #[test]
    fn tiny_stops_are_found_and_their_light_goes_with_their_area() {
        for film in [[0.0, 0.0], [6.0, 5.0], [14.0, -12.0]] {
            let light = |stop: f64| {
                let lens = lens(DGAUSS, stop, 36.77);
                let pupil = ExitPupil::new(&lens, 22.0, RINGS);
                let (mean, passed) = mean(&lens, film, |u| pupil.sample(film, u));
                // Of a stop of 0.1 um the region curves within a ring.
                assert!(passed > 0.2, "{stop} {film:?}: {passed}");
                mean / (stop * stop)
            };
            let reference = light(0.1);
            for stop in [1e-2, 1e-3, 1e-4] {
                // Aberration over a stop of 0.1 mm changes less than the sampling does.
                assert!(
                    (light(stop) / reference - 1.0).abs() < 2e-3,
                    "{stop} {film:?}"
                );
            }
        }
    }

    #[test]
    fn lenses_without_a_stop_lose_nothing() {
        let text: String = DGAUSS
            .lines()
            .filter(|l| !l.starts_with("0 "))
            .map(|l| format!("{l}\n"))
            .collect();
        let lens = lens(&text, 1.0, 36.77);
        let (pupil, all) = (ExitPupil::new(&lens, 22.0, RINGS), everything(&lens));
        for film in [[0.0, 0.0], [0.0, 9.0], [-12.0, 9.0], [15.0, 13.0]] {
            let (found, passed) = mean(&lens, film, |u| pupil.sample(film, u));
            let (truth, _) = mean(&lens, film, |u| all.sample(film, u));
            // Both estimates have some 1e-3, the wasteful one more.
            assert!(
                (found / truth - 1.0).abs() < 5e-3,
                "{film:?} {found} {truth}"
            );
            assert!(passed > 0.6, "{film:?} {passed}");
        }
    }

    #[test]
    fn awkward_exit_pupils_are_sampled_all_the_same() {
        for (name, text, film_distance) in [
            // The stop in the front focal plane: telecentric, exit pupil at infinity.
            ("telecentric", "0 100 0 5\n50 0 1.5 40\ninf 0 1 40\n", 120.0),
            // A stop imaged onto the film, and one imaged behind it.
            ("at the film", "0 200 0 5\n50 0 1.5 40\ninf 0 1 40\n", 200.0),
            (
                "behind the film",
                "0 200 0 5\n50 0 1.5 40\ninf 0 1 40\n",
                100.0,
            ),
            // Only a stop.
            ("pinhole", "0 0 0 0.4\n", 30.0),
        ] {
            let lens = lens(text, 5.0, film_distance);
            let (pupil, all) = (ExitPupil::new(&lens, 6.0, RINGS), everything(&lens));
            for film in [[0.0, 0.0], [1.0, 1.0], [0.0, -4.0]] {
                let (found, _) = mean(&lens, film, |u| pupil.sample(film, u));
                let (truth, _) = mean(&lens, film, |u| all.sample(film, u));
                let close = (found - truth).abs() <= 2e-2 * truth;
                assert!(close, "{name} {film:?}: {found} {truth}");
            }
        }
    }

    #[test]
    fn outside_the_image_circle_there_is_nothing() {
        // A stop far in front of a small lens shades everything beyond some film radius.
        let lens = lens("0 60 0 4\n30 3 1.5 8\n-30 0 1 8\n", 4.0, 31.0);
        let pupil = ExitPupil::new(&lens, 60.0, RINGS);
        assert!(pupil.region(0.0).is_some() && pupil.region(59.0).is_none());
        assert_eq!(pupil.sample([0.0, 59.0], Vec2::splat(0.5)), None);
    }

    #[test]
    fn the_enclosing_ellipse_of_an_ellipse_is_itself() {
        let points: Vec<[f64; 2]> = (0..=48)
            .map(|i| std::f64::consts::PI * f64::from(i) / 48.0)
            .map(|a| [7.0 + 3.0 * a.cos(), 0.5 * a.sin()])
            .collect();
        let e = enclosing_ellipse(&points).unwrap();
        // The margin on each axis, and the coarse search.
        assert!(
            (e.area() / (std::f64::consts::PI * 1.5) - 1.0).abs() < 3.0 * MARGIN,
            "{e:?}"
        );
        assert!((e.center - 7.0).abs() < 1e-2);
        assert_eq!(enclosing_ellipse(&[]), None);
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(48))]

        /// Whatever the lens, making its regions ends, and sampling them gives finite points.
        #[test]
        fn wild_lenses_have_finite_regions(
            rows in prop::collection::vec((-3.0..3.0f64, 0.0..20.0f64, 1.0..2.0f64, 0.01..40.0f64), 1..8),
            film_distance in 0.01..200.0f64,
        ) {
            let text: String = rows
                .iter()
                .map(|(c, t, n, a)| format!("{} {t} {n} {a}\n", if c.abs() < 0.3 { 0.0 } else { 20.0 / c }))
                .collect();
            let lens = Lens::new(&Prescription::parse(&text).unwrap(), film_distance).unwrap();
            let pupil = ExitPupil::new(&lens, 20.0, 8);
            for (i, u) in spread(64).enumerate() {
                let film = [i as f64 * 0.4, -0.1 * i as f64];
                if let Some(s) = pupil.sample(film, u) {
                    prop_assert!(s.point.iter().all(|x| x.is_finite()) && s.area.is_finite() && s.area > 0.0);
                    prop_assert!(pupil.projected_solid_angle(film, &s).is_finite());
                }
            }
        }
    }
}
