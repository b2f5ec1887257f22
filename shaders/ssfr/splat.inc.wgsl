#define_import_path meniscus::splat
#import meniscus::camera::Camera
#import meniscus::particle::{PackedParticle, StandIn, kept}

// What all splats of one set share.
struct SplatSet {
    radius_world: f32,
    volume_world: f32,
    // Steps per world unit of the fixed-point thickness.
    steps_per_world: f32,
    // How much of the growth of thinned particles is needed (particle.inc.wgsl).
    closing: f32,
    // Whether the last bits of distances tell how the radius of the visible splat compares with the set's.
    is_graded: u32,
    // Farthest that the centre of an ellipsoid is moved.
    most_shift_world: f32,
    // Most that a half-axis of an ellipsoid is of the radius.
    longest_axis: f32,
}

// Grades of radii: bits of a distance that they take, of which a few millionths of it are lost, and grades per factor of two.
// The set's radius itself and twice that have a grade of their own.
const GRADE_BITS: u32 = 31u;
const GRADES_PER_OCTAVE: f32 = 15.0;
const GRADE_OF_ONE: f32 = 16.0;

// What is stored of a distance, and what stands in its other bits.
struct Grade {
    distance_bits: u32,
    bits: u32,
}

fn grade_of(splats: SplatSet, radius_world: f32) -> Grade {
#ifdef UNIFORM
    return Grade(0xffffffffu, 0u);
#else
    let octaves = log2(max(radius_world / splats.radius_world, 1e-6));
    let grade = u32(clamp(round(GRADE_OF_ONE + GRADES_PER_OCTAVE * octaves), 0.0, f32(GRADE_BITS)));
    let is_graded = splats.is_graded != 0u;
    return Grade(select(0xffffffffu, ~GRADE_BITS, is_graded), select(0u, grade, is_graded));
#endif
}

// Orders as the distance does.
fn graded(distance: f32, grade: Grade) -> u32 {
    return bitcast<u32>(distance) & grade.distance_bits | grade.bits;
}

// What a radius of this grade is of the set's.
fn radius_of_grade(grade: u32) -> f32 {
    return exp2((f32(grade) - GRADE_OF_ONE) / GRADES_PER_OCTAVE);
}

// The pixel centres of a picture. Plane coordinates are tangents x/d, y/d (perspective) or view-space x, y (parallel);
// pixel (i, j) is centred at first + (i, j) * step.
struct Grid {
    first: vec2<f32>,
    step: vec2<f32>,
    last_px: vec2<i32>,
    // 1 for perspective, 0 for parallel projection.
    perspective: f32,
}

// A particle ready to be drawn. `center` is its view-space x, y and its distance.
struct Splat {
    center: vec3<f32>,
    radius: f32,
    volume: f32,
}

// Pixels whose centres lie in the splat's bounding rectangle; empty when last < first.
struct Footprint {
    first: vec2<i32>,
    last: vec2<i32>,
    // Half sizes of the rectangle in pixels, before rounding.
    half_px: vec2<f32>,
    // Centre in pixels; the top left corner of the picture is (0, 0).
    center_px: vec2<f32>,
}

// Where the line of sight through a pixel enters and leaves a sphere.
struct Chord {
    // Half of the stretch of distances inside the sphere, squared; negative = miss.
    half_squared: f32,
    // Distance halfway.
    middle: f32,
    // Length along the ray per unit of distance.
    stretch: f32,
}

// Below this half size in pixels a sphere may slip between pixel centres (half the diagonal of a pixel).
const POINT_HALF_PX: f32 = 0.71;

// The pixel grid of the picture, or of the picture reduced by `scale`, whose pixels are blocks of scale x scale.
fn grid_of(camera: Camera, scale: u32) -> Grid {
    let step = 2.0 * camera.half_extent / vec2<f32>(camera.size_px) * f32(scale) * vec2(1.0, -1.0);
    let corner = camera.half_extent * vec2(-1.0, 1.0);
    let size = (camera.size_px + scale - 1u) / scale;
    return Grid(corner + 0.5 * step, step, vec2<i32>(size) - 1, select(1.0, 0.0, camera.orthographic != 0u));
}

// The IEEE half in the low 16 bits, >= 0. (unpack2x16float needs an optional capability.)
fn half_to_float(bits: u32) -> f32 {
    // The exponent of a half is biased by 15, that of a float by 127.
    return bitcast<f32>((bits & 0xffffu) << 13u) * 0x1p+112f;
}

// Workgroups share the ranges of a list out between them: the number of a workgroup, and how many there are.
struct Share {
    first: u32,
    step: u32,
}

fn share_of(group: vec3<u32>, groups: vec3<u32>) -> Share {
    return Share(group.y * groups.x + group.x, groups.x * groups.y);
}

// With UNIFORM every particle is known to be kept and to have the set's radius.
fn splat_of(camera: Camera, splats: SplatSet, particle: PackedParticle, keep: u32) -> Splat {
    let p = (camera.view_from_world * vec4(particle.position_world, 1.0)).xyz;
#ifdef UNIFORM
    return Splat(vec3(p.xy, -p.z), splats.radius_world, splats.volume_world);
#else
    let relative = half_to_float(particle.packed >> 16u);
    let chosen = kept(particle.packed, keep, splats.closing);
    return Splat(
        vec3(p.xy, -p.z),
        splats.radius_world * relative * chosen.radius,
        splats.volume_world * relative * relative * relative * chosen.weight,
    );
#endif
}

// A stand-in for particles of a set whose `radius_world` is the spacing.
fn splat_of_stand_in(camera: Camera, splats: SplatSet, stand_in: StandIn) -> Splat {
    let p = (camera.view_from_world * vec4(stand_in.center_world, 1.0)).xyz;
    let radius = splats.radius_world * half_to_float(stand_in.packed >> 16u);
    return Splat(vec3(p.xy, -p.z), radius, splats.volume_world * half_to_float(stand_in.packed));
}

// A splat that reaches before the near distance is not drawn at all; that also keeps the eye outside of every splat.
fn is_drawn(camera: Camera, splat: Splat) -> bool {
    return splat.radius > 0.0 && splat.center.z - splat.radius >= camera.near_world;
}

// Exact bounding rectangle (algorithms.md 1.2, solved for the sphere): tangents of the lines from the eye that touch the
// circle in which the sphere meets the xz or yz plane.
fn footprint(grid: Grid, splat: Splat) -> Footprint {
    let d = splat.center.z;
    let r = splat.radius;
    // Selected, not branched on: lavapipe of Mesa 22.3 compiles a shader anew in every frame of which a condition depends on
    // uniforms alone.
    let is_perspective = grid.perspective > 0.0;
    let inverse = 1.0 / (d * d - r * r);
    let slope = r * sqrt(splat.center.xy * splat.center.xy + (d * d - r * r)) * inverse;
    let middle = select(splat.center.xy, splat.center.xy * (d * inverse), is_perspective);
    let half = select(vec2(r), slope, is_perspective);
    let center = select(splat.center.xy, splat.center.xy / d, is_perspective);
    return rectangle(grid, middle, half, center);
}

// The footprint of what reaches `half` to both sides of `middle` in plane coordinates, its centre being `center`.
fn rectangle(grid: Grid, middle: vec2<f32>, half: vec2<f32>, center: vec2<f32>) -> Footprint {
    let to_px = 1.0 / grid.step;
    let middle_px = (middle - grid.first) * to_px;
    let half_px = half * abs(to_px);
    // Far outside of the picture the conversion to integers would overflow.
    let far = vec2<f32>(grid.last_px) + 2.0;
    let low = clamp(ceil(middle_px - half_px), vec2(0.0), far);
    let high = clamp(floor(middle_px + half_px), vec2(-1.0), far - 2.0);
    return Footprint(vec2<i32>(low), vec2<i32>(high), half_px, (center - grid.first) * to_px + 0.5);
}

// The ellipse in which a splat shows, plane coordinates: its centre, and the matrix of which n . M n is the square of how far it reaches
// along n.
struct Outline {
    middle: vec2<f32>,
    xx: f32,
    xy: f32,
    yy: f32,
}

// The outline whose bounding rectangle is `footprint`.
fn outline_of(grid: Grid, splat: Splat) -> Outline {
    let at = splat.center.xy;
    let d = splat.center.z;
    let square = splat.radius * splat.radius;
    let beyond = d * d - square;
    let scale = square / (beyond * beyond);
    let is_perspective = grid.perspective > 0.0;
    let middle = select(at, at * (d / beyond), is_perspective);
    let reach = select(vec2(square), (at * at + beyond) * scale, is_perspective);
    return Outline(middle, reach.x, select(0.0, at.x * at.y * scale, is_perspective), reach.y);
}

// Pixels that a splat is drawn to: its footprint, or the one pixel that holds its centre.
struct SurfacePixels {
    first: vec2<i32>,
    last: vec2<i32>,
    is_point: bool,
}

fn surface_pixels(grid: Grid, splat: Splat) -> SurfacePixels {
    return pixels_of(grid, footprint(grid, splat));
}

fn pixels_of(grid: Grid, whole: Footprint) -> SurfacePixels {
    if max(whole.half_px.x, whole.half_px.y) >= POINT_HALF_PX {
        return SurfacePixels(whole.first, whole.last, false);
    }
    let at = vec2<i32>(floor(clamp(whole.center_px, vec2(-1.0), vec2<f32>(grid.last_px) + 1.0)));
    let is_outside = any(at < vec2(0)) || any(at > grid.last_px);
    return SurfacePixels(at, select(at, at - 1, is_outside), true);
}

// Line of sight at plane coordinates `plane` against the sphere (algorithms.md 1.1). Written around the point of the ray
// at the distance of the centre, so that nothing of the order of distance squared is subtracted: with o from the centre
// to that point and s the step of the ray per distance, |o + t s| = R.
fn chord_at(grid: Grid, splat: Splat, plane: vec2<f32>) -> Chord {
    let s = plane * grid.perspective;
    let o = plane * mix(1.0, splat.center.z, grid.perspective) - splat.center.xy;
    let a = 1.0 + dot(s, s);
    let k = dot(o, s);
    let inverse = 1.0 / a;
    let half_squared = (k * k + a * (splat.radius * splat.radius - dot(o, o))) * inverse * inverse;
    return Chord(half_squared, splat.center.z - k * inverse, sqrt(a));
}
