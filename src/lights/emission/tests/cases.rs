//! Lights of every type under every kind of transformation.

use super::*;
use crate::assets::mesh::MeshData;
use crate::lights::{
    DiffuseAreaLight, DiffuseAreaSpec, DistantLight, DistantSpec, GoniometricLight,
    GoniometricSpec, InfiniteLight, InfiniteSpec, LightMap, ProjectionLight, ProjectionSpec,
    SpotLight, SpotSpec,
};
use crate::shapes::Form;
use crate::shapes::cone::Cone;
use crate::shapes::cylinder::Cylinder;
use crate::shapes::disk::Disk;
use crate::shapes::emitter::Emitter;
use crate::shapes::hyperboloid::Hyperboloid;
use crate::shapes::mesh::TriangleMesh;
use crate::shapes::paraboloid::Paraboloid;
use crate::shapes::quadric::Quadric;
use crate::shapes::sphere::Sphere;

/// What is known of a light.
pub(super) struct Case {
    pub(super) name: String,
    pub(super) light: Light,
    /// How far its [`Light::power`] may be from the truth, relatively.
    pub(super) power_error: f64,
    /// Light that sets out against the normal meets the emitter itself: a full sphere, seen from outside.
    pub(super) hides_its_back: bool,
    /// Seen from inside only.
    pub(super) inward: bool,
}

pub(super) fn turn() -> Transform {
    Transform::translate(DVec3::new(0.3, -0.2, 0.1))
        * Transform::rotate(50.0, DVec3::new(1.0, -1.0, 2.0))
}

/// Transformations that keep angles (with their names), and ones that do not.
pub(super) fn placements() -> Vec<(&'static str, Transform, bool)> {
    let even = |s: f64| turn() * Transform::scale(DVec3::splat(s));
    let mirror = Transform::scale(DVec3::new(1.0, -1.0, 1.0));
    let uneven = Transform::scale(DVec3::new(0.6, 1.4, -0.8));
    vec![
        ("as it is", Transform::IDENTITY, true),
        ("turned", even(1.3), true),
        ("mirrored", even(0.9) * mirror, true),
        (
            "uneven",
            turn() * uneven * Transform::rotate(30.0, DVec3::X),
            false,
        ),
    ]
}

/// Contrasts, black parts, one bright texel, sides that are no powers of two.
pub(super) fn image(width: usize, height: usize) -> Option<LightMap> {
    let texel = |i: usize| match i % 7 {
        0 | 1 => Rgb::ZERO,
        3 if i % 5 == 2 => Rgb::new(9.0, 7.0, 5.0),
        k => Rgb::new(0.3, 0.2, 0.1) * k as f32,
    };
    LightMap::new(width, height, (0..width * height).map(texel).collect())
}

/// One texel of many.
pub(super) fn lone_texel(width: usize, height: usize) -> Option<LightMap> {
    let mut texels = vec![Rgb::ZERO; width * height];
    texels[height / 2 * width + width / 3] = Rgb::new(3.0, 2.0, 1.0);
    LightMap::new(width, height, texels)
}

pub(super) fn spot(cone_angle: f64, cone_delta_angle: f64, light_to_world: Transform) -> Light {
    let spec = SpotSpec {
        light_to_world,
        from: DVec3::new(0.1, 0.0, -0.1),
        to: DVec3::new(0.2, 0.3, 1.0),
        intensity: Rgb::new(1.0, 2.0, 3.0),
        cone_angle,
        cone_delta_angle,
    };
    Light::Spot(Box::new(SpotLight::new(&spec, None, &Transform::IDENTITY)))
}

pub(super) fn projection(map: Option<LightMap>, fov: f64, light_to_world: Transform) -> Light {
    let spec = ProjectionSpec {
        light_to_world,
        intensity: Rgb::new(2.0, 1.0, 0.5),
        fov,
    };
    Light::Projection(Box::new(ProjectionLight::new(
        &spec,
        map,
        &Transform::IDENTITY,
    )))
}

pub(super) fn goniometric(map: Option<LightMap>, light_to_world: Transform) -> Light {
    let spec = GoniometricSpec {
        light_to_world,
        intensity: Rgb::new(1.0, 2.0, 3.0),
    };
    Light::Goniometric(Box::new(GoniometricLight::new(
        &spec,
        map,
        &Transform::IDENTITY,
    )))
}

pub(super) fn infinite(map: Option<LightMap>, light_to_world: Transform) -> Light {
    let spec = InfiniteSpec {
        light_to_world,
        radiance: Rgb::new(0.5, 0.4, 0.3),
        samples: 1,
    };
    Light::Infinite(Box::new(InfiniteLight::new(
        &spec,
        map,
        &Transform::IDENTITY,
    )))
}

pub(super) fn distant(light_to_world: Transform) -> Light {
    let spec = DistantSpec {
        toward: light_to_world
            .vector(DVec3::new(0.2, 0.4, -1.0))
            .normalize(),
        irradiance: Rgb::new(3.0, 2.0, 1.0),
    };
    Light::Distant(Box::new(DistantLight::new(
        &spec,
        None,
        &Transform::IDENTITY,
    )))
}

pub(super) fn point() -> Light {
    let spec = PointSpec {
        position: DVec3::new(0.3, 0.1, -0.2),
        intensity: Rgb::new(1.0, 2.0, 3.0),
    };
    Light::Point(Box::new(PointLight::new(&spec, None, &Transform::IDENTITY)))
}

/// Lights without area, under one transformation, whose images are prepared or not, with the errors of their fluxes.
pub(super) fn lights_without_area(
    transform: Transform,
    even: bool,
    prepared: bool,
) -> Vec<(String, Light, f64)> {
    let exact = 1e-5;
    // Fluxes are those of transformations that keep angles.
    let placed = |error| if even { error } else { f64::INFINITY };
    // The flux behind images is a sum over texels' centers, as these lights' own tests say.
    let image_error = placed(0.06);
    let lone = || lone_texel(8, 4);
    // Those that images prepare.
    let mut list = vec![
        (
            "projection",
            projection(None, 45.0, transform),
            placed(exact),
        ),
        (
            "slide",
            projection(image(20, 9), 70.0, transform),
            image_error,
        ),
        (
            "wide slide",
            projection(image(4, 8), 130.0, transform),
            placed(0.3),
        ),
        ("map", goniometric(image(24, 10), transform), image_error),
    ];
    if prepared {
        list.extend([
            (
                "lone slide",
                projection(lone(), 60.0, transform),
                placed(0.3),
            ),
            ("lone map", goniometric(lone(), transform), placed(0.3)),
            ("spot", spot(40.0, 15.0, transform), placed(exact)),
            ("sharp spot", spot(20.0, 0.0, transform), placed(exact)),
            ("wide spot", spot(150.0, 100.0, transform), placed(exact)),
            ("goniometric", goniometric(None, transform), exact),
            ("sky", infinite(None, transform), exact),
            ("image sky", infinite(image(24, 10), transform), image_error),
            ("lone sky", infinite(lone(), transform), placed(0.3)),
            ("distant", distant(transform), exact),
            ("point", point(), exact),
        ]);
    }
    let finish = |(name, mut light, error): (&str, Light, f64)| {
        if prepared {
            light.prepare_emission();
        }
        let prepared = if prepared { ", prepared" } else { "" };
        (format!("{name}{prepared}"), light, error)
    };
    list.into_iter().map(finish).collect()
}

pub(super) fn area_light(emitter: Emitter, two_sided: bool) -> Light {
    let spec = DiffuseAreaSpec {
        radiance: Rgb::new(3.0, 2.0, 1.0),
        two_sided,
        samples: 1,
        one_light: false,
    };
    Light::DiffuseArea(DiffuseAreaLight::new(&spec, emitter, 0))
}

/// A triangle, one whose normals change sides, and a parallelogram.
pub(super) fn meshes(transform: &Transform, reverse: bool) -> Vec<(&'static str, Emitter)> {
    let corners = [
        DVec3::new(-0.7, -0.5, 0.2),
        DVec3::new(0.9, -0.6, 0.0),
        DVec3::new(0.2, 0.8, -0.3),
        DVec3::new(-1.4, 0.9, -0.1),
    ];
    let mesh = |name, indices: Vec<[u32; 3]>, normals: Vec<Vec3>| {
        let data = MeshData {
            positions: corners.into(),
            indices,
            normals,
            ..Default::default()
        };
        let mesh = TriangleMesh::new(data, transform, reverse);
        (name, Emitter::of_mesh(&mesh).next().expect("a triangle"))
    };
    let both = vec![Vec3::Z, Vec3::Z, Vec3::NEG_Z, Vec3::Z];
    vec![
        mesh("triangle", vec![[0, 1, 2]], vec![]),
        mesh("triangle of two sides", vec![[0, 1, 2]], both),
        mesh("parallelogram", vec![[0, 1, 2], [0, 2, 3]], vec![]),
    ]
}

pub(super) fn quadrics() -> Vec<(&'static str, Form)> {
    let ends = [DVec3::new(0.6, 0.0, -0.1), DVec3::new(0.2, 0.5, 1.1)];
    vec![
        ("sphere", Form::Sphere(Sphere::new(0.9, -0.9, 0.9, 360.0))),
        (
            "part of a sphere",
            Form::Sphere(Sphere::new(1.0, -0.6, 0.8, 220.0)),
        ),
        ("disk", Form::Disk(Disk::new(0.1, 1.0, 0.3, 300.0))),
        (
            "cylinder",
            Form::Cylinder(Cylinder::new(0.7, -0.8, 0.9, 280.0)),
        ),
        ("cone", Form::Cone(Cone::new(0.8, 1.2, 360.0))),
        (
            "paraboloid",
            Form::Paraboloid(Paraboloid::new(0.8, 0.1, 1.1, 300.0)),
        ),
        (
            "hyperboloid",
            Form::Hyperboloid(Hyperboloid::new(ends[0], ends[1], 250.0).unwrap()),
        ),
    ]
}

/// Area lights under one transformation; spheres with the handedness `turned` shine inward.
pub(super) fn area_lights(transform: Transform, even: bool) -> Vec<Case> {
    let mut cases = vec![];
    for (reverse, two_sided) in [(false, false), (true, false), (false, true)] {
        let case = |name: &str, emitter, power_error, closed: bool| Case {
            name: format!("{name}, reversed {reverse}, two sides {two_sided}"),
            light: area_light(emitter, two_sided),
            power_error,
            hides_its_back: closed,
            inward: closed && !two_sided && (reverse ^ transform.swaps_handedness()),
        };
        let flat = meshes(&transform, reverse).into_iter();
        cases.extend(flat.map(|(name, emitter)| case(name, emitter, 1e-5, false)));
        for (name, form) in quadrics() {
            let emitter = Emitter::of_quadric(&Quadric::new(form, transform, reverse));
            // What uneven ones have of area is a sum over a grid.
            let error = if even { 1e-5 } else { 2e-3 };
            cases.push(case(name, emitter, error, name == "sphere" && even));
        }
    }
    cases
}

pub(super) fn cases() -> Vec<Case> {
    let mut cases = vec![];
    for (placement, transform, even) in placements() {
        for prepared in [false, true] {
            let lights = lights_without_area(transform, even, prepared).into_iter();
            cases.extend(lights.map(|(name, light, power_error)| Case {
                name,
                light,
                power_error,
                hides_its_back: false,
                inward: false,
            }));
        }
        cases.extend(area_lights(transform, even));
        for case in &mut cases {
            if !case.name.contains(':') {
                case.name = format!("{placement}: {}", case.name);
            }
        }
    }
    cases
}
