//! The exit pupil of a film whose points do not all lie on one plane perpendicular to the axis.
//!
//! A lens looks the same from all points at one distance from its axis and at one z. A film that is tilted is cut into slabs across the axis, thin
//! beside the way to the lens, and each has its own regions by film radius, which hold what passes from anywhere within it.

use super::survey::Survey;
use super::{ExitPupil, PupilSample, PupilSampling, RINGS, sampling_plane};
use crate::math::Vec2;
use crate::optics::lens::Lens;

/// A slab is no thicker than this part of the way from the rear vertex to the film: across it the outline moves by a few hundredths of
/// its radius, which are lost to samples.
const SLAB: f64 = 1.0 / 64.0;

/// Slabs at most; of a film that is tilted more they are thicker, and more samples are lost.
const MOST_SLABS: usize = 48;

/// A plane nearer to a film than this part of how deep it is would be met at too flat an angle, if not by the film itself.
const CLEARANCE: f64 = 2.0;

/// For every point of a tilted film, the region of the exit pupil to sample.
#[derive(Clone, Debug)]
pub struct TiltedPupil {
    slabs: Vec<ExitPupil>,
    /// z of the film's nearest and farthest point.
    ends: [f64; 2],
    plane_z: f64,
}

impl TiltedPupil {
    /// For film points from z = `ends[0]` to `ends[1]`, up to `max_radius` mm from the axis. All of them lie behind the rear element.
    pub fn new(lens: &Lens, ends: [f64; 2], max_radius: f64, sampling: PupilSampling) -> Self {
        let plane_z = plane(lens, ends);
        let depth = ends[1] - ends[0];
        let count = (depth / (SLAB * lens.film_distance())).ceil();
        let count = (count as usize).clamp(1, MOST_SLABS);
        let at = |i: usize| ends[0] + depth * i as f64 / count as f64;
        let slab = |i: usize| {
            let survey = Survey::of_slab(lens, plane_z, [at(i), at(i + 1)], max_radius);
            ExitPupil::surveyed(survey, RINGS).with_sampling(sampling)
        };
        TiltedPupil {
            slabs: (0..count).map(slab).collect(),
            ends,
            plane_z,
        }
    }

    /// z of the plane that is sampled.
    pub fn plane_z(&self) -> f64 {
        self.plane_z
    }

    /// The slab that holds film points at this z.
    fn slab(&self, z: f64) -> Option<&ExitPupil> {
        let part = (z - self.ends[0]) / (self.ends[1] - self.ends[0]);
        let at = (part * self.slabs.len() as f64) as usize;
        self.slabs.get(at.min(self.slabs.len() - 1))
    }

    /// See [`ExitPupil::sample`].
    pub fn sample(&self, film: [f64; 3], u: Vec2) -> Option<PupilSample> {
        self.slab(film[2])?.sample([film[0], film[1]], u)
    }

    /// See [`ExitPupil::area_at`].
    pub fn area_at(&self, film: [f64; 3], point: [f64; 2]) -> Option<f64> {
        self.slab(film[2])?.area_at([film[0], film[1]], point)
    }
}

/// The plane to sample on: as for a flat film, unless that is too near to this one.
fn plane(lens: &Lens, [near, far]: [f64; 2]) -> f64 {
    let usual = sampling_plane(lens);
    let middle = 0.5 * (near + far);
    if (usual - middle).abs() > CLEARANCE * (far - near) {
        usual
    } else {
        lens.length()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::optics::lanes::FilmTracer;
    use crate::optics::{LensRay, Prescription};

    /// Of rays from all over a deep film through all of the rear element hardly one that passes is outside its point's region, and most samples
    /// of the regions pass.
    #[test]
    fn what_passes_from_a_tilted_film_lies_in_its_region() {
        for name in ["dgauss_50", "wide_22", "tessar_100"] {
            let file = format!("{}/tests/golden/{name}.dat", env!("CARGO_MANIFEST_DIR"));
            let p = Prescription::read(file.as_ref()).unwrap();
            let lens = Lens::new(&p, Lens::focused(&p, 2000.0).unwrap()).unwrap();
            let (z, half) = (lens.film_z(), 0.12 * lens.film_distance());
            let ends = [z - half, z + half];
            let reach = 18.0;
            let pupil = TiltedPupil::new(&lens, ends, reach, PupilSampling::default());
            let (mut passed, mut missed, mut sampled) = (0u32, 0u32, 0u32);
            const COUNT: u32 = 200_000;
            for i in 0..COUNT {
                // The R sequence (Roberts 2018).
                let r = |k: i32| (0.5 + f64::from(i) / 1.134_724_138_401_519f64.powi(k)).fract();
                let azimuth = std::f64::consts::TAU * r(4);
                let radius = reach * r(1).sqrt();
                let film = [
                    radius * azimuth.cos(),
                    radius * azimuth.sin(),
                    ends[0] + 2.0 * half * r(2),
                ];
                let turn = std::f64::consts::TAU * r(3);
                let height = lens.rear().clear_radius() * r(5).sqrt();
                let sag = lens.rear().sag(height);
                let through = [
                    height * turn.cos(),
                    height * turn.sin(),
                    lens.length() + sag,
                ];
                let passes = |film: [f64; 3], to: [f64; 3]| {
                    let mut ray = LensRay::through(film, to);
                    if ray.d[2] > 0.0 {
                        ray.d = ray.d.map(|x| -x);
                    }
                    lens.tracer().to_scene(&ray).is_ok()
                };
                if passes(film, through) {
                    passed += 1;
                    let k = (pupil.plane_z() - film[2]) / (through[2] - film[2]);
                    let at = [0, 1].map(|i| film[i] + k * (through[i] - film[i]));
                    missed += u32::from(pupil.area_at(film, at).is_none());
                }
                let sample = pupil.sample(film, Vec2::new(r(3) as f32, r(5) as f32));
                let sample = sample.filter(|s| passes(film, s.point));
                sampled += u32::from(sample.is_some());
                if let Some(s) = sample {
                    let there = pupil.area_at(film, [s.point[0], s.point[1]]).unwrap();
                    // On the border of two triangles it may be the other's.
                    assert!((there / s.area - 1.0).abs() < 0.05, "{there} {}", s.area);
                }
            }
            println!(
                "{name}: {} slabs, {missed} of {passed}, {sampled}",
                pupil.slabs.len()
            );
            // Of samples of a flat film some nine in ten pass.
            assert!(sampled > COUNT / 4 * 3, "{name}: {sampled}");
            assert!(
                passed > COUNT / 50 && missed * 10_000 < passed,
                "{name}: {missed} of {passed}"
            );
        }
    }

    /// A slab without depth is the flat film's pupil.
    #[test]
    fn a_film_without_depth_has_the_flat_films_pupil() {
        let p = Prescription::parse("50 5 1.5168 20\n-50 2 1 20\n0 0 0 10\n").unwrap();
        let lens = Lens::new(&p, 50.0).unwrap();
        let z = lens.film_z();
        let flat = ExitPupil::new(&lens, 15.0, RINGS);
        let tilted = TiltedPupil::new(&lens, [z, z], 15.0, PupilSampling::default());
        assert_eq!((tilted.slabs.len(), tilted.plane_z()), (1, flat.plane_z()));
        for (film, u) in [([0.0, 0.0], [0.2, 0.7]), ([9.0, -4.0], [0.9, 0.4])] {
            let u = Vec2::from(u);
            let both = [
                flat.sample(film, u),
                tilted.sample([film[0], film[1], z], u),
            ];
            assert_eq!(both[0], both[1]);
        }
        // Both trace alike.
        let tracers = [
            FilmTracer::<f64>::new(&lens, 0.0),
            FilmTracer::from_plane(&lens, z, 0.0),
        ];
        let rays = tracers.map(|t| t.trace(&[3.0, 4.0], &[1.0, 2.0]));
        assert_eq!(rays[0].ray.o, rays[1].ray.o);
    }
}
