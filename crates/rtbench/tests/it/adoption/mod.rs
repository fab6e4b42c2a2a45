//! What makes the program easy to take into use: formats, schemas, shards, configuration, pages,
//! and that the documents say what is true.

mod configuration;
mod documents;
mod exports;
mod printed;
mod shards;
mod widths;
