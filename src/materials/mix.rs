//! The `mix` material.

use super::lobes::straight;
use super::subsurface_transport::{Part, Parts};
use super::{Bump, Material, MaterialKind, Place, Scattering, may_scatter};
use crate::bsdf::{Bsdf, MAX_LOBES};
use crate::handles::MaterialId;
use crate::inputs::SpectrumInput;
use crate::math::Rgb;
use crate::math::color::is_black;
use crate::params::ParamReader;
use crate::syntax::suggest::nearest;

/// Maximum number of lobes of a mix with everything nested in it, present at once or not: enough for eight materials of
/// eight lobes. More are a mistake, or an attack on rendering time.
const MAX_NESTED: usize = MAX_LOBES * MAX_LOBES;

/// The named materials in scope.
pub trait NamedMaterials {
    /// The material called `name`; the inner `None` is the material `none`.
    fn find(&self, name: &str) -> Option<Option<Named>>;
    /// All names.
    fn names(&self) -> Vec<&str>;
    /// The name that is being defined by `MakeNamedMaterial`.
    fn defining(&self) -> Option<&str>;
}

/// The properties of a named material that a mix needs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Named {
    /// Its handle.
    pub id: MaterialId,
    /// Its bump map.
    pub bump: Option<Bump>,
    /// Maximum number of lobes that it can have at a point, at least 1.
    pub max_lobes: usize,
    /// `true` if there is a subsurface scattering medium inside.
    pub has_interior: bool,
}

impl Named {
    /// The material with this handle.
    pub fn new(id: MaterialId, material: &Material) -> Named {
        Named {
            id,
            bump: material.bump,
            max_lobes: material.kind.scattering().max_lobes(),
            has_interior: material.kind.scattering().has_interior(),
        }
    }
}

/// A weighted sum of two materials' BSDFs, by channel. Parameters: constant strings `namedmaterial1`, `namedmaterial2`
/// (required); spectrum `amount` (0.5): weight of the first, the second gets 1 − amount (the opposite of the `mix`
/// texture's convention).
///
/// As in pbrt the frame and its bumps are the first material's, and `bumpmap` is no parameter here.
/// `none` lets its share of the light straight on (pbrt-v3 crashes), and light that a part lets in
/// wanders below that part ([`super::subsurface_transport`]).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Mix {
    /// The two materials; `None` scatters nothing.
    pub parts: [Option<MaterialId>; 2],
    /// Weight of the first.
    pub amount: SpectrumInput,
    /// Maximum number of lobes that the two can have at a point.
    pub max_lobes: usize,
    /// `true` if there is a subsurface scattering medium inside one of them.
    pub has_interior: bool,
}

impl Mix {
    /// Reads the parameters, and finds the bump map. `None` if a material is missing, or too many are nested; an error
    /// has then been reported.
    pub(super) fn from_params(
        reader: &ParamReader,
        named: &dyn NamedMaterials,
    ) -> Option<(Mix, Option<Bump>)> {
        let first = find(reader, named, "namedmaterial1");
        let second = find(reader, named, "namedmaterial2");
        let amount = reader.spectrum_input("amount", Rgb::splat(0.5));
        let parts = [first?, second?];
        let lobes = |part: Option<Named>| part.map_or(1, |part| part.max_lobes);
        let mix = Mix {
            parts: parts.map(|part| Some(part?.id)),
            amount,
            max_lobes: parts.map(lobes).iter().sum(),
            has_interior: parts.iter().flatten().any(|part| part.has_interior),
        };
        let bump = parts[0].and_then(|first| first.bump);
        mix.check_size(reader).then_some((mix, bump))
    }

    fn check_size(&self, reader: &ParamReader) -> bool {
        let lobes = self.max_lobes;
        if lobes > MAX_NESTED {
            let message = format!("the materials mixed have more than {MAX_NESTED} lobes");
            reader.error("namedmaterial1", message);
            return false;
        }
        if lobes > MAX_LOBES {
            let message = format!(
                "the materials mixed have up to {lobes} lobes: those beyond {MAX_LOBES} at a point are \
                 left out (pbrt-v3 aborts)"
            );
            reader.warn("namedmaterial1", message);
        }
        true
    }

    /// The materials that contribute to the mix at a point, with their weights.
    fn shares(&self, at: &Place) -> impl Iterator<Item = (Option<MaterialId>, Rgb)> {
        let amount = at.reflectance(&self.amount);
        let rest = (Rgb::ONE - amount).max(Rgb::ZERO);
        let shares = self.parts.into_iter().zip([amount, rest]);
        shares.filter(|(_, share)| !is_black(*share))
    }

    /// Adds the materials whose lobes [`Mix::add_lobes`] adds to `parts`, in the same order. `lobes` is the number of
    /// lobes before; returns the number after, if all had room.
    pub(super) fn parts_at(&self, at: &Place, (first, parts): (usize, &mut Parts)) -> usize {
        self.shares(at).fold(first, |first, (part, _)| {
            // `none` has one lobe.
            let Some(material) = part else {
                return first + 1;
            };
            let lobes = match at.materials.get(material.index()) {
                Some(Material {
                    kind: MaterialKind::Mix(mix),
                    ..
                }) => return mix.parts_at(at, (first, parts)),
                Some(other) => first..first + other.lobe_count(at),
                None => return first,
            };
            let next = lobes.end;
            // Those that do not fit have no lobes either.
            if !lobes.is_empty() && first < MAX_LOBES {
                let _ = parts.try_push(Part {
                    material,
                    lobes: first..next.min(MAX_LOBES),
                });
            }
            next
        })
    }
}

/// The material named by the string parameter `param`.
fn find(reader: &ParamReader, named: &dyn NamedMaterials, param: &str) -> Option<Option<Named>> {
    const DONE: &str = "a matte of the mix's parameters is used";
    let Some(name) = reader.find_string(param) else {
        reader.error(param, format!("a mix needs one `string {param}`: {DONE}"));
        return None;
    };
    let Some(part) = named.find(name) else {
        if named.defining() == Some(name) {
            let message = format!("`{name}` cannot be one of its own materials: {DONE}");
            reader.error(param, message);
        } else {
            let suggestion = nearest(name, named.names());
            let message = format!("there is no material `{name}`: {DONE}");
            reader.error_with_suggestion(param, message, suggestion);
        }
        return None;
    };
    if part.is_none() {
        let message = format!("`{name}` does not scatter: its share of the light goes straight on");
        reader.warn(param, message);
    }
    Some(part)
}

impl Scattering for Mix {
    fn add_lobes<'a>(&'a self, at: &Place<'_, 'a>, bsdf: &mut Bsdf<'a>) {
        for (part, share) in self.shares(at) {
            let first = bsdf.lobe_count();
            match part {
                Some(id) => {
                    if let Some(material) = at.materials.get(id.index()) {
                        material.kind.add_lobes(at, bsdf);
                    }
                }
                None => bsdf.extend(straight(Rgb::ONE)),
            }
            bsdf.scale_from(first, share);
        }
    }

    fn max_lobes(&self) -> usize {
        self.max_lobes
    }

    fn has_interior(&self) -> bool {
        self.has_interior
    }

    /// Returns `true` if one of its parts, or the share that passes, is smooth.
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bsdf::testing::{direction, flat_hit, sky_by_sampling, sky_by_value};
    use crate::math::Vec3;
    use crate::params::testing::{Outcome, read};
    use crate::surface::Footprint;
    use crate::textures::Textures;

    /// Some materials, and a name for each and for `none`.
    #[derive(Default)]
    struct Scene {
        names: Vec<(&'static str, Option<usize>)>,
        materials: Vec<Material>,
    }

    impl Scene {
        fn add(&mut self, name: &'static str, kind: &str, params: &str) {
            let made = read(kind, params, |reader| Material::from_params(reader, self)).value;
            let index = made.as_ref().map(|_| self.materials.len());
            self.materials.extend(made);
            self.names.push((name, index));
        }

        fn mix(&self, params: &str) -> Outcome<Option<Material>> {
            read("mix", params, |reader| Material::from_params(reader, self))
        }

        /// The BSDF of a mix, which becomes one of the materials.
        fn bsdf(&mut self, params: &str, wo: Vec3) -> Bsdf<'_> {
            let mix = self.mix(params).value;
            self.materials.extend(mix);
            let (hit, footprint) = (flat_hit(wo), Footprint::default());
            let mix = self.materials.last().expect("a material");
            mix.bsdf(&hit, &footprint, &Textures::default(), &self.materials)
        }
    }

    impl NamedMaterials for Scene {
        fn find(&self, name: &str) -> Option<Option<Named>> {
            let (_, index) = self.names.iter().find(|(n, _)| *n == name)?;
            let named = |i: usize| Named::new(MaterialId(i as u32), &self.materials[i]);
            Some(index.map(named))
        }

        fn names(&self) -> Vec<&str> {
            self.names.iter().map(|(name, _)| *name).collect()
        }

        fn defining(&self) -> Option<&str> {
            Some("me")
        }
    }

    fn scene() -> Scene {
        let mut scene = Scene::default();
        scene.add("red", "matte", "\"rgb Kd\" [.8 .1 .1]");
        scene.add("mirror", "mirror", "\"rgb Kr\" [1 1 1]");
        scene.add("nothing", "none", "");
        scene.add(
            "coat",
            "substrate",
            "\"rgb Kd\" [.5 .5 .5] \"rgb Ks\" [.2 .2 .2]",
        );
        scene.add(
            "half",
            "mix",
            "\"string namedmaterial1\" \"red\" \"string namedmaterial2\" \"coat\"",
        );
        scene
    }

    fn parts(first: &str, second: &str) -> String {
        format!("\"string namedmaterial1\" \"{first}\" \"string namedmaterial2\" \"{second}\" ")
    }

    #[test]
    fn the_amount_weighs_the_first_material() {
        let wo = direction(30.0, 40.0);
        // Red's reflectance and the mirror's, weighted; an amount above 1 leaves nothing over.
        for (amount, expected) in [
            ("", Rgb::new(0.9, 0.55, 0.55)),
            ("\"rgb amount\" [1 0 .25]", Rgb::new(0.8, 1.0, 0.775)),
            ("\"rgb amount\" [2 2 2]", Rgb::new(1.6, 0.2, 0.2)),
            ("\"rgb amount\" [-1 -1 -1]", Rgb::ONE),
        ] {
            let mut scene = scene();
            let bsdf = scene.bsdf(&(parts("red", "mirror") + amount), wo);
            for sky in [sky_by_value(&bsdf, wo, 100), sky_by_sampling(&bsdf, wo, 16)] {
                // The grid's error on a cosine; some of the 16² strata of the number that chooses hold the border of two lobes.
                assert!(
                    (sky - expected).abs().max_element() < 2e-3,
                    "{amount}: {sky}"
                );
            }
        }
    }

    #[test]
    fn a_mix_of_a_mix_weighs_by_both_amounts() {
        let (wo, wi) = (direction(30.0, 40.0), direction(50.0, 190.0));
        let of = |params: &str| scene().bsdf(params, wo).f(wo, wi);
        let [red, coat] = ["red", "coat"].map(|name| of(&parts(name, name)));
        let nested = of(&(parts("half", "mirror") + "\"rgb amount\" [.6 .6 .6]"));
        // Rounding.
        assert!((nested - 0.3 * (red + coat)).abs().max_element() < 1e-6);
    }

    #[test]
    fn none_passes_its_share() {
        let wo = direction(60.0, 0.0);
        let params = parts("red", "nothing") + "\"rgb amount\" [.25 .25 .25]";
        assert_eq!(scene().mix(&params).warnings, 1);
        let sample = scene().bsdf(&params, wo).sample_specular(wo, true, 0.5);
        let sample = sample.expect("a way through");
        assert!((sample.wi + wo).length() < 1e-6);
        assert!((sample.f * sample.wi.z.abs() - 0.75).abs().max_element() < 1e-6);
    }

    #[test]
    fn bumps_are_the_first_materials() {
        let mut scene = scene();
        scene.add("rough", "matte", "\"float bumpmap\" 2");
        assert!(
            scene
                .mix(&parts("rough", "red"))
                .value
                .unwrap()
                .bump
                .is_some()
        );
        assert!(
            scene
                .mix(&parts("red", "rough"))
                .value
                .unwrap()
                .bump
                .is_none()
        );
        let given = scene.mix(&(parts("red", "rough") + "\"float bumpmap\" 1"));
        assert!(given.value.unwrap().bump.is_none() && given.warnings == 1);
    }

    #[test]
    fn names_that_mean_nothing_are_errors() {
        for (params, text) in [
            (parts("red", "miror"), "did you mean `mirror`"),
            (parts("me", "red"), "cannot be one of its own materials"),
            (
                "\"string namedmaterial1\" \"red\"".to_owned(),
                "needs one `string namedmaterial2`",
            ),
        ] {
            let outcome = scene().mix(&params);
            assert_eq!(
                (outcome.errors, outcome.warnings),
                (1, 0),
                "{}",
                outcome.text
            );
            assert!(outcome.text.contains(text), "{}", outcome.text);
            let Some(Material {
                kind: super::super::MaterialKind::Matte(_),
                ..
            }) = outcome.value
            else {
                panic!("a matte stands in")
            };
        }
    }

    #[test]
    fn too_many_lobes_are_left_out_or_refused() {
        let mut scene = scene();
        scene.add(
            "many",
            "uber",
            "\"rgb Kr\" [1 1 1] \"rgb Kt\" [1 1 1] \"rgb opacity\" [.5 .5 .5]",
        );
        let (params, wo) = (parts("many", "many"), direction(30.0, 0.0));
        let outcome = scene.mix(&params);
        assert_eq!(
            (outcome.errors, outcome.warnings),
            (0, 1),
            "{}",
            outcome.text
        );
        assert!(outcome.text.contains("up to 10 lobes"), "{}", outcome.text);
        assert_eq!(scene.bsdf(&params, wo).lobe_count(), MAX_LOBES);
        // Two to the power of that many would take practically forever, and so deep a chain would exhaust the stack.
        let names = ["0", "1", "2", "3", "4", "5", "6", "7", "8", "9"];
        let mut below = "red";
        let mut errors = 0;
        for name in names {
            let params = parts(below, below);
            errors += scene.mix(&params).errors;
            scene.add(name, "mix", &params);
            below = name;
        }
        // 2⁷ lobes are too many; the matte that replaces the mix starts again at 1.
        assert_eq!(errors, 1);
    }
}
