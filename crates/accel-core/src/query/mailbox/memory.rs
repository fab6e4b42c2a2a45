//! The mailbox interface, and the mailbox that remembers nothing.

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
