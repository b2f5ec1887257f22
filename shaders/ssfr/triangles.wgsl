// Nearest splat per pixel, as depth.wgsl finds it, drawn: a triangle around the outline of each splat, whose fragments find its distance, of
// which blending keeps the least. One draw for each range; its number is the instance. SHAPED: of ranges some of which are ellipsoids.
#import meniscus::camera::Camera
#import meniscus::page::particle_at
#import meniscus::splat::{SplatSet, Splat, Grid, Outline, SurfacePixels, Grade, grid_of, splat_of, is_drawn, surface_pixels, outline_of, grade_of, graded}
#import meniscus::strips::{item_at, splat_of_item}
#import meniscus::surface::NO_SURFACE
#ifdef SHAPED
#import meniscus::ellipsoid::{ellipsoid_of, front_of, is_ellipsoid_drawn, ellipsoid_pixels, ellipsoid_outline}
#endif

@group(0) @binding(0) var<uniform> camera: Camera;
@group(0) @binding(1) var<uniform> splats: SplatSet;
#ifdef SHAPED
@group(0) @binding(6) var<storage, read> shapes: array<vec4<u32>>;

// What `hit_at` calls o and s.
alias Sight = vec3<f32>;
// Of a step of the line of sight, what `Sight` leaves out, squared.
const LEFT_OUT: f32 = 0.0;
#else
// What `chord_at` calls o and s.
alias Sight = vec2<f32>;
const LEFT_OUT: f32 = 1.0;
#endif

// Everything that fragments need besides their place: a software driver would find it again for each of them.
struct Corner {
    @builtin(position) place: vec4<f32>,
    // Distance of the centre, nearest distance, radius squared, and the least that `reachable` may be.
    @location(0) @interpolate(flat) splat: vec4<f32>,
    @location(1) @interpolate(flat) grade: vec2<u32>,
    // The line of sight in the top left corner of the picture, and how it changes per pixel.
    @location(2) @interpolate(flat) o: Sight,
    @location(3) @interpolate(flat) o_along_x: Sight,
    @location(4) @interpolate(flat) o_along_y: Sight,
    @location(5) @interpolate(flat) s: Sight,
    @location(6) @interpolate(flat) s_along_x: Sight,
    @location(7) @interpolate(flat) s_along_y: Sight,
}

// Room between an outline and its triangle, whose corners are rounded to 1/256 pixel: of small ones the square of so many pixels is added to that
// of their reach, of large ones it is so much of their reach, squared. At least 1/200 pixel together.
const MARGIN_PX: f32 = 0.25;
const MARGIN: f32 = 0x1p-11f;
// How far what is drawn for a point reaches around the centre of its pixel; the corners of its triangle are twice as far away.
const POINT_PX: f32 = 0.25;

// A corner of the triangle, in clip space, for a splat that is drawn at all if it `shows`.
fn place_of(grid: Grid, outline: Outline, pixels: SurfacePixels, shows: bool, index: u32) -> vec4<f32> {
    if !shows || any(pixels.last < pixels.first) {
        // All three corners in one place cover nothing.
        return vec4(0.0, 0.0, 0.0, 1.0);
    }
    let px = abs(grid.step.x);
    let square_px = px * px;
    var around = outline;
    around.xx = outline.xx * (1.0 + MARGIN) + MARGIN_PX * MARGIN_PX * square_px;
    around.xy = outline.xy * (1.0 + MARGIN);
    around.yy = outline.yy * (1.0 + MARGIN) + MARGIN_PX * MARGIN_PX * square_px;
    if pixels.is_point {
        let reach = POINT_PX * POINT_PX * square_px;
        around = Outline(grid.first + vec2<f32>(pixels.first) * grid.step, reach, 0.0, reach);
    }
    // An equilateral triangle around the unit circle, which Cholesky's factor of the matrix maps to the ellipse.
    let i = index % 3u;
    let corner = vec2(select(-1.0, 2.0, i == 0u), sqrt(3.0) * (f32(i & 1u) - f32(i >> 1u)));
    let side = sqrt(around.xx);
    let skew = around.xy / side;
    let rest = sqrt(max(around.yy - skew * skew, 0.0));
    let plane = around.middle + vec2(side * corner.x, skew * corner.x + rest * corner.y);
    return vec4(plane / camera.half_extent, 0.0, 1.0);
}

// `v`, of view-space x, y and distance, where the splat is a sphere.
fn mapped(to_sphere: mat3x3<f32>, v: vec3<f32>) -> Sight {
#ifdef SHAPED
    return to_sphere * v;
#else
    return v.xy;
#endif
}

fn corner_of(grid: Grid, splat: Splat, to_sphere: mat3x3<f32>, front: f32, place: vec4<f32>, is_point: bool) -> Corner {
    let lift = mix(1.0, splat.center.z, grid.perspective);
    let top_left = grid.first - 0.5 * grid.step;
    let grade = grade_of(splats, splat.radius);
    return Corner(
        place,
        vec4(splat.center.z, front, splat.radius * splat.radius, select(-1.0, 0.0, is_point)),
        vec2(grade.distance_bits, grade.bits),
        mapped(to_sphere, vec3(top_left * lift - splat.center.xy, 0.0)),
        mapped(to_sphere, vec3(grid.step.x * lift, 0.0, 0.0)),
        mapped(to_sphere, vec3(0.0, grid.step.y * lift, 0.0)),
        mapped(to_sphere, vec3(top_left * grid.perspective, 1.0)),
        mapped(to_sphere, vec3(grid.step.x * grid.perspective, 0.0, 0.0)),
        mapped(to_sphere, vec3(0.0, grid.step.y * grid.perspective, 0.0)),
    );
}

@vertex
fn vertex(@builtin(vertex_index) index: u32, @builtin(instance_index) instance: u32) -> Corner {
    let grid = grid_of(camera, 1u);
    let origin = splat_of_item(item_at(instance), index / 3u);
    let particle = particle_at(origin.particle);
#ifdef SHAPED
    if origin.shape > 0u {
        let e = ellipsoid_of(camera, splats, particle, origin.keep, shapes[origin.shape - 1u]);
        let pixels = ellipsoid_pixels(grid, e);
        let place = place_of(grid, ellipsoid_outline(grid, e), pixels, is_ellipsoid_drawn(camera, e), index);
        return corner_of(grid, e.splat, e.to_sphere, front_of(e), place, pixels.is_point);
    }
#endif
    let splat = splat_of(camera, splats, particle, origin.keep);
    let pixels = surface_pixels(grid, splat);
    let place = place_of(grid, outline_of(grid, splat), pixels, is_drawn(camera, splat), index);
    let same = mat3x3(vec3(1.0, 0.0, 0.0), vec3(0.0, 1.0, 0.0), vec3(0.0, 0.0, 1.0));
    return corner_of(grid, splat, same, splat.center.z - splat.radius, place, pixels.is_point);
}

@fragment
fn fragment(corner: Corner) -> @location(0) f32 {
    let at = corner.place.xy;
    let o = corner.o + at.x * corner.o_along_x + at.y * corner.o_along_y;
    let s = corner.s + at.x * corner.s_along_x + at.y * corner.s_along_y;
    let a = dot(s, s) + LEFT_OUT;
    let k = dot(o, s);
    let reachable = max(k * k + a * (corner.splat.z - dot(o, o)), corner.splat.w);
    let distance = max(corner.splat.x - (k + sqrt(reachable)) / a, corner.splat.y);
    let bits = graded(distance, Grade(corner.grade.x, corner.grade.y));
    return select(NO_SURFACE, bitcast<f32>(bits), reachable >= 0.0);
}
