//! The passes on a real device: a missing adapter is a failure, not a skip.

mod brdf;
mod conformance;
mod fluid;
mod foam;
mod mistakes;
mod reflected_objects;
mod scene;
mod sunlight;
mod support;
