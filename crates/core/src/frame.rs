use std::ops::RangeInclusive;
use std::path::PathBuf;

use glam::DVec3;
use serde::{Deserialize, Serialize};

use crate::{Aabb, Flaws, FrameRead};

/// What a particle set is drawn as.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Look {
    /// Translucent liquid with a smoothed surface.
    Water,
    /// Opaque smoothed surface: soil, ice.
    Solid,
    /// Every particle as a sphere.
    Spheres,
    /// Not drawn.
    Hidden,
}

/// A per-particle quantity that was asked for, converted to `f32`.
#[derive(Clone, Debug, PartialEq)]
pub struct Attribute {
    /// Name as in the file.
    pub name: String,
    /// Numbers per particle, >= 1.
    pub components: usize,
    /// `components` numbers per particle, particle after particle.
    pub values: Vec<f32>,
}

/// The particles of one set at one time, after selection and cleaning: every position is finite.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ParticleFrame {
    /// World space: file coordinates minus the series' origin, rounded to `f32` after the subtraction.
    pub positions: Vec<[f32; 3]>,
    /// Identity from frame to frame: the file's id array, else the index in the file. Either empty (identity is the index
    /// in `positions`) or as long as `positions`.
    pub ids: Vec<u64>,
    /// The attributes that were asked for, each as long as `positions`.
    pub attributes: Vec<Attribute>,
    /// Spacing and radius of each particle relative to those of the series ([`crate::SeriesSpace`]), in [`SIZES`]. Either empty
    /// (all have those of the series) or as long as `positions`.
    pub sizes: Vec<f32>,
}

/// Relative sizes that particles are drawn with. Their cubes, the volumes, are normal numbers of half precision or close to it,
/// and a single particle that is larger would be more of a picture than all others.
pub const SIZES: RangeInclusive<f32> = 0.031_25..=32.0;

impl ParticleFrame {
    /// Number of particles.
    pub fn len(&self) -> usize {
        self.positions.len()
    }

    /// Whether there is no particle.
    pub fn is_empty(&self) -> bool {
        self.positions.is_empty()
    }

    /// Identity of particle `index`.
    pub fn id(&self, index: usize) -> u64 {
        self.ids.get(index).copied().unwrap_or(index as u64)
    }

    /// Relative size of particle `index`, in [`SIZES`]: 1 where it has none, or one that is no number above 0.
    pub fn size(&self, index: usize) -> f32 {
        match self.sizes.get(index) {
            Some(&size) if size > 0.0 => size.clamp(*SIZES.start(), *SIZES.end()),
            _ => 1.0,
        }
    }

    /// Box around the particle centres.
    pub fn bounds(&self) -> Aabb {
        Aabb::of_points(&self.positions)
    }

    /// Bytes held in memory.
    pub fn bytes(&self) -> u64 {
        let attributes: usize = self.attributes.iter().map(|a| a.values.len() * 4).sum();
        (self.positions.len() * 12 + self.ids.len() * 8 + attributes + self.sizes.len() * 4) as u64
    }
}

/// A named set of particles and how it is drawn.
#[derive(Clone, Debug, PartialEq)]
pub struct ParticleSet {
    /// `water` unless the user named it.
    pub name: String,
    /// How it is drawn.
    pub look: Look,
    /// The particles.
    pub particles: ParticleFrame,
}

/// All sets of one frame, as a [`crate::FrameSource`] gives them.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SetFrame {
    /// Index in the series.
    pub index: usize,
    /// Simulation time, where the series has one; seconds by convention.
    pub time: Option<f64>,
    /// The files it was read from.
    pub files: Vec<PathBuf>,
    /// What positions are relative to, file space.
    pub origin: DVec3,
    /// The sets that are drawn or may be drawn.
    pub sets: Vec<ParticleSet>,
    /// What was lost while reading.
    pub flaws: Flaws,
    /// What reading it took, where the source counts.
    pub read: Option<FrameRead>,
}

impl SetFrame {
    /// Number of particles over all sets.
    pub fn len(&self) -> usize {
        self.sets.iter().map(|set| set.particles.len()).sum()
    }

    /// Whether no set has a particle.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Bytes held in memory.
    pub fn bytes(&self) -> u64 {
        self.sets.iter().map(|set| set.particles.bytes()).sum()
    }

    /// Box around all particles that are not hidden.
    pub fn bounds(&self) -> Aabb {
        self.sets
            .iter()
            .filter(|set| set.look != Look::Hidden)
            .fold(Aabb::EMPTY, |bounds, set| bounds.union(set.particles.bounds()))
    }
}
