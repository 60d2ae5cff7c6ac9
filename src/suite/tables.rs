//! The tables of a suite file, and everything that is wrong with their form; what they mean is in [`file`](super::file).

use crate::syntax::{Diagnostic, Diagnostics};
use serde::Deserialize;
use std::collections::{BTreeMap, BTreeSet};
use toml::de::{DeArray, DeTable, DeValue, Deserializer};
use toml::{Spanned, Value};

/// So many mistakes of its form are told, each with the cost of reading it anew; with the note that there are more they are
/// as many messages as are printed.
const MISTAKES: usize = 99;

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct FileTable {
    #[serde(default)]
    pub(super) suite: SuiteTable,
    #[serde(default)]
    pub(super) renderer: BTreeMap<String, RendererTable>,
    #[serde(default)]
    pub(super) scene: Vec<Spanned<SceneTable>>,
    /// No scene was taken out, and nothing beside them, for its mistakes.
    #[serde(skip)]
    pub(super) is_complete: bool,
}

#[derive(Deserialize, Default)]
#[serde(deny_unknown_fields)]
pub(super) struct SuiteTable {
    pub(super) name: Option<String>,
    pub(super) alpha: Option<Spanned<f64>>,
    pub(super) correction: Option<Spanned<String>>,
    pub(super) noise: Option<Spanned<String>>,
    pub(super) cell: Option<Spanned<u32>>,
    pub(super) blocks: Option<Spanned<Vec<u32>>>,
    pub(super) tolerance: Option<Spanned<f64>>,
    pub(super) output: Option<String>,
    pub(super) references: Option<String>,
    pub(super) commits: Option<String>,
    pub(super) renderer: Option<Spanned<String>>,
    pub(super) spp: Option<Spanned<u32>>,
    pub(super) seeds: Option<Spanned<Vec<u64>>>,
    pub(super) baseline_seeds: Option<Spanned<Vec<u64>>>,
    pub(super) timeout: Option<Spanned<f64>>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RendererTable {
    pub(super) command: Spanned<Value>,
    pub(super) extension: Option<Spanned<String>>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct SceneTable {
    pub(super) file: Spanned<String>,
    pub(super) name: Option<Spanned<String>>,
    pub(super) renderer: Option<Spanned<String>>,
    pub(super) spp: Option<Spanned<u32>>,
    pub(super) seeds: Option<Spanned<Vec<u64>>>,
    pub(super) baseline_seeds: Option<Spanned<Vec<u64>>>,
    pub(super) timeout: Option<Spanned<f64>>,
    pub(super) reference: Option<String>,
    pub(super) sha256: Option<Spanned<String>>,
}

impl FileTable {
    /// The tables of a file; `None` if their form lacks anything, all of which is told to `refuse`.
    pub(super) fn parse(
        text: &str,
        problems: &Diagnostics,
        refuse: impl Fn(&toml::de::Error),
    ) -> Option<FileTable> {
        let (mut root, errors) = DeTable::parse_recoverable(text);
        errors.iter().for_each(&refuse);
        if !errors.is_empty() {
            return None;
        }
        let (mut is_whole, all) = (true, entries(&root));
        // Where the tables begin from which something was taken out.
        let mut reduced = BTreeSet::new();
        for _ in 0..MISTAKES {
            let error = match FileTable::deserialize(Deserializer::from(root.clone())) {
                Ok(mut tables) => {
                    tables.is_complete = entries(&root) == all;
                    return is_whole.then_some(tables);
                }
                Err(error) => error,
            };
            let start = error.span().map(|at| at.start);
            let message = error.message();
            let is_unknown = message.starts_with("unknown field");
            // What is missing may be what was taken out, or could not be understood.
            let is_lost = start.is_some_and(|start| reduced.contains(&start));
            if !(is_lost && message.starts_with("missing field")) {
                refuse(&error);
            }
            // A scene without its file is left out, a renderer without its command, and what is unknown.
            is_whole &= is_unknown || message.starts_with("missing field");
            reduced.insert(take_out(root.get_mut(), 0, start?)?);
        }
        problems.push(Diagnostic::error("… and more"));
        None
    }
}

/// How many entries a table has, with the items of those that are arrays, and the renderers.
fn entries(table: &Spanned<DeTable>) -> usize {
    let of = |name: &str, value: &Spanned<DeValue>| match value.get_ref() {
        DeValue::Array(items) => 1 + items.len(),
        DeValue::Table(renderers) if name == "renderer" => 1 + renderers.len(),
        _ => 1,
    };
    { table.get_ref().iter() }
        .map(|(name, value)| of(name.get_ref(), value))
        .sum()
}

/// Takes out the innermost entry that an error at this byte is about, of a table that begins at `start`. Returns where the
/// table or array begins that it was in, if there is one.
fn take_out(table: &mut DeTable, start: usize, at: usize) -> Option<usize> {
    let mut gone = None;
    for (key, value) in table.iter_mut() {
        let is_here = key.span().contains(&at) || value.span().contains(&at);
        let inner_start = value.span().start;
        let inside = match value.get_mut() {
            DeValue::Table(inner) => take_out(inner, inner_start, at),
            DeValue::Array(items) => take_out_of(items, inner_start, at),
            _ => None,
        };
        if inside.is_some() {
            return inside;
        }
        if is_here {
            gone = Some(key.clone());
        }
    }
    table.remove(&gone?).map(|_| start)
}

/// The same of an array, whose items may be tables.
fn take_out_of(items: &mut DeArray, start: usize, at: usize) -> Option<usize> {
    let of_item = |item: &mut Spanned<DeValue>| {
        let start = item.span().start;
        match item.get_mut() {
            DeValue::Table(inner) => take_out(inner, start, at),
            _ => None,
        }
    };
    let inside = items.iter_mut().find_map(of_item);
    if inside.is_some() {
        return inside;
    }
    let count = items.len();
    let others = { items.clone().into_iter() }.filter(|item| !item.span().contains(&at));
    *items = others.collect();
    (items.len() < count).then_some(start)
}
