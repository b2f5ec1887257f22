use meniscus_color::Quantity;
use meniscus_core::{Flaws, FrameRead, Look, SetFrame};
use meniscus_lod::{ChunkOptions, ChunkedSet, FoamOptions, Identity, chunks};

use crate::colors::values_of;

/// A frame in the order the GPU wants it, made on reader threads.
#[derive(Clone, Debug)]
pub struct PreparedFrame {
    /// Index in the series.
    pub index: usize,
    /// Simulation time.
    pub time: Option<f64>,
    /// The sets that are drawn.
    pub sets: Vec<PreparedSet>,
    /// What was lost while reading.
    pub flaws: Flaws,
    /// What reading it took, where the source counts.
    pub read: Option<FrameRead>,
}

/// One set of a prepared frame.
#[derive(Clone, Debug)]
pub struct PreparedSet {
    /// Its name.
    pub name: String,
    /// How it is drawn.
    pub look: Look,
    /// Whether the file names its particles; else they are told apart by their index in it.
    pub has_ids: bool,
    /// Its particles in chunks.
    pub chunked: ChunkedSet,
    /// What it is coloured by, in the order of the chunked particles; empty where nothing is.
    pub values: Vec<f32>,
}

impl PreparedFrame {
    /// Bytes held in memory.
    pub fn bytes(&self) -> u64 {
        self.sets.iter().map(|set| set.chunked.bytes() + size_of_val(set.values.as_slice()) as u64).sum()
    }
}

/// Brings frames into chunk order; cheap to clone and to send to reader threads.
#[derive(Clone, Debug)]
pub struct Preparer {
    pub(crate) page_particles: usize,
    pub(crate) spacing_world: f32,
    pub(crate) identity: Identity,
    /// What the sets are coloured by.
    pub(crate) quantity: Option<Quantity>,
    /// What foam of the water is found by.
    pub(crate) foam: Option<FoamOptions>,
}

impl Preparer {
    /// `frame` with its drawn sets in chunks; hidden sets are dropped.
    pub fn prepare(&self, frame: SetFrame) -> PreparedFrame {
        let options = ChunkOptions {
            identity: self.identity,
            ..ChunkOptions::new(self.page_particles, self.spacing_world)
        };
        let sets = frame
            .sets
            .into_iter()
            .filter(|set| set.look != Look::Hidden)
            .map(|set| {
                let foam = self.foam.as_ref().filter(|_| set.look == Look::Water);
                let chunked = chunks::build_with_foam(&set.particles, &options, foam);
                let quantity = self.quantity.as_ref();
                let values = quantity.map(|q| values_of(&set.particles, &chunked, q)).unwrap_or_default();
                let has_ids = !set.particles.ids.is_empty();
                PreparedSet { name: set.name, look: set.look, has_ids, chunked, values }
            })
            .collect();
        PreparedFrame { index: frame.index, time: frame.time, sets, flaws: frame.flaws, read: frame.read }
    }
}
