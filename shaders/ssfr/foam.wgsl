// Optical depth of foam per pixel in three layers (algorithms.md 11): in front of the surface, within about a spacing of it, and
// behind it. All in fixed point, so that the order of the drops does not matter.
#import meniscus::camera::{Camera, px_per_world}
#import meniscus::splat::{Splat, grid_of, half_to_float, is_drawn, surface_pixels}
#import meniscus::surface::is_empty

struct FoamDrop {
    center_world: vec3<f32>,
    // Low 16 bits: optical depth at the centre. High 16 bits: radius in spacings. Both IEEE halves.
    packed: u32,
}

struct Foam {
    spacing_world: f32,
    // Factor on the radius, for drops that stand for those left out.
    widening: f32,
    // Factor on the optical depth.
    amount: f32,
    // Drops that are drawn.
    count: u32,
}

@group(0) @binding(0) var<uniform> camera: Camera;
@group(0) @binding(1) var<uniform> foam: Foam;
@group(0) @binding(2) var<storage, read> drops: array<FoamDrop>;
@group(0) @binding(3) var distances: texture_2d<f32>;
@group(0) @binding(4) var scene_distance: texture_2d<f32>;
// In front, in the surface, behind, behind times depth in spacings; of each pixel.
@group(0) @binding(5) var<storage, read_write> layers: array<atomic<u32>>;

const LANES: u32 = 64u;
// Smallest radius in pixels: of a smaller one, what a pixel gets would depend on where its centre is.
const MIN_RADIUS_PX: f32 = 1.5;
// Steps of an optical depth of 1.
const STEPS: f32 = 4096.0;
// What is deeper counts as that deep: no light comes from there, and sums stay small.
const MAX_DEPTH_SPACINGS: f32 = 64.0;

// Adds an optical depth in steps, rounded.
fn add(place: u32, amount: f32) {
    let steps = u32(amount + 0.5);
    if steps > 0u {
        atomicAdd(&layers[place], steps);
    }
}

@compute @workgroup_size(LANES)
fn main(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>) {
    let index = id.y * groups.x * LANES + id.x;
    if index >= foam.count {
        return;
    }
    let drop = drops[index];
    let p = (camera.view_from_world * vec4(drop.center_world, 1.0)).xyz;
    let radius = foam.spacing_world * foam.widening * half_to_float(drop.packed >> 16u);
    let drawn = max(radius, MIN_RADIUS_PX / px_per_world(camera, max(-p.z, camera.near_world)));
    if !is_drawn(camera, Splat(vec3(p.xy, -p.z), radius, 0.0)) {
        return;
    }
    let splat = Splat(vec3(p.xy, -p.z), drawn, 0.0);
    let share = radius / drawn;
    let steps = STEPS * foam.amount * half_to_float(drop.packed) * share * share;
    let grid = grid_of(camera, 1u);
    let box = surface_pixels(grid, splat);
    let falloff = 1.0 / (drawn * drawn);
    let lift = mix(1.0, splat.center.z, grid.perspective);
    for (var y = box.first.y; y <= box.last.y; y++) {
        for (var x = box.first.x; x <= box.last.x; x++) {
            let offset = (grid.first + vec2(f32(x), f32(y)) * grid.step) * lift - splat.center.xy;
            let inside = 1.0 - dot(offset, offset) * falloff;
            if inside <= 0.0 || splat.center.z >= textureLoad(scene_distance, vec2(x, y), 0).x {
                continue;
            }
            let amount = steps * inside * inside;
            let pixel = u32(y * (grid.last_px.x + 1) + x);
            let distance = textureLoad(distances, vec2(x, y), 0).x;
            if is_empty(distance) {
                add(4u * pixel, amount);
                continue;
            }
            // Spacings behind the surface; layers blend into each other, so that nothing pops.
            let behind = (splat.center.z - distance) / foam.spacing_world;
            let front_share = clamp(-behind - 0.5, 0.0, 1.0);
            let behind_share = clamp(behind - 0.5, 0.0, 1.0);
            add(4u * pixel, amount * front_share);
            add(4u * pixel + 1u, amount * (1.0 - front_share - behind_share));
            add(4u * pixel + 2u, amount * behind_share);
            add(4u * pixel + 3u, amount * behind_share * min(behind, MAX_DEPTH_SPACINGS));
        }
    }
}
