// Sum of the splats' column densities as lengths along the ray, in fixed point (algorithms.md 2.2).
#import meniscus::camera::Camera
#import meniscus::particle::{PackedParticle, KeptRange}
#import meniscus::thickness::{Thickness, SATURATED}
#import meniscus::splat::{SplatSet, Splat, Grid, grid_of, splat_of, is_drawn, footprint, chord_at, area}
#import meniscus::tally::count

@group(0) @binding(0) var<uniform> camera: Camera;
@group(0) @binding(1) var<uniform> splats: SplatSet;
@group(0) @binding(2) var<uniform> thickness: Thickness;
@group(0) @binding(3) var<storage, read> particles: array<PackedParticle>;
@group(0) @binding(4) var<storage, read> ranges: array<KeptRange>;
@group(0) @binding(5) var<storage, read> limit: array<f32>;
@group(0) @binding(6) var<storage, read_write> sum: array<atomic<u32>>;

const LANES: u32 = 64u;
const SPHERE_VOLUME: f32 = 4.18879020;

fn add(pixel: u32, steps: f32) {
    let addend = u32(clamp(steps, 0.0, 1073741824.0));
    if addend > 0u && atomicAdd(&sum[pixel], addend) > SATURATED {
        atomicSub(&sum[pixel], addend);
    }
}

// Gives the number of pixels looked at, as `draw_point`.
fn draw_profile(grid: Grid, splat: Splat, first: vec2<i32>, last: vec2<i32>) -> u32 {
    let cube = splat.radius * splat.radius * splat.radius;
    let steps_per_length = splat.volume / (SPHERE_VOLUME * cube) * splats.steps_per_world;
    for (var y = first.y; y <= last.y; y++) {
        for (var x = first.x; x <= last.x; x++) {
            let chord = chord_at(grid, splat, grid.first + vec2(f32(x), f32(y)) * grid.step);
            let pixel = u32(y * (grid.last_px.x + 1) + x);
            if chord.half_squared > 0.0 {
                let half = sqrt(chord.half_squared);
                let length = max(min(chord.middle + half, limit[pixel]) - (chord.middle - half), 0.0);
                add(pixel, length * chord.stretch * steps_per_length + 0.5);
            }
        }
    }
    return area(first, last);
}

// Uniform in [0, 1): rounds the small addends of far splats up as often as needed for their sum to be right.
fn dither(particle: PackedParticle) -> f32 {
    let p = bitcast<vec3<u32>>(particle.position_world);
    var h = (particle.packed ^ (p.x * 0x9E3779B9u) ^ (p.y * 0x85EBCA6Bu) ^ (p.z * 0xC2B2AE35u)) * 0x27D4EB2Fu;
    h = (h ^ (h >> 15u)) * 0x2C1B3C6Du;
    return f32(h >> 8u) / 16777216.0;
}

fn draw_point(grid: Grid, splat: Splat, center_px: vec2<f32>, noise: f32) -> u32 {
    let corner = clamp(center_px - 0.5, vec2(-2.0), vec2<f32>(grid.last_px) + 1.0);
    let base = floor(corner);
    let part = corner - base;
    let d = splat.center.z;
    let slope = splat.center.xy / d * grid.perspective;
    let pixel_size = abs(grid.step) * mix(1.0, d, grid.perspective);
    // Volume over the pixel's cross-section, which is perpendicular to the ray.
    let steps = splat.volume * sqrt(1.0 + dot(slope, slope)) / (pixel_size.x * pixel_size.y) * splats.steps_per_world;
    var visited = 0u;
    for (var tap = 0; tap < 4; tap++) {
        let offset = vec2(tap & 1, tap >> 1u);
        let at = vec2<i32>(base) + offset;
        if all(at >= vec2(0)) && all(at <= grid.last_px) {
            visited++;
            let pixel = u32(at.y * (grid.last_px.x + 1) + at.x);
            let weights = select(1.0 - part, part, offset == vec2(1));
            // Part of the sphere's volume in front of the scene: a spherical segment of height 2 R f.
            let front = min(limit[pixel] - d, splat.radius);
            let f = max(front / (2.0 * splat.radius) + 0.5, 0.0);
            let visible = f * f * (3.0 - 2.0 * f);
            add(pixel, steps * weights.x * weights.y * visible + fract(noise + 0.25 * f32(tap)));
        }
    }
    return visited;
}

@compute @workgroup_size(LANES)
fn main(@builtin(workgroup_id) group: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>, @builtin(local_invocation_index) lane: u32) {
    let index = group.y * groups.x + group.x;
    if index >= splats.range_count {
        return;
    }
    let range = ranges[index];
    let grid = grid_of(camera, thickness.scale);
    var visited = 0u;
    for (var i = lane; i < range.count; i += LANES) {
        let particle = particles[range.first + i];
        let splat = splat_of(camera, splats, particle, range.keep);
        if is_drawn(camera, splat) {
            let box = footprint(grid, splat);
            if max(box.half_px.x, box.half_px.y) < thickness.profile_half_px {
                visited += draw_point(grid, splat, box.center_px, dither(particle));
            } else {
                visited += draw_profile(grid, splat, box.first, box.last);
            }
        }
    }
    count(visited);
}
