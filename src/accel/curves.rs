//! The curves of one tree. Each segment is a few boxes in the tree ("pieces"), whose leaves refer directly to its 64
//! bytes: a search reads nothing else, except for ribbons and for curves whose transformation does not preserve angles.

use super::PrimitiveAttributes;
use super::aabb::Aabb;
use crate::math::DVec3;
use crate::math::transform::Place;
use crate::shapes::curve::{CurveHit, CurveKind, Curves, Segment};
use crate::shapes::local::{Local, LocalSurface};

/// Bits for a piece's index within its segment, since a segment has up to eight.
const PIECE_BITS: u32 = 3;

/// Data shared by all segments of a curve.
struct Owner {
    kind: CurveKind,
    flip: bool,
    placement: Option<Box<Place>>,
    attributes: PrimitiveAttributes,
}

/// The curves.
#[derive(Default)]
pub(super) struct CurveStore {
    segments: Vec<Segment>,
    normals: Vec<[DVec3; 2]>,
    owners: Vec<Owner>,
}

impl CurveStore {
    /// Bytes of a segment.
    pub(super) const SEGMENT: usize = size_of::<Segment>();

    /// Bytes of a curve besides its segments.
    pub(super) const OWNER: usize = size_of::<Owner>();

    /// Adds a curve whose coordinates are relative to the level's anchor.
    pub(super) fn add(&mut self, curves: &Curves, attributes: PrimitiveAttributes) {
        let (owner, normal) = (self.owners.len() as u32, self.normals.len() as u32);
        self.segments.extend(curves.stored(owner, normal));
        self.normals.extend(curves.stored_normals());
        self.owners.push(Owner {
            kind: curves.kind,
            flip: curves.flip,
            placement: curves.placement.map(Box::new),
            attributes,
        });
    }

    /// The number of piece indices.
    pub(super) fn piece_numbers(&self) -> usize {
        self.segments.len() << PIECE_BITS
    }

    /// The number of segments.
    pub(super) fn segments(&self) -> usize {
        self.segments.len()
    }

    /// All pieces with their boxes.
    pub(super) fn pieces(&self) -> impl Iterator<Item = (usize, Aabb)> {
        let segments = self.segments.iter().enumerate();
        segments.flat_map(move |(i, segment)| {
            let piece = move |k| (i << PIECE_BITS | k, self.piece_bounds(segment, k));
            (0..segment.pieces()).map(piece)
        })
    }

    fn piece_bounds(&self, segment: &Segment, piece: usize) -> Aabb {
        let (mut min, mut max) = segment.bounds(piece);
        if let Some(placement) = &self.owners[segment.owner()].placement {
            let affine = &placement.outer_from_inner;
            let center = affine.transform_point3((min + max) * 0.5);
            // The largest factor by which a length grows, per axis.
            let reach = affine.matrix3.abs() * ((max - min) * 0.5);
            (min, max) = (center - reach, center + reach);
        }
        let bounds = Aabb::around(min, max);
        // A ray may see a curve outside its box by what both lose in single precision.
        let slack = bounds.min.abs().max(bounds.max.abs()) * (2.0 * f32::EPSILON);
        Aabb {
            min: bounds.min - slack,
            max: bounds.max + slack,
        }
    }

    /// The ray in the space in which the segment's widths are measured.
    fn local(&self, segment: &Segment, o: DVec3, d: DVec3) -> (DVec3, DVec3) {
        // Check the segment first: reading its owner is another cache miss.
        if !segment.is_placed() {
            return (o, d);
        }
        let placement = self.owners[segment.owner()].placement.as_deref();
        placement.map_or((o, d), |place| place.inward(o, d))
    }

    /// The nearest intersection of the ray with a piece at 0 < t < `t_max`.
    pub(super) fn intersect(
        &self,
        number: usize,
        o: DVec3,
        d: DVec3,
        t_max: f64,
    ) -> Option<CurveHit> {
        let segment = &self.segments[number >> PIECE_BITS];
        let piece = number & ((1 << PIECE_BITS) - 1);
        let normals = segment.normals().map(|i| &self.normals[i]);
        let (o, d) = self.local(segment, o, d);
        segment.intersect(piece, normals, o, d, t_max)
    }

    /// The surface at the hit that [`CurveStore::intersect`] found, and the curve's attributes.
    pub(super) fn surface(
        &self,
        number: usize,
        o: DVec3,
        d: DVec3,
    ) -> Option<(LocalSurface, &PrimitiveAttributes)> {
        let hit = self.intersect(number, o, d, f64::INFINITY)?;
        let segment = &self.segments[number >> PIECE_BITS];
        let owner = &self.owners[segment.owner()];
        let (o, d) = self.local(segment, o, d);
        let local = segment.surface(&hit, owner.kind, owner.flip, o, d)?;
        let placement = owner.placement.as_deref();
        let surface = placement.map_or(local, |place| local.transformed(place));
        Some((surface, &owner.attributes))
    }

    /// The attributes of all curves.
    pub(super) fn all_attributes(&self) -> impl Iterator<Item = &PrimitiveAttributes> {
        self.owners.iter().map(|owner| &owner.attributes)
    }

    /// The attributes of the curve that primitive `number` is a piece of.
    pub(super) fn attributes(&self, number: usize) -> &PrimitiveAttributes {
        &self.owners[self.segments[number >> PIECE_BITS].owner()].attributes
    }

    /// Memory in bytes.
    pub(super) fn bytes(&self) -> usize {
        let placed = self.owners.iter().filter(|o| o.placement.is_some()).count();
        size_of_val(&self.segments[..])
            + size_of_val(&self.normals[..])
            + size_of_val(&self.owners[..])
            + placed * size_of::<Place>()
    }
}
