//! Sets of rays, the same for all contenders.

use crate::contenders::{Ours, Query};
use fstop::math::hash::{mix2, unit_float};
use fstop::math::ray::Ray;
use fstop::math::sampling::uniform_sphere;
use fstop::math::{Vec2, Vec3};

/// What rays are like.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(crate) enum Kind {
    /// From an eye through a square image, tile by tile.
    Primary,
    /// From where primary rays meet the mesh, cosine-distributed.
    Bounce,
    /// From anywhere around to anywhere inside, neighbors in nothing.
    Random,
    /// From where primary rays meet the mesh to a light, ending there.
    Shadow,
}

/// All of them.
pub(crate) const SETS: [Kind; 4] = [Kind::Primary, Kind::Bounce, Kind::Random, Kind::Shadow];

impl Kind {
    /// For the table.
    pub(crate) fn name(self) -> &'static str {
        match self {
            Kind::Primary => "primary",
            Kind::Bounce => "bounce",
            Kind::Random => "random",
            Kind::Shadow => "shadow",
        }
    }

    /// What is asked along such rays.
    pub(crate) fn queries(self) -> &'static [Query] {
        match self {
            Kind::Shadow => &[Query::Any],
            _ => &[Query::Closest, Query::Any],
        }
    }
}

/// Rays of one kind.
pub(crate) struct RaySet {
    pub kind: Kind,
    pub rays: Vec<Ray>,
}

/// Pixels along one side of the image, and of a tile.
const SIDE: usize = 360;
const TILE: usize = 8;

/// How far secondary rays start from the surface: far more than rounding, so that contenders without
/// a defence against meeting the triangle they start from give the same answers.
const OFFSET: f32 = 1e-4;

impl RaySet {
    /// The rays of one kind; those that start on the mesh ask `ours` where it is.
    pub(crate) fn new(kind: Kind, ours: &Ours) -> RaySet {
        let count = SIDE * SIDE;
        let rays = match kind {
            Kind::Primary => (0..count).map(primary).collect(),
            Kind::Random => (0..count).map(random_ray).collect(),
            Kind::Bounce | Kind::Shadow => (0..count)
                .filter_map(|i| {
                    let (p, n) = ours.surface(&primary(i))?;
                    let o = p + n * OFFSET;
                    Some(if kind == Kind::Bounce {
                        // A point of the unit sphere that touches the surface there: cosine law.
                        let d = n + uniform_sphere(pair(i, 0)) * 0.9999;
                        Ray::new(o, d.normalize(), 0.0)
                    } else {
                        let to_light = Vec3::new(2.0, -2.0, 3.0) - o;
                        Ray {
                            t_max: to_light.length(),
                            ..Ray::new(o, to_light.normalize(), 0.0)
                        }
                    })
                })
                .collect(),
        };
        RaySet { kind, rays }
    }
}

fn pair(i: usize, dimension: u64) -> Vec2 {
    let draw = |k| unit_float(mix2(i as u64, 2 * dimension + k));
    Vec2::new(draw(0), draw(1))
}

fn primary(i: usize) -> Ray {
    let (tile, within) = (i / (TILE * TILE), i % (TILE * TILE));
    let tiles = SIDE / TILE;
    let (x, y) = (
        tile % tiles * TILE + within % TILE,
        tile / tiles * TILE + within / TILE,
    );
    let at = |pixel: usize| (pixel as f32 + 0.5) / SIDE as f32 - 0.5;
    let d = Vec3::new(0.7 * at(x), 1.0, 0.7 * at(y) - 0.17);
    Ray::new(Vec3::new(0.0, -3.0, 0.5), d.normalize(), 0.0)
}

fn random_ray(i: usize) -> Ray {
    let o = uniform_sphere(pair(i, 0)) * 2.0;
    let target = uniform_sphere(pair(i, 1)) * pair(i, 2).x;
    Ray::new(o, (target - o).normalize(), 0.0)
}
