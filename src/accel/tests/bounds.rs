//! Error boxes and normals of hits on triangles, against arithmetic of 106 bits.

use super::*;
use crate::math::motion::Motion;
use glam::DAffine3;
use std::ops::{Add, Mul, Sub};

/// A number as a sum of two (Dekker 1971).
#[derive(Clone, Copy)]
struct Double(f64, f64);

impl Add for Double {
    type Output = Double;
    fn add(self, b: Double) -> Double {
        let sum = self.0 + b.0;
        let part = sum - self.0;
        let rest = (self.0 - (sum - part)) + (b.0 - part) + self.1 + b.1;
        let high = sum + rest;
        Double(high, rest - (high - sum))
    }
}

impl Sub for Double {
    type Output = Double;
    fn sub(self, b: Double) -> Double {
        self + Double(-b.0, -b.1)
    }
}

impl Mul for Double {
    type Output = Double;
    fn mul(self, b: Double) -> Double {
        let product = self.0 * b.0;
        let rest = self.0.mul_add(b.0, -product) + (self.0 * b.1 + self.1 * b.0);
        Double(product, 0.0) + Double(rest, 0.0)
    }
}

type Point = [Double; 3];

fn exact(p: DVec3) -> Point {
    p.to_array().map(|x| Double(x, 0.0))
}

fn minus(a: Point, b: Point) -> Point {
    [0, 1, 2].map(|i| a[i] - b[i])
}

fn dot(a: Point, b: Point) -> Double {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn cross(a: Point, b: Point) -> Point {
    [(1, 2), (2, 0), (0, 1)].map(|(i, j)| a[i] * b[j] - a[j] * b[i])
}

fn rounded(a: Point) -> DVec3 {
    DVec3::from_array(a.map(|x| x.0))
}

fn moved(affine: &DAffine3, p: DVec3) -> Point {
    let rows = affine.matrix3.transpose();
    [0, 1, 2].map(|i| dot(exact(rows.col(i)), exact(p)) + Double(affine.translation[i], 0.0))
}

/// The three numbers that a law compares with what a hit says.
struct Truth {
    corners: [Point; 3],
    /// Not of unit length.
    normal: Point,
}

impl Truth {
    fn new(corners: [Point; 3]) -> Truth {
        let [a, b, c] = corners;
        let normal = cross(minus(b, a), minus(c, a));
        Truth { corners, normal }
    }

    /// Signed distance from the plane.
    fn height(&self, p: Vec3) -> f64 {
        let off = minus(exact(p.as_dvec3()), self.corners[0]);
        dot(self.normal, off).0 / rounded(self.normal).length()
    }

    /// The box around a hit point reaches the plane and not much farther, the normal is right but for its rounding, and
    /// rays that leave start on their side of the plane.
    fn check(&self, ray: &Ray, hit: &GeometryHit, random: &mut Random) {
        let s = &hit.surface;
        let n = rounded(self.normal).normalize();
        let reach = n.abs().dot(s.p_error.as_dvec3());
        let height = self.height(s.p);
        // The millionth is for the f64 in which the two are compared.
        assert!(
            height.abs() <= reach * (1.0 + 1e-6),
            "{height} {reach} {s:?}"
        );
        // Three coordinates of at most 1, rounded to half an ulp (6e-8) each, and what double precision leaves.
        let tilt = s.n.as_dvec3().cross(n).length();
        assert!(tilt < 1.2e-7, "{tilt} {s:?}");
        let largest = f64::from(s.p.abs().max_element());
        let far = self.corners.map(|p| rounded(p).abs().max_element());
        let far = far.into_iter().fold(largest, f64::max)
            + f64::from(ray.o.abs().max_element())
            + f64::from(hit.t);
        // Two ulp, and a hundred roundings of double precision of everything on the way; an instance adds two ulp of the
        // object, which is as large as `far` at most.
        let instance = 8.0 * f64::from(f32::EPSILON) * self.size();
        let bound = 2.0 * f64::from(f32::EPSILON) * largest + 1e3 * f64::EPSILON * far + instance;
        assert!(f64::from(s.p_error.max_element()) < bound, "{s:?}");
        for _ in 0..4 {
            let d = random.direction();
            let side = d.dot(s.n);
            // Directions in the plane but for its rounding have no side.
            if side.abs() > 1e-6 {
                let start = self.height(s.spawn_ray(d).o);
                assert!(start * f64::from(side) > 0.0, "{start} {side} {s:?}");
            }
        }
    }

    /// The longest edge.
    fn size(&self) -> f64 {
        let [a, b, c] = self.corners;
        [(a, b), (b, c), (c, a)]
            .map(|(p, q)| rounded(minus(p, q)).length())
            .into_iter()
            .fold(0.0, f64::max)
    }
}

/// A ray to a random point of a triangle, from a thousandth to a thousand times its size away.
fn ray_to(corners: [DVec3; 3], size: f64, random: &mut Random) -> Ray {
    let (a, b) = (f64::from(random.next()), f64::from(random.next()));
    let (a, b) = if a + b > 1.0 {
        (1.0 - a, 1.0 - b)
    } else {
        (a, b)
    };
    let target = corners[0] * (1.0 - a - b) + corners[1] * a + corners[2] * b;
    let distance = size * 10f64.powf(f64::from(random.next()) * 6.0 - 3.0);
    let o = (target + random.direction().as_dvec3() * distance).as_vec3();
    let d = (target - o.as_dvec3()).normalize().as_vec3();
    Ray::new(o, d, random.next())
}

/// Corners around the origin; every other triangle is a sliver, of widths down to a millionth of its length.
fn corners(i: usize, random: &mut Random) -> [DVec3; 3] {
    let [a, b, c] = [0; 3].map(|_| random.cube().as_dvec3());
    if i.is_multiple_of(2) {
        return [a, b, c];
    }
    let along = a.lerp(b, f64::from(random.next()));
    [
        a,
        b,
        along.lerp(c, 10f64.powf(-6.0 * f64::from(random.next()))),
    ]
}

fn one_triangle(corners: [DVec3; 3]) -> CompiledShape {
    compiled(
        &mesh(corners.to_vec(), vec![[0, 1, 2]]),
        &Transform::IDENTITY,
    )
}

#[test]
fn boxes_of_triangles_hold_the_plane_at_every_size_and_place() {
    let mut random = Random(31);
    let mut hits = 0;
    for i in 0..4000 {
        let size = 10f64.powf(f64::from(random.next()) * 12.0 - 6.0);
        let away = random.direction().as_dvec3() * [0.0, 10.0, 1e4][i % 3];
        let corners = corners(i, &mut random);
        // The tree's own corners.
        let corners = corners.map(|p| ((p + away) * size).as_vec3().as_dvec3());
        let truth = Truth::new(corners.map(exact));
        // What rounding has bent to a line is no triangle.
        let has_area = rounded(truth.normal).length() > 1e-9 * truth.size() * truth.size();
        if !has_area {
            continue;
        }
        let mut geometry = scene(vec![one_triangle(corners)]);
        for bare in [false, true] {
            geometry.set_bare(bare);
            for _ in 0..8 {
                let ray = ray_to(corners, size, &mut random);
                if let Some(hit) = geometry.intersect(&ray, &opaque) {
                    truth.check(&ray, &hit, &mut random);
                    hits += 1;
                }
            }
        }
    }
    assert!(hits > 30_000, "{hits}");
}

/// Objects of whole numbers, which are stored exactly, so that the truth is known in render space.
#[test]
fn boxes_of_instances_and_of_what_moves_hold_the_plane() {
    let mut random = Random(32);
    let mut hits = 0;
    for i in 0..1500 {
        let corners = corners(i, &mut random).map(|p| (p * 4096.0).round());
        let size = 10f64.powf(f64::from(random.next()) * 8.0 - 4.0) / 4096.0;
        let away = random.direction().as_dvec3() * 4096.0 * [0.0, 10.0, 1e3][i % 3];
        let place = |random: &mut Random| {
            let turn = Transform::rotate(
                360.0 * f64::from(random.next()),
                random.direction().as_dvec3(),
            );
            let stretch = DVec3::splat(1.0) + random.cube().as_dvec3() * 0.5;
            Transform::scale(DVec3::splat(size))
                * Transform::translate(away)
                * turn
                * Transform::scale(stretch)
        };
        let (start, end) = (place(&mut random), place(&mut random));
        let Some(motion) = Motion::new(&start, &end, [0.0, 1.0]) else {
            continue;
        };
        let mut moving = GeometryBuilder::default();
        moving.add_moving(
            one_triangle(corners),
            PrimitiveAttributes::default(),
            motion,
        );
        let at_rest = instanced(vec![one_triangle(corners)], &start);
        for (mut geometry, motion) in [
            (at_rest, None),
            (moving.build(vec![]).unwrap(), Some(motion)),
        ] {
            geometry.set_bare(i % 4 < 2);
            for _ in 0..8 {
                let time = random.next();
                let affine = motion.map_or(DAffine3::from_mat4(start.m), |m| m.at(f64::from(time)));
                let truth = Truth::new(corners.map(|p| moved(&affine, p)));
                let placed = truth.corners.map(rounded);
                let ray = Ray {
                    time,
                    ..ray_to(placed, truth.size(), &mut random)
                };
                if let Some(hit) = geometry.intersect(&ray, &opaque) {
                    truth.check(&ray, &hit, &mut random);
                    hits += 1;
                }
            }
        }
    }
    assert!(hits > 10_000, "{hits}");
}
