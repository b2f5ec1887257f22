#define_import_path meniscus::covered

// The pixels that show fluid, in no particular order, for computed passes that work on the surface only: lanes that have nothing to do
// would cost as much as others. Where pictures are drawn a mask does that, and the list is made for passes that ask for it.
struct CoveredPixels {
    count: u32,
    // x in the low, y in the high 16 bits.
    packed: array<u32>,
}

// The same while it is filled.
struct Filling {
    count: atomic<u32>,
    packed: array<u32>,
}

// Pixels per side of a tile.
const TILE: u32 = 4u;

// The tiles that show fluid, packed as pixels are.
struct CoveredTiles {
    count: u32,
    // Of them together.
    pixels: u32,
    packed: array<u32>,
}

fn pack_pixel(at: vec2<u32>) -> u32 {
    return at.x | (at.y << 16u);
}

fn unpack_pixel(packed: u32) -> vec2<u32> {
    return vec2(packed & 0xffffu, packed >> 16u);
}
