#define_import_path meniscus::texels

// Images of the picture that were copied into textures, because software drivers read those several times faster than storage
// buffers. Their rows are 2^row_bits long, whatever the width of the picture.
fn texel(index: u32, row_bits: u32) -> vec2<u32> {
    return vec2(index & ((1u << row_bits) - 1u), index >> row_bits);
}
