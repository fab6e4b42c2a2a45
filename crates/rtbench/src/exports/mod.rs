//! Results as files, and in the formats of services that keep time series.

pub mod measures;
pub mod outputs;
