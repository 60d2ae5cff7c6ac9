//! Names for what a scene is made of, by which a person finds it: in the scene's own words where it has any.

use super::description::{Frame, ShapeEntity};
use crate::handles::MaterialId;
use crate::syntax::{SourceMap, Span};
use std::collections::{HashMap, HashSet};

/// Where a material's name comes from.
#[derive(Clone, Debug, PartialEq)]
pub enum MaterialName {
    /// `MakeNamedMaterial "name"`.
    Given(String),
    /// `Material "type"`.
    Made(String, Span),
    /// Another one, of which a shape has changed a parameter.
    Changed(MaterialId),
    /// A type, where the scene has no directive.
    Type(&'static str),
}

/// The names of a frame's materials, shapes and instances, by their numbers.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Names {
    /// That of a named material; else its type and place, as `matte@12` (line 12) or `matte@geometry.pbrt:12`.
    pub materials: Vec<String>,
    /// Of shapes that are in no object: the file of a mesh without folders and extension, or the type and place. A name that was there
    /// before is followed by its number, as in `leaf#2`.
    pub shapes: Vec<String>,
    /// The object's name and a number, as in `tree#1`.
    pub instances: Vec<String>,
}

impl Names {
    /// Those of `frame`, which was read from `sources`.
    pub fn of(frame: &Frame, sources: &SourceMap) -> Names {
        let mut materials: Vec<String> = Vec::with_capacity(frame.material_names.len());
        for name in &frame.material_names {
            materials.push(match name {
                MaterialName::Given(name) => name.clone(),
                MaterialName::Made(kind, span) => format!("{kind}{}", place(*span, sources)),
                MaterialName::Changed(id) => materials.get(id.index()).cloned().unwrap_or_default(),
                MaterialName::Type(kind) => (*kind).to_string(),
            });
        }
        let mut shapes = Counted::default();
        let mut instances = Counted::default();
        let object = |id: usize| frame.objects.get(id).map_or("", |object| &object.name);
        Names {
            materials,
            shapes: { frame.shapes.iter() }
                .map(|entity| {
                    let name = shape(entity, sources);
                    match shapes.count(&name) {
                        1 => name,
                        number => format!("{name}#{number}"),
                    }
                })
                .collect(),
            instances: { frame.instances.iter() }
                .map(|instance| {
                    let name = object(instance.object.index());
                    format!("{name}#{}", instances.count(name))
                })
                .collect(),
        }
    }
}

/// What a name means: numbers of materials, of shapes that are in no object, and of instances.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct FocusTarget {
    /// Of these materials.
    pub materials: HashSet<MaterialId>,
    /// Or one of these shapes.
    pub shapes: HashSet<u32>,
    /// Or instances.
    pub instances: HashSet<u32>,
}

/// Names that a message tells.
const TOLD: usize = 8;

impl Names {
    /// All that is called `name`, or so and a number (`tree` is every `tree#1`, `tree#2`…); `None` if nothing is.
    pub fn target(&self, name: &str) -> Option<FocusTarget> {
        let is_called = |known: &String| match known.strip_prefix(name) {
            Some("") => true,
            Some(rest) => rest
                .strip_prefix('#')
                .is_some_and(|n| n.parse::<u64>().is_ok()),
            None => false,
        };
        let numbers = |names: &[String]| -> HashSet<u32> {
            let called = names.iter().zip(0..).filter(|(known, _)| is_called(known));
            called.map(|(_, number)| number).collect()
        };
        let target = FocusTarget {
            materials: numbers(&self.materials)
                .into_iter()
                .map(MaterialId)
                .collect(),
            shapes: numbers(&self.shapes),
            instances: numbers(&self.instances),
        };
        (target != FocusTarget::default()).then_some(target)
    }

    /// Each name there is: instances, shapes and materials.
    pub fn all(&self) -> impl Iterator<Item = &str> {
        let names = { self.instances.iter() }
            .chain(&self.shapes)
            .chain(&self.materials);
        names.map(String::as_str)
    }

    /// Some of them, for a message.
    pub fn some(&self) -> String {
        let mut told: Vec<&str> = Vec::new();
        for name in self.all() {
            if told.len() == TOLD {
                return format!("; there are {}, …", told.join(", "));
            }
            if !told.contains(&name) {
                told.push(name);
            }
        }
        match told.is_empty() {
            true => String::new(),
            false => format!("; there are {}", told.join(", ")),
        }
    }
}

/// How often each name has come.
#[derive(Default)]
struct Counted(HashMap<String, u64>);

impl Counted {
    /// Counts `name` once more.
    fn count(&mut self, name: &str) -> u64 {
        let count = self.0.entry(name.to_string()).or_default();
        *count += 1;
        *count
    }
}

fn shape(entity: &ShapeEntity, sources: &SourceMap) -> String {
    let file = entity.spec.kind.file().and_then(|file| file.file_stem());
    match file {
        Some(stem) => stem.to_string_lossy().into_owned(),
        None => format!("{}{}", entity.spec.kind.name(), place(entity.span, sources)),
    }
}

/// As in `@12`, line 12 of the scene's own file, or `@geometry.pbrt:12`.
fn place(span: Span, sources: &SourceMap) -> String {
    let line = sources.locate(span).map_or(0, |at| at.line);
    if sources.included_at(span.file).is_none() {
        return format!("@{line}");
    }
    let path = sources.path(span.file);
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    format!("@{name}:{line}")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{ReadSettings, read_scene};

    #[test]
    fn names_are_those_of_the_scene() {
        let sources = SourceMap::new();
        let text = r#"WorldBegin LightSource "point"
            MakeNamedMaterial "gold" "string type" "metal"
            Shape "sphere"
            NamedMaterial "gold" Shape "sphere" Shape "disk" Shape "disk"
            Shape "sphere" "float roughness" 0.5
            Material "plastic" Shape "cone"
            ObjectBegin "tree" Shape "sphere" Shape "disk" ObjectEnd
            ObjectInstance "tree" ObjectInstance "tree" WorldEnd"#;
        let main = sources.add_text("test.pbrt", text);
        let (mut scene, said) = read_scene(&sources, main, &ReadSettings::default());
        assert!(!said.has_errors());
        let frame = scene.frames.pop().expect("a frame");
        let names = Names::of(&frame, &sources);
        let of_shape = |i: usize| {
            let material = frame.shapes[i].material.expect("a material");
            (&names.shapes[i][..], &names.materials[material.index()][..])
        };
        let shapes: Vec<_> = (0..frame.shapes.len()).map(of_shape).collect();
        assert_eq!(
            shapes,
            [
                ("sphere@3", "matte"),
                ("sphere@4", "gold"),
                ("disk@4", "gold"),
                ("disk@4#2", "gold"),
                ("sphere@5", "gold"),
                ("cone@6", "plastic@6"),
            ]
        );
        assert_eq!(names.instances, ["tree#1", "tree#2"]);
    }
}
