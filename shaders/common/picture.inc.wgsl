#define_import_path meniscus::picture

// Corners of a triangle that covers the whole picture.
fn corner(index: u32) -> vec4<f32> {
    return vec4(4.0 * vec2<f32>(vec2(index & 1u, index >> 1u)) - 1.0, 0.5, 1.0);
}
