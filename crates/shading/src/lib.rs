//! Lighting models, environment, opaque scene pass.
