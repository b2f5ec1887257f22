use meniscus_core::Cancel;

use super::cursor::Cursor;
use crate::Error;
use crate::array::DataArray;
use crate::input_file::InputFile;
use crate::scalar::ToF64;

/// The geometry of `STRUCTURED_POINTS` and `RECTILINEAR_GRID`, whose points are not listed in the file.
#[derive(Default)]
pub(super) struct Grid {
    pub is_regular: bool,
    pub is_rectilinear: bool,
    dimensions: Option<[usize; 3]>,
    origin: [f64; 3],
    spacing: Option<[f64; 3]>,
    coordinates: [Option<DataArray>; 3],
}

impl Grid {
    /// Reads a section that starts with `keyword`; `false` when it is none of a grid's.
    pub fn section(&mut self, keyword: &str, cursor: &mut Cursor<'_>) -> Result<bool, Error> {
        match keyword {
            "dimensions" => self.dimensions = Some(three(cursor, "a dimension")?),
            "origin" => self.origin = three(cursor, "an origin")?,
            "spacing" | "aspect_ratio" => self.spacing = Some(three(cursor, "a spacing")?),
            "x_coordinates" | "y_coordinates" | "z_coordinates" => {
                let axis = usize::from(keyword.as_bytes()[0] - b'x');
                let count = cursor.number("the number of coordinates")?;
                let ty = cursor.scalar_type()?;
                self.coordinates[axis] = Some(cursor.array(keyword.into(), 1, count, ty)?);
            }
            _ => return Ok(false),
        }
        Ok(true)
    }

    /// Number and coordinates (little-endian `f64`, x fastest) of the grid's points.
    pub fn points(&self, file: &InputFile) -> Result<Option<(usize, Vec<u8>)>, Error> {
        let Some(dimensions) = self.dimensions.filter(|_| self.is_regular || self.is_rectilinear) else {
            return Ok(None);
        };
        let place = "DIMENSIONS";
        let count = dimensions.iter().try_fold(1_usize, |product, &n| product.checked_mul(n));
        // A point without any byte of data behind it carries nothing to draw; this also bounds the memory taken.
        let count = count.filter(|&count| count <= file.len()).ok_or_else(|| {
            Error::malformed(
                file.path(),
                place,
                format_args!("{dimensions:?} is more than the file can back"),
            )
        })?;
        let mut axes = [const { Vec::new() }; 3];
        for (axis, values) in axes.iter_mut().enumerate() {
            *values = match &self.coordinates[axis] {
                Some(array) => array.check(file)?.collect(&ToF64, &Cancel::default())?,
                None => {
                    let step = self.spacing.map_or(1.0, |spacing| spacing[axis]);
                    (0..dimensions[axis]).map(|i| self.origin[axis] + i as f64 * step).collect()
                }
            };
            if values.len() != dimensions[axis] {
                let message = format!("expected {} coordinates, found {}", dimensions[axis], values.len());
                return Err(Error::malformed(file.path(), place, message));
            }
        }
        let mut bytes = Vec::with_capacity(count * 24);
        for &z in &axes[2] {
            for &y in &axes[1] {
                for &x in &axes[0] {
                    bytes.extend([x, y, z].iter().flat_map(|v| v.to_le_bytes()));
                }
            }
        }
        Ok(Some((count, bytes)))
    }
}

fn three<T: std::str::FromStr + Copy + Default>(
    cursor: &mut Cursor<'_>,
    what: &str,
) -> Result<[T; 3], Error> {
    let mut values = [T::default(); 3];
    for value in &mut values {
        *value = cursor.number(what)?;
    }
    Ok(values)
}
