//! Physical laws of scattering, tested for every lobe: samples follow their density and the density integrates to one,
//! evaluating and sampling give the same image, energy is conserved (white furnace), and scattering is reciprocal.
//!
//! [`table`] has a row for each. A new kind of lobe does not compile without an entry in [`Lobe::kind`], and does not
//! pass without a row in the table. Where a lobe's model violates a law, its row says so and why; what remains of the
//! law is tested.

use super::clearcoat::Clearcoat;
use super::disney_diffuse::DisneyDiffuse;
use super::fourier::{FourierLobe, FourierTable};
use super::fresnel::Fresnel;
use super::fresnel_blend::FresnelBlend;
use super::hair::Hair;
use super::lambertian::{LambertianReflection, LambertianTransmission};
use super::measured::MeasuredLobe;
use super::measured::tests::{glossy_list, glossy_table};
use super::microfacet::{MicrofacetReflection, MicrofacetTransmission, MirroredReflection};
use super::oren_nayar::OrenNayar;
use super::specular::{FresnelSpecular, SpecularReflection, SpecularTransmission};
use super::subsurface_exit::SubsurfaceExit;
use super::testing::*;
use super::trowbridge_reitz::TrowbridgeReitz;
use super::*;
use crate::assets::bsdf_file::BsdfFile;
use crate::assets::bsdf_file::generator::{Analytic, encode};

/// Number of kinds of lobes.
const KINDS: usize = 16;

impl Lobe<'_> {
    /// A number below [`KINDS`] for each kind.
    fn kind(&self) -> usize {
        match self {
            Lobe::LambertianReflection(_) => 0,
            Lobe::LambertianTransmission(_) => 1,
            Lobe::OrenNayar(_) => 2,
            Lobe::SpecularReflection(_) => 3,
            Lobe::SpecularTransmission(_) => 4,
            Lobe::FresnelSpecular(_) => 5,
            Lobe::MicrofacetReflection(_) => 6,
            Lobe::MicrofacetTransmission(_) => 7,
            Lobe::MirroredReflection(_) => 8,
            Lobe::FresnelBlend(_) => 9,
            Lobe::DisneyDiffuse(_) => 10,
            Lobe::Clearcoat(_) => 11,
            Lobe::Hair(_) => 12,
            Lobe::SubsurfaceExit(_) => 13,
            Lobe::Fourier(_) => 14,
            Lobe::Measured(_) => 15,
        }
    }
}

/// The fraction of incident light that a lobe of reflectance 1 scatters.
enum Energy {
    /// All of it.
    All,
    /// Some is lost.
    Less,
    /// The model creates energy: the largest ratio to the incident light, and why.
    Made { most: f32, why: &'static str },
}

/// `true` if the BSDF is reciprocal.
enum Reciprocity {
    /// It is, with this refractive index below the surface.
    Holds { eta: f32 },
    /// By the model it is not, and why.
    Broken { why: &'static str },
}

/// One lobe or several, and their expected properties.
struct Row {
    name: &'static str,
    lobes: Vec<Lobe<'static>>,
    energy: Energy,
    reciprocity: Reciprocity,
}

impl Row {
    fn new(name: &'static str, energy: Energy, lobes: Vec<Lobe<'static>>) -> Row {
        Row {
            name,
            lobes,
            energy,
            reciprocity: Reciprocity::Holds { eta: 1.0 },
        }
    }

    fn with_eta(self, eta: f32) -> Row {
        Row {
            reciprocity: Reciprocity::Holds { eta },
            ..self
        }
    }

    fn bsdf(&self) -> Bsdf<'static> {
        let hit = flat_hit(Vec3::Z);
        let mut bsdf = Bsdf::new(hit.n, &hit.shading);
        self.lobes.iter().for_each(|&lobe| bsdf.add(lobe));
        bsdf
    }

    fn is_specular(&self) -> bool {
        self.lobes.iter().all(Lobe::is_specular)
    }
}

const ONE: Rgb = Rgb::ONE;

const SMOOTH: Fresnel = Fresnel::Dielectric {
    eta_i: 1.0,
    eta_t: 1.5,
};

fn ggx(x: f32, y: f32) -> TrowbridgeReitz {
    TrowbridgeReitz::new(x, y)
}

fn glossy(distribution: TrowbridgeReitz, fresnel: Fresnel) -> MicrofacetReflection {
    MicrofacetReflection {
        reflectance: ONE,
        distribution,
        fresnel,
    }
}

fn rough_glass(distribution: TrowbridgeReitz, eta_b: f32) -> Vec<Lobe<'static>> {
    let fresnel = Fresnel::Dielectric {
        eta_i: 1.0,
        eta_t: eta_b,
    };
    vec![
        Lobe::MicrofacetReflection(glossy(distribution, fresnel)),
        Lobe::MicrofacetTransmission(MicrofacetTransmission {
            transmittance: ONE,
            distribution,
            eta_a: 1.0,
            eta_b,
        }),
    ]
}

fn blend(diffuse: f32, specular: f32, x: f32, y: f32) -> Lobe<'static> {
    Lobe::FresnelBlend(FresnelBlend {
        diffuse: Rgb::splat(diffuse),
        specular: Rgb::splat(specular),
        distribution: ggx(x, y),
        scale: ONE,
    })
}

fn disney(base: f32, flat: f32, sheen: f32, roughness: f32) -> Lobe<'static> {
    Lobe::DisneyDiffuse(DisneyDiffuse {
        reflectance: ONE,
        base,
        flat,
        sheen: Rgb::splat(sheen),
        roughness,
    })
}

/// A table of a white diffuse surface, leaked: rows live as long as the tests.
fn tabulated() -> Row {
    let file = encode(&Analytic {
        eta: 1.0,
        channels: 1,
        cosines: 32,
        terms: 2,
        value: &|mu_i, mu_o, _| [if mu_i * mu_o < 0.0 { 0.9 } else { 0.0 }; 3],
    });
    let file = BsdfFile::parse(&file).expect("a good file");
    let table = Box::leak(Box::new(FourierTable::new(file)));
    let lobe = Lobe::Fourier(FourierLobe::new(table));
    Row::new("tabulated", Energy::Less, vec![lobe])
}

/// A measured BRDF of each format, leaked.
fn measured() -> [Row; 2] {
    let row = |name, table| {
        let table = Box::leak(Box::new(table));
        let lobe = Lobe::Measured(MeasuredLobe::new(table));
        Row::new(name, Energy::Less, vec![lobe])
    };
    [
        row("measured by half angles", glossy_table([24, 12, 24])),
        row("measured here and there", glossy_list(9, 9)),
    ]
}

/// The exit of a path under a surface of index 1.33.
fn subsurface_exit() -> Row {
    let made = Energy::Made {
        // η² is 1.769; the rest is for noise.
        most: 1.78,
        why: "radiance is η² times as large inside, which the other end of the path takes back",
    };
    Row {
        reciprocity: Reciprocity::Broken {
            why: "it is one end of a path, and the other end has the factor of the outgoing direction",
        },
        ..Row::new(
            "subsurface exit",
            made,
            vec![Lobe::SubsurfaceExit(SubsurfaceExit::new(1.33))],
        )
    }
}

fn hair(h: f32, sigma_a: f32, beta_m: f32, beta_n: f32) -> Row {
    Row {
        reciprocity: Reciprocity::Broken {
            why: "attenuation and the scales' tilt are those of the outgoing direction alone, and the \
                  cosine divided by is the incoming one's (Chiang et al. 2016, as in pbrt-v3)",
        },
        ..Row::new(
            "hair",
            if sigma_a > 0.0 {
                Energy::Less
            } else {
                Energy::All
            },
            vec![Lobe::Hair(Hair::new(
                h,
                1.55,
                Rgb::splat(sigma_a),
                [beta_m, beta_n],
                2.0,
            ))],
        )
    }
}

/// Every kind of lobe, with settings that exercise its terms.
fn table() -> Vec<Row> {
    let [half_angles, scattered] = measured();
    use Energy::{All, Less, Made};
    let lambert = Lobe::LambertianReflection(LambertianReflection { reflectance: ONE });
    let mirror = Lobe::SpecularReflection(SpecularReflection {
        reflectance: ONE,
        fresnel: Fresnel::NoOp,
    });
    let through = |eta_b| {
        Lobe::SpecularTransmission(SpecularTransmission {
            transmittance: ONE,
            eta_a: 1.0,
            eta_b,
        })
    };
    let smooth = Lobe::FresnelSpecular(FresnelSpecular {
        reflectance: ONE,
        transmittance: ONE,
        eta_a: 1.0,
        eta_b: 1.5,
        evenness: 0.0,
    });
    let other_side = Lobe::LambertianTransmission(LambertianTransmission { transmittance: ONE });
    let metallic = Fresnel::Disney {
        r0: Rgb::new(0.9, 0.5, 0.1),
        metallic: 0.6,
        eta: 1.4,
    };
    let reflect = |d, f| vec![Lobe::MicrofacetReflection(glossy(d, f))];
    let mirrored = Lobe::MirroredReflection(MirroredReflection(glossy(ggx(0.3, 0.3), SMOOTH)));
    let coat = |alpha| Lobe::Clearcoat(Clearcoat { weight: ONE, alpha });
    let retro =
        "retro-reflection brightens the rim of rough surfaces beyond the base (Burley 2012, §5.3)";
    let sheet =
        "so does the imitated subsurface scattering, flattest at the rim (Burley 2012, §5.3)";
    vec![
        Row::new("Lambert", All, vec![lambert]),
        Row::new("Lambert, other side", All, vec![other_side]),
        Row::new(
            "Oren–Nayar",
            Less,
            vec![Lobe::OrenNayar(OrenNayar::new(ONE, 30.0))],
        ),
        Row::new("mirror", All, vec![mirror]),
        Row::new("refraction", Less, vec![through(1.5)]),
        Row::new("straight on", All, vec![through(1.0)]),
        Row::new("smooth glass", All, vec![smooth]),
        Row::new("glossy", Less, reflect(ggx(0.15, 0.15), Fresnel::NoOp)),
        Row::new(
            "glossy, anisotropic",
            Less,
            reflect(ggx(0.5, 0.15), Fresnel::NoOp),
        ),
        Row::new("glossy, very rough", Less, reflect(ggx(1.2, 1.2), SMOOTH)),
        Row::new(
            "Disney's metal",
            Less,
            reflect(ggx(0.2, 0.6).separable(), metallic),
        ),
        Row::new("rough glass 0.2", Less, rough_glass(ggx(0.2, 0.2), 1.5)).with_eta(1.5),
        Row::new("rough glass 0.5", Less, rough_glass(ggx(0.5, 0.3), 1.5)).with_eta(1.5),
        Row::new("rough bubble", Less, rough_glass(ggx(0.3, 0.3), 0.8)).with_eta(0.8),
        Row::new(
            "Disney's glass",
            Less,
            rough_glass(ggx(0.3, 0.3).separable(), 1.4),
        )
        .with_eta(1.4),
        Row::new("mirrored glossy", Less, vec![mirrored]),
        Row::new("substrate", Less, vec![blend(1.0, 0.2, 0.3, 0.3)]),
        Row::new(
            "substrate, anisotropic",
            Less,
            vec![blend(0.5, 0.5, 0.2, 0.6)],
        ),
        Row::new("Disney's base", Less, vec![disney(1.0, 0.0, 0.0, 0.0)]),
        Row::new(
            "Disney's retro",
            Made {
                most: 1.45,
                why: retro,
            },
            vec![disney(1.0, 0.0, 0.0, 1.0)],
        ),
        Row::new(
            "Disney's sheet",
            Made {
                most: 1.85,
                why: sheet,
            },
            vec![disney(0.3, 0.7, 0.0, 0.8)],
        ),
        Row::new("Disney's sheen", Less, vec![disney(0.0, 0.0, 1.0, 0.0)]),
        Row::new("clearcoat 0.1", Less, vec![coat(0.1)]),
        Row::new("clearcoat 0.3", Less, vec![coat(0.3)]),
        Row::new(
            "diffuse, glossy and mirror",
            Made {
                most: 3.0,
                why: "three lobes of 1",
            },
            [vec![lambert, mirror], reflect(ggx(0.3, 0.2), Fresnel::NoOp)].concat(),
        ),
        subsurface_exit(),
        tabulated(),
        half_angles,
        scattered,
        hair(0.0, 0.0, 0.3, 0.3),
        hair(0.6, 0.0, 0.5, 0.2),
        hair(-0.95, 0.0, 0.2, 0.9),
        hair(0.3, 0.5, 0.4, 0.4),
        hair(1.0, 0.2, 0.3, 0.3),
    ]
}

#[test]
fn every_kind_of_lobe_is_in_the_table() {
    let mut seen = [false; KINDS];
    for row in table() {
        row.lobes.iter().for_each(|lobe| seen[lobe.kind()] = true);
    }
    assert_eq!(seen, [true; KINDS]);
}

/// Chi-squared test with failed samples as one more bin: so the density and what is lost sum to one.
#[test]
fn samples_follow_their_density() {
    for row in table().iter().filter(|row| !row.is_specular()) {
        let bsdf = row.bsdf();
        for degrees in [0.0, 75.0, 130.0] {
            let name = format!("{} at {degrees}°", row.name);
            check_sampling(&name, &bsdf, direction(degrees, 25.0));
        }
    }
}

#[test]
fn value_and_sampling_agree_on_a_white_sky() {
    for row in table().iter().filter(|row| !row.is_specular()) {
        let bsdf = row.bsdf();
        for degrees in [20.0, 120.0] {
            let wo = direction(degrees, 10.0);
            let (a, b) = (
                sky_by_value(&bsdf, wo, 400).x,
                sky_by_sampling(&bsdf, wo, 40).x,
            );
            // Standard error of 40³ stratified samples, and the grid's on the narrowest lobe; from
            // inside glass radiance is up to 2.25 times as high.
            assert!(
                (a - b).abs() < 0.004 * a.max(1.0),
                "{} at {degrees}°: {a} integrated, {b} sampled",
                row.name
            );
        }
    }
}

#[test]
fn no_lobe_makes_light_but_where_its_model_does() {
    for row in table() {
        let bsdf = row.bsdf();
        let directions = [0.0, 30.0, 60.0, 85.0, 110.0, 170.0];
        let albedo = directions.map(|degrees| albedo(&bsdf, direction(degrees, 10.0), 30));
        let most = albedo.into_iter().fold(0.0, f32::max);
        // Standard error of 30³ stratified samples.
        const NOISE: f32 = 0.006;
        let name = row.name;
        match row.energy {
            Energy::All => {
                let least = albedo.into_iter().fold(f32::MAX, f32::min);
                assert!(
                    least > 1.0 - NOISE && most < 1.0 + NOISE,
                    "{name}: {albedo:?}"
                );
            }
            Energy::Less => assert!(most < 1.0 + NOISE, "{name}: {albedo:?}"),
            Energy::Made { most: bound, why } => {
                assert!(
                    most < bound && most > 1.0,
                    "{name}: {albedo:?}, though {why}"
                );
            }
        }
    }
}

#[test]
fn light_goes_back_as_it_came_but_where_the_model_forbids() {
    for row in table().iter().filter(|row| !row.is_specular()) {
        match row.reciprocity {
            Reciprocity::Holds { eta } => check_reciprocity(row.name, &row.bsdf(), eta),
            Reciprocity::Broken { why } => {
                let (a, b) = (Vec3::new(0.6, 0.0, 0.8), direction(20.0, 80.0));
                let (f, g) = (row.bsdf().f(a, b).x, row.bsdf().f(b, a).x);
                assert!(
                    (f - g).abs() > 1e-3 * f,
                    "{}: is it still true that {why}?",
                    row.name
                );
            }
        }
    }
}

#[test]
fn wild_directions_and_numbers_do_no_harm() {
    for row in table() {
        let bsdf = row.bsdf();
        let grazing = [direction(89.9999, 0.0), direction(90.001, 3.0)];
        for wo in [Vec3::X, Vec3::Y, Vec3::Z, -Vec3::Z]
            .into_iter()
            .chain(grazing)
        {
            for u in [0.0, 0.5, 1.0 - f32::EPSILON / 2.0] {
                for v in [0.0, 0.5, 1.0 - f32::EPSILON / 2.0] {
                    if let Some(s) = bsdf.sample(wo, u, Vec2::new(v, u)) {
                        assert!(s.f.is_finite() && s.pdf > 0.0 && s.wi.is_finite());
                    }
                }
            }
            for wi in [Vec3::X, Vec3::Z, -wo, wo] {
                assert!(
                    !bsdf.f(wo, wi).is_nan() && !bsdf.pdf(wo, wi).is_nan(),
                    "{}",
                    row.name
                );
            }
        }
    }
}
