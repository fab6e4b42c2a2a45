//! A stamp for every primitive: the number of the ray that tested it last.
//!
//! Paper: B. Arnaldi, T. Priol, K. Bouatouch 1987 (see `mod.rs`).

use crate::query::mailbox::{Mailbox, MailboxSource};

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
        match self.stamps.get_mut(id as usize * self.stride) {
            Some(stamp) if *stamp == ray => false,
            Some(stamp) => {
                *stamp = ray;
                true
            }
            None => true,
        }
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
