//! Typed indices (handles): the scene and the world own flat arrays, whose items refer to each other by these.

macro_rules! handles {
    ($($(#[$doc:meta])* $name:ident;)*) => {$(
        $(#[$doc])*
        #[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, PartialOrd, Ord)]
        pub struct $name(pub u32);

        impl $name {
            /// The index in the array that this handle refers to.
            pub fn index(self) -> usize {
                self.0 as usize
            }
        }
    )*};
}

handles! {
    /// A float-valued texture.
    FloatTextureId;
    /// A spectrum-valued texture.
    SpectrumTextureId;
    /// A material.
    MaterialId;
    /// A light source, area lights included.
    LightId;
    /// A participating medium.
    MediumId;
    /// An interface between two media.
    InterfaceId;
    /// A named object (`ObjectBegin`): shapes with a tree of their own.
    ObjectId;
}

/// Which of the image's layers of light a light belongs to: 0 for light of no group.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct LightLayer(pub u8);

impl LightLayer {
    /// Its place among them.
    pub fn index(self) -> usize {
        self.0.into()
    }
}
