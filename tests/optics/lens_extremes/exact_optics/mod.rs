//! Optics in numbers of 32 digits, written independently of the program: what its own are measured against.
//!
//! Rays are traced with the textbook's other form (sphere by its center, Snell's law with vectors; Born and Wolf,
//! *Principles of Optics*, §4.6 and 3.2.2), which cancels for weak curvatures and therefore needs the digits.

#![allow(dead_code, reason = "not every test needs all of it")]

pub(super) mod dd;

use dd::Dd;
use fstop::optics::{Cause, Surface};

/// One row: what [`Surface`] says, in 32 digits.
#[derive(Clone, Copy, Debug)]
pub(super) struct Row {
    /// `None` for a plane.
    pub radius: Option<Dd>,
    pub thickness: Dd,
    pub index: Dd,
    pub clear_radius: Dd,
}

/// A lens of spheres and planes.
#[derive(Clone, Debug)]
pub(super) struct ExactLens {
    pub rows: Vec<Row>,
    /// Rays are rounded this much behind every surface, up or down by the pattern.
    rounding: Option<(f64, u64)>,
}

/// What became of a ray.
#[derive(Clone, Copy, Debug)]
pub(super) struct Outcome {
    /// Where it left the lens and where it goes, or where and why it ended.
    pub end: Result<([Dd; 3], [Dd; 3]), (usize, Cause)>,
    /// How near it came to another outcome, relative to the quantity that decides: 0 on the very edge.
    pub margin: f64,
    /// Where it met the last surface it came to within reach: how far from the axis the rim is, and where the ray was.
    pub last: Option<(f64, [f64; 2])>,
}

impl ExactLens {
    pub(super) fn new(surfaces: &[Surface]) -> ExactLens {
        let row = |s: &Surface| Row {
            radius: s.radius.is_finite().then(|| Dd::from(s.radius)),
            thickness: Dd::from(s.thickness),
            index: Dd::from(s.index),
            clear_radius: Dd::from(s.aperture) * Dd::from(0.5),
        };
        ExactLens {
            rows: surfaces.iter().map(row).collect(),
            rounding: None,
        }
    }

    /// The same lens, every number of which is off by `epsilon` of itself, up or down by `pattern`; so are rays behind
    /// every surface.
    pub(super) fn shaken(&self, epsilon: f64, pattern: u64) -> ExactLens {
        let mut state = pattern.wrapping_mul(0x9e37_79b9_7f4a_7c15) | 1;
        let mut shake = |x: Dd| x * (Dd::ONE + Dd::from(sign(&mut state) * epsilon));
        ExactLens {
            rows: self
                .rows
                .iter()
                .map(|r| Row {
                    radius: r.radius.map(&mut shake),
                    thickness: shake(r.thickness),
                    // Air is exactly 1.
                    index: if r.index == Dd::ONE {
                        r.index
                    } else {
                        shake(r.index)
                    },
                    clear_radius: r.clear_radius,
                })
                .collect(),
            rounding: Some((epsilon, pattern)),
        }
    }

    /// From the first vertex to the last.
    pub(super) fn length(&self) -> Dd {
        let inner = &self.rows[..self.rows.len() - 1];
        inner.iter().fold(Dd::ZERO, |sum, r| sum + r.thickness)
    }

    fn index_before(&self, i: usize) -> Dd {
        if i == 0 {
            Dd::ONE
        } else {
            self.rows[i - 1].index
        }
    }

    /// Traces a ray; toward the film where the direction's z is positive.
    pub(super) fn trace(&self, o: [Dd; 3], d: [Dd; 3]) -> Outcome {
        let to_film = d[2].hi > 0.0;
        let count = self.rows.len();
        let mut z = Dd::ZERO;
        let vertices: Vec<Dd> = self
            .rows
            .iter()
            .map(|r| {
                let at = z;
                z = z + r.thickness;
                at
            })
            .collect();
        let (mut o, mut d, mut margin) = (o, unit(d), f64::INFINITY);
        let mut last = None;
        for k in 0..count {
            let i = if to_film { k } else { count - 1 - k };
            let (n, n2) = (self.index_before(i), self.rows[i].index);
            let mu = if to_film { n / n2 } else { n2 / n };
            (o, d) = self.rounded(o, unit(d), i, vertices[i]);
            match cross(
                &self.rows[i],
                vertices[i],
                o,
                d,
                mu,
                to_film,
                (&mut margin, &mut last),
            ) {
                Ok(next) => (o, d) = next,
                Err(cause) => {
                    return Outcome {
                        end: Err((i, cause)),
                        margin,
                        last,
                    };
                }
            }
        }
        Outcome {
            end: Ok((o, d)),
            margin,
            last,
        }
    }

    /// The ray on the vertex plane, where the program goes first, with roundings of the sizes it has there.
    fn rounded(&self, o: [Dd; 3], d: [Dd; 3], i: usize, vertex: Dd) -> ([Dd; 3], [Dd; 3]) {
        let Some((epsilon, pattern)) = self.rounding else {
            return (o, d);
        };
        if d[2].hi == 0.0 {
            return (o, d);
        }
        let mut state = (pattern + 1).wrapping_mul(0xd1b5_4a32_d192_ed03 ^ i as u64) | 1;
        // Components of a vector are sums that may cancel: they carry roundings of the size of the whole.
        let mut shake = |x: Dd, size: f64| x + Dd::from(sign(&mut state) * epsilon * size);
        let o = along(o, d, (vertex - o[2]) / d[2]);
        let height = o[0].hi.hypot(o[1].hi);
        let o = [shake(o[0], height), shake(o[1], height), o[2]];
        (o, d.map(|x| shake(x, 1.0)))
    }

    /// (a, b, c, d) that take height and angle in front of the first vertex plane to those behind the last. Angles are
    /// true ones, not reduced by the index.
    pub(super) fn matrix(&self) -> [Dd; 4] {
        self.matrix_of(0, self.rows.len())
    }

    /// The same of the rows from `first` up to `end`, thicknesses in between included.
    pub(super) fn matrix_of(&self, first: usize, end: usize) -> [Dd; 4] {
        let follow = |mut y: Dd, mut u: Dd| {
            for i in first..end {
                let (n, n2) = (self.index_before(i), self.rows[i].index);
                let c = self.rows[i].radius.map_or(Dd::ZERO, |r| Dd::ONE / r);
                // n'u' = n u − (n' − n) c y.
                u = (n * u - (n2 - n) * c * y) / n2;
                if i + 1 < end {
                    y = y + self.rows[i].thickness * u;
                }
            }
            (y, u)
        };
        let (a, c) = follow(Dd::ONE, Dd::ZERO);
        let (b, d) = follow(Dd::ZERO, Dd::ONE);
        [a, b, c, d]
    }
}

/// Across one surface.
fn cross(
    row: &Row,
    vertex: Dd,
    o: [Dd; 3],
    d: [Dd; 3],
    mu: Dd,
    to_film: bool,
    (margin, last): (&mut f64, &mut Option<(f64, [f64; 2])>),
) -> Result<([Dd; 3], [Dd; 3]), Cause> {
    let mut near = |distance: Dd| *margin = margin.min(distance.hi.abs());
    let s = Dd::from(if to_film { 1.0 } else { -1.0 });
    near(d[2]);
    if (d[2] * s).hi <= 0.0 {
        return Err(Cause::Missed);
    }
    let (point, normal) = match row.radius {
        None => {
            let t = (vertex - o[2]) / d[2];
            (along(o, d, t), [Dd::ZERO, Dd::ZERO, Dd::ONE])
        }
        Some(radius) => {
            let center = [Dd::ZERO, Dd::ZERO, vertex + radius];
            let from_center = minus(o, center);
            let b = dot(d, from_center);
            // The squared distance of the line from the center, not the difference of two large numbers.
            let foot = minus(from_center, d.map(|x| x * b));
            let square = radius * radius - dot(foot, foot);
            near(square / (radius * radius));
            if square.hi < 0.0 {
                return Err(Cause::Missed);
            }
            // Where the ray runs along the normal that leans toward the film, or against it.
            let side = if radius.hi > 0.0 { s } else { -s };
            let t = -b - side * square.sqrt();
            let point = along(o, d, t);
            let normal = minus(center, point).map(|x| x / radius);
            near(normal[2]);
            if normal[2].hi <= 0.0 {
                return Err(Cause::Missed);
            }
            (point, normal)
        }
    };
    let height2 = point[0] * point[0] + point[1] * point[1];
    let clear2 = row.clear_radius * row.clear_radius;
    *last = Some((row.clear_radius.hi, [point[0].hi, point[1].hi]));
    near((clear2 - height2) / (clear2 + height2 + Dd::from(1e-300)));
    if (clear2 - height2).hi < 0.0 {
        return Err(Cause::Vignetted);
    }
    let q = dot(d, normal);
    let k = Dd::ONE - mu * mu * (Dd::ONE - q * q);
    near(k);
    if k.hi < 0.0 {
        return Err(Cause::TotalReflection);
    }
    let along_normal = s * k.sqrt() - mu * q;
    let out = std::array::from_fn(|i| mu * d[i] + along_normal * normal[i]);
    Ok((point, unit(out)))
}

fn sign(state: &mut u64) -> f64 {
    // Xorshift (Marsaglia 2003).
    *state ^= *state << 13;
    *state ^= *state >> 7;
    *state ^= *state << 17;
    if *state & 1 == 0 { 1.0 } else { -1.0 }
}

pub(super) fn dot(a: [Dd; 3], b: [Dd; 3]) -> Dd {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

pub(super) fn minus(a: [Dd; 3], b: [Dd; 3]) -> [Dd; 3] {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

pub(super) fn along(o: [Dd; 3], d: [Dd; 3], t: Dd) -> [Dd; 3] {
    std::array::from_fn(|i| o[i] + t * d[i])
}

pub(super) fn unit(d: [Dd; 3]) -> [Dd; 3] {
    let length = dot(d, d).sqrt();
    d.map(|x| x / length)
}
