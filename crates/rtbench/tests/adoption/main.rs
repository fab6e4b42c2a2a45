//! What makes the program easy to take into use: formats, schemas, shards, configuration, pages,
//! and that the documents say what is true.

#[path = "../common/mod.rs"]
mod common;

mod configuration;
mod documents;
mod exports;
mod printed;
mod shards;
