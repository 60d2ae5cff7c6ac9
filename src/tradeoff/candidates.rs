//! The candidate settings of a study.

use super::integrators::others;
use crate::cameras::{CameraSpec, Precision, RealisticSpec};
use crate::filters::{
    BoxFilter, Filter, FilterShape, GaussianFilter, MitchellFilter, SincFilter, TriangleFilter,
};
use crate::integrators::{IntegratorSpec, Path, VolPath};
use crate::lights::SelectionStrategy;
use crate::optics::models::ModelKind;
use crate::optics::pupil::PupilSampling;
use crate::samplers::{Points, SamplerSpec, Stratified};
use crate::scene::options::Options;
use std::mem::discriminant;

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
    /// The integrator.
    Integrator,
    /// Maximum path depth (scattering events).
    MaxDepth,
    /// The light selection strategy.
    LightChoice,
    /// The reconstruction filter, which changes the look rather than the quality.
    Filter,
}

impl Setting {
    /// Those that a recommendation may change.
    pub const QUALITY: [Setting; 7] = [
        Setting::Integrator,
        Setting::Sampler,
        Setting::LensModel,
        Setting::Precision,
        Setting::PupilSampling,
        Setting::MaxDepth,
        Setting::LightChoice,
    ];

    /// Its name in tables.
    pub fn name(self) -> &'static str {
        match self {
            Setting::Scene => "scene",
            Setting::Samples => "samples",
            Setting::Sampler => "sampler",
            Setting::LensModel => "lens model",
            Setting::Precision => "precision",
            Setting::PupilSampling => "pupil sampling",
            Setting::Integrator => "integrator",
            Setting::MaxDepth => "maxdepth",
            Setting::LightChoice => "light choice",
            Setting::Filter => "filter",
        }
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
    /// What it changes in them.
    change: Change,
}

/// What a candidate changes.
#[derive(Clone, Debug)]
enum Change {
    Samples(u32),
    Sampler(Points),
    LensModel(ModelKind),
    Precision(Precision),
    PupilSampling(PupilSampling),
    Integrator(Box<IntegratorSpec>),
    MaxDepth(u32),
    LightChoice(SelectionStrategy),
    Filter(Box<Filter>),
}

impl Change {
    fn apply(&self, options: &mut Options) {
        let sampler = options.sampler.clone();
        match self {
            Change::Samples(spp) => options.sampler = sampler.with_spp(*spp),
            Change::Sampler(points) => {
                let (points, spp) = (*points, sampler.spp);
                options.sampler = SamplerSpec { points, ..sampler }.with_spp(spp);
            }
            Change::LensModel(model) => change_lens(options, |lens| lens.model = *model),
            Change::Precision(precision) => {
                change_lens(options, |lens| lens.precision = *precision);
            }
            Change::PupilSampling(sampling) => {
                change_lens(options, |lens| lens.pupil_sampling = *sampling);
            }
            Change::Integrator(spec) => options.integrator.spec = (**spec).clone(),
            Change::MaxDepth(depth) => {
                if let Some(max_depth) = max_depth(&mut options.integrator.spec) {
                    *max_depth = *depth;
                }
            }
            Change::LightChoice(strategy) => {
                if let Some(path) = path(&mut options.integrator.spec) {
                    path.light_strategy = *strategy;
                }
            }
            Change::Filter(filter) => options.filter = (**filter).clone(),
        }
    }
}

fn change_lens(options: &mut Options, change: impl FnOnce(&mut RealisticSpec)) {
    if let CameraSpec::Realistic(lens) = &mut options.camera {
        change(lens);
    }
}

/// The path tracer's settings, if it is one.
fn path(spec: &mut IntegratorSpec) -> Option<&mut Path> {
    match spec {
        IntegratorSpec::Path(path) | IntegratorSpec::VolPath(VolPath { path }) => Some(path),
        _ => None,
    }
}

/// The maximum path depth, if the integrator has one that is worth varying.
fn max_depth(spec: &mut IntegratorSpec) -> Option<&mut u32> {
    match spec {
        IntegratorSpec::DirectLighting(direct) => Some(&mut direct.max_depth),
        IntegratorSpec::Whitted(whitted) => Some(&mut whitted.max_depth),
        other => path(other).map(|path| &mut path.max_depth),
    }
}

impl Candidate {
    /// Of `sppm`, the radius of the discs that it starts with, in the scene's units.
    #[must_use]
    pub fn photon_radius(&self) -> Option<f32> {
        match &self.options.integrator.spec {
            IntegratorSpec::Sppm(sppm) => Some(sppm.radius),
            _ => None,
        }
    }

    fn new(setting: Setting, value: &str, change: Change, options: &Options) -> Candidate {
        let mut options = options.clone();
        change.apply(&mut options);
        Candidate {
            setting,
            value: value.into(),
            options,
            change,
        }
    }

    /// The scene with all these settings and `spp` samples per pixel.
    pub(super) fn of_all<'a>(
        settings: impl Iterator<Item = &'a Candidate>,
        spp: u32,
        options: &Options,
    ) -> Candidate {
        let mut options = options.clone();
        settings.for_each(|candidate| candidate.change.apply(&mut options));
        let change = Change::Samples(spp);
        Candidate::new(Setting::Scene, "as recommended", change, &options)
    }
}

/// The settings of a `realistic` camera that it does not have.
fn of_camera(own: &RealisticSpec) -> impl Iterator<Item = (Setting, String, Change)> {
    let models = [ModelKind::Exact, ModelKind::Thick, ModelKind::Thin].into_iter();
    let models = models.filter(|model| *model != own.model).map(|model| {
        let change = Change::LensModel(model);
        (Setting::LensModel, model.to_string(), change)
    });
    let precisions = [("single", Precision::Single), ("double", Precision::Double)].into_iter();
    let precisions = precisions.filter(|(_, precision)| *precision != own.precision);
    let precisions = precisions.map(|(name, precision)| {
        let change = Change::Precision(precision);
        (Setting::Precision, name.to_owned(), change)
    });
    let samplings = [
        ("concentric", PupilSampling::Concentric),
        ("polar", PupilSampling::Polar),
        ("rejection", PupilSampling::Rejection),
    ];
    let samplings =
        { samplings.into_iter() }.filter(|(_, sampling)| *sampling != own.pupil_sampling);
    let samplings = samplings.map(|(name, sampling)| {
        let change = Change::PupilSampling(sampling);
        (Setting::PupilSampling, name.to_owned(), change)
    });
    models.chain(precisions).chain(samplings)
}

/// All candidates for a scene, the scene's own first: the sample counts `counts`, and every other setting at `spp`
/// samples per pixel, with the values that the scene does not have. `radius` is that of the sphere around the scene (world
/// units).
pub fn candidates(options: &Options, radius: f32, spp: u32, counts: &[u32]) -> Vec<Candidate> {
    let own = Candidate::new(
        Setting::Scene,
        "as it stands",
        Change::Samples(spp),
        options,
    );
    let base = own.options.clone();
    let mut candidates = vec![own];
    let mut add = |setting, value: &str, change| {
        candidates.push(Candidate::new(setting, value, change, &base));
    };
    for &n in counts {
        add(Setting::Samples, &n.to_string(), Change::Samples(n));
    }
    for (name, points) in samplers(base.sampler.points) {
        add(Setting::Sampler, name, Change::Sampler(points));
    }
    if let CameraSpec::Realistic(own) = &base.camera {
        for (setting, value, change) in of_camera(own) {
            add(setting, &value, change);
        }
    }
    let mut integrator = base.integrator.spec.clone();
    for (name, spec) in others(&integrator, radius) {
        let change = Change::Integrator(Box::new(spec));
        add(Setting::Integrator, name, change);
    }
    for depth in max_depth(&mut integrator).map_or_else(Vec::new, |own| depths(*own)) {
        add(
            Setting::MaxDepth,
            &depth.to_string(),
            Change::MaxDepth(depth),
        );
    }
    if let Some(own) = path(&mut integrator) {
        for (name, strategy) in [
            ("spatial", SelectionStrategy::Spatial),
            ("power", SelectionStrategy::Power),
            ("uniform", SelectionStrategy::Uniform),
        ] {
            if strategy != own.light_strategy {
                add(Setting::LightChoice, name, Change::LightChoice(strategy));
            }
        }
    }
    for (name, filter) in filters(&base.filter) {
        add(Setting::Filter, name, Change::Filter(Box::new(filter)));
    }
    candidates
}

/// Samplers of other kinds than the scene's.
fn samplers(own: Points) -> impl Iterator<Item = (&'static str, Points)> {
    let grid = Points::Stratified(Stratified::new(4, 4, true, None));
    let all = [
        ("random", Points::Random),
        ("stratified", grid),
        ("sobol", Points::Sobol),
    ];
    let other = move |points: &Points| discriminant(points) != discriminant(&own);
    all.into_iter().filter(move |(_, points)| other(points))
}

/// Twice a depth, then half of it each time: the cost of the path's end.
fn depths(own: u32) -> Vec<u32> {
    let halves = std::iter::successors(Some(own / 2), |depth| Some(depth / 2));
    let halves = halves.take_while(|&depth| depth > 0).take(4);
    let twice = std::iter::once(own.saturating_mul(2));
    twice.chain(halves).filter(|&depth| depth != own).collect()
}

/// The other filters, with their default widths.
fn filters(own: &Filter) -> impl Iterator<Item = (&'static str, Filter)> {
    let shapes = [
        ("box", FilterShape::Box(BoxFilter::default())),
        ("triangle", FilterShape::Triangle(TriangleFilter::default())),
        ("gaussian", FilterShape::Gaussian(GaussianFilter::default())),
        ("mitchell", FilterShape::Mitchell(MitchellFilter::default())),
        ("sinc", FilterShape::Sinc(SincFilter::default())),
    ];
    let own = discriminant(own.shape());
    let other = shapes
        .into_iter()
        .filter(move |(_, shape)| discriminant(shape) != own);
    other.filter_map(|(name, shape)| Some((name, Filter::new(shape)?)))
}
