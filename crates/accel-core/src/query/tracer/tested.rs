//! Structures built over a set whose primitives are tested as another set does, and the settings
//! that all structures have or may have.

use super::{Bound, Tracer};
use crate::geometry::scalar::Scalar;
use crate::memory::Limits;
use crate::params::config::{Config, Settings};
use crate::params::{ParamError, Params};
use crate::primitives::{PrimSet, Primitives};
use crate::query::kernel;
use crate::query::mailbox::{self, Setting};
use crate::query::tracer::{Parts, PreviousFrame};
use crate::structure::{BuildError, Structure, refuse_unusable};
use crate::variants::chosen_tests::Choice;

/// How primitives are tested, whatever the structure.
#[derive(Debug, Clone)]
pub(crate) struct TestChoice {
    /// Tests other than the default ones, where the structure offers them.
    pub(crate) chosen: Option<Choice>,
    pub(crate) mailbox: mailbox::Choice,
    /// Lists are asked for as blocks, which they are not where there is a mailbox.
    pub(crate) has_blocks: bool,
    /// Both were asked for.
    is_contradictory: bool,
}

impl Config for TestChoice {
    fn of(params: &Params) -> Self {
        let mailbox = mailbox::Choice::of(params);
        let has_mailbox = mailbox != mailbox::Choice::None;
        let is_given = params.changed().any(|setting| setting == (kernel::PARAM.name, "block"));
        Self {
            chosen: Choice::of(params),
            mailbox,
            has_blocks: params.get(kernel::PARAM.name) == Some("block") && !has_mailbox,
            is_contradictory: is_given && has_mailbox,
        }
    }
}

impl TestChoice {
    /// The mailbox that the settings ask for; refuses sets and settings that cannot be.
    pub(crate) fn mailbox<S: Scalar>(
        &self,
        prims: &dyn Primitives<S>,
        limits: Limits,
    ) -> Result<Setting, BuildError> {
        refuse_unusable(prims, limits)?;
        if self.is_contradictory {
            return Err(BuildError::Param(ParamError::Invalid {
                structure: limits.structure,
                name: kernel::PARAM.name,
                value: "block".to_owned(),
                expected: "scalar where there is a mailbox".to_owned(),
            }));
        }
        Ok(Setting::of(self.mailbox, prims.len(), prims.bytes()))
    }
}

/// Builds `T` over a set; its traversals test the primitives of `prims`, the same ones, perhaps
/// under other tests. `COMPILED`: see [`Bound`].
pub(crate) fn tested_as<'a, S, P, T, const COMPILED: bool>(
    over: &dyn Primitives<S>,
    prims: &'a P,
    (settings, testing): (&Settings<T::Config>, &TestChoice),
    before: Option<PreviousFrame<'_>>,
) -> Result<Box<dyn Tracer<S> + 'a>, BuildError>
where
    S: Scalar,
    P: PrimSet<S>,
    T: Structure<S>,
{
    let mailbox = testing.mailbox(over, settings.limits())?;
    let has_blocks = testing.has_blocks && P::HAS_BLOCKS;
    let (parts, is_updated) = match before.and_then(|before| before.parts(over.len())) {
        Some((parts, moved)) => Parts::updated(parts, over, settings, has_blocks, moved)?,
        None => (Parts::build(over, settings, has_blocks)?, false),
    };
    Ok(Box::new(Bound::<S, P, T, COMPILED>::of_parts(prims, parts, mailbox, is_updated)))
}
