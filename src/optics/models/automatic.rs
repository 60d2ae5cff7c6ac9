//! The cheapest model that is good enough.

use super::{LensModel, ModelError, ModelKind, Models, Unavailable};

/// A model, and all that were tried on the way to it.
#[derive(Clone, Debug)]
pub struct Choice {
    /// The cheapest that meets the tolerance; exact where none other does, or where none that
    /// does is cheaper.
    pub model: LensModel,
    /// What was tried, cheapest first, with the cost in ns a ray and the error.
    pub tried: Vec<(ModelKind, f64, Option<ModelError>)>,
}

/// Models that might pay, besides exact. Tables do not: every lane fetches its own coefficients.
pub const CANDIDATES: [ModelKind; 7] = [
    ModelKind::Thick,
    ModelKind::Polynomial(3),
    ModelKind::Polynomial(5),
    ModelKind::Polynomial(7),
    ModelKind::Polynomial(9),
    ModelKind::Polynomial(11),
    ModelKind::Table(1),
];

impl ModelKind {
    /// What tracing a ray costs in bundles of 32 with AVX-512, ns, through a lens of `surfaces` surfaces: fitted to
    /// `docs/lens-models.md` (AMD EPYC), within 2 ns. Polynomials of a high degree need more numbers at once than there are
    /// registers, and cost more than tracing two dozen surfaces.
    pub fn cost(self, surfaces: usize) -> f64 {
        match self {
            ModelKind::Thin => 2.0,
            ModelKind::Thick => 6.0,
            ModelKind::Polynomial(degree) => 6.0 + 0.49 * (degree * degree) as f64,
            ModelKind::Table(degree) => 15.0 + 2.15 * (degree * degree) as f64,
            ModelKind::Exact => 1.5 + 1.03 * surfaces as f64,
        }
    }
}

impl Choice {
    /// What was taken and why, in a sentence.
    pub fn reason(&self) -> String {
        let Some((kind, cost, error)) = self.tried.last() else {
            return "exact: nothing else was tried".into();
        };
        match (kind, error) {
            (ModelKind::Exact, _) => {
                let best = self.tried.iter().rev().nth(1);
                match best.and_then(|(kind, _, error)| Some((kind, (*error)?))) {
                    Some((kind, e)) => format!(
                        "exact, {cost:.0} ns a ray in lanes: the best cheaper model, {kind}, is off by {:.2} pixels",
                        e.p99
                    ),
                    None => format!("exact, {cost:.0} ns a ray in lanes: no model is cheaper"),
                }
            }
            (kind, Some(e)) => format!(
                "{kind}, {cost:.0} ns a ray in lanes: 99 of 100 rays within {:.2} pixels",
                e.p99
            ),
            (kind, None) => format!("{kind}, {cost:.0} ns a ray in lanes"),
        }
    }
}

impl Models<'_> {
    /// The cheapest model whose 99th percentile error is at most `tolerance` pixels of `pixel` mm.
    pub fn choose(&self, tolerance: f64, pixel: f64) -> Result<Choice, Unavailable> {
        let surfaces = self.lens.surfaces().len();
        let exact = ModelKind::Exact.cost(surfaces);
        let mut candidates: Vec<(ModelKind, f64)> = CANDIDATES
            .into_iter()
            .map(|kind| (kind, kind.cost(surfaces)))
            .filter(|(_, cost)| *cost < exact)
            .collect();
        candidates.sort_by(|a, b| a.1.total_cmp(&b.1));
        let mut tried = Vec::new();
        for (kind, cost) in candidates {
            // A lens without this model is served by another.
            let Ok(model) = self.model(kind) else {
                continue;
            };
            let error = self.error(&model, pixel);
            tried.push((kind, cost, error));
            if error.is_some_and(|e| e.p99 <= tolerance) {
                return Ok(Choice { model, tried });
            }
        }
        let model = self.model(ModelKind::Exact)?;
        tried.push((ModelKind::Exact, exact, self.error(&model, pixel)));
        Ok(Choice { model, tried })
    }
}
