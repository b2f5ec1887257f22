// Places on a colour scale near the visible surface: per pixel the sums of weights and of weighted places, both in fixed point, so
// that the order of the particles does not matter. STRIPS: of what was left to strips.
#import meniscus::camera::Camera
#import meniscus::page::particle_at
#import meniscus::splat::{SplatSet, Splat, Grid, grid_of, share_of, splat_of, is_drawn, surface_pixels}
#import meniscus::strips::{Strip, part_of, item_count, item_at, first_of_lane, splat_of_item}
#import meniscus::surface::is_empty

struct ColorScale {
    // Place on the scale = (value - offset) * factor; of the value's natural logarithm where `is_log` is not 0.
    offset: f32,
    factor: f32,
    is_log: u32,
}

@group(0) @binding(0) var<uniform> camera: Camera;
@group(0) @binding(1) var<uniform> splats: SplatSet;
@group(0) @binding(2) var<uniform> scale: ColorScale;
@group(0) @binding(5) var<storage, read> values: array<f32>;
@group(0) @binding(6) var front: texture_2d<f32>;
// Weights, then weighted places, of each pixel.
@group(0) @binding(7) var<storage, read_write> sums: array<atomic<u32>>;

const LANES: u32 = 64u;
// Radii over which a particle's value is spread out: neighbours blend into each other without losing detail.
const REACH_RADII: f32 = 2.0;
// Radii that a particle may lie in front of or behind the surface and still colour it: what it is made of, and not much more.
const DEPTH_RADII: f32 = 3.0;
// Steps of a weight of 1: sixty-five thousand particles in a pixel until sums overflow.
const STEPS: f32 = 65535.0;
// Value of a particle without one.
const NO_VALUE: f32 = 3e38;

fn place(value: f32) -> f32 {
    let x = select(value, log(max(value, 1.1754944e-38)), scale.is_log != 0u);
    return clamp((x - scale.offset) * scale.factor, 0.0, 1.0);
}

fn draw(grid: Grid, splat: Splat, at: f32, origin: Strip, lane: u32) {
    // Near the eye the wider sphere might reach behind it.
    let reach = min(REACH_RADII * splat.radius, splat.center.z - camera.near_world);
    let wide = Splat(splat.center, max(reach, splat.radius), splat.volume);
    let box = surface_pixels(grid, wide);
    let part = part_of(origin, box.first, box.last, lane);
    let falloff = 1.0 / (wide.radius * wide.radius);
    let depth_falloff = 1.0 / (DEPTH_RADII * splat.radius);
    let lift = mix(1.0, splat.center.z, grid.perspective);
    for (var y = part.first.y; y <= part.last.y; y += part.step.y) {
        for (var x = part.first.x; x <= part.last.x; x += part.step.x) {
            let pixel = u32(y * (grid.last_px.x + 1) + x);
            let distance = textureLoad(front, vec2(x, y), 0).x;
            if is_empty(distance) {
                continue;
            }
            let e = (splat.center.z - distance) * depth_falloff;
            let offset = (grid.first + vec2(f32(x), f32(y)) * grid.step) * lift - splat.center.xy;
            // A splat within one pixel counts there as if seen near its centre.
            let q = select(dot(offset, offset) * falloff, 0.25, box.is_point);
            if q < 1.0 && abs(e) < 1.0 {
                let near = (1.0 - q) * (1.0 - e * e);
                let weight = near * near * STEPS;
                atomicAdd(&sums[2u * pixel], u32(weight));
                atomicAdd(&sums[2u * pixel + 1u], u32(weight * at));
            }
        }
    }
}

fn draw_particle(grid: Grid, origin: Strip, lane: u32) {
    let value = values[origin.particle];
    let splat = splat_of(camera, splats, particle_at(origin.particle), origin.keep);
    if value < NO_VALUE && is_drawn(camera, splat) {
        draw(grid, splat, place(value), origin, lane);
    }
}

@compute @workgroup_size(LANES)
fn main(@builtin(workgroup_id) group: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>, @builtin(local_invocation_index) lane: u32) {
    let grid = grid_of(camera, 1u);
    let share = share_of(group, groups);
    for (var index = share.first; index < item_count(); index += share.step) {
        let item = item_at(index);
        for (var i = first_of_lane(lane); i < item.count; i += LANES) {
            draw_particle(grid, splat_of_item(item, i), lane);
        }
    }
}
