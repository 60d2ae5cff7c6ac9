//! Every statement, every parameter type, every spelling.

use crate::read;
use fstop::math::DVec3;
use fstop::syntax::directive::WORDS;
use fstop::syntax::{ActiveTransform, DirectiveKind, ParamType, ParamValue};
use glam::DMat4;

/// Directives of a scene without any problem.
fn clean(scene: &str) -> Vec<DirectiveKind> {
    let read = read(scene);
    assert!(read.messages.is_empty(), "{scene}\n{}", read.text);
    read.kinds
}

/// The value of the only parameter of `Shape "s" …`.
fn value(params: &str) -> ParamValue {
    match clean(&format!("Shape \"s\" {params}")).as_slice() {
        [DirectiveKind::Shape(shape)] => match shape.params.params.as_slice() {
            [param] => param.value.clone(),
            other => panic!("not one parameter: {other:?}"),
        },
        other => panic!("not one shape: {other:?}"),
    }
}

fn numbers(params: &str) -> Vec<f64> {
    match value(params) {
        ParamValue::Numbers(numbers) => numbers,
        other => panic!("no numbers: {other:?}"),
    }
}

/// One statement for each word of the language, `Include` aside.
const EVERY_DIRECTIVE: &str = r#"
Identity
Translate 1 2 3
Scale 1 2 3
Rotate 90 0 0 1
LookAt 1 2 3 4 5 6 0 1 0
Transform [ 1 0 0 0 0 1 0 0 0 0 1 0 7 8 9 1 ]
ConcatTransform [1 0 0 0  0 1 0 0  0 0 1 0  7 8 9 1]
CoordinateSystem "here"
CoordSysTransform "here"
ActiveTransform StartTime
ActiveTransform EndTime
ActiveTransform All
TransformTimes 0 1
TransformBegin
TransformEnd
AttributeBegin
AttributeEnd
PixelFilter "box"
Film "image" "integer xresolution" 64
Sampler "halton"
Accelerator "bvh"
Integrator "path"
Camera "realistic"
SurfaceIntegrator "path"
VolumeIntegrator "single"
Renderer "sampler"
Volume "homogeneous"
MakeNamedMedium "fog" "string type" "homogeneous"
MediumInterface "fog" ""
MediumInterface "fog"
WorldBegin
WorldEnd
Texture "wood" "spectrum" "imagemap" "string filename" "wood.png"
Material "matte"
MakeNamedMaterial "red" "string type" "matte"
NamedMaterial "red"
LightSource "point"
AreaLightSource "diffuse"
Shape "sphere"
ReverseOrientation
ObjectBegin "tree"
ObjectEnd
ObjectInstance "tree"
"#;

#[test]
fn every_directive_is_read() {
    let kinds = clean(EVERY_DIRECTIVE);
    let words: Vec<&str> = kinds.iter().map(DirectiveKind::word).collect();
    for word in WORDS.into_iter().filter(|word| *word != "Include") {
        assert!(words.contains(&word), "{word}");
    }
    // And in the order of the file.
    let written: Vec<&str> = EVERY_DIRECTIVE
        .lines()
        .filter_map(|line| line.split_whitespace().next())
        .collect();
    assert_eq!(words, written);
}

#[test]
fn arguments_arrive() {
    use DirectiveKind as Kind;
    let matrix = DMat4::from_translation(DVec3::new(7.0, 8.0, 9.0));
    for kind in clean(EVERY_DIRECTIVE) {
        match kind {
            Kind::Translate(v) | Kind::Scale(v) => assert_eq!(v, DVec3::new(1.0, 2.0, 3.0)),
            Kind::Rotate { degrees, axis } => assert_eq!((degrees, axis), (90.0, DVec3::Z)),
            Kind::LookAt { eye, look, up } => {
                assert_eq!(
                    (eye, look, up),
                    (DVec3::new(1., 2., 3.), DVec3::new(4., 5., 6.), DVec3::Y)
                );
            }
            Kind::Transform(m) | Kind::ConcatTransform(m) => assert_eq!(*m, matrix),
            Kind::TransformTimes(start, end) => assert_eq!((start, end), (0.0, 1.0)),
            Kind::MediumInterface { inside, outside } => {
                assert_eq!(inside.text, "fog");
                assert!(outside.text.is_empty() || outside.text == "fog");
            }
            Kind::Texture {
                name,
                value_type,
                class,
                params,
            } => {
                assert_eq!(
                    [name.text, value_type.text, class.text],
                    ["wood", "spectrum", "imagemap"]
                );
                assert!(
                    matches!(&params.params[0].value, ParamValue::Strings(s) if s[0].text == "wood.png")
                );
            }
            Kind::CoordinateSystem(name) | Kind::CoordSysTransform(name) => {
                assert_eq!(name.text, "here")
            }
            Kind::ObjectBegin(name) | Kind::ObjectInstance(name) => assert_eq!(name.text, "tree"),
            _ => {}
        }
    }
    let active: Vec<_> = clean(EVERY_DIRECTIVE)
        .into_iter()
        .filter_map(|kind| {
            if let Kind::ActiveTransform(which) = kind {
                Some(which)
            } else {
                None
            }
        })
        .collect();
    assert_eq!(
        active,
        [
            ActiveTransform::Start,
            ActiveTransform::End,
            ActiveTransform::All
        ]
    );
}

#[test]
fn every_type_and_alias_is_read() {
    for (word, ty) in ParamType::WORDS {
        let given = match ty {
            ParamType::Bool => "\"true\"",
            ParamType::String | ParamType::Texture => "[ \"a\" \"b\" ]",
            _ => "[ 1 2 3 4 5 6 ]",
        };
        let kinds = clean(&format!("Shape \"s\" \"{word} x\" {given}"));
        let [DirectiveKind::Shape(shape)] = kinds.as_slice() else {
            panic!("{kinds:?}")
        };
        assert_eq!(shape.params.params[0].ty, ty, "{word}");
    }
    assert!(matches!(
        value("\"spectrum Kd\" \"metals/Cu.spd\""),
        ParamValue::Strings(_)
    ));
}

#[test]
fn forms_seen_in_the_wild() {
    assert_eq!(numbers("\"float x\" .5"), [0.5]);
    assert_eq!(numbers("\"float x\"[5.]"), [5.0]);
    assert_eq!(numbers("\"float x\" [1.5e-009]"), [1.5e-9]);
    assert_eq!(
        numbers("\"float x\" [+1 -1 0x28 1E2]"),
        [1.0, -1.0, 40.0, 100.0]
    );
    assert_eq!(numbers("\"  float \t x\" 1"), [1.0]);
    assert_eq!(
        numbers("\"point P\"\r\n[ 1 2 # first\r\n 3 ]\r\n"),
        [1.0, 2.0, 3.0]
    );
    assert_eq!(numbers("\"float x\" # between\n 1"), [1.0]);
    assert_eq!(numbers("\"float x\" [ ]"), Vec::<f64>::new());
    assert_eq!(numbers("\"integer i\" [1 2.5 3]\x0c"), [1.0, 2.5, 3.0]);
    for bools in ["[true]", "true", "\"true\"", "[ \"true\" ]"] {
        assert_eq!(
            value(&format!("\"bool b\" {bools}")),
            ParamValue::Bools(vec![true]),
            "{bools}"
        );
    }
    assert_eq!(
        value("\"bool b\" [false \n true]"),
        ParamValue::Bools(vec![false, true])
    );
    assert_eq!(clean("\u{feff}Identity"), [DirectiveKind::Identity]);
    assert_eq!(clean(""), []);
    assert_eq!(clean("# nothing but a comment"), []);
    assert_eq!(
        read(b"# caf\xe9 \xff\nIdentity".as_slice()).kinds,
        [DirectiveKind::Identity]
    );
    let kinds = clean("NamedMaterial \"my red, \\\"old\\\" one\"");
    assert!(
        matches!(&kinds[0], DirectiveKind::NamedMaterial(name) if name.text == "my red, \"old\" one")
    );
}

#[test]
fn bytes_that_are_not_utf8_are_kept_apart_from_the_rest() {
    let read = read(b"NamedMaterial \"caf\xe9\" Identity".as_slice());
    assert!(
        matches!(&read.kinds[0], DirectiveKind::NamedMaterial(name) if name.text == "caf\u{fffd}")
    );
    assert_eq!(read.kinds.len(), 2);
}

#[test]
fn lenient_forms_are_read_with_a_warning() {
    for (scene, message) in [
        (
            "LookAt [0 0 0  0 0 1  0 1 0]",
            "the numbers of `LookAt` stand without brackets",
        ),
        (
            "LookAt [0 0 0] [0 0 1] [0 1 0]",
            "the numbers of `LookAt` stand without brackets",
        ),
        (
            "Transform 1 0 0 0 0 1 0 0 0 0 1 0 0 0 0 1",
            "the numbers of `Transform` belong in brackets",
        ),
        (
            "Translate 1, 2, 3",
            "a number is followed by something else",
        ),
        (
            "Shape \"s\" \"float x\" [1.5f]",
            "a number is followed by something else",
        ),
        (
            "Shape \"s\" \"float x\" [1,2 2abc 3]",
            "a number is followed by something else",
        ),
        (
            "Shape \"s\" \"float x y\" 1",
            "a parameter's declaration has words behind the name; they are ignored",
        ),
        (
            "Shape \"s\" \"bool x\" \"yes\"",
            "\"yes\" is neither \"true\" nor \"false\"",
        ),
        (
            "Shape \"s\" \"string x\" \"a\\w\"",
            "a backslash in a string should be doubled",
        ),
        (
            "Shape \"s\" \"point P\" [1 2 3 4]",
            "`point3 P` takes 3 numbers for each value, found 4",
        ),
    ] {
        let read = read(scene);
        assert_eq!(
            (read.kinds.len(), read.errors),
            (1, 0),
            "{scene}\n{}",
            read.text
        );
        assert!(
            read.messages.iter().all(|m| m == message) && !read.messages.is_empty(),
            "{}",
            read.text
        );
    }
    assert_eq!(
        read("Translate 1, 2, 3").kinds,
        [DirectiveKind::Translate(DVec3::new(1.0, 2.0, 3.0))]
    );
}
