//! How large the image of a point is that is out of focus, to first order.

use super::camera_transform::CameraSpaceRay;

/// The cone of light that a camera sees at the middle of a pixel near its axis, and the width of a pixel, both linear in
/// camera-space z, in camera units: near the axis every lens is like that (Gaussian optics).
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Blur {
    /// The cone's radius at z = 0, signed, and its growth.
    pub radius: Line,
    /// The same of a pixel's width.
    pub pixel: Line,
}

/// A linear function of z: its value at 0, and its growth.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Line(pub f64, pub f64);

impl Line {
    #[inline(always)]
    fn at(self, z: f64) -> f64 {
        self.0 + self.1 * z
    }

    /// The x coordinate of a ray, times `scale`.
    pub(super) fn of_ray(ray: &CameraSpaceRay, scale: f64) -> Line {
        let slope = ray.d.x / ray.d.z;
        Line(scale * (ray.o.x - ray.o.z * slope), scale * slope)
    }
}

impl Blur {
    /// The same for a point of a film that is tilted. Its cone goes through a part of the flat film as wide as `spread` pixels for each half width of
    /// the pupil, and its pixels are seen through as `pixels` of the flat film.
    pub(super) fn tilted(&self, spread: f64, pixels: f64) -> Blur {
        let Line(at_0, growth) = self.pixel;
        Blur {
            radius: Line(
                self.radius.0 + spread * at_0,
                self.radius.1 + spread * growth,
            ),
            pixel: Line(pixels * at_0, pixels * growth),
        }
    }

    /// Returns `true` if all points are sharp.
    pub(super) fn is_none(&self) -> bool {
        (self.radius.0, self.radius.1) == (0.0, 0.0)
    }

    /// Diameter in pixels of the circle of confusion of a point at `z`; 0 where it has none.
    #[inline(always)]
    pub(super) fn diameter(&self, z: f64) -> f64 {
        let diameter = (2.0 * self.radius.at(z) / self.pixel.at(z)).abs();
        if diameter.is_finite() { diameter } else { 0.0 }
    }
}
