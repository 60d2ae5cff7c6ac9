//! PLY meshes: ASCII, binary of both byte orders, and any of them compressed with gzip.
//!
//! Vertices: x y z of any scalar type; nx ny nz; texture coordinates by the first complete pair of u v, s t, texture_u
//! texture_v, texture_s texture_t. Faces: lists `vertex_indices` or `vertex_index` of any length, and the scalar
//! `face_indices` of each, for Ptex. Other elements and properties are skipped (Turk, "The PLY Polygon File Format",
//! 1994; docs/scene-language.md §3.7).

use super::mesh::{self, MeshData, MeshExtent, face_id, triangulate};
use crate::budget::Budget;
use crate::files::{self, FileError};
use crate::math::{DVec3, Vec2, Vec3};
use arrayvec::ArrayVec;
use flate2::read::MultiGzDecoder;
use serde::de::{IgnoredAny, SeqAccess, Visitor};
use serde::{Deserialize, Deserializer};
use serde_ply::{ElementDef, PlyReader, PropertyType, ScalarType};
use std::borrow::Cow;
use std::fmt;
use std::io::{BufRead, Read};
use std::marker::PhantomData;
use std::path::Path;

/// Loads the mesh at `path`, unless that takes more memory than is left of `budget`.
pub fn load(path: &Path, budget: &Budget) -> Result<MeshData, FileError> {
    mesh::load(path, budget, parse_within)
}

/// Bytes in which a header is expected.
const HEADER: u64 = 1 << 16;

/// How large the mesh at `path` is: by its header where that tells, otherwise by loading it.
///
/// # Errors
/// As [`load`].
pub fn extent(path: &Path) -> Result<MeshExtent, FileError> {
    let bytes = files::read_start(path, HEADER)?;
    let file = path.metadata().map_or(0, |found| found.len());
    if let Some(extent) = extent_of_header(&bytes, file) {
        return Ok(MeshExtent { file, ..extent });
    }
    let mesh = load(path, &Budget::new(None))?;
    Ok(MeshExtent {
        file,
        ..MeshExtent::of(&mesh)
    })
}

/// By the header of a binary file of vertices and faces: what vertices do not take are faces, and every corner beyond two
/// makes a triangle.
fn extent_of_header(bytes: &[u8], file: u64) -> Option<MeshExtent> {
    let length = header_length(bytes)?;
    if !bytes.starts_with(b"ply")
        || std::str::from_utf8(&bytes[..length])
            .ok()?
            .contains("format ascii")
    {
        return None;
    }
    let reader = PlyReader::from_reader(&bytes[..length]).ok()?;
    let [vertices, faces] = reader.header().elem_defs.as_slice() else {
        return None;
    };
    let scalar = |kind: &PropertyType| match *kind {
        PropertyType::Scalar(kind) => Some(bytes_of(kind)),
        PropertyType::List { .. } => None,
    };
    let sizes = vertices.properties.iter().map(|p| scalar(&p.property_type));
    let vertex: u64 = sizes.sum::<Option<u64>>()?;
    let (mut fixed, mut corner) = (0, None);
    for property in &faces.properties {
        match property.property_type {
            PropertyType::Scalar(kind) => fixed += bytes_of(kind),
            PropertyType::List {
                count_type,
                data_type,
            } if corner.is_none() => {
                fixed += bytes_of(count_type);
                corner = Some(bytes_of(data_type));
            }
            PropertyType::List { .. } => return None,
        }
    }
    let is_mesh = vertices.name == "vertex" && faces.name == "face";
    let rest = file.checked_sub(length as u64 + vertices.count as u64 * vertex)?;
    let corners = rest.checked_sub(faces.count as u64 * fixed)? / corner?;
    let has = |names: [&str; 2]| names.iter().all(|name| vertices.has_property(name));
    let triangles = corners.checked_sub(2 * faces.count as u64)?;
    is_mesh.then_some(MeshExtent {
        triangles,
        vertices: vertices.count as u64,
        normals: vertices.has_property("nx"),
        uv: [
            ["u", "v"],
            ["s", "t"],
            ["texture_u", "texture_v"],
            ["texture_s", "texture_t"],
        ]
        .into_iter()
        .any(has),
        faces: if is_numbered(faces) { triangles } else { 0 },
        file,
    })
}

fn bytes_of(kind: ScalarType) -> u64 {
    match kind {
        ScalarType::I8 | ScalarType::U8 => 1,
        ScalarType::I16 | ScalarType::U16 => 2,
        ScalarType::I32 | ScalarType::U32 | ScalarType::F32 => 4,
        ScalarType::F64 => 8,
    }
}

/// Reads a PLY file from memory; the error is a sentence without the file's name.
#[cfg(any(test, feature = "internals"))]
pub fn parse(bytes: &[u8]) -> Result<MeshData, String> {
    parse_within(bytes, &Budget::unlimited())
}

/// Vertices and faces take at most this many times the bytes of the file they are read from.
const GROWTH: u64 = 2;

fn parse_within(bytes: &[u8], budget: &Budget) -> Result<MeshData, String> {
    let is_zipped = bytes.starts_with(&[0x1f, 0x8b]);
    let (bytes, what) = if is_zipped {
        let plain = unzip(bytes, budget)?;
        (Cow::Owned(plain), "the mesh, when decompressed, at least")
    } else {
        (Cow::Borrowed(bytes), "the mesh")
    };
    let needed = (bytes.len() as u64).saturating_mul(1 + GROWTH);
    let _held = budget.hold(needed).map_err(|e| format!("{what} {e}"))?;
    parse_plain(&bytes)
}

/// The contents of a gzip file, up to one byte more than there is memory for: the file does not record its uncompressed
/// size, and one byte may expand to a thousand.
fn unzip(bytes: &[u8], budget: &Budget) -> Result<Vec<u8>, String> {
    let most = budget.left() / (1 + GROWTH);
    let mut plain = Vec::new();
    let mut decoder = MultiGzDecoder::new(bytes).take(most.saturating_add(1));
    match decoder.read_to_end(&mut plain) {
        Ok(_) => Ok(plain),
        Err(e) => Err(format!("damaged gzip data: {e}")),
    }
}

fn parse_plain(bytes: &[u8]) -> Result<MeshData, String> {
    if !bytes.starts_with(b"ply") {
        return Err("not a PLY file: it does not start with \"ply\"".into());
    }
    let (header, body) =
        bytes.split_at(header_length(bytes).ok_or("the header has no end_header line")?);
    // Comments may be in any encoding, but the reader requires UTF-8; the last number of an ASCII file may lack the
    // white space that the reader needs after it. Other files are read in place: a single slice is several times as
    // fast to read as a chain.
    match std::str::from_utf8(header) {
        Ok(header) if header.contains('\n') && !header.contains("format ascii") => read(bytes),
        _ => {
            let header = String::from_utf8_lossy(header);
            let header = if header.contains('\n') {
                header
            } else {
                header.replace('\r', "\n").into()
            };
            let body = [header.as_bytes(), body, b"\n"].concat();
            read(&body)
        }
    }
}

fn read(bytes: &[u8]) -> Result<MeshData, String> {
    let mut rest = bytes;
    elements(&mut rest).map_err(|error| {
        let read = &bytes[..bytes.len() - rest.len()];
        let header = String::from_utf8_lossy(&bytes[..bytes.len().min(HEADER as usize)]);
        match error.starts_with("element ") && header.contains("format ascii") {
            true => {
                let line = 1 + read.iter().filter(|&&byte| byte == b'\n').count();
                format!("{error}, near line {line}")
            }
            false => error,
        }
    })
}

/// Takes all elements from the front of what is left of a file.
fn elements(rest: &mut &[u8]) -> Result<MeshData, String> {
    let mut reader = PlyReader::from_reader(rest).map_err(|e| format!("bad header: {}", e.0))?;
    let mut vertices = Vertices::default();
    let mut faces = Faces::default();
    let mut warnings = Vec::new();
    while let Some(element) = reader.current_element().cloned() {
        check_element(&element)?;
        let located = |e: serde_ply::DeserializeError| format!("element {}: {}", element.name, e.0);
        match element.name.as_str() {
            "vertex" => vertices = gathered::<_, VertexRow>(&mut reader).map_err(located)?,
            "face" if is_numbered(&element) => {
                faces = gathered::<_, NumberedFaceRow>(&mut reader).map_err(located)?;
            }
            "face" => faces = gathered::<_, FaceRow>(&mut reader).map_err(located)?,
            other => {
                if other == "tristrips" {
                    warnings.push("triangle strips (element tristrips) are not read".into());
                }
                reader.next_element::<Vec<SkippedRow>>().map_err(located)?;
            }
        }
    }
    assemble(vertices, faces, warnings)
}

/// The rows of the next element.
fn gathered<T: Gather<Row>, Row: for<'a> Deserialize<'a>>(
    reader: &mut PlyReader<impl BufRead>,
) -> Result<T, serde_ply::DeserializeError> {
    Ok(reader.next_element::<Gathered<T, Row>>()?.0)
}

/// What the items of a sequence are gathered into, one by one.
trait Gather<Item>: Default {
    /// The items, for messages.
    const WHAT: &'static str;

    fn add(&mut self, item: Item);
}

/// A sequence of `Item`s, gathered as it is read.
struct Gathered<T, Item>(T, PhantomData<Item>);

impl<'de, T: Gather<Item>, Item: Deserialize<'de>> Deserialize<'de> for Gathered<T, Item> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_seq(Gathered(T::default(), PhantomData))
    }
}

impl<'de, T: Gather<Item>, Item: Deserialize<'de>> Visitor<'de> for Gathered<T, Item> {
    type Value = Self;

    fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str(T::WHAT)
    }

    fn visit_seq<A: SeqAccess<'de>>(mut self, mut items: A) -> Result<Self, A::Error> {
        while let Some(item) = items.next_element()? {
            self.0.add(item);
        }
        Ok(self)
    }
}

/// Length of the header with its final line break: LF, CR LF, or the CR of old Macintosh files.
fn header_length(bytes: &[u8]) -> Option<usize> {
    let mut start = 0;
    for line in bytes.split_inclusive(|&b| b == b'\n') {
        start += line.len();
        if line.trim_ascii() == b"end_header" && line.ends_with(b"\n") {
            return Some(start);
        }
    }
    const LAST: &[u8] = b"\rend_header\r";
    let found = bytes
        .windows(LAST.len())
        .position(|window| window == LAST)?;
    Some(found + LAST.len())
}

/// Rejects nonsensical elements, and those that would make reading endless.
fn check_element(element: &ElementDef) -> Result<(), String> {
    // Such rows take no bytes, so a corrupt count would never reach the end of the file.
    if element.properties.is_empty() && element.count > 0 {
        return Err(format!("element {} has no properties", element.name));
    }
    if element.name == "vertex" {
        for name in ["x", "y", "z"] {
            if !element.has_property(name) {
                return Err(format!("vertices have no property {name}"));
            }
        }
    }
    if element.name == "face"
        && !element.has_property("vertex_indices")
        && !element.has_property("vertex_index")
    {
        return Err("faces have no list vertex_indices".into());
    }
    Ok(())
}

/// Returns `true` if faces have indices.
fn is_numbered(faces: &ElementDef) -> bool {
    let numbers = faces.get_property("face_indices");
    numbers.is_some_and(|p| matches!(p.property_type, PropertyType::Scalar(_)))
}

fn assemble(
    vertices: Vertices,
    faces: Faces,
    mut warnings: Vec<String>,
) -> Result<MeshData, String> {
    let count = vertices.positions.len();
    if count > u32::MAX as usize {
        return Err(format!("{count} vertices are too many"));
    }
    if let Some(bad) = faces.bad_corner(count) {
        return Err(format!(
            "a face refers to vertex {bad}, but there are {count} vertices"
        ));
    }
    let short = faces.arities.iter().filter(|&&n| n < 3).count();
    let face_ids = faces.ids_of_triangles();
    if !face_ids.is_empty() && faces.arities.iter().any(|&n| n > 3) {
        warnings.push(
            "face_indices number faces of more than three corners, where pbrt-v3 stops: \
             all triangles of a face have its number"
                .into(),
        );
    }
    let indices = faces.triangles(&vertices.positions);
    if short > 0 {
        warnings.push(format!(
            "{short} faces with fewer than three corners are left out"
        ));
    }
    if indices.is_empty() {
        warnings.push("the file has no triangles".into());
    }
    Ok(MeshData {
        indices,
        positions: vertices.positions,
        normals: vertices.normals,
        tangents: Vec::new(),
        uv: vertices.uv,
        face_ids,
        warnings,
    })
}

/// One row of element vertex. Absent columns need a default: binary rows of scalars arrive as sequences that end at the
/// first absent one. The presence of x, y and z has been checked.
#[derive(Default, Deserialize)]
#[serde(default)]
struct VertexRow {
    x: f64,
    y: f64,
    z: f64,
    nx: Option<f32>,
    ny: Option<f32>,
    nz: Option<f32>,
    u: Option<f32>,
    v: Option<f32>,
    s: Option<f32>,
    t: Option<f32>,
    texture_u: Option<f32>,
    texture_v: Option<f32>,
    texture_s: Option<f32>,
    texture_t: Option<f32>,
}

impl VertexRow {
    fn normal(&self) -> Option<Vec3> {
        Some(Vec3::new(self.nx?, self.ny?, self.nz?))
    }

    fn uv(&self) -> Option<Vec2> {
        let u_v = self.u.zip(self.v);
        let s_t = self.s.zip(self.t);
        let texture_u_v = self.texture_u.zip(self.texture_v);
        let texture_s_t = self.texture_s.zip(self.texture_t);
        let (u, v) = u_v.or(s_t).or(texture_u_v).or(texture_s_t)?;
        Some(Vec2::new(u, v))
    }
}

/// Element vertex, column by column.
#[derive(Default)]
struct Vertices {
    positions: Vec<DVec3>,
    normals: Vec<Vec3>,
    uv: Vec<Vec2>,
}

impl Gather<VertexRow> for Vertices {
    const WHAT: &'static str = "vertices";

    #[inline]
    fn add(&mut self, row: VertexRow) {
        self.positions.push(DVec3::new(row.x, row.y, row.z));
        self.normals.extend(row.normal());
        self.uv.extend(row.uv());
    }
}

/// One row of an unused element; takes no memory.
struct SkippedRow;

impl<'de> Deserialize<'de> for SkippedRow {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<SkippedRow, D::Error> {
        // The reader provides rows as maps only.
        deserializer.deserialize_map(IgnoredAny).map(|_| SkippedRow)
    }
}

/// One row of element face.
#[derive(Deserialize)]
struct FaceRow {
    #[serde(alias = "vertex_index")]
    vertex_indices: Gathered<Corners, i64>,
}

/// The same with the index of the face, which may be of any scalar type.
#[derive(Deserialize)]
struct NumberedFaceRow {
    #[serde(alias = "vertex_index")]
    vertex_indices: Gathered<Corners, i64>,
    face_indices: f64,
}

/// A list of vertex indices, on the stack if it is short.
#[derive(Default)]
struct Corners {
    first: ArrayVec<i64, 4>,
    rest: Vec<i64>,
}

impl Gather<i64> for Corners {
    const WHAT: &'static str = "vertex numbers";

    #[inline]
    fn add(&mut self, index: i64) {
        if let Err(full) = self.first.try_push(index) {
            self.rest.push(full.element());
        }
    }
}

/// Element face.
#[derive(Default)]
struct Faces {
    /// The faces before the first non-triangle.
    triangles: Vec<[u32; 3]>,
    /// The numbers of corners of the remaining faces, and their corners one after another.
    arities: Vec<u32>,
    corners: Vec<u32>,
    /// Indices of the faces, if any.
    ids: Vec<u32>,
    /// The first corner that is not a 32-bit number.
    beyond: Option<i64>,
}

impl Faces {
    fn push(&mut self, face: &Corners) {
        let beyond = &mut self.beyond;
        let mut number = |&i: &i64| {
            u32::try_from(i).unwrap_or_else(|_| {
                beyond.get_or_insert(i);
                u32::MAX
            })
        };
        if let ([a, b, c], true) = (&face.first[..], self.arities.is_empty()) {
            self.triangles.push([number(a), number(b), number(c)]);
            return;
        }
        // A list's count has 32 bits in the file.
        self.arities
            .push((face.first.len() + face.rest.len()) as u32);
        let all = face.first.iter().chain(&face.rest);
        self.corners.extend(all.map(number));
    }

    /// A corner that is not one of `count` vertices.
    fn bad_corner(&self, count: usize) -> Option<i64> {
        let bad = |i: &&u32| **i as usize >= count;
        let in_triangles = self.triangles.as_flattened().iter().find(bad);
        self.beyond.or(in_triangles
            .or(self.corners.iter().find(bad))
            .map(|&i| i64::from(i)))
    }

    /// The face index of each triangle, if faces have indices. A polygon becomes two triangles fewer than it has
    /// corners ([`triangulate`]).
    fn ids_of_triangles(&self) -> Vec<u32> {
        let alone = std::iter::repeat_n(1, self.triangles.len());
        let counts = alone.chain(self.arities.iter().map(|&n| n.saturating_sub(2) as usize));
        let ids = self.ids.iter().zip(counts);
        ids.flat_map(|(&id, count)| std::iter::repeat_n(id, count))
            .collect()
    }

    /// All faces, triangulated.
    fn triangles(self, positions: &[DVec3]) -> Vec<[u32; 3]> {
        let mut triangles = self.triangles;
        triangles.extend(triangulate(&self.arities, &self.corners, positions));
        triangles
    }
}

impl Gather<FaceRow> for Faces {
    const WHAT: &'static str = "faces";

    #[inline]
    fn add(&mut self, row: FaceRow) {
        self.push(&row.vertex_indices.0);
    }
}

impl Gather<NumberedFaceRow> for Faces {
    const WHAT: &'static str = "faces";

    #[inline]
    fn add(&mut self, row: NumberedFaceRow) {
        self.push(&row.vertex_indices.0);
        self.ids.push(face_id(row.face_indices));
    }
}

#[cfg(test)]
mod tests;
