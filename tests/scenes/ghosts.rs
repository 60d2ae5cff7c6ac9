//! Ghosts of a realistic camera's lens (docs/camera.md), against quadratures and against a lens of real glass in the scene.

use fstop::build::build;
use fstop::film::Film;
use fstop::glam::DVec3;
use fstop::optics::ghosts::Ghosts;
use fstop::optics::{Lens, LensRay, Prescription};
use fstop::render::{Progress, RenderJob, TILE_SIZE, expose};
use fstop::scene::{ReadSettings, read_scene};
use fstop::syntax::SourceMap;
use std::f64::consts::PI;
use std::fmt::Write as _;
use std::path::Path;

/// What the scene is rendered by; `lens` is the text of its file `LENS`.
fn job(text: &str, lens: &str, seed: u64) -> RenderJob {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join("lens.dat");
    std::fs::write(&path, lens).expect("room for a lens");
    let text = text.replace("LENS", &path.display().to_string());
    let sources = SourceMap::new();
    let file = sources.add_text("scene", text);
    let (scene, said) = read_scene(&sources, file, &ReadSettings::default());
    assert!(!said.has_errors());
    let frame = scene.frames.into_iter().next().expect("a frame");
    build(frame, seed).0.expect("a scene that can be built").job
}

fn pixels(film: &Film) -> Vec<DVec3> {
    film.pixels().iter().map(|pixel| pixel.mean()).collect()
}

/// The picture and its ghosts, pixel by pixel: camera samples are the same without them.
fn parts(mut job: RenderJob) -> [Vec<DVec3>; 2] {
    let all = pixels(&expose(&job, TILE_SIZE, &Progress::hidden()));
    assert!(job.ghosts.take().is_some());
    let picture = pixels(&expose(&job, TILE_SIZE, &Progress::hidden()));
    let ghosts = all
        .iter()
        .zip(&picture)
        .map(|(all, picture)| *all - *picture);
    [ghosts.collect(), picture]
}

fn mean(pixels: &[DVec3]) -> DVec3 {
    pixels.iter().sum::<DVec3>() / pixels.len() as f64
}

/// A cemented doublet behind its stop.
const DOUBLET: &str = "0 3 0 12\n40 6 1.62 20\n-30 2 1.7 20\n-150 60 1 20\n";

/// The doublet at the film distance of its file, in front of six pixels, mm; a pixel is an irradiance.
fn by_doublet(world: &str, more: &str) -> String {
    format!(
        "Film \"image\" \"integer xresolution\" 3 \"integer yresolution\" 2\n\
         Camera \"realistic\" \"string specfile\" \"LENS\" \"float filmdistance\" 60 \"float aperture_diameter\" 12\n\
         \"float filmdiag\" 36.06 \"bool ghosts\" \"true\" {more}\n\
         PixelFilter \"box\" Sampler \"random\" \"integer pixelsamples\" 20000 Integrator \"path\"\n\
         WorldBegin\n{world}\nWorldEnd\n"
    )
}

/// A white sky: the mean irradiance is the étendue of all rays that a pair of reflections takes to the film, each with its share, over the
/// film's area.
#[test]
fn ghosts_of_a_white_sky_are_an_integral_over_rays() {
    let prescription = Prescription::parse(DOUBLET).unwrap();
    let lens = Lens::new(&prescription, 60.0).unwrap();
    let ghosts = Ghosts::new(lens.clone(), None);
    let (front, size) = (lens.surfaces()[0], [30.0, 20.0]);
    let radius = front.clear_radius();
    let pairs: Vec<_> = ghosts.pairs().collect();
    assert_eq!(pairs.len(), 3);
    let (mut sum, mut squares) = (0.0, 0.0);
    let count = 1 << 18;
    for i in 0..count {
        // Four coordinates of the R sequence (Roberts 2018): a point of the stop, which is flat, and a direction by its cosine.
        let r = |k: i32| (0.5 + f64::from(i + 1) / 1.167_303_978_261_418_7f64.powi(k)).fract();
        let disk = |u: f64, v: f64| {
            let (sin, cos) = (2.0 * PI * v).sin_cos();
            [u.sqrt() * cos, u.sqrt() * sin]
        };
        let ([x, y], [l, m]) = (disk(r(1), r(2)), disk(r(3), r(4)));
        let d = [l, m, (1.0 - l * l - m * m).max(0.0).sqrt()];
        let ray = LensRay::new([radius * x, radius * y, 0.0], d);
        let lands = |pair: &(usize, usize)| {
            let arrival = ghosts.trace(&ray, *pair)?;
            let [x, y] = arrival.film;
            let inside = x.abs() <= 0.5 * size[0] && y.abs() <= 0.5 * size[1];
            inside.then_some(arrival.light[0])
        };
        let light: f64 = pairs.iter().filter_map(lands).sum();
        sum += light;
        squares += light * light;
    }
    // Each ray stands for an étendue of πR²·π.
    let of_rays = PI * radius * radius * PI / (size[0] * size[1]);
    let n = f64::from(count);
    let expected = of_rays * sum / n;
    let error = of_rays * (squares / n).sqrt() / n.sqrt();
    let text = by_doublet("LightSource \"infinite\" \"rgb L\" [1 1 1]", "");
    let [found, _] = parts(job(&text, DOUBLET, 1));
    let found = mean(&found).x;
    // 120,000 samples, whose scatter is at most three times that of the rays: they choose a pair, and half of them look behind the lens. And
    // well-spread points do better than random ones, by which both are judged: one false alarm in far more than 15,000.
    let error = error * (1.0 + 9.0 * n / 120_000.0).sqrt();
    assert!(error < 0.05 * expected, "{error} {expected}");
    assert!(
        (found - expected).abs() < 4.0 * error,
        "{found} {expected} {error}"
    );
}

/// An integrator that traces no light of its own, or leaves that to camera paths, leaves them their light.
#[test]
fn ghosts_come_with_every_integrator() {
    let (x, z) = (5f64.to_radians().sin(), 5f64.to_radians().cos());
    let world = format!(
        "LightSource \"distant\" \"point from\" [{x} 0 {z}] \"point to\" [0 0 0] \"rgb L\" [1 1 1]\n\
         Translate 0 0 20000 Shape \"sphere\" \"float radius\" 1000"
    );
    let text = by_doublet(&world, "");
    let of = |integrator: &str| {
        let text = text.replace("Integrator \"path\"", &format!("Integrator {integrator}"));
        mean(&parts(job(&text, DOUBLET, 1))[0]).x
    };
    let expected = of("\"path\"");
    assert!(expected > 0.0);
    for depth in [0, 1, 5] {
        let found = of(&format!("\"bdpt\" \"integer maxdepth\" {depth}"));
        // Of the same samples, or of others where light paths have found that more or fewer pay: 7,500 of them scatter by some percent.
        assert!(
            (found / expected - 1.0).abs() < 0.2,
            "{depth}: {found} {expected}"
        );
    }
}

/// Lights that look the same to the lens, with an area and without, near and far.
#[test]
fn lamps_of_every_kind_have_the_same_ghosts() {
    // Of irradiance 1 at 10 m, 5 degrees off the axis; a radius of 20 mm is 0.1 degrees.
    let (x, z) = (5f64.to_radians().sin() * 1e4, 5f64.to_radians().cos() * 1e4);
    let (intensity, radiance) = (1e8, 1e8 / (PI * 400.0));
    let lamps = [
        format!(
            "LightSource \"distant\" \"point from\" [{x} 0 {z}] \"point to\" [0 0 0] \"rgb L\" [1 1 1]"
        ),
        format!(
            "LightSource \"point\" \"point from\" [{x} 0 {z}] \"rgb I\" [{intensity} {intensity} {intensity}]"
        ),
        format!(
            "LightSource \"spot\" \"point from\" [{x} 0 {z}] \"point to\" [0 0 0] \"float coneangle\" 5 \"float conedeltaangle\" 1 \
             \"rgb I\" [{intensity} {intensity} {intensity}]"
        ),
        format!(
            "AreaLightSource \"diffuse\" \"rgb L\" [{radiance} {radiance} {radiance}] Translate {x} 0 {z} Shape \"sphere\" \"float radius\" 20"
        ),
    ];
    let found = lamps
        .each_ref()
        .map(|lamp| mean(&parts(job(&by_doublet(lamp, ""), DOUBLET, 1))[0]).x);
    for light in found {
        // Lamps at 10 m are 0.6 % nearer to a lens of 12 mm than to its middle, and their light comes at other angles by 0.03 degrees; samples are the
        // same points for all.
        assert!(
            (light / found[0] - 1.0).abs() < 0.02 && light > 0.0,
            "{found:?}"
        );
    }
    // A wall hides all of it.
    let wall = "Material \"matte\" Shape \"disk\" \"float height\" 500 \"float radius\" 900";
    let hidden = by_doublet(&format!("{} {wall}", lamps[1]), "");
    assert_eq!(mean(&parts(job(&hidden, DOUBLET, 1))[0]), DVec3::ZERO);
}

/// A ball of glass, 20 mm wide, 2 mm behind a stop.
const BALL: &str = "0 2 0 8\n10 20 1.5 20\n-10 10 1 20\n";

/// Irradiance, at a point so far from the axis, mm, of the film behind a ball of glass in the scene that a lamp shines on through a hole: all that reflections
/// and refractions of the ball bring. `whitted` follows both at each surface, so that there is no noise but where pixels sample an edge.
///
/// First with few rays, then with many where the lamp is seen: by two reflections it is smaller than a pixel.
fn behind_real_glass(r: f64) -> f64 {
    let (side, fov) = (100, 110.0f64);
    let half = (0.5 * fov).to_radians().tan();
    let pixel = 2.0 * half / f64::from(side);
    let seen_in = |crop: [u32; 4], samples: u32| -> Vec<([u32; 2], f64)> {
        let [x0, x1, y0, y1] = crop.map(|edge| f64::from(edge) / f64::from(side));
        let text = format!(
            "LookAt {r} 0 -32  {r} 0 0  0 1 0 Camera \"perspective\" \"float fov\" {fov}\n\
             Film \"image\" \"integer xresolution\" {side} \"integer yresolution\" {side}\n\
             \"float cropwindow\" [{x0} {x1} {y0} {y1}] PixelFilter \"box\" Integrator \"whitted\" \"integer maxdepth\" 5\n\
             Sampler \"stratified\" \"integer xsamples\" {samples} \"integer ysamples\" {samples}\n\
             WorldBegin {LAMP}\n\
             Material \"matte\" \"rgb Kd\" [0 0 0] Shape \"disk\" \"float innerradius\" 4 \"float radius\" 900\n\
             Material \"glass\" \"float eta\" 1.5 Translate 0 0 -12 Shape \"sphere\" \"float radius\" 10 WorldEnd"
        );
        let film = expose(&job(&text, BALL, 1), TILE_SIZE, &Progress::hidden());
        let pixels = film.bounds().pixels().zip(film.pixels());
        pixels
            .map(|(at, seen)| (at.to_array(), seen.mean().x))
            .collect()
    };
    let lit = seen_in([0, side, 0, side], 3).into_iter();
    let lit: Vec<[u32; 2]> = lit
        .filter(|(_, light)| *light > 0.0)
        .map(|(at, _)| at)
        .collect();
    let ends = |axis: usize| {
        let all = || lit.iter().map(|at| at[axis]);
        let low = all().min().expect("the lamp is seen").saturating_sub(3);
        [low, (all().max().expect("the lamp is seen") + 4).min(side)]
    };
    let ([x0, x1], [y0, y1]) = (ends(0), ends(1));
    let seen = seen_in([x0, x1, y0, y1], 16).into_iter();
    seen.map(|(at, light)| {
        let [x, y] = at.map(|k| pixel * (f64::from(k) + 0.5) - half);
        // cos θ dω is cos⁴ θ per area at distance 1.
        light * pixel * pixel / (1.0 + x * x + y * y).powi(2)
    })
    .sum()
}

/// Of radius 8 mm, 60 mm before the hole.
const LAMP: &str = "AttributeBegin AreaLightSource \"diffuse\" \"rgb L\" [1 1 1] \"bool twosided\" \"true\" \
     Material \"matte\" \"rgb Kd\" [0 0 0] Shape \"disk\" \"float height\" 60 \"float radius\" 8 AttributeEnd";

/// The camera's ball has two surfaces and one pair, of which the scene's shows the same light: dimmed twice in the picture, and reflected twice beside it.
#[test]
fn a_ball_lens_shows_what_a_ball_of_glass_does() {
    let real: Vec<f64> = { 0..=13 }
        .map(|k| match k {
            4..=8 => f64::NAN,
            _ => behind_real_glass(0.5 * f64::from(k)),
        })
        .collect();
    let real_at = |r: f64| {
        let k = (2.0 * r).floor();
        let i = k as usize;
        real[i] + (2.0 * r - k) * (real[i + 1] - real[i])
    };
    // Pixels of half a millimeter.
    let text = format!(
        "Film \"image\" \"integer xresolution\" 20 \"integer yresolution\" 20\n\
         Camera \"realistic\" \"string specfile\" \"LENS\" \"float filmdistance\" 10 \"float aperture_diameter\" 8\n\
         \"float filmdiag\" 14.1421356 \"bool ghosts\" \"true\" PixelFilter \"box\"\n\
         Sampler \"random\" \"integer pixelsamples\" 1000 Integrator \"path\" WorldBegin {LAMP} WorldEnd"
    );
    let [ghosts, picture] = parts(job(&text, BALL, 1));
    // Sums over pixels between two radii: of both parts, and of the real ball.
    let mut report = String::new();
    let mut ring = |from: f64, to: f64| {
        let mut sums = [0.0; 3];
        for i in 0..400u32 {
            let [x, y] = [i % 20, i / 20].map(|k| 0.5 * (f64::from(k) + 0.5) - 5.0);
            let r = x.hypot(y);
            if (from..to).contains(&r) {
                let all = [ghosts[i as usize].x, picture[i as usize].x, real_at(r)];
                (0..3).for_each(|k| sums[k] += all[k]);
            }
        }
        let _ = writeln!(report, "{from}-{to}: {sums:?}");
        sums
    };
    let (middle, beside) = (ring(0.0, 1.5), ring(4.5, 6.5));
    let off = (middle[0] + middle[1]) / middle[2] - 1.0;
    // 28 pixels of 1000 samples, whose scatter is about their mean: 0.6 %. Four such, with a real ball that is known to 0.3 %. Without the loss it would
    // be 8 % brighter.
    assert!(
        off.abs() < 0.025 && middle[0] < 0.05 * middle[1],
        "{off}\n{report}"
    );
    // No picture there, but the ghost.
    assert_eq!(beside[1], 0.0);
    let off = beside[0] / beside[2] - 1.0;
    // About four thousand of 400,000 samples land there: 1.6 %, and four times that. Four and more reflections are 0.2 % of two.
    assert!(beside[2] > 0.0 && off.abs() < 0.065, "{off}\n{report}");
}

/// A room with a lamp, by camera paths alone and by paths from both ends.
#[test]
fn integrators_agree_on_the_picture_with_its_ghosts() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/scenes/valid/ghosts.pbrt");
    let text = std::fs::read_to_string(path).unwrap();
    let lens = Path::new(env!("CARGO_MANIFEST_DIR")).join("lenses/dgauss.50mm.dat");
    let text = text.replace(
        "../../../lenses/dgauss.50mm.dat",
        &lens.display().to_string(),
    );
    let mean_of = |integrator: &str, spp: u32, seed: u64| {
        let text = text
            .replace("\"path\"", &format!("\"{integrator}\""))
            .replace("[16]\nIntegrator", &format!("[{spp}]\nIntegrator"));
        let film = expose(&job(&text, DOUBLET, seed), TILE_SIZE, &Progress::hidden());
        mean(&pixels(&film))
    };
    let [a, b] = [("path", 64), ("bdpt", 32)].map(|(integrator, spp)| {
        let runs: Vec<DVec3> = (1..=8).map(|seed| mean_of(integrator, spp, seed)).collect();
        let all = mean(&runs);
        let scatter = runs.iter().map(|run| (*run - all) * (*run - all));
        (all, scatter.sum::<DVec3>() / (7.0 * 8.0))
    });
    let t = (a.0 - b.0) / (a.1 + b.1).map(f64::sqrt);
    // Student's distribution with at least seven degrees of freedom: one false alarm in a thousand channels.
    assert!(t.abs().max_element() < 5.41, "{a:?} {b:?}");
}
