#define_import_path meniscus::adaptive
#import meniscus::camera::Camera

struct Adaptive {
    spacing_per_radius: f32,
    // Radii: what deviates by more is another surface.
    range_radii: f32,
    // A tile is complex whose share of pixels beside an edge, or whose mean bend in radii, reaches these; it is simple up to
    // half of them.
    edges: f32,
    bend: f32,
}

// Pixels per side of a tile. The tiles lie around the middle of the picture: a mirrored picture has mirrored tiles.
const TILE: u32 = 16u;
// Steps of a bend of one radius, and the largest that counts: sums of a tile stay below 2^21.
const BEND_STEPS: f32 = 256.0;
const MOST_BEND: f32 = 16.0;

fn tiles(camera: Camera) -> vec2<u32> {
    return (camera.size_px + TILE - 1u) / TILE;
}

// Place of a pixel in half pixels from the first tile's corner.
fn half_px_in_tiles(camera: Camera, at: vec2<u32>) -> vec2<u32> {
    return TILE * tiles(camera) + 2u * at + 1u - camera.size_px;
}
