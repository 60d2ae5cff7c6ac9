//! A world made without the scene language.

use super::*;
use crate::accel::{GeometryBuilder, PrimitiveAttributes};
use crate::bsdf::Bsdf;
use crate::budget::Budget;
use crate::inputs::{FloatInput, SpectrumInput};
use crate::lights::{LightKind, LightSpec, PointSpec};
use crate::materials::{MaterialKind, Matte};
use crate::math::transform::Transform;
use crate::math::{DVec3, Vec2};
use crate::media::Media;
use crate::shapes::sphere::Sphere;
use crate::shapes::{Form, ShapeKind, ShapeSpec, Site};
use std::f32::consts::PI;

/// A gray sphere of radius 1 at the origin, and a light of intensity 8 at z = 3.
fn lit_sphere() -> World {
    let sphere = ShapeSpec {
        kind: ShapeKind::Quadric(Form::Sphere(Sphere::new(1.0, -1.0, 1.0, 360.0))),
        alpha: None,
        shadow_alpha: None,
    };
    let placed = sphere.compile(&Site {
        level_from_object: &Transform::IDENTITY,
        reverse_orientation: false,
        budget: &Budget::unlimited(),
    });
    let attributes = PrimitiveAttributes {
        material: Some(MaterialId(0)),
        ..PrimitiveAttributes::default()
    };
    let mut geometry = GeometryBuilder::default();
    geometry.add(placed.unwrap(), attributes);
    let matte = Material::without_textures(MaterialKind::Matte(Matte {
        kd: SpectrumInput::Constant(Rgb::splat(0.5)),
        sigma: FloatInput::Constant(0.0),
    }));
    let light = LightSpec {
        kind: LightKind::Point(PointSpec {
            position: DVec3::new(0.0, 0.0, 3.0),
            intensity: Rgb::splat(8.0),
        }),
        map: None,
    };
    World::new(
        geometry.build(Vec::new()).unwrap(),
        vec![matte],
        Textures::default(),
        vec![Light::new(&light, None, &Transform::IDENTITY)],
        1,
        Media::default(),
    )
}

#[test]
fn a_world_needs_no_scene_text() {
    let world = lit_sphere();
    // Light falls straight down from a distance of 2: 8 / 2² arrives, and 0.5 / π of it goes to any side.
    let expected = 0.5 / PI * 8.0 / 4.0;
    let ray = Ray::new(
        Vec3::new(0.0, 4.0, 5.0),
        Vec3::new(0.0, -1.0, -1.0).normalize(),
        0.0,
    );
    let hit = world.intersect(&ray).unwrap();
    let material = world.material(hit.material).unwrap();
    let mut bsdf = Bsdf::empty();
    world.fill_bsdf(material, &hit.surface, None, &mut bsdf);
    let from = hit.surface.reference_point();
    let sample = world.sampled_lights()[0].sample(&from, Vec2::ZERO).unwrap();
    assert!(!world.occluded(&sample.shadow));
    let (f, _) = bsdf.f_and_pdf(hit.surface.wo, sample.wi);
    let radiance = f * sample.radiance * sample.wi.dot(hit.surface.n).abs();
    assert!(
        (radiance - expected).abs().max_element() < 1e-5,
        "{radiance}"
    );
    // The other side is in shadow.
    let below = world
        .intersect(&Ray::new(Vec3::new(0.0, 0.0, -3.0), Vec3::Z, 0.0))
        .unwrap();
    let sample = world.sampled_lights()[0].sample(&below.surface.reference_point(), Vec2::ZERO);
    assert!(world.occluded(&sample.unwrap().shadow));
}
