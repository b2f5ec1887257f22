#define_import_path meniscus::edges

// The pixels that anti-aliasing works on, in no particular order: few pictures have many, and a software driver pays for lanes
// that have nothing to do.
struct Edges {
    count: u32,
    // x in the low, y in the high 16 bits.
    packed: array<u32>,
}

// What the passes of anti-aliasing know of the picture.
struct Smoothing {
    size_px: vec2<u32>,
    // Brightness of a byte b of `meniscus::luma`, 0 to 1: scale * b + offset.
    luma_scale: f32,
    luma_offset: f32,
    // Pixels from one row of the display image to the next.
    row_px: u32,
    pad: u32,
}

// Least contrast that is treated, absolute and relative to the brightest neighbour.
const MIN_CONTRAST: f32 = 0.035;
const RELATIVE_CONTRAST: f32 = 0.085;
