//! A state that can only go forward. Asked for an earlier one, it starts again.

/// A state, where it began, and how many steps it took.
pub(super) struct Replay<S> {
    first: S,
    state: S,
    steps: u32,
}

impl<S: Clone> Replay<S> {
    pub fn new(first: S) -> Self {
        Self { state: first.clone(), first, steps: 0 }
    }

    /// The state after so many steps.
    pub fn after(&mut self, steps: u32, step: impl Fn(&mut S)) -> &S {
        if steps < self.steps {
            self.state = self.first.clone();
            self.steps = 0;
        }
        while self.steps < steps {
            step(&mut self.state);
            self.steps += 1;
        }
        &self.state
    }
}
