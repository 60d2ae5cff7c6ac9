//! Searches: the closest hit, or any hit.

use super::instance::InnerRay;
use super::level::Level;
use super::passage::Passage;
use super::primitive::{OtherKind, PrimitiveId};
use super::stack::{LastFirst, NearestFirst};
use super::tree::{Visitor, Visitors};
use super::{Alpha, Geometry};
use crate::inputs::FloatInput;
use crate::math::ray::Ray;
use crate::math::transform::Place;
use crate::math::{DVec3, Vec3};
use crate::surface::{Footprint, TexturePoint};
use glam::DAffine3;

/// The closest hit: the primitive, and the instances that it is in.
#[derive(Clone, Copy, Debug)]
pub struct ClosestHit {
    pub(super) id: PrimitiveId,
    /// The path to the hit from the level searched, outermost first: an instance or moving object, and within it a
    /// moving shape. Unused entries are [`PrimitiveId::NONE`].
    pub(super) path: [PrimitiveId; 2],
    /// Distance along the outer ray.
    pub(super) t: f32,
}

impl ClosestHit {
    /// Returns `true` if it is of a triangle.
    #[cfg(test)]
    pub(crate) fn is_triangle(&self) -> bool {
        self.id.is_triangle()
    }

    /// How far along the ray it is.
    pub fn t(&self) -> f32 {
        self.t
    }
}

/// What is searched: one level.
#[derive(Clone, Copy)]
pub(super) struct Scope<'a, A> {
    geometry: &'a Geometry,
    level: &'a Level,
    /// Transformation to render space, for all but the top level.
    render_from_level: Option<&'a DAffine3>,
    alpha: &'a A,
}

/// A search in one level. `SHADOW` accepts any hit and, where the ray has no passage, evaluates shadow alpha too.
pub(super) struct Search<'a, A, const SHADOW: bool> {
    scope: &'a Scope<'a, A>,
    time: f32,
    o: Vec3,
    d: Vec3,
    /// In units of this level's ray.
    t_max: f32,
    /// `t` in units of this level's ray.
    pub found: Option<ClosestHit>,
    /// What the ray passes, if surfaces without material do not count as hits.
    passage: Option<&'a mut Passage>,
}

impl<'a, A: Alpha, const SHADOW: bool> Search<'a, A, SHADOW> {
    /// Searches the top level along each of the `rays`, one after the other. Those that have `passages` pass surfaces without material.
    pub(super) fn run(
        geometry: &'a Geometry,
        rays: &[Ray],
        alpha: &'a A,
        (found, passages): (&mut [Option<ClosestHit>], &mut [Passage]),
    ) {
        let scope = Scope {
            geometry,
            level: &geometry.top,
            render_from_level: None,
            alpha,
        };
        Searches::<A, SHADOW>::go(&scope, rays, (found, passages));
    }

    /// The ray of this level in double precision, for non-triangle primitives.
    fn precise(&self) -> (DVec3, DVec3) {
        (self.o.as_dvec3(), self.d.as_dvec3())
    }

    fn accept(&mut self, id: PrimitiveId, t: f32) -> bool {
        self.accept_in(id, [PrimitiveId::NONE; 2], t)
    }

    fn accept_in(&mut self, id: PrimitiveId, path: [PrimitiveId; 2], t: f32) -> bool {
        self.t_max = t;
        self.found = Some(ClosestHit { id, path, t });
        SHADOW
    }

    /// Returns `true` if the surface is not cut out where the ray hits a triangle with an alpha texture.
    #[cold]
    fn is_solid(&self, id: PrimitiveId) -> bool {
        let (mesh, i) = self.scope.level.locate(id.index());
        let triangle = mesh.triangle(i);
        let (o, d) = self.precise();
        let Some(b) = triangle.barycentrics(o, d) else {
            return true;
        };
        let p = triangle.point(b);
        let p = match self.scope.render_from_level {
            Some(affine) => affine.transform_point3(p),
            None => p,
        };
        let point = TexturePoint {
            p: p.as_vec3(),
            uv: triangle.uv_at(b).as_vec2(),
            footprint: Footprint::default(),
            face: self.scope.level.face_ids.of(mesh.first, i),
        };
        let solid = |input: Option<FloatInput>| {
            input.is_none_or(|input| (self.scope.alpha)(&input, &point) != 0.0)
        };
        let is_shadow = SHADOW && self.passage.is_none();
        solid(mesh.attributes.alpha) && (!is_shadow || solid(mesh.attributes.shadow_alpha))
    }

    /// Notes that the ray meets a primitive at `t`, if it passes that. Otherwise returns `false`.
    #[inline(always)]
    fn passes(&mut self, id: PrimitiveId, t: f32) -> bool {
        SHADOW && self.passage.is_some() && self.has_passed(id, t)
    }

    #[inline(never)]
    fn has_passed(&mut self, id: PrimitiveId, t: f32) -> bool {
        let (ray, level) = (self.precise(), self.scope.level);
        let attributes = level.attributes(id);
        if attributes.material.is_some() {
            return false;
        }
        if let (Some(passage), Some(interface)) = (&mut self.passage, attributes.interface) {
            passage.add((level, id, interface), ray, (t, self.t_max));
        }
        true
    }

    /// Accepts a hit at `t` if it is the nearest so far.
    fn accept_nearer(&mut self, id: PrimitiveId, t: Option<f64>) -> bool {
        t.is_some_and(|t| {
            let t = t as f32;
            self.is_nearer(id, t) && !self.passes(id, t) && self.accept(id, t)
        })
    }

    /// Returns `true` if a hit is the nearest so far: of equally near ones of a level the first counts, in whatever order they are found.
    #[inline(always)]
    fn is_nearer(&self, id: PrimitiveId, t: f32) -> bool {
        t < self.t_max || t == self.t_max && self.found.is_some_and(|found| id < found.id)
    }

    fn quadric(&mut self, id: PrimitiveId) -> bool {
        let (o, d) = self.precise();
        let quadric = &self.scope.level.quadrics[id.index()].quadric;
        if SHADOW && quadric.is_beyond(o, d, f64::from(self.t_max)) {
            return false;
        }
        self.accept_nearer(id, quadric.distance(o, d))
    }

    fn curve(&mut self, id: PrimitiveId) -> bool {
        let (o, d) = self.precise();
        let t_max = f64::from(self.t_max);
        let hit = self.scope.level.curves.intersect(id.index(), o, d, t_max);
        self.accept_nearer(id, hit.map(|hit| hit.t))
    }

    fn instance(&mut self, id: PrimitiveId) -> bool {
        let instance = &self.scope.level.instances[id.index()];
        let level = instance.level(&self.scope.geometry.objects);
        self.search_inside(id, &instance.place(self.time), level)
    }

    /// Searches the level at `place`. Objects hold no instances, and moving shapes hold nothing that moves, so this
    /// recurses at most two levels deep.
    fn search_inside(&mut self, id: PrimitiveId, place: &Place, level: &'a Level) -> bool {
        let (o, d) = self.precise();
        let inner = InnerRay::new(place, o, d, level);
        let t_max = inner.inner(f64::from(self.t_max)) as f32;
        if t_max <= 0.0 {
            return false;
        }
        let ray = Ray {
            o: inner.o.as_vec3(),
            d: inner.d.as_vec3(),
            t_max,
            time: self.time,
        };
        let mut found = [None];
        let render_from_level = match self.scope.render_from_level {
            Some(outer) => *outer * place.outer_from_inner,
            None => place.outer_from_inner,
        };
        let scope = Scope {
            level,
            render_from_level: Some(&render_from_level),
            ..*self.scope
        };
        let mut inside = Passage::default();
        let passages = match self.passage {
            Some(_) => std::slice::from_mut(&mut inside),
            None => &mut [],
        };
        Searches::<A, SHADOW>::go(&scope, std::slice::from_ref(&ray), (&mut found, passages));
        let outer = |t: f32| inner.outer(f64::from(t)) as f32;
        if let Some(passage) = &mut self.passage {
            passage.append(&inside, outer, self.t_max);
        }
        let [Some(found)] = found else {
            return false;
        };
        let t = outer(found.t);
        t < self.t_max && self.accept_in(found.id, [id, found.path[0]], t)
    }
}

/// Searches in a scope, and what they find: nothing unless told.
struct Searches<'a, A, const SHADOW: bool> {
    scope: &'a Scope<'a, A>,
    rays: std::slice::Iter<'a, Ray>,
    found: std::slice::IterMut<'a, Option<ClosestHit>>,
    passages: std::slice::IterMut<'a, Passage>,
}

impl<'a, A: Alpha, const SHADOW: bool> Searches<'a, A, SHADOW> {
    fn go(
        scope: &'a Scope<'a, A>,
        rays: &'a [Ray],
        (found, passages): (&'a mut [Option<ClosestHit>], &'a mut [Passage]),
    ) {
        let tree = &scope.level.tree;
        let searches = Searches::<A, SHADOW> {
            scope,
            rays: rays.iter(),
            found: found.iter_mut(),
            passages: passages.iter_mut(),
        };
        if let Some(few) = &scope.level.few {
            few.visit(tree.instructions, rays.len(), searches);
        } else if SHADOW {
            tree.traverse::<LastFirst, _>(searches);
        } else {
            tree.traverse::<NearestFirst, _>(searches);
        }
    }
}

impl<'a, A: Alpha, const SHADOW: bool> Visitors for Searches<'a, A, SHADOW> {
    type Visitor = Search<'a, A, SHADOW>;

    #[inline(always)]
    fn next(&mut self) -> Option<(Vec3, Vec3, Search<'a, A, SHADOW>)> {
        let ray = self.rays.next()?;
        let search = Search {
            scope: self.scope,
            time: ray.time,
            o: ray.o,
            d: ray.d,
            t_max: ray.t_max,
            found: None,
            passage: if SHADOW { self.passages.next() } else { None },
        };
        Some((ray.o, ray.d, search))
    }

    #[inline(always)]
    fn finish(&mut self, search: Search<'a, A, SHADOW>) {
        if let Some(found) = self.found.next() {
            *found = search.found;
        }
    }
}

impl<A: Alpha, const SHADOW: bool> Visitor for Search<'_, A, SHADOW> {
    #[inline(always)]
    fn t_max(&self) -> f32 {
        self.t_max
    }

    #[inline(always)]
    fn triangle(&mut self, id: PrimitiveId, t: f64) -> bool {
        let t = t as f32;
        self.is_nearer(id, t)
            && (!id.is_cut_out() || self.is_solid(id))
            && !self.passes(id, t)
            && self.accept(id, t)
    }

    #[inline(always)]
    fn ball(&mut self, id: PrimitiveId, t: f64) -> bool {
        self.accept_nearer(id, Some(t))
    }

    #[inline(never)]
    fn other(&mut self, id: PrimitiveId) -> bool {
        match id.kind() {
            OtherKind::Quadric => self.quadric(id),
            OtherKind::Instance => self.instance(id),
            OtherKind::Curve => self.curve(id),
        }
    }
}
