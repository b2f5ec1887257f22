//! ESRI ASCII grids (`.asc`): a few keys with a number each, then heights in rows from north to south.

use glam::DVec2;

use super::Terrain;

/// No land is higher or lower, whatever the unit.
const HIGHEST: f64 = 1e30;

/// Whether it begins as these grids do.
pub(super) fn is_esri(bytes: &[u8]) -> bool {
    bytes.trim_ascii_start().get(..5).is_some_and(|word| word.eq_ignore_ascii_case(b"ncols"))
}

/// The grid in `bytes`, or what is wrong and where.
pub(super) fn parse(bytes: &[u8]) -> Result<Terrain, String> {
    let mut tokens = bytes.split(u8::is_ascii_whitespace).filter(|token| !token.is_empty()).peekable();
    let mut header = Header::default();
    while tokens.peek().is_some_and(|token| token[0].is_ascii_alphabetic() && number(token).is_none()) {
        let key = String::from_utf8_lossy(tokens.next().unwrap_or_default()).to_ascii_lowercase();
        let text = tokens.next().unwrap_or_default();
        let value = number(text).ok_or_else(|| format!("{key} is {:?}, expected a number", shown(text)))?;
        let place = match key.as_str() {
            "ncols" => &mut header.columns,
            "nrows" => &mut header.rows,
            "xllcorner" => &mut header.corner[0],
            "yllcorner" => &mut header.corner[1],
            "xllcenter" => &mut header.center[0],
            "yllcenter" => &mut header.center[1],
            "cellsize" => {
                header.spacing[1] = Some(value);
                &mut header.spacing[0]
            }
            "dx" => &mut header.spacing[0],
            "dy" => &mut header.spacing[1],
            "nodata_value" => &mut header.missing,
            _ => return Err(format!("unknown key {key:?} before the heights")),
        };
        *place = Some(value);
    }
    let [columns, rows] = header.size(bytes.len())?;
    let spacing = header.spacing()?;
    let south_west = header.south_west(spacing)?;
    let mut heights = vec![f32::NAN; columns * rows];
    for row in (0..rows).rev() {
        for column in 0..columns {
            let place = || format!("height {} of row {}", column + 1, rows - row);
            let text = tokens.next().ok_or_else(|| {
                format!("{} is missing, expected {rows} rows of {columns}; the file is cut off", place())
            })?;
            let height =
                number(text).ok_or_else(|| format!("{} is {:?}, expected a number", place(), shown(text)))?;
            // Without the key, ESRI's default. Rasters of floats have their largest negative number there.
            if height.abs() < HIGHEST && height != header.missing.unwrap_or(-9999.0) {
                heights[row * columns + column] = height as f32;
            }
        }
    }
    match tokens.next() {
        None => Ok(Terrain::new(south_west, spacing, columns, heights)),
        Some(text) => {
            Err(format!("{:?} follows the {rows} rows of {columns} heights that it declares", shown(text)))
        }
    }
}

/// What stands before the heights.
#[derive(Default)]
struct Header {
    columns: Option<f64>,
    rows: Option<f64>,
    /// Of the south-western cell.
    corner: [Option<f64>; 2],
    center: [Option<f64>; 2],
    spacing: [Option<f64>; 2],
    missing: Option<f64>,
}

impl Header {
    /// Columns and rows; no more than a file of `bytes` can hold.
    fn size(&self, bytes: usize) -> Result<[usize; 2], String> {
        let count = |key: &str, found: Option<f64>| {
            let found = found.ok_or_else(|| format!("{key} is missing before the heights"))?;
            // A height takes a character and a blank.
            let possible = found.fract() == 0.0 && (1.0..=bytes as f64).contains(&found);
            possible
                .then_some(found as usize)
                .ok_or_else(|| format!("{key} is {found}; the file has {bytes} bytes"))
        };
        let (columns, rows) = (count("ncols", self.columns)?, count("nrows", self.rows)?);
        match columns.checked_mul(rows) {
            Some(points) if points <= bytes => Ok([columns, rows]),
            _ => Err(format!(
                "expected {rows} rows of {columns} heights, which {bytes} bytes cannot hold; the file is cut off"
            )),
        }
    }

    fn spacing(&self) -> Result<DVec2, String> {
        let of = |found: Option<f64>| match found {
            None => Err("cellsize is missing before the heights".to_owned()),
            Some(spacing) if spacing.is_finite() && spacing > 0.0 => Ok(spacing),
            Some(spacing) => Err(format!("cellsize is {spacing}, expected a positive length")),
        };
        Ok(DVec2::new(of(self.spacing[0])?, of(self.spacing[1])?))
    }

    /// Centre of the south-western cell: heights belong to the middle of cells.
    fn south_west(&self, spacing: DVec2) -> Result<DVec2, String> {
        let mut place = DVec2::ZERO;
        for axis in 0..2 {
            let found = self.center[axis].or(self.corner[axis].map(|corner| corner + 0.5 * spacing[axis]));
            let name = ["xllcorner", "yllcorner"][axis];
            place[axis] = found
                .filter(|place| place.is_finite())
                .ok_or_else(|| format!("{name} is missing before the heights"))?;
        }
        Ok(place)
    }
}

fn number(token: &[u8]) -> Option<f64> {
    std::str::from_utf8(token).ok()?.parse().ok()
}

/// The start of a token, for messages.
fn shown(token: &[u8]) -> String {
    String::from_utf8_lossy(&token[..token.len().min(40)]).into_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    const SMALL: &str = "NCOLS 3\r\nnrows 2\nxllcorner 100\nyllcenter 20.5\ncellsize 10\nNODATA_value -9999\n1 2 3\n4 -9999 6\n";

    fn parsed(text: &str) -> Result<Terrain, String> {
        parse(text.as_bytes())
    }

    #[test]
    fn rows_come_from_north_to_south_and_corners_are_not_centres() {
        let terrain = parsed(SMALL).unwrap();
        assert!(is_esri(SMALL.as_bytes()));
        assert_eq!((terrain.south_west, terrain.spacing), (DVec2::new(105.0, 20.5), DVec2::splat(10.0)));
        assert_eq!(terrain.size(), [3, 2]);
        let [west, missing, east] = [0, 1, 2].map(|i| terrain.heights[i]);
        assert_eq!((west, east, &terrain.heights[3..]), (4.0, 6.0, &[1.0, 2.0, 3.0][..]));
        assert!(missing.is_nan());
        let undeclared =
            SMALL.replace("NODATA_value -9999\n", "").replace("4 -9999", "-3.4028234663852886e+38 -9999");
        let undeclared = parsed(&undeclared).unwrap();
        assert!(undeclared.heights[0].is_nan() && undeclared.heights[1].is_nan());
        let oblong = parsed(&SMALL.replace("cellsize 10", "dx 10 dy 20")).unwrap();
        assert_eq!(oblong.spacing, DVec2::new(10.0, 20.0));
    }

    #[test]
    fn what_is_wrong_is_named() {
        for (from, to, said) in [
            ("4 -9999 6", "4 -9999", "height 3 of row 2 is missing"),
            ("4 -9999 6", "4 -9999 6 7", "\"7\" follows"),
            ("1 2 3", "1 two 3", "height 2 of row 1 is \"two\""),
            ("NCOLS 3", "ncols 3e9", "ncols is 3000000000"),
            ("NCOLS 3", "ncols 80", "80 heights"),
            ("NCOLS 3", "ncols 2.5", "ncols is 2.5"),
            ("nrows 2", "nrows nan", "nrows is NaN"),
            ("nrows 2\n", "", "nrows is missing"),
            ("cellsize 10", "cellsize 0", "cellsize is 0"),
            ("cellsize 10\n", "", "cellsize is missing"),
            ("xllcorner 100\n", "", "xllcorner is missing"),
            ("cellsize", "cell", "unknown key \"cell\""),
        ] {
            assert!(SMALL.contains(from));
            let message = parsed(&SMALL.replace(from, to)).unwrap_err();
            assert!(message.contains(said), "{to}: {message}");
        }
    }
}
