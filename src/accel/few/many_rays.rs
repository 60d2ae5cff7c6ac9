//! One triangle or quadric, and sixteen rays side by side.

use super::{Around, BALLS, CORNERS, COUNTS, Few, Meeting, mask, verdict};
use crate::accel::watertight::REACH;
use crate::math::instruction_set::{InstructionSet, Instructions, Kernel};
use crate::math::{DVec3, Vec3};
use crate::shapes::ball::Ball;
use arrayvec::ArrayVec;

/// How many.
pub(super) const RAYS: usize = 16;

/// Rays.
pub(super) struct Rays {
    /// By axis.
    o: [[f32; RAYS]; 3],
    d: [[f32; RAYS]; 3],
    /// What is beyond this is not met.
    end: [f32; RAYS],
}

impl Rays {
    /// None.
    #[inline(always)]
    pub(super) fn new() -> Rays {
        Rays {
            o: [[0.0; RAYS]; 3],
            d: [[0.0; RAYS]; 3],
            // Unused ones meet nothing, nor do those that are not finite.
            end: [f32::NAN; RAYS],
        }
    }

    /// Sets ray `i`, which ends at `t_max`.
    #[inline(always)]
    pub(super) fn set(&mut self, i: usize, (o, d): (Vec3, Vec3), t_max: f32) {
        let i = i % RAYS;
        (self.o[0][i], self.o[1][i], self.o[2][i]) = (o.x, o.y, o.z);
        (self.d[0][i], self.d[1][i], self.d[2][i]) = (d.x, d.y, d.z);
        self.end[i] = if (o + d).is_finite() {
            t_max * REACH
        } else {
            f32::NAN
        };
    }

    /// Origin and direction of ray `i`.
    #[inline(always)]
    pub(super) fn ray(&self, i: usize) -> (Vec3, Vec3) {
        let i = i % RAYS;
        let at = |rows: &[[f32; RAYS]; 3]| Vec3::new(rows[0][i], rows[1][i], rows[2][i]);
        (at(&self.o), at(&self.d))
    }

    /// Where each of them meets a ball; sets `bit` where it does.
    #[inline(always)]
    fn distances(&self, ball: &Ball, (bit, met): (u32, &mut [u32; RAYS])) -> [f64; RAYS] {
        let mut distances = [0.0; RAYS];
        let at = |rows: &[[f32; RAYS]; 3], i: usize| {
            DVec3::new(rows[0][i].into(), rows[1][i].into(), rows[2][i].into())
        };
        for i in 0..RAYS {
            let t = ball.distance_if_any(at(&self.o, i), at(&self.d, i));
            distances[i] = t;
            met[i] |= mask((t > 0.0) & (t as f32 <= self.end[i])) & bit;
        }
        distances
    }

    /// Sets `bit` where they come near something: by how far their lines pass from its middle, with a margin for squares that cancel.
    #[inline(always)]
    #[expect(
        clippy::needless_range_loop,
        reason = "a loop over several rows, which vector instructions are made of"
    )]
    fn near(&self, around: &Around, (bit, near): (u32, &mut [u32; RAYS])) {
        const MARGIN: f32 = 1e-4;
        let Around { center: c, radius } = *around;
        let r2 = radius * radius;
        for i in 0..RAYS {
            let to = [c.x - self.o[0][i], c.y - self.o[1][i], c.z - self.o[2][i]];
            let d = [self.d[0][i], self.d[1][i], self.d[2][i]];
            let along = to[0] * d[0] + to[1] * d[1] + to[2] * d[2];
            let length2 = d[0] * d[0] + d[1] * d[1] + d[2] * d[2];
            let distance2 = to[0] * to[0] + to[1] * to[1] + to[2] * to[2];
            let limit = r2 + MARGIN * (r2 + distance2);
            let beside = distance2 * length2 - along * along > limit * length2;
            // Behind its beginning, and outside there.
            let behind = (along < 0.0) & (distance2 > limit);
            near[i] |= mask(!(beside | behind | self.end[i].is_nan())) & bit;
        }
    }

    /// Adds what each ray meets. Written where it is read: it is large.
    #[inline(always)]
    pub(super) fn test(&self, instructions: InstructionSet, few: &Few, met: &mut Meetings) {
        let rays = self;
        instructions.run(Test { rays, few, met });
    }
}

/// What each ray meets.
pub(super) struct Meetings {
    /// Triangles: a bit for each.
    met: [[u32; RAYS]; WORDS],
    /// Those of which one edge function is 0.
    on_edge: [[u32; RAYS]; WORDS],
    /// The balls that each ray meets, and after them others that it may meet: a bit for each.
    round: [u32; RAYS],
    /// Where it meets the balls.
    distances: ArrayVec<[f64; RAYS], BALLS>,
}

/// Words for as many bits as there may be triangles.
const WORDS: usize = COUNTS.end().div_ceil(32);

impl Meetings {
    /// None.
    #[inline(always)]
    pub(super) fn new() -> Meetings {
        Meetings {
            met: [[0; RAYS]; WORDS],
            on_edge: [[0; RAYS]; WORDS],
            round: [0; RAYS],
            distances: ArrayVec::new(),
        }
    }

    /// The triangles of ray `i`.
    #[inline(always)]
    pub(super) fn of(&self, i: usize) -> Meeting {
        let i = i % RAYS;
        let bits =
            |words: &[[u32; RAYS]; WORDS]| u64::from(words[0][i]) | u64::from(words[1][i]) << 32;
        Meeting {
            met: bits(&self.met),
            on_edge: bits(&self.on_edge),
        }
    }

    /// The balls that ray `i` meets, and after them others that it may meet: a bit for each.
    #[inline(always)]
    pub(super) fn round(&self, i: usize) -> u32 {
        self.round[i % RAYS]
    }

    /// Where ray `i` meets ball `k`.
    #[inline(always)]
    pub(super) fn distance(&self, k: usize, i: usize) -> f64 {
        let distances = self.distances.get(k);
        distances.map_or(0.0, |distances| distances[i % RAYS])
    }
}

/// The rays' shears, as of [`crate::accel::ray::TraversalRay`], by the axes x, y and z of the sheared space.
struct Shears {
    /// All bits, where the direction is largest in x; in y.
    in_x: [u32; RAYS],
    in_y: [u32; RAYS],
    o: [[f32; RAYS]; 3],
    shear: [[f32; RAYS]; 3],
}

/// A corner in the sheared space of each ray.
type Sheared = [[f32; RAYS]; 3];

/// The coordinates of `v` in the axes of the sheared space.
#[inline(always)]
fn turned((in_x, in_y): (u32, u32), [x, y, z]: [f32; 3]) -> [f32; 3] {
    let select = |a: f32, b: f32, c: f32| {
        let other = if in_y != 0 { b } else { c };
        if in_x != 0 { a } else { other }
    };
    [select(y, z, x), select(z, x, y), select(x, y, z)]
}

impl Shears {
    #[inline(always)]
    fn new(rays: &Rays) -> Shears {
        let mut all = Shears {
            in_x: [0; RAYS],
            in_y: [0; RAYS],
            o: [[0.0; RAYS]; 3],
            shear: [[0.0; RAYS]; 3],
        };
        for i in 0..RAYS {
            let d = [rays.d[0][i], rays.d[1][i], rays.d[2][i]];
            let a = [d[0].abs(), d[1].abs(), d[2].abs()];
            let in_x = mask((a[0] > a[1]) & (a[0] > a[2]));
            let in_y = mask(a[1] > a[2]);
            let [ox, oy, oz] = turned((in_x, in_y), [rays.o[0][i], rays.o[1][i], rays.o[2][i]]);
            let [dx, dy, dz] = turned((in_x, in_y), d);
            (all.in_x[i], all.in_y[i]) = (in_x, in_y);
            (all.o[0][i], all.o[1][i], all.o[2][i]) = (ox, oy, oz);
            (all.shear[0][i], all.shear[1][i], all.shear[2][i]) = (-dx / dz, -dy / dz, 1.0 / dz);
        }
        all
    }

    #[inline(always)]
    #[expect(
        clippy::needless_range_loop,
        reason = "a loop over several rows, which vector instructions are made of"
    )]
    fn sheared(&self, p: Vec3) -> Sheared {
        let mut sheared = [[0.0; RAYS]; 3];
        let p = p.to_array();
        for i in 0..RAYS {
            let [x, y, z] = turned((self.in_x[i], self.in_y[i]), p);
            let z = z - self.o[2][i];
            sheared[0][i] = x - self.o[0][i] + self.shear[0][i] * z;
            sheared[1][i] = y - self.o[1][i] + self.shear[1][i] * z;
            sheared[2][i] = z * self.shear[2][i];
        }
        sheared
    }
}

/// The loops.
struct Test<'a> {
    rays: &'a Rays,
    few: &'a Few,
    met: &'a mut Meetings,
}

impl Kernel for Test<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self, _: impl Instructions) {
        let shears = Shears::new(self.rays);
        let mut places = ArrayVec::<Sheared, CORNERS>::new();
        for &p in &self.few.places {
            places.push(shears.sheared(p));
        }
        let all = self.met;
        for (k, (_, ball)) in self.few.balls.iter().enumerate() {
            let distances = self.rays.distances(ball, (1 << k, &mut all.round));
            all.distances.push(distances);
        }
        for (k, (_, around)) in (self.few.balls.len()..).zip(&self.few.others) {
            self.rays.near(around, (1 << k, &mut all.round));
        }
        let words = all.met.iter_mut().zip(&mut all.on_edge);
        for (corners, (met, on_edge)) in self.few.corners.chunks(32).zip(words) {
            for (k, &[a, b, c]) in corners.iter().enumerate() {
                let at = |i: u8| places.get(usize::from(i));
                if let (Some(a), Some(b), Some(c)) = (at(a), at(b), at(c)) {
                    add(&self.rays.end, [a, b, c], (1 << k, met, on_edge));
                }
            }
        }
    }
}

/// Adds the bit of the triangle with these corners, where it is met.
#[inline(always)]
fn add(
    end: &[f32; RAYS],
    [a, b, c]: [&Sheared; 3],
    (bit, met, on_edge): (u32, &mut [u32; RAYS], &mut [u32; RAYS]),
) {
    let at = |p: &Sheared, i: usize| (p[0][i], p[1][i], p[2][i]);
    for i in 0..RAYS {
        let found = verdict(at(a, i), at(b, i), at(c, i), end[i]);
        met[i] |= mask(found.0) & bit;
        on_edge[i] |= mask(found.1) & bit;
    }
}
