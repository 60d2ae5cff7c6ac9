//! The classes of textures: one table for names, the reader and the dispatch.

use super::*;

macro_rules! texture_classes {
    ($($name:literal => $Class:ident($Spec:ty),)*) => {
        /// A texture as the scene file describes it, in world space.
        #[derive(Clone, Debug)]
        pub enum TextureSpec<V: TextureValue> {
            $(#[doc = concat!("`", $name, "`")] $Class($Spec),)*
        }

        /// A texture ready for look-ups, in render space.
        #[derive(Clone, Debug)]
        pub(super) enum Texture<V: TextureValue> {
            $($Class(<$Spec as TextureClass<V>>::Compiled),)*
        }

        impl<V: TextureValue> TextureSpec<V> {
            /// The classes that a scene may name.
            pub const KINDS: &'static [&'static str] = &[$($name,)*];

            /// The texture that `Texture "name" "type" "class"` describes under the transformation
            /// `ctm`; `None`, with a message, where there is no such class.
            pub fn from_params(reader: &ParamReader, ctm: &Transform) -> Option<TextureSpec<V>> {
                match reader.kind() {
                    $($name if !V::HAS_COLORS && <$Spec as TextureClass<V>>::COLORS_ONLY => {
                        reader.accept_all();
                        let message = "texture has colors only: no float texture is defined";
                        reader.warn("", format!("a `{}` {message}", $name));
                        None
                    })*
                    $($name => {
                        let class = <$Spec as TextureClass<V>>::from_params(reader, ctm);
                        Some(TextureSpec::$Class(class))
                    })*
                    _ => {
                        reader.unknown_kind_replaced(Self::KINDS, "no texture is defined");
                        None
                    }
                }
            }

            /// The textures this one looks values up in.
            pub(super) fn operands(&self) -> Operands<V> {
                match self {
                    $(TextureSpec::$Class(t) => Operands {
                        own: TextureClass::<V>::inputs(t),
                        amount: TextureClass::<V>::amount(t),
                    },)*
                }
            }

            pub(super) fn compile(&self, compiler: &mut Compiler) -> Texture<V> {
                match self {
                    $(TextureSpec::$Class(t) => {
                        Texture::$Class(TextureClass::<V>::compile(t, compiler))
                    })*
                }
            }
        }

        impl<V: TextureValue> Texture<V> {
            pub(super) fn evaluate(&self, textures: &Textures, at: &TexturePoint) -> V {
                match self { $(Texture::$Class(t) => t.evaluate(textures, at),)* }
            }

            pub(super) fn needs_footprint(&self) -> bool {
                match self { $(Texture::$Class(t) => Evaluate::<V>::needs_footprint(t),)* }
            }
        }
    };
}

// A new class: its file, which implements `TextureClass` and `Evaluate`, and a line here.
texture_classes! {
    "constant" => Constant(Constant<V>),
    "scale" => Scale(Scale<V>),
    "mix" => Mix(Mix<V>),
    "bilerp" => Bilerp(Bilerp<V, MappingSpec>),
    "uv" => Uv(Uv<MappingSpec>),
    "checkerboard" => Checkerboard(Checkerboard<V, MappingSpec>),
    "imagemap" => Imagemap(ImagemapSpec),
    "dots" => Dots(Dots<V, MappingSpec>),
    "fbm" => Fbm(Fbm),
    "wrinkled" => Wrinkled(Wrinkled),
    "windy" => Windy(Windy),
    "marble" => Marble(Marble),
    "ptex" => Ptex(PtexSpec),
}
