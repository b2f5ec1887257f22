//! Numbers as text: the fewest digits that read back as the same number.

use std::fmt::{Display, LowerExp};
use std::io::{Result, Write};

use super::Values;

/// Numbers per line.
const PER_LINE: usize = 9;

/// Writes all numbers of `values`, several to a line, each line ended.
pub(super) fn write(writer: &mut impl Write, values: Values<'_>) -> Result<()> {
    match values {
        Values::F32(slice) => lines(writer, slice, |w, v| real(w, *v, f64::from(*v))),
        Values::F64(slice) => lines(writer, slice, |w, v| real(w, *v, *v)),
        Values::I8(slice) => lines(writer, slice, |w, v| write!(w, "{v}")),
        Values::U8(slice) => lines(writer, slice, |w, v| write!(w, "{v}")),
        Values::I16(slice) => lines(writer, slice, |w, v| write!(w, "{v}")),
        Values::U16(slice) => lines(writer, slice, |w, v| write!(w, "{v}")),
        Values::I32(slice) => lines(writer, slice, |w, v| write!(w, "{v}")),
        Values::U32(slice) => lines(writer, slice, |w, v| write!(w, "{v}")),
        Values::I64(slice) => lines(writer, slice, |w, v| write!(w, "{v}")),
        Values::U64(slice) => lines(writer, slice, |w, v| write!(w, "{v}")),
    }
}

fn lines<W: Write, T>(writer: &mut W, values: &[T], one: impl Fn(&mut W, &T) -> Result<()>) -> Result<()> {
    for line in values.chunks(PER_LINE) {
        for (i, value) in line.iter().enumerate() {
            if i > 0 {
                writer.write_all(b" ")?;
            }
            one(writer, value)?;
        }
        writer.write_all(b"\n")?;
    }
    Ok(())
}

/// `number`, whose size is that of `size`: with an exponent where it would be long without.
fn real(writer: &mut impl Write, number: impl Display + LowerExp, size: f64) -> Result<()> {
    match size.abs() {
        _ if size.is_nan() => writer.write_all(b"nan"),
        0.0 | 1e-4..1e15 => write!(writer, "{number}"),
        f64::INFINITY => writer.write_all(if size > 0.0 { b"inf" } else { b"-inf" }),
        _ => write!(writer, "{number:e}"),
    }
}
