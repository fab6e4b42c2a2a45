//! Subject of a check: a structure, an occluder, or the negative control.

use accel_core::occluders::{self, OccluderRegistry};
use accel_core::params::config::Settings;
use accel_core::primitives::{MoellerTrumbore, PrimsRef};
use accel_core::query::tracer::{Bound, PreviousFrame, Tracer};
use accel_core::registry::Buildable;
use accel_core::structure::{BuildError, Structure};
use accel_core::structures::brute_force::BruteForce;
use accel_core::structures::{Entry, find};
use measurement::plan::error::PlanError;
use measurement::plan::rows::{Row, select};
use renderer::Geometry;

pub const CONTROL: &str = "moeller-trumbore";

#[derive(Debug, Clone, PartialEq)]
pub enum Subject<'r> {
    /// A structure with settings, over the primitive tests that are the default.
    Structure(Row<'r>),
    Occluder(Row<'static, OccluderRegistry>),
    /// Brute force over plain Moeller-Trumbore tests, which leak at edges: where it misses
    /// nothing, the rays have no power.
    Control,
}

impl<'r> Subject<'r> {
    /// The structures that `-s` asks for; all of them and the control where it asks for nothing in
    /// particular. With `also_tested` structures that are named without settings have
    /// their further settings asked too.
    pub fn all(
        registry: &'r [Entry],
        structures: &[String],
        also_tested: bool,
    ) -> Result<Vec<Self>, PlanError> {
        let (named, rest): (Vec<String>, Vec<String>) =
            structures.iter().cloned().partition(|name| is_occluder(name));
        let mut subjects = Vec::new();
        if structures.is_empty() || !rest.is_empty() {
            subjects.extend(select(registry, &rest, &[])?.into_iter().map(Self::Structure));
        }
        let is_named = |entry: &&Entry| {
            structures.is_empty() || structures.iter().any(|n| n == "all" || n == entry.info.name)
        };
        let is_asked = |name: &str| structures.is_empty() || named.iter().any(|n| n == name);
        for entry in occluders::REGISTRY.iter().filter(|entry| is_asked(entry.info.name)) {
            subjects.push(Self::Occluder(Row::defaults(entry)?));
        }
        for entry in registry.iter().filter(is_named).filter(|_| also_tested) {
            for settings in entry.info.also_tested {
                let row = Row::parse(registry, &format!("{} {settings}", entry.info.name))?;
                if !subjects.contains(&Self::Structure(row.clone())) {
                    subjects.push(Self::Structure(row));
                }
            }
        }
        if structures.is_empty() {
            subjects.push(Self::Control);
        }
        Ok(subjects)
    }

    /// Selects the `subjects` of a case; `rows`: its own, as labels.
    pub fn select_for_case(
        rows: &[&str],
        subjects: &[Subject<'r>],
        registry: &'r [Entry],
    ) -> Result<Vec<Self>, PlanError> {
        if rows.is_empty() {
            let answers = |s: &&Self| !matches!(s, Self::Occluder(_));
            return Ok(subjects.iter().filter(answers).cloned().collect());
        }
        let is_asked = |name: &str| {
            subjects.iter().any(|s| match s {
                Self::Structure(row) => row.structure() == name,
                Self::Occluder(row) => row.structure() == name,
                _ => false,
            })
        };
        let name = |label: &&&str| label.split(' ').next().is_some_and(is_asked);
        rows.iter().filter(name).map(|label| Self::parse(registry, label)).collect()
    }

    pub fn parse(registry: &'r [Entry], label: &str) -> Result<Self, PlanError> {
        if label == CONTROL {
            return Ok(Self::Control);
        }
        if label.split([':', ' ']).next().is_some_and(is_occluder) {
            return Row::parse(occluders::REGISTRY, label).map(Self::Occluder);
        }
        Row::parse(registry, label).map(Self::Structure)
    }

    pub fn label(&self) -> String {
        match self {
            Self::Structure(row) => row.label(),
            Self::Occluder(row) => row.label(),
            Self::Control => CONTROL.to_owned(),
        }
    }

    /// Why its mismatches are no failure, if so.
    pub fn known_defect(&self) -> Option<&'static str> {
        match self {
            Self::Structure(row) => row.known_defect(),
            Self::Control => Some("negative control: leaks at edges"),
            Self::Occluder(_) => None,
        }
    }

    /// Brute force with its defaults, which is the reference: it need not be asked twice.
    pub fn is_reference(&self) -> bool {
        match self {
            Self::Structure(row) => find("brute-force").is_some_and(|e| std::ptr::eq(e, row.entry)),
            _ => false,
        }
    }

    /// Builds over `model` and hands the tracer to `ask`; `None` where it has no such primitives.
    pub fn over<S: Buildable, R>(
        &self,
        model: &Geometry<S>,
        ask: impl FnOnce(&dyn Tracer<S>) -> R,
    ) -> Result<Option<R>, BuildError> {
        match self {
            Self::Structure(row) => {
                let tracer = row.entry.build(model.prims(), &row.params)?;
                Ok(Some(ask(&*tracer)))
            }
            Self::Control => {
                let Geometry::Triangles(set) = model else { return Ok(None) };
                let settings = Settings::<()>::of(&brute_force_entry()?.defaults());
                let leaky = set.tested_by::<MoellerTrumbore>();
                let tracer = BruteForce::<S>::build(leaky, &settings)?;
                Ok(Some(ask(&Bound::<_, _, _, false>::new(leaky, tracer))))
            }
            Self::Occluder(_) => Ok(None),
        }
    }

    /// Builds over `before`, takes what was built to `model` as the settings say, and hands it to
    /// `ask`.
    pub fn taken_over<S: Buildable, R>(
        &self,
        before: &Geometry<S>,
        model: &Geometry<S>,
        ask: impl FnOnce(&dyn Tracer<S>) -> R,
    ) -> Result<Option<R>, BuildError> {
        let Self::Structure(row) = self else { return Ok(None) };
        let kept = row.entry.build(before.prims(), &row.params)?.released();
        let moved = model.moved_since(before);
        let (Some(kept), Some(moved)) = (kept, moved) else { return self.over(model, ask) };
        let before = PreviousFrame { kept, moved: &moved };
        Ok(Some(ask(&*row.entry.update(model.prims(), &row.params, before)?)))
    }
}

fn is_occluder(name: &str) -> bool {
    occluders::find(name).is_some()
}

/// Hands brute force over these primitives to `ask`.
pub fn with_brute_force<S: Buildable, R>(
    prims: PrimsRef<'_, S>,
    ask: impl FnOnce(&dyn Tracer<S>) -> R,
) -> Result<R, BuildError> {
    let entry = brute_force_entry()?;
    Ok(ask(&*entry.build(prims, &entry.defaults())?))
}

pub(super) fn brute_force_entry() -> Result<&'static Entry, BuildError> {
    find("brute-force")
        .ok_or(BuildError::NoPrimitives { structure: "brute-force (not in the registry)" })
}
