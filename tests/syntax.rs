//! The scene language from outside: every directive and form of parameter, recovery, includes,
//! and the messages exactly as they are printed.

use fstop::math::DVec3;
use fstop::syntax::directive::WORDS;
use fstop::syntax::{
    ActiveTransform, Diagnostics, Directive, DirectiveKind, ParamType, ParamValue, Parser,
    SourceMap, Style,
};
use glam::DMat4;
use proptest::prelude::*;
use std::fmt::Write as _;
use std::path::Path;

struct Read {
    kinds: Vec<DirectiveKind>,
    messages: Vec<String>,
    errors: usize,
    text: String,
}

fn read(scene: impl Into<Vec<u8>>) -> Read {
    let sources = SourceMap::new();
    let file = sources.add_text("scene.pbrt", scene);
    finish(&sources, file)
}

fn read_file(path: &Path) -> Read {
    let sources = SourceMap::new();
    let file = sources.open(path).expect("a readable file");
    finish(&sources, file)
}

fn finish(sources: &SourceMap, file: fstop::syntax::FileId) -> Read {
    let diagnostics = Diagnostics::new();
    let kinds = Parser::new(sources, file, &diagnostics)
        .map(|directive: Directive| directive.kind)
        .collect();
    Read {
        kinds,
        messages: diagnostics.kept().into_iter().map(|d| d.message).collect(),
        errors: diagnostics.errors(),
        text: diagnostics.render(sources, Style::Plain),
    }
}

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
    for word in ParamType::WORDS {
        let ty = ParamType::from_word(word).expect("a known word");
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

#[test]
fn all_errors_come_out_in_one_run() {
    let cases = [
        ("Shpae \"sphere\"", "expected a directive, found `Shpae`"),
        (
            "Translate 1 2",
            "`Translate` needs three numbers: x y z, found `Identity`",
        ),
        ("Translate 1 2 inf", "a transform needs finite numbers"),
        ("Translate 1 2 3 4", "expected a directive, found `4`"),
        (
            "Shape sphere",
            "`Shape` needs a type in quotes, found `sphere`",
        ),
        (
            "Shape \"sphere",
            "`Shape` needs a type in quotes, found the unfinished string `\"sphere`",
        ),
        ("Shape \"s\" \"float x", "a string does not end on its line"),
        (
            "Shape \"s\" \"float x\"",
            "parameter `x` has no value, found `Identity`",
        ),
        (
            "Shape \"s\" \"float x\" \"float y\" 1",
            "parameter `x` has no value, found the string `\"float y\"`",
        ),
        (
            "Shape \"s\" \"float x\" [1 2",
            "a list is not closed, found `Identity`",
        ),
        (
            "Shape \"s\" \"float x\" [1 [2] 3]",
            "expected a value or `]`, found `[`",
        ),
        (
            "Shape \"s\" \"float x\" [1 two 3]",
            "expected a value, found `two`",
        ),
        (
            "Shape \"s\" \"float x\" [1,2]",
            "a number is followed by something with digits in it",
        ),
        ("Shape \"s\" \"float x\" nan", "not a number"),
        (
            "Shape \"s\" \"flaot x\" 1",
            "unknown parameter type `flaot`",
        ),
        (
            "Shape \"s\" \"float\" 1",
            "expected a parameter's type and name, found \"float\"",
        ),
        (
            "Shape \"s\" \"float x\" \"one\"",
            "`float x` needs numbers, found strings",
        ),
        (
            "Shape \"s\" \"string x\" 1",
            "`string x` needs strings in quotes, found numbers",
        ),
        (
            "Shape \"s\" \"string x\" []",
            "`string x` needs strings in quotes, found an empty list",
        ),
        (
            "Shape \"s\" \"float x\" [1 \"one\"]",
            "`float x` needs numbers, found numbers mixed with strings",
        ),
        ("Shape \"s\" ]", "expected a directive, found `]`"),
        (
            "ActiveTransform Start",
            "`ActiveTransform` needs `StartTime`, `EndTime` or `All`, found `Start`",
        ),
        ("Include \"nowhere.pbrt\"", "cannot include this file: "),
        (
            "ColorSpace \"rec2020\"",
            "expected a directive, found `ColorSpace`",
        ),
    ];
    let mut scene = String::new();
    for (broken, _) in cases {
        writeln!(scene, "{broken}\nIdentity").expect("memory");
    }
    let read = read(scene);
    for (found, (broken, expected)) in read.messages.iter().zip(cases) {
        assert!(
            found.starts_with(expected),
            "{broken}\nfound:    {found}\nexpected: {expected}"
        );
    }
    assert_eq!(read.messages.len(), cases.len());
    // Nothing that was right has been lost.
    let rights = read
        .kinds
        .iter()
        .filter(|kind| **kind == DirectiveKind::Identity)
        .count();
    assert_eq!(rights, cases.len());
}

#[test]
fn good_parameters_beside_bad_ones_are_kept() {
    let read = read("Shape \"s\" \"flaot a\" 1 \"float b\" \"x\" \"float c\" [3");
    let [DirectiveKind::Shape(shape)] = read.kinds.as_slice() else {
        panic!("{:?}", read.kinds)
    };
    let names: Vec<_> = shape
        .params
        .params
        .iter()
        .map(|p| p.name.as_str())
        .collect();
    assert_eq!((names, read.errors), (vec!["c"], 3));
}

#[test]
fn brackets_without_end_are_no_trouble() {
    for scene in [
        "[".repeat(1_000_000),
        format!("Shape \"s\" \"float x\" {}", "[".repeat(1_000_000)),
    ] {
        let read = read(scene);
        assert_eq!((read.kinds.len(), read.errors), (0, 1));
    }
}

#[test]
fn a_million_shapes() {
    let mut scene = String::new();
    for i in 0..1_000_000 {
        writeln!(scene, "Shape \"sphere\" \"float radius\" {i}").expect("memory");
    }
    let sources = SourceMap::new();
    let file = sources.add_text("many.pbrt", scene);
    let diagnostics = Diagnostics::new();
    let mut expected = 0.0;
    for directive in Parser::new(&sources, file, &diagnostics) {
        let DirectiveKind::Shape(shape) = directive.kind else {
            panic!("no shape")
        };
        assert_eq!(
            shape.params.params[0].value,
            ParamValue::Numbers(vec![expected])
        );
        expected += 1.0;
    }
    assert_eq!(expected, 1e6);
}

/// As many errors as there are statements: counted, but neither kept nor printed all.
#[test]
fn a_million_errors() {
    let read =
        read("Shape \"s\" \"float x\" [1,2]\n".repeat(100_000) + &"Identty\n".repeat(100_000));
    assert_eq!(read.errors, 100_001); // resynchronising swallows the second half after its first
    assert!(read.text.len() < 10_000, "{}", read.text.len());
    assert!(
        read.text.contains("the same at other places: 99995 more"),
        "{}",
        read.text
    );
}

struct Folder(tempfile::TempDir);

impl Folder {
    fn new(files: &[(&str, &str)]) -> Self {
        let folder = Self(tempfile::tempdir().expect("a temporary folder"));
        for (name, text) in files {
            let path = folder.path(name);
            std::fs::create_dir_all(path.parent().expect("a parent")).expect("a folder");
            std::fs::write(path, text).expect("a file");
        }
        folder
    }

    fn path(&self, name: &str) -> std::path::PathBuf {
        self.0.path().join(name)
    }

    /// Messages with this folder's name, which changes, replaced.
    fn text(&self, read: &Read) -> String {
        read.text
            .replace(&self.0.path().display().to_string(), "FOLDER")
    }
}

#[test]
fn include_looks_beside_the_main_file() {
    let folder = Folder::new(&[
        ("main.pbrt", "Include \"sub/one.pbrt\"\nTranslate 3 0 0"),
        ("sub/one.pbrt", "Translate 1 0 0 Include \"two.pbrt\""),
        ("two.pbrt", "Translate 2 0 0"),
        ("sub/two.pbrt", "Translate -2 0 0"),
    ]);
    let read = read_file(&folder.path("main.pbrt"));
    assert!(read.messages.is_empty(), "{}", read.text);
    let steps = [1.0, 2.0, 3.0].map(|x| DirectiveKind::Translate(DVec3::new(x, 0.0, 0.0)));
    assert_eq!(read.kinds, steps);
}

#[test]
fn include_falls_back_to_beside_the_including_file() {
    let folder = Folder::new(&[
        ("main.pbrt", "Include \"sub/one.pbrt\""),
        ("sub/one.pbrt", "Include \"two.pbrt\""),
        ("sub/two.pbrt", "Identity"),
    ]);
    let read = read_file(&folder.path("main.pbrt"));
    assert_eq!(
        (read.kinds, read.errors),
        (vec![DirectiveKind::Identity], 0)
    );
    assert_eq!(
        read.messages,
        ["`two.pbrt` was found beside the including file only"]
    );
}

/// As in pbrt-v3, where an included file is a run of tokens.
#[test]
fn a_parameter_list_goes_on_after_an_included_file() {
    let folder = Folder::new(&[
        (
            "main.pbrt",
            "Include \"ball.pbrt\" \"float zmin\" 0 Identity",
        ),
        ("ball.pbrt", "Shape \"sphere\" \"float radius\" 2"),
    ]);
    let read = read_file(&folder.path("main.pbrt"));
    assert!(read.messages.is_empty(), "{}", read.text);
    assert!(matches!(&read.kinds[0], DirectiveKind::Shape(s) if s.params.params.len() == 2));
}

#[test]
fn an_include_circle_is_named() {
    let folder = Folder::new(&[
        ("a.pbrt", "Include \"b.pbrt\"\nTranslate 1 0 0"),
        ("b.pbrt", "Include \"./sub/../a.pbrt\"\nIdentity"),
        ("sub/x", ""),
    ]);
    let read = read_file(&folder.path("a.pbrt"));
    assert_eq!(
        read.messages,
        ["files include each other in a circle: a.pbrt -> b.pbrt -> a.pbrt"]
    );
    assert_eq!(read.kinds.len(), 2);
}

#[test]
fn a_folder_cannot_be_included() {
    let folder = Folder::new(&[("a.pbrt", "Include \"sub\"\nIdentity"), ("sub/x", "")]);
    let read = read_file(&folder.path("a.pbrt"));
    assert_eq!((read.errors, read.kinds.len()), (1, 1));
}

#[test]
fn ten_thousand_nested_includes() {
    let folder = Folder::new(&[]);
    for i in 0..10_000 {
        let text = format!(
            "Translate {i} 0 0\nInclude \"{}.pbrt\"\nTranslate -{i} 0 0\n",
            i + 1
        );
        std::fs::write(folder.path(&format!("{i}.pbrt")), text).expect("a file");
    }
    std::fs::write(folder.path("10000.pbrt"), "Identity Bogus").expect("a file");
    let read = read_file(&folder.path("0.pbrt"));
    assert_eq!(
        (read.kinds.len(), read.errors),
        (20_001, 1),
        "{}",
        read.text
    );
    assert_eq!(read.kinds[10_000], DirectiveKind::Identity);
    assert!(
        read.text.contains("… and so on, 9995 more"),
        "{}",
        read.text
    );
}

#[test]
fn messages_of_several_files_exactly() {
    let folder = Folder::new(&[
        (
            "main.pbrt",
            "Camera \"realistic\" \"string lensfile\" \"lens.dat\"\nInclude \"parts/ball.pbrt\"\nShpae \"disk\"\n",
        ),
        (
            "parts/ball.pbrt",
            "# one ball\r\nShape \"sphere\"\r\n\t\"flaot radius\" [ 2 ]\r\n\t\"float zmin\" [ 1,5 ]",
        ),
    ]);
    let expected = r#"error: unknown parameter type `flaot`
 --> FOLDER/parts/ball.pbrt:3:2
  |
3 |     "flaot radius" [ 2 ]
  |     ^^^^^^^^^^^^^^ parameter `radius` is ignored
  |
  = note: included from FOLDER/main.pbrt:2:1
  = help: did you mean `float`?

error: a number is followed by something with digits in it
 --> FOLDER/parts/ball.pbrt:4:18
  |
4 |     "float zmin" [ 1,5 ]
  |                     ^^ pbrt-v3 would drop this without a word
  |
  = note: included from FOLDER/main.pbrt:2:1
  = help: separate numbers by blanks

error: expected a directive, found `Shpae`
 --> FOLDER/main.pbrt:3:1
  |
3 | Shpae "disk"
  | ^^^^^ no directive has this name
  |
  = help: did you mean `Shape`?

"#;
    assert_eq!(folder.text(&read_file(&folder.path("main.pbrt"))), expected);
}

#[test]
fn the_excerpt_of_an_endless_line_is_short() {
    let scene = format!(
        "Shape \"mesh\" \"point P\" [{} 7,7 {}]",
        "1 2 3 ".repeat(300_000),
        "4 5 6 ".repeat(300_000)
    );
    let expected = r#"error: a number is followed by something with digits in it
 --> scene.pbrt:1:1800027
  |
1 | …3 1 2 3 1 2 3 1 2 3 1 2 3 1 2 3 1 2 3  7,7 4 5 6 4 5 6 4 5 6 4 5 6 4 5 6 4 5 6 4 5 6 4 5 6 4 5 6 4 5 6 4 5 6 4 5 6 4 5 6…
  |                                          ^^ pbrt-v3 would drop this without a word
  |
  = help: separate numbers by blanks

"#;
    let text = read(scene).text;
    assert!(text.starts_with(expected), "{text}");
}

#[test]
fn a_message_at_the_end_of_the_file() {
    let expected = r#"error: `Translate` needs three numbers: x y z, found the end of the file
 --> scene.pbrt:1:14
  |
1 | Translate 1 2
  |              ^ expected three numbers: x y z

"#;
    assert_eq!(read("Translate 1 2").text, expected);
}

fn decimal() -> impl Strategy<Value = f64> {
    prop_oneof![
        any::<i32>().prop_map(f64::from),
        any::<f64>().prop_filter("finite", |x| x.is_finite()),
        -1e3..1e3
    ]
}

/// A parameter as text, with what it should be read as.
fn parameter() -> impl Strategy<Value = (String, ParamValue)> {
    let blank = prop_oneof![
        Just(" "),
        Just("\n"),
        Just("\t"),
        Just(" # a \"comment\" ]\r\n")
    ];
    let numeric = proptest::sample::select(ParamType::WORDS.to_vec());
    (
        numeric,
        "[a-zA-Z_][a-zA-Z0-9_:.]{0,8}",
        proptest::collection::vec(decimal(), 0..12),
        any::<bool>(),
        blank,
    )
        .prop_map(|(word, name, mut numbers, flag, blank)| {
            let ty = ParamType::from_word(word).expect("a known word");
            let (given, value) = match ty {
                ParamType::Bool => (format!("\"{flag}\""), ParamValue::Bools(vec![flag])),
                // Too wordy to compare strings with their places; they have tests of their own.
                ParamType::String | ParamType::Texture => {
                    ("\"a b\"".to_owned(), ParamValue::Bools(vec![]))
                }
                _ => {
                    numbers.truncate(numbers.len() / ty.items() * ty.items());
                    let words: Vec<String> = numbers
                        .iter()
                        .map(|x| {
                            if flag {
                                format!("{x:e}")
                            } else {
                                format!("{x}")
                            }
                        })
                        .collect();
                    (words.join(blank), ParamValue::Numbers(numbers))
                }
            };
            (
                format!("{blank}\"{word} {name}\"{blank}[{given}{blank}]"),
                value,
            )
        })
}

proptest! {
    #[test]
    fn valid_scenes_are_read_as_written(shapes in proptest::collection::vec(proptest::collection::vec(parameter(), 0..6), 0..6)) {
        let mut scene = String::new();
        for params in &shapes {
            scene += "Shape \"s\"";
            scene.extend(params.iter().map(|(text, _)| text.as_str()));
            scene += "\nReverseOrientation\n";
        }
        let read = read(scene.as_str());
        prop_assert!(read.messages.is_empty(), "{}\n{}", scene, read.text);
        prop_assert_eq!(read.kinds.len(), 2 * shapes.len());
        for (kind, params) in read.kinds.iter().step_by(2).zip(&shapes) {
            let DirectiveKind::Shape(shape) = kind else { panic!("no shape") };
            prop_assert_eq!(shape.params.params.len(), params.len());
            for (found, (_, written)) in shape.params.params.iter().zip(params) {
                if !matches!(found.value, ParamValue::Strings(_)) {
                    prop_assert_eq!(&found.value, written);
                }
            }
        }
    }

    /// Any bytes: it ends, does not panic, and can print what it thinks of them.
    #[test]
    fn noise_is_survived(bytes in proptest::collection::vec(any::<u8>(), 0..300)) {
        read(bytes);
    }

    /// Pieces of the language in any order.
    #[test]
    fn shuffled_scenes_are_survived(pieces in proptest::collection::vec(0..14_usize, 0..60)) {
        let parts = ["Shape", "\"sphere\"", "\"float x\"", "[", "]", "1", "1,2", "\"", "\n", "# ", "Translate",
            "Include \"scene.pbrt\"", "Texture \"a\" \"float\" \"b\"", "true"];
        let scene: String = pieces.into_iter().flat_map(|i| [parts[i], " "]).collect();
        read(scene);
    }
}
