#define_import_path meniscus::material

struct Material {
    // Linear Rec. 709.
    color: vec3<f32>,
    roughness: f32,
    metallic: f32,
    // One of PATTERN_*.
    pattern: u32,
    // Size of the pattern's largest element, world units.
    scale_world: f32,
    pad: f32,
}

const PATTERN_PLAIN: u32 = 0u;
const PATTERN_TILES: u32 = 1u;
const PATTERN_CONCRETE: u32 = 2u;
const PATTERN_SOIL: u32 = 3u;

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
    if fade == 0.0 {
        return 0.0;
    }
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

// Factor on the base colour at the point `p` (pattern coordinates, 1 = one element), with the size of a pixel's footprint
// along both axes in the same coordinates.
fn pattern_tone(pattern: u32, p: vec2<f32>, footprint: vec2<f32>) -> f32 {
    let wide = max(footprint.x, footprint.y);
    if pattern == PATTERN_TILES {
        let joint = 1.0 - (1.0 - joint_coverage(p.x, footprint.x, 0.012)) * (1.0 - joint_coverage(p.y, footprint.y, 0.012));
        // Integers are joints: the tile is the cell between them.
        let tone = (cell_hash(floor(p)) - 0.5) * clamp(1.25 - wide, 0.0, 1.0);
        let cloud = noise(p * 5.3, wide * 5.3);
        return (1.0 + 0.09 * tone + 0.035 * cloud) * mix(1.0, 0.52, joint);
    }
    if pattern == PATTERN_CONCRETE {
        let joint = 1.0 - (1.0 - joint_coverage(p.x, footprint.x, 0.006)) * (1.0 - joint_coverage(p.y, footprint.y, 0.006));
        let cloud = noise(p * 2.7, wide * 2.7) + 0.5 * noise(p * 6.9 + 17.0, wide * 6.9);
        let pores = noise(p * 61.0, wide * 61.0);
        return (1.0 + 0.09 * cloud + 0.05 * pores) * mix(1.0, 0.6, joint);
    }
    if pattern == PATTERN_SOIL {
        let coarse = noise(p * 3.1, wide * 3.1);
        let middle = noise(p * 11.0 + 5.0, wide * 11.0);
        let fine = noise(p * 47.0, wide * 47.0);
        return 1.0 + 0.14 * coarse + 0.12 * middle + 0.12 * fine;
    }
    return 1.0;
}
