// Farthest distance per tile of 8 x 8 pixels; of the tiles again, per tile of 64 x 64. What lies behind it in all tiles that it
// could show in is hidden.

struct Tiles {
    // Of the picture, or of the tiles, that are looked at.
    source_px: vec2<u32>,
    // Where among the tiles they begin, and where the result does.
    first_source: u32,
    first_tile: u32,
}

@group(0) @binding(0) var<uniform> tiles: Tiles;
// FIRST: bits of the nearest distance per pixel.
#ifdef FIRST
@group(0) @binding(1) var<storage, read> nearest: array<f32>;
#endif
@group(0) @binding(2) var<storage, read_write> farthest: array<f32>;

const TILE: u32 = 8u;

fn distance_at(index: u32) -> f32 {
#ifdef FIRST
    return nearest[index];
#else
    return farthest[tiles.first_source + index];
#endif
}

@compute @workgroup_size(64, 1)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    let size = (tiles.source_px + TILE - 1u) / TILE;
    if any(id.xy >= size) {
        return;
    }
    let first = id.xy * TILE;
    let end = min(first + TILE, tiles.source_px);
    var found = 0.0;
    for (var y = first.y; y < end.y; y++) {
        for (var x = first.x; x < end.x; x++) {
            found = max(found, distance_at(y * tiles.source_px.x + x));
        }
    }
    farthest[tiles.first_tile + id.y * size.x + id.x] = found;
}
