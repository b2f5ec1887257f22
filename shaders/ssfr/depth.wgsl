// Nearest splat per pixel: u32 atomicMin on the bits of the distance, which order like the positive floats they are; the last
// bits may be those of the radius' grade. TESTED: of ranges that are drawn after others, so that most of their spheres are hidden.
// SHAPED: of ranges some of which are ellipsoids. STRIPS: of what was left to strips.
#import meniscus::camera::Camera
#import meniscus::page::particle_at
#import meniscus::splat::{SplatSet, Splat, Grid, grid_of, share_of, splat_of, is_drawn, surface_pixels, grade_of, graded}
#import meniscus::strips::{Strip, part_of, item_count, item_at, first_of_lane, splat_of_item}
#import meniscus::tally::count
#ifdef SHAPED
#import meniscus::ellipsoid::{Ellipsoid, bounding_sphere, ellipsoid_of, front_of, is_ellipsoid_drawn, ellipsoid_pixels, hit_at}
#endif

@group(0) @binding(0) var<uniform> camera: Camera;
@group(0) @binding(1) var<uniform> splats: SplatSet;
@group(0) @binding(4) var<storage, read_write> nearest: array<atomic<u32>>;

#ifdef SHAPED
@group(0) @binding(6) var<storage, read> shapes: array<vec4<u32>>;
#endif

#ifdef TESTED
@group(0) @binding(5) var farthest: texture_2d<f32>;

const TILE: i32 = 8;
// Splats of more tiles than this to a side are drawn without asking. A look takes a hundredth of what the pixels of a tile take, but
// lavapipe ends the loops of an invocation (strips.inc.wgsl), and lanes of a GPU wait for each other.
#ifdef HARDWARE
const MOST_TILES: i32 = 4;
#else
const MOST_TILES: i32 = 64;
#endif

fn farthest_in(column: i32, row: i32) -> f32 {
    return textureLoad(farthest, vec2(column, row), 0).x;
}

// Whether all that the splat could show in is nearer already, as far as the tiles tell (farthest.wgsl).
fn is_hidden(first: vec2<i32>, last: vec2<i32>, front: f32) -> bool {
    let a = first / TILE;
    let b = last / TILE;
    if any(b - a >= vec2(MOST_TILES)) {
        return false;
    }
    var found = 0.0;
    // Two rows and two columns at a time: most splats have no more.
    for (var y = a.y; y <= b.y; y += 2) {
        let below = min(y + 1, b.y);
        for (var x = a.x; x <= b.x; x += 2) {
            let right = min(x + 1, b.x);
            let of_upper = max(farthest_in(x, y), farthest_in(right, y));
            let of_lower = max(farthest_in(x, below), farthest_in(right, below));
            found = max(found, max(of_upper, of_lower));
        }
    }
    return found <= front;
}

#ifdef SHAPED
fn is_sphere_hidden(grid: Grid, sphere: Splat) -> bool {
    let front = sphere.center.z - sphere.radius;
    if front < camera.near_world {
        return false;
    }
    let box = surface_pixels(grid, sphere);
    return any(box.last < box.first) || is_hidden(box.first, box.last, front);
}
#endif
#endif

const LANES: u32 = 64u;

// Gives the number of pixels looked at.
fn draw(grid: Grid, splat: Splat, origin: Strip, lane: u32) -> u32 {
    let box = surface_pixels(grid, splat);
    if any(box.last < box.first) {
        return 0u;
    }
#ifdef TESTED
    if is_hidden(box.first, box.last, splat.center.z - splat.radius) {
        return 0u;
    }
#endif
    let part = part_of(origin, box.first, box.last, lane);
    // Chord of each pixel as in `chord_at`, with what is constant for a splat taken out of the loop.
    let d = splat.center.z;
    let lift = mix(1.0, d, grid.perspective);
    let plane_first = grid.first + vec2<f32>(part.first) * grid.step;
    let plane_step = grid.step * vec2<f32>(part.step);
    let o_first = plane_first * lift - splat.center.xy;
    let o_step = plane_step * lift;
    let s_first = plane_first * grid.perspective;
    let s_step = plane_step * grid.perspective;
    let radius_squared = splat.radius * splat.radius;
    let floor_squared = select(-1.0, 0.0, box.is_point);
    let front = d - splat.radius;
    let front_bits = bitcast<u32>(front);
    let grade = grade_of(splats, splat.radius);
    let columns = part.last.x - part.first.x;
    let row_step = u32(part.step.y * (grid.last_px.x + 1));
    var row = u32(part.first.y) * u32(grid.last_px.x + 1) + u32(part.first.x);
    var o = o_first;
    var s = s_first;
    var x = 0;
    // One loop, not two: lanes whose splats have other numbers of rows and columns wait less for each other.
    for (var y = part.first.y; y <= part.last.y;) {
        let pixel = row + u32(x);
        let stored = atomicLoad(&nearest[pixel]);
        // The sphere's nearest point is behind what is there: nothing to win.
        if stored > front_bits {
            let a = 1.0 + s.y * s.y + s.x * s.x;
            let k = o.y * s.y + o.x * s.x;
            let reachable = max(k * k + a * (radius_squared - o.y * o.y - o.x * o.x), floor_squared);
            let bits = graded(max(d - (k + sqrt(reachable)) / a, front), grade);
            if reachable >= 0.0 && bits < stored {
                atomicMin(&nearest[pixel], bits);
            }
        }
        x += part.step.x;
        let is_end = x > columns;
        x = select(x, 0, is_end);
        y += select(0, part.step.y, is_end);
        row += select(0u, row_step, is_end);
        o = select(vec2(o.x + o_step.x, o.y), vec2(o_first.x, o.y + o_step.y), is_end);
        s = select(vec2(s.x + s_step.x, s.y), vec2(s_first.x, s.y + s_step.y), is_end);
    }
    return part.visited;
}

#ifdef SHAPED
// As `draw`.
fn draw_ellipsoid(grid: Grid, ellipsoid: Ellipsoid, origin: Strip, lane: u32) -> u32 {
    let box = ellipsoid_pixels(grid, ellipsoid);
    if any(box.last < box.first) {
        return 0u;
    }
    let front = front_of(ellipsoid);
#ifdef TESTED
    if is_hidden(box.first, box.last, front) {
        return 0u;
    }
#endif
    let part = part_of(origin, box.first, box.last, lane);
    // Both vectors of `hit_at` are linear in the pixel.
    let d = ellipsoid.splat.center.z;
    let lift = mix(1.0, d, grid.perspective);
    let plane_first = grid.first + vec2<f32>(part.first) * grid.step;
    let plane_step = grid.step * vec2<f32>(part.step);
    let o_first = plane_first * lift - ellipsoid.splat.center.xy;
    let s_first = plane_first * grid.perspective;
    let along_x = ellipsoid.to_sphere[0] * plane_step.x;
    let along_y = ellipsoid.to_sphere[1] * plane_step.y;
    let floor_squared = select(-1.0, 0.0, box.is_point);
    let front_bits = bitcast<u32>(front);
    let grade = grade_of(splats, ellipsoid.splat.radius);
    let row_step = u32(part.step.y * (grid.last_px.x + 1));
    var row = u32(part.first.y) * u32(grid.last_px.x + 1) + u32(part.first.x);
    var o_row = ellipsoid.to_sphere * vec3(o_first, 0.0);
    var s_row = ellipsoid.to_sphere * vec3(s_first, 1.0);
    let columns = part.last.x - part.first.x;
    for (var y = part.first.y; y <= part.last.y; y += part.step.y) {
        var o = o_row;
        var s = s_row;
        for (var x = 0; x <= columns; x += part.step.x) {
            let pixel = row + u32(x);
            let stored = atomicLoad(&nearest[pixel]);
            if stored > front_bits {
                let hit = hit_at(ellipsoid, o, s);
                let reachable = max(hit.reachable, floor_squared);
                let bits = graded(max(d - (hit.k + sqrt(reachable)) / hit.a, front), grade);
                if reachable >= 0.0 && bits < stored {
                    atomicMin(&nearest[pixel], bits);
                }
            }
            o += along_x * lift;
            s += along_x * grid.perspective;
        }
        row += row_step;
        o_row += along_y * lift;
        s_row += along_y * grid.perspective;
    }
    return part.visited;
}
#endif

fn draw_particle(grid: Grid, origin: Strip, lane: u32) -> u32 {
    let particle = particle_at(origin.particle);
#ifdef SHAPED
    if origin.shape > 0u {
#ifdef TESTED
        // Most are hidden, which is found sooner without their shapes.
        if is_sphere_hidden(grid, bounding_sphere(camera, splats, particle, origin.keep)) {
            return 0u;
        }
#endif
        let ellipsoid = ellipsoid_of(camera, splats, particle, origin.keep, shapes[origin.shape - 1u]);
        if is_ellipsoid_drawn(camera, ellipsoid) {
            return draw_ellipsoid(grid, ellipsoid, origin, lane);
        }
        return 0u;
    }
#endif
    let splat = splat_of(camera, splats, particle, origin.keep);
    if is_drawn(camera, splat) {
        return draw(grid, splat, origin, lane);
    }
    return 0u;
}

@compute @workgroup_size(LANES)
fn main(@builtin(workgroup_id) group: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>, @builtin(local_invocation_index) lane: u32) {
    let grid = grid_of(camera, 1u);
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
