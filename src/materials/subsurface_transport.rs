//! Subsurface transport: where transmitted light continues, and in a mix, below which of its parts.
//!
//! A mix scatters everything its parts do, side by side. So light transmitted by a part's lobes undergoes subsurface
//! scattering in that part, and light transmitted by another part continues straight. (In pbrt-v3, light of the first
//! part looks for exits on surfaces of that part itself, finds those of the mix, and is lost; the second part has no
//! subsurface scattering.)

use super::{Material, MaterialKind, Place};
use crate::bsdf::{Bsdf, BsdfSample, MAX_LOBES};
use crate::bssrdf::Bssrdf;
use crate::handles::MaterialId;
use crate::math::Rgb;
use crate::surface::{Footprint, SurfaceHit};
use crate::textures::Textures;
use arrayvec::ArrayVec;
use std::ops::Range;

/// How transmitted light continues.
pub struct SubsurfaceTransport<'a> {
    /// Scale of the throughput: if several parts transmit light, one of them has been chosen.
    pub share: Rgb,
    /// Subsurface scattering below the surface; `None` if the light continues straight.
    pub bssrdf: Option<Bssrdf<'a>>,
}

impl SubsurfaceTransport<'_> {
    /// Light continues straight.
    pub const STRAIGHT_ON: Self = SubsurfaceTransport {
        share: Rgb::ONE,
        bssrdf: None,
    };
}

/// A material other than a mix, among the parts of a mix.
pub(super) struct Part {
    pub material: MaterialId,
    /// Indices of its lobes in the mix's BSDF.
    pub lobes: Range<usize>,
}

/// The parts that have lobes.
pub(super) type Parts = ArrayVec<Part, MAX_LOBES>;

impl Material {
    /// Returns `true` if all light that `bsdf` at `hit` transmits is scattered below. Never in a mix, where some of it may continue
    /// straight: which part it is that transmits is chosen for each sample.
    pub fn scatters_below(
        &self,
        hit: &SurfaceHit,
        bsdf: &Bsdf,
        footprint: &Footprint,
        textures: &Textures,
        materials: &[Material],
    ) -> bool {
        let at = Place {
            point: hit.texture_point(footprint),
            textures,
            materials,
        };
        !matches!(self.kind, MaterialKind::Mix(_)) && self.kind.bssrdf(hit, bsdf, &at).is_some()
    }

    /// How light continues that this material's `bsdf` at `hit` has transmitted as `sample`; `materials` are those of
    /// the scene, for the handles of mixes, and `choice` returns a sample in [0, 1) if one is needed.
    pub fn subsurface_transport<'a>(
        &'a self,
        hit: &SurfaceHit,
        (bsdf, sample): (&Bsdf, &BsdfSample),
        footprint: &Footprint,
        textures: &Textures,
        materials: &'a [Material],
        choice: impl FnOnce() -> f32,
    ) -> SubsurfaceTransport<'a> {
        let at = Place {
            point: hit.texture_point(footprint),
            textures,
            materials,
        };
        let mix = match &self.kind {
            MaterialKind::Mix(mix) if mix.has_interior => mix,
            MaterialKind::Mix(_) => return SubsurfaceTransport::STRAIGHT_ON,
            _ => {
                return SubsurfaceTransport {
                    bssrdf: self.kind.bssrdf(hit, bsdf, &at),
                    ..SubsurfaceTransport::STRAIGHT_ON
                };
            }
        };
        let mut parts = Parts::new();
        mix.parts_at(&at, (0, &mut parts));
        let chosen = if sample.specular {
            let lobe = usize::from(sample.lobe);
            let of_lobe = parts.iter().find(|part| part.lobes.contains(&lobe));
            of_lobe.map(|part| (part.material, Rgb::ONE))
        } else {
            choose(&parts, (bsdf, sample), hit, choice)
        };
        let Some((id, share)) = chosen else {
            return SubsurfaceTransport::STRAIGHT_ON;
        };
        let part = materials.get(id.index());
        SubsurfaceTransport {
            share,
            bssrdf: part.and_then(|part| part.kind.bssrdf(hit, bsdf, &at)),
        }
    }
}

/// Chooses one of the parts in proportion to what each transmits in the sampled direction; returns the factor that
/// compensates for the choice as well. `None` without any.
fn choose(
    parts: &Parts,
    (bsdf, sample): (&Bsdf, &BsdfSample),
    hit: &SurfaceHit,
    choice: impl FnOnce() -> f32,
) -> Option<(MaterialId, Rgb)> {
    let values = parts
        .iter()
        .map(|part| bsdf.f_of(part.lobes.clone(), hit.wo, sample.wi));
    let values: ArrayVec<Rgb, MAX_LOBES> = values.collect();
    let total: f32 = values.iter().map(|f| f.max_element()).sum();
    let only = values.iter().filter(|f| f.max_element() > 0.0).count() == 1;
    let mut left = if only { 0.0 } else { choice() * total };
    let mut chosen = None;
    for (part, &f) in parts.iter().zip(&values) {
        let weight = f.max_element();
        if weight > 0.0 {
            // The factor may divide by channels without light.
            let share = f / sample.f * (total / weight);
            let share = share.map(|x| if x.is_finite() { x } else { 0.0 });
            chosen = Some((part.material, share));
            if left < weight {
                break;
            }
        }
        left -= weight;
    }
    chosen
}
