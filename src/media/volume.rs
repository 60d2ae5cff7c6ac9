//! `Volume "homogeneous" | "exponential" | "volumegrid"`: pbrt-v2's boxes of absorbing, scattering and emissive media.
//!
//! `sigma_a`, `sigma_s` (spectra, 0): absorption and scattering per world unit, for density 1. `Le` (spectrum, 0):
//! radiance emitted per world unit, for density 1. `g` (float, 0): mean cosine of the [phase function](super::phase).
//! `p0` (point, (0,0,0)), `p1` (point, (1,1,1)): corners of the box, under the current transformation. `homogeneous`:
//! density 1. `exponential`: a·exp(−b h), `a`, `b` (floats, 1), with h the height above `p0` along `updir` (vector,
//! (0,1,0)). `volumegrid`: `nx`, `ny`, `nz` (integer, 1) and nx·ny·nz values of `density` (floats, required), x varying
//! fastest, trilinear between the centers of its voxels and constant beyond the outermost ones.
//! Source: Pharr and Humphreys 2010, §11.3; docs/scene-language.md §A.1.

use super::boxes::{BoxSpace, Chord};
use super::density_grid::{self, DensityGrid};
use super::numbers::Numbers;
use super::{HenyeyGreenstein, common};
use crate::math::ray::Ray;
use crate::math::transform::Transform;
use crate::math::{DVec3, Rgb};
use crate::params::ParamReader;

/// The types that `Volume` may name.
pub const KINDS: [&str; 3] = ["exponential", "homogeneous", "volumegrid"];

/// Transmittance below which ratio tracking uses Russian roulette.
const ROULETTE_BELOW: f32 = 0.1;

/// Maximum of a coefficient or density: products stay finite in single precision.
const LARGEST: f64 = 1e15;

/// How the density varies over the unit cube that the box is mapped to.
#[derive(Clone, Debug, PartialEq)]
enum Density {
    Constant,
    /// `scale` · exp(−`falloff` · p).
    Exponential {
        scale: f64,
        falloff: DVec3,
    },
    Grid(DensityGrid),
}

impl Density {
    /// The largest in the box.
    fn largest(&self) -> f64 {
        match self {
            Density::Constant => 1.0,
            // At one of the corners.
            Density::Exponential { scale, falloff } => {
                scale * (-falloff.min(DVec3::ZERO).element_sum()).exp()
            }
            Density::Grid(grid) => f64::from(grid.largest()),
        }
    }
}

/// A volume as specified by `Volume`, in world space.
#[derive(Clone, Debug, PartialEq)]
pub struct VolumeSpec {
    sigma_a: Rgb,
    sigma_s: Rgb,
    emission: Rgb,
    /// The phase function.
    pub(super) phase: HenyeyGreenstein,
    density: Density,
    /// From the unit cube to world space.
    world_from_box: Transform,
}

impl VolumeSpec {
    /// Reads the parameters under the transformation `world_from_volume`. `None`, after reporting the reason, if they
    /// are unusable.
    pub fn from_params(reader: &ParamReader, world_from_volume: &Transform) -> Option<VolumeSpec> {
        if !KINDS.contains(&reader.kind()) {
            reader.unknown_kind_replaced(&KINDS, "the volume is left out");
            return None;
        }
        let [sigma_a, sigma_s, emission] = ["sigma_a", "sigma_s", "Le"].map(|name| {
            let used = usable(
                reader,
                name,
                reader.spectrum(name, Rgb::ZERO).to_array().map(f64::from),
            );
            Rgb::from_array(used.map(|v| v as f32))
        });
        let phase = common::phase(reader);
        let [p0, p1] = [("p0", DVec3::ZERO), ("p1", DVec3::ONE)].map(|(n, p)| reader.point3(n, p));
        let (low, size) = (p0.min(p1), (p1 - p0).abs());
        let world_from_box =
            *world_from_volume * Transform::translate(low) * Transform::scale(size);
        let density = match reader.kind() {
            "exponential" => exponential(reader, size),
            "volumegrid" => {
                let sigma_t = (sigma_a + sigma_s).max_element();
                let resolution = density_grid::resolution(reader);
                let grid = DensityGrid::from_params(reader, resolution, sigma_t, &world_from_box);
                Density::Grid(grid?)
            }
            _ => Density::Constant,
        };
        if !world_from_box.is_invertible() {
            reader.warn(
                "p1",
                "the volume's box has no volume: there is nothing in it",
            );
            return None;
        }
        Some(VolumeSpec {
            sigma_a,
            sigma_s,
            emission,
            phase,
            density,
            world_from_box,
        })
    }

    /// Returns `true` if it emits, given that its density is positive somewhere.
    pub fn shines(&self) -> bool {
        self.emission.max_element() > 0.0
    }
}

/// Values clamped to 0…[`LARGEST`], with a warning if one was outside.
fn usable<const N: usize>(reader: &ParamReader, name: &str, given: [f64; N]) -> [f64; N] {
    // NaN counts as 0.
    let used = given.map(|v| if v >= 0.0 { v.min(LARGEST) } else { 0.0 });
    if used != given {
        let message = format!("`{name}` is {given:?}, outside 0 to {LARGEST:e}: {used:?} is used");
        reader.warn(name, message);
    }
    used
}

/// The density of a box of this size.
fn exponential(reader: &ParamReader, size: DVec3) -> Density {
    let [scale] = usable(reader, "a", [reader.float("a", 1.0)]);
    let up = reader.vector3("updir", DVec3::Y);
    let up = up.try_normalize().unwrap_or_else(|| {
        reader.warn("updir", "`updir` has no direction: (0, 1, 0) is used");
        DVec3::Y
    });
    let falloff = reader.float("b", 1.0) * size * up;
    let density = Density::Exponential { scale, falloff };
    if density.largest() <= LARGEST {
        return density;
    }
    reader.warn(
        "b",
        format!(
            "the density rises above {LARGEST:e} in the box: it is the same everywhere instead"
        ),
    );
    Density::Constant
}

/// A box of matter in render space.
#[derive(Clone, Debug)]
pub struct Volume {
    pub(super) spec: VolumeSpec,
    sigma_t: Rgb,
    largest_density: f64,
    space: BoxSpace,
}

impl Volume {
    /// Places the volume in render space.
    pub fn new(spec: VolumeSpec, render_from_world: &Transform) -> Volume {
        let placed = (*render_from_world * spec.world_from_box).with_translations_matched();
        Volume {
            sigma_t: spec.sigma_a + spec.sigma_s,
            largest_density: spec.density.largest(),
            spec,
            space: BoxSpace::new(&placed),
        }
    }

    /// Returns `true` if anything in it emits.
    pub fn shines(&self) -> bool {
        self.spec.shines() && self.largest_density > 0.0
    }

    /// Upper bound of the extinction of every channel.
    pub(super) fn majorant(&self) -> f64 {
        f64::from(self.sigma_t.max_element()) * self.largest_density
    }

    /// The segment of the ray inside the box, before `t_max`.
    pub(super) fn chord(&self, ray: &Ray, t_max: f64) -> Option<Chord> {
        let chord = self.space.chord(ray, t_max);
        // Also `None` if a distance is not finite.
        chord.filter(|chord| chord.end.is_finite())
    }

    /// The density at distance `t` along a ray that is inside the box there.
    fn density(&self, chord: &Chord, t: f64) -> f64 {
        let p = chord.o + chord.d * t;
        match &self.spec.density {
            Density::Constant => 1.0,
            Density::Exponential { scale, falloff } => {
                // Rounding may leave the box.
                (scale * (-falloff.dot(p)).exp()).min(self.largest_density)
            }
            Density::Grid(grid) => f64::from(grid.extended_density(p.as_vec3())),
        }
    }

    /// Extinction and scattering coefficients at distance `t` in the box.
    pub(super) fn coefficients(&self, chord: &Chord, t: f64) -> (Rgb, Rgb) {
        let density = self.density(chord, t) as f32;
        (self.sigma_t * density, self.spec.sigma_s * density)
    }

    /// Radiance emitted per unit length at distance `t` in the box.
    pub(super) fn emission(&self, chord: &Chord, t: f64) -> Rgb {
        self.spec.emission * self.density(chord, t) as f32
    }

    /// The integral of the density from the start of the chord to `t`, if it has a closed form.
    fn column(&self, chord: &Chord, t: f64) -> Option<f64> {
        let length = t - chord.start;
        match &self.spec.density {
            Density::Constant => Some(length),
            Density::Exponential { scale, falloff } => {
                let first = scale * (-falloff.dot(chord.o + chord.d * chord.start)).exp();
                let rate = falloff.dot(chord.d);
                let x = rate * length;
                // (1 − exp(−x)) / x is 1 at 0.
                let mean = if x == 0.0 { 1.0 } else { -(-x).exp_m1() / x };
                Some(first * length * mean)
            }
            Density::Grid(_) => None,
        }
    }

    /// The transmittance up to the distance `t_max`; for grids an unbiased estimate by ratio tracking (Novák, Selle and
    /// Jarosz 2014) along the densest channel.
    pub(super) fn transmittance(&self, ray: &Ray, t_max: f64, numbers: &mut Numbers) -> Rgb {
        let majorant = self.majorant();
        let Some(chord) = self.chord(ray, t_max).filter(|_| majorant > 0.0) else {
            return Rgb::ONE;
        };
        if let Some(column) = self.column(&chord, chord.end) {
            return (-self.sigma_t * column as f32).exp();
        }
        let mut left = Rgb::ONE;
        let mut t = chord.start;
        loop {
            t += f64::from(numbers.step()) / majorant;
            // Also false for NaN.
            let inside = t < chord.end;
            if !inside {
                return left;
            }
            let (sigma_t, _) = self.coefficients(&chord, t);
            left *= (Rgb::ONE - sigma_t / majorant as f32).max(Rgb::ZERO);
            let most = left.max_element();
            if most < ROULETTE_BELOW {
                // Russian roulette: survives with probability `most` / 0.1, and then counts as 0.1.
                if numbers.next() * ROULETTE_BELOW >= most {
                    return Rgb::ZERO;
                }
                left *= ROULETTE_BELOW / most;
            }
        }
    }
}
