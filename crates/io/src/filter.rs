//! Which points of the input are taken at all, before they are shared out among sets.

use std::str::FromStr;

use meniscus_core::Cancel;
use rayon::prelude::*;

use crate::frame_data::FrameData;
use crate::scalar::{InRanges, ToU64};
use crate::{Error, SeriesOptions};

/// A box in file coordinates; its faces belong to it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Region {
    /// Lowest x, y, z.
    pub min: [f64; 3],
    /// Highest x, y, z; none below its `min`.
    pub max: [f64; 3],
}

impl FromStr for Region {
    type Err = Error;

    /// Parses `xmin,xmax,ymin,ymax,zmin,zmax`, the order of VTK's bounds; a limit left empty or `inf` does not limit.
    fn from_str(text: &str) -> Result<Self, Error> {
        let fail = |what: &str| {
            Error::usage(format_args!(
                "--box {text:?}: {what}; expected xmin,xmax,ymin,ymax,zmin,zmax in file coordinates, e.g. 0,1.5,0,1,0,inf"
            ))
        };
        let words: Vec<&str> = text.split(',').map(str::trim).collect();
        let words: [&str; 6] = words.try_into().map_err(|_| fail("not six numbers"))?;
        let (mut min, mut max) = ([f64::NEG_INFINITY; 3], [f64::INFINITY; 3]);
        for (i, word) in words.iter().enumerate().filter(|(_, word)| !word.is_empty()) {
            let limit = if i % 2 == 0 { &mut min[i / 2] } else { &mut max[i / 2] };
            *limit = word.parse().ok().filter(|v: &f64| !v.is_nan()).ok_or_else(|| fail("not a number"))?;
        }
        if std::iter::zip(min, max).any(|(min, max)| min > max) {
            return Err(fail("a lower limit above its upper one"));
        }
        Ok(Self { min, max })
    }
}

/// What is left out of the input.
#[derive(Clone, Debug, Default)]
pub(crate) struct Filter {
    every: u64,
    region: Option<Region>,
    keep_ghosts: bool,
}

impl Filter {
    pub fn new(options: &SeriesOptions) -> Self {
        Self {
            every: options.every.unwrap_or(1).into(),
            region: options.region,
            keep_ghosts: options.keep_ghosts,
        }
    }

    /// How many points each one taken stands for.
    pub fn every(&self) -> u64 {
        self.every
    }

    /// Which points are taken; `None` for all.
    pub fn mask(&self, frame: &FrameData, cancel: &Cancel) -> Result<Option<Vec<bool>>, Error> {
        let mut mask = self.without_ghosts(frame, cancel)?;
        if self.every > 1 {
            let taken = self.every_nth(frame, cancel)?;
            mask = both(mask, taken);
        }
        if let Some(Region { min, max }) = self.region {
            let inside = frame.coordinates_as(&InRanges { min, max }, cancel)?;
            let taken = inside.as_chunks::<3>().0.par_iter().map(|axes| axes.iter().all(|&a| a)).collect();
            mask = both(mask, taken);
        }
        Ok(mask)
    }

    fn every_nth(&self, frame: &FrameData, cancel: &Cancel) -> Result<Vec<bool>, Error> {
        let every = self.every;
        if let Some(ids) = frame.id_attribute() {
            let ids = frame.values(ids, &ToU64, cancel)?;
            let taken: Vec<bool> = ids.par_iter().map(|id| id.is_multiple_of(every)).collect();
            let count = taken.par_iter().filter(|taken| **taken).count() as u64;
            let expected = ids.len() as u64 / every;
            // Ids with gaps of their own, all even for example, would give all or nothing.
            if count.abs_diff(expected) <= 1 + expected / 4 {
                return Ok(taken);
            }
        }
        Ok((0..frame.points as u64).into_par_iter().map(|i| i.is_multiple_of(every)).collect())
    }

    /// Which points are no ghosts; `None` for all, or where ghosts are kept.
    pub fn without_ghosts(&self, frame: &FrameData, cancel: &Cancel) -> Result<Option<Vec<bool>>, Error> {
        if self.keep_ghosts { Ok(None) } else { frame.not_ghosts(cancel) }
    }
}

fn both(mask: Option<Vec<bool>>, taken: Vec<bool>) -> Option<Vec<bool>> {
    Some(match mask {
        None => taken,
        Some(mut mask) => {
            std::iter::zip(&mut mask, taken).for_each(|(mask, taken)| *mask &= taken);
            mask
        }
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn boxes_are_parsed() {
        let region: Region = "0, 1.5,,2,-3,inf".parse().expect("a box");
        assert_eq!(region.min, [0.0, f64::NEG_INFINITY, -3.0]);
        assert_eq!(region.max, [1.5, 2.0, f64::INFINITY]);
        for bad in ["", "1,2", "1,0,0,1,0,1", "a,1,0,1,0,1", "nan,1,0,1,0,1", "0,1,0,1,0,1,2"] {
            assert!(bad.parse::<Region>().is_err(), "{bad}");
        }
    }
}
