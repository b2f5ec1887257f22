#define_import_path meniscus::environment

#import meniscus::brdf::PI

// A picture of the surroundings, equirectangular. First the picture itself, then levels of one size that are blurred as a
// rough mirror blurs (GGX), for equal steps of perceptual roughness up to 1.

struct EnvironmentSize {
    // Columns and rows of the picture; 0 if there is none.
    sharp: vec2<u32>,
    // Of each blurred level.
    blurred: vec2<u32>,
}

const BLURRED_LEVELS: f32 = 5.0;

@group(0) @binding(11) var<storage, read> environment_texels: array<vec4<f32>>;

// Bilinear, for a place in [0, 1): columns close in a circle.
fn environment_level(first: u32, size: vec2<u32>, place: vec2<f32>) -> vec3<f32> {
    let corner = place * vec2<f32>(size) - 0.5;
    let base = floor(corner);
    let f = corner - base;
    var sum = vec3(0.0);
    for (var k = 0; k < 4; k++) {
        let offset = vec2(k & 1, k >> 1u);
        let at = vec2<i32>(base) + offset;
        let column = (at.x + i32(size.x)) % i32(size.x);
        let row = clamp(at.y, 0, i32(size.y) - 1);
        let texel = environment_texels[first + u32(row) * size.x + u32(column)];
        let weights = mix(1.0 - f, f, vec2<f32>(offset));
        sum += weights.x * weights.y * texel.rgb;
    }
    return sum;
}

// Radiance from the unit direction, whose components are east, north and up, seen in a mirror of this perceptual roughness.
// The picture must exist.
fn environment_radiance(size: EnvironmentSize, direction: vec3<f32>, roughness: f32) -> vec3<f32> {
    let place = vec2(atan2(direction.x, direction.y) / (2.0 * PI) + 0.5, acos(clamp(direction.z, -1.0, 1.0)) / PI);
    let level = clamp(roughness, 0.0, 1.0) * BLURRED_LEVELS;
    let below = min(floor(level), BLURRED_LEVELS - 1.0);
    let sharp_texels = size.sharp.x * size.sharp.y;
    let blurred_texels = size.blurred.x * size.blurred.y;
    let upper = environment_level(sharp_texels + u32(below) * blurred_texels, size.blurred, place);
    if below > 0.0 {
        let lower = environment_level(sharp_texels + (u32(below) - 1u) * blurred_texels, size.blurred, place);
        return mix(lower, upper, level - below);
    }
    return mix(environment_level(0u, size.sharp, place), upper, level);
}
