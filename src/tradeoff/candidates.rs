//! The candidate settings of a study.

use crate::cameras::{CameraSpec, Precision};
use crate::filters::{
    BoxFilter, Filter, FilterShape, GaussianFilter, MitchellFilter, SincFilter, TriangleFilter,
};
use crate::integrators::{IntegratorSpec, VolPath};
use crate::lights::SelectionStrategy;
use crate::optics::models::ModelKind;
use crate::optics::pupil::PupilSampling;
use crate::samplers::{Points, SamplerSpec, Stratified};
use crate::scene::options::Options;

/// A setting that can be varied.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Setting {
    /// None: the scene as it is.
    Scene,
    /// Samples per pixel.
    Samples,
    /// The sampler.
    Sampler,
    /// The lens model that generates camera rays.
    LensModel,
    /// The floating-point precision of lens tracing.
    Precision,
    /// The distribution of lens samples over the exit pupil.
    PupilSampling,
    /// Maximum path depth (scattering events).
    MaxDepth,
    /// The light selection strategy.
    LightChoice,
    /// The reconstruction filter, which changes the look rather than the quality.
    Filter,
}

impl Setting {
    /// Its name in tables.
    pub fn name(self) -> &'static str {
        match self {
            Setting::Scene => "scene",
            Setting::Samples => "samples",
            Setting::Sampler => "sampler",
            Setting::LensModel => "lens model",
            Setting::Precision => "precision",
            Setting::PupilSampling => "pupil sampling",
            Setting::MaxDepth => "maxdepth",
            Setting::LightChoice => "light choice",
            Setting::Filter => "filter",
        }
    }

    /// Returns `true` if a recommendation may change it. A filter is a matter of taste.
    pub fn is_quality(self) -> bool {
        !matches!(self, Setting::Scene | Setting::Samples | Setting::Filter)
    }
}

/// One setting with one value.
#[derive(Clone, Debug)]
pub struct Candidate {
    /// The setting that is varied.
    pub setting: Setting,
    /// Its value, as spelled in the scene file.
    pub value: String,
    /// All options, including this one.
    pub options: Options,
}

/// All candidates for a scene, the scene's own first: the sample counts `counts`, and every other setting at `spp`
/// samples per pixel.
pub fn candidates(options: &Options, spp: u32, counts: &[u32]) -> Vec<Candidate> {
    let base = with(options, |o| o.sampler = o.sampler.clone().with_spp(spp));
    let mut candidates = vec![Candidate {
        setting: Setting::Scene,
        value: "as it stands".into(),
        options: base.clone(),
    }];
    let mut add = |setting, value: String, options| {
        candidates.push(Candidate {
            setting,
            value,
            options,
        })
    };
    for &n in counts {
        let options = with(&base, |o| o.sampler = o.sampler.clone().with_spp(n));
        add(Setting::Samples, n.to_string(), options);
    }
    for (name, sampler) in samplers(&base.sampler) {
        add(
            Setting::Sampler,
            name.into(),
            with(&base, |o| o.sampler = sampler),
        );
    }
    for (setting, value, camera) in cameras(&base.camera) {
        add(setting, value, with(&base, |o| o.camera = camera));
    }
    for (setting, value, spec) in integrators(&base.integrator.spec) {
        add(setting, value, with(&base, |o| o.integrator.spec = spec));
    }
    for (name, filter) in filters(&base.filter) {
        add(
            Setting::Filter,
            name.into(),
            with(&base, |o| o.filter = filter),
        );
    }
    candidates
}

fn with(options: &Options, change: impl FnOnce(&mut Options)) -> Options {
    let mut options = options.clone();
    change(&mut options);
    options
}

/// The samplers that the scene does not use.
fn samplers(own: &SamplerSpec) -> Vec<(&'static str, SamplerSpec)> {
    let spp = own.spp;
    let grid = Points::Stratified(Stratified::new(4, 4, true, None));
    let all = [
        ("random", Points::Random),
        ("stratified", grid),
        ("sobol", Points::Sobol),
    ];
    let same =
        |points: Points| std::mem::discriminant(&points) == std::mem::discriminant(&own.points);
    let other = all.into_iter().filter(|(_, points)| !same(*points));
    let spec = |points| SamplerSpec {
        points,
        ..own.clone()
    };
    other
        .map(|(name, points)| (name, spec(points).with_spp(spp)))
        .collect()
}

/// Lens models, precisions and pupil samplings that the scene does not use.
fn cameras(own: &CameraSpec) -> Vec<(Setting, String, CameraSpec)> {
    let CameraSpec::Realistic(own) = own else {
        return Vec::new();
    };
    let models = [ModelKind::Exact, ModelKind::Thick, ModelKind::Thin];
    let precisions = [("single", Precision::Single), ("double", Precision::Double)];
    let samplings = [
        ("concentric", PupilSampling::Concentric),
        ("polar", PupilSampling::Polar),
        ("rejection", PupilSampling::Rejection),
    ];
    let mut all = Vec::new();
    for model in models.into_iter().filter(|m| *m != own.model) {
        let mut spec = own.clone();
        spec.model = model;
        all.push((
            Setting::LensModel,
            model.to_string(),
            CameraSpec::Realistic(spec),
        ));
    }
    for (name, precision) in precisions.into_iter().filter(|(_, p)| *p != own.precision) {
        let mut spec = own.clone();
        spec.precision = precision;
        all.push((
            Setting::Precision,
            name.to_string(),
            CameraSpec::Realistic(spec),
        ));
    }
    for (name, sampling) in samplings
        .into_iter()
        .filter(|(_, s)| *s != own.pupil_sampling)
    {
        let mut spec = own.clone();
        spec.pupil_sampling = sampling;
        all.push((
            Setting::PupilSampling,
            name.to_string(),
            CameraSpec::Realistic(spec),
        ));
    }
    all
}

/// Maximum depths and light selection strategies that the scene does not use.
fn integrators(own: &IntegratorSpec) -> Vec<(Setting, String, IntegratorSpec)> {
    let mut all = Vec::new();
    let depths = |own: u32| {
        // Half the depth each time, and twice the depth once: the cost of the path's end.
        let mut depths = vec![own.saturating_mul(2)];
        let mut depth = own / 2;
        while depth > 0 && depths.len() < 5 {
            depths.push(depth);
            depth /= 2;
        }
        depths.retain(|&d| d != own);
        depths
    };
    match own {
        IntegratorSpec::Path(path) | IntegratorSpec::VolPath(VolPath { path }) => {
            let rebuilt = |path| match own {
                IntegratorSpec::VolPath(_) => IntegratorSpec::VolPath(VolPath { path }),
                _ => IntegratorSpec::Path(path),
            };
            for depth in depths(path.max_depth) {
                let mut path = path.clone();
                path.max_depth = depth;
                all.push((Setting::MaxDepth, depth.to_string(), rebuilt(path)));
            }
            let strategies = [
                ("spatial", SelectionStrategy::Spatial),
                ("power", SelectionStrategy::Power),
                ("uniform", SelectionStrategy::Uniform),
            ];
            for (name, strategy) in strategies {
                if strategy != path.light_strategy {
                    let mut path = path.clone();
                    path.light_strategy = strategy;
                    all.push((Setting::LightChoice, name.to_string(), rebuilt(path)));
                }
            }
        }
        IntegratorSpec::DirectLighting(direct) => {
            for depth in depths(direct.max_depth) {
                let mut direct = direct.clone();
                direct.max_depth = depth;
                all.push((
                    Setting::MaxDepth,
                    depth.to_string(),
                    IntegratorSpec::DirectLighting(direct),
                ));
            }
        }
        IntegratorSpec::Whitted(whitted) => {
            for depth in depths(whitted.max_depth) {
                let mut whitted = whitted.clone();
                whitted.max_depth = depth;
                all.push((
                    Setting::MaxDepth,
                    depth.to_string(),
                    IntegratorSpec::Whitted(whitted),
                ));
            }
        }
        _ => {}
    }
    all
}

/// The other filters, with their default widths.
fn filters(own: &Filter) -> Vec<(&'static str, Filter)> {
    let shapes = [
        ("box", FilterShape::Box(BoxFilter::default())),
        ("triangle", FilterShape::Triangle(TriangleFilter::default())),
        ("gaussian", FilterShape::Gaussian(GaussianFilter::default())),
        ("mitchell", FilterShape::Mitchell(MitchellFilter::default())),
        ("sinc", FilterShape::Sinc(SincFilter::default())),
    ];
    let other = shapes
        .into_iter()
        .filter(|(_, shape)| std::mem::discriminant(shape) != std::mem::discriminant(own.shape()));
    other
        .filter_map(|(name, shape)| Some((name, Filter::new(shape)?)))
        .collect()
}
