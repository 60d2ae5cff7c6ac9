//! Scenes of several files.

use crate::{Folder, read_file};
use fstop::math::DVec3;
use fstop::syntax::{DirectiveKind, ParamValue};

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

/// As in pbrt-v2, whose lexer follows `Include` wherever it stands; the scene's reader says whether that is allowed.
#[test]
fn an_include_may_stand_among_parameters() {
    let folder = Folder::new(&[
        (
            "main.pbrt",
            "Shape \"sphere\" \"float radius\" 2 Include \"more.pbrt\" \"float phimax\" [90 Include \"none.pbrt\" ]
             Shape \"cone\" \"float height\" Include \"list.pbrt\" Include \"whole.pbrt\"",
        ),
        ("more.pbrt", "\"float zmin\" [-1 Include \"none.pbrt\"] Include \"none.pbrt\" \"float zmax\""),
        ("none.pbrt", "# nothing"),
        ("list.pbrt", "[ 3 ]"),
        ("whole.pbrt", "Identity"),
    ]);
    let main = std::fs::read_to_string(folder.path("main.pbrt")).expect("the scene");
    // A declaration at the end of a file has its value in the one around.
    std::fs::write(
        folder.path("main.pbrt"),
        main.replace("\"float phimax\"", "1 \"float phimax\""),
    )
    .expect("room for a scene");
    let read = read_file(&folder.path("main.pbrt"));
    assert!(read.messages.is_empty(), "{}", read.text);
    let values = |kind: &DirectiveKind| match kind {
        DirectiveKind::Shape(s) => s.params.params.iter().map(|p| p.value.clone()).collect(),
        _ => Vec::new(),
    };
    let numbers = |values: &[f64]| -> Vec<ParamValue> {
        values
            .iter()
            .map(|&v| ParamValue::Numbers(vec![v]))
            .collect()
    };
    assert_eq!(values(&read.kinds[0]), numbers(&[2.0, -1.0, 1.0, 90.0]));
    assert_eq!(values(&read.kinds[1]), numbers(&[3.0]));
    assert_eq!(read.kinds[2..], [DirectiveKind::Identity]);
}

/// A list whose bracket is missing before an `Include` of directives is still found.
#[test]
fn an_unclosed_list_before_an_include_is_reported() {
    let folder = Folder::new(&[
        (
            "main.pbrt",
            "Shape \"sphere\" \"float radius\" [ 2\nInclude \"whole.pbrt\"\nIdentity",
        ),
        ("whole.pbrt", "Identity"),
    ]);
    let read = read_file(&folder.path("main.pbrt"));
    assert_eq!(read.messages, ["a list is not closed, found `Identity`"]);
    assert_eq!(read.kinds.len(), 3);
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

/// Eighteen files that each include the next one twice: no circle, and 524,286 inclusions.
#[test]
fn exponential_includes_end_and_name_the_file() {
    let folder = Folder::new(&[]);
    for i in 0..18 {
        let next = format!("Include \"{0}.pbrt\" Include \"{0}.pbrt\"", i + 1);
        std::fs::write(folder.path(&format!("{i}.pbrt")), next).expect("a file");
    }
    std::fs::write(folder.path("18.pbrt"), "Identity").expect("a file");
    let read = read_file(&folder.path("0.pbrt"));
    assert_eq!(
        read.messages[0],
        "more than 50000 inclusions: no more are followed"
    );
    // Half of them are of the innermost file.
    assert!(
        (24_900..25_100).contains(&read.kinds.len()),
        "{}",
        read.kinds.len()
    );
    let named = format!("18.pbrt` alone was included {} times", read.kinds.len());
    assert!(read.text.contains(&named), "{}", read.text);
}
