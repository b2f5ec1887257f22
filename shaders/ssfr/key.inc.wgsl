#define_import_path meniscus::key
#import meniscus::camera::Camera
#import meniscus::surface::NO_SURFACE

// The key of a distance: a number that is affine in the pixel on every plane, and greater for what is nearer. 1/d under
// perspective, -d in parallel projection (algorithms.md 3.7).

// No surface: behind everything.
const GAP: f32 = -3.4e38;

fn is_gap(key: f32) -> bool {
    return key <= -1.7e38;
}

// Whether a distance is one: positive, and neither the sentinel nor infinite nor NaN. By its bits, because comparisons of
// floats may assume that the last two do not occur.
fn is_surface(distance: f32) -> bool {
    return bitcast<u32>(distance) - 0x00800000u < 0x7e800000u;
}

fn key_of(camera: Camera, distance: f32) -> f32 {
    if !is_surface(distance) {
        return GAP;
    }
    return select(1.0 / distance, -distance, camera.orthographic != 0u);
}

fn distance_of(camera: Camera, key: f32) -> f32 {
    if is_gap(key) {
        return NO_SURFACE;
    }
    return select(1.0 / key, -key, camera.orthographic != 0u);
}

// Change of the key per change of distance, without sign, at `key`.
fn key_per_distance(camera: Camera, key: f32) -> f32 {
    return select(key * key, 1.0, camera.orthographic != 0u);
}

// Slope from the steps to the neighbours on both sides: the smaller where they agree in sign, 0 where they do not, the
// only one beside a gap.
fn smaller_step(after: f32, center: f32, before: f32) -> f32 {
    let forward = after - center;
    let backward = center - before;
    if is_gap(after) {
        return select(backward, 0.0, is_gap(before));
    }
    if is_gap(before) {
        return forward;
    }
    return select(select(backward, forward, abs(forward) < abs(backward)), 0.0, forward * backward <= 0.0);
}
