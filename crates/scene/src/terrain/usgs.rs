//! USGS DEM: records of 1024 characters with numbers at fixed places (USGS, *Standards for Digital Elevation Models*, part 2,
//! 1998): a header, then profiles from south to north, each with its own start.

use std::fmt::Display;

use glam::DVec2;

use super::Terrain;

const RECORD: usize = 1024;

/// Heights in the first record of a profile, behind 144 characters, and in each that follows.
const FIRST: usize = 146;
const NEXT: usize = 170;

/// A height without a number.
const VOID: f64 = -32767.0;

/// The grid in `bytes`, or what is wrong and where.
pub(super) fn parse(bytes: &[u8]) -> Result<Terrain, String> {
    // Some files have a line per record.
    let text: Vec<u8> = bytes.iter().copied().filter(|byte| !matches!(byte, b'\n' | b'\r')).collect();
    let header = Header::read(&text).ok_or(
        "is neither an ESRI ASCII grid, which starts with `ncols`, nor a USGS DEM, whose numbers are at fixed places; convert it, \
         for example by `gdal_translate -of AAIGrid`",
    )?;
    let mut profiles = Vec::new();
    let mut at = RECORD;
    for index in 0..header.profiles {
        let (profile, next) = Profile::read(&text, at, header.height_unit).map_err(|message| {
            format!("profile {} of {}, character {at}: {message}", index + 1, header.profiles)
        })?;
        profiles.push(profile);
        at = next;
    }
    header.grid(&profiles)
}

struct Header {
    /// Distances of profiles, and of heights in them.
    spacing: DVec2,
    /// Steps in which heights are stored.
    height_unit: f64,
    /// Ground units in a unit of height.
    ground_per_height: f64,
    profiles: usize,
}

impl Header {
    fn read(text: &[u8]) -> Option<Self> {
        let [x, y, z] = [817, 829, 841].map(|column| number(text, column, 12));
        // Feet or metres; arc seconds and others are left as they are.
        let metres = |column: usize| match number(text, column, 6) {
            Some(1.0) => Some(0.3048),
            Some(2.0) => Some(1.0),
            _ => None,
        };
        let ground_per_height = metres(535).zip(metres(529)).map_or(1.0, |(height, ground)| height / ground);
        let positive = |value: Option<f64>| value.filter(|value| value.is_finite() && *value > 0.0);
        let profiles = number(text, 859, 6).filter(|count| count.fract() == 0.0 && *count >= 1.0)?;
        // Every profile takes a record: no more are believed than the file holds.
        let profiles = (profiles as usize <= text.len() / RECORD).then_some(profiles as usize)?;
        let spacing = DVec2::new(positive(x)?, positive(y)?);
        Some(Self { spacing, height_unit: positive(z)?, ground_per_height, profiles })
    }

    /// Profiles stand on a common grid, but need not start in the same row of it.
    fn grid(&self, profiles: &[Profile]) -> Result<Terrain, String> {
        let columns = profiles.len();
        let south = profiles.iter().map(|profile| profile.start.y).fold(f64::INFINITY, f64::min);
        let row_of = |profile: &Profile| ((profile.start.y - south) / self.spacing.y).round();
        let tops = profiles.iter().map(|profile| row_of(profile) + profile.heights.len() as f64);
        let rows = tops.fold(0.0, f64::max);
        // Profiles that start far from each other would make a grid of holes.
        let there: usize = profiles.iter().map(|profile| profile.heights.len()).sum();
        if !rows.is_finite() || rows * columns as f64 > 16.0 * there as f64 + 1024.0 {
            return Err(format!(
                "its profiles start too far from each other: {there} heights in {rows} rows"
            ));
        }
        let mut heights = vec![f32::NAN; rows as usize * columns];
        for (column, profile) in profiles.iter().enumerate() {
            let first = row_of(profile) as usize;
            for (row, height) in profile.heights.iter().enumerate() {
                heights[(first + row) * columns + column] = (*height * self.ground_per_height) as f32;
            }
        }
        Ok(Terrain::new(DVec2::new(profiles[0].start.x, south), self.spacing, columns, heights))
    }
}

/// Heights from south to north.
struct Profile {
    start: DVec2,
    heights: Vec<f64>,
}

impl Profile {
    /// The profile at `at`, and where the next one starts.
    fn read(text: &[u8], at: usize, unit: f64) -> Result<(Self, usize), String> {
        let record = text.get(at..).unwrap_or_default();
        let field = |name: &dyn Display, column: usize, width: usize| {
            number(record, column, width).filter(|value| value.is_finite()).ok_or_else(|| {
                let found = String::from_utf8_lossy(field(record, column, width)).into_owned();
                format!("{name} is {found:?}, expected a number")
            })
        };
        let count = field(&"the number of heights", 13, 6)?;
        // Six characters each: no more than the file holds.
        if count < 1.0 || count.fract() != 0.0 || count > record.len() as f64 / 6.0 {
            return Err(format!("{count} heights, which the file cannot hold"));
        }
        let count = count as usize;
        let (east, north) = (field(&"east", 25, 24)?, field(&"north", 49, 24)?);
        let datum = field(&"the datum", 73, 24)?;
        let mut heights = Vec::with_capacity(count);
        for i in 0..count {
            let column = match i.checked_sub(FIRST) {
                None => 145 + 6 * i,
                Some(later) => RECORD * (1 + later / NEXT) + 6 * (later % NEXT) + 1,
            };
            let height = field(&format_args!("height {}", i + 1), column, 6)?;
            heights.push(if height == VOID { f64::NAN } else { datum + unit * height });
        }
        let records = 1 + count.saturating_sub(FIRST).div_ceil(NEXT);
        Ok((Self { start: DVec2::new(east, north), heights }, at + records * RECORD))
    }
}

/// The characters from `column`, counted from 1.
fn field(text: &[u8], column: usize, width: usize) -> &[u8] {
    text.get(column - 1..(column - 1 + width).min(text.len())).unwrap_or_default()
}

/// A number as Fortran writes it, also `0.1D+02`.
fn number(text: &[u8], column: usize, width: usize) -> Option<f64> {
    let text = std::str::from_utf8(field(text, column, width)).ok()?.trim();
    text.replace(['D', 'd'], "E").parse().ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A DEM of three profiles of which the middle one starts a row farther north; `count` heights in the last one.
    fn dem(count: usize) -> Vec<u8> {
        let mut text = vec![b' '; RECORD];
        let put = |text: &mut Vec<u8>, column: usize, value: &str| {
            text[column - 1..][..value.len()].copy_from_slice(value.as_bytes())
        };
        put(&mut text, 817, "0.300000E+020.200000E+020.500000E+00");
        put(&mut text, 853, &format!("{:6}{:6}", 1, 3));
        for (column, (start, heights)) in [(100, 2), (120, 1), (100, count)].into_iter().enumerate() {
            let mut profile = vec![b' '; RECORD * (1 + heights.saturating_sub(FIRST).div_ceil(NEXT))];
            put(&mut profile, 1, &format!("{:6}{:6}{heights:6}{:6}", 1, column + 1, 1));
            put(
                &mut profile,
                25,
                &format!(
                    "{:24}{:24}{:24}",
                    format!("{}.D0", 1000 + 30 * column),
                    format!("0.{start}D+03"),
                    "0.1D+02"
                ),
            );
            for i in 0..heights {
                let at = if i < FIRST {
                    145 + 6 * i
                } else {
                    RECORD * (1 + (i - FIRST) / NEXT) + 6 * ((i - FIRST) % NEXT) + 1
                };
                put(
                    &mut profile,
                    at,
                    &format!("{:6}", if i == 1 { -32767 } else { (10 * column + i) as i32 }),
                );
            }
            text.extend(profile);
        }
        text
    }

    #[test]
    fn profiles_stand_where_they_start() {
        let terrain = parse(&dem(2)).unwrap();
        assert_eq!(
            (terrain.south_west, terrain.spacing),
            (DVec2::new(1000.0, 100.0), DVec2::new(30.0, 20.0))
        );
        assert_eq!(terrain.size(), [3, 2]);
        // Row 0: profiles 1 and 3; row 1: profile 2; heights are half metres above 10.
        let found: Vec<_> = terrain.heights.iter().map(|height| format!("{height}")).collect();
        assert_eq!(found, ["10", "NaN", "20", "NaN", "15", "NaN"]);
    }

    #[test]
    fn heights_come_in_the_unit_of_the_map() {
        for (ground, height, expected) in
            [("2", "1", 10.0 * 0.3048), ("1", "2", 10.0 / 0.3048), ("2", "2", 10.0), ("3", "2", 10.0)]
        {
            let mut text = dem(2);
            text[533..534].copy_from_slice(ground.as_bytes());
            text[539..540].copy_from_slice(height.as_bytes());
            // 1e-6: rounding of f32.
            assert!((f64::from(parse(&text).unwrap().heights[0]) / expected - 1.0).abs() < 1e-6);
        }
    }

    #[test]
    fn long_profiles_go_on_in_the_next_records() {
        let count = FIRST + 2 * NEXT + 5;
        let with_lines: Vec<u8> =
            dem(count).chunks(RECORD).flat_map(|record| [record, b"\r\n"].concat()).collect();
        for text in [dem(count), with_lines] {
            let terrain = parse(&text).unwrap();
            let last = |row: usize| terrain.heights[row * 3 + 2];
            let rows = [0, FIRST - 1, FIRST, FIRST + NEXT - 1, FIRST + NEXT, count - 1];
            assert_eq!(rows.map(last), rows.map(|row| 10.0 + 0.5 * (20 + row) as f32));
        }
    }

    #[test]
    fn what_is_wrong_is_named() {
        let cut = dem(2);
        assert!(parse(&cut[..2 * RECORD + 100]).is_err());
        let message = |change: &dyn Fn(&mut Vec<u8>)| {
            let mut text = dem(2);
            change(&mut text);
            parse(&text).unwrap_err()
        };
        let number = message(&|text| text[3 * RECORD + 144..][..6].copy_from_slice(b"   abc"));
        assert!(number.contains("profile 3 of 3") && number.contains("height 1 is \"   abc\""), "{number}");
        let count = message(&|text| text[RECORD + 12..][..6].copy_from_slice(b"999999"));
        assert!(count.contains("profile 1 of 3") && count.contains("999999 heights"), "{count}");
        let apart = message(&|text| text[2 * RECORD + 48..][..8].copy_from_slice(b"0.10D+13"));
        assert!(apart.contains("too far from each other"), "{apart}");
    }
}
