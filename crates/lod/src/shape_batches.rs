//! Which particles get shapes of their own, and which are near enough to those to shape them.

use meniscus_core::Aabb;
use meniscus_gpu::role::KeptRange;

use crate::{Chunk, ChunkedSet};

/// Shells of neighbouring chunks, and all particles that may be near them.
#[derive(Clone, Debug, PartialEq)]
pub struct ShapeBatch {
    /// Box around the centres of the chunks whose shells these are, world.
    pub bounds: Aabb,
    /// The shells, for each page of the set; each range says where its shapes go.
    pub targets: Vec<Vec<KeptRange>>,
    /// What may be near them, for each page.
    pub sources: Vec<Vec<KeptRange>>,
    /// How many particles that are.
    pub source_particles: usize,
}

/// The shells of `set` in batches of chunks that together have at most about `most_particles` particles, with all particles up to
/// `support_world` around them.
pub fn shape_batches(set: &ChunkedSet, support_world: f32, most_particles: usize) -> Vec<ShapeBatch> {
    let with_shell: Vec<&Chunk> = set.chunks.iter().filter(|chunk| chunk.shell > 0).collect();
    let mut rest = with_shell.as_slice();
    let mut batches = Vec::new();
    while !rest.is_empty() {
        let mut particles = 0;
        let fits = |chunk: &&&Chunk| {
            particles += chunk.count as usize;
            particles <= most_particles
        };
        let (of_batch, others) = rest.split_at(rest.iter().take_while(fits).count().max(1));
        batches.push(batch(set, of_batch, support_world));
        rest = others;
    }
    batches
}

fn batch(set: &ChunkedSet, of_batch: &[&Chunk], support_world: f32) -> ShapeBatch {
    let bounds = of_batch.iter().fold(Aabb::EMPTY, |bounds, chunk| bounds.union(chunk.bounds));
    let near = bounds.inflated(support_world);
    let is_near =
        |chunk: &Chunk| near.min.cmple(chunk.bounds.max).all() && near.max.cmpge(chunk.bounds.min).all();
    let pages = set.pages().len();
    let mut batch = ShapeBatch {
        bounds,
        targets: vec![Vec::new(); pages],
        sources: vec![Vec::new(); pages],
        source_particles: 0,
    };
    let keep = KeptRange::KEEP_ALL;
    for chunk in of_batch {
        let first = chunk.first + chunk.isolated;
        let range = KeptRange { first, count: chunk.shell, keep, shape: 1 + chunk.first_shape };
        batch.targets[chunk.page as usize].push(range);
    }
    for chunk in set.chunks.iter().filter(|chunk| is_near(chunk)) {
        let range = KeptRange { first: chunk.first, count: chunk.count, keep, shape: 0 };
        batch.sources[chunk.page as usize].push(range);
        batch.source_particles += chunk.count as usize;
    }
    batch
}
