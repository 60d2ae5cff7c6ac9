//! Numbers of any size, and lights that bring nothing.

use super::*;

#[test]
fn numbers_of_any_size_do_no_harm() {
    let sizes = [1e-15, 1e-6, 1.0, 1e6, 1e15];
    let mut found = 0;
    for a in sizes {
        for b in sizes {
            let moved = Transform::translate(DVec3::new(b, -b, 0.5 * b)) * turn();
            let scaled = [
                DVec3::splat(a),
                DVec3::new(a, b, 1.0),
                DVec3::new(1.0, a, 1.0),
            ];
            for scale in scaled {
                let transform = moved * Transform::scale(scale);
                let mut lights: Vec<Light> = (lights_without_area(transform, false, true)
                    .into_iter())
                .map(|(_, light, _)| light)
                .collect();
                lights.extend(area_lights(transform, false).into_iter().map(|c| c.light));
                let scene = SceneSphere {
                    center: Vec3::splat(b as f32),
                    radius: a as f32,
                };
                for (k, light) in lights.iter().enumerate() {
                    for i in 0..10 {
                        let e = light.emit(&scene, random(i, 18), random(i, 19));
                        let Some(e) = e else { continue };
                        found += 1;
                        let densities = light.emission_density(&scene, e.n, e.d);
                        let all = [e.density, densities];
                        assert!(
                            all.iter()
                                .all(|d| d.position.is_finite() && d.direction.is_finite())
                                && e.density.position > 0.0
                                && e.density.direction > 0.0
                                && e.p.is_finite()
                                && (e.d.length() - 1.0).abs() < 1e-5
                                && e.p_error.is_finite()
                                && e.light.is_finite(),
                            "{a} {b} {k}: {e:?}"
                        );
                    }
                }
            }
        }
    }
    // Most of 75 × 45 × 10.
    assert!(found > 20_000, "{found}");
}

#[test]
fn black_lights_and_none_bring_nothing() {
    let mut spec = PointSpec {
        position: DVec3::ZERO,
        intensity: Rgb::ZERO,
    };
    let light = |spec: &PointSpec| {
        Light::Point(Box::new(PointLight::new(spec, None, &Transform::IDENTITY)))
    };
    assert!(light(&spec).emit(&SCENE, Vec2::ZERO, Vec2::ZERO).is_none());
    spec.intensity = Rgb::new(f32::INFINITY, 0.0, 1.0);
    assert!(light(&spec).emit(&SCENE, Vec2::ZERO, Vec2::ZERO).is_none());
    assert!(
        spot(0.0, 0.0, Transform::IDENTITY)
            .emit(&SCENE, Vec2::ZERO, Vec2::splat(0.5))
            .is_none()
    );
    for radius in [0.0, f32::INFINITY, f32::NAN] {
        let scene = SceneSphere { radius, ..SCENE };
        for light in [infinite(None, turn()), distant(turn())] {
            assert!(
                light
                    .emit(&scene, Vec2::splat(0.3), Vec2::splat(0.4))
                    .is_none()
            );
            let density = light.emission_density(&scene, Vec3::ZERO, Vec3::X);
            assert_eq!(density.position, 0.0);
        }
    }
}
