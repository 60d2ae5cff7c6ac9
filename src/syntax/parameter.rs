//! Parameter lists as written in the file: typed and named values with their locations.

use super::directive::Name;
use super::source::Span;
use std::cell::Cell;

/// The types a parameter can be declared with. Aliases (`color`, `point`, `vector`) are resolved.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum ParamType {
    /// Integers.
    Integer,
    /// Floating-point numbers.
    Float,
    /// `"true"` or `"false"`.
    Bool,
    /// Quoted strings.
    String,
    /// The name of a texture.
    Texture,
    /// 2D points.
    Point2,
    /// 2D vectors.
    Vector2,
    /// 3D points; `point` is the same.
    Point3,
    /// 3D vectors; `vector` is the same.
    Vector3,
    /// Surface normals.
    Normal,
    /// Linear RGB with sRGB primaries; `color` is the same.
    Rgb,
    /// CIE XYZ.
    Xyz,
    /// Temperature in kelvin, and scale.
    Blackbody,
    /// (nm, value) pairs that form one spectrum, or the names of `.spd` files.
    Spectrum,
}

/// The type by which a parameter is looked up, besides its name: the types within a group are interchangeable, later
/// ones replacing earlier ones of the same name.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum ParamGroup {
    /// `integer`
    Integer,
    /// `float`
    Float,
    /// `bool`
    Bool,
    /// `string`
    String,
    /// `texture`
    Texture,
    /// `point2`
    Point2,
    /// `vector2`
    Vector2,
    /// `point3`
    Point3,
    /// `vector3`
    Vector3,
    /// `normal`
    Normal,
    /// `rgb`, `xyz`, `blackbody`, `spectrum`
    Spectrum,
}

impl ParamGroup {
    /// All groups, in the order of the type table of the scene language.
    pub const ALL: [Self; 11] = [
        Self::Integer,
        Self::Float,
        Self::Bool,
        Self::String,
        Self::Texture,
        Self::Point2,
        Self::Vector2,
        Self::Point3,
        Self::Vector3,
        Self::Normal,
        Self::Spectrum,
    ];
}

impl ParamType {
    /// Every word that declares a type, each type's own before its aliases.
    pub const WORDS: [(&str, Self); 17] = [
        ("integer", Self::Integer),
        ("float", Self::Float),
        ("bool", Self::Bool),
        ("string", Self::String),
        ("texture", Self::Texture),
        ("point2", Self::Point2),
        ("vector2", Self::Vector2),
        ("point3", Self::Point3),
        ("point", Self::Point3),
        ("vector3", Self::Vector3),
        ("vector", Self::Vector3),
        ("normal", Self::Normal),
        ("rgb", Self::Rgb),
        ("color", Self::Rgb),
        ("xyz", Self::Xyz),
        ("blackbody", Self::Blackbody),
        ("spectrum", Self::Spectrum),
    ];

    /// The type that a word declares.
    pub fn from_word(word: &str) -> Option<Self> {
        let (_, ty) = Self::WORDS.iter().find(|(own, _)| *own == word)?;
        Some(*ty)
    }

    /// Returns `true` if this text declares a parameter: a type and a name.
    pub fn declares(text: &str) -> bool {
        let mut words = text.split_ascii_whitespace();
        words.next().and_then(Self::from_word).is_some() && words.next().is_some()
    }

    /// The word that declares this type.
    pub fn word(self) -> &'static str {
        let found = Self::WORDS.iter().find(|(_, ty)| *ty == self);
        found.map_or("", |(word, _)| word)
    }

    /// The group that it belongs to.
    pub fn group(self) -> ParamGroup {
        match self {
            Self::Integer => ParamGroup::Integer,
            Self::Float => ParamGroup::Float,
            Self::Bool => ParamGroup::Bool,
            Self::String => ParamGroup::String,
            Self::Texture => ParamGroup::Texture,
            Self::Point2 => ParamGroup::Point2,
            Self::Vector2 => ParamGroup::Vector2,
            Self::Point3 => ParamGroup::Point3,
            Self::Vector3 => ParamGroup::Vector3,
            Self::Normal => ParamGroup::Normal,
            Self::Rgb | Self::Xyz | Self::Blackbody | Self::Spectrum => ParamGroup::Spectrum,
        }
    }

    /// The number of items per value; the list of a well-formed parameter is a multiple of this.
    pub fn items(self) -> usize {
        match self {
            Self::Point2 | Self::Vector2 | Self::Blackbody | Self::Spectrum => 2,
            Self::Point3 | Self::Vector3 | Self::Normal | Self::Rgb | Self::Xyz => 3,
            Self::Integer | Self::Float | Self::Bool | Self::String | Self::Texture => 1,
        }
    }
}

/// The value of a parameter.
#[derive(Clone, Debug, PartialEq)]
pub enum ParamValue {
    /// For numeric types and inline spectra: items of complete values, possibly none.
    Numbers(Vec<f64>),
    /// For `string`, `texture` and spectra in files: at least one.
    Strings(Vec<Name>),
    /// For `bool`: at least one.
    Bools(Vec<bool>),
}

/// One parameter: `"float radius" [ 2 ]`.
#[derive(Clone, Debug, PartialEq)]
pub struct Param {
    /// The declared type.
    pub ty: ParamType,
    /// The declared name.
    pub name: String,
    /// The value, whose variant fits the type.
    pub value: ParamValue,
    /// Location of the declaration string, including quotation marks.
    pub declaration: Span,
    /// Location of the value, including brackets.
    pub value_span: Span,
    /// `true` if it has been looked up.
    pub used: Cell<bool>,
}

/// The parameters of one directive, in file order.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ParamList {
    /// All of them, including those that a later one replaces.
    pub params: Vec<Param>,
}

impl ParamList {
    /// An empty list.
    pub const EMPTY: ParamList = ParamList { params: Vec::new() };

    /// The parameter with that name and group; the last one if there are several.
    pub fn get(&self, name: &str, group: ParamGroup) -> Option<&Param> {
        self.params
            .iter()
            .rev()
            .find(|p| p.ty.group() == group && p.name == name)
    }

    /// The last parameter with that name, whatever its type.
    pub fn named(&self, name: &str) -> Option<&Param> {
        self.params.iter().rev().find(|p| p.name == name)
    }
}
