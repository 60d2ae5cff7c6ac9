//! What the sums of a pixel's layers are, and where they stand: of all layers and of those of light, of a leaf and of any number of samples.

use super::sample::{OF_ALBEDO, OF_NORMAL, OF_P, OF_UV};
use super::{CameraSample, Layer, LayerSet, RenderSpace, SurfaceSample};
use crate::film::pairwise::Join;
use crate::math::{DVec3, DVec4, Vec4};
use arrayvec::ArrayVec;
use std::ops::AddAssign;

/// Sums are in rows of four, which are added by vector instructions: of those that all layers share, of the four parts of a [`SurfaceSample`], and of the
/// camera.
pub(super) const ROWS: usize = 6;
pub(super) const ALBEDO: usize = 1;
pub(super) const NORMAL: usize = 2;
const POSITION: usize = 3;
const UV: usize = 4;
const CAMERA: usize = 5;

/// The row that a layer's sums are in, and the first one's place in there; `None` where it has none.
pub(super) fn place(layer: Layer) -> Option<(usize, usize)> {
    match layer {
        Layer::Alpha => Some((0, COVERED)),
        Layer::Albedo => Some((ALBEDO, 0)),
        Layer::Normal => Some((NORMAL, 0)),
        Layer::Position => Some((POSITION, 0)),
        Layer::Uv => Some((UV, 0)),
        Layer::Depth => Some((CAMERA, 0)),
        Layer::Coc => Some((CAMERA, 1)),
        Layer::Motion => Some((CAMERA, 2)),
        Layer::Material | Layer::Instance | Layer::Lights => None,
    }
}

/// Where the shared ones are: the number of samples that left the lens, the weights of those that met a surface, the number of these, and that of all samples.
pub(super) const SEEN: usize = 0;
pub(super) const COVERED: usize = 1;
pub(super) const HITS: usize = 2;
pub(super) const SAMPLES: usize = 3;

/// Sums of the layers of light.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Lights(pub(super) ArrayVec<f64, { 3 * LayerSet::MAX_LIGHTS }>);

impl Lights {
    /// Of no samples.
    pub(super) fn none(set: LayerSet) -> Lights {
        Lights(std::iter::repeat_n(0.0, 3 * set.lights()).collect())
    }

    /// Adds light, layer by layer, to such sums.
    pub(super) fn add_to(sums: &mut [f64], lights: impl Iterator<Item = DVec3>) {
        for (sums, light) in sums.chunks_exact_mut(3).zip(lights) {
            add(sums, &light.to_array());
        }
    }
}

impl Join for Lights {
    fn join(&mut self, right: &Lights) {
        add(&mut self.0, &right.0);
    }
}

/// Adds sums to sums.
#[inline(always)]
pub(super) fn add<T: AddAssign + Copy>(sums: &mut [T], more: &[T]) {
    for (sum, more) in sums.iter_mut().zip(more) {
        *sum += *more;
    }
}

/// The sums of all layers, wanted or not, but for those of light.
#[derive(Clone, Debug, Default)]
pub(super) struct Own(pub(super) [DVec4; ROWS]);

impl Join for Own {
    #[inline(always)]
    fn join(&mut self, right: &Own) {
        add(&mut self.0, &right.0);
    }
}

/// The same of a leaf, sixteen samples at most, in single precision: rounded as a few of the samples themselves are, and half as many instructions
/// add them. Points are in render space.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Leaf([Vec4; ROWS]);

impl Leaf {
    /// Adds a sample that has met a surface: whatever is wanted, so that there are no branches.
    #[inline(always)]
    pub(super) fn add(
        &mut self,
        weight: f32,
        surface: &SurfaceSample,
        camera: Option<CameraSample>,
    ) {
        let [shared, albedo, normal, p, uv, own] = &mut self.0;
        *shared += Vec4::new(1.0, weight, 1.0, 1.0);
        *albedo += weight * surface.four(OF_ALBEDO);
        *normal += weight * surface.four(OF_NORMAL);
        *p += surface.four(OF_P);
        *uv += surface.four(OF_UV);
        if let Some(CameraSample(camera)) = camera {
            *own += camera;
        }
    }

    /// Adds a sample that has met nothing, or one that has not left the lens.
    #[inline(always)]
    pub(super) fn add_empty(&mut self, is_seen: bool) {
        self.0[0] += Vec4::new(f32::from(is_seen), 0.0, 0.0, 1.0);
    }

    /// Its sums.
    #[inline(always)]
    pub(super) fn sums(&self, space: &RenderSpace) -> Own {
        let mut own = Own(self.0.map(|sums| sums.as_dvec4()));
        // Of what is behind them in a sample.
        (own.0[ALBEDO].w, own.0[NORMAL].w) = (0.0, 0.0);
        (own.0[UV].z, own.0[UV].w) = (0.0, 0.0);
        let (hits, points) = (own.0[0][HITS], &mut own.0[POSITION]);
        let depth = (*points + hits * DVec4::W).dot(space.depth);
        *points += hits * space.origin;
        own.0[CAMERA].x += depth;
        own
    }
}
