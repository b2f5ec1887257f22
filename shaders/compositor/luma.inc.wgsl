#define_import_path meniscus::luma

// Brightness of the picture for anti-aliasing: one byte per pixel, four neighbours of a row in a texel, so that a pass that does all four
// writes it without asking who has the other bytes.

// Brightness as the eye weighs it, with alpha so that the edges of a transparent picture are found too. Where all is opaque, the
// byte is for the colours alone; `Smoothing` has what makes the two comparable.
fn luma_byte(color: vec3<f32>, alpha: f32, is_transparent: bool) -> u32 {
    let luma = dot(color, vec3(0.299, 0.587, 0.114));
    return u32(255.0 * select(luma, (luma + 0.5 * alpha) / 1.5, is_transparent) + 0.5);
}
