//! Stub for systems on which plugins have no processes of their own.

use accel_core::primitives::TriangleSet;
use accel_core::{Hit, Ray};

use crate::description::Description;
use crate::instance::Stats;
use crate::process::{BuildReply, Launch, Order};

pub(crate) enum Remote {}

impl Remote {
    pub(crate) fn start(_: &Launch) -> Result<Self, String> {
        Err("there are processes of plugins on Unix only".into())
    }

    pub(crate) fn failure(&self) -> Option<&str> {
        match *self {}
    }

    pub(crate) fn describe(&mut self) -> Result<Description, String> {
        match *self {}
    }

    pub(crate) fn build(
        &mut self,
        _: &TriangleSet<f32>,
        _: &Order<'_>,
    ) -> Result<BuildReply, String> {
        match *self {}
    }

    pub(crate) fn closest(&mut self, _: &[Ray<f32>], _: &mut [Hit<f32>]) -> Result<f64, String> {
        match *self {}
    }

    pub(crate) fn occluded(&mut self, _: &[Ray<f32>], _: &mut [bool]) -> Result<f64, String> {
        match *self {}
    }

    pub(crate) fn count(&mut self, _: bool) -> Result<(), String> {
        match *self {}
    }

    pub(crate) fn stats(&mut self) -> Result<Stats, String> {
        match *self {}
    }

    pub(crate) fn destroy(&mut self) -> Result<(), String> {
        match *self {}
    }

    pub(crate) fn empty_call(&mut self) -> Result<f64, String> {
        match *self {}
    }
}
