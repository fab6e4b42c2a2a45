//! Mailboxes: a primitive that stands in several cells is tested once a ray.
//!
//! Papers: B. Arnaldi, T. Priol, K. Bouatouch, "A New Space Subdivision Method for Ray Tracing CSG
//! Modelled Scenes", The Visual Computer 3, 1987 (mailboxes); C. Benthin, "Realtime Ray Tracing on
//! Current CPU Architectures", 2006, for the small hash of a ray.
//!
//! A mailbox is a property of the query, not of the structure: sinks hold one, and
//! [`crate::query::tracer::Bound`] picks its type once a batch. A structure with duplicate
//! references lists [`PARAM`] and [`SLOTS_PARAM`] among its parameters and is served.
//!
//! * `none`: the sinks hold a zero-sized [`NoMailbox`] and are what they were without this module.
//!   The other three are one type, [`AnyMailbox`], that branches at run time, always the same way.
//! * `primitive`: the lecture's naive one, a stamp in the primitive's record ([`Stamps`] as wide as
//!   primitives). One for all threads, so batches of several threads wait for each other.
//! * `array`: an array of stamps for each thread ([`Stamps`], dense).
//! * `hash`: a few slots for each ray ([`Slots`]); what was pushed out is tested again.
//!
//! A stamp is the number of a ray. Where numbers run out they start again, after all stamps have
//! been cleared: a wrong skip never happens.
//!
//! Deviation of `primitive`: our sets are read-only while rays are traced. The stamp therefore
//! stands in a record of its own as wide as an average primitive and the stamp together. It dirties
//! a cache line for each primitive that is tested, as the lecture's does, and touches one line
//! more.
//!
//! The historical shadow ray of 1999 has no mailbox but its own memory for glass.

mod stamps;

pub use stamps::{Mailbox, MailboxSource, NoMailbox, Slots, Stamps};

use std::cell::RefCell;
use std::sync::{Mutex, PoisonError};

use crate::params::{ParamSpec, Params};

/// The setting, for the parameter list of a structure with duplicate references.
pub const PARAM: ParamSpec =
    ParamSpec::choice("mailbox", "none", &["none", "primitive", "array", "hash"]).about(
        "spares repeated tests: stamp in the primitive, array per thread, or small hash per ray",
    );

pub const SLOTS_PARAM: ParamSpec = ParamSpec::integer("mailbox-slots", "64", 1, 1 << 20)
    .about("slots of the mailbox 'hash' (rounded up to a power of two)");

/// A mailbox chosen at run time; one type, so that traversals are compiled once.
pub enum AnyMailbox<'m> {
    None,
    Stamps(&'m mut Stamps),
    Slots(&'m mut Slots),
}

impl Mailbox for AnyMailbox<'_> {
    const ENABLED: bool = true;

    #[inline(always)]
    fn is_new(&mut self, id: u32) -> bool {
        match self {
            Self::None => true,
            Self::Stamps(stamps) => stamps.is_new(id),
            Self::Slots(slots) => slots.is_new(id),
        }
    }
}

impl MailboxSource for AnyMailbox<'_> {
    type Mailbox<'r>
        = AnyMailbox<'r>
    where
        Self: 'r;

    #[inline(always)]
    fn next_ray(&mut self) -> AnyMailbox<'_> {
        match self {
            Self::None => AnyMailbox::None,
            Self::Stamps(stamps) => AnyMailbox::Stamps(stamps.next_ray()),
            Self::Slots(slots) => AnyMailbox::Slots(slots.next_ray()),
        }
    }
}

/// Mailbox chosen by the settings of a structure.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Choice {
    None,
    /// Stamps in the primitives.
    Primitive,
    /// An array for each thread.
    Array,
    /// A hash for each ray, of so many slots.
    Hash(usize),
}

impl Choice {
    /// Reads [`PARAM`] and [`SLOTS_PARAM`]; none for a structure that does not list them.
    pub fn of(params: &Params) -> Self {
        match params.get(PARAM.name) {
            Some("primitive") => Self::Primitive,
            Some("array") => Self::Array,
            Some("hash") => Self::Hash(params.integer(SLOTS_PARAM.name) as usize),
            _ => Self::None,
        }
    }
}

/// The mailbox of a tracer.
#[derive(Debug)]
pub enum Setting {
    None,
    /// Stamps beside the primitives, one set for all threads.
    Primitive(Mutex<Stamps>),
    /// Stamps for each thread, for so many primitives.
    Array(usize),
    /// A hash for each ray, of so many slots.
    Hash(usize),
}

thread_local! {
    /// One array per thread, whatever it traces: ray numbers go on, so what a tracer before this
    /// one left is never taken for its own.
    static ARRAY: RefCell<Stamps> = RefCell::new(Stamps::dense(0));
}

impl Setting {
    /// Creates the chosen mailbox; `bytes` is the size of the set of `primitives`.
    pub fn of(choice: Choice, primitives: usize, bytes: usize) -> Self {
        match choice {
            Choice::Primitive => {
                let record = bytes / primitives.max(1) + size_of::<u32>();
                Self::Primitive(Mutex::new(Stamps::in_records(primitives, record)))
            }
            Choice::Array => Self::Array(primitives),
            Choice::Hash(slots) => Self::Hash(slots),
            Choice::None => Self::None,
        }
    }

    /// Returns whether there is one.
    pub fn is_used(&self) -> bool {
        !matches!(self, Self::None)
    }

    /// Calls `use_it` with the mailbox of this thread; `primitive` waits until no other thread
    /// uses it.
    pub fn with<R>(&self, use_it: impl FnOnce(AnyMailbox) -> R) -> R {
        let (mut locked, mut slots);
        let mut taken = None;
        let mailbox = match self {
            Self::None => AnyMailbox::None,
            Self::Primitive(stamps) => {
                // after a panic elsewhere the stamps are still those of earlier rays
                locked = stamps.lock().unwrap_or_else(PoisonError::into_inner);
                AnyMailbox::Stamps(&mut locked)
            }
            Self::Array(primitives) => {
                // taken out while in use, so that a query within a query gets one of its own
                let stamps = taken.insert(ARRAY.take());
                stamps.hold(*primitives);
                AnyMailbox::Stamps(stamps)
            }
            Self::Hash(number) => {
                slots = Slots::new(*number);
                AnyMailbox::Slots(&mut slots)
            }
        };
        // in one place, so that it is compiled once
        let result = use_it(mailbox);
        if let Some(stamps) = taken {
            ARRAY.replace(stamps);
        }
        result
    }

    /// Bytes of a mailbox that belongs to the structure.
    pub fn bytes(&self) -> u64 {
        match self {
            Self::Primitive(stamps) => {
                stamps.lock().unwrap_or_else(PoisonError::into_inner).bytes() as u64
            }
            _ => 0,
        }
    }
}
