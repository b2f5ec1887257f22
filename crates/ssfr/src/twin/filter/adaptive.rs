use super::image::Source;
use super::smoothing::smooth;
use crate::filter::{AdaptiveParams, HostSurface, Rule, TILE};
use crate::twin::HostView;

/// Bilateral in simple tiles, narrow-range in complex ones (`main-renderer.md` 5.4).
pub fn adaptive(view: &HostView, params: &AdaptiveParams, surface: &HostSurface<'_>) -> Vec<f32> {
    let source = Source { view, surface };
    let complexity = Complexity::measure(&source, params);
    smooth(&source, &params.width(), Rule::Adaptive, |pixel| complexity.at(half_px_in_tiles(&source, pixel)))
}

/// Place of a pixel in half pixels from the first tile's corner; the tiles lie around the middle of the picture.
fn half_px_in_tiles(source: &Source<'_>, pixel: usize) -> [i64; 2] {
    let at = source.place(pixel);
    [0, 1].map(|axis| {
        let side = source.view.size_px[axis];
        side.next_multiple_of(TILE as usize) as i64 + 2 * at[axis] + 1 - side as i64
    })
}

/// Of each tile, row by row; `None` where nothing was measured.
struct Complexity {
    tiles: [usize; 2],
    of_tiles: Vec<Option<f64>>,
}

#[derive(Clone, Copy, Default)]
struct Sums {
    measured: u32,
    edges: u32,
    /// Of the others, in steps of a 256th of a radius.
    bends: f64,
}

impl Complexity {
    fn measure(source: &Source<'_>, params: &AdaptiveParams) -> Self {
        let keys = source.keys();
        let tiles = source.view.size_px.map(|side| side.div_ceil(TILE as usize));
        let mut sums = vec![Sums::default(); tiles[0] * tiles[1]];
        for (pixel, key) in keys.iter().enumerate() {
            let Some(center) = *key else { continue };
            let spacing_px = source.spacings_px(1.0, pixel, source.distance(center));
            let place = half_px_in_tiles(source, pixel);
            // Every other row and column, counted from the borders; pixels right between two tiles belong to none.
            let is_skipped = (0..2)
                .any(|axis| source.room(pixel, axis) % 2 == 1 || place[axis] % (2 * i64::from(TILE)) == 0);
            if is_skipped || spacing_px <= 0.0 {
                continue;
            }
            let wanted = spacing_px.round_ties_even().max(1.0) as i64;
            // How far the middle lies off the line between samples on both sides; none beside a gap.
            let bends = [[1, 0], [0, 1]].map(|axis: [i64; 2]| {
                let reach = wanted.min(source.room(pixel, axis[1] as usize));
                let [after, before] = source.pair(pixel, axis.map(|a| a * reach)).expect("there is room");
                Some((0.5 * (keys[after]? + keys[before]?) - center).abs())
            });
            let per_radius = (source.radius(pixel) * source.key_per_distance(center)).max(1e-30);
            let radii = bends[0].zip(bends[1]).map(|(x, y)| x.max(y) / per_radius);
            let [column, row] = place.map(|half_px| half_px as usize / (2 * TILE as usize));
            let tile = &mut sums[row * tiles[0] + column];
            tile.measured += 1;
            match radii.filter(|&radii| radii <= f64::from(params.threshold)) {
                Some(radii) => tile.bends += (256.0 * radii.min(16.0)).round_ties_even(),
                None => tile.edges += 1,
            }
        }
        let of_tiles = sums.iter().map(|sums| {
            let edges = f64::from(sums.edges) / f64::from(sums.measured);
            let bend = sums.bends / 256.0 / f64::from((sums.measured - sums.edges).max(1));
            let reached = (edges / f64::from(params.edges)).max(bend / f64::from(params.bend));
            (sums.measured > 0).then_some((2.0 * reached - 1.0).clamp(0.0, 1.0))
        });
        Self { tiles, of_tiles: of_tiles.collect() }
    }

    /// Bilinear between the middles of tiles.
    fn at(&self, half_px: [i64; 2]) -> f64 {
        let at = half_px.map(|c| c as f64 / f64::from(2 * TILE) - 0.5);
        let (mut total, mut weights) = (0.0, 0.0);
        for corner in [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [1.0, 1.0]] {
            let tile = [0, 1].map(|axis| at[axis].floor() + corner[axis]);
            let overlap = [0, 1].map(|axis| 1.0 - (at[axis] - tile[axis]).abs());
            let inside = [0, 1].map(|axis| tile[axis].clamp(0.0, self.tiles[axis] as f64 - 1.0) as usize);
            if let Some(complexity) = self.of_tiles[inside[1] * self.tiles[0] + inside[0]] {
                total += overlap[0] * overlap[1] * complexity;
                weights += overlap[0] * overlap[1];
            }
        }
        // Water so thin that none of it was measured is all edge.
        if weights > 1e-6 { total / weights } else { 1.0 }
    }
}
