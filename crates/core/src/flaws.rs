use std::fmt;

use serde::Serialize;

/// One way in which a picture is not what was asked for.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(tag = "kind", rename_all = "snake_case")]
pub enum Flaw {
    /// Points with a NaN or infinite coordinate were left out.
    NonFiniteDropped {
        /// How many.
        count: u64,
    },
    /// Particles so far from the others that `f32` cannot say where they are to the spacing were left out.
    FarDropped {
        /// How many.
        count: u64,
        /// How far away they are at least, file units.
        distance: f32,
    },
    /// Particles whose stated size is missing, no number above 0 or out of range.
    SizesReplaced {
        /// Name of the attribute that states sizes.
        attribute: String,
        /// How many.
        count: u64,
    },
    /// A software adapter drew the picture although the machine has a GPU.
    SoftwareAdapter {
        /// What was found and how to fix it.
        advice: String,
    },
    /// A frame of the series could not be read and is missing from the output.
    FrameMissing {
        /// Index in the series.
        frame: usize,
        /// The reader's error.
        reason: String,
    },
    /// The spacing was estimated from few or irregular particles.
    SpacingUncertain {
        /// What the estimate rests on.
        reason: String,
    },
    /// The data has no extent along one axis and is drawn as a thin sheet.
    Planar {
        /// The flat axis: `x`, `y` or `z`.
        axis: char,
    },
    /// Particles that look like something else are drawn as water.
    OthersDrawnAsWater {
        /// What they look like: `walls`, `body` or `air`.
        what: &'static str,
        /// The flag that hides them.
        flag: String,
    },
    /// Particles without ids change places in the file from frame to frame, which level of detail cannot follow.
    UnstableIdentity {
        /// Share of neighbouring particles that the next frame has far apart, 0..=1.
        share: f64,
    },
    /// Pictures of a film show the nearest frame of the data instead of the particles at their time.
    FramesHeld {
        /// How many.
        pictures: usize,
        /// Of how many.
        of: usize,
        /// How far from its time a picture is at most, in the time of the series.
        at_most: f64,
        /// What to do.
        advice: String,
    },
    /// Edges have steps: the filter that smooths them works on 8 bits.
    EdgesNotSmoothed,
    /// The exposure was to be metered, but the pictures that it is metered on have no light.
    NothingToMeter,
    /// Motion blur was asked for, but it is not known where particles are between frames.
    MotionNotBlurred {
        /// Why.
        reason: String,
    },
    /// Velocities of the file do not carry particles from frame to frame, so that they move in straight lines between frames.
    VelocitiesUnused,
    /// More than one particle in a hundred is in one of two frames only, or far from where it moves to, and comes or goes halfway.
    ParticlesComeAndGo,
    /// Not a single pixel shows a particle.
    NothingVisible {
        /// Why, and what to do.
        reason: String,
    },
}

impl fmt::Display for Flaw {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NonFiniteDropped { count } => {
                write!(f, "{count} points with NaN or infinite coordinates were dropped")
            }
            Self::FarDropped { count, distance } => {
                let (particles, are) = if *count == 1 { ("particle is", "it is") } else { ("particles are", "they are") };
                write!(
                    f,
                    "{count} {particles} more than {distance:.1e} away from the middle of the others; {are} not drawn. Leave such \
                     particles out with --box or --where"
                )
            }
            Self::SizesReplaced { attribute, count } => write!(
                f,
                "{count} particles have no size, or one beyond 1/32 to 32 times the usual, in {attribute:?}; they are drawn as \
                 usual, or with that limit. --radius-by chooses another attribute, or none"
            ),
            Self::SoftwareAdapter { advice } => {
                write!(f, "a software adapter draws although this machine has a GPU: {advice}")
            }
            Self::FrameMissing { frame, reason } => write!(f, "frame {frame} is missing: {reason}"),
            Self::SpacingUncertain { reason } => {
                write!(f, "the particle spacing is uncertain: {reason}; set it with --spacing")
            }
            Self::Planar { axis } => {
                write!(f, "the data is flat along {axis} and drawn as a sheet one spacing thick")
            }
            Self::OthersDrawnAsWater { what, flag } => {
                let like = if *what == "body" { "a moving body" } else { what };
                write!(f, "some particles look like {like} and are drawn as water; hide them with {flag}")
            }
            Self::UnstableIdentity { share } => write!(
                f,
                "the file has no ids and its particles change places from frame to frame ({:.0} % of neighbours part), so \
                 that a reduced level of detail flickers; write ids, or draw with --lod 1",
                100.0 * share
            ),
            Self::FramesHeld { pictures, of, at_most, advice } => write!(
                f,
                "{pictures} of {of} pictures show the nearest frame of the data, up to {at_most:.4} s from their time; {advice}"
            ),
            Self::EdgesNotSmoothed => {
                f.write_str("edges are not smoothed in pictures of more than 8 bits; add --samples 16")
            }
            Self::NothingToMeter => f.write_str(
                "the exposure is 0 stops: there is no light in the pictures that it is metered on; set it with --exposure EV",
            ),
            Self::MotionNotBlurred { reason } => write!(f, "there is no motion blur: {reason}"),
            Self::VelocitiesUnused => f.write_str(
                "the velocities do not carry particles from frame to frame; particles move in straight lines between frames. \
                 Check the times of the series (--dt)",
            ),
            Self::ParticlesComeAndGo => f.write_str(
                "more than 1 % of the particles are in one of two frames only, or jump; they come and go halfway between frames",
            ),
            Self::NothingVisible { reason } => write!(f, "the picture shows no particle: {reason}"),
        }
    }
}

/// The flaws of one picture, each listed once, in the order found.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
#[serde(transparent)]
pub struct Flaws(Vec<Flaw>);

impl Flaws {
    /// Adds `flaw` unless the same one is listed already.
    pub fn add(&mut self, flaw: Flaw) {
        if !self.0.contains(&flaw) {
            self.0.push(flaw);
        }
    }

    /// Adds all of `other`.
    pub fn merge(&mut self, other: &Self) {
        other.iter().for_each(|flaw| self.add(flaw.clone()));
    }

    /// The flaws in the order found.
    pub fn iter(&self) -> impl Iterator<Item = &Flaw> {
        self.0.iter()
    }

    /// Whether the picture is what was asked for.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }
}

impl FromIterator<Flaw> for Flaws {
    fn from_iter<I: IntoIterator<Item = Flaw>>(flaws: I) -> Self {
        let mut all = Self::default();
        flaws.into_iter().for_each(|flaw| all.add(flaw));
        all
    }
}
