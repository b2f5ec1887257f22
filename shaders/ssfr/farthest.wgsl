// Farthest distance per tile of 8 x 8 pixels; of the tiles again, per tile of 64 x 64. What lies behind it in all tiles that it
// could show in is hidden.
#ifdef FIRST
#import meniscus::camera::Camera

@group(0) @binding(0) var<uniform> camera: Camera;
// FIRST: bits of the nearest distance per pixel.
@group(0) @binding(1) var<storage, read> nearest: array<f32>;
#else
@group(0) @binding(1) var tiles: texture_2d<f32>;
#endif
@group(0) @binding(2) var farthest: texture_storage_2d<r32float, write>;

const TILE: u32 = 8u;

fn source_size() -> vec2<u32> {
#ifdef FIRST
    return camera.size_px;
#else
    return textureDimensions(tiles);
#endif
}

fn distance_at(at: vec2<u32>) -> f32 {
#ifdef FIRST
    return nearest[at.y * camera.size_px.x + at.x];
#else
    return textureLoad(tiles, at, 0).x;
#endif
}

@compute @workgroup_size(64, 1)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    let source = source_size();
    let first = id.xy * TILE;
    if any(first >= source) {
        return;
    }
    let end = min(first + TILE, source);
    var found = 0.0;
    for (var y = first.y; y < end.y; y++) {
        for (var x = first.x; x < end.x; x++) {
            found = max(found, distance_at(vec2(x, y)));
        }
    }
    textureStore(farthest, id.xy, vec4(found));
}
