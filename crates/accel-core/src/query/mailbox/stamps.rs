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

impl<B: MailboxSource> MailboxSource for &mut B {
    type Mailbox<'r>
        = B::Mailbox<'r>
    where
        Self: 'r;

    #[inline(always)]
    fn next_ray(&mut self) -> B::Mailbox<'_> {
        (**self).next_ray()
    }
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

/// A number of rays; 0 stands for none.
pub trait Stamp: Copy + PartialEq + Default + Send + Sync + 'static {
    /// The next number, or `None` when they have run out.
    fn next(self) -> Option<Self>;

    /// The number of the next ray. Where numbers have run out they start again, after `clear` has
    /// removed all that were given.
    #[inline(always)]
    fn of_next_ray(self, clear: impl FnOnce()) -> Self {
        self.next().unwrap_or_else(|| {
            clear();
            Self::default().next().unwrap_or_default()
        })
    }
}

impl Stamp for u32 {
    #[inline(always)]
    fn next(self) -> Option<Self> {
        self.checked_add(1)
    }
}

impl Stamp for u8 {
    #[inline(always)]
    fn next(self) -> Option<Self> {
        self.checked_add(1)
    }
}

/// One stamp for each primitive, next to each other or in records.
#[derive(Debug, Clone)]
pub struct Stamps<I> {
    /// Primitive `id` is stamped at `id * stride`.
    stamps: Vec<I>,
    stride: usize,
    ray: I,
}

impl<I: Stamp> Stamps<I> {
    /// Next to each other.
    pub fn dense(primitives: usize) -> Self {
        Self { stamps: vec![I::default(); primitives], stride: 1, ray: I::default() }
    }

    /// Each in a record of that many bytes.
    pub fn in_records(primitives: usize, bytes: usize) -> Self {
        let stride = bytes.div_ceil(size_of::<I>()).max(1);
        let stamps = vec![I::default(); primitives.saturating_mul(stride)];
        Self { stamps, stride, ray: I::default() }
    }

    /// Makes room for so many primitives.
    pub fn hold(&mut self, primitives: usize) {
        let needed = primitives * self.stride;
        if self.stamps.len() < needed {
            self.stamps.resize(needed, I::default());
        }
    }

    pub fn bytes(&self) -> usize {
        size_of_val(self.stamps.as_slice())
    }
}

impl<I: Stamp> Default for Stamps<I> {
    fn default() -> Self {
        Self::dense(0)
    }
}

impl<I: Stamp> Mailbox for &mut Stamps<I> {
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

impl<I: Stamp> MailboxSource for Stamps<I> {
    type Mailbox<'r> = &'r mut Self;

    #[inline(always)]
    fn next_ray(&mut self) -> &mut Self {
        self.ray = self.ray.of_next_ray(|| self.stamps.fill(I::default()));
        self
    }
}

/// A table whose slots hold the last primitive of those that fall into each.
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
