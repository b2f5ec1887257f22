// Sum of the splats' column densities as lengths along the ray, in fixed point (algorithms.md 2.2). STAND_IN: of spheres that
// stand for groups of particles. STRIPS: of what was left to strips. POINTS: of sets none of which is large enough for its profile to
// be drawn: software drivers go through what no lane needs. IN_FRONT: of sets that nothing opaque cuts.
// BOUNDED: where no sum can exceed its bits. PAIRS: of those, where words of 64 bits hold two sums.
#import meniscus::camera::Camera
#import meniscus::page::{particle_at, stand_in_at}
#import meniscus::thickness::{Thickness, SATURATED}
#import meniscus::splat::{SplatSet, Splat, Grid, grid_of, share_of, splat_of, splat_of_stand_in, is_drawn, footprint, chord_at}
#import meniscus::strips::{Strip, part_of, item_count, item_at, first_of_lane, splat_of_item}
#import meniscus::tally::count

@group(0) @binding(0) var<uniform> camera: Camera;
@group(0) @binding(1) var<uniform> splats: SplatSet;
@group(0) @binding(2) var<uniform> thickness: Thickness;
#ifndef IN_FRONT
// Farthest the fluid is seen in a block. A buffer: few lanes of a software driver get here at a time, and it would read a texel
// for all of them.
@group(0) @binding(5) var<storage, read> limit: array<f32>;
#endif
#ifdef PAIRS
// Of each block, and beside it in the high bits a part of the next one's: two blocks of a row for one addition.
@group(0) @binding(6) var<storage, read_write> sum: array<atomic<u64>>;
#else
@group(0) @binding(6) var<storage, read_write> sum: array<atomic<u32>>;
#endif

const LANES: u32 = 64u;
const SPHERE_VOLUME: f32 = 4.18879020;

fn whole(steps: f32) -> u32 {
    return u32(clamp(steps, 0.0, 1073741824.0));
}

#ifdef PAIRS
// To a block and the next one in its row.
fn add_pair(pixel: u32, addend: u32, next: u32) {
    atomicAdd(&sum[pixel], u64(addend) | (u64(next) << 32u));
}
#else
fn add(pixel: u32, addend: u32) {
#ifdef BOUNDED
    atomicAdd(&sum[pixel], addend);
#else
    if addend > 0u && atomicAdd(&sum[pixel], addend) > SATURATED {
        atomicSub(&sum[pixel], addend);
    }
#endif
}
#endif

// Steps that the splat's volume is worth over the cross-section of a pixel, which is perpendicular to the ray.
fn steps_of_volume(grid: Grid, splat: Splat) -> f32 {
    let d = splat.center.z;
    let slope = splat.center.xy / d * grid.perspective;
    let pixel_size = abs(grid.step) * mix(1.0, d, grid.perspective);
    return splat.volume * sqrt(1.0 + dot(slope, slope)) / (pixel_size.x * pixel_size.y) * splats.steps_per_world;
}

// Where what reaches to the distance `far` is seen to end.
fn end_of(pixel: u32, far: f32) -> f32 {
#ifdef IN_FRONT
    return far;
#else
    return min(far, limit[pixel]);
#endif
}

// Part of a sphere's volume in front of the scene: a spherical segment of height 2 R f.
fn visible_part(pixel: u32, splat: Splat) -> f32 {
#ifdef IN_FRONT
    return 1.0;
#else
    let front = min(limit[pixel] - splat.center.z, splat.radius);
    let f = max(front / (2.0 * splat.radius) + 0.5, 0.0);
    return f * f * (3.0 - 2.0 * f);
#endif
}

#ifndef POINTS
// Blocks of a row that an invocation adds to at once: the lanes of a strip lie side by side.
#ifdef STRIPS
const AT_ONCE: i32 = 1;
#else ifdef PAIRS
const AT_ONCE: i32 = 2;
#else
const AT_ONCE: i32 = 1;
#endif

#ifdef STAND_IN
// From this many pixels on, the samples of a profile are right to a hundredth.
const WIDE_PX: i32 = 5;

// What the samples of the profile are worth, in steps, before `correction`; up to a tenth off for a sphere two pixels wide,
// depending on where its centre lies. Particles average that out; the same errors of thousands of stand-ins in rows add up.
fn correction(grid: Grid, splat: Splat, steps_per_length: f32, first: vec2<i32>, last: vec2<i32>) -> f32 {
    // Wide ones have samples enough, and at the border of the picture a part is missing.
    let is_wide = all(last - first >= vec2(WIDE_PX));
    if is_wide || any(first <= vec2(0)) || any(last >= grid.last_px) {
        return 1.0;
    }
    var sampled = 0.0;
    for (var y = first.y; y <= last.y; y++) {
        for (var x = first.x; x <= last.x; x++) {
            let chord = chord_at(grid, splat, grid.first + vec2(f32(x), f32(y)) * grid.step);
            sampled += sqrt(max(chord.half_squared, 0.0)) * chord.stretch;
        }
    }
    return steps_of_volume(grid, splat) / max(2.0 * sampled * steps_per_length, 1e-20);
}
#endif

// What the sphere's chord through the middle of a block is worth.
fn steps_of_chord(grid: Grid, splat: Splat, at: vec2<i32>, steps_per_length: f32) -> u32 {
    let chord = chord_at(grid, splat, grid.first + vec2<f32>(at) * grid.step);
    let half = sqrt(max(chord.half_squared, 0.0));
    let end = end_of(u32(at.y * (grid.last_px.x + 1) + at.x), chord.middle + half);
    let length = max(end - (chord.middle - half), 0.0);
    return select(0u, whole(length * chord.stretch * steps_per_length + 0.5), chord.half_squared > 0.0);
}

// Gives the number of pixels looked at, as `draw_point`.
fn draw_profile(grid: Grid, splat: Splat, first: vec2<i32>, last: vec2<i32>, origin: Strip, lane: u32) -> u32 {
    let part = part_of(origin, first, last, lane);
    let cube = splat.radius * splat.radius * splat.radius;
    var steps_per_length = splat.volume / (SPHERE_VOLUME * cube) * splats.steps_per_world;
#ifdef STAND_IN
    steps_per_length *= correction(grid, splat, steps_per_length, first, last);
#endif
    for (var y = part.first.y; y <= part.last.y; y += part.step.y) {
        for (var x = part.first.x; x <= part.last.x; x += AT_ONCE * part.step.x) {
            let pixel = u32(y * (grid.last_px.x + 1) + x);
            let steps = steps_of_chord(grid, splat, vec2(x, y), steps_per_length);
#ifdef PAIRS
            // Beyond the last column of the picture it is of no block, and nobody reads it.
            let next = select(0u, steps_of_chord(grid, splat, vec2(x + 1, y), steps_per_length), AT_ONCE > 1);
            if (steps | next) > 0u {
                add_pair(pixel, steps, next);
            }
#else
            if steps > 0u {
                add(pixel, steps);
            }
#endif
        }
    }
    return part.visited;
}
#endif

// Uniform in [0, 1): rounds the small addends of far splats up as often as needed for their sum to be right.
fn dither(position_world: vec3<f32>, packed: u32) -> f32 {
    let p = bitcast<vec3<u32>>(position_world);
    var h = (packed ^ (p.x * 0x9E3779B9u) ^ (p.y * 0x85EBCA6Bu) ^ (p.z * 0xC2B2AE35u)) * 0x27D4EB2Fu;
    h = (h ^ (h >> 15u)) * 0x2C1B3C6Du;
    return f32(h >> 8u) / 16777216.0;
}

// What of `steps` of a splat counts in a block.
fn counted(pixel: u32, splat: Splat, steps: f32, noise: f32) -> u32 {
    return whole(steps * visible_part(pixel, splat) + fract(noise));
}

#ifdef PAIRS
// Adds `steps` of a splat to two blocks side by side, as far as there are any; gives their number.
fn share_pair(grid: Grid, splat: Splat, at: vec2<i32>, steps: vec2<f32>, noise: vec2<f32>) -> u32 {
    let is_left = at.x >= 0;
    if at.y < 0 || at.y > grid.last_px.y || at.x < -1 || at.x > grid.last_px.x {
        return 0u;
    }
    let row = at.y * (grid.last_px.x + 1);
    let first = counted(u32(row + max(at.x, 0)), splat, steps.x, noise.x);
    let second = counted(u32(row + at.x + 1), splat, steps.y, noise.y);
    // At the left border the second one is the block itself; beyond the right one nobody reads it.
    add_pair(u32(row + max(at.x, 0)), select(second, first, is_left), select(0u, second, is_left));
    return select(1u, 2u, is_left && at.x < grid.last_px.x);
}
#else

// Adds `steps` of a splat to a block, if there is one; gives the number of blocks.
fn share(grid: Grid, splat: Splat, at: vec2<i32>, steps: f32, noise: f32) -> u32 {
    if any(at < vec2(0)) || any(at > grid.last_px) {
        return 0u;
    }
    let pixel = u32(at.y * (grid.last_px.x + 1) + at.x);
    add(pixel, counted(pixel, splat, steps, noise));
    return 1u;
}
#endif

// Shares the splat out between the four blocks around its centre.
fn draw_point(grid: Grid, splat: Splat, center_px: vec2<f32>, noise: f32) -> u32 {
    let corner = clamp(center_px - 0.5, vec2(-2.0), vec2<f32>(grid.last_px) + 1.0);
    let base = floor(corner);
    let at = vec2<i32>(base);
    let far = corner - base;
    let near = 1.0 - far;
    let steps = steps_of_volume(grid, splat);
#ifdef PAIRS
    let upper = steps * near.y;
    let lower = steps * far.y;
    return share_pair(grid, splat, at, upper * vec2(near.x, far.x), noise + vec2(0.0, 0.25))
        + share_pair(grid, splat, at + vec2(0, 1), lower * vec2(near.x, far.x), noise + vec2(0.5, 0.75));
#else
    return share(grid, splat, at, steps * near.x * near.y, noise)
        + share(grid, splat, at + vec2(1, 0), steps * far.x * near.y, noise + 0.25)
        + share(grid, splat, at + vec2(0, 1), steps * near.x * far.y, noise + 0.5)
        + share(grid, splat, at + vec2(1, 1), steps * far.x * far.y, noise + 0.75);
#endif
}

fn draw_particle(grid: Grid, origin: Strip, lane: u32) -> u32 {
#ifdef STAND_IN
    let stand_in = stand_in_at(origin.particle);
    let splat = splat_of_stand_in(camera, splats, stand_in);
    let noise = dither(stand_in.center_world, stand_in.packed);
#else
    let particle = particle_at(origin.particle);
    let splat = splat_of(camera, splats, particle, origin.keep);
    let noise = dither(particle.position_world, particle.packed);
#endif
    if !is_drawn(camera, splat) {
        return 0u;
    }
    let box = footprint(grid, splat);
#ifndef POINTS
    if max(box.half_px.x, box.half_px.y) >= thickness.profile_half_px {
        return draw_profile(grid, splat, box.first, box.last, origin, lane);
    }
#endif
    return draw_point(grid, splat, box.center_px, noise);
}

@compute @workgroup_size(LANES)
fn main(@builtin(workgroup_id) group: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>, @builtin(local_invocation_index) lane: u32) {
    let grid = grid_of(camera, thickness.scale);
    let share = share_of(group, groups);
    var visited = 0u;
    for (var index = share.first; index < item_count(); index += share.step) {
        let item = item_at(index);
        for (var i = first_of_lane(lane); i < item.count; i += LANES) {
            visited += draw_particle(grid, splat_of_item(item, i), lane);
        }
    }
    count(visited);
}
