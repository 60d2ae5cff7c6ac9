//! The classes of textures: one table for names, the reader and the dispatch.

use super::combinations::{Constant, Mix, Scale};
use super::solid::{Fbm, Solid, Windy, Wrinkled};
use super::*;
use crate::inputs::TexturesRead;
use crate::math::transform::Transform;
use crate::params::ParamReader;
use crate::surface::TexturePoint;

macro_rules! texture_classes {
    ($($name:literal => $Class:ident($Type:ty),)*) => {
        /// A texture: in world space as the scene file describes it, or, once it is prepared, in render space.
        #[derive(Clone, Debug)]
        pub enum Texture<V: TextureValue> {
            $(#[doc = concat!("`", $name, "`")] $Class($Type),)*
        }

        impl<V: TextureValue> Texture<V> {
            /// The classes that a scene may name.
            pub const KINDS: &'static [&'static str] = &[$($name,)*];

            /// The texture that `Texture "name" "type" "class"` describes under the transformation
            /// `ctm`; `None`, with a message, where there is no such class.
            pub fn from_params(reader: &ParamReader, ctm: &Transform) -> Option<Texture<V>> {
                match reader.kind() {
                    $($name if !V::HAS_COLORS && <$Type as TextureClass<V>>::COLORS_ONLY => {
                        reader.accept_all();
                        let message = "texture has colors only: no float texture is defined";
                        reader.warn("", format!("a `{}` {message}", $name));
                        None
                    })*
                    $($name => {
                        let class = <$Type as TextureClass<V>>::from_params(reader, ctm);
                        Some(Texture::$Class(class))
                    })*
                    _ => {
                        reader.unknown_kind_replaced(Self::KINDS, "no texture is defined");
                        None
                    }
                }
            }

            /// The textures this one looks values up in.
            pub(super) fn inputs(&self) -> TexturesRead {
                match self { $(Texture::$Class(t) => TextureClass::<V>::inputs(t),)* }
            }

            /// Moves it from world to render space, and asks for the files it needs.
            pub(super) fn prepare(&mut self, compiler: &mut Compiler) {
                match self { $(Texture::$Class(t) => TextureClass::<V>::prepare(t, compiler),)* }
            }

            pub(super) fn evaluate(&self, textures: &Textures, at: &TexturePoint) -> V {
                match self { $(Texture::$Class(t) => t.evaluate(textures, at),)* }
            }

            pub(super) fn needs_footprint(&self) -> bool {
                match self { $(Texture::$Class(t) => TextureClass::<V>::needs_footprint(t),)* }
            }
        }
    };
}

// A new class: its file, which implements `TextureClass`, and a line here.
texture_classes! {
    "constant" => Constant(Constant<V>),
    "scale" => Scale(Scale<V>),
    "mix" => Mix(Mix<V>),
    "bilerp" => Bilerp(Bilerp<V>),
    "uv" => Uv(Uv),
    "checkerboard" => Checkerboard(Checkerboard<V>),
    "imagemap" => Imagemap(Imagemap),
    "dots" => Dots(Dots<V>),
    "fbm" => Fbm(Solid<Fbm>),
    "wrinkled" => Wrinkled(Solid<Wrinkled>),
    "windy" => Windy(Solid<Windy>),
    "marble" => Marble(Solid<Marble>),
    "ptex" => Ptex(Ptex),
}
