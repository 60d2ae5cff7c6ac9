//! Bytes as a scene: every choice of the grammar of scene files is taken from them, so that whatever a
//! fuzzer does to the bytes, most of what comes out is a scene, and small changes are small changes.

use super::vocabulary::*;
use arbitrary::{Result, Unstructured};
use std::fmt::Write as _;

/// A scene, the same for the same bytes.
pub(crate) fn scene_text(bytes: &[u8]) -> String {
    let mut writer = Writer {
        from: Unstructured::new(bytes),
        text: String::new(),
    };
    // Bytes that ran out leave a shorter scene.
    let _ = writer.scene();
    writer.text
}

/// Numbers that mean something in most places.
const PLAIN: [&str; 16] = [
    "0", "1", ".5", "2", "-1", ".1", "3", "90", "45", ".9", "1.5", "10", "-.3", ".01", "360", ".75",
];

/// Numbers at the ends of what numbers can be.
const EXTREME: [&str; 16] = [
    "1e-30",
    "1e30",
    "-1e30",
    "3e38",
    "1e-45",
    "1e300",
    "-0",
    "1e-7",
    "1e7",
    "16777217",
    "0.99999994",
    "1.0000001",
    "-1e7",
    "2147483647",
    "1e-10",
    "1e10",
];

struct Writer<'a> {
    from: Unstructured<'a>,
    text: String,
}

impl<'a> Writer<'a> {
    /// True once in `n`; false where the bytes ran out.
    fn once_in(&mut self, n: u8) -> Result<bool> {
        self.chance(1, n)
    }

    /// True `hits` times in `n`; false where the bytes ran out.
    fn chance(&mut self, hits: u8, n: u8) -> Result<bool> {
        Ok(!self.from.is_empty() && self.from.ratio(hits, n)?)
    }

    fn pick<T>(&mut self, from: &'static [T]) -> Result<&'static T> {
        self.from.choose(from)
    }

    fn write(&mut self, text: &str) {
        self.text.push_str(text);
        self.text.push(' ');
    }

    fn number(&mut self) -> Result<()> {
        let from = if self.once_in(12)? { &EXTREME } else { &PLAIN };
        let number = self.pick(from)?;
        self.write(number);
        Ok(())
    }

    fn numbers(&mut self, count: usize) -> Result<()> {
        (0..count).try_for_each(|_| self.number())
    }

    /// `"type name" [ what `values` writes ]`.
    fn parameter(
        &mut self,
        kind: &str,
        name: &str,
        values: impl FnOnce(&mut Self) -> Result<()>,
    ) -> Result<()> {
        let _ = write!(self.text, "\"{kind} {name}\" [ ");
        let written = values(self);
        self.write("]");
        written
    }

    fn one_of(&mut self, choices: &str) -> Result<()> {
        let choices: Vec<&str> = choices.split('|').collect();
        let choice = *self.from.choose(&choices)?;
        let _ = write!(self.text, "\"{choice}\" ");
        Ok(())
    }

    /// A small number as counts are, seldom another one.
    fn count(&mut self) -> Result<()> {
        let count = if self.once_in(12)? {
            self.from.int_in_range(-2..=64)?
        } else {
            self.from.int_in_range(0..=4)?
        };
        let _ = write!(self.text, "{count} ");
        Ok(())
    }

    fn color(&mut self, name: &str) -> Result<()> {
        match self.from.int_in_range(0..=7)? {
            0 => self.parameter("blackbody", name, |w| w.numbers(2)),
            1 => self.parameter("spectrum", name, |w| {
                w.one_of("spectra/paint.spd|spectra/nosuch.spd")
            }),
            2 => self.parameter("spectrum", name, |w| {
                w.write("400 1 500");
                w.numbers(1)?;
                w.write("600 .5");
                Ok(())
            }),
            3 => self.parameter("xyz", name, |w| w.numbers(3)),
            4 => self.parameter("texture", name, |w| w.one_of("colors|colors|floats|nosuch")),
            _ => self.parameter("rgb", name, |w| w.numbers(3)),
        }
    }

    /// One parameter as `vocabulary` spells it; `color` says of what textures are.
    fn spelled(&mut self, spelling: &str, color: bool) -> Result<()> {
        let mut words = spelling.splitn(3, ' ');
        let mut next = || words.next().unwrap_or_default();
        let (kind, name, choices) = (next(), next(), next());
        let (letter, count) = kind.split_at(1.min(kind.len()));
        let count: usize = count.parse().unwrap_or(1);
        // Lists are now and then too short or too long.
        let count = if count > 1 && self.once_in(24)? {
            self.from.int_in_range(0..=count + 2)?
        } else {
            count
        };
        match letter {
            "b" => self.parameter("bool", name, |w| w.one_of("true|false")),
            "i" => self.parameter("integer", name, Self::count),
            "I" => self.parameter("integer", name, |w| (0..count).try_for_each(|_| w.count())),
            "s" => self.parameter("string", name, |w| w.one_of(choices)),
            "p" => self.parameter("point", name, |w| w.numbers(3)),
            "P" => self.parameter("point", name, |w| w.numbers(3 * count)),
            "N" => self.parameter("normal", name, |w| w.numbers(3 * count)),
            "Q" => self.parameter("float", name, |w| w.numbers(2 * count)),
            "c" => self.color(name),
            "v" if color => self.color(name),
            "t" | "v" if self.once_in(4)? => {
                self.parameter("texture", name, |w| w.one_of("floats|floats|colors|nosuch"))
            }
            "" => Ok(()),
            _ => self.parameter("float", name, |w| w.numbers(count)),
        }
    }

    /// A type of `kinds` with some of its parameters, and some of those that all of them have.
    fn kind(&mut self, kinds: &'static [Kind], of_all: &str, color: bool) -> Result<()> {
        let (kind, parameters) = self.pick(kinds)?;
        let _ = write!(self.text, "\"{kind}\" ");
        self.parameters(kind, parameters, of_all, color)?;
        self.write("\n");
        Ok(())
    }

    fn parameters(&mut self, kind: &str, own: &str, of_all: &str, color: bool) -> Result<()> {
        // Meshes and files are nothing without what they are made of.
        let needed = |spelling: &str| {
            let name = spelling.split(' ').nth(1).unwrap_or_default();
            let counted = kind == "nurbs" || kind == "heightfield";
            counted || ["P", "indices", "filename", "lensfile", "bsdffile"].contains(&name)
        };
        for spelling in own.split(';').chain(of_all.split(';')) {
            let chance = if needed(spelling) { 15 } else { 6 };
            if self.chance(chance, 16)? {
                self.spelled(spelling, color)?;
            }
        }
        Ok(())
    }

    fn directive(&mut self, word: &str, kinds: &'static [Kind], of_all: &str) -> Result<()> {
        self.write(word);
        self.kind(kinds, of_all, true)
    }

    fn transform(&mut self) -> Result<()> {
        let (word, count) = *self.pick(&[
            ("Translate", 3),
            ("Scale", 3),
            ("Rotate", 4),
            ("LookAt", 9),
            ("ConcatTransform [", 16),
            ("Transform [", 16),
        ])?;
        self.write(word);
        self.numbers(count)?;
        self.write(if count == 16 { "]\n" } else { "\n" });
        Ok(())
    }

    fn state(&mut self) -> Result<()> {
        let line = self.pick(&[
            "Identity",
            "ReverseOrientation",
            "ActiveTransform StartTime",
            "ActiveTransform EndTime",
            "ActiveTransform All",
            "CoordinateSystem \"here\"",
            "CoordSysTransform \"here\"",
            "CoordSysTransform \"camera\"",
            "TransformTimes 0 1",
            "MediumInterface \"fog\" \"\"",
            "MediumInterface \"\" \"fog\"",
            "MediumInterface \"fog\" \"fog\"",
            "NamedMaterial \"a\"",
            "NamedMaterial \"b\"",
            "ObjectInstance \"thing\"",
        ])?;
        self.write(line);
        self.write("\n");
        Ok(())
    }

    fn texture(&mut self) -> Result<()> {
        let color = self.from.arbitrary()?;
        self.write(if color {
            "Texture \"colors\" \"spectrum\""
        } else {
            "Texture \"floats\" \"float\""
        });
        self.kind(TEXTURES, OF_TEXTURES, color)
    }

    fn named_material(&mut self) -> Result<()> {
        self.write("MakeNamedMaterial");
        self.one_of("a|b")?;
        let (kind, parameters) = self.pick(MATERIALS)?;
        let _ = write!(self.text, "\"string type\" \"{kind}\" ");
        self.parameters(kind, parameters, OF_MATERIALS, true)?;
        self.write("\n");
        Ok(())
    }

    fn medium(&mut self) -> Result<()> {
        let (kind, parameters) = self.pick(MEDIA)?;
        let _ = write!(
            self.text,
            "MakeNamedMedium \"fog\" \"string type\" \"{kind}\" "
        );
        self.parameters(kind, parameters, "", true)?;
        self.write("\n");
        Ok(())
    }

    /// A block that is opened and closed, whatever happens inside.
    fn block(&mut self, depth: u32) -> Result<()> {
        let (begin, end) = *self.pick(&[
            ("AttributeBegin\n", "AttributeEnd\n"),
            ("TransformBegin\n", "TransformEnd\n"),
            ("ObjectBegin \"thing\"\n", "ObjectEnd\n"),
        ])?;
        self.write(begin);
        let written = self.world(depth + 1);
        self.write(end);
        written
    }

    /// What may stand in the world.
    fn world(&mut self, depth: u32) -> Result<()> {
        for _ in 0..self.from.int_in_range(0..=12_u8)? {
            match self.from.int_in_range(0..=15_u8)? {
                0 | 1 => self.transform()?,
                2 => self.state()?,
                3 => self.texture()?,
                4 => self.named_material()?,
                5 => self.medium()?,
                6 | 7 => self.directive("LightSource", LIGHTS, "")?,
                8 => self.directive("AreaLightSource", AREA_LIGHTS, "")?,
                9 | 10 => self.directive("Material", MATERIALS, OF_MATERIALS)?,
                11 if depth < 4 => self.block(depth)?,
                _ => self.directive("Shape", SHAPES, OF_SHAPES)?,
            }
        }
        Ok(())
    }

    fn options(&mut self) -> Result<()> {
        if self.once_in(4)? {
            self.transform()?;
        }
        if self.once_in(6)? {
            self.medium()?;
        }
        self.write("Camera");
        self.kind(CAMERAS, "", true)?;
        self.directive("Integrator", INTEGRATORS, "")?;
        for (word, kinds) in [
            ("Sampler", SAMPLERS),
            ("PixelFilter", FILTERS),
            ("Accelerator", ACCELERATORS),
        ] {
            if self.once_in(3)? {
                self.directive(word, kinds, "")?;
            }
        }
        if self.once_in(6)? {
            self.directive("Film", FILMS, "")?;
        }
        Ok(())
    }

    fn scene(&mut self) -> Result<()> {
        self.write("LookAt 0 0 -4 0 0 0 0 1 0\n");
        let options = self.options();
        self.write("WorldBegin\n");
        if options.is_ok() && !self.once_in(3)? {
            self.write("LightSource \"infinite\"\n");
        }
        let world = self.world(0);
        self.write("WorldEnd\n");
        options.and(world)
    }
}
