// From the light that landed to how much brighter the scene is there than without waves: smoothed over the pixels between
// which single bundles of light leave gaps, and as strong as wanted.

#import meniscus::camera::Camera

struct Caustics {
    // 0: none, 1: all.
    strength: f32,
    pad_a: f32,
    pad_b: f32,
    pad_c: f32,
}

@group(0) @binding(0) var<uniform> sun_camera: Camera;
@group(0) @binding(1) var<uniform> parameters: Caustics;
@group(0) @binding(2) var<storage, read> landed: array<u32>;
@group(0) @binding(3) var<storage, read_write> caustics: array<f32>;

const ONE: f32 = 4096.0;
// Brighter than this is noise of single particles.
const MOST: f32 = 3.9;

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    let size = vec2<i32>(sun_camera.size_px);
    let at = vec2<i32>(id.xy);
    if any(at >= size) {
        return;
    }
    // A binomial of five by five.
    const WEIGHTS = array<f32, 3>(6.0, 4.0, 1.0);
    var sum = 0.0;
    for (var y = -2; y <= 2; y++) {
        let row = clamp(at.y + y, 0, size.y - 1) * size.x;
        for (var x = -2; x <= 2; x++) {
            sum += WEIGHTS[abs(y)] * WEIGHTS[abs(x)] * f32(landed[row + clamp(at.x + x, 0, size.x - 1)]);
        }
    }
    let focus = sum / (256.0 * ONE);
    caustics[at.y * size.x + at.x] = mix(1.0, min(focus, MOST), parameters.strength);
}
