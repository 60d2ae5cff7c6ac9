//! The image of an emitter by light tracing and by rays of the camera, through the lenses of `tests/golden`: a few of them always, all at four
//! stops and three field points by
//!
//! ```text
//! cargo test --release --lib cameras::connection::proof -- --ignored --nocapture
//! ```

use super::tests::traced;
use super::*;
use crate::cameras::{CameraSpec, FilmGeometry, Form};
use crate::math::UVec2;
use crate::math::transform::Transform;
use crate::optics::Prescription;
use std::path::{Path, PathBuf};

/// Full frame, in pixels of 0.36 mm.
const FILM: FilmGeometry = FilmGeometry {
    resolution: UVec2::new(100, 66),
    diagonal_mm: 43.27,
};

/// Heights of the middle of the emitter's image, in parts of the farthest point across the film that is lit.
const FIELDS: [f32; 3] = [0.0, 0.5, 0.9];

/// Where the film is focused and where the emitter is, mm: out of focus by a tenth.
const FOCUS: f64 = 3000.0;
const DISTANCE: f64 = 2700.0;

/// Rays to a point of the emitter, in camera space.
struct Emitter {
    corner: DVec3,
    edges: [DVec3; 2],
}

/// What comes of a comparison, in parts of the whole flux: the difference of the flux, and of the image in tiles, all added.
struct Difference {
    flux: f64,
    picture: f64,
}

/// Well-spread numbers (Roberts 2018) of this many dimensions.
fn spread<const D: usize>(i: usize) -> [f64; D] {
    // The root of x^(D+1) = x + 1.
    let root = (0..40).fold(1.5f64, |x, _| (1.0 + x).powf(1.0 / (D as f64 + 1.0)));
    std::array::from_fn(|k| (0.5 + (i + 1) as f64 / root.powi(1 + k as i32)).fract())
}

fn lenses() -> Vec<PathBuf> {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/golden");
    let files = std::fs::read_dir(folder)
        .unwrap()
        .map(|f| f.unwrap().path());
    let mut files: Vec<_> = files
        .filter(|f| f.extension().is_some_and(|e| e == "dat"))
        .collect();
    files.sort();
    files
}

fn camera(file: &Path, opened: f64) -> Camera {
    let mut p = Prescription::read(file).unwrap();
    let stops = p.surfaces.iter().filter(|s| s.is_stop).map(|s| s.aperture);
    let open = stops.fold(0.0, f64::max);
    p.set_stops(opened * open);
    let spec = CameraSpec::Realistic(Box::new(traced(&p, FOCUS, Form::Course)));
    let mut camera = Camera::new(&spec, &FILM, &Transform::IDENTITY).unwrap();
    camera.prepare_connections([Vec2::ZERO, FILM.resolution.as_vec2()]);
    camera
}

impl Emitter {
    /// Across the ray of the film point at `field`, ten pixels wide; `None` where that sees nothing.
    fn new(camera: &Camera, field: f32) -> Option<Emitter> {
        let middle = 0.5 * FILM.resolution.as_vec2();
        // The ray in the middle of those that pass.
        let ray = |raster: Vec2| {
            let rays = (0..256).filter_map(|i| {
                let [u, v] = spread::<2>(i);
                let sample = CameraSample {
                    raster,
                    time: 0.5,
                    lens: Vec2::new(u as f32, v as f32),
                    wavelength: 0.5,
                };
                camera.ray(&sample, false)
            });
            let (o, d) = rays.fold((DVec3::ZERO, DVec3::ZERO), |(o, d), r| {
                (o + r.ray.o.as_dvec3(), d + r.ray.d.as_dvec3())
            });
            let count = d.length();
            (count > 0.0).then(|| (o / count, d / count))
        };
        let raster = middle + Vec2::new(field * middle.x, 0.3 * field * middle.y);
        let (o, d) = ray(raster)?;
        let (_, beside) = ray(raster - Vec2::new(5.0, 0.0))?;
        let size = 2.0 * DISTANCE * d.normalize().cross(beside.normalize()).length();
        let across = d.cross(DVec3::Y).normalize();
        // Rolled by 20° about the ray.
        let (sin, cos) = 20f64.to_radians().sin_cos();
        let up = across.cross(d).normalize();
        let edges = [cos * across + sin * up, cos * up - sin * across];
        let edges = [size * edges[0], 0.8 * size * edges[1]];
        let corner = o + DISTANCE * d.normalize() - 0.5 * (edges[0] + edges[1]);
        Some(Emitter { corner, edges })
    }

    fn normal(&self) -> DVec3 {
        self.edges[0].cross(self.edges[1])
    }

    fn holds(&self, ray: &Ray) -> bool {
        let (o, d) = (ray.o.as_dvec3(), ray.d.as_dvec3());
        let t = (self.corner - o).dot(self.normal()) / d.dot(self.normal());
        let at = o + t * d - self.corner;
        let inside = |e: DVec3| (0.0..=1.0).contains(&(at.dot(e) / e.length_squared()));
        t > 0.0 && inside(self.edges[0]) && inside(self.edges[1])
    }

    /// The sample number `i` of light: where it lands, and its value.
    fn light(&self, camera: &Camera, i: usize) -> Option<(Vec2, f64)> {
        let [a, b, u, v] = spread::<4>(i);
        let from = ReferencePoint {
            p: (self.corner + a * self.edges[0] + b * self.edges[1]).as_vec3(),
            time: 0.5,
            ..Default::default()
        };
        let sample = LensSample {
            lens: Vec2::new(u as f32, v as f32),
            wavelength: 0.5,
        };
        let aim = camera.aim(&from, &sample)?;
        let landing = camera.land(&aim)?;
        // Not normalized, so the area is in it.
        let cos_area = self.normal().dot(aim.wi.as_dvec3()).abs();
        Some((landing.raster, f64::from(landing.importance.x) * cos_area))
    }
}

/// How far light reaches across the film, in parts of half its width.
fn lit(camera: &Camera) -> f32 {
    let parts = (1..=50).rev().map(|i| i as f32 / 50.0);
    let mut lit = parts.filter(|field| Emitter::new(camera, *field).is_some());
    lit.next().unwrap_or(0.0)
}

/// Compares the image by `n` rays of either; `None` where the lens shows nothing of the field point.
fn compare(camera: &Camera, field: f32, n: usize) -> Option<Difference> {
    const TILES: usize = 4;
    let emitter = Emitter::new(camera, field)?;
    // Where the image is, and a margin.
    let seen = (0..20_000).filter_map(|i| emitter.light(camera, i));
    let ends = seen.fold(None, |ends: Option<[Vec2; 2]>, (p, _)| {
        let [low, high] = ends.unwrap_or([p, p]);
        Some([low.min(p), high.max(p)])
    });
    let [low, high] = ends?;
    let (low, high) = (low - 0.5, high + 0.5);
    let (low, high) = (low.max(Vec2::ZERO), high.min(FILM.resolution.as_vec2()));
    let tile = |p: Vec2| {
        let at = (p - low) / (high - low) * TILES as f32;
        let inside = at.min_element() >= 0.0 && at.max_element() < TILES as f32;
        inside.then(|| at.y as usize * TILES + at.x as usize)
    };
    let mut sums = [[0.0; TILES * TILES]; 2];
    let mut rays = [None; BUNDLE];
    for first in (0..n).step_by(BUNDLE) {
        let samples: [CameraSample; BUNDLE] = std::array::from_fn(|k| {
            let [x, y, u, v] = spread::<4>(first + k);
            CameraSample {
                raster: low + Vec2::new(x as f32, y as f32) * (high - low),
                time: 0.5,
                lens: Vec2::new(u as f32, v as f32),
                wavelength: 0.5,
            }
        });
        camera.rays(&samples, false, &mut rays);
        for (sample, ray) in samples.iter().zip(&rays) {
            let hit = ray.filter(|ray| emitter.holds(&ray.ray));
            if let (Some(ray), Some(tile)) = (hit, tile(sample.raster)) {
                let area = f64::from((high - low).element_product());
                sums[0][tile] += f64::from(ray.weight) * area;
            }
        }
    }
    for i in 0..n {
        if let Some((raster, value)) = emitter.light(camera, i)
            && let Some(tile) = tile(raster)
        {
            sums[1][tile] += value;
        }
    }
    let [by_camera, by_light] = sums;
    let whole: f64 = by_camera.iter().sum();
    let pairs = || by_camera.iter().zip(&by_light);
    Some(Difference {
        flux: pairs().map(|(a, b)| b - a).sum::<f64>() / whole,
        picture: pairs().map(|(a, b)| (b - a).abs()).sum::<f64>() / whole,
    })
}

#[test]
fn an_emitter_looks_the_same_through_some_lenses() {
    for name in ["dgauss_50", "wide_22"] {
        let file = lenses()
            .into_iter()
            .find(|f| f.ends_with(format!("{name}.dat")));
        let camera = camera(&file.unwrap(), 0.5);
        for field in FIELDS {
            let difference = compare(&camera, field, 40_000).unwrap();
            // Well-spread samples of 40000: some parts in a thousand, and more in the tiles of a small image.
            assert!(
                difference.flux.abs() < 4e-3,
                "{name} {field}: {}",
                difference.flux
            );
            assert!(
                difference.picture < 2e-2,
                "{name} {field}: {}",
                difference.picture
            );
        }
    }
}

#[test]
#[ignore = "minutes"]
fn an_emitter_looks_the_same_through_all_lenses() {
    let mut worst = 0.0f64;
    println!(
        "difference of flux by field, in parts of a thousand (and of the picture in 16 tiles)"
    );
    for file in lenses() {
        for opened in [1.0, 0.5, 0.25, 0.125] {
            let camera = camera(&file, opened);
            let lit = lit(&camera);
            let name = file.file_stem().unwrap().to_string_lossy();
            let mut line = format!("{name:18} stop × {opened:5}:");
            for field in FIELDS {
                // Of a million samples some tenths of a percent may be noise; what does not go away with more of them is none.
                let differences = [20, 22, 24].map(|log| (log, 1usize << log)).into_iter();
                let mut differences =
                    differences.map(|(log, n)| (log, compare(&camera, field * lit, n).unwrap()));
                let mut found = differences.next().unwrap();
                while found.1.flux.abs() > 4e-4
                    && let Some(more) = differences.next()
                {
                    found = more;
                }
                let (log, d) = found;
                let note = if log > 20 {
                    format!(" 2^{log}")
                } else {
                    String::new()
                };
                line += &format!("  {:6.3} ({:.3}){note}", 1e3 * d.flux, 1e3 * d.picture);
                worst = worst.max(d.flux.abs());
            }
            println!("{line}");
        }
    }
    println!("worst: {worst:.2e}");
    assert!(worst < 1e-3);
}
