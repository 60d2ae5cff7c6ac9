//! The graphics state saved by `AttributeBegin` (docs/scene-language.md §2.1). The tables of names are not copied;
//! changes are undone instead, so that saving and defining cost the same however many textures and materials a scene
//! has.

use crate::handles::{FloatTextureId, MaterialId, SpectrumTextureId};
use crate::params::TextureNames;
use crate::syntax::{Name, Typed};
use std::cell::Cell;
use std::collections::HashMap;
use std::rc::Rc;

/// A material directive, kept so that shapes can override its parameters.
#[derive(Debug)]
pub struct MaterialDirective {
    /// Type and parameters.
    pub typed: Typed,
    /// The resulting material; `None` for `"none"`.
    pub id: Option<MaterialId>,
    /// Made by `MakeNamedMaterial`.
    pub named: bool,
}

/// A `MediumInterface` directive: names are looked up when a shape uses them.
#[derive(Debug)]
pub struct InterfaceDirective {
    /// The medium opposite the normal; `""` is vacuum.
    pub inside: Name,
    /// The medium that the normal points to.
    pub outside: Name,
    /// `true` if an undefined name has been reported.
    pub reported: Cell<bool>,
}

/// A definition inside a scope, and the previous meaning of its name.
#[derive(Debug)]
enum Redefined {
    FloatTexture(String, Option<FloatTextureId>),
    SpectrumTexture(String, Option<SpectrumTextureId>),
    Material(String, Option<Rc<MaterialDirective>>),
}

/// The part of the graphics state saved by a scope.
#[derive(Debug)]
pub struct SavedGraphicsState {
    /// Everything but the names, whose tables are empty here.
    rest: GraphicsState,
    /// The number of definitions made inside scopes before.
    redefined: usize,
    /// `true` if there are enclosing scopes.
    inside_scope: bool,
}

/// The graphics state.
#[derive(Debug)]
pub struct GraphicsState {
    /// Current material; `None` until the first `Material`: matte with its defaults.
    pub material: Option<Rc<MaterialDirective>>,
    /// The last `Material`: in pbrt-v2 the fallback for unknown named materials.
    pub unnamed_material: Option<Rc<MaterialDirective>>,
    /// In pbrt-v2, the name of a material that was undefined when it was requested: the next shape looks it up again.
    pub late_material: Option<Name>,
    /// Texture names in scope.
    pub textures: Rc<TextureNames>,
    /// Named materials in scope.
    pub named_materials: Rc<HashMap<String, Rc<MaterialDirective>>>,
    /// Emission of later shapes: an entry of [`Frame::area_lights`](super::Frame::area_lights).
    pub area_light: Option<usize>,
    /// `ReverseOrientation` flag.
    pub reverse_orientation: bool,
    /// The media on both sides of later shapes; `None` until the first `MediumInterface`: vacuum.
    pub medium_interface: Option<Rc<InterfaceDirective>>,
    /// Definitions to be undone at the ends of the open scopes, in order.
    redefined: Vec<Redefined>,
    /// `true` if a scope is open. Definitions outside all scopes are permanent.
    inside_scope: bool,
}

impl GraphicsState {
    /// The state at the start of a frame.
    pub fn new() -> GraphicsState {
        GraphicsState {
            material: None,
            unnamed_material: None,
            late_material: None,
            textures: Rc::default(),
            named_materials: Rc::default(),
            area_light: None,
            reverse_orientation: false,
            medium_interface: None,
            redefined: Vec::new(),
            inside_scope: false,
        }
    }

    /// Opens a scope.
    pub fn save(&mut self) -> SavedGraphicsState {
        SavedGraphicsState {
            rest: GraphicsState {
                material: self.material.clone(),
                unnamed_material: self.unnamed_material.clone(),
                late_material: self.late_material.clone(),
                area_light: self.area_light,
                reverse_orientation: self.reverse_orientation,
                medium_interface: self.medium_interface.clone(),
                ..GraphicsState::new()
            },
            redefined: self.redefined.len(),
            inside_scope: std::mem::replace(&mut self.inside_scope, true),
        }
    }

    /// Closes a scope.
    pub fn restore(&mut self, saved: SavedGraphicsState) {
        while self.redefined.len() > saved.redefined
            && let Some(redefined) = self.redefined.pop()
        {
            self.take_back(redefined);
        }
        *self = GraphicsState {
            textures: std::mem::take(&mut self.textures),
            named_materials: std::mem::take(&mut self.named_materials),
            redefined: std::mem::take(&mut self.redefined),
            inside_scope: saved.inside_scope,
            ..saved.rest
        };
    }

    fn take_back(&mut self, redefined: Redefined) {
        match redefined {
            Redefined::FloatTexture(name, before) => {
                put_back(&mut Rc::make_mut(&mut self.textures).float, name, before);
            }
            Redefined::SpectrumTexture(name, before) => {
                put_back(&mut Rc::make_mut(&mut self.textures).spectrum, name, before);
            }
            Redefined::Material(name, before) => {
                put_back(Rc::make_mut(&mut self.named_materials), name, before);
            }
        }
    }

    /// Records a definition that the end of the scope undoes.
    fn note(&mut self, redefined: impl FnOnce() -> Redefined) {
        if self.inside_scope {
            self.redefined.push(redefined());
        }
    }

    /// Defines a float texture; returns `true` if the name was already defined.
    pub fn define_float_texture(&mut self, name: &str, id: FloatTextureId) -> bool {
        let names = &mut Rc::make_mut(&mut self.textures).float;
        let before = names.insert(name.to_string(), id);
        self.note(|| Redefined::FloatTexture(name.to_string(), before));
        before.is_some()
    }

    /// Defines a spectrum texture; returns `true` if the name was already defined.
    pub fn define_spectrum_texture(&mut self, name: &str, id: SpectrumTextureId) -> bool {
        let names = &mut Rc::make_mut(&mut self.textures).spectrum;
        let before = names.insert(name.to_string(), id);
        self.note(|| Redefined::SpectrumTexture(name.to_string(), before));
        before.is_some()
    }

    /// Defines a named material; returns `true` if the name was already defined.
    pub fn define_material(&mut self, name: &str, material: MaterialDirective) -> bool {
        let names = Rc::make_mut(&mut self.named_materials);
        let before = names.insert(name.to_string(), Rc::new(material));
        let taken = before.is_some();
        self.note(|| Redefined::Material(name.to_string(), before));
        taken
    }
}

fn put_back<V>(names: &mut HashMap<String, V>, name: String, before: Option<V>) {
    match before {
        Some(value) => drop(names.insert(name, value)),
        None => drop(names.remove(&name)),
    }
}

impl Default for GraphicsState {
    fn default() -> Self {
        GraphicsState::new()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn definitions_end_with_their_scopes() {
        let mut state = GraphicsState::new();
        let float = |state: &GraphicsState| state.textures.float.get("a").map(|id| id.0);
        let spectrum = |state: &GraphicsState| state.textures.spectrum.get("a").map(|id| id.0);
        state.define_float_texture("a", FloatTextureId(1));
        let outer = state.save();
        assert!(state.define_float_texture("a", FloatTextureId(2)));
        assert!(!state.define_spectrum_texture("a", SpectrumTextureId(3)));
        state.reverse_orientation = true;
        let inner = state.save();
        assert!(state.define_float_texture("a", FloatTextureId(4)));
        assert!(state.define_float_texture("a", FloatTextureId(5)));
        state.reverse_orientation = false;
        assert_eq!((float(&state), spectrum(&state)), (Some(5), Some(3)));
        state.restore(inner);
        assert_eq!((float(&state), spectrum(&state)), (Some(2), Some(3)));
        assert!(state.reverse_orientation && state.inside_scope);
        state.restore(outer);
        assert_eq!((float(&state), spectrum(&state)), (Some(1), None));
        assert!(!state.reverse_orientation && !state.inside_scope);
        // Outside scopes nothing is recorded to be undone.
        state.define_float_texture("b", FloatTextureId(6));
        assert!(state.redefined.is_empty());
    }
}
