//! A small table for each ray: a slot holds the last primitive of those that fall into it.
//!
//! Paper: C. Benthin 2006 (see `mod.rs`). Deviations: slots are chosen by a multiplicative hash;
//! they are not cleared for a ray but carry its number.

use crate::query::mailbox::stamps::{Mailbox, MailboxSource, Stamp, is_changed};

#[derive(Debug, Clone)]
pub struct Slots<I> {
    slots: Vec<(I, u32)>,
    /// 32 minus the logarithm of their number.
    shift: u32,
    ray: I,
}

impl<I: Stamp> Slots<I> {
    /// At least that many slots, a power of two.
    pub fn new(slots: usize) -> Self {
        let slots = slots.clamp(1, 1 << 20).next_power_of_two();
        let shift = 32 - slots.trailing_zeros();
        Self { slots: vec![(I::default(), 0); slots], shift, ray: I::default() }
    }
}

impl<I: Stamp> Mailbox for &mut Slots<I> {
    const ENABLED: bool = true;

    #[inline(always)]
    fn is_new(&mut self, id: u32) -> bool {
        let hash = u64::from(id.wrapping_mul(0x9E37_79B9));
        let letter = (self.ray, id);
        is_changed(self.slots.get_mut((hash >> self.shift) as usize), letter)
    }
}

impl<I: Stamp> MailboxSource for Slots<I> {
    type Mailbox<'r> = &'r mut Self;

    #[inline(always)]
    fn next_ray(&mut self) -> &mut Self {
        self.ray = self.ray.of_next_ray(|| self.slots.fill((I::default(), 0)));
        self
    }
}
