use std::str::FromStr;

use meniscus_core::{Look, UpAxis};

use crate::Error;
use crate::filter::Region;

/// How a series is read; the default leaves every choice to the data.
#[derive(Clone, Debug, Default)]
pub struct SeriesOptions {
    /// Selects the particles of the default set, by the grammar of [`crate::expression`].
    pub where_expr: Option<String>,
    /// Further sets, drawn besides the default one.
    pub sets: Vec<SetSpec>,
    /// Physical distance of neighbouring particles, file units, > 0.
    pub spacing: Option<f64>,
    /// Radius drawn, file units, > 0.
    pub radius: Option<f64>,
    /// Name of the attribute that states each particle's radius, or another measure of its size; `none`: all are alike.
    pub radius_by: Option<String>,
    /// The file axis that points up.
    pub up: Option<UpAxis>,
    /// Metres per file unit, > 0.
    pub metres_per_unit: Option<f64>,
    /// How file bytes come into memory.
    pub io_mode: IoMode,
    /// Takes every n-th particle of the input: by its id where that takes about one in n, else by its index in the file; >= 1.
    /// The particles taken stand for the others: an automatic spacing grows accordingly.
    pub every: Option<u32>,
    /// Takes the particles of the input inside this box.
    pub region: Option<Region>,
    /// Time between frames, > 0; replaces what the files state.
    pub time_step: Option<f64>,
    /// Keeps particles that are no water for sure in the default set. Else walls, moving bodies and air are hidden sets of their own,
    /// `walls`, `body` and `air`, unless [`Self::where_expr`] or a set `water` says what the default set is.
    pub keep_others: bool,
    /// Keeps points that the file marks as ghosts: copies of a neighbouring process' points, or hidden ones.
    pub keep_ghosts: bool,
}

/// How file bytes come into memory.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum IoMode {
    /// Maps local files at rest; reads those of network file systems and those modified in the last seconds.
    #[default]
    Auto,
    /// Maps every file.
    Map,
    /// Reads every file, block by block.
    Read,
}

impl FromStr for IoMode {
    type Err = Error;

    fn from_str(text: &str) -> Result<Self, Error> {
        match text {
            "auto" => Ok(Self::Auto),
            "map" => Ok(Self::Map),
            "read" => Ok(Self::Read),
            _ => Err(Error::usage(format_args!("--io {text:?}; expected auto, map or read"))),
        }
    }
}

impl SeriesOptions {
    /// Refuses lengths that are none.
    pub(crate) fn validate(&self) -> Result<(), Error> {
        let numbers = [
            ("--spacing", self.spacing),
            ("--radius", self.radius),
            ("--unit", self.metres_per_unit),
            ("--dt", self.time_step),
        ];
        for (flag, number) in numbers {
            if let Some(number) = number.filter(|number| !(number.is_finite() && *number > 0.0)) {
                return Err(Error::usage(format_args!("{flag} is {number}; give a number above 0")));
            }
        }
        if self.every == Some(0) {
            return Err(Error::usage("--every is 0; give 1 for all particles, 2 for every other one"));
        }
        if self.sets.len() > MAX_SETS {
            return Err(Error::usage(format_args!("{} sets; give at most {MAX_SETS}", self.sets.len())));
        }
        for (i, set) in self.sets.iter().enumerate() {
            if self.sets[..i].iter().any(|other| other.name == set.name) {
                return Err(Error::usage(format_args!("--set {} is given twice; use two names", set.name)));
            }
        }
        Ok(())
    }
}

/// Sets are numbered in a byte while particles are told apart, and one of its values means none.
const MAX_SETS: usize = 200;

/// A set of particles as the user writes it: `NAME=PATTERN[:LOOK]`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SetSpec {
    /// Its name; `water` replaces the default set.
    pub name: String,
    /// A selection of the input's particles ([`crate::expression`]), or other files: a file, a series, a glob, a folder.
    pub pattern: String,
    /// How it is drawn.
    pub look: Look,
}

/// The names of looks on the command line.
const LOOKS: [(&str, Look); 4] =
    [("water", Look::Water), ("solid", Look::Solid), ("spheres", Look::Spheres), ("hidden", Look::Hidden)];

impl SetSpec {
    /// Parses `NAME=PATTERN[:LOOK]`; the look is `water` when left out.
    ///
    /// # Errors
    /// [`Error::Usage`] when the name or the pattern is missing.
    pub fn parse(text: &str) -> Result<Self, Error> {
        let fail = |what: &str| {
            Err(Error::usage(format_args!(
                "--set {text:?}: {what}; expected NAME=PATTERN[:LOOK], e.g. \"walls=type == 1:hidden\" or \
                 \"soil=SoilBlock_*.vtp:solid\", with the look water, solid, spheres or hidden"
            )))
        };
        let Some((name, rest)) = text.split_once('=') else { return fail("no `=`") };
        let name = name.trim();
        if name.is_empty() || !name.chars().all(|c| c.is_alphanumeric() || matches!(c, '_' | '-')) {
            return fail("the name must be letters, digits, `_` and `-`");
        }
        let (pattern, look) = rest
            .rsplit_once(':')
            .and_then(|(pattern, word)| {
                let known = LOOKS.iter().find(|(name, _)| *name == word.trim())?;
                Some((pattern, known.1))
            })
            .unwrap_or((rest, Look::Water));
        if pattern.trim().is_empty() {
            return fail("no pattern");
        }
        Ok(Self { name: name.to_owned(), pattern: pattern.trim().to_owned(), look })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sets_are_parsed() {
        let set = |text| SetSpec::parse(text).map(|s| (s.name, s.pattern, s.look)).ok();
        let expect = |name: &str, pattern: &str, look| Some((name.to_owned(), pattern.to_owned(), look));
        assert_eq!(set("walls=type == 1:hidden"), expect("walls", "type == 1", Look::Hidden));
        assert_eq!(set("soil=data/Soil_*.vtp:solid"), expect("soil", "data/Soil_*.vtp", Look::Solid));
        assert_eq!(set("b=C:/x.vtu"), expect("b", "C:/x.vtu", Look::Water));
        for bad in ["soil", "=x", "a b=x", "soil=", "soil=:solid"] {
            assert_eq!(set(bad), None, "{bad}");
        }
    }

    #[test]
    fn impossible_numbers_are_refused() {
        for number in [0.0, -1.0, f64::NAN, f64::INFINITY] {
            let spacing = SeriesOptions { spacing: Some(number), ..Default::default() };
            let time_step = SeriesOptions { time_step: Some(number), ..Default::default() };
            assert!(spacing.validate().is_err() && time_step.validate().is_err(), "{number}");
        }
        assert!(SeriesOptions { every: Some(0), ..Default::default() }.validate().is_err());
    }

    #[test]
    fn modes_are_parsed() {
        assert_eq!("map".parse::<IoMode>().ok(), Some(IoMode::Map));
        assert!("mmap".parse::<IoMode>().is_err());
    }
}
