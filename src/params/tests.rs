//! Look-ups as pbrt-v3 makes them (docs/scene-language.md §1.3 and §1.4).

use super::testing::{Surroundings, read, read_in};
use super::*;
use crate::inputs::{FloatInput, SpectrumInput};
use crate::math::{DVec3, Rgb};
use crate::syntax::{Diagnostics, DirectiveKind, Parser, SearchFolder, SourceMap, Span};

/// Reads without any message.
fn quiet<T>(params: &str, look_up: impl FnOnce(&ParamReader<'_>) -> T) -> T {
    let outcome = read("sphere", params, look_up);
    assert!(outcome.messages.is_empty(), "{params}\n{}", outcome.text);
    outcome.value
}

/// Reads with exactly these messages.
fn told<T>(params: &str, messages: &[&str], look_up: impl FnOnce(&ParamReader<'_>) -> T) -> T {
    let outcome = read("sphere", params, look_up);
    assert_eq!(outcome.messages, messages, "{params}\n{}", outcome.text);
    outcome.value
}

#[test]
fn each_type_is_found() {
    assert_eq!(quiet("\"float x\" 1.5", |p| p.find_float("x")), Some(1.5));
    assert_eq!(quiet("\"integer x\" -3", |p| p.find_integer("x")), Some(-3));
    assert_eq!(
        quiet("\"integer x\" 1e30", |p| p.find_integer("x")),
        Some(i64::MAX)
    );
    assert_eq!(
        quiet("\"bool x\" \"true\"", |p| p.find_boolean("x")),
        Some(true)
    );
    let string = quiet("\"string x\" \"a b\"", |p| {
        p.find_string("x").map(str::to_owned)
    });
    assert_eq!(string.as_deref(), Some("a b"));
    assert_eq!(
        quiet("\"point x\" [1 2 3]", |p| p.find_point3("x")),
        Some(DVec3::new(1., 2., 3.))
    );
    assert_eq!(
        quiet("\"vector3 x\" [1 2 3]", |p| p.find_vector3("x")),
        Some(DVec3::new(1., 2., 3.))
    );
    let list = |numbers: Option<&[f64]>| numbers.map(<[f64]>::to_vec);
    let six = Some(vec![1., 2., 3., 4., 5., 6.]);
    assert_eq!(
        quiet("\"float x\" [1 2 3 4 5 6]", |p| list(p.floats("x"))),
        six
    );
    assert_eq!(
        quiet("\"integer x\" [1 2 3 4 5 6]", |p| list(p.integers("x"))),
        six
    );
    assert_eq!(
        quiet("\"point3 x\" [1 2 3 4 5 6]", |p| list(p.points3("x"))),
        six
    );
    assert_eq!(
        quiet("\"vector x\" [1 2 3 4 5 6]", |p| list(p.vectors3("x"))),
        six
    );
    assert_eq!(
        quiet("\"normal x\" [1 2 3 4 5 6]", |p| list(p.normals("x"))),
        six
    );
    assert_eq!(
        quiet("\"point2 x\" [1 2 3 4 5 6]", |p| list(p.points2("x"))),
        six
    );
    assert_eq!(
        quiet("\"float x\" [1 2 3 4 5 6]", |p| list(p.points2("x"))),
        six
    );
    assert_eq!(
        quiet("\"string x\" [\"a\" \"b\"]", |p| p
            .strings("x")
            .map(<[_]>::len)),
        Some(2)
    );
}

#[test]
fn defaults_where_nothing_is_given() {
    quiet("", |p| {
        assert_eq!(
            (p.float("x", 2.0), p.integer("x", 2), p.boolean("x", true)),
            (2.0, 2, true)
        );
        assert_eq!(
            (p.string("x", "a"), p.point3("x", DVec3::X)),
            ("a", DVec3::X)
        );
        assert_eq!(
            (p.vector3("x", DVec3::Y), p.spectrum("x", Rgb::ONE)),
            (DVec3::Y, Rgb::ONE)
        );
        assert_eq!(p.float_input("x", 0.5), FloatInput::Constant(0.5));
        assert_eq!(
            p.spectrum_input("x", Rgb::ONE),
            SpectrumInput::Constant(Rgb::ONE)
        );
        assert_eq!(
            (p.one_of("x", &["a", "b"]), p.has("x"), p.file("x")),
            ("a", false, None)
        );
        assert_eq!(
            (p.kind(), p.word(), p.dialect()),
            ("sphere", "Shape", Dialect::V3)
        );
    });
}

#[test]
fn the_later_one_wins_within_a_group() {
    assert_eq!(
        quiet("\"float x\" 1 \"float x\" 2", |p| p.float("x", 0.0)),
        2.0
    );
    let rgb = quiet("\"xyz x\" [0 0 0] \"color x\" [1 2 3]", |p| {
        p.find_spectrum("x")
    });
    assert_eq!(rgb, Some(Rgb::new(1.0, 2.0, 3.0)));
    // Two groups are two parameters; each is found by the type it is asked for.
    let both = quiet("\"float x\" 1 \"integer x\" 2", |p| {
        (p.float("x", 0.0), p.integer("x", 0))
    });
    assert_eq!(both, (1.0, 2));
}

#[test]
fn several_values_where_one_is_wanted_are_ignored_as_a_whole() {
    let message = "`float x` takes one value, found 2; it is ignored";
    assert_eq!(
        told("\"float x\" [1 2]", &[message], |p| p.float("x", 7.0)),
        7.0
    );
    let message = "`float x` takes one value, found 0; it is ignored";
    assert_eq!(
        told("\"float x\" [ ]", &[message], |p| p.float("x", 7.0)),
        7.0
    );
    let message = "`point3 x` takes one value, found 2; it is ignored";
    assert_eq!(
        told("\"point x\" [1 2 3 4 5 6]", &[message], |p| p
            .find_point3("x")),
        None
    );
    let message = "`rgb x` takes one value, found 2; it is ignored";
    assert_eq!(
        told("\"rgb x\" [1 2 3 4 5 6]", &[message], |p| p
            .find_spectrum("x")),
        None
    );
}

#[test]
fn inputs_take_the_first_of_several_values() {
    let message = ["`x` takes one value, found 2"];
    let value = told("\"float x\" [.5 2]", &message, |p| p.float_input("x", 7.0));
    assert_eq!(value, FloatInput::Constant(0.5));
    let value = told("\"rgb x\" [1 2 3 4 5 6]", &message, |p| {
        p.find_spectrum_input("x")
    });
    assert_eq!(
        value,
        Some(SpectrumInput::Constant(Rgb::new(1.0, 2.0, 3.0)))
    );
}

#[test]
fn unused_parameters_are_named_with_what_was_meant() {
    let outcome = read("sphere", "\"float raduis\" 2 \"string kd\" \"x\"", |p| {
        p.float("radius", 1.0)
    });
    assert_eq!(outcome.value, 1.0);
    assert_eq!((outcome.errors, outcome.warnings), (0, 2));
    let expected = r#"warning: parameter `raduis` is not used by `Shape "sphere"`
 --> test.pbrt:1:16
  |
1 | Shape "sphere" "float raduis" 2 "string kd" "x"
  |                ^^^^^^^^^^^^^^
  |
  = help: did you mean `radius`?

warning: parameter `kd` is not used by `Shape "sphere"`
 --> test.pbrt:1:33
  |
1 | Shape "sphere" "float raduis" 2 "string kd" "x"
  |                                 ^^^^^^^^^^^

"#;
    assert_eq!(outcome.text, expected);
}

#[test]
fn the_wrong_type_says_which_is_right() {
    told(
        "\"integer x\" 2",
        &["`x` should be a `float`, found `integer`; it is not used"],
        |p| p.find_float("x"),
    );
    let message = "`x` should be a `float` or a `point2`, found `point3`; it is not used";
    // In the order of the table of types.
    told("\"point x\" [1 2 3]", &[message], |p| {
        p.points2("x").is_some()
    });
    let message =
        "`x` should be a `texture` or a spectrum such as `rgb`, found `float`; it is not used";
    told("\"float x\" 2", &[message], |p| p.find_spectrum_input("x"));
}

#[test]
fn choices() {
    let choices = ["uniform", "power", "spatial"];
    assert_eq!(
        quiet("\"string s\" \"power\"", |p| p.one_of("s", &choices)),
        "power"
    );
    let outcome = read("path", "\"string s\" \"spacial\"", |p| {
        p.one_of("s", &choices)
    });
    assert_eq!(outcome.value, "uniform");
    assert_eq!((outcome.errors, outcome.warnings), (0, 1));
    assert!(
        outcome.text.contains("did you mean `spatial`?"),
        "{}",
        outcome.text
    );
}

#[test]
fn integers_are_cut_as_pbrt_does() {
    let message = ["`integer x` is not a whole number: -2 is used"];
    assert_eq!(
        told("\"integer x\" -2.7", &message, |p| p.find_integer("x")),
        Some(-2)
    );
}

#[test]
fn a_spare_coordinate_is_dropped() {
    let message = ["`uv` takes pairs, found 3 numbers; the last one is ignored"];
    assert_eq!(
        told("\"float uv\" [1 2 3]", &message, |p| p
            .points2("uv")
            .map(<[f64]>::to_vec)),
        Some(vec![1.0, 2.0])
    );
}

fn with_textures() -> Surroundings {
    let mut surroundings = Surroundings::default();
    surroundings
        .textures
        .float
        .insert("scratches".into(), FloatTextureId(3));
    surroundings
        .textures
        .spectrum
        .insert("wood".into(), SpectrumTextureId(4));
    surroundings
}

#[test]
fn textures_come_before_values() {
    let params = "\"texture roughness\" \"scratches\" \"texture Kd\" \"wood\"";
    let outcome = read_in(&with_textures(), "plastic", params, |p| {
        (
            p.float_input("roughness", 0.1),
            p.spectrum_input("Kd", Rgb::ZERO),
        )
    });
    let expected = (
        FloatInput::Texture(FloatTextureId(3)),
        SpectrumInput::Texture(SpectrumTextureId(4)),
    );
    assert_eq!(outcome.value, expected);
    assert!(outcome.messages.is_empty(), "{}", outcome.text);

    let params = "\"float roughness\" 1 \"texture roughness\" \"scratches\"";
    let outcome = read_in(&with_textures(), "plastic", params, |p| {
        p.find_float_input("roughness")
    });
    assert_eq!(outcome.value, Some(FloatInput::Texture(FloatTextureId(3))));
    assert_eq!(outcome.warnings, 1); // the value is not used
}

#[test]
fn a_missing_texture_is_an_error_and_the_default_counts() {
    for (texture, help) in [
        ("wodo", "did you mean `wood`?"),
        (
            "scratches",
            "a float texture has this name; the two kinds are apart",
        ),
    ] {
        let params = format!("\"texture Kd\" \"{texture}\"");
        let outcome = read_in(&with_textures(), "matte", &params, |p| {
            p.spectrum_input("Kd", Rgb::ONE)
        });
        assert_eq!(
            (outcome.value, outcome.errors),
            (SpectrumInput::Constant(Rgb::ONE), 1)
        );
        assert!(outcome.text.contains(help), "{}", outcome.text);
    }
    let outcome = read_in(&with_textures(), "matte", "\"texture x\" \"wood\"", |p| {
        p.float_input("x", 2.0)
    });
    assert_eq!(
        (outcome.value, outcome.errors),
        (FloatInput::Constant(2.0), 1)
    );
}

#[test]
fn spectra_of_every_kind() {
    let xyz = quiet("\"xyz x\" [1 2 3]", |p| p.find_spectrum("x"));
    assert_eq!(
        xyz,
        Some(crate::math::color::rgb_from_xyz(Rgb::new(1.0, 2.0, 3.0)))
    );
    let blackbody = quiet("\"blackbody x\" [5000 .5]", |p| p.find_spectrum("x"));
    assert_eq!(
        blackbody,
        Some(crate::math::spectrum::rgb_from_blackbody(5000.0) * 0.5)
    );
    let inline = quiet("\"spectrum x\" [400 1 700 .5]", |p| p.find_spectrum("x"));
    let expected = crate::math::spectrum::rgb_from_samples(&[(400.0, 1.0), (700.0, 0.5)]);
    assert_eq!(inline, Some(expected));
    let message = ["`x` is no spectrum: it has two values at 400 nm"];
    assert_eq!(
        told("\"spectrum x\" [400 1 400 2]", &message, |p| p
            .find_spectrum("x")),
        Some(Rgb::ZERO)
    );
    let odd = ["`spectrum x` takes 2 numbers for each value, found 3"];
    told("\"spectrum x\" [400 1 500]", &odd, |p| p.find_spectrum("x"));
}

#[test]
fn spectra_and_files_are_looked_up_beside_the_scene() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    std::fs::create_dir(folder.path().join("spds")).expect("a folder");
    std::fs::write(folder.path().join("spds/flat.spd"), "700 2 400 2").expect("a file");
    let here = Surroundings {
        search: SearchFolder::new(folder.path()),
        ..Surroundings::default()
    };
    let outcome = read_in(&here, "metal", "\"spectrum x\" \"spds/flat.spd\"", |p| {
        p.find_spectrum("x")
    });
    let expected = crate::math::spectrum::rgb_from_samples(&[(400.0, 2.0), (700.0, 2.0)]);
    assert_eq!((outcome.value, outcome.messages), (Some(expected), vec![]));
    let outcome = read_in(&here, "plymesh", "\"string x\" \"spds\\flat.spd\"", |p| {
        p.file("x")
    });
    assert_eq!(outcome.value, Some(folder.path().join("spds/flat.spd")));
    for missing in ["spds/none.spd", "spds", ""] {
        let params = format!("\"spectrum x\" \"{missing}\" \"string f\" \"{missing}\"");
        let outcome = read_in(&here, "metal", &params, |p| {
            (p.find_spectrum("x"), p.file("f"))
        });
        assert_eq!(
            (outcome.value, outcome.errors),
            ((Some(Rgb::ZERO), None), 2),
            "{}",
            outcome.text
        );
    }
    for (odd, said) in [
        ("spds", "this is a folder"),
        ("/dev/null", "not a regular file"),
    ] {
        let params = format!("\"spectrum x\" \"{odd}\" \"string f\" \"{odd}\"");
        let outcome = read_in(&here, "metal", &params, |p| {
            (p.find_spectrum("x"), p.file("f"))
        });
        assert_eq!(outcome.value, (Some(Rgb::ZERO), None));
        assert!(
            outcome.messages.iter().all(|m| m.ends_with(said)),
            "{}",
            outcome.text
        );
    }
}

#[test]
fn own_messages_point_at_the_parameter_or_else_at_the_type() {
    let outcome = read("sphere", "\"float radius\" -1", |p| {
        p.find_float("radius");
        p.error("radius", "a radius is above zero");
        p.warn("phimax", "no phimax");
        p.unknown_kind(&["sphere2", "disk"]);
    });
    for place in ["1:16\n", "1:7\n"] {
        assert!(
            outcome.text.contains(&format!("test.pbrt:{place}")),
            "{}",
            outcome.text
        );
    }
    assert_eq!((outcome.errors, outcome.warnings), (2, 1));
    assert!(
        outcome.text.contains("did you mean `sphere2`?"),
        "{}",
        outcome.text
    );
}

/// A shape's parameters before its material's; those of the shape that neither the shape nor the
/// material asks for are reported.
#[test]
fn layers() {
    let scene = "Material \"plastic\" \"rgb Kd\" [1 0 0] \"float roughness\" .25\n\
                 Shape \"sphere\" \"rgb Kd\" [0 1 0] \"texture roughness\" \"scratches\" \"float kr\" 1";
    let (sources, diagnostics, spectra) =
        (SourceMap::new(), Diagnostics::new(), SpectrumFiles::new());
    let file = sources.add_text("test.pbrt", scene);
    let directives: Vec<_> = Parser::new(&sources, file, &diagnostics).collect();
    let [
        DirectiveKind::Material(material),
        DirectiveKind::Shape(shape),
    ] = [&directives[0].kind, &directives[1].kind]
    else {
        panic!("{directives:?}")
    };
    let textures = with_textures().textures;
    let context = ParamContext {
        search: &SearchFolder::default(),
        dialect: Dialect::V3,
        diagnostics: &diagnostics,
        spectra: &spectra,
        textures: &textures,
    };
    let span = Span {
        file,
        start: 0,
        end: 0,
    };
    let own = ParamReader::new(&context, "Shape", span, &shape.kind, &shape.params);
    own.float("radius", 1.0);
    let both = own.layered(&material.kind.text, &material.params);
    assert_eq!((both.kind(), both.has("Kd")), ("plastic", true));
    assert_eq!(
        both.spectrum_input("Kd", Rgb::ONE),
        SpectrumInput::Constant(Rgb::new(0.0, 1.0, 0.0))
    );
    // A texture of the shape goes before a number of the material.
    assert_eq!(
        both.float_input("roughness", 0.1),
        FloatInput::Texture(FloatTextureId(3))
    );
    both.spectrum_input("Kr", Rgb::ZERO);
    own.finish();
    let messages: Vec<_> = diagnostics
        .kept()
        .into_iter()
        .map(|d| (d.message, d.help))
        .collect();
    let unused = "`kr` is not used";
    assert_eq!(messages.len(), 1);
    assert!(
        messages[0].0.contains(unused) && messages[0].1 == ["did you mean `Kr`?"],
        "{messages:?}"
    );
    own.finish();
    assert_eq!(diagnostics.warnings(), 1);
}

#[test]
fn which_shapes_change_their_material() {
    for (params, expected) in [
        ("", false),
        ("\"float radius\" 2 \"texture alpha\" \"leaf\"", false),
        (
            "\"string filename\" \"a.ply\" \"integer indices\" [0 1 2] \"point P\" [0 0 0 1 1 1]",
            false,
        ),
        ("\"rgb Kd\" [1 0 0]", true),
        ("\"texture Kd\" \"wood\"", true),
        ("\"float roughness\" .1", true),
        ("\"spectrum Kd\" [400 1 500 1]", true),
        ("\"bool remaproughness\" \"true\"", true),
    ] {
        let sources = SourceMap::new();
        let file = sources.add_text("test.pbrt", format!("Shape \"s\" {params}"));
        let directive = Parser::new(&sources, file, &Diagnostics::new())
            .next()
            .expect("a shape");
        let DirectiveKind::Shape(shape) = directive.kind else {
            panic!("no shape")
        };
        assert_eq!(may_change_material(&shape.params), expected, "{params}");
    }
}
