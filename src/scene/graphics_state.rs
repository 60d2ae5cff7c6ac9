//! What `AttributeBegin` saves (scene-language 2.1). Maps are shared until one side changes, so
//! that saving costs the same however many textures a scene defines.

use crate::handles::{FloatTextureId, MaterialId, SpectrumTextureId};
use crate::params::TextureNames;
use crate::syntax::{Name, Typed};
use std::cell::Cell;
use std::collections::HashMap;
use std::rc::Rc;

/// A material as the file gave it, kept so that shapes can override its parameters.
#[derive(Debug)]
pub struct MaterialDirective {
    /// Type and parameters.
    pub typed: Typed,
    /// The material made from them; `None` for `"none"`.
    pub id: Option<MaterialId>,
    /// Made by `MakeNamedMaterial`.
    pub named: bool,
}

/// A `MediumInterface` as the file gave it: names are looked up when a shape uses them.
#[derive(Debug)]
pub struct InterfaceDirective {
    /// Against the normal; `""` is vacuum.
    pub inside: Name,
    /// Where the normal points.
    pub outside: Name,
    /// A name that nobody has defined has been reported.
    pub reported: Cell<bool>,
}

/// The graphics state.
#[derive(Clone, Debug)]
pub struct GraphicsState {
    /// Current material; `None` until the first `Material`: matte with its defaults.
    pub material: Option<Rc<MaterialDirective>>,
    /// What `Material` gave last: in pbrt-v2 unknown named materials fall back on it.
    pub unnamed_material: Option<Rc<MaterialDirective>>,
    /// In pbrt-v2, the name of a material that was unknown when it was asked for: the next shape
    /// looks it up again.
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
        }
    }

    /// Brings a float texture into scope; true where the name was taken.
    pub fn define_float_texture(&mut self, name: &str, id: FloatTextureId) -> bool {
        Rc::make_mut(&mut self.textures)
            .float
            .insert(name.to_string(), id)
            .is_some()
    }

    /// Brings a spectrum texture into scope; true where the name was taken.
    pub fn define_spectrum_texture(&mut self, name: &str, id: SpectrumTextureId) -> bool {
        Rc::make_mut(&mut self.textures)
            .spectrum
            .insert(name.to_string(), id)
            .is_some()
    }

    /// Brings a named material into scope; true where the name was taken.
    pub fn define_material(&mut self, name: &str, material: MaterialDirective) -> bool {
        Rc::make_mut(&mut self.named_materials)
            .insert(name.to_string(), Rc::new(material))
            .is_some()
    }
}

impl Default for GraphicsState {
    fn default() -> Self {
        GraphicsState::new()
    }
}
