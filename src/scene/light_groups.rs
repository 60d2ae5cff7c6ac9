//! Groups of lights, by the parameter `"string group"` of `LightSource` and `AreaLightSource` (ours, not pbrt-v3's): with `--aov lights`
//! the image has a layer of the light of each.

use super::interpreter::Interpreter;
use crate::film::{LayerSet, NO_GROUP};
use crate::handles::LightLayer;
use crate::params::ParamReader;
use crate::syntax::{Diagnostic, Span};

/// The longest name of a group: names of channels have 31 characters at most, of which `light_` and `.R` take eight.
const LONGEST: usize = 23;

/// The groups that a scene names, and what is in them.
#[derive(Clone, Debug, Default)]
pub struct LightGroups {
    /// In the order of their first lights. Group i has layer i + 1.
    pub names: Vec<String>,
    /// The layer of each light source.
    pub of_lights: Vec<LightLayer>,
    /// The layer of each area light.
    pub of_area_lights: Vec<LightLayer>,
}

impl LightGroups {
    /// The group that a light says it is in, if its name will do for one.
    pub(super) fn name(reader: &ParamReader) -> Option<String> {
        let name = reader.find_string("group")?;
        let is_plain = |c: char| c.is_alphanumeric() || matches!(c, '_' | '-');
        if name == NO_GROUP {
            let message = format!("`{NO_GROUP}` is what light without a group is called");
            reader.error("group", message);
        } else if name.is_empty() || name.len() > LONGEST || !name.chars().all(is_plain) {
            let message = format!(
                "a group's name is of letters, digits, `_` and `-`, {LONGEST} bytes at most: it becomes that of channels"
            );
            reader.error("group", message);
        } else {
            return Some(name.to_string());
        }
        None
    }

    /// The layer of a group; `None` if there are too many.
    fn layer(&mut self, name: &str) -> Option<LightLayer> {
        let known = self.names.iter().position(|known| known == name);
        let index = known.unwrap_or_else(|| {
            self.names.push(name.to_string());
            self.names.len() - 1
        });
        if index + 1 < LayerSet::MAX_LIGHTS {
            return Some(LightLayer(index as u8 + 1));
        }
        self.names.truncate(LayerSet::MAX_LIGHTS - 1);
        None
    }
}

impl Interpreter<'_> {
    /// The layer of the group that the light at `span` is in, if it is in one.
    pub(super) fn layer_of_group(&mut self, span: Span, group: Option<String>) -> LightLayer {
        let Some((world, group)) = self.world.as_mut().zip(group) else {
            return LightLayer::default();
        };
        world.light_groups.layer(&group).unwrap_or_else(|| {
            let most = LayerSet::MAX_LIGHTS - 1;
            let message =
                format!("`{group}` is one group of lights too many: there are at most {most}");
            self.diagnostics
                .push(Diagnostic::error(message).at(span).recoverable());
            LightLayer::default()
        })
    }
}
