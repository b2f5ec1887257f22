// Drawn radius of the splat that is visible in a pixel; the largest where several are equally near.
#import meniscus::camera::Camera
#import meniscus::particle::{PackedParticle, KeptRange}
#import meniscus::splat::{SplatSet, Splat, Grid, grid_of, share_of, splat_of, is_drawn, surface_pixels, chord_at}

@group(0) @binding(0) var<uniform> camera: Camera;
@group(0) @binding(1) var<uniform> splats: SplatSet;
@group(0) @binding(2) var<storage, read> particles: array<PackedParticle>;
@group(0) @binding(3) var<storage, read> ranges: array<KeptRange>;
@group(0) @binding(4) var<storage, read> nearest: array<f32>;
@group(0) @binding(5) var<storage, read_write> radius: array<atomic<u32>>;

const LANES: u32 = 64u;
// Fraction of the radius by which a splat may lie behind the nearest and still count as visible: far above the rounding
// by which two shaders may differ in the same formula, far below anything that can be seen.
const TOLERANCE: f32 = 1e-3;

fn draw(grid: Grid, splat: Splat) {
    let box = surface_pixels(grid, splat);
    let front = splat.center.z - splat.radius;
    let slack = TOLERANCE * splat.radius + 4e-7 * splat.center.z;
    for (var y = box.first.y; y <= box.last.y; y++) {
        for (var x = box.first.x; x <= box.last.x; x++) {
            let pixel = u32(y * (grid.last_px.x + 1) + x);
            if nearest[pixel] + slack >= front {
                let chord = chord_at(grid, splat, grid.first + vec2(f32(x), f32(y)) * grid.step);
                if box.is_point || chord.half_squared >= 0.0 {
                    let distance = max(chord.middle - sqrt(max(chord.half_squared, 0.0)), front);
                    if distance <= nearest[pixel] + slack {
                        atomicMax(&radius[pixel], bitcast<u32>(splat.radius));
                    }
                }
            }
        }
    }
}

@compute @workgroup_size(LANES)
fn main(@builtin(workgroup_id) group: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>, @builtin(local_invocation_index) lane: u32) {
    let grid = grid_of(camera, 1u);
    let share = share_of(group, groups);
    for (var index = share.first; index < ranges[0].first; index += share.step) {
        let range = ranges[index + 1u];
        for (var i = lane; i < range.count; i += LANES) {
            let splat = splat_of(camera, splats, particles[range.first + i], range.keep);
            if is_drawn(camera, splat) {
                draw(grid, splat);
            }
        }
    }
}
