//! Rules of 1999 that today's traversals do without.

pub mod bounds_rule;
pub mod shadow_sink;
