//! Numeric types of VTK arrays and their conversion, one pass from file bytes to the type wanted.

/// Numeric type of an array in a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum ScalarType {
    Bit,
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    I64,
    U64,
    F32,
    F64,
    /// Legacy `vtkIdType`: 64 bits in memory, 32 in the file.
    Id,
}

impl ScalarType {
    /// Bytes per value; `None` for packed bits.
    pub fn size(self) -> Option<usize> {
        match self {
            Self::Bit => None,
            Self::I8 | Self::U8 => Some(1),
            Self::I16 | Self::U16 => Some(2),
            Self::I32 | Self::U32 | Self::F32 | Self::Id => Some(4),
            Self::I64 | Self::U64 | Self::F64 => Some(8),
        }
    }

    /// Bytes that `values` of them take; `None` on overflow.
    pub fn bytes(self, values: usize) -> Option<usize> {
        match self.size() {
            Some(size) => values.checked_mul(size),
            None => Some(values.div_ceil(8)),
        }
    }

    /// VTK's XML name.
    pub fn name(self) -> &'static str {
        match self {
            Self::Bit => "Bit",
            Self::I8 => "Int8",
            Self::U8 => "UInt8",
            Self::I16 => "Int16",
            Self::U16 => "UInt16",
            Self::I32 => "Int32",
            Self::U32 => "UInt32",
            Self::I64 | Self::Id => "Int64",
            Self::U64 => "UInt64",
            Self::F32 => "Float32",
            Self::F64 => "Float64",
        }
    }

    /// Whether it holds whole numbers.
    pub fn is_integer(self) -> bool {
        !matches!(self, Self::F32 | Self::F64)
    }

    /// From VTK's XML name, e.g. `Float64`.
    pub fn from_xml(name: &str) -> Option<Self> {
        use ScalarType::*;
        [Bit, I8, U8, I16, U16, I32, U32, I64, U64, F32, F64]
            .into_iter()
            .find(|ty| ty.name().eq_ignore_ascii_case(name))
    }

    /// From the legacy format's name, e.g. `unsigned_char`. `long` has 8 bytes, as where VTK files are written today; names
    /// with sizes are also written by meshio.
    pub fn from_legacy(name: &str) -> Option<Self> {
        Some(match name.to_ascii_lowercase().as_str() {
            "bit" => Self::Bit,
            "char" | "signed_char" | "vtktypeint8" => Self::I8,
            "unsigned_char" | "vtktypeuint8" => Self::U8,
            "short" | "vtktypeint16" => Self::I16,
            "unsigned_short" | "vtktypeuint16" => Self::U16,
            "int" | "vtktypeint32" => Self::I32,
            "unsigned_int" | "vtktypeuint32" => Self::U32,
            "vtkidtype" => Self::Id,
            "long" | "vtktypeint64" | "long_long" => Self::I64,
            "unsigned_long" | "unsigned_long_long" | "vtktypeuint64" => Self::U64,
            "float" | "vtktypefloat32" => Self::F32,
            "double" | "vtktypefloat64" => Self::F64,
            _ => return None,
        })
    }
}

/// A number as stored in a file.
pub(crate) trait Element: Copy {
    const SIZE: usize;
    /// `bytes` has exactly `SIZE` bytes.
    fn read<const BIG: bool>(bytes: &[u8]) -> Self;
    fn to_f64(self) -> f64;
    fn to_f32(self) -> f32;
    fn to_u64(self) -> u64;
}

macro_rules! element {
    ($($t:ty),*) => {$(
        impl Element for $t {
            const SIZE: usize = size_of::<$t>();
            #[inline(always)]
            fn read<const BIG: bool>(bytes: &[u8]) -> Self {
                let mut raw = [0; size_of::<$t>()];
                raw.copy_from_slice(bytes);
                if BIG { <$t>::from_be_bytes(raw) } else { <$t>::from_le_bytes(raw) }
            }
            #[inline(always)]
            fn to_f64(self) -> f64 { self as f64 }
            #[inline(always)]
            fn to_f32(self) -> f32 { self as f32 }
            #[inline(always)]
            fn to_u64(self) -> u64 { self as u64 }
        }
    )*};
}
element!(i8, u8, i16, u16, i32, u32, i64, u64, f32, f64);

/// What file values become.
pub(crate) trait Convert: Sync {
    type Out: Copy + Default + Send + Sync;
    /// Converts `src` (whole elements) into `out` (as many); `first` is the index of the first value in its array.
    fn block<E: Element, const BIG: bool>(&self, first: usize, src: &[u8], out: &mut [Self::Out]);

    /// [`Self::block`] for a run-time type. Bits are unpacked before they come here.
    fn bytes(&self, ty: ScalarType, big: bool, first: usize, src: &[u8], out: &mut [Self::Out]) {
        macro_rules! run {
            ($t:ty) => {
                if big {
                    self.block::<$t, true>(first, src, out)
                } else {
                    self.block::<$t, false>(first, src, out)
                }
            };
        }
        match ty {
            ScalarType::Bit | ScalarType::U8 => run!(u8),
            ScalarType::I8 => run!(i8),
            ScalarType::I16 => run!(i16),
            ScalarType::U16 => run!(u16),
            ScalarType::I32 | ScalarType::Id => run!(i32),
            ScalarType::U32 => run!(u32),
            ScalarType::I64 => run!(i64),
            ScalarType::U64 => run!(u64),
            ScalarType::F32 => run!(f32),
            ScalarType::F64 => run!(f64),
        }
    }
}

macro_rules! plain {
    ($name:ident, $out:ty, $method:ident) => {
        impl Convert for $name {
            type Out = $out;
            #[inline]
            fn block<E: Element, const BIG: bool>(&self, _first: usize, src: &[u8], out: &mut [$out]) {
                for (bytes, value) in src.chunks_exact(E::SIZE).zip(out) {
                    *value = E::read::<BIG>(bytes).$method();
                }
            }
        }
    };
}

/// Values as `f64`.
pub(crate) struct ToF64;
plain!(ToF64, f64, to_f64);

/// Values as `f32`.
pub(crate) struct ToF32;
plain!(ToF32, f32, to_f32);

/// Whole numbers as identities; negative ones wrap, as two's complement does.
pub(crate) struct ToU64;
plain!(ToU64, u64, to_u64);

/// Coordinates (x, y, z, x, ...) minus `origin`, subtracted in `f64` before rounding to `f32`.
pub(crate) struct Recentre {
    pub origin: [f64; 3],
}

impl Convert for Recentre {
    type Out = f32;
    #[inline]
    fn block<E: Element, const BIG: bool>(&self, first: usize, src: &[u8], out: &mut [f32]) {
        let origin: [f64; 3] = std::array::from_fn(|i| self.origin[(first + i) % 3]);
        let whole = out.len() / 3;
        let (points, rest) = out.split_at_mut(whole * 3);
        let (src, src_rest) = src.split_at(whole * 3 * E::SIZE);
        for (bytes, point) in src.chunks_exact(3 * E::SIZE).zip(points.chunks_exact_mut(3)) {
            for axis in 0..3 {
                let value = E::read::<BIG>(&bytes[axis * E::SIZE..(axis + 1) * E::SIZE]).to_f64();
                point[axis] = limited(value - origin[axis]);
            }
        }
        for (axis, (bytes, value)) in src_rest.chunks_exact(E::SIZE).zip(rest).enumerate() {
            *value = limited(E::read::<BIG>(bytes).to_f64() - origin[axis]);
        }
    }
}

/// As `f32`; a number that is too large for it is its largest one: far away, but not without a place.
#[inline(always)]
fn limited(value: f64) -> f32 {
    let near = value as f32;
    if near.is_infinite() && value.is_finite() { f32::MAX.copysign(near) } else { near }
}

/// Whether each coordinate (x, y, z, x, ...) is inside its axis' range, limits included; never for NaN.
pub(crate) struct InRanges {
    pub min: [f64; 3],
    pub max: [f64; 3],
}

impl Convert for InRanges {
    type Out = bool;
    #[inline]
    fn block<E: Element, const BIG: bool>(&self, first: usize, src: &[u8], out: &mut [bool]) {
        for (i, (bytes, inside)) in src.chunks_exact(E::SIZE).zip(out).enumerate() {
            let axis = (first + i) % 3;
            let value = E::read::<BIG>(bytes).to_f64();
            *inside = self.min[axis] <= value && value <= self.max[axis];
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn recentring_subtracts_in_f64_at_any_phase() {
        // The steps of f32 are 1/32 at half a million and 1/4 at three million: rounded first, these would lose their fractions.
        let values = [500_000.015_625_f64, 3_400_000.062_5, 10.5, 500_001.0, 3_400_001.0, 11.0];
        let bytes: Vec<u8> = values.iter().flat_map(|v| v.to_be_bytes()).collect();
        let convert = Recentre { origin: [500_000.0, 3_400_000.0, 10.0] };
        let expected = [0.015_625, 0.0625, 0.5, 1.0, 1.0, 1.0];
        for first in 0..6 {
            let mut out = vec![0.0; 6 - first];
            convert.bytes(ScalarType::F64, true, first, &bytes[first * 8..], &mut out);
            assert_eq!(out, expected[first..], "starting at value {first}");
        }
    }

    #[test]
    fn what_is_too_far_for_f32_is_as_far_as_it_goes() {
        let values = [1e308, -1e39, f64::INFINITY, f64::NEG_INFINITY, f64::NAN, 3.0];
        let bytes: Vec<u8> = values.iter().flat_map(|v| v.to_le_bytes()).collect();
        let mut out = [0.0; 6];
        Recentre { origin: [1.0; 3] }.bytes(ScalarType::F64, false, 0, &bytes, &mut out);
        assert_eq!(out[..4], [f32::MAX, -f32::MAX, f32::INFINITY, f32::NEG_INFINITY]);
        assert!(out[4].is_nan() && out[5] == 2.0);
    }

    #[test]
    fn every_type_is_read_in_both_byte_orders() {
        macro_rules! check {
            ($t:ty, $ty:expr) => {
                let value = 77 as $t;
                let mut out = [0.0];
                ToF64.bytes($ty, false, 0, &value.to_le_bytes(), &mut out);
                assert_eq!(out, [77.0]);
                ToF64.bytes($ty, true, 0, &value.to_be_bytes(), &mut out);
                assert_eq!(out, [77.0]);
                assert_eq!(ScalarType::from_xml($ty.name()), Some($ty));
            };
        }
        check!(i8, ScalarType::I8);
        check!(u8, ScalarType::U8);
        check!(i16, ScalarType::I16);
        check!(u16, ScalarType::U16);
        check!(i32, ScalarType::I32);
        check!(u32, ScalarType::U32);
        check!(i64, ScalarType::I64);
        check!(u64, ScalarType::U64);
        check!(f32, ScalarType::F32);
        check!(f64, ScalarType::F64);
    }
}
