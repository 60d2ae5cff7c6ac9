//! All of pbrt-v2's `Volume`s of a scene, which add up where they overlap (its `AggregateVolume`).
//!
//! A single medium that fills the whole scene, nonempty only in the boxes: surfaces are not interfaces of it, as in
//! pbrt-v2, so that cameras inside a box, glass in it and nested boxes need no special treatment.
//!
//! Free paths are sampled by spectral tracking (Kutz, Habel, Li and Novák 2017, §4): a tentative collision scatters
//! with a probability determined by the scattering in the channels that matter to the path, and absorption is a weight.

use super::boxes::Chord;
use super::numbers::Numbers;
use super::{Flight, HenyeyGreenstein, Volume};
use crate::math::Rgb;
use crate::math::ray::Ray;
use crate::samplers::SampleStream;

/// Number of stratified points along a ray's segment in a box at which emission is sampled.
const EMISSION_SAMPLES: u32 = 4;

/// Volumes in render space.
#[derive(Clone, Debug)]
pub struct Volumes {
    volumes: Vec<Volume>,
    shines: bool,
}

/// A segment of a ray that lies in a fixed set of boxes.
struct Stretch {
    end: f64,
    /// Upper bound of the extinction of every channel.
    majorant: f64,
}

impl Volumes {
    /// A medium from at least one volume.
    pub fn new(volumes: Vec<Volume>) -> Volumes {
        let shines = volumes.iter().any(Volume::shines);
        Volumes { volumes, shines }
    }

    /// The phase function of one of the volumes.
    pub fn phase(&self, volume: usize) -> Option<&HenyeyGreenstein> {
        self.volumes.get(volume).map(|volume| &volume.spec.phase)
    }

    /// See [`super::Medium::transmittance`].
    pub fn transmittance(&self, ray: &Ray, t_max: f32, stream: &mut SampleStream) -> Rgb {
        self.left(ray, f64::from(t_max), &mut Numbers::new(stream))
    }

    /// The product of the transmittances of all volumes.
    fn left(&self, ray: &Ray, t_max: f64, numbers: &mut Numbers) -> Rgb {
        let mut left = Rgb::ONE;
        for volume in &self.volumes {
            left *= volume.transmittance(ray, t_max, numbers);
        }
        left
    }

    /// See [`super::Medium::emission`].
    pub fn emission(&self, ray: &Ray, t_max: f32, stream: &mut SampleStream) -> Rgb {
        if !self.shines {
            return Rgb::ZERO;
        }
        let mut numbers = Numbers::new(stream);
        let mut sum = Rgb::ZERO;
        for volume in self.volumes.iter().filter(|volume| volume.shines()) {
            let Some(chord) = volume.chord(ray, f64::from(t_max)) else {
                continue;
            };
            let part = (chord.end - chord.start) / f64::from(EMISSION_SAMPLES);
            for i in 0..EMISSION_SAMPLES {
                let t = chord.start + part * (f64::from(i) + f64::from(numbers.next()));
                let left = self.left(ray, t, &mut numbers);
                sum += left * volume.emission(&chord, t) * part as f32;
            }
        }
        sum
    }

    /// The next stretch from `t` on that ends before `t_max`; `None` if no box is ahead.
    fn stretch(&self, ray: &Ray, t: f64, t_max: f64) -> Option<Stretch> {
        let mut stretch = Stretch {
            end: f64::INFINITY,
            majorant: 0.0,
        };
        for volume in &self.volumes {
            match volume.chord(ray, t_max) {
                Some(chord) if chord.start > t => stretch.end = stretch.end.min(chord.start),
                Some(chord) if chord.end > t => {
                    stretch.end = stretch.end.min(chord.end);
                    stretch.majorant += volume.majorant();
                }
                _ => {}
            }
        }
        stretch.end.is_finite().then_some(stretch)
    }

    /// The volumes that contain the ray at distance `t`, with its segments inside them.
    fn around(&self, ray: &Ray, t: f64) -> impl Iterator<Item = (usize, &Volume, Chord)> {
        let ray = *ray;
        (self.volumes.iter().enumerate()).filter_map(move |(i, volume)| {
            let chord = volume.chord(&ray, f64::MAX)?;
            (chord.start <= t && t <= chord.end).then_some((i, volume, chord))
        })
    }

    /// See [`super::Medium::sample`]; also returns the volume in which light scatters.
    pub fn sample(
        &self,
        ray: &Ray,
        t_max: f32,
        throughput: Rgb,
        stream: &mut SampleStream,
    ) -> (Flight, usize) {
        let mut numbers = Numbers::new(stream);
        let (mut t, mut weight) = (0.0, Rgb::ONE);
        while let Some(stretch) = self.stretch(ray, t, f64::from(t_max)) {
            loop {
                t += f64::from(numbers.step()) / stretch.majorant;
                // Also false if the majorant is 0.
                let inside = t < stretch.end;
                if !inside {
                    break;
                }
                let matter = (throughput * weight).abs();
                match self.collide(ray, t, stretch.majorant as f32, matter, &mut numbers) {
                    Collision::Null(factor) => weight *= factor,
                    Collision::Scattered(factor, volume) => {
                        let flight = Flight {
                            scattered: Some(t as f32),
                            weight: weight * factor,
                        };
                        return (flight, volume);
                    }
                }
                if weight.max_element() <= 0.0 {
                    break;
                }
            }
            t = stretch.end;
        }
        let scattered = None;
        (Flight { scattered, weight }, 0)
    }

    /// The outcome of a tentative collision at distance `t`; `matter` is the importance of each channel to the path.
    fn collide(
        &self,
        ray: &Ray,
        t: f64,
        majorant: f32,
        matter: Rgb,
        numbers: &mut Numbers,
    ) -> Collision {
        let (mut sigma_t, mut scatters) = (Rgb::ZERO, 0.0);
        let worth = |sigma_s: Rgb| (sigma_s * matter).max_element();
        for (_, volume, chord) in self.around(ray, t) {
            let (t, s) = volume.coefficients(&chord, t);
            sigma_t += t;
            scatters += worth(s);
        }
        let null = (Rgb::splat(majorant) - sigma_t).max(Rgb::ZERO);
        let passes = worth(null);
        let mut u = numbers.next() * (scatters + passes);
        if u >= scatters || scatters == 0.0 {
            let probability = passes / (scatters + passes);
            // Nothing is left if nothing is transmitted.
            return Collision::Null(match probability > 0.0 {
                true => null / (majorant * probability),
                false => Rgb::ZERO,
            });
        }
        let mut chosen = Collision::Null(Rgb::ZERO);
        for (i, volume, chord) in self.around(ray, t) {
            let (_, sigma_s) = volume.coefficients(&chord, t);
            let worth = worth(sigma_s);
            if worth > 0.0 {
                let probability = worth / (scatters + passes);
                chosen = Collision::Scattered(sigma_s / (majorant * probability), i);
                if u < worth {
                    break;
                }
            }
            u -= worth;
        }
        chosen
    }
}

/// The outcome of a collision, with its weight.
enum Collision {
    Null(Rgb),
    Scattered(Rgb, usize),
}

#[cfg(test)]
mod tests;
