//! Parameter lists as they stand in the file: typed and named values with their places.

use super::directive::Name;
use super::source::Span;
use std::cell::Cell;

/// The types a parameter can be declared with. Aliases (`color`, `point`, `vector`) are resolved.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum ParamType {
    /// Whole numbers.
    Integer,
    /// Numbers.
    Float,
    /// `"true"` or `"false"`.
    Bool,
    /// Quoted strings.
    String,
    /// The name of a texture.
    Texture,
    /// Pairs.
    Point2,
    /// Pairs.
    Vector2,
    /// Triples; `point` is the same.
    Point3,
    /// Triples; `vector` is the same.
    Vector3,
    /// Triples.
    Normal,
    /// Linear RGB with sRGB primaries; `color` is the same.
    Rgb,
    /// CIE XYZ.
    Xyz,
    /// Kelvin and scale.
    Blackbody,
    /// (nm, value) pairs that make one spectrum, or the names of `.spd` files.
    Spectrum,
}

/// What a parameter is looked up by besides its name: the types within one group stand for each
/// other, later ones replacing earlier ones of the same name.
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
    /// All groups, in the order of the scene language's table of types.
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

    /// The type one would write to get this group.
    pub fn name(self) -> &'static str {
        match self {
            Self::Integer => "integer",
            Self::Float => "float",
            Self::Bool => "bool",
            Self::String => "string",
            Self::Texture => "texture",
            Self::Point2 => "point2",
            Self::Vector2 => "vector2",
            Self::Point3 => "point3",
            Self::Vector3 => "vector3",
            Self::Normal => "normal",
            Self::Spectrum => "rgb",
        }
    }
}

impl ParamType {
    /// Every word that declares a type, aliases included.
    pub const WORDS: [&str; 17] = [
        "integer",
        "float",
        "bool",
        "string",
        "texture",
        "point2",
        "vector2",
        "point3",
        "point",
        "vector3",
        "vector",
        "normal",
        "rgb",
        "color",
        "xyz",
        "blackbody",
        "spectrum",
    ];

    /// The type a word declares.
    pub fn from_word(word: &str) -> Option<Self> {
        Some(match word {
            "integer" => Self::Integer,
            "float" => Self::Float,
            "bool" => Self::Bool,
            "string" => Self::String,
            "texture" => Self::Texture,
            "point2" => Self::Point2,
            "vector2" => Self::Vector2,
            "point3" | "point" => Self::Point3,
            "vector3" | "vector" => Self::Vector3,
            "normal" => Self::Normal,
            "rgb" | "color" => Self::Rgb,
            "xyz" => Self::Xyz,
            "blackbody" => Self::Blackbody,
            "spectrum" => Self::Spectrum,
            _ => return None,
        })
    }

    /// Does this text declare a parameter: a type and a name?
    pub fn declares(text: &str) -> bool {
        let mut words = text.split_ascii_whitespace();
        words.next().and_then(Self::from_word).is_some() && words.next().is_some()
    }

    /// The word that declares this type.
    pub fn word(self) -> &'static str {
        match self {
            Self::Rgb => "rgb",
            Self::Xyz => "xyz",
            Self::Blackbody => "blackbody",
            Self::Spectrum => "spectrum",
            other => other.group().name(),
        }
    }

    /// The group it belongs to.
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

    /// How many items make one value; the list of a well-formed parameter is a multiple of this.
    pub fn items(self) -> usize {
        match self {
            Self::Point2 | Self::Vector2 | Self::Blackbody | Self::Spectrum => 2,
            Self::Point3 | Self::Vector3 | Self::Normal | Self::Rgb | Self::Xyz => 3,
            Self::Integer | Self::Float | Self::Bool | Self::String | Self::Texture => 1,
        }
    }
}

/// What stands behind a declaration.
#[derive(Clone, Debug, PartialEq)]
pub enum ParamValue {
    /// Of the numeric types and of inline spectra: a whole number of values, possibly none.
    Numbers(Vec<f64>),
    /// Of `string`, `texture` and of spectra in files: at least one.
    Strings(Vec<Name>),
    /// Of `bool`: at least one.
    Bools(Vec<bool>),
}

/// One parameter: `"float radius" [ 2 ]`.
#[derive(Clone, Debug, PartialEq)]
pub struct Param {
    /// The declared type.
    pub ty: ParamType,
    /// The declared name.
    pub name: String,
    /// What was given; its kind fits the type.
    pub value: ParamValue,
    /// The declaration string, quotation marks included.
    pub declaration: Span,
    /// The value, brackets included.
    pub value_span: Span,
    /// Has anyone asked for it?
    pub used: Cell<bool>,
}

/// The parameters of one directive, in the order of the file.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ParamList {
    /// All of them, those that a later one replaces included.
    pub params: Vec<Param>,
}

impl ParamList {
    /// A list without parameters.
    pub const EMPTY: ParamList = ParamList { params: Vec::new() };

    /// The parameter of that name and group; the later one where there are several.
    pub fn get(&self, name: &str, group: ParamGroup) -> Option<&Param> {
        self.params
            .iter()
            .rev()
            .find(|p| p.ty.group() == group && p.name == name)
    }

    /// The last parameter of that name, whatever its type.
    pub fn named(&self, name: &str) -> Option<&Param> {
        self.params.iter().rev().find(|p| p.name == name)
    }
}
