//! One ray and eight triangles side by side.

use super::{Meeting, mask, verdict};
use crate::accel::ray::TraversalRay;
use crate::accel::watertight::REACH;
use crate::math::Vec3;
use crate::math::instruction_set::{InstructionSet, Instructions, Kernel};

/// Triangles that are tested by one turn of the loop.
const LANES: usize = 8;

/// Triangles by lot and lane, those of a lane being neighbors: their corners, by axis and corner. Unused ones are NaN, which no test
/// accepts.
pub(super) struct Lots(Box<[[[[f32; LANES]; 3]; 3]]>);

impl Lots {
    /// Of up to 64 triangles.
    pub(super) fn of(triangles: &[[Vec3; 3]]) -> Lots {
        let mut lots = vec![[[[f32::NAN; LANES]; 3]; 3]; triangles.len().div_ceil(LANES)];
        let count = lots.len().max(1);
        for (i, corners) in triangles.iter().enumerate() {
            let (lot, lane) = (&mut lots[i % count], i / count);
            for (k, p) in corners.iter().enumerate() {
                for (rows, x) in lot.iter_mut().zip(p.to_array()) {
                    rows[k][lane] = x;
                }
            }
        }
        Lots(lots.into())
    }

    /// Memory in bytes.
    pub(super) fn bytes(&self) -> usize {
        size_of_val(&self.0[..])
    }

    /// The triangles that the ray meets, of finite numbers, which ends at `t_max`: for each a bit, [numbered](Lots::triangle) in the triangles' order.
    #[inline(always)]
    pub(super) fn test(
        &self,
        instructions: InstructionSet,
        (o, d): (Vec3, Vec3),
        t_max: f32,
    ) -> Meeting {
        instructions.run(Test {
            lots: self,
            ray: (o, d),
            end: t_max * REACH,
        })
    }

    /// The triangle of a bit.
    #[inline(always)]
    pub(super) fn triangle(&self, bit: u32) -> usize {
        let (lane, lot) = (bit as usize / LANES, bit as usize % LANES);
        lane * self.0.len() + lot
    }
}

/// The loop.
struct Test<'a> {
    lots: &'a Lots,
    ray: (Vec3, Vec3),
    end: f32,
}

impl Kernel for Test<'_> {
    type Output = Meeting;

    #[inline(always)]
    fn run(self, _: impl Instructions) -> Meeting {
        let ray = TraversalRay::new(self.ray.0, self.ray.1);
        let [ax, ay, az] = ray.axes;
        let [sx, sy, sz] = ray.shear;
        let [ox, oy, oz] = ray.sheared_o;
        let (mut met, mut on_edge) = ([0; LANES], [0; LANES]);
        for (lot, rows) in self.lots.0.iter().enumerate() {
            let (x, y, z) = (&rows[ax], &rows[ay], &rows[az]);
            let sheared = |k: usize, i: usize| {
                let z = z[k][i] - oz;
                (x[k][i] - ox + sx * z, y[k][i] - oy + sy * z, z * sz)
            };
            for i in 0..LANES {
                let found = verdict(sheared(0, i), sheared(1, i), sheared(2, i), self.end);
                met[i] |= mask(found.0) & (1 << lot);
                on_edge[i] |= mask(found.1) & (1 << lot);
            }
        }
        Meeting {
            met: bits(met),
            on_edge: bits(on_edge),
        }
    }
}

/// The lowest bits of each, one after the other.
#[inline(always)]
fn bits(lanes: [u32; LANES]) -> u64 {
    u64::from_le_bytes(lanes.map(|lane| lane as u8))
}
