//! Which points of the input are taken at all, before they are shared out among sets.

use std::str::FromStr;

use meniscus_core::Cancel;

use crate::frame_data::{Block, FrameArray, FrameData};
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

    /// The part of it that leaves out ghosts.
    pub fn ghosts_only(&self) -> Self {
        Self { every: 1, region: None, keep_ghosts: self.keep_ghosts }
    }

    /// Looks at `frame` as far as it takes to filter its blocks; `None` where all points are taken.
    pub fn of<'a>(&self, frame: &'a FrameData, cancel: &Cancel) -> Result<Option<FrameFilter<'a>>, Error> {
        let not_ghosts = self.without_ghosts(frame, cancel)?;
        let every = if self.every > 1 { Some(self.every_nth(frame, cancel)?) } else { None };
        let region = self
            .region
            .map(|Region { min, max }| Ok::<_, Error>((InRanges { min, max }, frame.positions_array()?)));
        let filter = FrameFilter { not_ghosts, every, region: region.transpose()? };
        Ok(Some(filter).filter(|f| f.not_ghosts.is_some() || f.every.is_some() || f.region.is_some()))
    }

    fn every_nth<'a>(&self, frame: &'a FrameData, cancel: &Cancel) -> Result<EveryNth<'a>, Error> {
        let mut by_id = EveryNth { every: self.every, ids: None };
        let Some(ids) = frame.id_attribute() else { return Ok(by_id) };
        by_id.ids = Some(frame.attribute_array(ids)?);
        let mut count = 0_u64;
        for block in frame.blocks() {
            count += by_id.block(&block, cancel)?.into_iter().filter(|taken| *taken).count() as u64;
        }
        let expected = frame.points as u64 / self.every;
        // Ids with gaps of their own, all even for example, would give all or nothing.
        if count.abs_diff(expected) > 1 + expected / 4 {
            by_id.ids = None;
        }
        Ok(by_id)
    }

    /// Which points are no ghosts; `None` for all, or where ghosts are kept.
    pub fn without_ghosts(&self, frame: &FrameData, cancel: &Cancel) -> Result<Option<Vec<bool>>, Error> {
        if self.keep_ghosts { Ok(None) } else { frame.not_ghosts(cancel) }
    }
}

/// A filter tied to a frame.
pub(crate) struct FrameFilter<'a> {
    /// One for each point: which are ghosts is known only when all cells were looked at.
    not_ghosts: Option<Vec<bool>>,
    every: Option<EveryNth<'a>>,
    region: Option<(InRanges, FrameArray<'a>)>,
}

impl FrameFilter<'_> {
    /// Which points of `block` are taken.
    pub fn block(&self, block: &Block, cancel: &Cancel) -> Result<Vec<bool>, Error> {
        let points = block.first..block.first + block.len();
        let mut mask = match &self.not_ghosts {
            Some(not_ghosts) => not_ghosts[points].to_vec(),
            None => vec![true; block.len()],
        };
        if let Some(every) = &self.every {
            std::iter::zip(&mut mask, every.block(block, cancel)?).for_each(|(mask, taken)| *mask &= taken);
        }
        if let Some((ranges, positions)) = &self.region {
            let inside = positions.values(block, ranges, cancel)?;
            std::iter::zip(&mut mask, inside.as_chunks::<3>().0)
                .for_each(|(mask, axes)| *mask &= axes.iter().all(|inside| *inside));
        }
        Ok(mask)
    }
}

/// Every n-th point, by its id or by its index.
struct EveryNth<'a> {
    every: u64,
    ids: Option<FrameArray<'a>>,
}

impl EveryNth<'_> {
    fn block(&self, block: &Block, cancel: &Cancel) -> Result<Vec<bool>, Error> {
        let taken = |number: u64| number.is_multiple_of(self.every);
        Ok(match &self.ids {
            Some(ids) => ids.values(block, &ToU64, cancel)?.into_iter().map(taken).collect(),
            None => (block.first..block.first + block.len()).map(|index| taken(index as u64)).collect(),
        })
    }
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
