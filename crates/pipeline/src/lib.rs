//! The one crate that knows all stages: frame loop, presets, report.
