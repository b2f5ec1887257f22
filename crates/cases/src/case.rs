use std::fmt;
use std::str::FromStr;

use meniscus_core::{Cancel, UpAxis};

use crate::dam_break::DamBreak;
use crate::fjord::Fjord;
use crate::fjord_ground;
use crate::flow::{FillOptions, fill};
use crate::sphere_entry::SphereEntry;

/// An analytic stand-in for a published case. Metres and seconds, z up.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Case {
    /// A sphere of 1.27 cm radius enters the water of a 30 x 50 x 60 cm tank at 2.17 m/s: cavity, crown, jet. The sphere
    /// itself is not among the particles.
    SphereEntry,
    /// A column 1.228 m long, 1 m wide and 0.55 m high collapses and runs along a tank of 3.22 m: front, run-up on the far
    /// wall, splash, return wave. Dimensions of the dam break of Kleefsman et al., *J. Comput. Phys.* 206, 2005.
    DamBreak,
    /// A wave with crest and trough travels along a winding fjord some 10 km long and 600 m wide at map coordinates around
    /// x = 500,000 m, y = 3,400,000 m, with spray where it is made and on its crest.
    FjordTsunami,
}

/// Size and seed of a series.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct CaseOptions {
    /// Particles per frame, 1 to [`CaseOptions::MAX_PARTICLES`].
    pub particles: u64,
    /// Frames that the event is cut into, >= 1: the first shows its begin and the last its end; a single frame shows its
    /// middle.
    pub frames: usize,
    /// Decides jitter and droplets.
    pub seed: u64,
}

/// One generated frame; all arrays have one entry per particle and the same order in every frame.
#[derive(Clone, Debug, PartialEq)]
pub struct CaseFrame {
    /// File space, m.
    pub positions: Vec<[f64; 3]>,
    /// m/s: the exact motion's, jitter included.
    pub velocities: Vec<[f32; 3]>,
    /// kg/m^3, raw as an SPH sum gives it: 1000 inside, half of it at the free surface, a third in droplets.
    pub density: Vec<f32>,
    /// Pa, hydrostatic.
    pub pressure: Vec<f32>,
    /// Stable through time.
    pub ids: Vec<i64>,
    /// s.
    pub time: f64,
    /// Distance of neighbours, m: the cube root of the volume per particle.
    pub spacing: f64,
}

/// Heights of the land around the water, over a square grid.
#[derive(Clone, Debug, PartialEq)]
pub struct Ground {
    /// x and y of the south-western point, file space, m.
    pub south_west: [f64; 2],
    /// Distance of neighbouring points, m.
    pub spacing: f64,
    /// Points from west to east.
    pub columns: usize,
    /// z, file space, m: west to east in rows from south to north.
    pub heights: Vec<f32>,
}

/// Why a case cannot be made.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum CaseError {
    /// No case of that name.
    #[error("unknown case '{0}': expected sphere-entry, dam-break or fjord-tsunami")]
    UnknownCase(String),
    /// Particle number out of range.
    #[error("{found} particles: expected 1 to {max}", max = CaseOptions::MAX_PARTICLES)]
    Particles {
        /// The number given.
        found: u64,
    },
    /// A series without frames.
    #[error("0 frames: expected at least 1")]
    NoFrames,
}

impl CaseOptions {
    /// Largest particle number; a frame then takes some 11 GB.
    pub const MAX_PARTICLES: u64 = 200_000_000;

    /// The published particle number, 60 frames, seed 1.
    pub fn published(case: Case) -> Self {
        let particles = match case {
            Case::SphereEntry => 459_472,
            Case::DamBreak => 1_131_712,
            Case::FjordTsunami => 17_988_089,
        };
        Self { particles, frames: 60, seed: 1 }
    }

    /// Checks the ranges.
    ///
    /// # Errors
    /// [`CaseError::Particles`] or [`CaseError::NoFrames`].
    pub fn validate(&self) -> Result<(), CaseError> {
        if !(1..=Self::MAX_PARTICLES).contains(&self.particles) {
            return Err(CaseError::Particles { found: self.particles });
        }
        if self.frames == 0 { Err(CaseError::NoFrames) } else { Ok(()) }
    }
}

impl Case {
    /// Every case.
    pub const ALL: [Self; 3] = [Self::SphereEntry, Self::DamBreak, Self::FjordTsunami];

    /// Name on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::SphereEntry => "sphere-entry",
            Self::DamBreak => "dam-break",
            Self::FjordTsunami => "fjord-tsunami",
        }
    }

    /// Which axis points up.
    pub fn up(self) -> UpAxis {
        UpAxis::Z
    }

    /// How long the event takes, s.
    pub fn duration(self) -> f64 {
        match self {
            Self::SphereEntry => 0.4,
            Self::DamBreak => 2.0,
            Self::FjordTsunami => 200.0,
        }
    }

    /// The land that the water stands on, where it is no tank.
    pub fn ground(self) -> Option<Ground> {
        match self {
            Self::SphereEntry | Self::DamBreak => None,
            Self::FjordTsunami => Some(fjord_ground::ground()),
        }
    }

    /// Volume of the water, m^3; the same at all times.
    pub fn volume(self) -> f64 {
        match self {
            Self::SphereEntry => SphereEntry::volume(),
            Self::DamBreak => DamBreak::volume(),
            Self::FjordTsunami => Fjord::volume(),
        }
    }

    /// Distance of neighbours, m: the cube root of the volume per particle.
    pub fn spacing(self, options: &CaseOptions) -> f64 {
        (self.volume() / options.particles.max(1) as f64).cbrt()
    }

    /// Time of frame `index`, s.
    pub fn time(self, options: &CaseOptions, index: usize) -> f64 {
        match options.frames {
            0 | 1 => self.duration() * 0.5,
            frames => self.duration() * index as f64 / (frames - 1) as f64,
        }
    }

    /// Frame `index`, 0 to `options.frames - 1`. A series is made faster through [`crate::CaseSource`] or
    /// [`crate::CaseSource::case_frame`], which lay the particles out once.
    pub fn frame(self, options: &CaseOptions, index: usize) -> CaseFrame {
        CaseFlow::new(self, options).frame(self, options, index, &Cancel::default())
    }
}

impl fmt::Display for Case {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}

impl FromStr for Case {
    type Err = CaseError;

    fn from_str(name: &str) -> Result<Self, CaseError> {
        Self::ALL
            .into_iter()
            .find(|case| case.name() == name)
            .ok_or_else(|| CaseError::UnknownCase(name.to_owned()))
    }
}

/// The particles of a case, laid out for one particle number.
pub(crate) enum CaseFlow {
    SphereEntry(SphereEntry),
    DamBreak(DamBreak),
    Fjord(Fjord),
}

impl CaseFlow {
    pub(crate) fn new(case: Case, options: &CaseOptions) -> Self {
        let (particles, spacing) = (options.particles, case.spacing(options));
        match case {
            Case::SphereEntry => Self::SphereEntry(SphereEntry::new(particles, spacing)),
            Case::DamBreak => Self::DamBreak(DamBreak::new(particles, spacing, case.duration())),
            Case::FjordTsunami => Self::Fjord(Fjord::new(particles, spacing)),
        }
    }

    /// Frame `index`; incomplete where `cancel` was raised.
    pub(crate) fn frame(
        &self,
        case: Case,
        options: &CaseOptions,
        index: usize,
        cancel: &Cancel,
    ) -> CaseFrame {
        let fill_options = FillOptions {
            seed: options.seed,
            spacing: case.spacing(options),
            time: case.time(options, index),
            time_step: case.duration() * 1e-4,
            cancel,
        };
        match self {
            Self::SphereEntry(flow) => fill(flow, &fill_options),
            Self::DamBreak(flow) => fill(flow, &fill_options),
            Self::Fjord(flow) => fill(flow, &fill_options),
        }
    }
}
