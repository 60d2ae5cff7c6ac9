//! What is measured. Each asserts what its row claims, and returns the figures.

use super::{read, root};
use crate::common::rendering::Render;
use fstop::bsdf::fresnel_moments::FresnelMoments;
use fstop::bssrdf::{Bssrdf, NormalizedChannel, Profile, ProfileTable, TabulatedChannel};
use fstop::film::{self, Image, PixelBounds};
use fstop::math::color::luminance;
use fstop::math::frame::Frame;
use fstop::math::hash::{mix2, unit_float};
use fstop::math::motion::Motion;
use fstop::math::transform::Transform;
use fstop::math::{DVec3, Vec2, Vec3};
use fstop::surface::{ShadingGeometry, SurfaceHit};

/// Standard errors that two means may differ by: one false alarm in 15,000.
const SIGMAS: f64 = 4.0;

/// Half-width of a 95 % confidence interval in standard errors.
const CONFIDENCE: f64 = 1.96;

/// The mean luminance of an image, and its standard error.
struct Light {
    mean: f64,
    error: f64,
}

impl Light {
    /// Of the scene that looks at the origin from (0, 1.5, −3).
    fn of(sampler: &str, integrator: &str, world: &str) -> Light {
        let text = format!(
            "LookAt 0 1.5 -3  0 0 0  0 1 0\nCamera \"perspective\" \"float fov\" [40]\n\
             Film \"image\" \"integer xresolution\" [24] \"integer yresolution\" [24]\n\
             Sampler \"{sampler}\" \"integer pixelsamples\" [256]\n\
             Integrator \"{integrator}\"\nWorldBegin\n{world}\nWorldEnd\n"
        );
        let image = Render::of_text(&text, 1).image;
        Light::within(&image, image.bounds)
    }

    /// Of the part `bounds` of an image with variances.
    fn within(image: &Image, bounds: PixelBounds) -> Light {
        let variances = image.variance.as_ref().expect("variances");
        let (mut count, mut sum, mut variance) = (0.0, 0.0, 0.0);
        let pixels = image.bounds.pixels().zip(&image.pixels).zip(variances);
        for ((_, &value), v) in pixels.filter(|((pixel, _), _)| bounds.contains(*pixel)) {
            count += 1.0;
            sum += f64::from(luminance(value));
            // Channels are perfectly correlated at worst.
            variance += f64::from(v.max_element());
        }
        Light {
            mean: sum / count,
            error: f64::sqrt(variance) / count,
        }
    }

    /// This over another.
    fn over(&self, other: &Light) -> (f64, f64) {
        let ratio = self.mean / other.mean;
        let error = (self.error / self.mean).hypot(other.error / other.mean) * ratio;
        (ratio, error)
    }

    /// This over another, which has the same expectation but for the fraction `but`.
    fn equal_to(&self, other: &Light, but: f64) -> String {
        let (ratio, error) = self.over(other);
        assert!(
            self.mean > 0.0 && (ratio - 1.0).abs() <= SIGMAS * error + but,
            "{ratio} ± {error}"
        );
        format!("{ratio:.4} ± {:.4}", CONFIDENCE * error)
    }
}

const FLOOR: &str = "Material \"matte\"\nShape \"trianglemesh\" \"integer indices\" [0 1 2 0 2 3] \
    \"point P\" [-3 0 -3  3 0 -3  3 0 3  -3 0 3]\n";

/// A floor and a light above it, out of sight.
fn lit(source: &str) -> Light {
    let world = format!("{FLOOR}Translate 0 2 0\n{source}");
    Light::of("random", "directlighting", &world)
}

/// Mean ratios of a reference, as the comparison with it has measured them.
pub(super) fn mean_ratio(name: &str) -> String {
    let table = read(root().join("docs/generated/references.md"));
    let row = table
        .lines()
        .find(|line| line.starts_with(&format!("| `{name}` |")));
    let row = row.unwrap_or_else(|| panic!("no reference {name}"));
    let cell = row.split(" | ").nth(2);
    cell.expect("a cell of ratios").to_owned()
}

/// All references with the realistic camera.
pub(super) fn realistic() -> String {
    let table = read(root().join("docs/generated/references.md"));
    let rows = table.lines().filter(|l| l.starts_with("| `realistic_"));
    let ratios = rows.map(|row| row.split(" | ").nth(2).expect("a cell of ratios"));
    let off = ratios.map(|cell| {
        let numbers = cell.split(" ± ").next().unwrap_or_default().split(", ");
        let numbers = numbers.map(|n| n.parse::<f64>().expect("a ratio"));
        numbers.map(|n| (n - 1.0).abs()).fold(0.0, f64::max)
    });
    let off: Vec<f64> = off.collect();
    assert!(off.len() > 5);
    let largest = off.iter().fold(0.0f64, |a, b| a.max(*b));
    format!(
        "means within {largest:.4} of pbrt-v3's on {} references",
        off.len()
    )
}

/// The quarter of `shape_alpha` where the quad with `shadowalpha` stands and casts its shadow.
pub(super) fn shadow_holes() -> String {
    let scene = root().join("tests/scenes/reference/shape_alpha.pbrt");
    let arguments = ["--spp", "2048", "--crop", "0.5,1,0.5,1"];
    let ours = Render::new(&scene, 1, 1, &arguments).image;
    let reference = film::read(&root().join("refimages/shape_alpha.exr")).expect("a reference");
    let quarter = Light::within(&ours, ours.bounds);
    let (ratio, error) = quarter.over(&Light::within(&reference.image, ours.bounds));
    // By no more than the weights explain: with pbrt-v3's weights and density in their place the
    // difference was gone. Samples of half the sphere and of both lights make it brighter, as more is left to
    // shadow rays, which pass the holes; samples of the whole sphere and of one light made it darker by as much.
    assert!(
        (ratio - 1.0).abs() < 0.004 + SIGMAS * error,
        "{ratio} ± {error}"
    );
    format!(
        "`shape_alpha`, the quarter with its shadow: {ratio:.4} ± {:.4}",
        CONFIDENCE * error
    )
}

/// A cylinder stretched along its axis, and the same written longer.
pub(super) fn stretched_cylinder() -> String {
    let source = |scale: f32, end: f32| {
        format!(
            "Scale 1 1 {scale}\nAreaLightSource \"diffuse\" \"rgb L\" [9 9 9] \"integer samples\" [8]\n\
             Shape \"cylinder\" \"float radius\" [.2] \"float zmin\" [-{end}] \"float zmax\" [{end}]"
        )
    };
    let ratio = lit(&source(3.0, 0.3)).equal_to(&lit(&source(1.0, 0.9)), 0.0);
    format!("a cylinder's light under `Scale 1 1 3` over that of one three times as long: {ratio}")
}

/// A projector under a large scale and under none.
pub(super) fn scaled_projector() -> String {
    let source = |scale: f32| {
        format!(
            "Rotate 90 1 0 0\nScale {scale} {scale} {scale}\nLightSource \"projection\" \"float fov\" [60]"
        )
    };
    let ratio = lit(&source(5000.0)).equal_to(&lit(&source(1.0)), 1e-4);
    format!("light under a scale of 5000 over that under none: {ratio}")
}

/// pbrt-v3 blends and normalizes quaternions whose cosine is above 0.9995; the largest error of the
/// angle on the way, as a part of the whole angle.
pub(super) fn small_turns() -> String {
    let half = 0.9995f64.acos();
    let degrees = (2.0 * half).to_degrees();
    let (start, end) = (Transform::IDENTITY, Transform::rotate(degrees, DVec3::Z));
    let motion = Motion::new(&start, &end, [0.0, 1.0]).expect("a rotation");
    let mut largest = 0.0f64;
    for i in 0..=1000 {
        let t = f64::from(i) / 1000.0;
        let (x, y) = (1.0 - t + t * half.cos(), t * half.sin());
        let blended = 2.0 * y.atan2(x);
        let x = motion.at(t).transform_vector3(DVec3::X);
        let ours = x.y.atan2(x.x);
        // Even to what single turns lose in double precision.
        assert!((ours - 2.0 * half * t).abs() < 1e-12);
        largest = largest.max((blended - ours).abs() / (2.0 * half));
    }
    format!("at most {largest:.1e} of the angle")
}

/// The samplers that one stands in for, and `random`.
pub(super) fn samplers() -> String {
    let source = format!(
        "{FLOOR}LightSource \"infinite\"\nMaterial \"plastic\"\nShape \"sphere\" \"float radius\" [.8]"
    );
    let random = Light::of("random", "path", &source);
    let names = [
        "halton",
        "sobol",
        "02sequence",
        "lowdiscrepancy",
        "maxmindist",
    ];
    let texts = names.map(|name| {
        let light = Light::of(name, "path", &source);
        format!("`{name}` {}", light.equal_to(&random, 0.0))
    });
    format!("mean over that with `random`: {}", texts.join(", "))
}

/// How much brighter a ball in a white sky is by a path integrator than by one that shows boundaries only.
fn beside_its_boundary(material: &str) -> String {
    let world = format!("LightSource \"infinite\"\n{material}\nShape \"sphere\"");
    let by = |integrator: &str| Light::of("random", integrator, &world);
    let path = by("path");
    for name in ["bdpt", "mlt", "sppm"] {
        by(name).equal_to(&path, 0.0);
    }
    let (ratio, error) = path.over(&by("whitted"));
    assert!((ratio - 1.0).abs() > SIGMAS * error);
    format!(
        "{ratio:.3} ± {:.3} times as bright as its boundary",
        CONFIDENCE * error
    )
}

/// Milk.
pub(super) fn milk() -> String {
    const MILK: &str = "Material \"subsurface\" \"string name\" \"Wholemilk\" \"float scale\" [10]";
    format!(
        "a ball of milk in a white sky is {}",
        beside_its_boundary(MILK)
    )
}

/// Chalk with milk.
pub(super) fn chalk_and_milk() -> String {
    const MIXED: &str = "MakeNamedMaterial \"chalk\" \"string type\" \"matte\"\n\
        MakeNamedMaterial \"milk\" \"string type\" \"subsurface\" \"string name\" \"Wholemilk\" \
        \"float scale\" [10]\nMaterial \"mix\" \"string namedmaterial1\" \"chalk\" \
        \"string namedmaterial2\" \"milk\"";
    format!(
        "a ball of chalk and milk in a white sky is {}",
        beside_its_boundary(MIXED)
    )
}

/// A light that is an instance, above a floor.
pub(super) fn instanced_lamp() -> String {
    let source = "ObjectBegin \"light\"\nAreaLightSource \"diffuse\" \"rgb L\" [9 9 9]\n\
        Shape \"sphere\"\nObjectEnd\nObjectInstance \"light\"";
    let floor = lit(source).mean;
    assert_eq!(floor, 0.0);
    format!("a floor receives {floor} from such a light")
}

/// What pbrt-v3 loses below a ball whose radius is 50 times the longest length.
pub(super) fn below_a_ball() -> String {
    let table = ProfileTable::new(0.0, 1.33);
    let (albedos, lengths) = ([0.5, 0.9, 0.98], [0.02, 0.01, 0.005]);
    let tabulated = |c: usize| TabulatedChannel::new(table.row(albedos[c]), lengths[c], 1e-12);
    let normalized = |c: usize| NormalizedChannel::new(albedos[c], lengths[c], 1e-12);
    let tabulated = Profile::Tabulated([0, 1, 2].map(tabulated));
    let normalized = Profile::Normalized([0, 1, 2].map(normalized));
    let [tabulated, normalized] = [tabulated, normalized].map(|profile| lost(profile, &table));
    assert!(
        tabulated >= 0.0 && normalized > 1.0,
        "{tabulated}, {normalized}"
    );
    format!(
        "{tabulated:.1} % of the longest channel below `subsurface`, {normalized:.1} % below `disney`, for \
         lengths 4 : 2 : 1 on a ball of 50 lengths"
    )
}

/// What pbrt-v3 loses below the ball of `mat_kdsubsurface`.
pub(super) fn below_the_ball_of_mat_kdsubsurface() -> String {
    let table = ProfileTable::new(0.0, 1.33);
    let (colors, lengths, radius) = ([0.7, 0.4, 0.3], [0.15, 0.1, 0.08], 0.9);
    let channel = |c: usize| {
        let row = table.row(table.invert(colors[c]));
        TabulatedChannel::new(row, lengths[c] / radius, 1e-12)
    };
    let profile = Profile::Tabulated([0, 1, 2].map(channel));
    format!(
        "{:.1} % of the red light that comes out of the ball of `mat_kdsubsurface`",
        lost(profile, &table)
    )
}

/// The part of the first channel's light, in per cent, that is lost below a ball of radius 1 where the
/// densities of channels whose probes do not come as far as what is met are counted all the same.
fn lost(profile: Profile, table: &ProfileTable) -> f64 {
    const AXIS_CHANCES: [f32; 3] = [0.25, 0.25, 0.5];
    let shading = ShadingGeometry {
        n: Vec3::Z,
        dpdu: Vec3::X,
        dpdv: Vec3::Y,
        dndu: Vec3::ZERO,
        dndv: Vec3::ZERO,
    };
    let top = SurfaceHit {
        p: Vec3::ZERO,
        p_error: Vec3::ZERO,
        n: Vec3::Z,
        uv: Vec2::ZERO,
        dpdu: Vec3::X,
        dpdv: Vec3::Y,
        shading,
        wo: Vec3::Z,
        time: 0.0,
        face: 0,
    };
    let frame = Frame::from_normal_and_tangent(Vec3::Z, Vec3::X);
    let bssrdf = Bssrdf::new(&top, frame, profile, table.exit());
    let all_channels = |p: Vec3, n: Vec3| -> f32 {
        let (p, n) = (frame.to_local(p), frame.to_local(n));
        let of_axis = |axis: usize| {
            let off = Vec2::new(p[(axis + 1) % 3], p[(axis + 2) % 3]).length();
            let densities: f32 = (0..3).map(|c| profile.pdf(c, off)).sum();
            AXIS_CHANCES[axis] * n[axis].abs() * densities / 3.0
        };
        (0..3).map(of_axis).sum()
    };
    let (mut ours, mut theirs) = (0.0, 0.0);
    for i in 0..200_000 {
        let number = |j: u64| unit_float(mix2(4 * i + j, 0));
        let Some(probe) = bssrdf.probe(number(0), Vec2::new(number(1), number(2))) else {
            continue;
        };
        let center = -Vec3::Z.as_dvec3();
        let (o, d) = (probe.o.as_dvec3() - center, probe.d.as_dvec3());
        let b = o.dot(d);
        let root = (b * b - o.length_squared() + 1.0).sqrt();
        for t in [-b - root, -b + root] {
            if (0.0..=f64::from(probe.length)).contains(&t) {
                let n = o + t * d;
                let p = (center + n).as_vec3();
                let value = bssrdf.value(p).x;
                ours += f64::from(value / bssrdf.pdf(p, n.as_vec3()));
                theirs += f64::from(value / all_channels(p, n.as_vec3()));
            }
        }
    }
    100.0 * (1.0 - theirs / ours)
}

/// The largest value of the spline of `marble` in its six segments, and in the second one alone, past
/// its end, as pbrt-v3 takes it (Pharr, Jakob and Humphreys 2016, §10.6.6).
pub(super) fn marble() -> String {
    // Red of the control points, which is the largest but for blue's 0.6.
    const RED: [f64; 9] = [0.58, 0.58, 0.58, 0.5, 0.6, 0.58, 0.58, 0.2, 0.58];
    let bezier = |first: usize, t: f64| -> f64 {
        let weights = [
            (1.0 - t).powi(3),
            3.0 * t * (1.0 - t).powi(2),
            3.0 * t * t * (1.0 - t),
            t * t * t,
        ];
        let points = &RED[first..first + 4];
        1.5 * weights.iter().zip(points).map(|(w, p)| w * p).sum::<f64>()
    };
    let steps = (0..=6000).map(|i| f64::from(i) / 1000.0);
    let (mut ours, mut theirs) = (0.0f64, 0.0f64);
    for t in steps {
        let segment = (t as usize).min(5);
        ours = ours.max(bezier(segment, t - segment as f64));
        let slip = segment.min(1);
        theirs = theirs.max(bezier(slip, t - slip as f64).abs());
    }
    format!("red up to {theirs:.1} there, {ours:.2} here")
}

/// The polynomial that pbrt-v3 has for the first moment of light inside (d'Eon and Irving 2011).
pub(super) fn fresnel_polynomials() -> String {
    const FIRST: [f64; 6] = [-4.61686, 11.1136, -10.4646, 5.11455, -1.27198, 0.12746];
    let polynomial = |coefficients: &[f64], x: f64| {
        let terms = coefficients.iter().rev();
        terms.fold(0.0, |sum, c| sum * x + c)
    };
    let mut largest = 0.0f64;
    for i in 0..=70 {
        let eta = 1.1 + f64::from(i) / 100.0;
        let off = polynomial(&FIRST, eta) - FresnelMoments::inside(eta).first;
        largest = largest.max(off.abs());
    }
    assert!(largest < 0.005, "{largest}");
    format!("at most {largest:.4} of the first moment for indices from 1.1 to 1.8")
}

/// What references hold in channels that are black, as a part of the pixel's largest.
pub(super) fn black_channels() -> String {
    let folder = std::fs::read_dir(root().join("refimages")).expect("the references");
    let paths = folder.map(|entry| entry.expect("a readable entry").path());
    let pictures = paths.filter(|path| path.extension().is_some_and(|e| e == "exr"));
    let mut largest = 0.0f32;
    for path in pictures {
        let image = fstop::film::read(&path)
            .unwrap_or_else(|e| panic!("{e}"))
            .image;
        for p in &image.pixels {
            let part = p.abs().min_element() / p.abs().max_element();
            if part.is_finite() && part < 1e-6 {
                largest = largest.max(part);
            }
        }
    }
    assert!(largest > 0.0);
    format!("up to {largest:.0e} of the largest channel")
}

/// An emitter without material above a glossy floor, and one that is black.
pub(super) fn bare_emitter() -> String {
    let floor = FLOOR.replace("\"matte\"", "\"metal\" \"float roughness\" [.1]");
    let source = |material: &str| {
        let world = format!(
            "{floor}Material {material}\nAreaLightSource \"diffuse\" \"rgb L\" [5 5 5]\n\
             Translate 0 2 1\nShape \"sphere\" \"float radius\" [.5]"
        );
        Light::of("random", "volpath", &world)
    };
    let black = source("\"matte\" \"rgb Kd\" [0 0 0]");
    let ratio = source("\"none\"").equal_to(&black, 0.0);
    format!("its light over that with a black material: {ratio}")
}
