// Which ranges are not hidden by what is drawn already: those of which a sphere may be nearer than the farthest distance in the
// tiles that it could show in (hierarchical z-buffer, Greene, Kass and Miller 1993). Never wrongly hidden.
#import meniscus::particle::{KeptRange, Occludee}

struct Occlusion {
    count: u32,
}

// A list of ranges while it is filled.
struct Filling {
    count: atomic<u32>,
    // The rest of the header.
    pad: array<u32, 3>,
    ranges: array<KeptRange>,
}

@group(0) @binding(0) var<uniform> occlusion: Occlusion;
@group(0) @binding(1) var<storage, read> occludees: array<Occludee>;
// Of tiles of 8 pixels, and of 64.
@group(0) @binding(2) var farthest: texture_2d<f32>;
@group(0) @binding(3) var farthest_large: texture_2d<f32>;
@group(0) @binding(4) var<storage, read_write> visible: Filling;

// Most tiles that one test looks at; what spreads over more of the large ones is so near that it is drawn.
const MOST_TILES: u32 = 64u;

fn unpack(tile: u32) -> vec2<u32> {
    return vec2(tile & 0xffffu, tile >> 16u);
}

fn reaches_before(front: f32, tiles: texture_2d<f32>, first: vec2<u32>, last: vec2<u32>) -> bool {
    for (var y = first.y; y <= last.y; y++) {
        for (var x = first.x; x <= last.x; x++) {
            if textureLoad(tiles, vec2(x, y), 0).x > front {
                return true;
            }
        }
    }
    return false;
}

fn is_visible(occludee: Occludee) -> bool {
    var first = unpack(occludee.first_tile);
    var last = unpack(occludee.last_tile);
    var size = last - first + 1u;
    if size.x * size.y <= MOST_TILES {
        return reaches_before(occludee.front, farthest, first, last);
    }
    first /= 8u;
    last /= 8u;
    size = last - first + 1u;
    if size.x * size.y <= MOST_TILES {
        return reaches_before(occludee.front, farthest_large, first, last);
    }
    return true;
}

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>) {
    let index = id.y * groups.x * 64u + id.x;
    if index < occlusion.count && is_visible(occludees[index]) {
        visible.ranges[atomicAdd(&visible.count, 1u)] = occludees[index].range;
    }
}
