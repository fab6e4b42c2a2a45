//! The mailbox interface; the mailbox that remembers nothing; a stamp for every primitive, the number
//! of the ray that tested it last; and a small table for each ray.
//!
//! Papers: B. Arnaldi, T. Priol, K. Bouatouch 1987 (stamps), C. Benthin 2006 (slots; see `mod.rs`).
//! Deviations: slots are chosen by a multiplicative hash; they are not cleared for a ray but carry
//! its number.

/// Remembers what one ray has been tested against.
pub trait Mailbox {
    const ENABLED: bool;
    /// False when `id` was tested for this ray already; otherwise it counts as tested from now on.
    /// May forget, never invents.
    fn is_new(&mut self, id: u32) -> bool;
}

/// Gives every ray of a batch its mailbox.
pub trait MailboxSource {
    /// The mailbox of one ray.
    type Mailbox<'r>: Mailbox
    where
        Self: 'r;
    fn next_ray(&mut self) -> Self::Mailbox<'_>;
}

#[derive(Debug, Clone, Copy, Default)]
pub struct NoMailbox;

impl Mailbox for NoMailbox {
    const ENABLED: bool = false;

    #[inline(always)]
    fn is_new(&mut self, _: u32) -> bool {
        true
    }
}

impl MailboxSource for NoMailbox {
    type Mailbox<'r> = Self;

    #[inline(always)]
    fn next_ray(&mut self) -> Self {
        Self
    }
}

/// The number of the ray after this one; 0 stands for none. Numbers up to `LAST` start again where
/// they have run out, after `clear` has removed all that were given.
#[inline(always)]
fn next_number<const LAST: u32>(ray: u32, clear: impl FnOnce()) -> u32 {
    if ray == LAST {
        clear();
        return 1;
    }
    ray + 1
}

/// One stamp for each primitive, next to each other or in records. `LAST` is the largest number of a
/// ray.
#[derive(Debug, Clone)]
pub struct Stamps<const LAST: u32 = { u32::MAX }> {
    /// Primitive `id` is stamped at `id * stride`.
    stamps: Vec<u32>,
    stride: usize,
    ray: u32,
}

impl<const LAST: u32> Stamps<LAST> {
    /// Next to each other.
    pub fn dense(primitives: usize) -> Self {
        Self { stamps: vec![0; primitives], stride: 1, ray: 0 }
    }

    /// Each in a record of that many bytes.
    pub fn in_records(primitives: usize, bytes: usize) -> Self {
        let stride = bytes.div_ceil(size_of::<u32>()).max(1);
        let stamps = vec![0; primitives.saturating_mul(stride)];
        Self { stamps, stride, ray: 0 }
    }

    /// Makes room for so many primitives.
    pub fn hold(&mut self, primitives: usize) {
        let needed = primitives * self.stride;
        if self.stamps.len() < needed {
            self.stamps.resize(needed, 0);
        }
    }

    pub fn bytes(&self) -> usize {
        size_of_val(self.stamps.as_slice())
    }
}

impl<const LAST: u32> Default for Stamps<LAST> {
    fn default() -> Self {
        Self::dense(0)
    }
}

impl<const LAST: u32> Mailbox for &mut Stamps<LAST> {
    const ENABLED: bool = true;

    #[inline(always)]
    fn is_new(&mut self, id: u32) -> bool {
        let ray = self.ray;
        is_changed(self.stamps.get_mut(id as usize * self.stride), ray)
    }
}

/// Puts a letter into a slot, if there is one; false where it is there already.
#[inline(always)]
fn is_changed<T: PartialEq>(slot: Option<&mut T>, letter: T) -> bool {
    match slot {
        Some(slot) if *slot == letter => false,
        Some(slot) => {
            *slot = letter;
            true
        }
        None => true,
    }
}

impl<const LAST: u32> MailboxSource for Stamps<LAST> {
    type Mailbox<'r> = &'r mut Self;

    #[inline(always)]
    fn next_ray(&mut self) -> &mut Self {
        self.ray = next_number::<LAST>(self.ray, || self.stamps.fill(0));
        self
    }
}

/// A table whose slots hold the last primitive of those that fall into each.
#[derive(Debug, Clone)]
pub struct Slots<const LAST: u32 = { u32::MAX }> {
    slots: Vec<(u32, u32)>,
    /// 32 minus the logarithm of their number.
    shift: u32,
    ray: u32,
}

impl<const LAST: u32> Slots<LAST> {
    /// At least that many slots, a power of two.
    pub fn new(slots: usize) -> Self {
        let slots = slots.clamp(1, 1 << 20).next_power_of_two();
        let shift = 32 - slots.trailing_zeros();
        Self { slots: vec![(0, 0); slots], shift, ray: 0 }
    }
}

impl<const LAST: u32> Mailbox for &mut Slots<LAST> {
    const ENABLED: bool = true;

    #[inline(always)]
    fn is_new(&mut self, id: u32) -> bool {
        let hash = u64::from(id.wrapping_mul(0x9E37_79B9));
        let letter = (self.ray, id);
        is_changed(self.slots.get_mut((hash >> self.shift) as usize), letter)
    }
}

impl<const LAST: u32> MailboxSource for Slots<LAST> {
    type Mailbox<'r> = &'r mut Self;

    #[inline(always)]
    fn next_ray(&mut self) -> &mut Self {
        self.ray = next_number::<LAST>(self.ray, || self.slots.fill((0, 0)));
        self
    }
}
