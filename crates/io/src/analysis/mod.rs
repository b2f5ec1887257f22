//! What is found out about the data instead of asked: spacing, up axis, what is no water.

mod gas;
mod groups;
mod motion;
pub(crate) mod names;
pub(crate) mod neighbours;
pub(crate) mod others;
pub(crate) mod spacing;
pub(crate) mod subset;
pub(crate) mod up;
mod walls;
