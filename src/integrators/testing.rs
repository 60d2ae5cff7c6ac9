//! Scenes for the tests of what is computed side by side, and their paths in waves and one by one.

use super::context::CameraPath;
use super::witness::Watch;
use super::{CameraEnd, Paired, Workspace};
use crate::cameras::{CameraRay, CameraSample};
use crate::film::{Layer, LayerSet};
use crate::math::hash::{mix2, unit_float};
use crate::math::{IVec2, Rgb, Vec2};
use crate::render::RenderJob;
use crate::samplers::SampleStream;
use crate::scene::{ReadSettings, read_scene};
use crate::syntax::SourceMap;

/// A white room, closed, so that paths are long, with two lamps and something glossy. Shading normals are not those of the floor.
pub(super) const ROOM_WITH_LAMPS: &str = r#"
    LookAt 0 0 -3.9  0 0 0  0 1 0
    Camera "perspective" "float fov" 70
    Film "image" "integer xresolution" 16 "integer yresolution" 16 "string aov" "lights"
    Sampler "sobol" "integer pixelsamples" 16
    Integrator "path" "integer maxdepth" 30 "float rrthreshold" 0
    WorldBegin
    Material "matte" "rgb Kd" [ .95 .9 .93 ]
    Shape "trianglemesh" "integer indices" [ 0 1 2 0 2 3 4 5 6 4 6 7 0 1 5 0 5 4 3 2 6 3 6 7 0 3 7 0 7 4 1 2 6 1 6 5 ]
        "point P" [ -4 -4 -4  4 -4 -4  4 4 -4  -4 4 -4  -4 -4 4  4 -4 4  4 4 4  -4 4 4 ]
    Shape "trianglemesh" "integer indices" [ 0 1 2 0 2 3 ] "point P" [ -3 -2 -3  3 -2 -3  3 -2 3  -3 -2 3 ]
        "normal N" [ .1 1 0  0 1 .2  -.3 1 0  0 1 -.1 ]
    Material "plastic"
    Shape "sphere" "float radius" 1
    Shape "trianglemesh" "integer indices" [ 0 1 2 0 2 3 ] "point P" [ -3 -1 2  -1 -1 1  -1 2 1  -3 2 2 ]
        "normal N" [ -.5 0 -1  .2 0 -1  .2 .4 -1  -.5 .4 -1 ]
    Texture "tiles" "spectrum" "checkerboard" "float uscale" 9 "float vscale" 9 "rgb tex1" [ .8 .7 .6 ] "rgb tex2" [ .1 .2 .1 ]
    Material "plastic" "texture Kd" "tiles" "float roughness" .02
    Shape "trianglemesh" "integer indices" [ 0 1 2 0 2 3 ] "point P" [ 1 -1 1  3 -1 2  3 2 2  1 2 1 ]
    Material "uber" "float roughness" .3
    Shape "trianglemesh" "integer indices" [ 0 1 2 0 2 3 ] "point P" [ -1 2 2  1 2 2  1 3 1  -1 3 1 ]
    Material "matte"
    AreaLightSource "diffuse" "rgb L" [ 3 2 1 ]
    Shape "trianglemesh" "integer indices" [ 0 1 2 0 2 3 ] "point P" [ -1 3.9 -1  1 3.9 -1  1 3.9 1  -1 3.9 1 ]
    Translate 2 0 -1
    ReverseOrientation
    AreaLightSource "diffuse" "rgb L" [ 1 2 3 ] "bool twosided" "true" "string group" "ball"
    Shape "sphere" "float radius" .5
    WorldEnd
"#;

/// Under the sky and lamps of other kinds, with something of everything that a path may meet.
pub(super) const OUTDOORS: &str = r#"
    LookAt 0 1 -6  0 .5 0  0 1 0
    Camera "perspective" "float fov" 60
    Film "image" "integer xresolution" 16 "integer yresolution" 16 "string aov" "lights"
    Sampler "sobol" "integer pixelsamples" 16
    Integrator "path" "integer maxdepth" 6
    WorldBegin
    LightSource "infinite" "rgb L" [ .3 .4 .6 ] "string group" "sky"
    LightSource "point" "rgb I" [ 20 18 15 ] "string group" "lamp" "point from" [ 3 5 -3 ]
    LightSource "distant" "rgb L" [ 1 .9 .8 ] "point from" [ -1 2 -1 ] "point to" [ 0 0 0 ]
    AttributeBegin
    AreaLightSource "diffuse" "rgb L" [ 9 9 9 ]
    Shape "disk" "float height" 4 "float radius" .5
    AttributeEnd
    AttributeBegin
    AreaLightSource "diffuse" "rgb L" [ 5 6 7 ]
    Translate -3 2 0
    Shape "sphere" "float radius" .3
    AttributeEnd
    Texture "tiles" "spectrum" "checkerboard" "float uscale" 20 "float vscale" 20 "rgb tex1" [ .8 .7 .6 ] "rgb tex2" [ .1 .2 .1 ]
    Material "matte" "texture Kd" "tiles"
    Shape "trianglemesh" "integer indices" [ 0 1 2 0 2 3 ] "point P" [ -9 0 -9  9 0 -9  9 0 9  -9 0 9 ] "float uv" [ 0 0 1 0 1 1 0 1 ]
    Material "matte" "rgb Kd" [ .6 .5 .4 ] "float sigma" 20
    Shape "trianglemesh" "integer indices" [ 0 1 2 0 2 3 ] "point P" [ -4 0 3  4 0 3  4 3 3.5  -4 3 3.5 ]
    Material "matte" "rgb Kd" [ .5 .5 .9 ]
    Shape "trianglemesh" "integer indices" [ 0 1 2 ] "point P" [ -2 .4 -2  40 .4 90  40 .4001 91 ]
    ObjectBegin "post"
    Shape "trianglemesh" "integer indices" [ 0 1 2 0 2 3 ] "point P" [ -.1 0 0  .1 0 0  .1 1 0  -.1 1 0 ]
    ObjectEnd
    AttributeBegin
    Translate 1.5 0 -1
    ObjectInstance "post"
    AttributeEnd
    Material "glass"
    Translate 0 .7 0
    Shape "sphere" "float radius" .6
    Material "none"
    Shape "sphere" "float radius" .8
    Material "mirror"
    Translate 1.4 0 1
    Shape "sphere" "float radius" .5
    Material "translucent"
    Translate -2.8 0 0
    Shape "sphere" "float radius" .5
    Material "subsurface" "string name" "Skin1" "float scale" 20
    Translate 0 0 -1.5
    Shape "sphere" "float radius" .4
    WorldEnd
"#;

/// The scene of this text.
pub(super) fn job(text: &str) -> RenderJob {
    let sources = SourceMap::new();
    let main = sources.add_text("scene.pbrt", text.to_string());
    let (mut scene, said) = read_scene(&sources, main, &ReadSettings::default());
    assert!(!said.has_errors());
    let frame = scene.frames.pop().expect("a frame");
    let (built, diagnostics) = crate::build::build(frame, 0);
    assert!(!diagnostics.has_errors());
    built.expect("a scene").job
}

/// Of an image of 16 × 16 pixels.
const PIXELS: u32 = 256;

/// The samples of a pixel, their rays, and the numbers of their paths.
fn samples(job: &RenderJob, pixel: u32) -> Vec<(CameraSample, CameraRay, SampleStream)> {
    let sample = |index: u32| {
        let sample = CameraSample {
            raster: [pixel % 16, pixel / 16].map(|x| x as f32 + 0.5).into(),
            time: 0.0,
            lens: Vec2::splat(unit_float(mix2(pixel.into(), index.into()))),
            wavelength: 0.5,
        };
        let ray = job.camera.ray(&sample, job.world.needs_footprint());
        let at = IVec2::new(pixel as i32 % 16, pixel as i32 / 16);
        (sample, ray.expect("a ray"), job.sampler.stream(at, index))
    };
    (0..8).map(sample).collect()
}

pub(super) fn bits(colors: &[Rgb]) -> Vec<[u32; 3]> {
    let bits = |color: &Rgb| color.to_array().map(f32::to_bits);
    colors.iter().map(bits).collect()
}

/// What paths bring, and what layers see of them.
#[derive(Default)]
pub(super) struct Found {
    pub radiances: Vec<Rgb>,
    pub seen: Vec<String>,
    pub parts: Vec<Vec<Rgb>>,
}

impl Found {
    fn look(&mut self, watch: Watch) {
        // Bits, but for NaN: each number is printed with as many digits as tell it from others.
        let known = watch.sight.known();
        self.seen.push(format!("{known:?}"));
        let parts = watch.parts.expect("parts");
        self.parts.push(parts.scaled(Rgb::ONE, 4).collect());
    }
}

fn watch() -> Watch {
    let mut watch = Watch::default();
    let layers = LayerSet::NONE.with(Layer::Uv).with(Layer::Lights);
    watch.look(layers.with_lights(4));
    watch
}

/// All camera rays, in waves of this many, of an image with so many light paths for each sample of a pixel.
pub(super) fn in_waves(job: &RenderJob, of: usize, light_paths: f32, is_watched: bool) -> Found {
    let mut all: Vec<_> = (0..PIXELS).flat_map(|pixel| samples(job, pixel)).collect();
    let mut workspace = job.integrator.workspace(&job.world);
    let mut found = Found::default();
    for some in all.chunks_mut(of) {
        let mut watches: Vec<Watch> = some.iter().map(|_| watch()).collect();
        let path = |((sample, ray, stream), watch)| {
            let (sample, ray): (&CameraSample, &CameraRay) = (sample, ray);
            CameraPath {
                end: end(job, sample, ray, light_paths),
                differentials: ray.scaled_differentials(1.0),
                stream,
                watch: Some(watch).filter(|_| is_watched),
            }
        };
        let mut paths: Vec<CameraPath> = some
            .iter_mut()
            .zip(&mut watches)
            .map(|((s, r, t), w)| path(((&*s, &*r, t), w)))
            .collect();
        let radiances = job
            .integrator
            .radiances(&job.world, &mut paths, &mut workspace, None);
        found.radiances.extend(radiances);
        watches.into_iter().for_each(|watch| found.look(watch));
    }
    found
}

fn end<'a>(
    job: &'a RenderJob,
    sample: &'a CameraSample,
    ray: &'a CameraRay,
    light_paths: f32,
) -> CameraEnd<'a> {
    CameraEnd {
        camera: &job.camera,
        sample,
        ray,
        film_density: 1.0,
        light_paths,
        // One of the sample's own.
        paired: Some(Paired {
            sampler: &job.sampler,
            number: sample.lens.x.to_bits().into(),
        })
        .filter(|_| job.integrator.joined() == 1.0 && light_paths > 0.0),
    }
}

/// Each camera ray by itself.
pub(super) fn one_by_one(job: &RenderJob, light_paths: f32) -> Found {
    let mut workspace = Workspace::default();
    let all = (0..PIXELS).flat_map(|pixel| samples(job, pixel));
    let mut found = Found::default();
    for (sample, ray, mut stream) in all {
        let differentials = ray.scaled_differentials(1.0);
        let mut watch = watch();
        found.radiances.push(job.integrator.radiance(
            &job.world,
            &end(job, &sample, &ray, light_paths),
            differentials.as_ref(),
            &mut stream,
            &mut workspace,
            Some(&mut watch),
        ));
        found.look(watch);
    }
    found
}
