//! Several independent renders of one scene as one image.

use crate::compare::Estimate;
use crate::film::{FilmMetadata, Image, LoadedImage};
use crate::math::{DVec3, Rgb};

/// Why renders cannot be averaged.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum MergeError {
    /// There is none.
    #[error("there is no image")]
    None,
    /// They are not of the same pixels.
    #[error("the runs differ in size or crop window")]
    Window,
}

/// The mean of independent renders with as many samples each, and the variance of that mean.
///
/// Where every run knows its variances, those of the mean are their sum over n², with n times the degrees of freedom.
/// Otherwise they are the runs' own scatter, Σ (x − x̄)² / (n (n − 1)), with n − 1; of a single run without variances nothing
/// is known.
///
/// # Errors
/// See [`MergeError`].
pub fn merged(runs: Vec<LoadedImage>) -> Result<LoadedImage, MergeError> {
    if runs.len() <= 1 {
        return runs.into_iter().next().ok_or(MergeError::None);
    }
    let first = runs.first().ok_or(MergeError::None)?;
    let window = |run: &LoadedImage| (run.image.bounds, run.image.resolution, run.display);
    if runs.iter().any(|run| window(run) != window(first)) {
        return Err(MergeError::Window);
    }
    let count: u32 = runs.iter().map(|run| run.runs.unwrap_or(1).max(1)).sum();
    let estimates: Vec<Estimate> = runs.iter().map(Estimate::of).collect();
    let pool = first
        .pool
        .filter(|_| runs.iter().all(|run| run.pool == first.pool));
    let are_alike = runs.iter().all(|run| run.pool == pool);
    let is_known = are_alike && estimates.iter().all(Estimate::has_variance);
    let freedom = { estimates.iter() }.fold(f64::INFINITY, |least, e| least.min(e.freedom));
    let pixels = mean(&runs, |image| Some(&image.pixels)).unwrap_or_default();
    let n = runs.len() as f32;
    let of_mean = |pick: fn(&Image) -> Option<&Vec<Rgb>>| {
        let sum = mean(&runs, pick)?;
        Some(sum.into_iter().map(|variance| variance / n).collect())
    };
    let variance = match is_known {
        true => of_mean(|image| image.variance.as_ref()),
        false => Some(scatter(&runs, &pixels)),
    };
    Ok(LoadedImage {
        spp: first
            .spp
            .filter(|_| runs.iter().all(|run| run.spp == first.spp)),
        runs: Some(count),
        freedom: is_known.then_some(freedom * f64::from(n)),
        pool: pool.filter(|_| is_known),
        light_paths: { first.light_paths }
            .filter(|_| runs.iter().all(|run| run.light_paths == first.light_paths)),
        denoised: first.denoised.clone(),
        from_xyz: runs.iter().any(|run| run.from_xyz),
        display: first.display,
        primaries: first.primaries,
        image: Image {
            resolution: first.image.resolution,
            bounds: first.image.bounds,
            pixels,
            variance,
            independent: of_mean(|image| image.independent.as_ref()).filter(|_| is_known),
            layers: Default::default(),
        },
    })
}

/// The mean over the runs of one of their layers, if all have it.
fn mean(runs: &[LoadedImage], pick: fn(&Image) -> Option<&Vec<Rgb>>) -> Option<Vec<Rgb>> {
    let layers: Vec<&Vec<Rgb>> = { runs.iter() }
        .map(|run| pick(&run.image))
        .collect::<Option<_>>()?;
    let count = layers.len() as f64;
    let pixels = layers.first().map_or(0, |layer| layer.len());
    let of = |i: usize| {
        let values = layers.iter().filter_map(|layer| layer.get(i));
        (values.map(|value| value.as_dvec3()).sum::<DVec3>() / count).as_vec3()
    };
    Some((0..pixels).map(of).collect())
}

/// The variance of the mean by the scatter of the runs.
fn scatter(runs: &[LoadedImage], mean: &[Rgb]) -> Vec<Rgb> {
    let n = runs.len() as f64;
    let of = |(i, mean): (usize, &Rgb)| {
        let deviations = runs.iter().filter_map(|run| run.image.pixels.get(i));
        let squares = deviations.map(|x| (x.as_dvec3() - mean.as_dvec3()).powf(2.0));
        (squares.sum::<DVec3>() / (n * (n - 1.0))).as_vec3()
    };
    mean.iter().enumerate().map(of).collect()
}

/// What the file of such an image says of it. `seed` is the first run's. Samples whose number is unknown are written as 0, which
/// [`film::read()`](crate::film::read()) takes for that.
pub fn metadata(image: &LoadedImage, scene: &str, seed: u64) -> FilmMetadata {
    FilmMetadata {
        spp: image.spp.unwrap_or_default(),
        runs: image.runs.filter(|&runs| runs > 1),
        freedom: image.freedom,
        pool: image.pool,
        light_paths: image.light_paths,
        denoised: image.denoised.clone(),
        seed,
        scene: scene.to_owned(),
        software: concat!("fstop ", env!("CARGO_PKG_VERSION")).to_string(),
        ..FilmMetadata::default()
    }
}
