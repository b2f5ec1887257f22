//! A frame into another file: the numbers as they are, of the particles that are taken.

use std::path::Path;

use meniscus_core::Cancel;

use super::Series;
use super::read::retain;
use super::sets::{Assignment, NO_SET};
use crate::Error;
use crate::array::check;
use crate::frame_data::{Block, FrameArray};
use crate::scalar::{ScalarType, ToF32, ToF64, ToU64};
use crate::writer::{self, Format, Values, WriteAttribute, WriteParticles};

/// An attribute's numbers in the type they are written as.
enum Numbers {
    F32(Vec<f32>),
    F64(Vec<f64>),
    I8(Vec<i8>),
    U8(Vec<u8>),
    I16(Vec<i16>),
    U16(Vec<u16>),
    I32(Vec<i32>),
    U32(Vec<u32>),
    I64(Vec<i64>),
    U64(Vec<u64>),
}

/// Runs `$body` with `$list` bound to the list of whichever type `$numbers` holds.
macro_rules! with_list {
    ($numbers:expr, $list:ident => $body:expr) => {
        match $numbers {
            Numbers::F32($list) => $body,
            Numbers::F64($list) => $body,
            Numbers::I8($list) => $body,
            Numbers::U8($list) => $body,
            Numbers::I16($list) => $body,
            Numbers::U16($list) => $body,
            Numbers::I32($list) => $body,
            Numbers::U32($list) => $body,
            Numbers::I64($list) => $body,
            Numbers::U64($list) => $body,
        }
    };
}

/// A number in its own type from an array of that type.
trait FromArray: Sized {
    fn read(array: &FrameArray<'_>, block: &Block, cancel: &Cancel) -> Result<Vec<Self>, Error>;
}

impl FromArray for f32 {
    fn read(array: &FrameArray<'_>, block: &Block, cancel: &Cancel) -> Result<Vec<Self>, Error> {
        array.values(block, &ToF32, cancel)
    }
}

impl FromArray for f64 {
    fn read(array: &FrameArray<'_>, block: &Block, cancel: &Cancel) -> Result<Vec<Self>, Error> {
        array.values(block, &ToF64, cancel)
    }
}

/// Whole numbers pass through their 64 bits, which hold every one of them.
macro_rules! from_bits {
    ($($t:ty),*) => {$(
        impl FromArray for $t {
            fn read(array: &FrameArray<'_>, block: &Block, cancel: &Cancel) -> Result<Vec<Self>, Error> {
                let bits = array.values(block, &ToU64, cancel)?;
                Ok(bits.into_iter().map(|bits| bits as $t).collect())
            }
        }
    )*};
}
from_bits!(i8, u8, i16, u16, i32, u32, i64, u64);

impl Numbers {
    fn new(ty: ScalarType) -> Self {
        match ty {
            ScalarType::F32 => Self::F32(Vec::new()),
            ScalarType::F64 => Self::F64(Vec::new()),
            ScalarType::I8 => Self::I8(Vec::new()),
            ScalarType::U8 | ScalarType::Bit => Self::U8(Vec::new()),
            ScalarType::I16 => Self::I16(Vec::new()),
            ScalarType::U16 => Self::U16(Vec::new()),
            ScalarType::I32 => Self::I32(Vec::new()),
            ScalarType::U32 => Self::U32(Vec::new()),
            ScalarType::I64 | ScalarType::Id => Self::I64(Vec::new()),
            ScalarType::U64 => Self::U64(Vec::new()),
        }
    }

    /// Appends the tuples of `block` that `taken` marks, all without it.
    fn extend(
        &mut self,
        array: &FrameArray<'_>,
        block: &Block,
        taken: Option<&[bool]>,
        cancel: &Cancel,
    ) -> Result<(), Error> {
        with_list!(self, list => extend(list, array, block, taken, cancel))
    }

    fn values(&self) -> Values<'_> {
        match self {
            Self::F32(values) => Values::F32(values),
            Self::F64(values) => Values::F64(values),
            Self::I8(values) => Values::I8(values),
            Self::U8(values) => Values::U8(values),
            Self::I16(values) => Values::I16(values),
            Self::U16(values) => Values::U16(values),
            Self::I32(values) => Values::I32(values),
            Self::U32(values) => Values::U32(values),
            Self::I64(values) => Values::I64(values),
            Self::U64(values) => Values::U64(values),
        }
    }
}

fn extend<T: FromArray>(
    list: &mut Vec<T>,
    array: &FrameArray<'_>,
    block: &Block,
    taken: Option<&[bool]>,
    cancel: &Cancel,
) -> Result<(), Error> {
    let mut values = T::read(array, block, cancel)?;
    if let Some(taken) = taken {
        retain(&mut values, array.components, taken);
    }
    list.append(&mut values);
    Ok(())
}

impl Series {
    /// Writes frame `index` to `path` with all its attributes in their own types and coordinates in the file's space: the
    /// particles that `--where`, sets, `--every` and `--box` take, broken coordinates included. Returns their number.
    ///
    /// # Errors
    /// [`Error`] when the frame cannot be read or the file cannot be written.
    pub fn convert_frame(
        &self,
        index: usize,
        path: &Path,
        format: Format,
        cancel: &Cancel,
    ) -> Result<usize, Error> {
        let frame = self.frame_data(index, cancel)?;
        let assignment = Assignment::new(self.sets(), &frame, cancel)?;
        let coordinates = frame.positions_array()?;
        let arrays = frame.attributes().iter().map(|attribute| frame.attribute_array(attribute));
        let arrays: Vec<FrameArray<'_>> = arrays.collect::<Result<_, _>>()?;
        let mut positions: Vec<f64> = Vec::new();
        let mut numbers: Vec<Numbers> = arrays.iter().map(|array| Numbers::new(array.ty)).collect();
        for block in frame.blocks() {
            check(cancel)?;
            let sets = assignment.as_ref().map(|assignment| assignment.block(&block, cancel)).transpose()?;
            let taken: Option<Vec<bool>> =
                sets.map(|sets| sets.into_iter().map(|set| set != NO_SET).collect());
            extend(&mut positions, &coordinates, &block, taken.as_deref(), cancel)?;
            for (numbers, array) in std::iter::zip(&mut numbers, &arrays) {
                numbers.extend(array, &block, taken.as_deref(), cancel)?;
            }
        }
        frame.check_unchanged()?;
        let attributes: Vec<WriteAttribute<'_>> = std::iter::zip(frame.attributes(), &numbers)
            .map(|(attribute, numbers)| WriteAttribute {
                name: &attribute.name,
                components: attribute.components,
                values: numbers.values(),
            })
            .collect();
        let particles = WriteParticles {
            positions: positions.as_chunks::<3>().0,
            attributes: &attributes,
            time: frame.time,
        };
        writer::write(path, &particles, format)?;
        Ok(particles.positions.len())
    }
}
