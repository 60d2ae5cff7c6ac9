//! Maps of a lens for other programs: distortion and shading for compositing, point spread functions and rays for simulation.

use super::Bench;
use crate::cli::messages::Failure;
use crate::optics::analysis::maps::{LensMaps, RadialFactor, Raster, shading};
use crate::optics::analysis::psf::{COLORS, ColorLenses, FIELDS, PsfGrid};
use crate::optics::analysis::{ChiefFinder, ObjectPlane, ReferenceScale};
use crate::output;
use ::exr::prelude::{
    AnyChannel, AnyChannels, Blocks, Compression, Encoding, FlatSamples, Image, Layer,
    LayerAttributes, LineOrder, Text, WritableImage,
};
use clap::{ArgGroup, Args};
use std::fmt::Write;
use std::io::Cursor;
use std::path::{Path, PathBuf};

/// Files about one lens.
#[derive(Args, Debug)]
#[command(next_help_heading = "For compositing and simulation")]
#[command(group(ArgGroup::new("maps").multiple(true).args(["stmap", "undistort", "shading"])))]
#[command(group(ArgGroup::new("points").multiple(true).args(["psf", "rays"])))]
pub(super) struct MapArgs {
    /// Write an STMap that warps a pinhole's image to the lens' (32-bit EXR; R and G are the source's place from its lower left corner, 0 to 1)
    #[arg(long, value_name = "FILE.exr")]
    stmap: Option<PathBuf>,
    /// Write the STMap that warps the lens' image to the pinhole's
    #[arg(long, value_name = "FILE.exr")]
    undistort: Option<PathBuf>,
    /// Write the brightness of the lens' image, 1 in the middle
    #[arg(long, value_name = "FILE.exr")]
    shading: Option<PathBuf>,
    /// Pixels of these maps, which are square; their proportions are those of the film
    #[arg(
        long,
        value_name = "WIDTHxHEIGHT",
        default_value = "1500x1000",
        requires = "maps"
    )]
    map_size: MapSize,
    /// Write the chief rays over the field as a table
    #[arg(long, value_name = "FILE.csv")]
    chief_rays: Option<PathBuf>,
    /// Write point spread functions: fields from left to right, depths from top to bottom, colors as R, G and B
    #[arg(long, value_name = "FILE.exr")]
    psf: Option<PathBuf>,
    /// Write the rays of the same points, from the scene to the film, as a table
    #[arg(long, value_name = "FILE.csv")]
    rays: Option<PathBuf>,
    /// Depths of --psf and --rays in meters from the film, separated by commas (`inf` is one); by default the plane of focus
    #[arg(
        long,
        value_name = "M,M",
        value_delimiter = ',',
        allow_hyphen_values = true,
        requires = "points"
    )]
    depths: Vec<Depth>,
}

/// Pixels across and down.
#[derive(Clone, Copy, Debug)]
struct MapSize([usize; 2]);

/// The most pixels that a side may have: an EXR of 32,768² pixels has 8 GB.
const LARGEST: usize = 32_768;

impl std::str::FromStr for MapSize {
    type Err = String;

    fn from_str(text: &str) -> Result<MapSize, String> {
        let side = |text: &str| {
            let n = text.parse().ok();
            n.filter(|n| (1..=LARGEST).contains(n))
        };
        let (width, height) = text.split_once('x').unwrap_or_default();
        match (side(width), side(height)) {
            (Some(width), Some(height)) => Ok(MapSize([width, height])),
            _ => Err(format!("expected WIDTHxHEIGHT, each 1 to {LARGEST}")),
        }
    }
}

/// A distance from the film, mm.
#[derive(Clone, Copy, Debug)]
struct Depth(f64);

impl std::str::FromStr for Depth {
    type Err = String;

    fn from_str(text: &str) -> Result<Depth, String> {
        match text.parse::<f64>() {
            Ok(m) if m > 0.0 => Ok(Depth(1e3 * m)),
            _ => Err("expected a distance in meters, or `inf`".to_string()),
        }
    }
}

impl MapArgs {
    /// Every output file requested.
    pub(super) fn files(&self) -> impl Iterator<Item = &PathBuf> {
        let maps = self
            .stmap
            .iter()
            .chain(&self.undistort)
            .chain(&self.shading);
        let tables = self.chief_rays.iter().chain(&self.psf).chain(&self.rays);
        maps.chain(tables)
    }

    /// Refuses names that say another format than the file has.
    pub(super) fn check(&self) -> Result<(), String> {
        let images = [&self.stmap, &self.undistort, &self.shading, &self.psf];
        let is_exr =
            |file: &PathBuf| { file.extension() }.is_some_and(|e| e.eq_ignore_ascii_case("exr"));
        match images.into_iter().flatten().find(|file| !is_exr(file)) {
            None => Ok(()),
            Some(file) => Err(format!(
                "{}: maps and point spread functions are EXR files: expected a name ending in .exr",
                file.display()
            )),
        }
    }

    /// Writes them.
    pub(super) fn write(&self, bench: &Bench) -> Result<(), Failure> {
        self.write_maps(bench)?;
        if let Some(file) = &self.chief_rays {
            output::write(file, chief_rays(bench).as_bytes())?;
        }
        self.write_points(bench)
    }

    fn write_maps(&self, bench: &Bench) -> Result<(), Failure> {
        let raster = Raster::new(self.map_size.0, bench.film.diagonal());
        if self.stmap.is_some() || self.undistort.is_some() {
            let maps = LensMaps::new(&bench.lens, raster.film, bench.object);
            let maps =
                maps.ok_or_else(|| bench.says("the lens has no chief rays near its axis"))?;
            for (file, map) in [
                (&self.stmap, &maps.to_pinhole),
                (&self.undistort, &maps.to_lens),
            ] {
                if let Some(file) = file {
                    write_stmap(file, &raster, map)?;
                }
            }
        }
        if let Some(file) = &self.shading {
            let factor = shading(&bench.lens, raster.film);
            let factor =
                factor.ok_or_else(|| bench.says("no light reaches the middle of the film"))?;
            let value = |[x, y]: [f64; 2]| factor.at(x.hypot(y)).unwrap_or(0.0) as f32;
            let values: Vec<f32> = pixels(&raster).map(|p| value(raster.place(p))).collect();
            let channels = ["R", "G", "B"].map(|name| (name, values.clone()));
            write_exr(
                file,
                raster.size,
                channels,
                "irradiance over that in the middle",
            )?;
        }
        Ok(())
    }

    fn write_points(&self, bench: &Bench) -> Result<(), Failure> {
        /// Pixels of a tile's side.
        const TILE: usize = 64;
        if self.psf.is_none() && self.rays.is_none() {
            return Ok(());
        }
        let lenses = ColorLenses::new(&bench.prescription, bench.lens.film_distance(), bench.film);
        let lenses = lenses.ok_or_else(|| bench.says("no lens for other colors"))?;
        let depths: Vec<ObjectPlane> = match &self.depths[..] {
            [] => vec![bench.object],
            depths => {
                let plane = |d: &Depth| ObjectPlane::at_distance(&bench.lens, d.0);
                depths.iter().map(plane).collect()
            }
        };
        if let Some(file) = &self.psf {
            let grid = PsfGrid::new(&lenses, &depths, TILE);
            let um = 1e3 * grid.pitch;
            let about = format!(
                "tiles of {TILE} pixels of {um} um; fields {FIELDS:?} of half the diagonal from left to right; R, G, B are {COLORS:?} um"
            );
            let [red, green, blue] = grid.light;
            let channels = [("R", red), ("G", green), ("B", blue)];
            write_exr(file, grid.size, channels, &about)?;
        }
        if let Some(file) = &self.rays {
            output::write(file, rays(bench, &lenses, &depths).as_bytes())?;
        }
        Ok(())
    }
}

/// Columns and rows, row by row from the top.
fn pixels(raster: &Raster) -> impl Iterator<Item = [usize; 2]> {
    let [width, height] = raster.size;
    (0..height).flat_map(move |row| (0..width).map(move |column| [column, row]))
}

/// What is not known comes from outside of the image.
const NOWHERE: [f64; 2] = [-1.0, -1.0];

fn write_stmap(file: &Path, raster: &Raster, map: &RadialFactor) -> Result<(), Failure> {
    let sources = pixels(raster).map(|p| raster.source(map, p).unwrap_or(NOWHERE));
    let (u, v) = sources.map(|[u, v]| (u as f32, v as f32)).unzip();
    let blue = vec![0.0; raster.size[0] * raster.size[1]];
    let channels = [("R", u), ("G", v), ("B", blue)];
    write_exr(
        file,
        raster.size,
        channels,
        "STMap: R, G = source / size, origin at the lower left",
    )
}

/// Writes channels of 32-bit floats.
fn write_exr(
    file: &Path,
    size: [usize; 2],
    channels: [(&str, Vec<f32>); 3],
    about: &str,
) -> Result<(), Failure> {
    let encoding = Encoding {
        compression: Compression::ZIP16,
        blocks: Blocks::ScanLines,
        line_order: LineOrder::Increasing,
    };
    let attributes = LayerAttributes {
        comments: Some(Text::new_or_none(about).unwrap_or_default()),
        ..LayerAttributes::default()
    };
    let channel = |(name, values)| AnyChannel::new(name, FlatSamples::F32(values));
    let channels = AnyChannels::sort(channels.into_iter().map(channel).collect());
    let layer = Layer::new((size[0], size[1]), attributes, encoding, channels);
    let picture = Image::from_layer(layer);
    let mut bytes = Vec::new();
    // In parallel it would start as many threads as RAYON_NUM_THREADS says, even a hundred thousand.
    let written = picture.write().non_parallel();
    written
        .to_buffered(Cursor::new(&mut bytes))
        .map_err(|e| format!("{}: {e}", file.display()))?;
    Ok(output::write(file, &bytes)?)
}

/// Where film points look, from the middle of the film to its corner.
fn chief_rays(bench: &Bench) -> String {
    const ROWS: u32 = 101;
    let chief = ChiefFinder::new(&bench.lens);
    let corner = 0.5 * bench.film.diagonal();
    let scale = ReferenceScale::new(&chief, bench.object, corner);
    let mut text = "film_height_mm,field_angle_deg,film_angle_deg,pinhole_height_mm,distortion_percent,front_y_mm,front_z_mm,direction_y,direction_z,passes\n".to_string();
    for i in 0..ROWS {
        let height = corner * f64::from(i) / f64::from(ROWS - 1);
        let Some(found) = chief.find(height) else {
            break;
        };
        let film_angle = ((height - found.aim) / bench.lens.film_distance()).atan();
        let ideal = match height {
            0.0 => 0.0,
            _ => scale.ideal_height(&found),
        };
        let distortion = if height > 0.0 {
            100.0 * (height / ideal - 1.0)
        } else {
            0.0
        };
        let ([_, y, z], [_, m, n]) = (found.ray.o, found.ray.d);
        let _ = writeln!(
            text,
            "{height},{},{},{ideal},{distortion},{y},{z},{m},{n},{}",
            found.field_angle().to_degrees(),
            film_angle.to_degrees(),
            u8::from(found.passes)
        );
    }
    text
}

/// Rays of points over field, depth and color, as far as they get through.
fn rays(bench: &Bench, lenses: &ColorLenses, depths: &[ObjectPlane]) -> String {
    const ACROSS: usize = 32;
    let mut text = "field_mm,depth_m,wavelength_um,origin_x,origin_y,origin_z,direction_x,direction_y,direction_z,film_x,film_y\n".to_string();
    for depth in depths {
        let meters = depth
            .z
            .map_or(f64::INFINITY, |z| 1e-3 * (bench.lens.film_z() - z));
        for field in FIELDS {
            let height = field * 0.5 * bench.film.diagonal();
            for (rays, wavelength) in lenses.rays(field, *depth, ACROSS).iter().zip(COLORS) {
                for ray in rays {
                    let ([x, y, z], [l, m, n], [u, v]) = (ray.ray.o, ray.ray.d, ray.film);
                    let _ = writeln!(
                        text,
                        "{height},{meters},{wavelength},{x},{y},{z},{l},{m},{n},{u},{v}"
                    );
                }
            }
        }
    }
    text
}
