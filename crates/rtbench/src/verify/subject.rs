//! What is put to the test: a structure, or the negative control.

use accel_core::primitives::{MoellerTrumbore, TriangleSet};
use accel_core::structures::{BuildError, Buildable, Entry, PrimsRef, find};
use accel_core::tracer::Tracer;

use super::model::Model;
use crate::plan::PlanError;
use crate::rows::{Row, select};

/// The negative control's name.
pub const CONTROL: &str = "moeller-trumbore";

/// Who answers.
#[derive(Debug)]
pub enum Subject<'r> {
    /// A structure with settings, over the primitive tests that are the default.
    Structure(Row<'r>),
    /// Brute force over plain Moeller-Trumbore tests, which leak at edges: where it misses
    /// nothing, the rays have no power.
    Control,
}

impl<'r> Subject<'r> {
    /// The structures that `-s` asks for, and the control where it asks for everything.
    ///
    /// # Errors
    /// [`PlanError`] naming what is valid.
    pub fn all(registry: &'r [Entry], structures: &[String]) -> Result<Vec<Self>, PlanError> {
        let rows = select(registry, structures, &[])?;
        let mut subjects: Vec<Self> = rows.into_iter().map(Self::Structure).collect();
        if structures.is_empty() {
            subjects.push(Self::Control);
        }
        Ok(subjects)
    }

    /// The one of that label.
    ///
    /// # Errors
    /// [`PlanError`] naming what is valid.
    pub fn parse(registry: &'r [Entry], label: &str) -> Result<Self, PlanError> {
        if label == CONTROL {
            return Ok(Self::Control);
        }
        Row::parse(registry, label).map(Self::Structure)
    }

    /// Name and settings.
    pub fn label(&self) -> String {
        match self {
            Self::Structure(row) => row.label(),
            Self::Control => CONTROL.to_owned(),
        }
    }

    /// Why its mismatches are no failure, if so.
    pub fn known_defect(&self) -> Option<&'static str> {
        match self {
            Self::Structure(row) => row.known_defect(),
            Self::Control => Some("negative control: leaks at edges"),
        }
    }

    /// Builds over `model` and hands the tracer to `ask`; `None` where it has no such primitives.
    ///
    /// # Errors
    /// [`BuildError`] when it refuses the scene.
    pub fn over<S: Buildable, R>(
        &self,
        model: &Model<S>,
        ask: impl FnOnce(&dyn Tracer<S>) -> R,
    ) -> Result<Option<R>, BuildError> {
        match self {
            Self::Structure(row) => {
                let tracer = row.entry.build(model.prims(), &row.params)?;
                Ok(Some(ask(&*tracer)))
            }
            Self::Control => {
                let leaky: Option<TriangleSet<S, MoellerTrumbore>> = model.with_moeller_trumbore();
                let Some(set) = leaky else { return Ok(None) };
                with_brute_force(PrimsRef::MoellerTrumbore(&set), ask).map(Some)
            }
        }
    }
}

/// Hands brute force over these primitives to `ask`.
///
/// # Errors
/// [`BuildError`] for an empty scene.
pub fn with_brute_force<S: Buildable, R>(
    prims: PrimsRef<'_, S>,
    ask: impl FnOnce(&dyn Tracer<S>) -> R,
) -> Result<R, BuildError> {
    let entry = find("brute-force")
        .ok_or(BuildError::NoPrimitives { structure: "brute-force (not in the registry)" })?;
    let tracer = entry.build(prims, &entry.params([])?)?;
    Ok(ask(&*tracer))
}
