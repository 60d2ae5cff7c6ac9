//! The bugs of `examples/mutants`: they stand where they can be put in.

use std::path::Path;

/// Each expression occurs once in its file, before the tests there.
#[test]
fn every_bug_has_its_place() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let read = |file: &str| {
        std::fs::read_to_string(root.join(file)).unwrap_or_else(|error| panic!("{file}: {error}"))
    };
    let bugs: toml::Table = toml::from_str(&read("examples/mutants/bugs.toml")).expect("TOML");
    let bugs = bugs["bug"].as_array().expect("a list");
    assert!(bugs.len() > 20, "{}", bugs.len());
    for bug in bugs {
        let [file, expression] = ["file", "expression"].map(|key| bug[key].as_str().expect(key));
        let text = read(file);
        let code = text
            .split("#[cfg(test)]\nmod tests")
            .next()
            .unwrap_or_default();
        assert_eq!(code.matches(expression).count(), 1, "{file}: {expression}");
        // A statement is not an expression, and cannot be put into a `match`.
        assert!(!expression.contains(';'), "{file}: {expression}");
    }
}
