//! Animated transformations: `ActiveTransform` and `TransformTimes`.
//!
//! Each end is decomposed into a translation, a rotation and a stretch, M = T R S, by polar decomposition; translation
//! and stretch are interpolated linearly, the rotation at constant speed about one axis, the shorter way round
//! (Shoemake and Duff, "Matrix Animation and Polar Decomposition", 1992; Pharr, Jakob and Humphreys 2016, §2.9). Before
//! the first and after the last time the ends apply (docs/scene-language.md §2.2). Reflections, which pbrt-v3 does not
//! handle, are part of the stretch.

use super::transform::{Transform, box_around, box_corners, largest_entry};
use super::{DMat4, DVec3};
use glam::{DAffine3, DMat3, DQuat};

/// Maximum iterations of the polar decomposition; each squares the error, so a dozen suffice for any matrix that is
/// invertible in double precision.
const POLAR_ROUNDS: usize = 100;

/// Steps by which the path of a rotating point is bounded. The margin is below (π/64)²/8 = 3e-4 of its distance from
/// the axis.
const TURNING_STEPS: usize = 64;

/// T, R and S of one matrix.
#[derive(Clone, Copy, Debug)]
struct Parts {
    translation: DVec3,
    rotation: DQuat,
    stretch: DMat3,
}

impl Parts {
    /// `None` unless the matrix is affine and invertible.
    fn of(m: &DMat4) -> Option<Parts> {
        let linear = DMat3::from_mat4(*m);
        let affine = m.row(3) == DVec3::ZERO.extend(1.0);
        if !affine || !m.is_finite() || !linear.inverse().is_finite() {
            return None;
        }
        let mut rotation = linear;
        for _ in 0..POLAR_ROUNDS {
            let next = (rotation + rotation.inverse().transpose()) * 0.5;
            let change = next - rotation;
            rotation = next;
            // Entries of a rotation are at most 1.
            if largest_entry(&change) <= 4.0 * f64::EPSILON {
                break;
            }
        }
        // A reflection goes to the stretch: quaternions cannot represent it.
        if rotation.determinant() < 0.0 {
            rotation = -rotation;
        }
        let stretch = rotation.transpose() * linear;
        let parts = Parts {
            translation: m.w_axis.truncate(),
            rotation: DQuat::from_mat3(&rotation).normalize(),
            stretch,
        };
        (parts.rotation.is_finite() && stretch.is_finite()).then_some(parts)
    }
}

/// A transformation that is interpolated between two times.
#[derive(Clone, Copy, Debug)]
pub struct Motion {
    times: [f64; 2],
    translation: [DVec3; 2],
    /// Rotation at the start.
    rotation: DQuat,
    /// The axis of rotation, unit length.
    axis: DVec3,
    /// The angle of rotation from start to end, in radians, 0 to π.
    angle: f64,
    stretch: [DMat3; 2],
}

impl Motion {
    /// The motion from `start` at the first of `times` to `end` at the second. `None` if an end is not invertible or
    /// not affine.
    pub fn new(start: &Transform, end: &Transform, times: [f64; 2]) -> Option<Motion> {
        let (a, b) = (Parts::of(&start.m)?, Parts::of(&end.m)?);
        let turn = b.rotation * a.rotation.conjugate();
        // The shorter way round.
        let turn = if turn.w < 0.0 { -turn } else { turn };
        let sine = turn.xyz().length();
        Some(Motion {
            times,
            translation: [a.translation, b.translation],
            rotation: a.rotation,
            axis: turn.xyz().try_normalize().unwrap_or(DVec3::Z),
            angle: 2.0 * sine.atan2(turn.w),
            stretch: [a.stretch, b.stretch],
        })
    }

    /// The same motion followed by a translation by `offset`.
    pub fn shifted(mut self, offset: DVec3) -> Motion {
        self.translation = self.translation.map(|t| t + offset);
        self
    }

    /// The fraction of the motion that is completed at `time`.
    fn fraction(&self, time: f64) -> f64 {
        let [first, last] = self.times;
        if time <= first {
            0.0
        } else if time >= last {
            1.0
        } else {
            (time - first) / (last - first)
        }
    }

    fn rotation_at(&self, s: f64) -> DQuat {
        DQuat::from_axis_angle(self.axis, self.angle * s) * self.rotation
    }

    /// The position of the point `p` after the fraction `s` of the motion.
    fn point(&self, p: DVec3, s: f64) -> DVec3 {
        let [t0, t1] = self.translation;
        let stretched = (self.stretch[0] * p).lerp(self.stretch[1] * p, s);
        t0.lerp(t1, s) + self.rotation_at(s) * stretched
    }

    /// The transformation at `time`.
    pub fn at(&self, time: f64) -> DAffine3 {
        let s = self.fraction(time);
        let stretch = self.stretch[0] * (1.0 - s) + self.stretch[1] * s;
        DAffine3 {
            matrix3: DMat3::from_quat(self.rotation_at(s)) * stretch,
            translation: self.translation[0].lerp(self.translation[1], s),
        }
    }

    /// Corners of a box that contains the box from `low` to `high` at all times.
    ///
    /// At any time the box's image is the convex hull of its corners' images, so it suffices to bound the corners'
    /// paths. A corner p is at c(s) = T(s) + R(s) q(s) with T and q = S p linear in s and R rotating at constant speed
    /// by the angle θ, hence |c″| ≤ θ² |q| + 2 θ |q′|, and |q| is largest at an end. Between two of its points that are
    /// h apart in s, a curve is no farther than h²/8 · max|c″| from the chord; so the points' box, widened by that,
    /// contains it.
    pub fn bounds(&self, low: DVec3, high: DVec3) -> (DVec3, DVec3) {
        let steps = if self.angle > 0.0 { TURNING_STEPS } else { 1 };
        box_around(box_corners(low, high).into_iter().flat_map(|corner| {
            let ends = self.stretch.map(|s| s * corner);
            let reach = ends[0].length().max(ends[1].length());
            let bend = self.angle * (self.angle * reach + 2.0 * ends[0].distance(ends[1]));
            let step = 1.0 / steps as f64;
            let margin = DVec3::splat(step * step / 8.0 * bend);
            (0..=steps).flat_map(move |j| {
                let p = self.point(corner, j as f64 * step);
                [p - margin, p + margin]
            })
        }))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn turn(degrees: f64) -> Transform {
        Transform::rotate(degrees, DVec3::new(1.0, 2.0, -0.5))
    }

    fn ends() -> Vec<(Transform, Transform)> {
        let shift = Transform::translate(DVec3::new(3.0, -1.0, 2.0));
        let uneven = Transform::scale(DVec3::new(1.3, 0.8, 2.0));
        let mirror = Transform::scale(DVec3::new(-1.0, 1.0, 1.0));
        vec![
            (Transform::IDENTITY, shift),
            (turn(10.0), shift * turn(170.0)),
            (
                uneven * turn(30.0),
                turn(-100.0) * uneven * turn(12.0) * shift,
            ),
            (mirror * turn(5.0), shift * mirror * turn(95.0)),
            (turn(20.0), turn(20.0)),
            (turn(0.0), turn(180.0)),
        ]
    }

    fn close(a: &DAffine3, b: &DMat4) -> bool {
        a.abs_diff_eq(DAffine3::from_mat4(*b), 1e-12)
    }

    #[test]
    fn the_ends_are_the_matrices_and_hold_outside() {
        for (start, end) in ends() {
            let motion = Motion::new(&start, &end, [1.0, 3.0]).unwrap();
            assert!(close(&motion.at(1.0), &start.m) && close(&motion.at(-5.0), &start.m));
            assert!(close(&motion.at(3.0), &end.m) && close(&motion.at(9.0), &end.m));
        }
    }

    #[test]
    fn halfway_is_half_the_way_and_half_the_turn() {
        let end = Transform::translate(DVec3::new(4.0, 0.0, 0.0))
            * Transform::rotate(90.0, DVec3::Z)
            * Transform::scale(DVec3::new(3.0, 1.0, 1.0));
        let motion = Motion::new(&Transform::IDENTITY, &end, [0.0, 1.0]).unwrap();
        let half = Transform::translate(DVec3::new(2.0, 0.0, 0.0))
            * Transform::rotate(45.0, DVec3::Z)
            * Transform::scale(DVec3::new(2.0, 1.0, 1.0));
        assert!(close(&motion.at(0.5), &half.m));
        // 270° one way is 90° the other way.
        let far = Transform::rotate(270.0, DVec3::Z);
        let motion = Motion::new(&Transform::IDENTITY, &far, [0.0, 1.0]).unwrap();
        assert!(close(
            &motion.at(0.5),
            &Transform::rotate(-45.0, DVec3::Z).m
        ));
    }

    #[test]
    fn mirrors_stay_mirrors_on_the_way() {
        let mirror = Transform::scale(DVec3::new(1.0, -1.0, 1.0));
        let (a, b) = (mirror * turn(10.0), turn(70.0) * mirror);
        let motion = Motion::new(&a, &b, [0.0, 1.0]).unwrap();
        for i in 0..=10 {
            let m = motion.at(f64::from(i) / 10.0).matrix3;
            assert!((m.determinant() + 1.0).abs() < 1e-12);
        }
    }

    #[test]
    fn times_without_length_are_a_step() {
        let end = Transform::translate(DVec3::X);
        let motion = Motion::new(&Transform::IDENTITY, &end, [1.0, 1.0]).unwrap();
        assert!(close(&motion.at(1.0), &DMat4::IDENTITY));
        assert!(close(&motion.at(1.0 + 1e-9), &end.m));
    }

    #[test]
    fn what_is_flat_or_no_number_does_not_move() {
        let flat = Transform::scale(DVec3::new(1.0, 0.0, 1.0));
        assert!(Motion::new(&Transform::IDENTITY, &flat, [0.0, 1.0]).is_none());
        let none = Transform::scale(DVec3::NAN);
        assert!(Motion::new(&none, &Transform::IDENTITY, [0.0, 1.0]).is_none());
        let mut projective = DMat4::IDENTITY;
        projective.z_axis.w = 0.5;
        let projective = Transform::from_matrix(projective);
        assert!(Motion::new(&projective, &Transform::IDENTITY, [0.0, 1.0]).is_none());
    }

    #[test]
    fn bounds_hold_everything_at_all_times_and_little_more() {
        let (low, high) = (DVec3::new(-1.0, -0.2, 0.5), DVec3::new(2.0, 0.3, 1.0));
        for (start, end) in ends() {
            let motion = Motion::new(&start, &end, [0.0, 1.0]).unwrap();
            let (min, max) = motion.bounds(low, high);
            let (mut seen_min, mut seen_max) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
            for i in 0..=1000 {
                let m = motion.at(f64::from(i) / 1000.0);
                for j in 0..27 {
                    let f = DVec3::new((j % 3) as f64, (j / 3 % 3) as f64, (j / 9) as f64) / 2.0;
                    let p = m.transform_point3(low + f * (high - low));
                    assert!(p.cmpge(min - 1e-12).all() && p.cmple(max + 1e-12).all());
                    (seen_min, seen_max) = (seen_min.min(p), seen_max.max(p));
                }
            }
            // Twice the margin that the constant above guarantees, for the size of this box.
            let slack = (max - seen_max).max(seen_min - min).max_element();
            assert!(slack < 2.0 * 3e-4 * 8.0, "{slack}");
        }
    }
}
