//! Broken scenes: all that is wrong is said, and what is right is kept.

use crate::read;
use fstop::syntax::{Diagnostics, DirectiveKind, ParamValue, Parser, SourceMap};
use std::fmt::Write as _;

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
        read("Shape \"s\" \"float x\" [one]\n".repeat(100_000) + &"Identty\n".repeat(100_000));
    assert_eq!(read.errors, 200_000);
    assert!(read.text.len() < 10_000, "{}", read.text.len());
    assert!(
        read.text.contains("the same at other places: 99995 more"),
        "{}",
        read.text
    );
}
