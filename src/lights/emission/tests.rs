//! The laws of emission, for every type of light under every kind of transformation: fluxes, densities, and that
//! light which leaves its source is the light that arrives elsewhere.

use super::*;
use crate::assets::mesh::MeshData;
use crate::handles::LightId;
use crate::lights::{
    DiffuseAreaLight, DiffuseAreaSpec, DistantLight, DistantSpec, EmissionGuide, EmitterChoice,
    GoniometricLight, GoniometricSpec, InfiniteLight, InfiniteSpec, Light, LightMap, PointLight,
    PointSpec, ProjectionLight, ProjectionSpec, SpotLight, SpotSpec, place_of_ray,
};
use crate::math::DVec3;
use crate::math::adaptive_density::{AdaptiveDensity, Found};
use crate::math::hash::{mix2, unit_float};
use crate::math::sampling::uniform_sphere;
use crate::math::transform::Transform;
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
struct Case {
    name: String,
    light: Light,
    /// How far its [`Light::power`] may be from the truth, relatively.
    power_error: f64,
    /// Light that sets out against the normal meets the emitter itself: a full sphere, seen from outside.
    hides_its_back: bool,
    /// Seen from inside only.
    inward: bool,
}

const SCENE: SceneSphere = SceneSphere {
    center: Vec3::new(0.1, -0.2, 0.3),
    radius: 6.0,
};

/// Two random numbers; `stream` tells the uses apart.
fn random(i: u64, stream: u64) -> Vec2 {
    let number = |k| unit_float(mix2(i, 2 * stream + k));
    Vec2::new(number(0), number(1))
}

/// What is wrong with one case goes to the list of what is wrong with all.
macro_rules! check {
    ($failed:ident, $holds:expr, $($message:tt)+) => {
        let holds: bool = $holds;
        if !holds {
            $failed.push(format!($($message)+));
        }
    };
}

/// A mean with its standard error.
#[derive(Default)]
struct Mean {
    n: f64,
    sum: f64,
    squares: f64,
}

impl Mean {
    fn add(&mut self, value: f64) {
        self.n += 1.0;
        self.sum += value;
        self.squares += value * value;
    }

    fn value(&self) -> f64 {
        self.sum / self.n
    }

    fn error(&self) -> f64 {
        let variance = self.squares / self.n - self.value() * self.value();
        (variance.max(0.0) / self.n).sqrt()
    }
}

fn total(rgb: Rgb) -> f64 {
    rgb.as_dvec3().element_sum()
}

fn turn() -> Transform {
    Transform::translate(DVec3::new(0.3, -0.2, 0.1))
        * Transform::rotate(50.0, DVec3::new(1.0, -1.0, 2.0))
}

/// Transformations that keep angles (with their names), and ones that do not.
fn placements() -> Vec<(&'static str, Transform, bool)> {
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
fn image(width: usize, height: usize) -> Option<LightMap> {
    let texel = |i: usize| match i % 7 {
        0 | 1 => Rgb::ZERO,
        3 if i % 5 == 2 => Rgb::new(9.0, 7.0, 5.0),
        k => Rgb::new(0.3, 0.2, 0.1) * k as f32,
    };
    LightMap::new(width, height, (0..width * height).map(texel).collect())
}

/// One texel of many.
fn lone_texel(width: usize, height: usize) -> Option<LightMap> {
    let mut texels = vec![Rgb::ZERO; width * height];
    texels[height / 2 * width + width / 3] = Rgb::new(3.0, 2.0, 1.0);
    LightMap::new(width, height, texels)
}

fn spot(cone_angle: f64, cone_delta_angle: f64, light_to_world: Transform) -> Light {
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

fn projection(map: Option<LightMap>, fov: f64, light_to_world: Transform) -> Light {
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

fn goniometric(map: Option<LightMap>, light_to_world: Transform) -> Light {
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

fn infinite(map: Option<LightMap>, light_to_world: Transform) -> Light {
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

fn distant(light_to_world: Transform) -> Light {
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

fn point() -> Light {
    let spec = PointSpec {
        position: DVec3::new(0.3, 0.1, -0.2),
        intensity: Rgb::new(1.0, 2.0, 3.0),
    };
    Light::Point(Box::new(PointLight::new(&spec, None, &Transform::IDENTITY)))
}

/// Lights without area, under one transformation, whose images are prepared or not, with the errors of their fluxes.
fn lights_without_area(
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

fn area_light(emitter: Emitter, two_sided: bool) -> Light {
    let spec = DiffuseAreaSpec {
        radiance: Rgb::new(3.0, 2.0, 1.0),
        two_sided,
        samples: 1,
        one_light: false,
    };
    Light::DiffuseArea(DiffuseAreaLight::new(&spec, emitter, 0))
}

/// A triangle, one whose normals change sides, and a parallelogram.
fn meshes(transform: &Transform, reverse: bool) -> Vec<(&'static str, Emitter)> {
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

fn quadrics() -> Vec<(&'static str, Form)> {
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
fn area_lights(transform: Transform, even: bool) -> Vec<Case> {
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

fn cases() -> Vec<Case> {
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

fn reference(p: Vec3) -> ReferencePoint {
    ReferencePoint {
        p,
        p_error: Vec3::ZERO,
        n: Vec3::ZERO,
        time: 0.0,
        receiver_side: Default::default(),
    }
}

/// A ray tells where a light without area is.
fn place(light: &Light) -> Vec3 {
    let ray = (0..1000).find_map(|i| light.emit(&SCENE, Vec2::ZERO, random(i, 9)));
    ray.map_or(Vec3::NAN, |ray| ray.p)
}

/// What a light without area sends in the direction `d` of its rays, through [`Light::sample`] or [`Light::escaped`].
fn shining(light: &Light, place: Vec3, d: Vec3) -> Rgb {
    if light.is_at_infinity() {
        return light.escaped(-d);
    }
    // The distance is 1 but for rounding.
    let sample = light.sample(&reference(place + d), Vec2::ZERO);
    sample.map_or(Rgb::ZERO, |s| s.radiance)
}

/// The integral of that over all directions.
fn flux_by_directions(light: &Light) -> f64 {
    let side = 512;
    let place = place(light);
    let mut sum = 0.0;
    for i in 0..side * side {
        let corner = Vec2::new((i % side) as f32, (i / side) as f32);
        let d = uniform_sphere((corner + random(i, 1)) / side as f32);
        sum += total(shining(light, place, d));
    }
    let sphere = 4.0 * std::f64::consts::PI / (side * side) as f64;
    let disk = match light.is_at_infinity() {
        true => std::f64::consts::PI * f64::from(SCENE.radius * SCENE.radius),
        false => 1.0,
    };
    sum * sphere * disk
}

#[test]
fn rays_bring_the_flux_of_their_light() {
    let mut failed = vec![];
    for case in cases() {
        let mut mean = Mean::default();
        for i in 0..20_000 {
            let emission = case.light.emit(&SCENE, random(i, 2), random(i, 3));
            mean.add(emission.map_or(0.0, |e| total(e.flux())));
        }
        let power = total(case.light.power(SCENE.radius));
        let off = (mean.value() - power).abs();
        // Five standard errors: one false alarm in a million cases.
        let noise = 5.0 * mean.error();
        check!(
            failed,
            off <= noise + case.power_error * power,
            "{}: {} ± {} but {power}",
            case.name,
            mean.value(),
            mean.error()
        );
        if matches!(case.light, Light::DiffuseArea(_) | Light::Distant(_)) {
            continue;
        }
        let expected = flux_by_directions(&case.light);
        // A jittered grid of 512² points over functions with edges: the narrowest light with a sharp one has 3 % of the
        // sphere, with some 300 of its 8000 points at the edge, each off by half, by chance: 0.1 %. A few times that, for
        // the steps of interpolation.
        check!(
            failed,
            (mean.value() - expected).abs() <= noise + 6e-3 * expected,
            "{}: {} ± {} but {expected}",
            case.name,
            mean.value(),
            mean.error()
        );
        // All have some, to which the noise is small.
        check!(
            failed,
            expected > 0.0 && mean.error() < 0.05 * expected,
            "{}",
            case.name
        );
    }
    assert!(failed.is_empty(), "{failed:#?}");
}

/// The density of each ray is what is said of it afterwards.
#[test]
fn rays_carry_their_density() {
    let mut failed = vec![];
    for case in cases() {
        let (mut rays, mut agree) = (0, 0);
        for i in 0..2000 {
            let Some(emission) = case.light.emit(&SCENE, random(i, 4), random(i, 5)) else {
                continue;
            };
            let EmissionDensity {
                position,
                direction,
            } = case.light.emission_density(&SCENE, emission.n, emission.d);
            rays += 1;
            // Normals are rounded; angles of image skies lose a few 1e-6 over sin θ.
            let same = |a: f32, b: f32| (a / b - 1.0).abs() < 1e-3;
            agree += i32::from(
                same(position, emission.density.position)
                    && same(direction, emission.density.direction),
            );
            assert!((emission.d.length() - 1.0).abs() < 1e-5);
            let on_surface = matches!(case.light, Light::DiffuseArea(_));
            assert_eq!(emission.n != Vec3::ZERO, on_surface);
            let (ray, side) = (emission.ray(0.5), emission.n.dot(emission.d).signum());
            let above = side * (ray.o - emission.p).dot(emission.n);
            assert!(ray.time == 0.5 && ray.d == emission.d && (above > 0.0) == on_surface);
            if case.light.is_at_infinity() {
                let out = (emission.p - SCENE.center).length() / SCENE.radius;
                check!(failed, out > 1.0 && out < 1.5, "{}: {out}", case.name);
            }
        }
        // All but those that rounding moves over a cell's border.
        check!(
            failed,
            agree >= rays - 10 && rays > 1000,
            "{}: {agree} of {rays}",
            case.name
        );
    }
    assert!(failed.is_empty(), "{failed:#?}");
}

/// Directions in the frame of the normal.
const BINS: [usize; 2] = [16, 32];

fn bin(d: Vec3) -> usize {
    let height = ((1.0 - d.z) * 0.5 * BINS[0] as f32) as usize;
    let turn = (crate::lights::turns(d.x, d.y) * BINS[1] as f32) as usize;
    height.min(BINS[0] - 1) * BINS[1] + turn.min(BINS[1] - 1)
}

#[test]
fn directions_follow_their_density() {
    let mut failed = vec![];
    for case in cases() {
        if matches!(case.light, Light::Distant(_)) {
            continue;
        }
        let is_area = matches!(case.light, Light::DiffuseArea(_));
        let n = 20_000;
        let (mut observed, mut expected) = (vec![0.0; 512], vec![0.0; 512]);
        for i in 0..n {
            if let Some(e) = case.light.emit(&SCENE, random(i, 6), random(i, 7)) {
                let local = match is_area {
                    true => Frame::from_normal(e.n).to_local(e.d),
                    false => e.d,
                };
                observed[bin(local)] += 1.0;
            }
        }
        let mut all = 0.0;
        // 14² points in each bin, each somewhere in its square: edges may run along the grid.
        let grid = [14 * BINS[0], 14 * BINS[1]];
        let each = 4.0 * std::f64::consts::PI / (grid[0] * grid[1]) as f64;
        let normal = if is_area { Vec3::Z } else { Vec3::ZERO };
        let place = place(&case.light);
        for i in 0..grid[0] * grid[1] {
            let corner = Vec2::new((i / grid[1]) as f32, (i % grid[1]) as f32);
            let at = corner + random(i as u64, 20);
            let d = uniform_sphere(at / Vec2::new(grid[0] as f32, grid[1] as f32));
            let density = case.light.emission_density(&SCENE, normal, d).direction;
            let density = f64::from(density) * each;
            all += density;
            // What is chosen where the light is black is no ray.
            if is_area || total(shining(&case.light, place, d)) > 0.0 {
                expected[bin(d)] += density * n as f64;
            }
        }
        // A grid of a hundred thousand points over steps and edges; see above.
        check!(failed, (all - 1.0).abs() < 5e-3, "{}: {all}", case.name);
        let (mut rest, mut chi2, mut degrees) = ([0.0; 2], 0.0, 0.0);
        for (o, e) in observed.iter().zip(&expected) {
            if *e < 20.0 {
                rest = [rest[0] + o, rest[1] + e];
            } else {
                chi2 += (o - e) * (o - e) / e;
                degrees += 1.0;
            }
        }
        let off: f64 = rest[0] - rest[1];
        check!(
            failed,
            off.abs() < 5.0 * rest[1].sqrt() + 5.0,
            "{}: {rest:?}",
            case.name
        );
        // Wilson and Hilferty's quantile of chi-square for one false alarm in a million; expected counts, good to 0.7
        // percent (as 20² points in a bin are to 0.5), add 5e-5 × n at most: 1.
        let k = 2.0 / (9.0 * degrees);
        let quantile = degrees * (1.0 - k + 4.75 * f64::sqrt(k)).powi(3);
        check!(
            failed,
            chi2 < quantile + 1.0,
            "{}: {chi2} over {degrees}",
            case.name
        );
    }
    assert!(failed.is_empty(), "{failed:#?}");
}

/// A disk that light falls on, from either side.
struct Target {
    center: Vec3,
    normal: Vec3,
    radius: f32,
}

impl Target {
    fn outside() -> [Target; 4] {
        [
            [0.0, 0.2, 3.0],
            [-2.9, 0.5, 0.3],
            [0.4, 3.0, -0.6],
            [0.5, -2.0, -2.0],
        ]
        .map(|p| Target {
            center: Vec3::from_array(p),
            normal: (Vec3::from_array(p) + Vec3::splat(0.5)).normalize(),
            radius: 1.5,
        })
    }

    fn inside() -> [Target; 1] {
        [Target {
            center: Vec3::new(0.3, -0.2, 0.1) * 0.5,
            normal: Vec3::new(0.6, 0.0, 0.8),
            radius: 0.3,
        }]
    }

    /// Before a light at a point, which may shine past all others.
    fn in_the_beam(light: &Light) -> Option<Target> {
        let ray = (0..1000).find_map(|i| light.emit(&SCENE, Vec2::ZERO, random(i, 8)))?;
        let at_point = !light.is_at_infinity() && ray.n == Vec3::ZERO;
        at_point.then(|| Target {
            center: ray.p + 2.0 * ray.d,
            normal: ray.d,
            radius: 1.0,
        })
    }

    /// Flux that falls on it, by light sampling, from one point.
    fn arriving(&self, light: &Light, u: Vec2, u_light: Vec2) -> f64 {
        let on_disk = concentric_disk(u).extend(0.0);
        let p = self.center + self.radius * Frame::from_normal(self.normal).to_world(on_disk);
        let area = f64::from(PI * self.radius * self.radius);
        light.sample(&reference(p), u_light).map_or(0.0, |s| {
            total(s.radiance) * f64::from(s.wi.dot(self.normal).abs() / s.pdf) * area
        })
    }

    fn is_hit(&self, emission: &Emission) -> bool {
        let t = (self.center - emission.p).dot(self.normal) / emission.d.dot(self.normal);
        t > 0.0 && (emission.p + t * emission.d - self.center).length() < self.radius
    }
}

#[test]
fn light_that_leaves_is_light_that_arrives() {
    let mut failed = vec![];
    for case in cases() {
        let mut targets: Vec<_> = match case.inward {
            true => Target::inside().into(),
            false => Target::outside().into(),
        };
        targets.extend(Target::in_the_beam(&case.light));
        let mut precise = false;
        let n = 40_000;
        let mut leaving: Vec<Mean> = targets.iter().map(|_| Mean::default()).collect();
        for i in 0..n {
            let emission = case.light.emit(&SCENE, random(i, 10), random(i, 11));
            let visible = |e: &Emission| !(case.hides_its_back && e.n.dot(e.d) < 0.0);
            let emission = emission.filter(visible);
            for (target, mean) in targets.iter().zip(&mut leaving) {
                let hit = emission.filter(|e| target.is_hit(e));
                mean.add(hit.map_or(0.0, |e| total(e.flux())));
            }
        }
        for (k, (target, leaving)) in targets.iter().zip(&leaving).enumerate() {
            let mut arriving = Mean::default();
            for i in 0..n {
                arriving.add(target.arriving(&case.light, random(i, 12), random(i, 13)));
            }
            let error = leaving.error().hypot(arriving.error());
            let largest = arriving.value().max(leaving.value());
            // Four standard errors, in some 600 comparisons of fixed random numbers; what is met by a handful of rays has no
            // normal distribution, and is left to the other targets.
            let off = (leaving.value() - arriving.value()).abs();
            check!(
                failed,
                off <= 4.0 * error + 1e-5 * largest || error > 0.2 * largest,
                "{} {k}: {} ± {} leaves, {} ± {} arrives",
                case.name,
                leaving.value(),
                leaving.error(),
                arriving.value(),
                arriving.error()
            );
            precise |= error < 0.05 * largest;
        }
        check!(failed, precise, "{}", case.name);
    }
    assert!(failed.is_empty(), "{failed:#?}");
}

/// A guide that has learned where rays come near to a point.
fn guide_to(light: &Light, target: &Target) -> Option<EmissionGuide> {
    let n = 20_000;
    let found = (0..n).filter_map(|i| {
        let e = light.emit(&SCENE, random(i, 30), random(i, 31))?;
        let at = place_of_ray(light, &SCENE, e.p, e.d);
        let square = if target.is_hit(&e) {
            total(e.flux())
        } else {
            0.0
        };
        (square > 0.0).then_some(Found { at, square })
    });
    let mut found: Vec<Found> = found.collect();
    AdaptiveDensity::new(&mut found, n as usize).map(EmissionGuide::new)
}

/// Light falls on a disk in the same way whether rays are guided to it, past it or not at all, and each carries its density.
#[test]
fn guides_change_the_noise_alone() {
    let mut failed = vec![];
    let (mut guides, mut gains) = (0, 0);
    for case in cases().into_iter().filter(|case| !case.inward) {
        let light = &case.light;
        let mut targets = Vec::from(Target::outside());
        targets.extend(Target::in_the_beam(light));
        let Some((guide, aim)) = { targets.iter().enumerate() }
            .find_map(|(i, target)| Some((guide_to(light, target)?, i)))
        else {
            continue;
        };
        guides += 1;
        let mut means: Vec<[Mean; 2]> = targets.iter().map(|_| Default::default()).collect();
        for i in 0..8_000 {
            let (u, v) = (random(i, 32), random(i, 33));
            let guided = guide.emit(light, &SCENE, u, v);
            if let Some(e) = &guided {
                // Farther along the ray, where the first surface may be.
                let p = e.p + 3.0 * e.d;
                let alone = light.emission_density(&SCENE, e.n, e.d);
                let again = guide.mixed(light, &SCENE, alone, p, e.d);
                // As in `rays_carry_their_density`; but for rays at the border of two cells.
                let same = |a: f32, b: f32| (a / b - 1.0).abs() < 1e-3;
                let agree = same(again.position, e.density.position)
                    && same(again.direction, e.density.direction);
                check!(
                    failed,
                    agree || i % 50 == 0,
                    "{} {i}: {again:?} {:?}",
                    case.name,
                    e.density
                );
            }
            let alone = light.emit(&SCENE, u, v);
            let visible = |e: &Emission| !(case.hides_its_back && e.n.dot(e.d) < 0.0);
            for (target, means) in targets.iter().zip(&mut means) {
                for (emission, mean) in [alone, guided].iter().zip(means) {
                    let hit = emission.filter(|e| visible(e) && target.is_hit(e));
                    mean.add(hit.map_or(0.0, |e| total(e.flux())));
                }
            }
        }
        for (k, [alone, guided]) in means.iter().enumerate() {
            let error = alone.error().hypot(guided.error());
            let off = (alone.value() - guided.value()).abs();
            // As in `light_that_leaves_is_light_that_arrives`.
            check!(
                failed,
                off <= 4.0 * error || error > 0.2 * alone.value(),
                "{} {k}: {} ± {} alone, {} ± {} guided",
                case.name,
                alone.value(),
                alone.error(),
                guided.value(),
                guided.error()
            );
        }
        let [alone, guided] = &means[aim];
        gains += i32::from(guided.error() < alone.error());
    }
    assert!(failed.is_empty(), "{failed:#?}");
    // A guide from noise does not serve every light: a wide sky, and lights whose every ray comes there.
    assert!(
        guides > 50 && 10 * gains > 8 * guides,
        "{gains} of {guides}"
    );
}

/// Where on the light a sample came from.
#[test]
fn samples_know_their_end() {
    let mut failed = vec![];
    for case in cases() {
        for i in 0..200 {
            let from = reference(Vec3::new(0.2, 2.5, 1.5) * random(i, 14).x);
            let u = random(i, 15);
            let sample = case.light.sample(&from, u);
            let Some((again, end)) = case.light.sample_with_end(&from, u) else {
                assert!(sample.is_none());
                continue;
            };
            let sample = sample.unwrap();
            assert_eq!((sample.wi, sample.pdf), (again.wi, again.pdf));
            assert_eq!(sample.radiance, again.radiance);
            if !case.light.is_at_infinity() {
                // Single-precision coordinates of some units.
                let away = end.p - from.p;
                let off = (away.normalize() - sample.wi).length();
                check!(
                    failed,
                    off < 1e-6 + 1e-6 / away.length(),
                    "{}: {off}",
                    case.name
                );
            }
            let on_surface = matches!(case.light, Light::DiffuseArea(_));
            assert_eq!(end.n.length() > 0.5, on_surface, "{}", case.name);
        }
    }
    assert!(failed.is_empty(), "{failed:#?}");
}

/// Every ray of a light that is sampled exactly represents all of its flux.
#[test]
fn what_can_be_exact_is() {
    let even = placements().into_iter().filter(|(_, _, even)| *even);
    for (placement, transform, _) in even {
        let white = LightMap::new(8, 4, vec![Rgb::ONE; 32]);
        // Probabilities of about 1/64 are in steps of a 65535th, twice: up to a percent; and cells of a 64th of the
        // projector's side get darker toward the corners by some percent.
        for (name, mut light, spread) in [
            ("spot", spot(40.0, 15.0, transform), 1e-4),
            ("wide spot", spot(150.0, 100.0, transform), 1e-4),
            ("projection", projection(None, 45.0, transform), 0.06),
            ("even map", goniometric(white, transform), 0.015),
        ] {
            light.prepare_emission();
            let rays = (0..1000).filter_map(|i| light.emit(&SCENE, Vec2::ZERO, random(i, 16)));
            for ray in rays {
                let off = total(ray.flux()) / total(light.power(1.0)) - 1.0;
                assert!(off.abs() < spread, "{placement} {name}: {off}");
            }
        }
    }
}

/// A map that is dark but for a spot costs few rays.
#[test]
fn images_are_followed() {
    for light in [
        goniometric(lone_texel(32, 16), turn()),
        projection(lone_texel(32, 16), 60.0, turn()),
    ] {
        let moment = |light: &Light| {
            let mut mean = Mean::default();
            for i in 0..20_000 {
                let emission = light.emit(&SCENE, Vec2::ZERO, random(i, 17));
                mean.add(emission.map_or(0.0, |e| total(e.flux())));
            }
            mean.squares / mean.n / (mean.value() * mean.value())
        };
        let mut prepared = light.clone();
        prepared.prepare_emission();
        // 1 is perfect. Cells are a quarter of a texel's peak across.
        assert!(moment(&prepared) < 1.5, "{}", moment(&prepared));
        assert!(moment(&light) > 30.0, "{}", moment(&light));
    }
}

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

#[test]
fn lights_are_chosen_by_power() {
    let lights: Vec<Light> = cases().into_iter().map(|case| case.light).collect();
    for lights in [&lights[..], &lights[..1], &[]] {
        for radius in [0.0, 6.0, 1e20, f32::INFINITY] {
            let choice = EmitterChoice::new(lights, radius);
            let pmfs = (0..lights.len()).map(|i| choice.pmf(LightId(i as u32)));
            let sum: f64 = pmfs.map(f64::from).sum();
            // Some hundred single-precision probabilities.
            assert!((sum - 1.0).abs() < 1e-5 || lights.is_empty(), "{sum}");
            assert_eq!(choice.pmf(LightId(lights.len() as u32)), 0.0);
            let n = 1 << 16;
            let mut counts = vec![0.0; lights.len()];
            for i in 0..n {
                let Some((light, pmf, rest)) = choice.sample((i as f32 + 0.5) / n as f32) else {
                    assert!(lights.is_empty());
                    continue;
                };
                assert_eq!(pmf, choice.pmf(light));
                assert!(pmf > 0.0 && (0.0..1.0).contains(&rest));
                counts[light.index()] += 1.0;
            }
            for (i, count) in counts.into_iter().enumerate() {
                // Equally spaced numbers: off by one at each end.
                let expected = choice.pmf(LightId(i as u32)) * n as f32;
                assert!((count - expected).abs() <= 2.0, "{i}: {count} {expected}");
            }
        }
    }
}
