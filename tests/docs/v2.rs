//! pbrt-v2's parameters: what the program follows is what the document says.

use fstop::params::{V2, V2_DIRECTIVES, v2_rows};

#[test]
fn the_appendix_of_the_language_names_every_row() {
    let document = super::links::scene_language();
    let (_, appendix) = document.split_once("## Appendix A").expect("an appendix");
    for directive in V2_DIRECTIVES {
        assert!(!v2_rows(directive).is_empty(), "{directive}");
        for (_, name, row) in v2_rows(directive) {
            assert!(appendix.contains(name), "{directive} {name}");
            if let V2::Named(other) = row {
                assert!(appendix.contains(other), "{directive} {name}");
            }
        }
    }
}
