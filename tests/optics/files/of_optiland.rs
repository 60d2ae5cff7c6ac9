//! One lens, written by optiland 0.6.3 in four formats: an aspheric doublet, a stop, a conic single lens. No file gives a clear diameter. The rays are
//! what optiland traces, through the paraxial entrance pupil; the index of its Abbe glass, given as 1.72, is 1.7196401257171294 there.

use fstop::optics::prescription::{Glasses, agf, optiland, oslo, seq, zmx};
use fstop::optics::{Lens, LensRay, Prescription};

/// N-BK7 of Schott's data sheet, whose formula optiland uses.
const CATALOGUE: &str = "NM N-BK7 2 517642.251 1.5168 64.17 0 1 -1\nCD 1.03961212 0.00600069867 0.231792344 0.0200179144 1.01046945 103.560653\nLD 0.3 2.5\n";

/// Field in degrees, height on the front surface, on the film, and direction cosine there.
const RAYS: [[f64; 4]; 6] = [
    [0.0, 3.0, -0.15107725799273908, -0.04650593326624161],
    [
        5.0,
        -6.930306476552941,
        6.3379423790779725,
        0.18166531704497088,
    ],
    [
        5.0,
        5.0532304283620695,
        5.586501636784634,
        -0.004116738781798257,
    ],
    [
        8.0,
        -1.5480201330962469,
        9.534698173337244,
        0.1429327256718403,
    ],
    [
        8.0,
        -7.485018324586338,
        10.076439000331337,
        0.2346446913211364,
    ],
    [
        8.0,
        4.472626597775659,
        9.086837444310927,
        0.04880803858421782,
    ],
];
/// Of the axial beam at the stop, mm.
const STOP: f64 = 5.50270337598577;

/// Its rays are optiland's to `tolerance` mm.
fn check(lens: &Prescription, tolerance: f64, about: &str) {
    assert_eq!(lens.surfaces.len(), 6, "{about}");
    assert_eq!(lens.film_distance, 55.0, "{about}");
    let stop = &lens.surfaces[3];
    assert!(
        stop.is_stop && (0.5 * stop.aperture - STOP).abs() < tolerance,
        "{about} {stop:?}"
    );
    // The widest ray of the widest field, which goes through the rim of the stop and not of the paraxial pupil, is 0.2 % farther out.
    let front = 0.5 * lens.surfaces[0].aperture;
    assert!((7.485..7.51).contains(&front), "{about} {front}");
    let bench = Lens::new(lens, lens.film_distance).unwrap();
    for [field, height, image, direction] in RAYS {
        let (sine, cosine) = field.to_radians().sin_cos();
        let from = [0.0, height, lens.surfaces[0].sag(height)];
        let ray = bench
            .tracer()
            .to_film(&LensRay::new(from, [0.0, sine, cosine]));
        let ray = ray.unwrap_or_else(|e| panic!("{about}, {field}° at {height}: {e}"));
        let y = ray.o[1] + (bench.film_z() - ray.o[2]) * ray.d[1] / ray.d[2];
        assert!((y - image).abs() < tolerance, "{about}: {y} {image}");
        assert!(
            (ray.d[1] - direction).abs() < tolerance,
            "{about}: {} {direction}",
            ray.d[1]
        );
    }
}

#[test]
fn four_formats_say_the_same_lens() {
    let glasses = Glasses::COMMON.with(agf::parse(CATALOGUE));
    let text = include_str!("lenses/optiland.zmx");
    // Numbers of 17 digits. What is left is how exactly optiland solves for points of aspheres: 3e-8 mm on the film.
    let zemax = zmx::parse(text, &glasses).unwrap();
    check(&zemax, 1e-7, "zmx");
    let text = include_str!("lenses/optiland.len");
    check(&oslo::parse(text, &glasses).unwrap(), 1e-7, "len");
    // Indices of six digits: 1.3e-7 off.
    let text = include_str!("lenses/optiland.seq");
    let codev = seq::parse(text, &glasses).unwrap();
    check(&codev, 2e-6, "seq");
    assert!(
        codev
            .warnings
            .iter()
            .any(|w| w.message.contains("written by optiland"))
    );
    let text = include_str!("lenses/optiland.json");
    let native = optiland::parse(text, &glasses).unwrap();
    assert_eq!(
        (native.surfaces[1].index, native.surfaces[1].abbe),
        (1.72, Some(29.5))
    );
    let traced = text.replace("1.72,", "1.7196401257171294,");
    check(&optiland::parse(&traced, &glasses).unwrap(), 1e-7, "json");
    assert_eq!(native.surfaces[0].asphere, zemax.surfaces[0].asphere);
    assert_eq!(native.surfaces[0].glass, zemax.surfaces[0].glass);
}

/// A lens whose vertices were placed by hand, or that was solved for, has thicknesses of another state.
#[test]
fn vertices_say_how_thick_a_lens_is() {
    let glasses = Glasses::COMMON.with(agf::parse(CATALOGUE));
    let text = include_str!("lenses/optiland.json");
    let lens = optiland::parse(text, &glasses).unwrap();
    let mut value: serde_json::Value = serde_json::from_str(
        &text
            .replace("-Infinity", "null")
            .replace("Infinity", "null"),
    )
    .unwrap();
    for surface in value["surface_group"]["surfaces"].as_array_mut().unwrap() {
        surface["thickness"] = 0.0.into();
    }
    let placed = optiland::parse(&value.to_string(), &glasses).unwrap();
    for (a, b) in lens.surfaces.iter().zip(&placed.surfaces) {
        assert!(
            (a.thickness - b.thickness).abs() < 1e-9,
            "{} {}",
            a.thickness,
            b.thickness
        );
    }
    assert!((lens.film_distance - placed.film_distance).abs() < 1e-9);
    let first = &mut value["surface_group"]["surfaces"][1];
    first["interaction_model"]["type"] = "ThinLensInteractionModel".into();
    let error = optiland::parse(&value.to_string(), &glasses).unwrap_err();
    assert!(
        error.to_string().contains("ThinLensInteractionModel"),
        "{error}"
    );
}
