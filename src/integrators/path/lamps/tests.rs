use super::super::testing::{ROOM_WITH_LAMPS, job};
use super::*;
use crate::bsdf::{Bsdf, Lobe, lambertian::LambertianReflection};
use crate::math::Vec3;
use crate::math::hash::{mix2, unit_float};
use crate::math::instruction_set::InstructionSet;
use crate::surface::ShadingGeometry;

fn bits(colors: &[Rgb]) -> Vec<[u32; 3]> {
    let bits = |color: &Rgb| color.to_array().map(f32::to_bits);
    colors.iter().map(bits).collect()
}

/// Vertices all over the place, also on the lamps and where they cannot be seen.
fn fill(vertices: &mut Vertices, seed: u64) {
    for i in 0..ROOM {
        let number = |k: u64| unit_float(mix2(seed * 1000 + i as u64, k));
        let vector = |k: u64| Vec3::new(number(k), number(k + 1), number(k + 2));
        let unit = |k: u64| (2.0 * vector(k) - Vec3::ONE).normalize_or(Vec3::Z);
        let from = ReferencePoint {
            p: 8.0 * vector(0) - Vec3::splat(4.0),
            p_error: 1e-6 * vector(3),
            n: unit(6),
            time: 0.0,
            receiver_side: Default::default(),
        };
        let n = (unit(6) + 0.3 * unit(9)).normalize_or(Vec3::Z);
        let shading = ShadingGeometry {
            n,
            dpdu: Vec3::ZERO,
            dpdv: Vec3::ZERO,
            dndu: Vec3::ZERO,
            dndv: Vec3::ZERO,
        };
        let mut bsdf = Bsdf::new(from.n, &shading);
        bsdf.add(Lobe::LambertianReflection(LambertianReflection {
            reflectance: vector(12),
        }));
        let matte = bsdf.matte(unit(15)).expect("diffuse reflection alone");
        let u = match i {
            0 => Vec2::splat(0.5),
            1 => Vec2::ZERO,
            _ => Vec2::new(number(18), number(19)),
        };
        vertices.set(i, number(20), u, (&from, &matte), vector(21));
    }
}

#[test]
fn all_instructions_find_the_same_light() {
    let job = job(ROOM_WITH_LAMPS);
    let mut lit = 0;
    for seed in 0..50 {
        for light in [0, 1].map(LightId) {
            let found = InstructionSet::available().into_iter().map(|set| {
                let mut waiting = Waiting::default();
                fill(&mut waiting.vertices, seed);
                let (vertices, samples) = (&waiting.vertices, &mut waiting.samples);
                let (emitter, glow) = job.world.light(light).shape().expect("a shape");
                let count = ROOM;
                match emitter {
                    Emitter::Parallelogram(piece) => set.run(SideBySide {
                        emitter: **piece,
                        glow,
                        vertices,
                        count,
                        samples,
                    }),
                    Emitter::Sphere(ball) => set.run(SideBySide {
                        emitter: ball.far(),
                        glow,
                        vertices,
                        count,
                        samples,
                    }),
                    _ => panic!("neither lamp"),
                }
                lit += (0..ROOM)
                    .filter(|&i| !is_black(samples.value.get(i)))
                    .count();
                let of = |i: usize| {
                    let (value, ray) = (samples.value.get(i), samples.shadow(i, 0.0));
                    // Nobody looks at the ray of nothing, which may be no number, of whatever bits.
                    let seen = if is_black(value) { 1 } else { 4 };
                    bits(&[value, ray.o, ray.d, Rgb::splat(ray.t_max)][..seen])
                };
                (0..ROOM).map(of).collect::<Vec<_>>()
            });
            let found: Vec<_> = found.collect();
            assert!(found.windows(2).all(|pair| pair[0] == pair[1]), "{seed}");
        }
    }
    assert!(lit > 1000, "{lit}");
}
