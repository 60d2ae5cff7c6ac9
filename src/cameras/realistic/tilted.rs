//! A film that is tilted: `"float tilt"` [x y], degrees.
//!
//! It turns about its own middle, wherever `shift` puts that: by the first angle about its horizontal line, its upper edge away from the lens, then by
//! the second about the vertical through its middle, its right edge (seen from behind the camera) away from the lens. What is sharp is nearer at the
//! bottom of the image then, and at its left: the image on the film is upside down.
//!
//! Between the lens and the film light runs straight. So a ray of the tilted film is one of the flat film at `film_z`: that which goes
//! along the same line. It begins where that line meets the flat film, and everything that knows flat films knows it. Three things are
//! the tilted film's own: where its pixels are, the exit pupil that they see ([`TiltedPupil`]), and the cosine in
//! the weight.

use crate::math::{DMat4, DVec3};
use crate::optics::Lens;
use crate::optics::entrance::FilmWindow;
use crate::optics::pupil::{PupilSample, TiltedPupil};
use glam::DVec4;

/// Where a tilted film lies, in lens coordinates. Its points are named by the coordinates (mm) that they have when it is not tilted.
#[derive(Clone, Debug)]
pub(in super::super) struct TiltedFilm {
    middle: DVec3,
    /// Unit vectors along its rows, from left to right, and along its columns, upward; seen from behind.
    right: DVec3,
    up: DVec3,
    /// Toward the lens.
    normal: DVec3,
}

impl TiltedFilm {
    /// Tilted by these angles, degrees; `None` where both are 0. The film's middle lies at `middle` of the plane at `film_z`.
    pub(super) fn new(tilt: [f64; 2], middle: [f64; 2], film_z: f64) -> Option<TiltedFilm> {
        if tilt == [0.0; 2] {
            return None;
        }
        let [(sin, cos), (sin_y, cos_y)] = tilt.map(|degrees| degrees.to_radians().sin_cos());
        let swung =
            |v: DVec3| DVec3::new(cos_y * v.x - sin_y * v.z, v.y, sin_y * v.x + cos_y * v.z);
        let (right, up) = (swung(DVec3::X), swung(DVec3::new(0.0, cos, sin)));
        Some(TiltedFilm {
            middle: DVec3::new(middle[0], middle[1], film_z),
            right,
            up,
            normal: up.cross(right),
        })
    }

    /// Where the point `film` lies.
    pub(super) fn point(&self, film: [f64; 2]) -> DVec3 {
        let (x, y) = (film[0] - self.middle.x, film[1] - self.middle.y);
        self.middle + x * self.right + y * self.up
    }

    /// Where the line from its point `film` through `pupil` meets the flat film.
    pub(super) fn on_flat(&self, film: [f64; 2], pupil: [f64; 3]) -> [f64; 2] {
        let p = self.point(film);
        let k = (self.middle.z - p.z) / (pupil[2] - p.z);
        [p.x + k * (pupil[0] - p.x), p.y + k * (pupil[1] - p.y)]
    }

    /// The point where the line through `flat` of the flat film and `pupil` meets it.
    pub(super) fn from_flat(&self, flat: [f64; 2], pupil: [f64; 3]) -> [f64; 2] {
        let q = DVec3::from(pupil);
        let d = DVec3::new(flat[0], flat[1], self.middle.z) - q;
        let p = q + d * ((self.middle - q).dot(self.normal) / d.dot(self.normal)) - self.middle;
        [
            self.middle.x + p.dot(self.right),
            self.middle.y + p.dot(self.up),
        ]
    }

    /// Takes (X w, Y w, w, ·), with (X, Y) a point of the flat film, to (x v, y v, ·, v), with (x, y) from the film's middle along its rows and columns
    /// where the line through (0, 0, `pupil_z`) meets it.
    pub(in super::super) fn homography(&self, pupil_z: f64) -> DMat4 {
        let q = DVec3::new(0.0, 0.0, pupil_z);
        let from_middle = q - self.middle;
        // The line's direction is d = (X, Y, z) w: linear in what is given. The point is q + d (m − q)·n/(d·n).
        let toward_film = self.middle.z - pupil_z;
        let linear = |v: DVec3| DVec4::new(v.x, v.y, toward_film * v.z, 0.0);
        // Of such a length that v is w on the axis, as it is everywhere for a film that is not tilted.
        let normal = self.normal / (toward_film * self.normal.z);
        let height = -from_middle.dot(normal);
        let row = |axis: DVec3| linear(normal) * from_middle.dot(axis) + linear(axis) * height;
        let rows = [row(self.right), row(self.up), DVec4::Z, linear(normal)];
        DMat4::from_cols_array_2d(&rows.map(|row| row.to_array())).transpose()
    }

    /// Projected solid angle of `sample`'s area seen from `film`, sr, across the tilted film: A cosθ cosθ′/d². Not positive where the film
    /// turns its back on it.
    pub(super) fn projected_solid_angle(&self, film: [f64; 2], sample: &PupilSample) -> f64 {
        let d = DVec3::from(sample.point) - self.point(film);
        // Along the line toward the lens, also where the plane of the pupil lies behind the film.
        let toward = if d.z > 0.0 { -1.0 } else { 1.0 };
        let distance2 = d.length_squared();
        sample.area * d.z.abs() * (toward * d.dot(self.normal)) / (distance2 * distance2)
    }

    /// The corners of the film between two of its points.
    fn corners([low, high]: [[f64; 2]; 2]) -> [[f64; 2]; 4] {
        [low, [high[0], low[1]], high, [low[0], high[1]]]
    }

    /// z of the nearest and the farthest of the film's points between `ends`, and the farthest from the axis, mm.
    pub(super) fn extent(&self, ends: [[f64; 2]; 2]) -> ([f64; 2], f64) {
        let corners = Self::corners(ends).map(|corner| self.point(corner));
        let nearest = corners.iter().map(|p| p.z).fold(f64::INFINITY, f64::min);
        let farthest = corners.iter().map(|p| p.z).fold(0.0, f64::max);
        let reach = corners.iter().map(|p| p.x.hypot(p.y)).fold(0.0, f64::max);
        ([nearest, farthest], reach)
    }

    /// Around all that lines from the film between `ends` to the rear element meet of the flat film.
    pub(super) fn window_on_flat(&self, ends: [[f64; 2]; 2], lens: &Lens) -> FilmWindow {
        let rear = lens.rear();
        let radius = rear.clear_radius();
        let heights = [lens.length(), lens.length() + rear.sag(radius)];
        let mut window = FilmWindow {
            low: [f64::INFINITY; 2],
            high: [f64::NEG_INFINITY; 2],
        };
        // Seen from a point of the element the flat film's part is the image of a rectangle, so its corners' are the farthest; the
        // element's disks are those at its vertex and at its rim, between which they change one way.
        for p in Self::corners(ends).map(|corner| self.point(corner).to_array()) {
            for z in heights {
                let k = (self.middle.z - p[2]) / (z - p[2]);
                let (center, reach) = ([0, 1].map(|i| p[i] * (1.0 - k)), radius * k.abs());
                window.low = [0, 1].map(|i| window.low[i].min(center[i] - reach));
                window.high = [0, 1].map(|i| window.high[i].max(center[i] + reach));
            }
        }
        window
    }

    /// Of the film's plane z = z₀ + αx + βy: z₀, and α and β; `None` for one that holds the axis' direction.
    pub(super) fn on_axis(&self) -> Option<(f64, [f64; 2])> {
        let slopes = [self.normal.x, self.normal.y].map(|n| -n / self.normal.z);
        let z = self.middle.z - slopes[0] * self.middle.x - slopes[1] * self.middle.y;
        (z.is_finite()).then_some((z, slopes))
    }
}

/// See [`TiltedPupil::area_at`], for the film point named `film`.
pub(super) fn area_at(
    tilted: &TiltedFilm,
    pupil: &TiltedPupil,
    film: [f64; 2],
    point: [f64; 2],
) -> Option<f64> {
    pupil.area_at(tilted.point(film).to_array(), point)
}
