//! The measured shape of the pupil, for a model that knows no rims.

use crate::math::DVec2;
use crate::optics::lens::Lens;
use crate::optics::pupil::boundary;
use crate::optics::real::{Index, Mask, Plain};

/// For each film radius, how far from its middle the pupil reaches in every direction, on the plane that
/// rays are aimed at. Between the measured film radii and directions it is interpolated linearly.
#[derive(Clone, Debug)]
pub struct PupilShape<B> {
    /// Film radii per mm.
    radii_per_mm: B,
    /// Middle of the pupil (distance from the axis toward the film point, mm) at each film radius.
    middle: Vec<B>,
    /// Squared reach, mm²: [`DIRECTIONS`] + 1 for each film radius, by [`quadrant`].
    reach2: Vec<B>,
}

/// Film radii between the axis and the largest.
const RADII: usize = 64;

/// Directions over half a turn; the other half is its mirror image. An arc between two differs from
/// its chord by π²/8·96² = 0.013 % of the radius.
const DIRECTIONS: usize = 96;

/// A measure of the direction (x, y), y ≥ 0, that grows from 0 along x to 2 along −x as the angle
/// does, without a transcendental function: 1 − x/(|x| + |y|).
fn quadrant(x: f64, y: f64) -> f64 {
    1.0 - x / (x.abs() + y.abs())
}

impl PupilShape<f64> {
    /// Measures the pupil of `lens` on the plane at `plane_z`, for film points up to `film_radius` mm.
    pub fn measure(lens: &Lens, film_radius: f64, plane_z: f64) -> PupilShape<f64> {
        let mut shape = PupilShape {
            radii_per_mm: RADII as f64 / film_radius,
            middle: Vec::with_capacity(RADII + 1),
            reach2: Vec::with_capacity((RADII + 1) * (DIRECTIONS + 1)),
        };
        for i in 0..=RADII {
            let outline = boundary(lens, i as f64 / RADII as f64 * film_radius, plane_z);
            shape.push(&outline);
        }
        shape
    }

    /// Adds a film radius with this outline: points from the direction x to −x.
    fn push(&mut self, outline: &[[f64; 2]]) {
        let Some((first, last)) = outline.first().zip(outline.last()) else {
            // Dark: the middle of the last lit one, and no reach.
            self.middle.push(self.middle.last().copied().unwrap_or(0.0));
            self.reach2.extend([0.0; DIRECTIONS + 1]);
            return;
        };
        let middle = 0.5 * (first[0] + last[0]);
        self.middle.push(middle);
        let points: Vec<DVec2> = outline
            .iter()
            .map(|p| DVec2::new(p[0] - middle, p[1]))
            .collect();
        let mut edge = 0;
        for k in 0..=DIRECTIONS {
            let q = 2.0 * k as f64 / DIRECTIONS as f64;
            while edge + 2 < points.len() && quadrant(points[edge + 1].x, points[edge + 1].y) < q {
                edge += 1;
            }
            let next = (edge + 1).min(points.len() - 1);
            self.reach2.push(reach2(q, points[edge], points[next]));
        }
    }

    /// In another precision.
    pub fn rounded<B: Plain>(&self) -> PupilShape<B> {
        let all = |values: &[f64]| values.iter().map(|x| B::round_from(*x)).collect();
        PupilShape {
            radii_per_mm: B::round_from(self.radii_per_mm),
            middle: all(&self.middle),
            reach2: all(&self.reach2),
        }
    }
}

/// Where the ray from the origin in direction `q` meets the line through `a` and `b`: squared distance.
fn reach2(q: f64, a: DVec2, b: DVec2) -> f64 {
    // On the unit diamond.
    let d = if q <= 1.0 {
        DVec2::new(1.0 - q, q)
    } else {
        DVec2::new(1.0 - q, 2.0 - q)
    };
    let along = b - a;
    let t = a.perp_dot(along) / d.perp_dot(along);
    let found = t * t * d.length_squared();
    // A line toward the origin is met nowhere or everywhere; its ends are as good.
    if found.is_finite() && found <= 4.0 * a.length_squared().max(b.length_squared()) {
        found
    } else {
        a.length_squared().max(b.length_squared())
    }
}

impl<B: Plain> PupilShape<B> {
    /// Is the pupil point inside, for this film point?
    #[inline(always)]
    pub fn holds<T: Index<Base = B>>(&self, film: &[T; 2], pupil: &[T; 2]) -> T::Mask {
        let radius = (film[0] * film[0] + film[1] * film[1]).sqrt();
        let inside_film = radius
            .times(self.radii_per_mm)
            .at_most(B::round_from(RADII as f64));
        let (ring, t) = radius.times(self.radii_per_mm).place(RADII - 1);
        let (at, next) = (
            T::look_up(&self.middle, [(ring, 1)], 0),
            T::look_up(&self.middle, [(ring, 1)], 1),
        );
        let middle = at + t * (next - at);
        // Along and across the film point's azimuth; at the very middle of the film the pupil is round and
        // any will do.
        let tiny = B::round_from(1e-6);
        let (fx, fy) = (film[0].plus(tiny), film[1]);
        let azimuth = (fx * fx + fy * fy).sqrt();
        let (cos, sin) = (fx / azimuth, fy / azimuth);
        let x = pupil[0] * cos + pupil[1] * sin - middle;
        let y = pupil[1] * cos - pupil[0] * sin;
        let distance2 = x * x + y * y;
        // The mirror image has y < 0. √(y²) is |y|.
        let (ax, ay) = ((x * x).sqrt(), (y * y).sqrt());
        // In the very middle x/(|x| + |y|) is 0/0.
        let around = (ax + ay).plus(B::round_from(1e-30));
        let one = T::constant(B::ONE);
        let half = B::round_from(0.5 * DIRECTIONS as f64);
        let (direction, s) = (one - x / around).times(half).place(DIRECTIONS - 1);
        let reach2 = {
            let stride = DIRECTIONS + 1;
            let corner = |i: usize, k: usize| {
                let at = [(ring, stride), (direction, 1)];
                T::look_up(&self.reach2, at, i * stride + k)
            };
            let (a, b) = (corner(0, 0), corner(0, 1));
            let (c, d) = (corner(1, 0), corner(1, 1));
            let (inner, outer) = (a + s * (b - a), c + s * (d - c));
            inner + t * (outer - inner)
        };
        let lit = reach2.greater(B::ZERO);
        (distance2 - reach2)
            .at_most(B::ZERO)
            .and(lit)
            .and(inside_film)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::optics::Prescription;

    /// Two holes in a wall and nothing else: the pupil is the overlap of two disks.
    fn holes() -> Lens {
        let text = "0 10 0 8\n0 10 0 10\n0 0 0 60\n";
        Lens::new(&Prescription::parse(text).unwrap(), 30.0).unwrap()
    }

    #[test]
    fn the_shape_is_the_overlap_of_the_rims() {
        let lens = holes();
        // Aimed at the middle hole, 40 mm from the film; the first is 50 mm from it and seen from there
        // 4/5 as large, shifted by a fifth of the film point.
        let shape = PupilShape::measure(&lens, 20.0, 10.0);
        let single = shape.rounded::<f32>();
        let (mut inside, mut wrong) = (0, 0);
        for i in 0..20_000 {
            let r = |k: i32| (0.5 + f64::from(i) / 1.167_303_978_261_418_7f64.powi(k)).fract();
            let (radius, angle) = (20.0 * r(1), 6.0 * r(2));
            let film = [radius * angle.cos(), radius * angle.sin()];
            let p = [12.0 * r(3) - 6.0, 12.0 * r(4) - 6.0];
            let away = |c: [f64; 2]| (p[0] - c[0]).hypot(p[1] - c[1]);
            let truth = away([0.0; 2]) <= 5.0 && away(film.map(|x| 0.2 * x)) <= 3.2;
            inside += i32::from(truth);
            wrong += i32::from(truth != shape.holds(&film, &p));
            let same = single.holds(&film.map(|x| x as f32), &p.map(|x| x as f32));
            wrong += i32::from(truth != same);
        }
        // Corners between measured directions are cut: a thousandth of the outcomes, in either
        // precision.
        assert!(
            inside > 2000 && wrong < 2 * inside / 500,
            "{wrong} of {inside}"
        );
    }

    #[test]
    fn what_is_no_point_is_outside() {
        let shape = PupilShape::measure(&holes(), 20.0, 10.0);
        assert!(shape.holds(&[0.0f64, 0.0], &[0.0, 0.0]));
        for bad in [f64::NAN, f64::INFINITY, 1e300] {
            assert!(!shape.holds(&[bad, 0.0], &[0.0, 0.0]));
            assert!(!shape.holds(&[0.0, 0.0], &[0.0, bad]));
        }
        // Beyond the film that was measured.
        assert!(!shape.holds(&[20.1f64, 0.0], &[2.0, 0.0]));
        // Where it is dark: beyond 41 mm the holes no longer overlap.
        let shape = PupilShape::measure(&holes(), 60.0, 10.0);
        assert!(!shape.holds(&[50.0f64, 0.0], &[5.0, 0.0]));
    }
}
