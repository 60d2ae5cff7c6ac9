//! The immutable world: everything a render reads and nothing it writes, shared by all threads without locks. It holds
//! only what its scene needs.

use crate::accel::{ClosestHit, EmitterHit, Geometry, GeometryHit, Passage, PrimitiveAttributes};
use crate::bsdf::{Boundary, Bsdf, BsdfSample, CoatedLobes};
use crate::handles::{LightId, LightLayer, MaterialId, MediumId};
use crate::inputs::FloatInput;
use crate::lights::Light;
use crate::materials::Material;
use crate::materials::subsurface_transport::SubsurfaceTransport;
use crate::math::ray::{Ray, RayDifferentials};
use crate::math::{Rgb, Vec2, Vec3};
use crate::media::Media;
use crate::surface::{ReceiverSide, SurfaceHit, TexturePoint};
use crate::textures::Textures;

/// The most surfaces without material on a path: more are a modeling error, and a ray that is caught between
/// surfaces would otherwise never end.
pub const MAX_NULL_SURFACES: u32 = 4096;

/// Geometry, appearance and light, all in render space.
pub struct World {
    /// Every surface, in its acceleration structure.
    pub geometry: Geometry,
    /// Materials by [`MaterialId`].
    pub materials: Vec<Material>,
    /// The reflectance of those materials that are [matte everywhere](Material::even_reflectance).
    even_reflectances: Vec<Option<Rgb>>,
    /// The lobes of those that are [coated alike everywhere](Material::even_coat).
    even_coats: Vec<Option<CoatedLobes>>,
    /// The lobes of those that are [boundaries](Boundary) alike everywhere.
    even_boundaries: Vec<Option<Boundary>>,
    /// Textures by their ids.
    pub textures: Textures,
    /// Lights by [`LightId`], area lights included.
    pub lights: Vec<Light>,
    /// How many of `lights`, from the front, are sampled; the rest are emitters inside objects, which are visible but
    /// illuminate nothing, as in pbrt-v3 (docs/scene-language.md §2.4).
    sampled_lights: usize,
    /// The layer of each light; empty where no layers of light are wanted.
    pub light_layers: Vec<LightLayer>,
    /// Those of `lights` that rays see which leave the scene (environment lights).
    pub infinite_lights: Vec<LightId>,
    /// Participating media and their interfaces.
    pub media: Media,
    /// See [`Geometry::has_recoverable_surfaces`].
    has_recoverable_surfaces: bool,
    has_interiors: bool,
    has_visible_lights: bool,
    moves: bool,
}

impl World {
    /// Assembles a world; the first `sampled_lights` of `lights` are sampled.
    pub fn new(
        geometry: Geometry,
        materials: Vec<Material>,
        textures: Textures,
        lights: Vec<Light>,
        sampled_lights: usize,
        media: Media,
    ) -> World {
        let is_infinite = |id: &LightId| lights[id.index()].is_infinite();
        let ids = (0..lights.len() as u32).map(LightId);
        let infinite_lights = ids.filter(is_infinite).collect();
        World {
            has_recoverable_surfaces: geometry.has_recoverable_surfaces(),
            has_interiors: materials.iter().any(Material::has_interior),
            has_visible_lights: lights.iter().any(|light| !light.is_delta()),
            moves: geometry.moves(),
            geometry,
            even_reflectances: materials.iter().map(Material::even_reflectance).collect(),
            even_coats: materials.iter().map(Material::even_coat).collect(),
            even_boundaries: materials.iter().map(Material::even_boundary).collect(),
            materials,
            textures,
            lights,
            sampled_lights,
            light_layers: Vec::new(),
            infinite_lights,
            media,
        }
    }

    /// The layer of light that a light belongs to; that of light from no light, too.
    pub fn light_layer(&self, light: Option<LightId>) -> LightLayer {
        let layer = light.and_then(|id| self.light_layers.get(id.index()));
        layer.copied().unwrap_or_default()
    }

    /// The lights that are sampled; index i is [`LightId`] i.
    pub fn sampled_lights(&self) -> &[Light] {
        &self.lights[..self.sampled_lights]
    }

    /// Returns `true` if a ray may meet a light: one with an area, or around the scene.
    pub fn has_visible_lights(&self) -> bool {
        self.has_visible_lights
    }

    /// Returns `true` if light that a surface transmits may be scattered below it and leave it elsewhere.
    pub fn has_interiors(&self) -> bool {
        self.has_interiors
    }

    /// Makes what lights need before paths begin at them.
    pub fn prepare_emission(&mut self) {
        self.lights.iter_mut().for_each(Light::prepare_emission);
    }

    /// Returns `true` if anything in the world filters over a texture footprint. If not, cameras need not generate ray
    /// differentials.
    pub fn needs_footprint(&self) -> bool {
        self.textures.needs_footprint() || self.materials.iter().any(Material::needs_footprint)
    }

    /// The closest hit along a ray.
    pub fn intersect(&self, ray: &Ray) -> Option<GeometryHit> {
        self.geometry
            .intersect(ray, &|input, point| self.textures.float(input, point))
    }

    /// The same with the parameters (u, v) there, whether or not its material asks for them, if they are `wanted`.
    pub fn intersect_with(&self, ray: &Ray, wanted: bool) -> Option<GeometryHit> {
        let alpha = |input: &FloatInput, point: &TexturePoint| self.textures.float(input, point);
        let found = self.geometry.closest(ray, &alpha)?;
        self.surface_with(ray, &found, wanted)
    }

    /// What [`World::intersect`] hits along each of the `rays`; `found` has as many places. [`World::surface`] tells the rest.
    pub fn closest(&self, rays: &[Ray], found: &mut [Option<ClosestHit>]) {
        let alpha = |input: &FloatInput, point: &TexturePoint| self.textures.float(input, point);
        self.geometry.closest_of_all(rays, &alpha, found);
    }

    /// The surface that this ray has hit.
    #[inline]
    pub fn surface(&self, ray: &Ray, found: &ClosestHit) -> Option<GeometryHit> {
        self.geometry.surface(ray, found, false)
    }

    /// The same with its parameters (u, v), whether or not its material asks for them, if they are `wanted`.
    #[inline]
    pub fn surface_with(&self, ray: &Ray, found: &ClosestHit, wanted: bool) -> Option<GeometryHit> {
        self.geometry.surface(ray, found, wanted)
    }

    /// The parameters (u, v) of what `ray` has hit, whether or not its material asks for them.
    pub fn surface_parameters(&self, ray: &Ray, found: &ClosestHit) -> Vec2 {
        self.geometry.parameters(ray, found)
    }

    /// The light of the nearest surface along a ray; see [`Geometry::intersect_emitter`].
    pub fn intersect_emitter(&self, ray: &Ray) -> EmitterHit {
        self.geometry
            .intersect_emitter(ray, &|input, point| self.textures.float(input, point))
    }

    /// Returns `true` if anything blocks the ray before its end.
    pub fn occluded(&self, ray: &Ray) -> bool {
        self.geometry
            .occluded(ray, &|input, point| self.textures.float(input, point))
    }

    /// Something that blocks each of the `rays` before its end, if there is anything; `found` has as many places.
    pub fn occluders(&self, rays: &[Ray], found: &mut [Option<ClosestHit>]) {
        let alpha = |input: &FloatInput, point: &TexturePoint| self.textures.float(input, point);
        self.geometry.occluders(rays, &alpha, found);
    }

    /// The same for light that surfaces without material let pass: see [`Geometry::passages`].
    pub(crate) fn passages(
        &self,
        rays: &[Ray],
        (found, passages): (&mut [Option<ClosestHit>], &mut [Passage]),
    ) {
        let alpha = |input: &FloatInput, point: &TexturePoint| self.textures.float(input, point);
        self.geometry.passages(rays, &alpha, (found, passages));
    }

    /// See [`Geometry::has_recoverable_surfaces`].
    pub fn has_recoverable_surfaces(&self) -> bool {
        self.has_recoverable_surfaces
    }

    /// Returns `true` if anything moves: if not, times do not matter.
    pub fn moves(&self) -> bool {
        self.moves
    }

    /// The medium that a ray enters which leaves a hit in direction `d`, where `current` is the one it came through.
    pub fn medium_beyond(
        &self,
        hit: &GeometryHit,
        d: Vec3,
        current: Option<MediumId>,
    ) -> Option<MediumId> {
        hit.interface.map_or(current, |id| {
            self.media.interface(id).toward(d, hit.surface.n)
        })
    }

    /// Points about the surfaces from which light may gather in a caustic: half of them for perfectly specular ones, half for others, on each shape as
    /// many as on each other. Up to `count`; none where all is diffuse.
    pub fn points_of_caustics(&self, count: usize) -> Vec<Vec3> {
        let of = |specular: bool| {
            let wanted = |attributes: &PrimitiveAttributes| {
                self.material(attributes.material).is_some_and(|material| {
                    material.may_focus() && material.is_smooth(&self.materials) == specular
                })
            };
            self.geometry.points_about(&wanted, count / 2)
        };
        [of(true), of(false)].concat()
    }

    /// The material of a hit; `None` for a surface without one (`Material "none"`), which rays pass through.
    pub fn material(&self, id: Option<MaterialId>) -> Option<&Material> {
        self.materials.get(id?.index())
    }

    /// The reflectance of a material that is [matte everywhere](Material::even_reflectance).
    #[inline]
    pub fn even_reflectance(&self, id: Option<MaterialId>) -> Option<Rgb> {
        *self.even_reflectances.get(id?.index())?
    }

    /// The lobes of a material that is [coated alike everywhere](Material::even_coat).
    #[inline]
    pub(crate) fn even_coat(&self, id: Option<MaterialId>) -> Option<&CoatedLobes> {
        self.even_coats.get(id?.index())?.as_ref()
    }

    /// The lobe of a material that is a perfectly specular [boundary](Boundary), and the same everywhere.
    #[inline]
    pub(crate) fn even_boundary(&self, id: Option<MaterialId>) -> Option<&Boundary> {
        self.even_boundaries.get(id?.index())?.as_ref()
    }

    /// How the surface scatters at a hit: fills the [empty](Bsdf::empty) `bsdf`, as to return one
    /// would copy its 500 bytes.
    pub fn fill_bsdf<'a>(
        &'a self,
        material: &'a Material,
        surface: &SurfaceHit,
        differentials: Option<&RayDifferentials>,
        bsdf: &mut Bsdf<'a>,
    ) {
        let footprint = surface.footprint(differentials);
        material.fill_bsdf(surface, &footprint, &self.textures, &self.materials, bsdf);
    }

    /// How light continues that the `bsdf` at a hit has transmitted as `sample`; `choice` returns a sample in [0, 1) if
    /// one is needed.
    pub fn subsurface_transport(
        &self,
        material: Option<MaterialId>,
        surface: &SurfaceHit,
        scattered: (&Bsdf, &BsdfSample),
        differentials: Option<&RayDifferentials>,
        choice: impl FnOnce() -> f32,
    ) -> SubsurfaceTransport<'_> {
        let Some(id) = material else {
            return SubsurfaceTransport::STRAIGHT_ON;
        };
        let material = &self.materials[id.index()];
        let footprint = surface.footprint(differentials);
        let (textures, materials) = (&self.textures, &self.materials);
        material.subsurface_transport(surface, scattered, &footprint, textures, materials, choice)
    }

    /// Returns `true` if all light that `bsdf` at a hit transmits, other than by smooth glass, is scattered below the surface.
    pub fn scatters_below(
        &self,
        hit: &GeometryHit,
        bsdf: &Bsdf,
        differentials: Option<&RayDifferentials>,
    ) -> bool {
        if !self.has_interiors || bsdf.receiver_side(hit.surface.wo) != ReceiverSide::BothSides {
            return false;
        }
        let Some(material) = self.material(hit.material) else {
            return false;
        };
        let surface = &hit.surface;
        let footprint = surface.footprint(differentials);
        let (textures, materials) = (&self.textures, &self.materials);
        material.scatters_below(surface, bsdf, &footprint, textures, materials)
    }

    /// The light with this handle.
    pub fn light(&self, id: LightId) -> &Light {
        &self.lights[id.index()]
    }

    /// Radiance along a ray that hits nothing: the sum of all infinite lights.
    pub fn escaped_radiance(&self, ray: &Ray) -> Rgb {
        let infinite = self.infinite_lights.iter();
        infinite.map(|&id| self.light(id).escaped(ray.d)).sum()
    }

    /// Radiance that the surface itself emits back along the ray that hit it.
    pub fn emitted_radiance(&self, hit: &GeometryHit) -> Rgb {
        hit.light
            .map_or(Rgb::ZERO, |id| self.light(id).emitted(&hit.surface))
    }
}

#[cfg(test)]
mod tests;
