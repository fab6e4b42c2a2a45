//! What makes the program easy to take into use: formats, schemas, shards, set files, pages,
//! and that the documents say what is true.

pub mod documents;
mod exports;
mod parsed;
mod printed;
mod recorded;
mod set_files;
mod shards;
mod typed;
mod widths;
