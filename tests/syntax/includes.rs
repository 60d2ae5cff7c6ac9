//! Scenes of several files.

use crate::{Folder, read_file};
use fstop::math::DVec3;
use fstop::syntax::DirectiveKind;

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
