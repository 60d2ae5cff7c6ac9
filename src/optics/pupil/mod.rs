//! Where to aim: the part of the exit pupil that a film point sees light through.
//!
//! Most rays toward the rear element end at some rim. For each of a number of rings of film
//! radius the outline of the rays that pass is found by tracing ([`outline`]), and a polygon around it is
//! kept that moves with the film radius ([`ring`]); samples are drawn uniformly from the polygon, and
//! their weight carries its area. The polygon holds every ray that passes, so the expectation is that of
//! sampling everything: what bends outward between the film radii and directions that were traced is
//! measured half-way and made room for ([`draft`]), rings are split where the pupil changes fast, and rays
//! just outside and all over the rear element look for light that was overlooked ([`survey`]).
//!
//! The plane is that of the paraxial exit pupil, where the region hardly moves within a ring. The
//! paraxial pupil disk itself would not do (pupil aberration moves the true one off it by up to half
//! its light), nor the rear element's disk at its vertex (the rim of a curved surface lies elsewhere;
//! a wide-angle lens loses its corners). pbrt's boxes (3rd edition §6.4.5) waste a quarter of the
//! rays or more, and miss a stop of a hundredth of a millimetre altogether, because they look for it with
//! random rays. Here the search starts from a ray that passes and walks outward. `docs/pupil.md` has
//! the figures.
//!
//! How the unit square is spread over the polygon is a [`PupilSampling`]; [`stops`] finds the pupils as
//! lens designers do, by imaging every aperture.

mod draft;
mod ellipse;
mod mapping;
mod outline;
mod rear;
mod ring;
mod survey;

pub use mapping::PupilSampling;
pub use ring::Region;

use self::mapping::Polar;
use self::outline::View;
use self::rear::Rear;
use self::ring::Ring;
use self::survey::Survey;
use super::lens::Lens;
use crate::math::Vec2;

/// A point of the exit pupil to aim at.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PupilSample {
    /// Where, in lens coordinates.
    pub point: [f64; 3],
    /// Area it was drawn from uniformly, mm², on a plane perpendicular to the axis.
    pub area: f64,
}

/// For every film radius, the region of the exit pupil to sample.
#[derive(Clone, Debug)]
pub struct ExitPupil {
    plane_z: f64,
    film_z: f64,
    /// Largest film radius that `rings` know of.
    reach: f64,
    /// By film radius; between them it is dark.
    rings: Vec<Ring>,
    /// For equal parts of the reach, the first ring that may serve it.
    first: Vec<u32>,
    rear: Rear,
    sampling: PupilSampling,
}

/// Rings to begin with; they are split where the pupil changes fast. Between 16 of them and their
/// middles no change of the pupil is overlooked in the lenses of `tests/golden`.
pub const RINGS: usize = 16;

impl ExitPupil {
    /// Finds the regions for film points up to `max_radius` mm from the axis, beginning with `rings`
    /// rings.
    pub fn new(lens: &Lens, max_radius: f64, rings: usize) -> ExitPupil {
        let survey = Survey {
            lens,
            plane_z: sampling_plane(lens),
            rear: Rear::new(lens),
            reach: max_radius.max(f64::MIN_POSITIVE),
        };
        let rings = survey.rings(rings.max(1));
        // Four parts to a ring: two steps from the first find it, on average.
        let parts = 4 * rings.len() + 1;
        let first = (0..parts).map(|i| {
            let radius = survey.reach * i as f64 / parts as f64;
            rings.partition_point(|r| r.radii[1] < radius) as u32
        });
        ExitPupil {
            plane_z: survey.plane_z,
            film_z: lens.film_z(),
            reach: survey.reach,
            first: first.collect(),
            rings,
            rear: survey.rear,
            sampling: PupilSampling::default(),
        }
    }

    /// The same regions, sampled in another way.
    pub fn with_sampling(self, sampling: PupilSampling) -> ExitPupil {
        ExitPupil { sampling, ..self }
    }

    /// z of the plane that is sampled.
    pub fn plane_z(&self) -> f64 {
        self.plane_z
    }

    /// Number of rings.
    pub fn rings(&self) -> usize {
        self.rings.len()
    }

    /// The region for film points `radius` mm from the axis; `None` where no light arrives.
    /// Beyond the largest radius: everything the rear element lets through.
    pub fn region(&self, radius: f64) -> Option<Region> {
        if radius <= self.reach {
            return self.ring(radius).map(|ring| ring.region(ring.t(radius)));
        }
        let e = self.rear.region(radius, self.plane_z, self.film_z)?;
        Some(Region {
            center: e.center,
            along: e.along,
            across: e.across,
            area: e.area(),
        })
    }

    /// The ring of a film radius within reach.
    #[inline]
    fn ring(&self, radius: f64) -> Option<&Ring> {
        let part = (radius / self.reach * self.first.len() as f64) as usize;
        let first = self.first[part.min(self.first.len() - 1)] as usize;
        let ring = self.rings[first..].iter().find(|r| radius <= r.radii[1])?;
        (ring.radii[0] <= radius).then_some(ring)
    }

    /// Maps `u` in the unit square to the region of the film point (x, y) mm, evenly over its area.
    /// `None` where no light arrives.
    pub fn sample(&self, film: [f64; 2], u: Vec2) -> Option<PupilSample> {
        let radius = film[0].hypot(film[1]);
        let ([x, y], area) = if radius <= self.reach {
            let ring = self.ring(radius)?;
            let t = ring.t(radius);
            (ring.sample(t, u, self.sampling), ring.area(t))
        } else {
            let e = self.rear.region(radius, self.plane_z, self.film_z)?;
            (e.point(Polar::concentric(u)), e.area())
        };
        let (cos, sin) = if radius > 0.0 {
            (film[0] / radius, film[1] / radius)
        } else {
            (1.0, 0.0)
        };
        Some(PupilSample {
            point: [cos * x - sin * y, sin * x + cos * y, self.plane_z],
            area,
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
pub fn sampling_plane(lens: &Lens) -> f64 {
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

/// Points on the outline of the rays that pass, for the film point (radius, 0), on the plane
/// `plane_z`: the half with y ≥ 0, each just outside. Empty where no ray passes.
pub fn boundary(lens: &Lens, radius: f64, plane_z: f64) -> Vec<[f64; 2]> {
    let view = View {
        lens,
        radius,
        plane_z,
    };
    let outline = view.outline(&Rear::new(lens), None);
    outline.map_or(Vec::new(), |o| o.absolute().collect())
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
        all.reach = -1.0;
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
