//! A frame in blocks of points, so that work on all of them needs memory for one.

use std::ops::Range;
use std::sync::atomic::{AtomicU64, Ordering};

use meniscus_core::Cancel;

use crate::Error;
use crate::array::CheckedArray;
use crate::scalar::{Convert, ScalarType};

/// Points in a block: enough to keep all cores busy, 1.5 MB of coordinates in double precision.
pub(super) const BLOCK: usize = 1 << 16;

/// Points that follow one another in one piece.
#[derive(Clone, Debug)]
pub(crate) struct Block {
    pub(super) piece: usize,
    /// Its points in the piece.
    pub(super) range: Range<usize>,
    /// Index of the first of them in the frame.
    pub first: usize,
}

impl Block {
    /// Number of points.
    pub fn len(&self) -> usize {
        self.range.len()
    }
}

/// An array of all pieces of a frame.
pub(crate) struct FrameArray<'a> {
    /// One for each piece that has points.
    pub(super) arrays: Vec<CheckedArray<'a>>,
    pub components: usize,
    pub ty: ScalarType,
    pub(super) bytes_read: &'a AtomicU64,
}

impl FrameArray<'_> {
    /// The values of `block` as `convert` gives them, tuple after tuple.
    pub fn values<C: Convert>(
        &self,
        block: &Block,
        convert: &C,
        cancel: &Cancel,
    ) -> Result<Vec<C::Out>, Error> {
        let array = &self.arrays[block.piece];
        let values = array.tuples_in(block.range.clone(), convert, cancel)?;
        if block.range.start == 0 {
            self.bytes_read.fetch_add(array.stored_bytes(), Ordering::Relaxed);
        }
        Ok(values)
    }
}
