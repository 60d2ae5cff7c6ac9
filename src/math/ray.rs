//! Rays and their differentials.

use super::Vec3;

/// A ray in render space (or, inside an instance, in the object's space). `d` has unit length.
#[derive(Clone, Copy, Debug, Default)]
pub struct Ray {
    /// Origin.
    pub o: Vec3,
    /// Unit direction.
    pub d: Vec3,
    /// Hits at or beyond this distance are ignored.
    pub t_max: f32,
    /// Time within the shutter interval.
    pub time: f32,
}

impl Ray {
    /// An unbounded ray at time `time`.
    pub fn new(o: Vec3, d: Vec3, time: f32) -> Ray {
        Ray {
            o,
            d,
            t_max: f32::INFINITY,
            time,
        }
    }

    /// The point at distance `t`.
    pub fn at(&self, t: f32) -> Vec3 {
        self.o + self.d * t
    }
}

/// Ray differentials: the rays through the film points one sample spacing to the right (x) and below (y), which
/// determine the size of a texture footprint (Igehy 1999).
#[derive(Clone, Copy, Debug)]
pub struct RayDifferentials {
    /// Origin of the ray shifted in x.
    pub rx_o: Vec3,
    /// Direction of the ray shifted in x.
    pub rx_d: Vec3,
    /// Origin of the ray shifted in y.
    pub ry_o: Vec3,
    /// Direction of the ray shifted in y.
    pub ry_d: Vec3,
}

impl RayDifferentials {
    /// Scales the differentials by `s` toward `ray`: with n samples per pixel, s = 1/√n.
    pub fn scaled(self, ray: &Ray, s: f32) -> RayDifferentials {
        RayDifferentials {
            rx_o: ray.o + (self.rx_o - ray.o) * s,
            rx_d: ray.d + (self.rx_d - ray.d) * s,
            ry_o: ray.o + (self.ry_o - ray.o) * s,
            ry_d: ray.d + (self.ry_d - ray.d) * s,
        }
    }
}
