//! Perfectly specular materials, through and off which light continues in a single direction (caustics).

use super::roughness::UNBENT;
use super::{Glass, Material, MaterialKind, Mix, Uber, may_scatter};
use crate::handles::MaterialId;
use crate::inputs::{FloatInput, SpectrumInput};
use crate::math::Rgb;

impl Material {
    /// Returns `true` if the material may reflect or transmit light in a single direction somewhere, besides any other
    /// scattering; `materials` are those of the scene, for the handles of mixes.
    ///
    /// Subsurface scattering does not count: light that enters exits scattered.
    pub fn is_smooth(&self, materials: &[Material]) -> bool {
        match &self.kind {
            MaterialKind::Mirror(m) => may_scatter(&m.kr),
            MaterialKind::Glass(m) => m.is_smooth(),
            MaterialKind::Uber(m) => m.is_smooth(),
            MaterialKind::Mix(m) => m.is_smooth(materials),
            MaterialKind::ShinyMetal(_) => true,
            MaterialKind::Subsurface(m) => m.interior.boundary.is_smooth(),
            MaterialKind::KdSubsurface(m) => m.interior.boundary.is_smooth(),
            MaterialKind::Matte(_)
            | MaterialKind::Plastic(_)
            | MaterialKind::Metal(_)
            | MaterialKind::Substrate(_)
            | MaterialKind::Translucent(_)
            | MaterialKind::Disney(_)
            | MaterialKind::Hair(_)
            | MaterialKind::Measured(_)
            | MaterialKind::Fourier(_) => false,
        }
    }

    /// Returns `true` if light from a single direction may be scattered into others. Mixes, which are rarely of mirrors
    /// alone, count as such.
    pub fn scatters_widely(&self) -> bool {
        match &self.kind {
            MaterialKind::Mirror(_) => false,
            MaterialKind::Glass(m) => !m.is_smooth(),
            _ => true,
        }
    }
}

impl Glass {
    fn is_smooth(&self) -> bool {
        let colored = may_scatter(&self.kr) || may_scatter(&self.kt);
        let unbending = |eta: &FloatInput| matches!(eta, FloatInput::Constant(eta) if (eta - 1.0).abs() < UNBENT);
        let polished = self.roughness == [FloatInput::Constant(0.0); 2];
        (polished && colored) || (unbending(&self.eta) && may_scatter(&self.kt))
    }
}

impl Uber {
    fn is_smooth(&self) -> bool {
        let holes = self.opacity != SpectrumInput::Constant(Rgb::ONE);
        let polished = may_scatter(&self.kr) || may_scatter(&self.kt);
        holes || (may_scatter(&self.opacity) && polished)
    }
}

impl Mix {
    fn is_smooth(&self, materials: &[Material]) -> bool {
        let rest = match self.amount {
            SpectrumInput::Constant(amount) => SpectrumInput::Constant(Rgb::ONE - amount),
            texture => texture,
        };
        let smooth = |id: Option<MaterialId>| match id {
            // `none` transmits its share of the light straight.
            None => true,
            Some(id) => materials
                .get(id.index())
                .is_some_and(|material| material.is_smooth(materials)),
        };
        let shares = self.parts.into_iter().zip([self.amount, rest]);
        shares
            .filter(|(_, share)| may_scatter(share))
            .any(|(part, _)| smooth(part))
    }
}
