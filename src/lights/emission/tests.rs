//! The laws of emission, for every type of light under every kind of transformation: fluxes, densities, and that
//! light which leaves its source is the light that arrives elsewhere.

/// What is wrong with one case goes to the list of what is wrong with all.
macro_rules! check {
    ($failed:ident, $holds:expr, $($message:tt)+) => {
        let holds: bool = $holds;
        if !holds {
            $failed.push(format!($($message)+));
        }
    };
}

mod arrival;
mod cases;
mod density;
mod extremes;

use super::*;
use crate::handles::LightId;
use crate::lights::{
    EmissionGuide, EmitterChoice, Light, PointLight, PointSpec, RayNumbers, place_of_ray,
};
use crate::math::DVec3;
use crate::math::adaptive_density::{AdaptiveDensity, Found};
use crate::math::hash::{mix2, unit_float};
use crate::math::sampling::uniform_sphere;
use crate::math::transform::Transform;
use cases::*;

const SCENE: SceneSphere = SceneSphere {
    center: Vec3::new(0.1, -0.2, 0.3),
    radius: 6.0,
};

/// Two random numbers; `stream` tells the uses apart.
fn random(i: u64, stream: u64) -> Vec2 {
    let number = |k| unit_float(mix2(i, 2 * stream + k));
    Vec2::new(number(0), number(1))
}

/// A mean with its standard error.
#[derive(Default)]
struct Mean {
    n: f64,
    sum: f64,
    squares: f64,
}

impl Mean {
    fn add(&mut self, value: f64) {
        self.n += 1.0;
        self.sum += value;
        self.squares += value * value;
    }

    fn value(&self) -> f64 {
        self.sum / self.n
    }

    fn error(&self) -> f64 {
        let variance = self.squares / self.n - self.value() * self.value();
        (variance.max(0.0) / self.n).sqrt()
    }
}

fn total(rgb: Rgb) -> f64 {
    rgb.as_dvec3().element_sum()
}

fn reference(p: Vec3) -> ReferencePoint {
    ReferencePoint {
        p,
        ..Default::default()
    }
}
