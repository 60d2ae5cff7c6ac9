//! The types of lights: one table for names, the reader and the dispatch.

use super::*;
use crate::shapes::emitter::Emitter;

macro_rules! light_types {
    (
        sources { $($name:literal $(or $alias:literal)? => $Type:ident($Spec:ident, $Light:ident),)* }
        areas { $($Area:ident($AreaLight:ident),)* }
    ) => {
        /// The types of `LightSource`, with their parameters.
        #[derive(Clone, Debug, PartialEq)]
        pub enum LightKind {
            $(#[doc = concat!("`", $name, "`")] $Type($Spec),)*
        }

        impl LightSpec {
            /// The types that a `LightSource` may name.
            pub const KINDS: &'static [&'static str] = &[$($name, $($alias,)?)*];

            /// Reads a `LightSource` under the transformation `light_to_world`. `None`, after a report,
            /// where no light can be made of it.
            pub fn from_params(reader: &ParamReader, light_to_world: &Transform) -> Option<LightSpec> {
                if !light_to_world.is_invertible() {
                    reader.accept_all();
                    let problem = "the transformation of this light source cannot be inverted";
                    reader.error("", format!("{problem}; {LEFT_OUT}"));
                    return None;
                }
                match reader.kind() {
                    $($name $(| $alias)? => Some(LightSpec {
                        kind: LightKind::$Type($Spec::from_params(reader, light_to_world)),
                        map: $Light::MAPPED.then(|| reader.optional_file("mapname")).flatten(),
                    }),)*
                    _ => {
                        reader.unknown_kind_replaced(LightSpec::KINDS, LEFT_OUT);
                        None
                    }
                }
            }

            /// The name of its type in scene files.
            pub fn name(&self) -> &'static str {
                match self.kind { $(LightKind::$Type(_) => $name,)* }
            }
        }

        /// A light source in render space. Of many lights nearly all are shapes, and all take as much memory as the largest type: the
        /// others are apart.
        #[derive(Clone, Debug)]
        pub enum Light {
            $(#[doc = concat!("`", $name, "`")] $Type(Box<$Light>),)*
            $(#[doc = "A shape that emits."] $Area($AreaLight),)*
        }

        impl Light {
            /// The light of a `LightSource`. `map` is the image of one that names one
            /// ([`LightSpec::map`]) and whose file could be read.
            pub fn new(spec: &LightSpec, map: Option<LightMap>, render_from_world: &Transform) -> Light {
                match &spec.kind {
                    $(LightKind::$Type(s) => Light::$Type(Box::new($Light::new(s, map, render_from_world))),)*
                }
            }

            /// The name of its type in scene files; an emitting shape is `area`.
            pub fn name(&self) -> &'static str {
                match self { $(Light::$Type(_) => $name,)* $(Light::$Area(_) => "area",)* }
            }

            /// Chooses a way for light to come to `from`, by `u` in [0, 1)². `None` where none was found:
            /// it counts as a sample that brings nothing.
            #[inline]
            pub fn sample(&self, from: &ReferencePoint, u: Vec2) -> Option<LightSample> {
                match self { $(Light::$Type(l) => l.sample(from, u),)* $(Light::$Area(l) => l.sample(from, u),)* }
            }

            /// [`Light::sample`], and where on the light that came from.
            pub fn sample_with_end(&self, from: &ReferencePoint, u: Vec2) -> Option<(LightSample, LightEnd)> {
                match self {
                    $(Light::$Type(l) => l.sample_with_end(from, u),)*
                    $(Light::$Area(l) => l.sample_with_end(from, u),)*
                }
            }

            /// Makes what [`Light::emit`] chooses the directions of an image by; without it they are chosen evenly.
            pub fn prepare_emission(&mut self) {
                match self {
                    $(Light::$Type(l) => l.prepare_emission(),)*
                    $(Light::$Area(l) => l.prepare_emission(),)*
                }
            }

            /// Chooses a ray of its light into `scene`, by numbers in [0, 1)². `None` where none was found: it counts
            /// as one that brings nothing.
            pub fn emit(&self, scene: &SceneSphere, u_position: Vec2, u_direction: Vec2) -> Option<Emission> {
                match self {
                    $(Light::$Type(l) => l.emit(scene, u_position, u_direction),)*
                    $(Light::$Area(l) => l.emit(scene, u_position, u_direction),)*
                }
            }

            /// [`Light::emit`] in a given unit direction: a ray from a point chosen by `u_position`, with the densities that
            /// `emit` has for it. `None` for lights at infinity.
            pub fn emit_toward(&self, u_position: Vec2, d: Vec3) -> Option<Emission> {
                match self {
                    $(Light::$Type(l) => l.emit_toward(u_position, d),)*
                    $(Light::$Area(l) => l.emit_toward(u_position, d),)*
                }
            }

            /// The densities with which [`Light::emit`] chooses a ray in unit direction `d`: of an area light, from any
            /// point of it where hits report the unit geometric normal `n`. What `emit` cannot choose has density 0,
            /// but where it has no alternative it is not asked whether `d` is the one.
            pub fn emission_density(&self, scene: &SceneSphere, n: Vec3, d: Vec3) -> EmissionDensity {
                let density = match self {
                    $(Light::$Type(l) => l.emission_density(scene, n, d),)*
                    $(Light::$Area(l) => l.emission_density(scene, n, d),)*
                };
                density.or_zero()
            }

            /// Density per solid angle with which [`Light::sample`] chooses the unit direction `wi`; 0 for
            /// delta lights. An area light needs `hit`, where a ray from `from` along `wi` met it.
            pub fn pdf(&self, from: &ReferencePoint, wi: Vec3, hit: Option<&SurfaceHit>) -> f32 {
                match self {
                    $(Light::$Type(l) => l.pdf(from, wi, hit),)*
                    $(Light::$Area(l) => l.pdf(from, wi, hit),)*
                }
            }

            /// Radiance along a ray in unit direction `d` that leaves the scene.
            pub fn escaped(&self, d: Vec3) -> Rgb {
                match self { $(Light::$Type(l) => l.escaped(d),)* $(Light::$Area(l) => l.escaped(d),)* }
            }

            /// [`Light::escaped`] and [`Light::pdf`] of a direction that meets nothing, together.
            pub fn escaped_and_pdf(&self, from: &ReferencePoint, d: Vec3) -> (Rgb, f32) {
                match self {
                    $(Light::$Type(l) => l.escaped_and_pdf(from, d),)*
                    $(Light::$Area(l) => l.escaped_and_pdf(from, d),)*
                }
            }

            /// Radiance that leaves the surface point `hit` of this area light toward `hit.wo`.
            pub fn emitted(&self, hit: &SurfaceHit) -> Rgb {
                match self { $(Light::$Type(l) => l.emitted(hit),)* $(Light::$Area(l) => l.emitted(hit),)* }
            }

            /// Flux into a scene whose bounding sphere has radius `scene_radius`.
            pub fn power(&self, scene_radius: f32) -> Rgb {
                match self {
                    $(Light::$Type(l) => l.power(scene_radius),)*
                    $(Light::$Area(l) => l.power(scene_radius),)*
                }
            }

            /// Returns `true` if no ray can meet the light by chance.
            pub fn is_delta(&self) -> bool {
                match self { $(Light::$Type(_) => $Light::IS_DELTA,)* $(Light::$Area(_) => $AreaLight::IS_DELTA,)* }
            }

            /// Returns `true` if rays that leave the scene see the light.
            pub fn is_infinite(&self) -> bool {
                match self { $(Light::$Type(_) => $Light::IS_INFINITE,)* $(Light::$Area(_) => false,)* }
            }

            /// Returns `true` if the light comes from infinitely far away, seen by rays that leave the scene or not.
            pub fn is_at_infinity(&self) -> bool {
                match self { $(Light::$Type(_) => $Light::IS_AT_INFINITY,)* $(Light::$Area(_) => false,)* }
            }

            /// How many samples `directlighting` takes of this light under its strategy "all".
            pub fn sample_count(&self) -> u32 {
                match self { $(Light::$Type(l) => l.sample_count(),)* $(Light::$Area(l) => l.sample_count(),)* }
            }

            /// The shape that it is, and how that shines; `None` for other lights.
            #[inline]
            pub(crate) fn shape(&self) -> Option<(&Emitter, Glow)> {
                match self { $(Light::$Type(_) => None,)* $(Light::$Area(l) => Some(l.parts()),)* }
            }

            /// Lights with the same number are pieces of one thing, such as a mesh's triangles.
            pub(super) fn group(&self) -> Option<u32> {
                match self { $(Light::$Type(l) => l.group(),)* $(Light::$Area(l) => l.group(),)* }
            }

            /// Roughly where, and how strongly, the light arrives.
            pub(super) fn bounds(&self) -> LightBounds {
                match self { $(Light::$Type(l) => l.bounds(),)* $(Light::$Area(l) => l.bounds(),)* }
            }
        }
    };
}

// A new type: its file, which implements `from_params`, `new` and `LightType`, and a line here.
light_types! {
    sources {
        "distant" => Distant(DistantSpec, DistantLight),
        "goniometric" => Goniometric(GoniometricSpec, GoniometricLight),
        "infinite" or "exinfinite" => Infinite(InfiniteSpec, InfiniteLight),
        "point" => Point(PointSpec, PointLight),
        "projection" => Projection(ProjectionSpec, ProjectionLight),
        "spot" => Spot(SpotSpec, SpotLight),
    }
    areas {
        DiffuseArea(DiffuseAreaLight),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_light_of_many_is_small() {
        // Corners, normals where there are any, radiance, samples and group of a mesh's triangle.
        assert!(size_of::<Light>() <= 72);
    }
}
