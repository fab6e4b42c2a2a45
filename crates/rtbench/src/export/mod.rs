//! Results as files and tables, one format a file.

pub mod csv;
pub mod files;
pub mod json;
pub mod markdown;
pub mod numbers;
pub mod svg_plot;
pub mod sweep_csv;
pub mod sweep_plot;
pub mod sweep_table;
pub mod table;
pub mod text;
