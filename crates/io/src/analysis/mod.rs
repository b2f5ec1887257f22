//! What is found out about the data instead of asked: spacing, up axis, walls.

pub(crate) mod names;
pub(crate) mod neighbours;
pub(crate) mod spacing;
pub(crate) mod subset;
pub(crate) mod up;
pub(crate) mod walls;
