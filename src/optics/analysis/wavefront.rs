//! The wavefront of an object point, and the contrast that diffraction leaves of it.
//!
//! Rays are followed to where they are needed: at even steps of the direction cosines with which they arrive at the film. In these
//! the field at the film is a Fourier transform of the pupil, with the optical path to the foot of the perpendicular from a point of the
//! film as its phase (Hamilton's angular characteristic: Born and Wolf, *Principles of Optics*, 7th edition, §4.1 and 8.8), and
//! the optical transfer function the pupil's autocorrelation (Goodman, *Introduction to Fourier Optics*, §6.3): a frequency of ν line
//! pairs shifts one copy by λν. A scalar theory, of one wavelength; cosines over the index of refraction at the film.

use super::beam::Beam;
use super::contrast::Follower;
use crate::optics::dispersion::LINE_D;
use crate::optics::lens::Lens;
use crate::optics::real::Dual;
use crate::optics::trace::LensRay;
use std::f64::consts::TAU;

/// Wavelength of the d line, mm.
pub const WAVELENGTH: f64 = 1e-3 * LINE_D;

/// The pupil of one object point on a grid of direction cosines.
#[derive(Clone, Debug)]
pub struct Wavefront {
    /// Cells across and along the meridional plane.
    size: [usize; 2],
    /// Of a cell, in cosines times the index at the film.
    step: [f64; 2],
    /// Square root of the light in a cell, and optical path in mm; `None` where nothing arrives.
    cells: Vec<Option<[f64; 2]>>,
}

/// A map between places in the beam and direction cosines at the film.
struct Directions<'a> {
    lens: &'a Lens,
    beam: &'a Beam,
    /// Place in the beam ≈ `origin` + `slope` · cosine, each axis for itself.
    origin: [f64; 2],
    slope: [f64; 2],
}

impl Wavefront {
    /// Of `beam` about the film point `about`, with `size` cells over its cone of rays; `None` where too few rays arrive.
    pub fn new(lens: &Lens, beam: &Beam, about: [f64; 2], size: [usize; 2]) -> Option<Wavefront> {
        let (directions, range) = Directions::new(lens, beam)?;
        let step = [0, 1].map(|k| (range[k][1] - range[k][0]) / size[k] as f64);
        let cell = |i: usize| {
            let at = [i % size[0], i / size[0]];
            let cosine = [0, 1].map(|k| range[k][0] + (at[k] as f64 + 0.5) * step[k]);
            let (p, area) = directions.place(cosine)?;
            Some([area.sqrt(), optical_path(lens, beam, p, about)?])
        };
        let index = lens.rear().index;
        Some(Wavefront {
            size,
            step: step.map(|s| index * s),
            cells: (0..size[0] * size[1]).map(cell).collect(),
        })
    }

    /// Frequencies at which the transfer is known along an axis (0 across the meridional plane, 1 along it), line pairs per mm: whole steps
    /// of the grid.
    pub fn frequencies(&self, axis: usize) -> impl Iterator<Item = f64> + '_ {
        (0..self.size[axis]).map(move |k| k as f64 * self.step[axis] / WAVELENGTH)
    }

    /// At these frequencies, from none on, the modulus of the transfer, negative where black and white have changed places.
    pub fn transfer(&self, axis: usize) -> impl Iterator<Item = f64> + '_ {
        let mut follower = Follower::default();
        (0..self.size[axis]).map(move |k| follower.next(self.autocorrelation(axis, k)))
    }

    /// The optical transfer function at the frequency number `k` along an axis.
    fn autocorrelation(&self, axis: usize, k: usize) -> [f64; 2] {
        let (mut re, mut im, mut all) = (0.0, 0.0, 0.0);
        let stride = if axis == 0 { k } else { k * self.size[0] };
        for (i, cell) in self.cells.iter().enumerate() {
            let Some([amplitude, path]) = cell else {
                continue;
            };
            all += amplitude * amplitude;
            let inside = axis == 1 || i % self.size[0] + k < self.size[0];
            let other = self.cells.get(i + stride).copied().flatten();
            if let (true, Some([other, path2])) = (inside, other) {
                let (sin, cos) = (TAU / WAVELENGTH * (path2 - path)).sin_cos();
                re += amplitude * other * cos;
                im += amplitude * other * sin;
            }
        }
        if all > 0.0 {
            [re / all, im / all]
        } else {
            [0.0; 2]
        }
    }

    /// Root mean square departure of the wavefront from the sphere about its point that fits best, waves of the d line.
    pub fn rms(&self) -> f64 {
        let cells = self.cells.iter().flatten();
        let sum = |f: &dyn Fn(&[f64; 2]) -> f64| cells.clone().map(f).sum::<f64>();
        let light = sum(&|c| c[0] * c[0]);
        let mean = sum(&|c| c[0] * c[0] * c[1]) / light;
        (sum(&|c| (c[0] * (c[1] - mean)).powi(2)) / light).sqrt() / WAVELENGTH
    }
}

impl<'a> Directions<'a> {
    /// With the range of cosines that arrive; `None` where too few rays do.
    fn new(lens: &'a Lens, beam: &'a Beam) -> Option<(Directions<'a>, [[f64; 2]; 2])> {
        const ACROSS: usize = 48;
        let places = beam.grid(lens, ACROSS);
        let rays: Vec<([f64; 2], [f64; 2])> = places
            .iter()
            .filter_map(|(p, _)| {
                let d = beam.at_film(lens, *p)?.d;
                Some((*p, [d[0], d[1]]))
            })
            .collect();
        if rays.len() < ACROSS {
            return None;
        }
        let mut directions = Directions {
            lens,
            beam,
            origin: [0.0; 2],
            slope: [0.0; 2],
        };
        let n = rays.len() as f64;
        let range = [0, 1].map(|k| {
            let mean = |f: fn(f64, f64) -> f64, p: f64, c: f64| {
                let sum: f64 = rays.iter().map(|r| f(r.0[k] - p, r.1[k] - c)).sum();
                sum / n
            };
            let (p, c) = (mean(|p, _| p, 0.0, 0.0), mean(|_, c| c, 0.0, 0.0));
            let slope = mean(|p, c| p * c, p, c) / mean(|_, c| c * c, p, c);
            (directions.slope[k], directions.origin[k]) = (slope, p - slope * c);
            let (low, high) = rays
                .iter()
                .map(|r| r.1[k])
                .fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), x| {
                    (l.min(x), h.max(x))
                });
            // Rays of the grid are in the middle of their cells: half a cell more on either side holds the rest.
            let more = (high - low) / ACROSS as f64;
            [low - more, high + more]
        });
        let sound = directions.slope.iter().all(|s| s.is_finite() && *s != 0.0);
        sound.then_some((directions, range))
    }

    /// Where in the beam the ray is that arrives with these cosines, by Newton's method, and the area of the beam for one of cosines; `None` where
    /// it is blocked.
    fn place(&self, cosine: [f64; 2]) -> Option<([f64; 2], f64)> {
        let mut p: [f64; 2] = std::array::from_fn(|k| self.origin[k] + self.slope[k] * cosine[k]);
        // The error is squared each time; the first guess is off by some per cent of the beam.
        for _ in 0..6 {
            let start = self
                .beam
                .ray([Dual::parameter(p[0], 0), Dual::parameter(p[1], 1)]);
            let out: LensRay<Dual> = self.lens.tracer().to_film_unclipped(&start).ok()?;
            let [x, y, _] = out.d;
            let (ex, ey) = (cosine[0] - x.value, cosine[1] - y.value);
            let determinant = x.by[0] * y.by[1] - x.by[1] * y.by[0];
            if ex.abs() + ey.abs() < 1e-10 {
                self.beam.on_film(self.lens, p)?;
                return Some((p, 1.0 / determinant.abs())).filter(|(_, a)| a.is_finite());
            }
            p[0] += (ex * y.by[1] - ey * x.by[1]) / determinant;
            p[1] += (ey * x.by[0] - ex * y.by[0]) / determinant;
            // Far from the beam nothing is to be found.
            let far = |k: usize| {
                let [low, high] = self.beam.extent[k];
                !(2.0 * low - high..2.0 * high - low).contains(&p[k])
            };
            if far(0) || far(1) {
                return None;
            }
        }
        None
    }
}

/// From the object, or a wave front in front of the lens, to the foot of the perpendicular from the film point `about` on the ray, mm.
fn optical_path(lens: &Lens, beam: &Beam, p: [f64; 2], about: [f64; 2]) -> Option<f64> {
    let ray = beam.ray(p);
    let mut path = beam.lead(&ray);
    let (mut from, mut index) = (ray.o, 1.0);
    let out = lens.tracer().visit_to_film(&ray, |i, to| {
        let way = (0..3)
            .map(|k| (to[k] - from[k]) * (to[k] - from[k]))
            .sum::<f64>()
            .sqrt();
        // The plane where the beam starts may lie behind the front surface.
        let along = (0..3).map(|k| (to[k] - from[k]) * ray.d[k]).sum::<f64>();
        path += index * if i == 0 { way.copysign(along) } else { way };
        (from, index) = (to, lens.surfaces()[i].index);
    });
    let (out, film) = (out.ok()?, [about[0], about[1], lens.film_z()]);
    let rest: f64 = (0..3).map(|k| (film[k] - from[k]) * out.d[k]).sum();
    Some(path + index * rest).filter(|x| x.is_finite())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::optics::analysis::{ChiefFinder, ObjectPlane, Spot};
    use crate::optics::{ExitPupil, Prescription};

    fn axial(lens: &Lens) -> Beam {
        let pupil = ExitPupil::new(lens, 1.0, 8);
        let chief = ChiefFinder::new(lens).find(0.0).unwrap();
        Beam::new(lens, &pupil, &chief, ObjectPlane::INFINITY).unwrap()
    }

    /// Descartes' ellipsoid, of conic −1/n², images a distant point perfectly into its glass, at nR/(n − 1): what is left is the
    /// autocorrelation of a circle.
    #[test]
    fn a_perfect_surface_has_the_contrast_of_a_round_pupil() {
        let conic = -1.0 / (1.5f64 * 1.5);
        let text = format!("0 0 0 20\n20 0 1.5 40 k={conic}\n");
        let lens = Lens::new(&Prescription::parse(&text).unwrap(), 60.0).unwrap();
        let wavefront = Wavefront::new(&lens, &axial(&lens), [0.0; 2], [64, 64]).unwrap();
        // Rounding of a path of some 80 mm.
        assert!(wavefront.rms() < 1e-8, "{}", wavefront.rms());
        let sine = {
            let out = lens
                .tracer()
                .to_film(&LensRay::new([0.0, 9.999_999, -1.0], [0.0, 0.0, 1.0]))
                .unwrap();
            -out.d[1]
        };
        let cutoff = 2.0 * 1.5 * sine / WAVELENGTH;
        for axis in [0, 1] {
            for (frequency, found) in wavefront.frequencies(axis).zip(wavefront.transfer(axis)) {
                let s = (frequency / cutoff).min(1.0);
                let expected = (s.acos() - s * (1.0 - s * s).sqrt()) * 2.0 / std::f64::consts::PI;
                // A circle of 64 cells, whose light is a little uneven in cosines (no more than a part in fifty here).
                assert!(
                    (found - expected).abs() < 0.015,
                    "{axis} {frequency}: {found} {expected}"
                );
            }
        }
    }

    #[test]
    fn many_waves_of_aberration_leave_the_contrast_of_the_rays() {
        // A plano-convex lens at f/5 a millimeter out of focus: some 30 waves. Rays and waves agree as long as the frequency is a small part
        // of the cut-off of 340 lp/mm: the phase of the rays is the first derivative of that of the waves.
        let p = Prescription::parse("0 0 0 20\ninf 5 1.5 30\n-50 0 1 30\n").unwrap();
        let lens = Lens::new(&p, 97.0).unwrap();
        let beam = axial(&lens);
        let rays = Spot::trace(&lens, &beam, 200);
        let wavefront = Wavefront::new(&lens, &beam, [0.0; 2], [96, 96]).unwrap();
        assert!(wavefront.rms() > 2.0, "{}", wavefront.rms());
        let curve = wavefront.frequencies(0).zip(wavefront.transfer(0));
        for (frequency, waves) in curve.take(9) {
            let [geometric, _] = rays.mtf(frequency);
            // What diffraction takes of a perfect lens there: 4/π of the part of the cut-off.
            let most = 0.02 + 1.4 * frequency / 340.0;
            assert!(
                (waves - geometric).abs() < most,
                "{frequency}: {waves} {geometric}"
            );
        }
    }
}
