//! Results as files, and in the formats of services that keep time series.

pub mod bencher;
pub mod elsewhere;
pub mod github_action_benchmark;
pub mod measures;
pub mod occupied;
pub mod outputs;
pub mod places;
