use super::*;
use crate::bsdf::fresnel::Fresnel;
use crate::bsdf::lambertian::LambertianReflection;
use crate::bsdf::microfacet::MicrofacetReflection;
use crate::bsdf::trowbridge_reitz::TrowbridgeReitz;
use crate::bsdf::{Bsdf, Coated, Lobe, Matte};
use crate::integrators::testing::{ROOM_WITH_LAMPS, job};
use crate::math::Vec3;
use crate::math::hash::{mix2, unit_float};
use crate::math::instruction_set::InstructionSet;
use crate::surface::ShadingGeometry;

fn bits(colors: &[Rgb]) -> Vec<[u32; 3]> {
    let bits = |color: &Rgb| color.to_array().map(f32::to_bits);
    colors.iter().map(bits).collect()
}

/// A kind of vertices.
trait Kind: Scatterer {
    /// What scatters to `wo`, in some frame around `n`.
    fn made(color: Vec3, ng: Vec3, n: Vec3, wo: Vec3) -> (Self, Bsdf<'static>);
}

fn bsdf(ng: Vec3, n: Vec3, lobes: &[Lobe<'static>]) -> Bsdf<'static> {
    let shading = ShadingGeometry {
        n,
        dpdu: Vec3::ZERO,
        dpdv: Vec3::ZERO,
        dndu: Vec3::ZERO,
        dndv: Vec3::ZERO,
    };
    let mut bsdf = Bsdf::new(ng, &shading);
    lobes.iter().for_each(|&lobe| bsdf.add(lobe));
    bsdf
}

fn diffuse(reflectance: Vec3) -> Lobe<'static> {
    Lobe::LambertianReflection(LambertianReflection { reflectance })
}

impl Kind for Matte {
    fn made(color: Vec3, ng: Vec3, n: Vec3, wo: Vec3) -> (Matte, Bsdf<'static>) {
        let bsdf = bsdf(ng, n, &[diffuse(color)]);
        (bsdf.matte(wo).expect("diffuse reflection alone"), bsdf)
    }
}

impl Kind for Coated {
    fn made(color: Vec3, ng: Vec3, n: Vec3, wo: Vec3) -> (Coated, Bsdf<'static>) {
        let coat = Lobe::MicrofacetReflection(MicrofacetReflection {
            reflectance: Vec3::new(color.y, color.z, color.x),
            distribution: TrowbridgeReitz::new(color.x, color.z),
            fresnel: Fresnel::Dielectric {
                eta_i: 1.5,
                eta_t: 1.0,
            },
        });
        let bsdf = bsdf(ng, n, &[diffuse(color), coat]);
        let lobes = bsdf.coated().expect("both lobes");
        (Coated::new(&lobes, ng, *bsdf.frame(), wo), bsdf)
    }
}

/// Vertices all over the place, also on the lamps and where they cannot be seen.
fn fill<S: Kind>(vertices: &mut Vertices<S>, seed: u64) {
    for i in 0..ROOM {
        let number = |k: u64| unit_float(mix2(seed * 1000 + i as u64, k));
        let vector = |k: u64| Vec3::new(number(k), number(k + 1), number(k + 2));
        let unit = |k: u64| (2.0 * vector(k) - Vec3::ONE).normalize_or(Vec3::Z);
        let from = ReferencePoint {
            p: 8.0 * vector(0) - Vec3::splat(4.0),
            p_error: 1e-6 * vector(3),
            n: unit(6),
            ..Default::default()
        };
        let n = (unit(6) + 0.3 * unit(9)).normalize_or(Vec3::Z);
        let (scatterer, _) = S::made(vector(12), from.n, n, unit(15));
        let u = match i {
            0 => Vec2::splat(0.5),
            1 => Vec2::ZERO,
            _ => Vec2::new(number(18), number(19)),
        };
        vertices.set(i, number(20), u, (&from, &scatterer), vector(21));
    }
}

/// A coated vertex by itself has the value, the density and the samples of its BSDF.
#[test]
fn what_is_coated_scatters_as_its_two_lobes() {
    let (mut lit, mut gone) = (0, 0);
    for i in 0..10_000 {
        let number = |k: u64| unit_float(mix2(i, k));
        let vector = |k: u64| Vec3::new(number(k), number(k + 1), number(k + 2));
        let unit = |k: u64| (2.0 * vector(k) - Vec3::ONE).normalize_or(Vec3::Z);
        let ng = unit(0);
        let n = (ng + 0.3 * unit(3)).normalize_or(Vec3::Z);
        let (wo, wi, u) = (unit(6), unit(9), Vec2::new(number(12), number(13)));
        let (coated, bsdf) = Coated::made(vector(14), ng, n, wo);
        let (f, pdf) = bsdf.f_and_pdf(wo, wi);
        assert_eq!(coated.f_and_pdf(wi), (f, pdf));
        lit += usize::from(!is_black(f));
        let frame = bsdf.frame();
        let (sample, is_lit) = coated.sample(frame.s, frame.t, u);
        let expected = bsdf.sample(wo, 0.0, u).map(|s| (s.f, s.wi, s.pdf));
        let found = is_lit.then_some((sample.f, sample.wi, sample.pdf));
        assert_eq!(found, expected, "{i}");
        gone += usize::from(!is_lit);
        assert_eq!(coated.receiver_side(), bsdf.receiver_side(wo));
    }
    assert!(lit > 3000 && gone > 100, "{lit} {gone}");
}

#[test]
fn all_instructions_find_the_same_light() {
    assert_same_light::<Matte>();
    assert_same_light::<Coated>();
}

fn assert_same_light<S: Kind>() {
    let job = job(ROOM_WITH_LAMPS);
    let mut lit = 0;
    for seed in 0..50 {
        for light in [0, 1].map(LightId) {
            let found = InstructionSet::available().into_iter().map(|set| {
                let mut waiting = Waiting::<S>::default();
                fill(&mut waiting.vertices, seed);
                let samples = &mut Samples::default();
                let vertices = waiting.vertices.rows();
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
