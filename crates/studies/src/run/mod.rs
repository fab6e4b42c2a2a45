//! The record of a run as tables, Markdown and CSV.

pub mod columns;
pub mod csv;
pub mod foreign;
pub mod kind_tables;
pub mod machines;
pub mod markdown;
pub mod picture_time;
pub mod tables;
pub mod text;
