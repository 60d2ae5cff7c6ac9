use super::*;
use crate::accel::GeometryHit;
use crate::bsdf::fresnel::Fresnel;
use crate::bsdf::lambertian::LambertianReflection;
use crate::bsdf::microfacet::MicrofacetReflection;
use crate::bsdf::trowbridge_reitz::TrowbridgeReitz;
use crate::bsdf::{Bsdf, CoatedLobes, Lobe};
use crate::integrators::testing::{OUTDOORS, ROOM_WITH_LAMPS, bits, in_waves, job, one_by_one};
use crate::math::color::is_black;
use crate::math::hash::{mix2, unit_float};
use crate::math::instruction_set::InstructionSet;
use crate::math::{Vec2, Vec3};
use crate::render::RenderJob;
use crate::surface::SurfaceHit;
use std::collections::HashSet;

/// [`OUTDOORS`], with so many lamps that first surfaces choose several.
fn under_many_lamps() -> String {
    let lamp = |i: u32| {
        format!(
            "AttributeBegin AreaLightSource \"diffuse\" \"rgb L\" [ {i} 3 4 ] Translate {i} 3 -1 \
             Shape \"sphere\" \"float radius\" .2 AttributeEnd LightSource \"point\" \"point from\" [ -{i} 4 -2 ]\n"
        )
    };
    let lamps: String = (0..4).map(lamp).collect();
    OUTDOORS.replace("WorldBegin", &format!("WorldBegin\n{lamps}"))
}

/// [`ROOM_WITH_LAMPS`] with one of them, with neither but a point, and seen through a pane without material, beyond which first
/// vertices lie one step later.
fn other_rooms() -> [String; 4] {
    const FIRST: &str = "AreaLightSource \"diffuse\" \"rgb L\" [ 3 2 1 ]";
    const SECOND: &str = "Translate 2 0 -1";
    let end = ROOM_WITH_LAMPS.find(SECOND).expect("the ball");
    let flat = format!("{} WorldEnd", &ROOM_WITH_LAMPS[..end]);
    let point = "LightSource \"point\" \"rgb I\" [ 9 8 7 ] \"point from\" [ 0 3 0 ]";
    let pane = "Material \"none\" Shape \"trianglemesh\" \"integer indices\" [ 0 1 2 0 2 3 ]
        \"point P\" [ -4 -4 -3  0 -4 -3  0 4 -3  -4 4 -3 ] Material \"plastic\" Shape \"sphere\" \"float radius\" 1";
    [
        flat.replace(FIRST, point),
        ROOM_WITH_LAMPS.replace(FIRST, ""),
        ROOM_WITH_LAMPS.replacen("Material \"plastic\"", pane, 1),
        flat,
    ]
}

/// Under `volpath`: [`OUTDOORS`] without a medium, with one in a sphere without material and around others, and in haze, as the camera is, through
/// which one channel passes to the sky.
fn through_media() -> [String; 3] {
    let outdoors = OUTDOORS.replace(r#"Integrator "path""#, r#"Integrator "volpath""#);
    let medium = |name: &str, coefficients: &str| {
        let begin = format!("MakeNamedMedium \"{name}\" \"string type\" \"homogeneous\"");
        format!("{begin} \"float g\" .3 {coefficients} MediumInterface")
    };
    let fog = medium(
        "fog",
        r#""rgb sigma_a" [ 1.5 .02 .1 ] "rgb sigma_s" [ .05 .1 1.5 ]"#,
    );
    let haze = medium(
        "haze",
        r#""rgb sigma_a" [ 0 .02 .1 ] "rgb sigma_s" [ 0 .1 .1 ]"#,
    );
    let ball = format!(r#"{fog} "fog" "" Material "none""#);
    let inside = outdoors.replace(r#"Material "none""#, &ball);
    let within = inside.replace("WorldBegin", r#"WorldBegin MediumInterface "haze" "haze""#);
    [outdoors, inside, format!(r#"{haze} "" "haze" {within}"#)]
}

#[test]
fn a_path_brings_the_same_in_any_wave_as_by_itself() {
    let others: Vec<String> = other_rooms().into_iter().chain(through_media()).collect();
    let others = others.iter().map(String::as_str);
    for text in [ROOM_WITH_LAMPS, OUTDOORS, &under_many_lamps()]
        .into_iter()
        .chain(others)
    {
        let job = job(text);
        let expected = one_by_one(&job, 0.0).radiances;
        let lit = expected.iter().filter(|&&light| !is_black(light)).count();
        assert!(lit > expected.len() * 9 / 10, "{lit}");
        for of in [1, 7, 64, WAVE] {
            let found = in_waves(&job, of, 0.0, false).radiances;
            assert_eq!(bits(&found), bits(&expected), "waves of {of}");
        }
    }
}

#[test]
fn layers_see_the_same_in_a_wave_as_by_itself() {
    let (rooms, media) = (other_rooms(), through_media());
    // Where there is a group of lights.
    let others = rooms[1..3].iter().chain(&media).map(String::as_str);
    for text in [ROOM_WITH_LAMPS, OUTDOORS, &under_many_lamps()]
        .into_iter()
        .chain(others)
    {
        let job = job(text);
        let (expected, found) = (one_by_one(&job, 0.0), in_waves(&job, WAVE, 0.0, true));
        assert_eq!(bits(&found.radiances), bits(&expected.radiances));
        assert_eq!(found.seen, expected.seen);
        let known = |seen: &&String| seen.starts_with("Some(");
        let known = expected.seen.iter().filter(known).count();
        assert!(known > expected.seen.len() * 9 / 10, "{known}");
        let parts = found.parts.iter().zip(&expected.parts);
        for (i, (found, expected)) in parts.enumerate() {
            assert_eq!(bits(found), bits(expected), "{i}");
        }
        let in_group = |parts: &&Vec<Rgb>| !is_black(parts[1]);
        let in_group = expected.parts.iter().filter(in_group).count();
        assert!(in_group > expected.parts.len() / 10, "{in_group}");
    }
}

/// Rays from all over the place.
fn rays(seed: u64) -> impl Iterator<Item = Ray> {
    let number = move |k: u64| unit_float(mix2(seed, k));
    let vector = move |k: u64| Vec3::new(number(k), number(k + 1), number(k + 2));
    (0..).map(move |k| {
        let (mut o, mut d) = (
            6.0 * vector(6 * k + 3) - Vec3::splat(3.0),
            2.0 * vector(6 * k) - Vec3::ONE,
        );
        if k % 8 == 0 {
            // Along the floor of the room.
            (o.y, d.y) = (-3.99, -0.004);
        }
        Ray::new(o, d.normalize_or(Vec3::Z), 0.0)
    })
}

/// Hits of flat triangles by them.
fn flat_hits(job: &RenderJob, seed: u64) -> (FlatHits<WAVE>, Vec<(Ray, GeometryHit)>) {
    let (mut flats, mut hits) = (FlatHits::default(), Vec::new());
    for ray in rays(seed) {
        let mut found = [None];
        job.world.closest(std::slice::from_ref(&ray), &mut found);
        if let Some(found) = found[0]
            && let Some(triangle) = job.world.geometry.bare_triangle(&found)
            && triangle.is_flat()
        {
            flats.set(hits.len(), &ray, (&triangle, &found));
            flats.bare.note(hits.len(), &triangle);
            hits.push((ray, job.world.surface(&ray, &found).expect("a hit")));
            if hits.len() == WAVE {
                break;
            }
        }
    }
    (flats, hits)
}

#[test]
fn all_instructions_find_the_same_points_of_smooth_triangles() {
    let job = job(ROOM_WITH_LAMPS);
    let (mut smooth, mut hits) = (SmoothHits::<WAVE>::default(), Vec::new());
    for ray in rays(7) {
        let mut found = [None];
        job.world.closest(std::slice::from_ref(&ray), &mut found);
        if let Some(found) = found[0]
            && let Some(triangle) = job.world.geometry.bare_triangle(&found)
            && !triangle.is_flat()
        {
            smooth.set(hits.len(), &ray, (&triangle, &found));
            hits.push(job.world.surface(&ray, &found).expect("a hit").surface);
            if hits.len() == WAVE {
                break;
            }
        }
    }
    for set in InstructionSet::available() {
        smooth.resolve_with(set, WAVE);
        let mut vertices = Vertices::<Coated, WAVE>::default();
        for i in 0..WAVE as u32 {
            vertices.add_smooth(i, &lobes(), Rgb::ONE);
        }
        vertices.place_smooth_with(set, &smooth);
        vertices.finish_with(set);
        for (i, hit) in hits.iter().enumerate() {
            let found = smooth.point(i);
            let found = [found.p, found.p_error, found.n, found.shading_n, found.wo];
            let expected = [hit.p, hit.p_error, hit.n, hit.shading.n, hit.wo];
            assert_eq!(bits(&found), bits(&expected));
            let mut bsdf = Bsdf::new(hit.n, &hit.shading);
            bsdf.add(diffuse(Rgb::ONE));
            let from = vertices.from(i, 0.0);
            assert_eq!(bits(&[from.p, from.n]), bits(&[hit.p, hit.n]));
            assert_eq!(from.receiver_side, bsdf.receiver_side(hit.wo));
        }
    }
}

/// Of plastic.
fn lobes() -> CoatedLobes {
    let coat = Lobe::MicrofacetReflection(MicrofacetReflection {
        reflectance: Rgb::splat(0.3),
        distribution: TrowbridgeReitz::new(0.1, 0.3),
        fresnel: Fresnel::Dielectric {
            eta_i: 1.5,
            eta_t: 1.0,
        },
    });
    CoatedLobes::of(&[diffuse(Rgb::splat(0.5)), coat]).expect("both lobes")
}

/// Shapes of all kinds, in place, stretched, in instances and in motion.
const SHAPES: &str = r#"
    LookAt 0 1 -6  0 .5 0  0 1 0
    Camera "perspective" "float fov" 60
    Film "image" "integer xresolution" 16 "integer yresolution" 16
    WorldBegin
    Shape "sphere" "float radius" 1
    Shape "sphere" "float radius" 3 "float zmin" 1 "float zmax" 1.5
    Shape "disk" "float radius" 9 "float height" 7
    AttributeBegin
    Translate 2 1 1
    Rotate 30 1 2 3
    Scale 1 2 1
    Shape "sphere" "float zmin" -.5 "float phimax" 270
    AttributeEnd
    AttributeBegin
    Translate -2 0 1
    Rotate -90 1 0 0
    Shape "cone" "float height" 2
    Translate 0 2 0
    Shape "curve" "point P" [ -2 0 -3  -1 0 2  0 1 -2  0 0 3 ] "float width" 1
    ActiveTransform EndTime
    Translate 0 0 .2
    ActiveTransform All
    Shape "cylinder"
    AttributeEnd
    ObjectBegin "two"
    Shape "paraboloid"
    Translate 0 0 -1
    Shape "trianglemesh" "integer indices" [ 0 1 2 ] "point P" [ -9 -9 0  9 -9 0  0 9 0 ] "float uv" [ 0 0 3 0 1 1 ]
    ObjectEnd
    Translate 0 -1 4
    Scale 2 1 1
    ObjectInstance "two"
    WorldEnd
"#;

#[test]
fn parameters_are_those_of_the_whole_surface() {
    // Those of quadrics to what is promised (`ObjectSurface::approximate_uv`).
    let is_same = |found: &ClosestHit, a: Vec2, b: Vec2| match found.is_triangle() {
        true => a.to_array().map(f32::to_bits) == b.to_array().map(f32::to_bits),
        false => a.abs_diff_eq(b, 2e-6),
    };
    // The ground, too, whose mesh has parameters of its own.
    let plain = OUTDOORS.replace(r#""texture Kd" "tiles""#, r#""rgb Kd" [ .5 .5 .5 ]"#);
    for text in [ROOM_WITH_LAMPS, &plain, SHAPES] {
        let job = job(text);
        let geometry = &job.world.geometry;
        let (mut compared, mut shapes) = (0, HashSet::new());
        for (time, ray) in [0.0, 0.6, 1.0].into_iter().cycle().zip(rays(9)) {
            let (ray, mut found) = (Ray { time, ..ray }, [None]);
            job.world.closest(std::slice::from_ref(&ray), &mut found);
            let Some(found) = found[0].take() else {
                continue;
            };
            let whole = geometry.whole(&ray, &found).expect("a surface");
            let uv = job.world.surface_parameters(&ray, &found);
            assert!(is_same(&found, uv, whole.surface.uv), "{ray:?}");
            // Asked for beside the point, they change nothing of it; where there is no material nobody needs them.
            let known = job.world.surface_with(&ray, &found, true);
            let known = known.expect("a surface").surface;
            let plain = job.world.surface(&ray, &found).expect("a surface").surface;
            let uv = if whole.material.is_some() {
                assert!(is_same(&found, known.uv, uv), "{ray:?}");
                known.uv
            } else {
                plain.uv
            };
            let expected = SurfaceHit { uv, ..plain };
            assert_eq!(format!("{known:?}"), format!("{expected:?}"), "{ray:?}");
            assert!(whole.surface.uv != Vec2::ZERO, "{ray:?}");
            shapes.insert(format!("{:?}", geometry.standing(&whole)));
            compared += 1;
            if compared == 4 * WAVE {
                break;
            }
        }
        assert!(shapes.len() >= 5, "{shapes:?}");
    }
}

#[test]
fn all_instructions_find_the_same_points_and_directions() {
    let (mut grazing, mut gone_on) = (0, 0);
    for (text, seed) in [ROOM_WITH_LAMPS, OUTDOORS].into_iter().zip(0..) {
        let job = job(text);
        let (mut flats, hits) = flat_hits(&job, seed);
        for set in InstructionSet::available() {
            flats.resolve_with(set, WAVE);
            let mut mattes = Vertices::<Matte, WAVE>::default();
            let reflectance = |i: usize| Rgb::new(0.1, 0.9, i as f32 / WAVE as f32);
            for i in 0..WAVE {
                mattes.add_flat(i as u32, reflectance(i), Rgb::splat(0.7));
                mattes.set_number(i, number(seed, i));
            }
            mattes.place_with(set, &flats);
            mattes.sample_with(set);
            for (i, (ray, hit)) in hits.iter().enumerate() {
                if let Some(uv) = flats.bare.parameters(i) {
                    let found = flats.bare.found(i).expect("a hit");
                    let expected = job.world.surface_parameters(ray, &found);
                    assert_eq!(bits(&[uv.extend(0.0)]), bits(&[expected.extend(0.0)]));
                }
                if flats.grazing(i).is_some() {
                    grazing += 1;
                    continue;
                }
                let ((p, p_error, n), wo) = flats.point(i);
                let surface = &hit.surface;
                let expected = [surface.p, surface.p_error, surface.n, -ray.d];
                assert_eq!(bits(&[p, p_error, n, wo]), bits(&expected));
                let next = mattes.next(i);
                let found =
                    next.map(|next| [next.throughput, next.o, next.d, Rgb::splat(next.pdf)]);
                let bsdf = bsdf(hit, &[diffuse(reflectance(i))]);
                let expected = step(hit, &bsdf, number(seed, i));
                assert_eq!(
                    found.map(|found| bits(&found)),
                    expected.map(|next| bits(&next))
                );
                gone_on += usize::from(expected.is_some());
            }
        }
    }
    assert!(grazing > 0 && gone_on > WAVE, "{grazing} {gone_on}");
}

fn number(seed: u64, i: usize) -> Vec2 {
    let number = |k| unit_float(mix2(seed, 1000 + 2 * i as u64 + k));
    match i {
        0 => Vec2::splat(0.5),
        1 => Vec2::ZERO,
        _ => Vec2::new(number(0), number(1)),
    }
}

#[test]
fn all_instructions_find_the_same_directions_at_coated_surfaces() {
    let (mut gone_on, mut ended) = (0, 0);
    for (text, seed) in [ROOM_WITH_LAMPS, OUTDOORS].into_iter().zip(2..) {
        let hits = flat_hits(&job(text), seed).1;
        let color = |i: usize| Rgb::new(0.1, 0.9, i as f32 / WAVE as f32);
        let coat = |i: usize| {
            Lobe::MicrofacetReflection(MicrofacetReflection {
                reflectance: color(WAVE - i),
                distribution: TrowbridgeReitz::new(0.01 * i as f32, 0.3),
                fresnel: Fresnel::Dielectric {
                    eta_i: 1.5,
                    eta_t: 1.0,
                },
            })
        };
        let bsdfs = hits.iter().zip(0..);
        let bsdfs: Vec<Bsdf> = bsdfs
            .map(|((_, hit), i)| bsdf(hit, &[diffuse(color(i)), coat(i)]))
            .collect();
        for set in InstructionSet::available() {
            let mut vertices = Vertices::<Coated, WAVE>::default();
            for (i, ((_, hit), bsdf)) in hits.iter().zip(&bsdfs).enumerate() {
                let lobes = bsdf.coated().expect("both lobes");
                let known = (&lobes, bsdf.frame());
                vertices.begin(i as u32, &hit.surface, known, Rgb::splat(0.7));
                vertices.set_number(i, number(seed, i));
            }
            vertices.finish_with(set);
            vertices.sample_with(set);
            for (i, ((_, hit), bsdf)) in hits.iter().zip(&bsdfs).enumerate() {
                let next = vertices.next(i);
                let found =
                    next.map(|next| [next.throughput, next.o, next.d, Rgb::splat(next.pdf)]);
                let expected = step(hit, bsdf, number(seed, i));
                assert_eq!(
                    found.map(|found| bits(&found)),
                    expected.map(|next| bits(&next))
                );
                gone_on += usize::from(expected.is_some());
                ended += usize::from(expected.is_none());
            }
        }
    }
    assert!(gone_on > WAVE && ended > 0, "{gone_on} {ended}");
}

fn diffuse(reflectance: Rgb) -> Lobe<'static> {
    Lobe::LambertianReflection(LambertianReflection { reflectance })
}

fn bsdf(hit: &GeometryHit, lobes: &[Lobe<'static>]) -> Bsdf<'static> {
    let mut bsdf = Bsdf::new(hit.surface.n, &hit.surface.shading);
    lobes.iter().for_each(|&lobe| bsdf.add(lobe));
    bsdf
}

/// Throughput, ray and density after BSDF sampling, by itself.
fn step(hit: &GeometryHit, bsdf: &Bsdf, u: Vec2) -> Option<[Rgb; 4]> {
    let sample = bsdf.sample(hit.surface.wo, 0.0, u)?;
    let cosine = sample.wi.dot(bsdf.shading_normal()).abs();
    let throughput = Rgb::splat(0.7) * (sample.f * (cosine / sample.pdf));
    let ray = hit.surface.spawn_ray(sample.wi);
    Some([throughput, ray.o, ray.d, Rgb::splat(sample.pdf)])
}
