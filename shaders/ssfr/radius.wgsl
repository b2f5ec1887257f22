// Drawn radius of the splat that is visible in a pixel, of an ellipsoid that of the sphere in its place; the largest where several
// are equally near. SHAPED: of ranges some of which are ellipsoids. STRIPS: of what was left to strips.
#import meniscus::camera::Camera
#import meniscus::page::particle_at
#import meniscus::splat::{SplatSet, Splat, Grid, grid_of, share_of, splat_of, is_drawn, surface_pixels, chord_at}
#import meniscus::strips::{Strip, part_of, item_count, item_at, first_of_lane, splat_of_item}
#ifdef SHAPED
#import meniscus::ellipsoid::{Ellipsoid, ellipsoid_of, front_of, is_ellipsoid_drawn, ellipsoid_pixels, hit_at}
#endif

@group(0) @binding(0) var<uniform> camera: Camera;
@group(0) @binding(1) var<uniform> splats: SplatSet;
@group(0) @binding(4) var<storage, read> nearest: array<f32>;
@group(0) @binding(5) var<storage, read_write> radius: array<atomic<u32>>;
#ifdef SHAPED
@group(0) @binding(6) var<storage, read> shapes: array<vec4<u32>>;
#endif

const LANES: u32 = 64u;
// Fraction of the radius by which a splat may lie behind the nearest and still count as visible: far above the rounding
// by which two shaders may differ in the same formula, far below anything that can be seen.
const TOLERANCE: f32 = 1e-3;

fn draw(grid: Grid, splat: Splat, origin: Strip, lane: u32) {
    let box = surface_pixels(grid, splat);
    let part = part_of(origin, box.first, box.last, lane);
    let front = splat.center.z - splat.radius;
    let slack = TOLERANCE * splat.radius + 4e-7 * splat.center.z;
    for (var y = part.first.y; y <= part.last.y; y += part.step.y) {
        for (var x = part.first.x; x <= part.last.x; x += part.step.x) {
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

#ifdef SHAPED
// As `draw`.
fn draw_ellipsoid(grid: Grid, ellipsoid: Ellipsoid, origin: Strip, lane: u32) {
    let box = ellipsoid_pixels(grid, ellipsoid);
    let part = part_of(origin, box.first, box.last, lane);
    let center = ellipsoid.splat.center;
    let front = front_of(ellipsoid);
    let slack = TOLERANCE * ellipsoid.splat.radius + 4e-7 * center.z;
    let lift = mix(1.0, center.z, grid.perspective);
    for (var y = part.first.y; y <= part.last.y; y += part.step.y) {
        for (var x = part.first.x; x <= part.last.x; x += part.step.x) {
            let pixel = u32(y * (grid.last_px.x + 1) + x);
            let plane = grid.first + vec2(f32(x), f32(y)) * grid.step;
            let o = ellipsoid.to_sphere * vec3(plane * lift - center.xy, 0.0);
            let s = ellipsoid.to_sphere * vec3(plane * grid.perspective, 1.0);
            let hit = hit_at(ellipsoid, o, s);
            let distance = max(center.z - (hit.k + sqrt(max(hit.reachable, 0.0))) / hit.a, front);
            if (box.is_point || hit.reachable >= 0.0) && distance <= nearest[pixel] + slack {
                atomicMax(&radius[pixel], bitcast<u32>(ellipsoid.splat.radius));
            }
        }
    }
}
#endif

fn draw_particle(grid: Grid, origin: Strip, lane: u32) {
    let particle = particle_at(origin.particle);
#ifdef SHAPED
    if origin.shape > 0u {
        let ellipsoid = ellipsoid_of(camera, splats, particle, origin.keep, shapes[origin.shape - 1u]);
        if is_ellipsoid_drawn(camera, ellipsoid) {
            draw_ellipsoid(grid, ellipsoid, origin, lane);
        }
        return;
    }
#endif
    let splat = splat_of(camera, splats, particle, origin.keep);
    if is_drawn(camera, splat) {
        draw(grid, splat, origin, lane);
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
