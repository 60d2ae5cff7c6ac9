use super::*;
use crate::integrators::Integrator;
use crate::math::color::luminance;
use crate::math::{DVec3, Vec3};
use crate::params::testing::read;
use crate::render::RenderJob;
use crate::samplers::{Sampler, SamplerSpec};
use crate::scene::{ReadSettings, read_scene};
use crate::syntax::SourceMap;
use proptest::prelude::*;

fn photon(p: [f32; 3]) -> Photon {
    Photon::new(p.into(), Vec3::Z, Rgb::splat(p[0]))
}

/// Coordinates with many ties, and of very different sizes.
fn points() -> impl Strategy<Value = Vec<[f32; 3]>> {
    let number = || prop_oneof![-2.0f32..2.0, (-2i8..3).prop_map(f32::from), -1e6f32..1e6];
    prop::collection::vec([number(), number(), number()], 0..200)
}

proptest! {
    /// Neither more nor fewer, whatever the radius, and each once.
    #[test]
    fn the_map_finds_the_photons_within_the_radius(
        points in points(), at in 0usize..200, exact in any::<bool>(), radius in -12.0f32..8.0
    ) {
        let photons: Vec<Photon> = points.iter().map(|&p| photon(p)).collect();
        let mut map = PhotonMap::default();
        let (first, second) = photons.split_at(photons.len() / 3);
        map.fill([first, second].into_iter());
        let p = points.get(at).map_or(Vec3::ONE, |&p| p.into());
        // At whole distances there are photons on the rim.
        let radius = if exact { 1.0 } else { radius.exp() };
        let mut found = Vec::new();
        map.visit(p, radius, |photon| found.push(photon.p.to_array()));
        let near = |q: &&[f32; 3]| p.distance_squared(Vec3::from(**q)) <= radius * radius;
        let mut expected: Vec<[f32; 3]> = points.iter().filter(near).copied().collect();
        let order = |a: &[f32; 3], b: &[f32; 3]| a.partial_cmp(b).unwrap();
        found.sort_by(order);
        expected.sort_by(order);
        prop_assert_eq!(found, expected);
    }
}

/// Many photons are sorted by several threads, to the same order.
#[test]
fn the_order_of_photons_does_not_depend_on_threads() {
    let place = |i: u64| {
        let bits = crate::math::hash::mix(i);
        [bits & 63, bits >> 8 & 255, bits >> 16 & 255].map(|x| x as f32)
    };
    let photons: Vec<Photon> = (0..40_000).map(|i| photon(place(i))).collect();
    let order = |threads| {
        let pool = { rayon::ThreadPoolBuilder::new() }.num_threads(threads);
        let mut map = PhotonMap::default();
        let fill = || map.fill(photons.chunks(999));
        pool.build().unwrap().install(fill);
        let mut order = Vec::new();
        map.visit(Vec3::ZERO, 1e9, |photon| order.push(*photon));
        order
    };
    assert!(order(1) == order(3));
}

fn job(world: &str, parameters: &str) -> RenderJob {
    job_by(&format!("Integrator \"sppm\" {parameters}"), world)
}

fn job_by(integrator: &str, world: &str) -> RenderJob {
    let sources = SourceMap::new();
    let film = "Film \"image\" \"integer xresolution\" 4 \"integer yresolution\" 4";
    let text = format!("{film} {integrator} WorldBegin {world} WorldEnd");
    let main = sources.add_text("test.pbrt", text);
    let (mut scene, read) = read_scene(&sources, main, &ReadSettings::default());
    assert!(!read.has_errors());
    let (built, _) = crate::build::build(scene.frames.pop().unwrap(), 0);
    built.unwrap().job
}

/// The photons of so many light paths.
fn photons(job: &RenderJob, paths: u64) -> Vec<Photon> {
    let mapper: Option<PhotonMapper> = Integrator::photons(&job.integrator, &job.world);
    let sampler = Sampler::new(&SamplerSpec::sobol(1), 3);
    let mut photons = Vec::new();
    for path in 0..paths {
        let mut stream = sampler.stream(Default::default(), path as u32);
        mapper
            .unwrap()
            .trace(|time| time, &mut stream, &mut photons);
    }
    photons
}

fn flux(photons: &[Photon], paths: u64) -> f64 {
    let light: f64 = { photons.iter() }
        .map(|photon| f64::from(luminance(photon.flux)))
        .sum();
    light / paths as f64
}

const LAMP: &str = "LightSource \"point\" \"color I\" [1 1 1] \"point from\" [0 0 .2] ";
const GLASS: &str = "Material \"glass\" \"float eta\" 1.5 Shape \"sphere\" \"float radius\" .5 ";

/// All that a point light emits (4π) comes through a ball of clear glass to the walls around it.
#[test]
fn glass_conserves_flux() {
    let wall = "Material \"matte\" \"color Kd\" [.01 .01 .01] Shape \"sphere\" \"float radius\" 2 ";
    let job = job(&[LAMP, wall, GLASS].concat(), "\"integer maxdepth\" 40");
    let paths = 1 << 15;
    let photons = photons(&job, paths);
    let arrived = flux(&photons, paths) / (4.0 * std::f64::consts::PI);
    // A hundredth of it comes to the walls again. Flux is the same for every path, so that the only noise is in that.
    assert!((arrived - 1.0 / 0.99).abs() < 2e-3, "{arrived}");
    let inside = |photon: &&Photon| photon.p.length() < 1.9;
    // Job's render space begins at the camera, which is at the origin.
    assert_eq!(photons.iter().filter(inside).count(), 0, "on clear glass");
}

/// Photons are those of the second surface on, up to `maxdepth`: in a closed room of albedo ρ each brings ρ times that
/// of the one before.
#[test]
fn photons_count_from_their_second_surface_on() {
    let wall = "Material \"matte\" \"color Kd\" [.5 .5 .5] Shape \"sphere\" \"float radius\" 2 ";
    let null = "Material \"none\" Shape \"sphere\" \"float radius\" 1 ";
    let world = [LAMP, wall, null].concat();
    let paths = 1 << 14;
    for (depth, expected) in [(0, 0.0), (1, 0.0), (2, 0.5), (4, 0.5 + 0.25 + 0.125)] {
        let job = job(&world, &format!("\"integer maxdepth\" {depth}"));
        let arrived = flux(&photons(&job, paths), paths) / (4.0 * std::f64::consts::PI);
        // Half of the paths end at each surface: one standard error is √(Σ p(1 − p) / paths), at most 0.005.
        assert!((arrived - expected).abs() < 0.02, "{depth}: {arrived}");
    }
}

#[test]
fn no_light_no_photons() {
    let wall = "Material \"matte\" Shape \"sphere\" \"float radius\" 2 ";
    assert!(photons(&job(wall, ""), 100).is_empty());
    assert!(photons(&job("", ""), 100).is_empty());
    assert!(photons(&job(LAMP, ""), 100).is_empty());
}

#[test]
fn the_defaults_are_pbrts() {
    let outcome = read(
        "sppm",
        "\"integer imagewritefrequency\" 7",
        Sppm::from_params,
    );
    let expected = Sppm {
        max_depth: 5,
        iterations: 64,
        photons: None,
        radius: 1.0,
    };
    assert_eq!((outcome.value, outcome.warnings), (expected, 0));
    let given = "\"integer numiterations\" 3 \"integer photonsperiteration\" 9 \"float radius\" .5";
    let outcome = read("sppm", given, Sppm::from_params);
    assert_eq!(
        (outcome.value.iterations, outcome.value.photons),
        (3, Some(9))
    );
    assert_eq!(outcome.value.radius, 0.5);
    let both = "\"integer numiterations\" 3 \"integer iterations\" 4";
    assert_eq!(read("sppm", both, Sppm::from_params).value.iterations, 4);
}

#[test]
fn what_is_no_radius_is_warned_of() {
    for (given, used) in [
        ("0", 1.0),
        ("-3", 1.0),
        ("1e-30", 1.0),
        ("nan", 1.0),
        ("1e30", 1e15),
    ] {
        let outcome = read(
            "sppm",
            &format!("\"float radius\" {given}"),
            Sppm::from_params,
        );
        assert_eq!(outcome.value.radius, used, "{given}");
        assert!(outcome.warnings + outcome.errors > 0, "{given}");
    }
    for given in ["0", "-1"] {
        let outcome = read(
            "sppm",
            &format!("\"integer iterations\" {given}"),
            Sppm::from_params,
        );
        assert_eq!((outcome.value.iterations, outcome.warnings), (1, 1));
    }
}

/// The mean of pixels, for images that are the same everywhere.
fn mean(job: &RenderJob) -> DVec3 {
    let film = crate::render::expose(job, 16, &crate::render::Progress::hidden());
    let pixels = film.pixels();
    pixels.iter().map(|pixel| pixel.mean()).sum::<DVec3>() / pixels.len() as f64
}

/// In a closed room whose walls glow with radiance 1 and have the albedo ρ there is Σ ρᵏ everywhere, one term for each scattering
/// event. In a sphere the part of the wall within the distance r of a point has the area π r² whatever r is: not even the
/// size of discs has a bias.
#[test]
fn a_furnace_glows_evenly() {
    let wall = "AreaLightSource \"diffuse\" \"color L\" [1 1 1] ReverseOrientation \
                Material \"matte\" \"color Kd\" [.6 .6 .6] Shape \"sphere\" \"float radius\" 2 ";
    for (depth, radius) in [(1, 0.5), (2, 0.5), (5, 0.25), (5, 1.5)] {
        let parameters = format!(
            "\"integer maxdepth\" {depth} \"float radius\" {radius} \"integer iterations\" 32 \
             \"integer photonsperiteration\" 2000"
        );
        let found = mean(&job(wall, &parameters)).x;
        let expected: f64 = (0..=depth).map(|k| 0.6f64.powi(k)).sum();
        // Emission and direct light, 1.6, have no noise to speak of (2e-3 of BSDF samples); what photons bring of the rest
        // comes of 16 pixels · 32 iterations of discs with at least 2000 · 1.5 · (0.25/4)² photons, 12: about 1 %.
        assert!(
            (found / expected - 1.0).abs() < 0.015,
            "{depth}: {found} for {expected}"
        );
    }
}

/// Sizes far from the scene's, and scenes with nothing in them, give images without light or numbers out of bounds.
#[test]
fn extremes_stay_finite() {
    let wall = "Material \"matte\" Shape \"sphere\" \"float radius\" 2 ";
    for radius in ["1e-15", "1e-6", "1e6", "1e15"] {
        for world in [&[LAMP, wall, GLASS].concat(), wall, ""] {
            let parameters = format!("\"float radius\" {radius} \"integer iterations\" 3");
            let found = mean(&job(world, &parameters));
            assert!(found.is_finite() && found.min_element() >= 0.0, "{found}");
        }
    }
}

/// Light that comes out of milk, onto a floor and into the camera, is that which a path tracer finds.
#[test]
fn milk_lights_its_surroundings() {
    let world = "LightSource \"point\" \"point from\" [0 1.2 -.8] \"color I\" [1 1 1] \
        Material \"matte\" \"color Kd\" [.8 .8 .8] Shape \"sphere\" \"float radius\" 2 \
        Material \"subsurface\" \"string name\" \"Wholemilk\" \"float scale\" [10] \
        Translate 0 0 1 Shape \"sphere\" \"float radius\" .7";
    let photons = job(
        world,
        "\"integer photonsperiteration\" 8000 \"integer iterations\" 64 \"float radius\" .28 \
         \"integer maxdepth\" 12",
    );
    let path = "Integrator \"path\" \"integer maxdepth\" 12 \
                Sampler \"random\" \"integer pixelsamples\" 8192";
    let ratio = mean(&photons).x / mean(&job_by(path, world)).x;
    // Six seeds scatter by 4 %, as few photons enter the ball where it is seen; discs are smaller than the gap around it. Most
    // of the light is photons': without the 1/η² of either boundary it would be half or double.
    assert!((ratio - 1.0).abs() < 0.1, "{ratio}");
}
