//! Values of flags, each with its own reading and its own words when it cannot be read.

use std::fmt;
use std::ops::RangeInclusive;
use std::str::FromStr;

use glam::DVec3;
use meniscus_cases::Case;
use meniscus_prefetch::MemoryLimit;

/// A positive, finite number.
pub fn positive(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(value) if value > 0.0 && value.is_finite() => Ok(value),
        _ => Err("expected a positive number".into()),
    }
}

/// Limits of colours, `MIN,MAX`, of which one may be left empty.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ColorRange(pub [Option<f64>; 2]);

impl FromStr for ColorRange {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let expected = || "expected MIN,MAX as in 0,2.5, of which one may be left empty as in 0,".to_owned();
        let limit = |text: &str| match text.trim() {
            "" => Ok(None),
            number => number.parse().ok().filter(|x: &f64| x.is_finite()).map(Some).ok_or_else(expected),
        };
        let (min, max) = text.split_once(',').ok_or_else(expected)?;
        match (limit(min)?, limit(max)?) {
            (None, None) => Err(expected()),
            (Some(min), Some(max)) if min > max => Err(format!("{min} is larger than {max}")),
            limits => Ok(Self(limits.into())),
        }
    }
}

/// `--foam`: an amount, 0 for `off`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FoamAmount(pub f32);

impl FromStr for FoamAmount {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        match text.parse() {
            _ if text == "off" => Ok(Self(0.0)),
            Ok(amount) if (0.0..=10.0).contains(&amount) => Ok(Self(amount)),
            _ => Err("expected 0 to 10 (1 is the usual amount), or off".into()),
        }
    }
}

/// The share of the time between two pictures that a shutter is open for.
pub fn shutter(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(value) if value > 0.0 && value <= 1.0 => Ok(value),
        _ => Err("expected a number above 0, at most 1".into()),
    }
}

/// 8 or 16.
pub fn bits(text: &str) -> Result<u8, String> {
    match text {
        "8" => Ok(8),
        "16" => Ok(16),
        _ => Err("expected 8 or 16".into()),
    }
}

/// `--bitrate`: bits per second, with k or M.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BitRate(pub u32);

impl FromStr for BitRate {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let wrong = || "expected bits per second from 10k to 200M, like 8M or 500k".to_owned();
        let (number, unit) = match text.strip_suffix(['M', 'm']) {
            Some(number) => (number, 1e6),
            None => text.strip_suffix(['k', 'K']).map_or((text, 1.0), |number| (number, 1e3)),
        };
        let bits = positive(number).map_err(|_| wrong())? * unit;
        // What H.264 allows at most is 240 M, and no film is worth less than the least.
        if (1e4..=2e8).contains(&bits) { Ok(Self(bits as u32)) } else { Err(wrong()) }
    }
}

/// `--shard i/n`, `i` from 1.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Shard {
    /// From 0.
    pub index: usize,
    /// At least 1.
    pub count: usize,
}

impl FromStr for Shard {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let wrong = || "expected I/N with I from 1 to N, e.g. 1/3, 2/3 and 3/3".to_owned();
        let (number, count) = text.split_once('/').ok_or_else(wrong)?;
        let parse = |text: &str| text.trim().parse::<usize>().map_err(|_| wrong());
        let (number, count) = (parse(number)?, parse(count)?);
        if (1..=count).contains(&number) { Ok(Self { index: number - 1, count }) } else { Err(wrong()) }
    }
}

/// `WxH` in pixels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ImageSize(pub [u32; 2]);

impl FromStr for ImageSize {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let wrong = || "expected WIDTHxHEIGHT in pixels, each from 1 to 16384, e.g. 1920x1080".to_owned();
        let (w, h) = text.split_once(['x', 'X']).ok_or_else(wrong)?;
        let side =
            |s: &str| s.trim().parse::<u32>().ok().filter(|v| (1..=16384).contains(v)).ok_or_else(wrong);
        Ok(Self([side(w)?, side(h)?]))
    }
}

impl fmt::Display for ImageSize {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}x{}", self.0[0], self.0[1])
    }
}

/// `--lod`: how much is drawn.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Detail {
    /// This fraction of the particles.
    Threshold(f32),
    /// As little as cannot be told from all.
    Auto,
    /// As much as this many pictures per second allow.
    Rate(f64),
}

impl FromStr for Detail {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let wrong = || "expected a fraction from 0 to 1, auto, or a rate like 30fps".to_owned();
        if text == "auto" {
            return Ok(Self::Auto);
        }
        match text.strip_suffix("fps") {
            Some(rate) => positive(rate).map(Self::Rate).map_err(|_| wrong()),
            // Its range is checked with all other parameters.
            None => text.parse().map(Self::Threshold).map_err(|_| wrong()),
        }
    }
}

impl fmt::Display for Detail {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Threshold(threshold) => write!(f, "{threshold}"),
            Self::Auto => f.write_str("auto"),
            Self::Rate(rate) => write!(f, "{rate}fps"),
        }
    }
}

/// `A..B`, both ends included and either left out.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FrameRange {
    first: usize,
    last: Option<usize>,
}

impl FrameRange {
    /// The frames of a series of `count` frames.
    ///
    /// # Errors
    /// In words, when the range reaches past the end.
    pub fn within(self, count: usize) -> Result<RangeInclusive<usize>, String> {
        let last = self.last.unwrap_or(count.saturating_sub(1));
        if self.first >= count || last >= count {
            return Err(format!(
                "--frames reaches to {}, the series has frames 0 to {}",
                last.max(self.first),
                count.max(1) - 1
            ));
        }
        Ok(self.first..=last)
    }
}

impl FromStr for FrameRange {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let wrong =
            || "expected A..B with A <= B, frame numbers from 0; either end may be left out".to_owned();
        let (a, b) = text.split_once("..").ok_or_else(wrong)?;
        let number = |s: &str| s.trim().parse::<usize>().map_err(|_| wrong());
        let first = if a.trim().is_empty() { 0 } else { number(a)? };
        let last = if b.trim().is_empty() { None } else { Some(number(b.trim().trim_start_matches('='))?) };
        if last.is_some_and(|last| last < first) {
            return Err(wrong());
        }
        Ok(Self { first, last })
    }
}

/// `--camera`: all in the file's coordinates.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CameraValue {
    /// Eye.
    pub eye: DVec3,
    /// Point looked at.
    pub target: DVec3,
    /// Up direction.
    pub up: DVec3,
    /// Vertical field of view, degrees.
    pub fovy_deg: f64,
}

impl FromStr for CameraValue {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let wrong = |what: &str| {
            format!(
                "{what}; expected eye/target/up/fovy as ex,ey,ez/tx,ty,tz/ux,uy,uz/degrees, e.g. 1,2,3/0,0,0/0,0,1/40"
            )
        };
        let parts: Vec<_> = text.split('/').collect();
        let [eye, target, up, fovy] = parts[..] else {
            return Err(wrong(&format!("found {} parts between slashes", parts.len())));
        };
        let vector = |name: &str, s: &str| {
            let numbers: Option<Vec<f64>> = s.split(',').map(|n| n.trim().parse().ok()).collect();
            match numbers.as_deref() {
                Some(&[x, y, z]) if [x, y, z].iter().all(|v| v.is_finite()) => Ok(DVec3::new(x, y, z)),
                _ => Err(wrong(&format!("{name} `{s}` is not three finite numbers"))),
            }
        };
        let fovy_deg = fovy.trim().parse::<f64>().ok().filter(|f| *f > 0.1 && *f < 175.0);
        Ok(Self {
            eye: vector("the eye", eye)?,
            target: vector("the target", target)?,
            up: vector("the up vector", up)?,
            fovy_deg: fovy_deg
                .ok_or_else(|| wrong(&format!("the field of view `{fovy}` is not between 0.1 and 175")))?,
        })
    }
}

/// `--unit`: metres per unit of the file.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Unit(pub f64);

impl FromStr for Unit {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        Ok(Self(match text {
            "m" => 1.0,
            "cm" => 0.01,
            "mm" => 0.001,
            other => {
                positive(other).map_err(|_| "expected m, cm, mm, or the metres that one unit stands for")?
            }
        }))
    }
}

/// `--sun`: azimuth and elevation in degrees.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SunValue(pub [f32; 2]);

impl FromStr for SunValue {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let wrong = || "expected azimuth and elevation in degrees, e.g. 135,40".to_owned();
        let (azimuth, elevation) = text.split_once(',').ok_or_else(wrong)?;
        let number = |text: &str| text.trim().parse::<f32>().ok().filter(|n| n.is_finite()).ok_or_else(wrong);
        let (azimuth, elevation) = (number(azimuth)?, number(elevation)?);
        if elevation <= 0.0 || elevation > 90.0 {
            return Err("the sun must stand above the horizon, at most at 90 degrees".into());
        }
        Ok(Self([azimuth, elevation]))
    }
}

/// `--exposure`: stops, or `auto`, which is none.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ExposureValue(pub Option<f32>);

impl FromStr for ExposureValue {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        if text == "auto" {
            return Ok(Self(None));
        }
        let stops = text.parse::<f32>().ok().filter(|stops| (-20.0..=20.0).contains(stops));
        stops.map(|stops| Self(Some(stops))).ok_or_else(|| "expected auto, or -20 to 20 stops".into())
    }
}

/// `--param`: `list`, or a key and its value.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Parameter {
    /// Print all parameters.
    List,
    /// Set one.
    Set {
        /// Path, `stage.name`.
        key: String,
        /// Its new value as text.
        value: String,
    },
}

impl FromStr for Parameter {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        if text == "list" {
            return Ok(Self::List);
        }
        match text.split_once('=') {
            Some((key, value)) if !key.trim().is_empty() => {
                Ok(Self::Set { key: key.trim().to_owned(), value: value.trim().to_owned() })
            }
            _ => Err("expected KEY=VALUE, e.g. post.exposure=1.5, or `list`".into()),
        }
    }
}

/// `--memory`: a share of the free memory, or bytes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MemorySize(pub MemoryLimit);

impl FromStr for MemorySize {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        if let Some(bytes) = bytes(text) {
            return Ok(Self(MemoryLimit::Bytes(bytes)));
        }
        let share = text.trim().parse().ok().filter(|share| *share > 0.0 && *share <= 1.0);
        let wrong = || "expected a share above 0 and at most 1, or bytes like 500MB or 2GiB".to_owned();
        Ok(Self(MemoryLimit::Share(share.ok_or_else(wrong)?)))
    }
}

/// `--gpu-memory`: bytes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ByteCount(pub u64);

impl FromStr for ByteCount {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        bytes(text).map(Self).ok_or_else(|| "expected bytes like 500MB, 2GiB or 0B".to_owned())
    }
}

/// A number of bytes with its unit.
fn bytes(text: &str) -> Option<u64> {
    const UNITS: [(&str, f64); 7] = [
        ("KiB", 1024.0),
        ("MiB", 1048576.0),
        ("GiB", 1073741824.0),
        ("kB", 1e3),
        ("MB", 1e6),
        ("GB", 1e9),
        ("B", 1.0),
    ];
    let (count, factor) = UNITS.iter().find_map(|(name, factor)| Some((text.strip_suffix(name)?, factor)))?;
    let count = count.trim().parse::<f64>().ok().filter(|n| n.is_finite() && *n >= 0.0)?;
    Some((count * factor) as u64)
}

/// `--medium`: how fast files come.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum MediumSpeed {
    /// Bytes per second.
    Rate(f64),
    /// Time for a frame, in times of drawing one.
    DrawTimes(f64),
}

impl FromStr for MediumSpeed {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        match text.strip_suffix('x') {
            Some(factor) => positive(factor).map(Self::DrawTimes),
            None => positive(text).map(|megabytes| Self::Rate(megabytes * 1e6)),
        }
        .map_err(|_| "expected MB per second, like 80, or times of drawing a frame, like 0.9x".to_owned())
    }
}

/// A case of `make`.
#[derive(Clone, Copy, Debug)]
pub struct CaseName(pub Case);

impl FromStr for CaseName {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        text.parse().map(Self).map_err(|_| "expected sphere-entry, dam-break or fjord-tsunami".to_owned())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_sun_stands_above_the_horizon() {
        assert_eq!("135, 40.5".parse(), Ok(SunValue([135.0, 40.5])));
        assert_eq!("-30,90".parse(), Ok(SunValue([-30.0, 90.0])));
        for bad in ["", "135", "135,0", "0,-5", "0,91", "nan,45", "0,inf", "1,2,3"] {
            assert!(bad.parse::<SunValue>().is_err(), "{bad}");
        }
    }

    #[test]
    fn bit_rates_and_shards() {
        assert_eq!(("8M".parse(), "500k".parse()), (Ok(BitRate(8_000_000)), Ok(BitRate(500_000))));
        assert_eq!("2.5m".parse(), Ok(BitRate(2_500_000)));
        for bad in ["", "M", "-1M", "1", "1e9M", "8Mbit"] {
            assert!(bad.parse::<BitRate>().is_err(), "{bad}");
        }
        assert_eq!("3/3".parse(), Ok(Shard { index: 2, count: 3 }));
        for bad in ["0/3", "4/3", "1/0", "1", "a/b", "-1/3"] {
            assert!(bad.parse::<Shard>().is_err(), "{bad}");
        }
    }

    #[test]
    fn sizes() {
        assert_eq!("1280x720".parse(), Ok(ImageSize([1280, 720])));
        for bad in ["1280", "0x5", "5x-1", "20000x10", "ax b", ""] {
            assert!(bad.parse::<ImageSize>().is_err(), "{bad}");
        }
    }

    #[test]
    fn detail_is_a_fraction_automatic_or_a_rate() {
        for (text, detail) in
            [("0.3", Detail::Threshold(0.3)), ("auto", Detail::Auto), ("30fps", Detail::Rate(30.0))]
        {
            assert_eq!(text.parse(), Ok(detail));
            assert_eq!(detail.to_string(), text);
        }
        for bad in ["", "much", "fps", "-3fps", "nanfps", "0.3x"] {
            assert!(bad.parse::<Detail>().is_err(), "{bad}");
        }
    }

    #[test]
    fn frame_ranges_include_their_end_and_stay_inside() {
        let range = |text: &str| text.parse::<FrameRange>().unwrap().within(20);
        assert_eq!(range("2..5"), Ok(2..=5));
        assert_eq!(range(".."), Ok(0..=19));
        assert_eq!(range("7.."), Ok(7..=19));
        assert_eq!(range("..3"), Ok(0..=3));
        assert!(range("5..20").unwrap_err().contains("0 to 19"));
        assert!("5..2".parse::<FrameRange>().is_err());
        assert!("a..2".parse::<FrameRange>().is_err());
    }

    #[test]
    fn cameras_name_the_part_that_is_wrong() {
        let camera: CameraValue = "1,2,3/0,0,0.5/0,0,1/40".parse().unwrap();
        assert_eq!(camera.target, DVec3::new(0.0, 0.0, 0.5));
        for (bad, word) in [
            ("1,2,3/0,0,0/0,0,1", "3 parts"),
            ("1,2/0,0,0/0,0,1/40", "the eye"),
            ("1,2,3/nan,0,0/0,0,1/40", "the target"),
            ("1,2,3/0,0,0/0,0,1/180", "field of view"),
        ] {
            assert!(bad.parse::<CameraValue>().unwrap_err().contains(word), "{bad}");
        }
    }

    #[test]
    fn memory_is_a_share_or_bytes() {
        let memory = |text: &str| text.parse::<MemorySize>().map(|size| size.0);
        assert_eq!(memory("0.25"), Ok(MemoryLimit::Share(0.25)));
        assert_eq!(memory("500MB"), Ok(MemoryLimit::Bytes(500_000_000)));
        assert_eq!(memory("1.5 GiB"), Ok(MemoryLimit::Bytes(3 << 29)));
        assert_eq!(memory("0B"), Ok(MemoryLimit::Bytes(0)));
        assert_eq!("2GB".parse(), Ok(ByteCount(2_000_000_000)));
        for bad in ["0", "2", "-1MB", "nan", "MB", "5 apples", ""] {
            assert!(memory(bad).is_err() && bad.parse::<ByteCount>().is_err(), "{bad}");
        }
    }

    #[test]
    fn media_have_a_rate_or_follow_drawing() {
        assert_eq!("80".parse(), Ok(MediumSpeed::Rate(80e6)));
        assert_eq!("0.9x".parse(), Ok(MediumSpeed::DrawTimes(0.9)));
        for bad in ["0", "x", "-2x", "fast", ""] {
            assert!(bad.parse::<MediumSpeed>().is_err(), "{bad}");
        }
    }

    #[test]
    fn parameters_and_units() {
        assert_eq!("list".parse(), Ok(Parameter::List));
        assert_eq!("a.b = 2".parse(), Ok(Parameter::Set { key: "a.b".into(), value: "2".into() }));
        assert!("ab".parse::<Parameter>().is_err());
        assert_eq!("mm".parse(), Ok(Unit(0.001)));
        assert_eq!("0.3048".parse(), Ok(Unit(0.3048)));
        assert!("-1".parse::<Unit>().is_err());
    }
}
