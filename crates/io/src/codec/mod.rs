//! From stored bytes to values: text, base64, compressed blocks.

pub(crate) mod base64;
pub(crate) mod blocks;
pub(crate) mod text;
