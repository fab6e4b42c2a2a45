//! A classical ray tracer.
