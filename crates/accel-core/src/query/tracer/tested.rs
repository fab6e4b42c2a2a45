//! Structures built over a set whose primitives are tested as another set does, and the mailbox that
//! their settings ask for.

use super::kept::{Before, Parts};
use super::{Bound, Tracer};
use crate::geometry::scalar::Scalar;
use crate::params::{ParamError, Params};
use crate::primitives::PrimSet;
use crate::query::kernel;
use crate::query::mailbox::{self, Setting};
use crate::structure::{BuildError, Structure, refuse_unusable};
use crate::update::Change;

/// Builds `T` over a set; its traversals test the primitives of `prims`, the same ones, perhaps under
/// other tests.
pub(crate) fn tested_as<'a, S: Scalar, B: PrimSet<S>, P: PrimSet<S>, T: Structure<S>>(
    over: &B,
    prims: &'a P,
    params: &Params,
    before: Option<Before<'_>>,
) -> Result<Box<dyn Tracer<S> + 'a>, BuildError> {
    let mailbox = mailbox_of::<S, B>(over, params)?;
    let has_blocks = asks_for_blocks(params);
    let of_frame = |parts: &Parts<S, T>| parts.primitives == over.len();
    let Some((mut parts, moved)) =
        before.and_then(Before::parts::<S, T>).filter(|b| of_frame(&b.0))
    else {
        let bound = Bound::new(prims, T::build(over, params)?).with_mailbox(mailbox);
        return Ok(Box::new(if has_blocks { bound.with_blocks(over, params)? } else { bound }));
    };
    let change = parts.structure.update(over, params, moved)?;
    let bound = Bound::new(prims, parts.structure).with_mailbox(mailbox).updated(&change);
    Ok(Box::new(match (has_blocks, change, parts.blocks) {
        (false, ..) => bound,
        (true, Change::Lists(lists), Some(blocks)) => {
            bound.with_changed_blocks(over, params, blocks, &lists)?
        }
        (true, ..) => bound.with_blocks(over, params)?,
    }))
}

/// Whether the settings ask for lists as blocks.
pub(crate) fn asks_for_blocks(params: &Params) -> bool {
    params.get(kernel::PARAM.name) == Some("block") && !asks_for_mailbox(params)
}

fn asks_for_mailbox(params: &Params) -> bool {
    params.get(mailbox::PARAM.name).is_some_and(|mailbox| mailbox != "none")
}

/// The mailbox that the settings ask for; refuses sets and settings that cannot be.
pub(crate) fn mailbox_of<S: Scalar, P: PrimSet<S>>(
    prims: &P,
    params: &Params,
) -> Result<Setting, BuildError> {
    refuse_unusable(prims, params)?;
    if params.changed().any(|setting| setting == (kernel::PARAM.name, "block"))
        && asks_for_mailbox(params)
    {
        return Err(BuildError::Param(ParamError::Invalid {
            structure: params.structure(),
            name: kernel::PARAM.name,
            value: "block".to_owned(),
            expected: "scalar where there is a mailbox".to_owned(),
        }));
    }
    Ok(Setting::of(params, prims.len(), prims.bytes()))
}
