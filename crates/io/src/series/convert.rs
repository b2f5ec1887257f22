//! A frame into another file: the numbers as they are, of the particles that are taken.

use std::path::Path;

use meniscus_core::Cancel;

use super::Series;
use super::sets::{self, NO_SET};
use crate::Error;
use crate::frame_data::{AttributeInfo, FrameData};
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

/// Whole numbers pass through their 64 bits, which hold every one of them.
macro_rules! from_bits {
    ($($ty:pat => $kind:ident($t:ty)),*) => {
        |ty: ScalarType, bits: Vec<u64>| match ty {
            $($ty => Numbers::$kind(bits.into_iter().map(|bits| bits as $t).collect()),)*
            ScalarType::F32 | ScalarType::F64 | ScalarType::U64 => Numbers::U64(bits),
        }
    };
}

impl Numbers {
    fn read(frame: &FrameData, attribute: &AttributeInfo, cancel: &Cancel) -> Result<Self, Error> {
        let whole = from_bits!(
            ScalarType::I8 => I8(i8), ScalarType::U8 | ScalarType::Bit => U8(u8),
            ScalarType::I16 => I16(i16), ScalarType::U16 => U16(u16),
            ScalarType::I32 => I32(i32), ScalarType::U32 => U32(u32),
            ScalarType::I64 | ScalarType::Id => I64(i64));
        Ok(match attribute.ty {
            ScalarType::F32 => Self::F32(frame.values(attribute, &ToF32, cancel)?),
            ScalarType::F64 => Self::F64(frame.values(attribute, &ToF64, cancel)?),
            ty => whole(ty, frame.values(attribute, &ToU64, cancel)?),
        })
    }

    /// Leaves the tuples that `taken` marks.
    fn retain(&mut self, components: usize, taken: &[bool]) {
        fn retain<T>(values: &mut Vec<T>, components: usize, taken: &[bool]) {
            let mut index = 0;
            values.retain(|_| {
                index += 1;
                taken[(index - 1) / components]
            });
        }
        match self {
            Self::F32(values) => retain(values, components, taken),
            Self::F64(values) => retain(values, components, taken),
            Self::I8(values) => retain(values, components, taken),
            Self::U8(values) => retain(values, components, taken),
            Self::I16(values) => retain(values, components, taken),
            Self::U16(values) => retain(values, components, taken),
            Self::I32(values) => retain(values, components, taken),
            Self::U32(values) => retain(values, components, taken),
            Self::I64(values) => retain(values, components, taken),
            Self::U64(values) => retain(values, components, taken),
        }
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
        let assigned = sets::assign(self.sets(), &frame, cancel)?;
        let taken: Option<Vec<bool>> =
            assigned.map(|sets| sets.into_iter().map(|set| set != NO_SET).collect());
        let mut positions = frame.coordinates(cancel)?.as_chunks::<3>().0.to_vec();
        if let Some(taken) = &taken {
            let mut marks = taken.iter();
            positions.retain(|_| marks.next().is_some_and(|taken| *taken));
        }
        let mut numbers = Vec::with_capacity(frame.attributes().len());
        for attribute in frame.attributes() {
            let mut values = Numbers::read(&frame, attribute, cancel)?;
            if let Some(taken) = &taken {
                values.retain(attribute.components, taken);
            }
            numbers.push(values);
        }
        frame.check_unchanged()?;
        let attributes: Vec<WriteAttribute<'_>> = std::iter::zip(frame.attributes(), &numbers)
            .map(|(attribute, numbers)| WriteAttribute {
                name: &attribute.name,
                components: attribute.components,
                values: numbers.values(),
            })
            .collect();
        let particles = WriteParticles { positions: &positions, attributes: &attributes, time: frame.time };
        writer::write(path, &particles, format)?;
        Ok(positions.len())
    }
}
