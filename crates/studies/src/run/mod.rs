//! The record of a run as conclusions, tables, Markdown and CSV.

pub mod columns;
pub mod conclusions;
pub mod costs;
pub mod few;
pub mod kind_tables;
pub mod leads;
pub mod lines;
pub mod output;
pub mod tables;
pub mod time_to_image;
pub mod view;
