//! Cryptomatte: numbers for names, and the attributes that tell a compositing program which is which.
//!
//! Sources: J. Friedman and A. C. Jones, "Fully automatic ID mattes with support for motion blur and transparency", SIGGRAPH 2015
//! posters; Psyop, *Cryptomatte Specification*, version 1.2.0, 2018; A. Appleby, MurmurHash3 (x86, 32 bits), public domain.

use super::{Layer, LayerSet};
use serde::{Deserialize, Serialize};

/// The channels of `material`: number and part by turns.
pub(super) const MATERIAL: [&str; 12] = [
    "CryptoMaterial00.R",
    "CryptoMaterial00.G",
    "CryptoMaterial00.B",
    "CryptoMaterial00.A",
    "CryptoMaterial01.R",
    "CryptoMaterial01.G",
    "CryptoMaterial01.B",
    "CryptoMaterial01.A",
    "CryptoMaterial02.R",
    "CryptoMaterial02.G",
    "CryptoMaterial02.B",
    "CryptoMaterial02.A",
];

/// Of `instance`, by the name that such a layer has elsewhere.
pub(super) const OBJECT: [&str; 12] = [
    "CryptoObject00.R",
    "CryptoObject00.G",
    "CryptoObject00.B",
    "CryptoObject00.A",
    "CryptoObject01.R",
    "CryptoObject01.G",
    "CryptoObject01.B",
    "CryptoObject01.A",
    "CryptoObject02.R",
    "CryptoObject02.G",
    "CryptoObject02.B",
    "CryptoObject02.A",
];

/// The number of a name in a matte.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct MatteId(u32);

impl MatteId {
    /// Of this name: its hash, as a float that is neither infinite, nor subnormal, nor no number.
    pub fn of(name: &str) -> MatteId {
        let hash = murmur3(name.as_bytes());
        let exponent = hash >> 23 & 0xff;
        let is_usual = (1..0xff).contains(&exponent);
        MatteId(if is_usual { hash } else { hash ^ 1 << 23 })
    }

    /// As a channel has it.
    pub fn number(self) -> f32 {
        f32::from_bits(self.0)
    }

    pub(super) fn bits(self) -> u32 {
        self.0
    }

    pub(super) fn from_bits(bits: u32) -> MatteId {
        MatteId(bits)
    }
}

/// The names of things in a matte.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Manifest {
    layer: Layer,
    /// JSON: an object with the number of each name in hexadecimal.
    names: String,
}

impl Manifest {
    /// Of these names, in which some may be the same.
    pub fn new<'a>(layer: Layer, names: impl IntoIterator<Item = &'a String>) -> Manifest {
        let numbered =
            |name: &String| (name.clone(), format!("{:08x}", MatteId::of(name).0).into());
        let all: serde_json::Map<_, _> = names.into_iter().map(numbered).collect();
        Manifest {
            layer,
            names: serde_json::Value::Object(all).to_string(),
        }
    }

    /// Those of its attributes, with their values; none if the layer is not in the image.
    pub(in super::super) fn attributes(&self, wanted: LayerSet) -> Vec<(String, String)> {
        if !wanted.contains(self.layer) {
            return Vec::new();
        }
        let first = self.layer.channels().first().copied().unwrap_or_default();
        let name = first.trim_end_matches("00.R");
        // By which programs keep those of several mattes apart.
        let key = format!("{:08x}", murmur3(name.as_bytes()));
        let attribute = |what: &str, value: &str| {
            (
                format!("cryptomatte/{}/{what}", &key[..7]),
                value.to_string(),
            )
        };
        vec![
            attribute("name", name),
            attribute("hash", "MurmurHash3_32"),
            attribute("conversion", "uint32_to_float32"),
            attribute("manifest", &self.names),
        ]
    }
}

/// MurmurHash3 with seed 0.
fn murmur3(bytes: &[u8]) -> u32 {
    let mix = |word: u32| {
        word.wrapping_mul(0xcc9e_2d51)
            .rotate_left(15)
            .wrapping_mul(0x1b87_3593)
    };
    let (words, rest) = bytes.as_chunks::<4>();
    let mut hash = words.iter().fold(0u32, |hash, &word| {
        let hash = (hash ^ mix(u32::from_le_bytes(word))).rotate_left(13);
        hash.wrapping_mul(5).wrapping_add(0xe654_6b64)
    });
    let mut last = [0; 4];
    last[..rest.len()].copy_from_slice(rest);
    hash ^= mix(u32::from_le_bytes(last));
    hash ^= bytes.len() as u32;
    hash = (hash ^ hash >> 16).wrapping_mul(0x85eb_ca6b);
    hash = (hash ^ hash >> 13).wrapping_mul(0xc2b2_ae35);
    hash ^ hash >> 16
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Values of the reference implementation, and the specification's own example of a manifest.
    #[test]
    fn hashes_are_those_of_others() {
        assert_eq!(murmur3(b""), 0);
        assert_eq!(murmur3(b"test"), 0xba6b_d213);
        assert_eq!(murmur3(b"Hello, world!"), 0xc036_3e43);
        assert_eq!(
            murmur3(b"The quick brown fox jumps over the lazy dog"),
            0x2e4f_f723
        );
        let names = ["bunny", "default"].map(String::from);
        let manifest = Manifest::new(Layer::Instance, &names);
        assert_eq!(
            manifest.names,
            r#"{"bunny":"13851a76","default":"42c9679f"}"#
        );
    }

    #[test]
    fn numbers_are_normal() {
        let mut changed = 0;
        for i in 0..100_000 {
            let name = i.to_string();
            let id = MatteId::of(&name);
            assert!(id.number().is_normal(), "{name}");
            changed += usize::from(id.0 != murmur3(name.as_bytes()));
        }
        // Two of 256 exponents.
        assert!((500..1100).contains(&changed), "{changed}");
    }

    #[test]
    fn a_matte_has_four_attributes() {
        let manifest = Manifest::new(Layer::Material, &["wall \"a\"".to_string()]);
        assert!(manifest.attributes(LayerSet::NONE).is_empty());
        let attributes = manifest.attributes(LayerSet::NONE.with(Layer::Material));
        let names: Vec<&str> = attributes.iter().map(|(name, _)| &name[20..]).collect();
        assert_eq!(names, ["name", "hash", "conversion", "manifest"]);
        assert_eq!(attributes[0].1, "CryptoMaterial");
        assert!(attributes[3].1.starts_with(r#"{"wall \"a\"":""#));
        // Longer names of attributes are not for every program.
        assert!(attributes.iter().all(|(name, _)| name.len() <= 31));
    }
}
