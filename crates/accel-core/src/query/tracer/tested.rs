//! Structures built over a set whose primitives are tested as another set does, and the mailbox that
//! their settings ask for.

use super::{Bound, Tracer};
use crate::geometry::scalar::Scalar;
use crate::params::{ParamError, Params};
use crate::primitives::PrimSet;
use crate::query::kernel;
use crate::query::mailbox::{self, Setting};
use crate::structure::{BuildError, Structure, refuse_unusable};

/// Builds `T` over a set; its traversals test the primitives of `prims`, the same ones, perhaps under
/// other tests.
pub(crate) fn tested_as<'a, S: Scalar, B: PrimSet<S>, P: PrimSet<S>, T: Structure<S> + 'a>(
    over: &B,
    prims: &'a P,
    params: &Params,
) -> Result<Box<dyn Tracer<S> + 'a>, BuildError> {
    let mailbox = mailbox_of::<S, B>(over, params)?;
    let bound = Bound::new(prims, T::build(over, params)?).with_mailbox(mailbox);
    Ok(Box::new(if asks_for_blocks(params) { bound.with_blocks(over, params)? } else { bound }))
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
