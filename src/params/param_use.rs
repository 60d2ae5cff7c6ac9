//! What has been asked for: the names and types a scene type really has.

use crate::inputs::{TextureRead, TexturesRead};
use crate::syntax::ParamGroup;
use std::cell::RefCell;
use std::ops::Range;

/// The look-ups made for one directive, shared by its readers. All names lie in one string: a
/// scene may have a million shapes, each asking for a dozen names.
#[derive(Debug, Default)]
pub(super) struct ParamUse {
    log: RefCell<Log>,
}

#[derive(Debug, Default)]
struct Log {
    names: String,
    entries: Vec<(Range<usize>, ParamGroup)>,
    textures: Vec<TextureRead>,
}

impl ParamUse {
    pub(super) fn record(&self, name: &str, group: ParamGroup) {
        let Log { names, entries, .. } = &mut *self.log.borrow_mut();
        let start = names.len();
        names.push_str(name);
        entries.push((start..names.len(), group));
    }

    pub(super) fn record_texture(&self, texture: TextureRead) {
        self.log.borrow_mut().textures.push(texture);
    }

    /// How many textures have been read.
    pub(super) fn textures(&self) -> usize {
        self.log.borrow().textures.len()
    }

    /// The textures read after the first `count`.
    pub(super) fn textures_since(&self, count: usize) -> TexturesRead {
        let log = self.log.borrow();
        log.textures.get(count..).unwrap_or_default().to_vec()
    }

    /// The groups a name was asked for with, in the order of the table of types.
    pub(super) fn groups(&self, name: &str) -> Vec<ParamGroup> {
        let Log { names, entries, .. } = &*self.log.borrow();
        let asked = |group| {
            entries
                .iter()
                .any(|(at, g)| *g == group && names.get(at.clone()) == Some(name))
        };
        ParamGroup::ALL
            .into_iter()
            .filter(|group| asked(*group))
            .collect()
    }

    /// Every name asked for, possibly several times.
    pub(super) fn names(&self) -> Vec<String> {
        let Log { names, entries, .. } = &*self.log.borrow();
        entries
            .iter()
            .filter_map(|(at, _)| names.get(at.clone()).map(str::to_owned))
            .collect()
    }
}
