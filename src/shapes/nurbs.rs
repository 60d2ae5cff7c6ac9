//! `Shape "nurbs"`: a non-uniform rational B-spline surface, as a fixed grid of triangles.
//!
//! | parameter | default | meaning |
//! |---|---|---|
//! | `integer nu`, `nv` | required | control points in u and in v |
//! | `integer uorder`, `vorder` | required | degree + 1 of the splines, from 2 to the number of points |
//! | `float uknots`, `vknots` | required | nu + uorder and nv + vorder knots, ascending |
//! | `point3 P`, or else `float Pw` | required | nu · nv control points, u fastest; Pw has four numbers each, x y z already times the weight |
//! | `float u0`, `u1`, `v0`, `v1` | knots order − 1 and n | the part that is made |
//!
//! As in pbrt-v3 always 30 × 30 points with exact normals; (u, v) are the knots' own parameters; the
//! normal is along ∂p/∂u × ∂p/∂v (docs/scene-language.md §3.7; Piegl and Tiller, "The NURBS Book", 1997, §4;
//! Rogers, "An Introduction to NURBS", 2001).

use super::site::{ShapeType, Site};
use super::{CompiledShape, ShapeError, grid, left_out, needed, triples};
use crate::assets::mesh::MeshData;
use crate::math::{DVec3, Vec2};
use crate::params::ParamReader;
use glam::DVec4;

/// Points in u and in v of the mesh.
const DICED: u32 = 30;

/// One direction of the surface.
#[derive(Clone, Debug, PartialEq)]
struct Direction {
    /// Degree + 1, at least 2.
    order: usize,
    /// Control points, at least `order`.
    count: usize,
    /// `count + order` of them, ascending.
    knots: Vec<f64>,
    /// The part that is made, within the knots `order − 1` and `count`.
    range: [f64; 2],
}

/// See the module.
#[derive(Clone, Debug, PartialEq)]
pub struct NurbsSpec {
    u: Direction,
    v: Direction,
    /// Control points times weight, with the weight, u fastest.
    points: Vec<DVec4>,
}

/// A point of a spline, times its weight and with it, and the derivative.
struct Jet {
    value: DVec4,
    derivative: DVec4,
}

impl NurbsSpec {
    /// Reads the parameters; `None` where something is missing or does not fit (reported).
    pub fn from_params(reader: &ParamReader) -> Option<NurbsSpec> {
        let u = Direction::from_params(reader, "u");
        let v = Direction::from_params(reader, "v");
        let points = control_points(reader);
        let (u, v, points) = (u?, v?, points?);
        if u.count.checked_mul(v.count) != Some(points.len()) {
            let name = if reader.has("P") { "P" } else { "Pw" };
            let (given, u, v) = (points.len(), u.count, v.count);
            return left_out(
                reader,
                name,
                format_args!("{given} control points for {u} × {v}"),
            );
        }
        Some(NurbsSpec { u, v, points })
    }

    /// The mesh.
    pub fn mesh(&self) -> MeshData {
        let mut mesh = MeshData {
            indices: grid::triangles(DICED, DICED),
            ..MeshData::default()
        };
        for v in self.v.diced() {
            for u in self.u.diced() {
                let [p, dpdu, dpdv] = self.at(u, v);
                mesh.positions.push(p);
                let n = dpdu.normalize_or_zero().cross(dpdv.normalize_or_zero());
                mesh.normals.push(n.normalize_or_zero().as_vec3());
                mesh.uv.push(Vec2::new(u as f32, v as f32));
            }
        }
        mesh
    }

    /// The point with its derivatives by u and by v.
    fn at(&self, u: f64, v: f64) -> [DVec3; 3] {
        let row = |j: usize| self.u.spline(u, |i| self.points[j * self.u.count + i]);
        // Rows are splines in u; their points and derivatives are control points in v.
        let whole = self.v.spline(v, |j| row(j).value);
        let by_u = self.v.spline(v, |j| row(j).derivative).value;
        // The quotient rule.
        let p = whole.value.truncate() / whole.value.w;
        let divided = |d: DVec4| (d.truncate() - p * d.w) / whole.value.w;
        [p, divided(by_u), divided(whole.derivative)]
    }
}

impl ShapeType for NurbsSpec {
    fn compile(&self, site: &Site) -> Result<CompiledShape, ShapeError> {
        site.charged_mesh(self.mesh())
    }
}

impl Direction {
    /// `name` is "u" or "v".
    fn from_params(reader: &ParamReader, name: &str) -> Option<Direction> {
        let integer = |name: &str| {
            let message = format!("a nurbs surface needs \"integer {name}\"");
            needed(reader, name, reader.find_integer(name), message)
        };
        let (order_name, knots_name) = (format!("{name}order"), format!("{name}knots"));
        let (count, order) = (integer(&format!("n{name}")), integer(&order_name));
        let knots = reader.floats(&knots_name);
        let ends = [0, 1].map(|end| {
            let name = format!("{name}{end}");
            let given = reader.find_float(&name);
            (name, given)
        });
        let message = format!("a nurbs surface needs \"float {knots_name}\"");
        let knots = needed(reader, &knots_name, knots, message);
        let (count, order, knots) = (count?, order?, knots?);
        if order < 2 || order > count {
            let why = format_args!(
                "`{order_name}` is {order}; with {count} control points it is from 2 to {count}"
            );
            return left_out(reader, &order_name, why);
        }
        if count.checked_add(order) != i64::try_from(knots.len()).ok() {
            let why = format_args!(
                "{} knots for {count} control points of order {order}, which take {}",
                knots.len(),
                count.saturating_add(order)
            );
            return left_out(reader, &knots_name, why);
        }
        let (count, order) = (usize::try_from(count).ok()?, usize::try_from(order).ok()?);
        let (first, last) = (knots[order - 1], knots[count]);
        let ascending = knots.is_sorted() && knots.iter().all(|k| k.is_finite());
        if !ascending || first >= last {
            let why =
                "knots ascend, and there is something between the first and the last that count";
            return left_out(reader, &knots_name, why);
        }
        let range = ends_within(reader, ends, [first, last]);
        Some(Direction {
            order,
            count,
            knots: knots.to_vec(),
            range,
        })
    }

    /// The parameters of the mesh's points.
    fn diced(&self) -> impl Iterator<Item = f64> {
        let [first, last] = self.range;
        (0..DICED).map(move |i| {
            let t = f64::from(i) / f64::from(DICED - 1);
            first * (1.0 - t) + last * t
        })
    }

    /// The knot interval that holds `t`: the first that does not end before it.
    fn interval(&self, t: f64) -> usize {
        let (first, end) = (self.order - 1, self.count);
        let before = self.knots[first + 1..end].partition_point(|&knot| knot < t);
        first + before
    }

    /// De Boor's algorithm: the spline at `t` with the control points `point(i)`.
    fn spline(&self, t: f64, point: impl Fn(usize) -> DVec4) -> Jet {
        let (degree, k) = (self.order - 1, self.interval(t));
        let mut work: Vec<DVec4> = (0..=degree).map(|i| point(k - degree + i)).collect();
        for level in 1..degree {
            for i in 0..=degree - level {
                let (from, to) = (self.knots[k - degree + level + i], self.knots[k + 1 + i]);
                work[i] = between(work[i], work[i + 1], fraction(t, from, to));
            }
        }
        // The last step is between two points, whose difference is the derivative.
        let (from, to) = (self.knots[k], self.knots[k + 1]);
        Jet {
            value: between(work[0], work[1], fraction(t, from, to)),
            derivative: (work[1] - work[0]) * (degree as f64 / (to - from)),
        }
    }
}

/// The ends of the part that is made: those that are given, by their names, moved within the knots.
fn ends_within(
    reader: &ParamReader,
    given: [(String, Option<f64>); 2],
    [first, last]: [f64; 2],
) -> [f64; 2] {
    let mut range = [first, last];
    for (end, (name, given)) in range.iter_mut().zip(given) {
        let Some(given) = given else { continue };
        *end = given.clamp(first, last);
        if *end != given {
            let message = format!("`{name}` is {given}, outside the knots: {end} is used");
            reader.warn(&name, message);
        }
    }
    range
}

/// Where `t` is between two knots. Intervals of no length have no point of their own; 0 there.
fn fraction(t: f64, from: f64, to: f64) -> f64 {
    if to > from {
        (t - from) / (to - from)
    } else {
        0.0
    }
}

fn between(a: DVec4, b: DVec4, t: f64) -> DVec4 {
    a * (1.0 - t) + b * t
}

/// `P`, or else `Pw`.
fn control_points(reader: &ParamReader) -> Option<Vec<DVec4>> {
    if let Some(points) = reader.points3("P") {
        return Some(triples(points).map(|p| p.extend(1.0)).collect());
    }
    let message = "a nurbs surface needs control points: \"point3 P\" or \"float Pw\"";
    let numbers = needed(reader, "P", reader.floats("Pw"), message)?;
    let (points, rest) = numbers.as_chunks::<4>();
    if !rest.is_empty() {
        let why = "`Pw` has four numbers for each control point";
        return left_out(reader, "Pw", why);
    }
    if let Some(bad) = points.iter().position(|p| p[3] <= 0.0 || p[3].is_nan()) {
        // A weight that changes its sign on the way sends points to infinity.
        let weight = points[bad][3];
        reader.error_item(
            "Pw",
            4 * bad + 3,
            format!("weights of control points are positive, not {weight}: the shape is left out"),
        );
        return None;
    }
    Some(points.iter().copied().map(DVec4::from).collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::params::testing::read;

    fn reading(params: &str) -> crate::params::testing::Outcome<Option<NurbsSpec>> {
        read("nurbs", params, NurbsSpec::from_params)
    }

    /// A quarter of a cylinder of radius 2 about the y axis, v along it.
    fn quarter() -> NurbsSpec {
        let h = 0.5f64.sqrt();
        let (a, b, c) = (
            [2.0, 0.0, 0.0, 1.0],
            [2.0 * h, 0.0, 2.0 * h, h],
            [0.0, 0.0, 2.0, 1.0],
        );
        let lifted = |mut p: [f64; 4]| {
            p[1] = 3.0 * p[3];
            p
        };
        let numbers = [a, b, c, lifted(a), lifted(b), lifted(c)];
        let numbers: Vec<String> = numbers.iter().flatten().map(f64::to_string).collect();
        let params = format!(
            "\"integer nu\" 3 \"integer nv\" 2 \"integer uorder\" 3 \"integer vorder\" 2 \
             \"float uknots\" [0 0 0 1 1 1] \"float vknots\" [0 0 2 2] \"float Pw\" [{}]",
            numbers.join(" ")
        );
        let outcome = reading(&params);
        assert!(outcome.messages.is_empty(), "{:?}", outcome.messages);
        outcome.value.unwrap()
    }

    #[test]
    fn rational_quadratics_are_circles() {
        let mesh = quarter().mesh();
        assert_eq!(
            (mesh.positions.len(), mesh.indices.len()),
            (900, 2 * 29 * 29)
        );
        for (p, n) in mesh.positions.iter().zip(&mesh.normals) {
            let outward = DVec3::new(p.x, 0.0, p.z);
            assert!((outward.length() - 2.0).abs() < 1e-14);
            // At (2, 0, 0) u leads along z and v along y: z × y is −x, toward the axis.
            assert!(
                (n.as_dvec3() + outward / 2.0).length() < 1e-6,
                "{n} {outward}"
            );
        }
        assert!((mesh.positions[899] - DVec3::new(0.0, 3.0, 2.0)).length() < 1e-14);
        assert_eq!(mesh.uv[899], Vec2::new(1.0, 2.0));
    }

    #[test]
    fn derivatives_are_those_of_finite_differences() {
        // Uneven knots, one of them double, and a weight.
        let mut spec = NurbsSpec {
            u: Direction {
                order: 4,
                count: 6,
                knots: vec![0.0, 0.0, 0.1, 0.5, 1.0, 1.0, 2.0, 2.5, 3.0, 4.0],
                range: [0.5, 2.0],
            },
            v: Direction {
                order: 3,
                count: 4,
                knots: vec![-1.0, 0.0, 0.5, 1.5, 2.0, 2.0, 2.0],
                range: [0.5, 2.0],
            },
            points: Vec::new(),
        };
        for i in 0..24 {
            let p = DVec3::new((i % 6) as f64, (i / 6) as f64, (i as f64).sin());
            let w = if i == 9 { 2.5 } else { 1.0 };
            spec.points.push((p * w).extend(w));
        }
        // Truncation is of the order of STEP², rounding of 1e-16 / STEP.
        const STEP: f64 = 1e-5;
        for i in 0..20 {
            for j in 0..20 {
                let u = 0.51 + 1.48 * f64::from(i) / 20.0;
                let v = 0.51 + 1.48 * f64::from(j) / 20.0;
                let [_, dpdu, dpdv] = spec.at(u, v);
                let change = |du: f64, dv: f64| {
                    (spec.at(u + du, v + dv)[0] - spec.at(u - du, v - dv)[0]) / (2.0 * STEP)
                };
                // Second derivatives jump at double knots, of which none is that near.
                assert!((change(STEP, 0.0) - dpdu).length() < 1e-7);
                assert!((change(0.0, STEP) - dpdv).length() < 1e-7);
            }
        }
        // Points and normals exist at both ends and at the double knot.
        let mesh = spec.mesh();
        assert!(mesh.positions.iter().all(|p| p.is_finite()));
        assert!(mesh.normals.iter().all(|n| (n.length() - 1.0).abs() < 1e-6));
        assert!(spec.at(1.0, 1.5)[1].is_finite());
    }

    #[test]
    fn what_does_not_fit_is_an_error_and_what_is_outside_is_moved() {
        let body = "\"integer nu\" 2 \"integer nv\" 2 \"integer uorder\" 2 \"integer vorder\" 2 \
                    \"float uknots\" [0 0 1 1] \"float vknots\" [0 0 1 1] \
                    \"point P\" [0 0 0 1 0 0 0 1 0 1 1 0]";
        assert!(reading(body).messages.is_empty());
        let outcome = reading(&format!("{body} \"float u0\" -1 \"float v1\" .5"));
        assert_eq!((outcome.errors, outcome.warnings), (0, 1));
        assert_eq!(outcome.value.unwrap().u.range, [0.0, 1.0]);
        for (right, wrong) in [
            ("\"integer nu\" 2", ""),
            ("\"integer nu\" 2", "\"integer nu\" 3"),
            ("\"integer uorder\" 2", "\"integer uorder\" 1"),
            ("\"integer uorder\" 2", "\"integer uorder\" 3"),
            ("\"float uknots\" [0 0 1 1]", "\"float uknots\" [0 0 1]"),
            ("\"float uknots\" [0 0 1 1]", "\"float uknots\" [0 1 0 1]"),
            ("\"float uknots\" [0 0 1 1]", "\"float uknots\" [1 1 1 1]"),
            ("\"float vknots\" [0 0 1 1]", ""),
            (
                "\"point P\" [0 0 0 1 0 0 0 1 0 1 1 0]",
                "\"point P\" [0 0 0 1 0 0 0 1 0]",
            ),
            ("\"point P\" [0 0 0 1 0 0 0 1 0 1 1 0]", ""),
            (
                "\"point P\" [0 0 0 1 0 0 0 1 0 1 1 0]",
                "\"float Pw\" [0 0 0 1 0]",
            ),
            (
                "\"point P\" [0 0 0 1 0 0 0 1 0 1 1 0]",
                "\"float Pw\" [0 0 0 1 1 0 0 1 0 1 0 0 1 1 0 1]",
            ),
        ] {
            assert!(body.contains(right));
            let outcome = reading(&body.replace(right, wrong));
            assert!(outcome.value.is_none() && outcome.errors > 0, "{wrong}");
        }
    }
}
