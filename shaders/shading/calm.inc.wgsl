#define_import_path meniscus::calm

#import meniscus::surface::unpack_normal

// The normals that refraction sees, from `shading.calm_normals`: of the surface without the noise that the places of single
// particles leave on it. A mirror does not show a degree of that; a body of water moves what is behind it by a fiftieth of its
// thickness.

// Pixels per side of a block that shares one normal.
const BLOCK_PX: i32 = 4;
// Straight away from the eye: no normal.
const NO_NORMAL: vec3<f32> = vec3(0.0, 0.0, -1.0);

// Cosines between a pixel's own normal and a calm one: up to the first they are those of one surface, from the second on of
// different ones. 20 and 35 degrees.
const SAME: f32 = 0.94;
const OTHER: f32 = 0.82;

@group(0) @binding(14) var calm_normals: texture_2d<u32>;

// Calm normals of a pixel and of those to its right and below it; not of unit length.
struct Calm {
    own: vec3<f32>,
    right: vec3<f32>,
    below: vec3<f32>,
}

// What one of the blocks around a pixel adds to its own normal: `share` of it, as far as the two are of one surface.
fn calming(block: vec3<f32>, own: vec3<f32>, share: vec2<f32>) -> vec3<f32> {
    return share.x * share.y * smoothstep(OTHER, SAME, dot(block, own)) * (block - own);
}

// Of a pixel whose own normal is the unit vector `normal_view`, which changes by `to_right` and `to_below` from pixel to pixel.
fn calmed(pixel: vec2<u32>, normal_view: vec3<f32>, to_right: vec3<f32>, to_below: vec3<f32>) -> Calm {
    let corner = (vec2<f32>(pixel) + 0.5) / f32(BLOCK_PX) - 0.5;
    let base = floor(corner);
    let f = corner - base;
    let last = vec2<i32>(textureDimensions(calm_normals)) - 1;
    let right = normal_view + to_right;
    let below = normal_view + to_below;
    var calm = Calm(normal_view, right, below);
    for (var k = 0; k < 4; k++) {
        let offset = vec2(k & 1, k >> 1u);
        let block = clamp(vec2<i32>(base) + offset, vec2(0), last);
        let normal = unpack_normal(textureLoad(calm_normals, block, 0).x);
        let share = mix(1.0 - f, f, vec2<f32>(offset));
        // From a pixel to the next, shares grow by this.
        let growth = (2.0 * vec2<f32>(offset) - 1.0) / f32(BLOCK_PX);
        calm.own += calming(normal, normal_view, share);
        calm.right += calming(normal, right, share + vec2(growth.x, 0.0));
        calm.below += calming(normal, below, share + vec2(0.0, growth.y));
    }
    return calm;
}
