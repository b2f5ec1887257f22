// Spheres as triangles, one for each, around its outline: vertices are pulled from the particles, fragments find the distance of the
// sphere, and the depth buffer keeps the nearest. Pixels are those of the compute pass. For perspective cameras.
#import meniscus::camera::Camera
#import meniscus::page::particle_at
#import meniscus::splat::{Splat, Grid, grid_of, is_drawn, surface_pixels, chord_at}

@group(0) @binding(0) var<uniform> camera: Camera;
@group(0) @binding(1) var<uniform> radius_world: f32;

struct Corner {
    @builtin(position) place: vec4<f32>,
    // Tangents of the line of sight; the same in all of the picture's planes, so that no correction for perspective is needed.
    @location(0) @interpolate(linear) plane: vec2<f32>,
    // Centre of the sphere: view-space x, y, distance. Least half chord, squared, of a pixel that shows it: 0 for points, which
    // show in their pixel also where its centre misses them.
    @location(1) @interpolate(flat) sphere: vec4<f32>,
}

// Kept between the outline and the triangle, in pixels: corners are rounded to 1/256.
const MARGIN_PX: f32 = 1.0 / 64.0;
// Of the triangle around the centre of a single pixel: its corners stay within the pixel.
const POINT_PX: f32 = 0.25;

@vertex
fn vertex(@builtin(vertex_index) index: u32) -> Corner {
    let grid = grid_of(camera, 1u);
    let p = (camera.view_from_world * vec4(particle_at(index / 3u).position_world, 1.0)).xyz;
    let sphere = Splat(vec3(p.xy, -p.z), radius_world, 0.0);
    let pixels = surface_pixels(grid, sphere);
    if !is_drawn(camera, sphere) || any(pixels.last < pixels.first) {
        // All three corners in one place cover nothing.
        return Corner(vec4(0.0, 0.0, 0.0, 1.0), vec2(0.0), vec4(0.0));
    }
    // The outline is an ellipse, longer along the line through the middle of the picture: the footprint's formula along both axes.
    let d = sphere.center.z;
    let beyond = d * d - sphere.radius * sphere.radius;
    let off = length(sphere.center.xy);
    let px = abs(grid.step.x);
    var middle = sphere.center.xy * (d / beyond);
    var along = sphere.radius * sqrt(off * off + beyond) / beyond + MARGIN_PX * px;
    var across = sphere.radius * inverseSqrt(beyond) + MARGIN_PX * px;
    if pixels.is_point {
        middle = grid.first + vec2<f32>(pixels.first) * grid.step;
        along = POINT_PX * px;
        across = along;
    }
    // An equilateral triangle around a circle has its corners on one of twice the radius.
    let corner = index % 3u;
    let a = along * select(-1.0, 2.0, corner == 0u);
    let b = across * sqrt(3.0) * (f32(corner & 1u) - f32(corner >> 1u));
    let outwards = select(vec2(1.0, 0.0), sphere.center.xy / off, off > 0.0);
    let plane = middle + a * outwards + b * vec2(-outwards.y, outwards.x);
    let nearest = camera.near_world / (d - sphere.radius);
    return Corner(
        vec4(plane / camera.half_extent, nearest, 1.0),
        plane,
        vec4(sphere.center, select(-1.0, 0.0, pixels.is_point)),
    );
}

const PERSPECTIVE: Grid = Grid(vec2<f32>(0.0, 0.0), vec2<f32>(0.0, 0.0), vec2<i32>(0, 0), 1.0);

// Nothing is nearer than the triangle, which may be tested before its fragments are shaded.
@fragment @early_depth_test(less_equal)
fn fragment(corner: Corner) -> @builtin(frag_depth) f32 {
    let sphere = Splat(corner.sphere.xyz, radius_world, 0.0);
    let chord = chord_at(PERSPECTIVE, sphere, corner.plane);
    let reachable = max(chord.half_squared, corner.sphere.w);
    if reachable < 0.0 {
        discard;
    }
    return min(camera.near_world / (chord.middle - sqrt(reachable)), corner.place.z);
}
