//! Tests in numbers of few digits, all of a lattice's triangles and rays: every rounding that f32
//! meets once in millions of rays is met here, and exact integers say what is right.
//!
//! What `proofs/` shows holds in epsilons of any scalar, so the code is run with another one: the
//! watertight test and the structures as they are, over [`float::Toy`]. `wide-bvh` has boxes in f32
//! whatever the scalar is; `planes.rs` repeats the arithmetic of its node test, so a change of that
//! is not noticed there (`proofs/node_exit.gappa` and tests of `bvh/items.rs` are about it, too).

mod exact;
mod float;
mod lattice;
mod planes;

pub(super) use float::Toy;
