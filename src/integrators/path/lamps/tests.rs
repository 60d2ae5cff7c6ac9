use super::*;
use crate::bsdf::{Bsdf, Lobe, lambertian::LambertianReflection};
use crate::cameras::{BUNDLE, CameraSample};
use crate::integrators::{CameraEnd, Workspace};
use crate::math::hash::{mix2, unit_float};
use crate::math::instruction_set::InstructionSet;
use crate::math::{IVec2, Vec3};
use crate::render::RenderJob;
use crate::scene::{ReadSettings, read_scene};
use crate::surface::ShadingGeometry;
use crate::syntax::SourceMap;
use arrayvec::ArrayVec;

/// A white room, closed, so that paths are long, with two lamps and something glossy. Shading normals are not those of the floor.
const ROOM_WITH_LAMPS: &str = r#"
    LookAt 0 0 -3.9  0 0 0  0 1 0
    Camera "perspective" "float fov" 70
    Film "image" "integer xresolution" 16 "integer yresolution" 16
    Sampler "sobol" "integer pixelsamples" 16
    Integrator "path" "integer maxdepth" 30 "float rrthreshold" 0
    WorldBegin
    Material "matte" "rgb Kd" [ .95 .9 .93 ]
    Shape "trianglemesh" "integer indices" [ 0 1 2 0 2 3 4 5 6 4 6 7 0 1 5 0 5 4 3 2 6 3 6 7 0 3 7 0 7 4 1 2 6 1 6 5 ]
        "point P" [ -4 -4 -4  4 -4 -4  4 4 -4  -4 4 -4  -4 -4 4  4 -4 4  4 4 4  -4 4 4 ]
    Shape "trianglemesh" "integer indices" [ 0 1 2 0 2 3 ] "point P" [ -3 -2 -3  3 -2 -3  3 -2 3  -3 -2 3 ]
        "normal N" [ .1 1 0  0 1 .2  -.3 1 0  0 1 -.1 ]
    Material "plastic"
    Shape "sphere" "float radius" 1
    Material "matte"
    AreaLightSource "diffuse" "rgb L" [ 3 2 1 ]
    Shape "trianglemesh" "integer indices" [ 0 1 2 0 2 3 ] "point P" [ -1 3.9 -1  1 3.9 -1  1 3.9 1  -1 3.9 1 ]
    Translate 2 0 -1
    ReverseOrientation
    AreaLightSource "diffuse" "rgb L" [ 1 2 3 ] "bool twosided" "true"
    Shape "sphere" "float radius" .5
    WorldEnd
"#;

fn room() -> RenderJob {
    let sources = SourceMap::new();
    let main = sources.add_text("room.pbrt", ROOM_WITH_LAMPS.to_string());
    let (mut scene, _) = read_scene(&sources, main, &ReadSettings::default());
    let frame = scene.frames.pop().expect("a frame");
    let (built, diagnostics) = crate::build::build(frame, 0);
    assert!(!diagnostics.has_errors());
    built.expect("a scene").job
}

/// Samples of a pixel, with the numbers of their paths' samples.
fn samples(pixel: u32) -> ArrayVec<CameraSample, BUNDLE> {
    let sample = |index: u32| CameraSample {
        raster: [pixel % 16, pixel / 16].map(|x| x as f32 + 0.5).into(),
        time: 0.0,
        lens: Vec2::splat(unit_float(mix2(pixel.into(), index.into()))),
        wavelength: 0.5,
    };
    (0..BUNDLE as u32).map(sample).collect()
}

#[test]
fn a_path_brings_the_same_whether_its_light_has_deferred_or_not() {
    let job = room();
    let mut at_once = Workspace::default();
    let mut side_by_side = job.integrator.workspace(&job.world);
    assert!(side_by_side.deferred.0[..2].iter().all(Option::is_some));
    let (mut rays, mut lit) = (ArrayVec::new(), 0);
    for pixel in 0..256u32 {
        let samples = samples(pixel);
        job.camera.rays(&samples, false, &mut rays);
        let mut expected = Vec::new();
        for ((sample, ray), index) in samples.iter().zip(&rays).zip(0..) {
            let end = CameraEnd {
                camera: &job.camera,
                sample,
                ray: ray.as_ref().expect("a ray"),
                film_density: 1.0,
                light_paths: 0.0,
            };
            let at = IVec2::new(pixel as i32 % 16, pixel as i32 / 16);
            let [mut one, mut other] = [0; 2].map(|_| job.sampler.stream(at, index));
            let integrator = &job.integrator;
            let radiance =
                integrator.radiance(&job.world, &end, None, &mut one, &mut at_once, None);
            expected.push(radiance);
            integrator.walk(&job.world, &end, None, &mut other, &mut side_by_side, None);
        }
        let found = side_by_side.radiances(&job.world);
        assert_eq!(bits(&found), bits(&expected));
        lit += expected
            .iter()
            .filter(|&&radiance| !is_black(radiance))
            .count();
    }
    assert!(lit > 256 * BUNDLE * 9 / 10, "{lit}");
}

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
    let job = room();
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
