//! Stub for systems on which plugins have no processes of their own.

use accel_core::primitives::TriangleSet;
use accel_core::{Hit, Ray};

use crate::description::Description;
use crate::instance::{PluginScalar, Stats};
use crate::stopwatch::CallTime;
use crate::wire::{BuildReply, Launch, Order};

pub(crate) enum Remote {}

impl Remote {
    pub(crate) fn start(_: &Launch) -> Result<Self, String> {
        Err("plugins run in separate processes on Unix only".into())
    }

    pub(crate) fn failure(&self) -> Option<&str> {
        match *self {}
    }

    pub(crate) fn describe(&mut self) -> Result<Description, String> {
        match *self {}
    }

    pub(crate) fn build<S: PluginScalar>(
        &mut self,
        _: &TriangleSet<S>,
        _: &Order<'_>,
    ) -> Result<BuildReply, String> {
        match *self {}
    }

    pub(crate) fn closest<S: PluginScalar>(
        &mut self,
        _: &[Ray<S>],
        _: &mut [Hit<S>],
    ) -> Result<CallTime, String> {
        match *self {}
    }

    pub(crate) fn occluded<S: PluginScalar>(
        &mut self,
        _: &[Ray<S>],
        _: &mut [bool],
    ) -> Result<CallTime, String> {
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
