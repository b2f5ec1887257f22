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

// The calm normal of a pixel whose own is the unit vector `normal_view`; not of unit length.
fn calmed(pixel: vec2<u32>, normal_view: vec3<f32>) -> vec3<f32> {
    let corner = (vec2<f32>(pixel) + 0.5) / f32(BLOCK_PX) - 0.5;
    let base = floor(corner);
    let f = corner - base;
    let last = vec2<i32>(textureDimensions(calm_normals)) - 1;
    var sum = vec3(0.0);
    var own = 1.0;
    for (var k = 0; k < 4; k++) {
        let offset = vec2(k & 1, k >> 1u);
        let block = clamp(vec2<i32>(base) + offset, vec2(0), last);
        let normal = unpack_normal(textureLoad(calm_normals, block, 0).x);
        let weights = mix(1.0 - f, f, vec2<f32>(offset));
        let weight = weights.x * weights.y * smoothstep(OTHER, SAME, dot(normal, normal_view));
        sum += weight * normal;
        own -= weight;
    }
    return sum + own * normal_view;
}
