#define_import_path meniscus::material

// A surface with a procedural tone. One formula serves all patterns, with their numbers from the host: software drivers
// execute every branch of a choice.
struct Material {
    // Linear Rec. 709.
    color: vec3<f32>,
    roughness: f32,
    metallic: f32,
    // Size of the pattern's largest element, world units.
    scale_world: f32,
    // Joints between elements: half their width in elements, and their tone.
    joint_half_width: f32,
    joint_tone: f32,
    // How much elements differ in tone.
    element_amplitude: f32,
    // Two octaves of noise: cells per element, and amplitude.
    coarse_frequency: f32,
    coarse_amplitude: f32,
    fine_frequency: f32,
    fine_amplitude: f32,
    pad_a: f32,
    pad_b: f32,
    pad_c: f32,
}

// Hash of an integer cell to [0, 1).
fn cell_hash(cell: vec2<f32>) -> f32 {
    // Cells beyond a million look alike from anywhere, and the conversion must not overflow.
    let c = vec2<i32>(clamp(cell, vec2(-1e6), vec2(1e6)));
    var h = (bitcast<u32>(c.x) * 0x9e3779b1u) ^ (bitcast<u32>(c.y) * 0x85ebca77u);
    h = (h ^ (h >> 15u)) * 0x2c1b3c6du;
    h = (h ^ (h >> 12u)) * 0x297a2d39u;
    h ^= h >> 15u;
    return f32(h >> 8u) * 5.9604645e-8;
}

// Value noise in [-1, 1], faded to its mean 0 where the footprint covers its cells.
fn noise(p: vec2<f32>, footprint: f32) -> f32 {
    let fade = clamp(1.5 - 2.0 * footprint, 0.0, 1.0);
    let cell = floor(p);
    let f = p - cell;
    let u = f * f * (3.0 - 2.0 * f);
    let bottom = mix(cell_hash(cell), cell_hash(cell + vec2(1.0, 0.0)), u.x);
    let top = mix(cell_hash(cell + vec2(0.0, 1.0)), cell_hash(cell + vec2(1.0, 1.0)), u.x);
    return fade * (2.0 * mix(bottom, top, u.y) - 1.0);
}

// Share of the interval of length `footprint` around x that lies within half_width of an integer.
fn joint_coverage(x: f32, footprint: f32, half_width: f32) -> f32 {
    let w = max(footprint, 1e-4);
    let lo = x - 0.5 * w + half_width;
    let hi = x + 0.5 * w + half_width;
    let covered = floor(hi) + min(fract(hi) / (2.0 * half_width), 1.0) - floor(lo) - min(fract(lo) / (2.0 * half_width), 1.0);
    return clamp(covered * 2.0 * half_width / w, 0.0, 1.0);
}

// Factor on the base colour at the point `p` (pattern coordinates, 1 = one element), averaged over a pixel's footprint along
// both axes in the same coordinates.
fn pattern_tone(m: Material, p: vec2<f32>, footprint: vec2<f32>) -> f32 {
    let wide = max(footprint.x, footprint.y);
    // Integers are joints: an element is the cell between them.
    let element = (cell_hash(floor(p)) - 0.5) * clamp(1.25 - wide, 0.0, 1.0);
    let coarse = noise(p * m.coarse_frequency, wide * m.coarse_frequency);
    let fine = noise(p * m.fine_frequency, wide * m.fine_frequency);
    let x = joint_coverage(p.x, footprint.x, m.joint_half_width);
    let y = joint_coverage(p.y, footprint.y, m.joint_half_width);
    let joint = 1.0 - (1.0 - x) * (1.0 - y);
    return (1.0 + m.element_amplitude * element + m.coarse_amplitude * coarse + m.fine_amplitude * fine) * mix(1.0, m.joint_tone, joint);
}
