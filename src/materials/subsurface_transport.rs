//! What light that a material transmits goes into: of a mix, which of its parts.
//!
//! A mix scatters all that its parts do, side by side. So light that a part's lobes let in wanders
//! below that part, and what another part lets through goes straight on. (In pbrt-v3 the first part's
//! light looks for a way out of surfaces of the part itself, finds those of the mix, and is lost; the
//! second's wanders nowhere.)

use super::{Material, MaterialKind};
use crate::bsdf::{Bsdf, BsdfSample, MAX_LOBES};
use crate::bssrdf::Bssrdf;
use crate::handles::MaterialId;
use crate::math::Rgb;
use crate::surface::{Footprint, SurfaceHit};
use crate::textures::Textures;
use arrayvec::ArrayVec;
use std::ops::Range;

/// Where transmitted light goes on.
pub struct SubsurfaceTransport<'a> {
    /// Factor of its throughput: of light that several parts let through, one has been chosen.
    pub share: Rgb,
    /// How it wanders below the surface; `None` where it goes straight on.
    pub bssrdf: Option<Bssrdf<'a>>,
}

impl SubsurfaceTransport<'_> {
    /// All of it on the way that it has.
    pub const STRAIGHT_ON: Self = SubsurfaceTransport {
        share: Rgb::ONE,
        bssrdf: None,
    };
}

/// A material that is no mix, among those that a mix comes to.
pub(super) struct Part {
    pub material: MaterialId,
    /// Positions of its lobes in the mix's BSDF.
    pub lobes: Range<usize>,
}

/// Those that have lobes.
pub(super) type Parts = ArrayVec<Part, MAX_LOBES>;

impl Material {
    /// Where light goes on that this material's `bsdf` at `hit` has transmitted as `sample` says;
    /// `materials` are the scene's, for the handles of mixes, and `choice` gives a fresh number in
    /// [0, 1) if one is needed.
    pub fn subsurface_transport<'a>(
        &'a self,
        hit: &SurfaceHit,
        (bsdf, sample): (&Bsdf, &BsdfSample),
        footprint: &Footprint,
        textures: &Textures,
        materials: &'a [Material],
        choice: impl FnOnce() -> f32,
    ) -> SubsurfaceTransport<'a> {
        let mix = match &self.kind {
            MaterialKind::Mix(mix) if mix.has_interior => mix,
            MaterialKind::Mix(_) => return SubsurfaceTransport::STRAIGHT_ON,
            _ => {
                return SubsurfaceTransport {
                    bssrdf: self.bssrdf(hit, bsdf, footprint, textures),
                    ..SubsurfaceTransport::STRAIGHT_ON
                };
            }
        };
        let at = hit.texture_point(footprint);
        let mut parts = Parts::new();
        mix.parts_at(&at, textures, materials, (0, &mut parts));
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
            bssrdf: part.and_then(|part| part.bssrdf(hit, bsdf, footprint, textures)),
        }
    }
}

/// One of the parts by what each lets through along the direction drawn, with the factor that makes up
/// for the choice. `None` without any.
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
            // The factor may divide by channels that carry no light.
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
