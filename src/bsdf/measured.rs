//! Measured isotropic BRDFs, evaluated as pbrt-v2 does. Directions are local.

mod facets;
mod half_angle;
mod scattered;

use super::lobe::TableLobe;
use super::lobe_choice::rescaled;
use super::lobe_sample::LobeSample;
use crate::assets::brdf_file::BrdfFile;
use crate::assets::merl_file::MerlFile;
use crate::files::FileError;
use crate::math::color::is_black;
use crate::math::sampling::{cosine_hemisphere, cosine_hemisphere_pdf};
use crate::math::{Rgb, Vec2, Vec3};
use facets::Facets;
use scattered::Scattered;
use std::fmt;
use std::path::Path;

/// Bins of the half angle by which directions are sampled for scattered measurements.
const BINS: usize = 64;

/// A measured BRDF.
#[derive(Clone, PartialEq)]
pub struct MeasuredTable {
    data: Data,
    /// Approximate distribution of reflected light.
    facets: Facets,
}

#[derive(Clone, PartialEq)]
enum Data {
    HalfAngle(MerlFile),
    Scattered(Scattered),
}

impl fmt::Debug for MeasuredTable {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("MeasuredTable").finish_non_exhaustive()
    }
}

impl MeasuredTable {
    /// Reads a file: a list of samples if its name ends in `.brdf`, otherwise a MERL table, as in pbrt-v2.
    pub fn read(path: &Path) -> Result<MeasuredTable, FileError> {
        let is_list = path
            .extension()
            .is_some_and(|ending| ending.eq_ignore_ascii_case("brdf"));
        Ok(if is_list {
            MeasuredTable::from_brdf(&BrdfFile::read(path)?)
        } else {
            MeasuredTable::from_merl(MerlFile::read(path)?)
        })
    }

    /// From a list of samples.
    pub fn from_brdf(file: &BrdfFile) -> MeasuredTable {
        MeasuredTable::new(Data::Scattered(Scattered::new(file)), BINS)
    }

    /// From a MERL table.
    pub fn from_merl(file: MerlFile) -> MeasuredTable {
        let bins = file.counts[0];
        MeasuredTable::new(Data::HalfAngle(file), bins)
    }

    fn new(data: Data, bins: usize) -> MeasuredTable {
        let facets = Facets::new(bins, |wo, wi| data.f(wo, wi));
        MeasuredTable { data, facets }
    }

    /// Returns `true` if nothing is reflected at all.
    pub fn is_black(&self) -> bool {
        match &self.data {
            Data::HalfAngle(table) => table.values.iter().all(|value| is_black(*value)),
            Data::Scattered(table) => table.is_black(),
        }
    }
}

impl Data {
    /// The BRDF, in 1/sr.
    fn f(&self, wo: Vec3, wi: Vec3) -> Rgb {
        match self {
            Data::HalfAngle(table) => half_angle::nearest(table, wo, wi),
            Data::Scattered(table) => table.f(wo, wi),
        }
    }
}

/// A lobe that reflects as measured.
pub type MeasuredLobe<'a> = TableLobe<'a, MeasuredTable>;

impl MeasuredLobe<'_> {
    /// Value in 1/sr.
    pub fn f(&self, wo: Vec3, wi: Vec3) -> Rgb {
        self.table.data.f(wo, wi) * self.share
    }

    /// Density of [`MeasuredLobe::sample`] per solid angle.
    pub fn pdf(&self, wo: Vec3, wi: Vec3) -> f32 {
        if wo.z * wi.z <= 0.0 {
            return 0.0;
        }
        0.5 * (cosine_hemisphere_pdf(wi.z.abs()) + self.table.facets.pdf(wo, wi))
    }

    /// Samples a cosine-distributed direction for `u.x` below ½, as pbrt-v2 always does, otherwise one reflected about a
    /// facet whose normal follows the mean over the table; `None` if that would leave below the surface.
    pub fn sample(&self, wo: Vec3, u: Vec2) -> Option<LobeSample> {
        let wi = if u.x < 0.5 {
            let wi = cosine_hemisphere(rescaled(u, 0.5));
            wi.with_z(wi.z.copysign(wo.z))
        } else {
            let u = rescaled(u - Vec2::new(0.5, 0.0), 0.5);
            let h = self.table.facets.sample(u);
            let h = h.with_z(h.z.copysign(wo.z));
            (2.0 * wo.dot(h) * h - wo).try_normalize()?
        };
        LobeSample::evaluated(wi, self.pdf(wo, wi), || self.f(wo, wi))
    }
}

#[cfg(test)]
pub(crate) mod tests;
