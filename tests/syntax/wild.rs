//! Random scenes, valid and not.

use crate::read;
use fstop::syntax::{DirectiveKind, ParamType, ParamValue};
use proptest::prelude::*;

fn decimal() -> impl Strategy<Value = f64> {
    prop_oneof![
        any::<i32>().prop_map(f64::from),
        any::<f64>().prop_filter("finite", |x| x.is_finite()),
        -1e3..1e3
    ]
}

/// A parameter as it should be read, places left out.
#[derive(Clone, Debug, PartialEq)]
struct Written {
    ty: ParamType,
    name: String,
    numbers: Vec<f64>,
    strings: Vec<String>,
    bools: Vec<bool>,
}

impl Written {
    fn items(&self, exponents: bool) -> Vec<String> {
        let number = |x: &f64| {
            if exponents {
                format!("{x:e}")
            } else {
                format!("{x}")
            }
        };
        let string = |s: &String| format!("\"{}\"", s.replace('\\', "\\\\").replace('"', "\\\""));
        let bool = |b: &bool| {
            if exponents {
                format!("\"{b}\"")
            } else {
                format!("{b}")
            }
        };
        let numbers = self.numbers.iter().map(number);
        numbers
            .chain(self.strings.iter().map(string))
            .chain(self.bools.iter().map(bool))
            .collect()
    }
}

/// A parameter, and one of the ways to write it.
fn parameter() -> impl Strategy<Value = (String, Written)> {
    let blank = prop_oneof![
        Just(" "),
        Just("\n"),
        Just("\t"),
        Just(" # a \"comment\" ]\r\n")
    ];
    (
        proptest::sample::select(ParamType::WORDS.map(|(word, _)| word).to_vec()),
        "[a-zA-Z_][a-zA-Z0-9_:.]{0,8}",
        proptest::collection::vec(decimal(), 0..12),
        proptest::collection::vec("[ -~]{0,9}", 1..4),
        any::<bool>(),
        blank,
    )
        .prop_map(|(word, name, mut numbers, mut strings, flag, blank)| {
            let ty = ParamType::from_word(word).expect("a known word");
            let mut bools = vec![flag; strings.len()];
            let files = ty == ParamType::Spectrum && flag;
            if files || matches!(ty, ParamType::String | ParamType::Texture | ParamType::Bool) {
                numbers.clear();
            } else {
                numbers.truncate(numbers.len() / ty.items() * ty.items());
            }
            if !files && !matches!(ty, ParamType::String | ParamType::Texture) {
                strings.clear();
            }
            if ty != ParamType::Bool {
                bools.clear();
            }
            let declaration = format!("\"{word} {name}\"");
            let written = Written {
                ty,
                name,
                numbers,
                strings,
                bools,
            };
            let items = written.items(flag);
            let text = match items.as_slice() {
                [one] if flag => format!("{blank}{declaration}{blank}{one}{blank}"),
                items => format!("{blank}{declaration}{blank}[{}{blank}]", items.join(blank)),
            };
            (text, written)
        })
}

proptest! {
    #[test]
    fn valid_scenes_are_read_as_written(
        shapes in proptest::collection::vec(proptest::collection::vec(parameter(), 0..6), 0..6)
    ) {
        let mut scene = String::new();
        for params in &shapes {
            scene += "Shape \"s\"";
            scene.extend(params.iter().map(|(text, _)| text.as_str()));
            scene += "\nReverseOrientation\n";
        }
        let read = read(scene.as_str());
        prop_assert!(read.messages.is_empty(), "{}\n{}", scene, read.text);
        prop_assert_eq!(read.kinds.len(), 2 * shapes.len());
        for (kind, written) in read.kinds.iter().step_by(2).zip(&shapes) {
            let DirectiveKind::Shape(shape) = kind else { panic!("no shape") };
            let found: Vec<Written> = shape.params.params.iter().map(|param| {
                let (mut numbers, mut strings, mut bools) = (vec![], vec![], vec![]);
                match &param.value {
                    ParamValue::Numbers(given) => numbers.clone_from(given),
                    ParamValue::Strings(given) => strings = given.iter().map(|s| s.text.clone()).collect(),
                    ParamValue::Bools(given) => bools.clone_from(given),
                }
                Written { ty: param.ty, name: param.name.clone(), numbers, strings, bools }
            }).collect();
            let written: Vec<Written> = written.iter().map(|(_, w)| w.clone()).collect();
            prop_assert_eq!(found, written);
        }
    }

    /// Any bytes: it ends, does not panic, and can print what it thinks of them.
    #[test]
    fn noise_is_survived(bytes in proptest::collection::vec(any::<u8>(), 0..300)) {
        read(bytes);
    }

    /// Pieces of the language in any order.
    #[test]
    fn shuffled_scenes_are_survived(pieces in proptest::collection::vec(0..17_usize, 0..60)) {
        let parts = [
            "Shape", "\"sphere\"", "\"float x\"", "[", "]", "1", "1,2", "\"", "\n", "# ", "Translate",
            "Include \"scene.pbrt\"", "Texture \"a\" \"float\" \"b\"", "true", "Transform [", "\\", "caf\u{e9}",
        ];
        let scene: String = pieces.into_iter().flat_map(|i| [parts[i], " "]).collect();
        read(scene);
    }
}
