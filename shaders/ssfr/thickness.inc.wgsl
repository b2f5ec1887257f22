#define_import_path meniscus::thickness

struct Thickness {
    // Size of the reduced image; its pixels are blocks of scale x scale.
    size_px: vec2<u32>,
    scale: u32,
    // World units per step of the fixed-point sums.
    world_per_step: f32,
    // Standard deviation of the smoothing in spacings.
    sigma_spacings: f32,
    // Spacing of the particles per drawn radius.
    spacing_per_radius: f32,
    // From this half size in blocks on a sphere's profile is sampled. Smaller splats are shared out between the four
    // nearest blocks: samples would depend on where in the block the centre lies.
    profile_half_px: f32,
    pad: f32,
}

// What a block of the picture tells the smoothing, in the texels of the reduced surface.
struct Block {
    // Nearest surface.
    nearest: f32,
    // Part that shows fluid, of what the scene does not hide.
    covered: f32,
    // Standard deviation of the smoothing in blocks; 0 where there is no surface.
    sigma: f32,
}

fn block_of(texel: vec4<f32>) -> Block {
    return Block(texel.x, texel.y, texel.z);
}

// What the last pass of the smoothing leaves of a block, in the texels of the smoothed thickness; the others leave thickness, coverage
// and standard deviation.
struct SmoothedBlock {
    // Mean over what is covered, world units along the ray.
    thickness_world: f32,
    // As in `Block`.
    nearest: f32,
    covered: f32,
}

fn smoothed_block_of(texel: vec4<f32>) -> SmoothedBlock {
    return SmoothedBlock(texel.x, texel.y, texel.z);
}

// From here on a sum takes no more: half of the range, so that additions in flight never wrap.
const SATURATED: u32 = 0x80000000u;
