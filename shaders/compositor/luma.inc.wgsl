#define_import_path meniscus::luma

// Brightness of the picture for anti-aliasing: one byte per pixel, four neighbours of a row in a texel, so that a pass that does all four
// writes it without asking who has the other bytes.

// What tells one colour from another. Water takes red first: its thin edges are as bright to the eye as the pale ground beside them, and are
// found by red. Blue is left out, as in the original (Lottes 2009).
const WEIGHTS: vec2<f32> = vec2(0.8, 0.2);

// Brightness by these weights; TRANSPARENT: with alpha, so that the edges of a transparent picture are found too. Where all is opaque,
// the byte is for the colours alone; `Smoothing` has what makes the two comparable.
fn luma_byte(color: vec3<f32>, alpha: f32) -> u32 {
    let luma = dot(color.rg, WEIGHTS);
#ifdef TRANSPARENT
    return u32(255.0 / 1.5 * (luma + 0.5 * alpha) + 0.5);
#else
    return u32(255.0 * luma + 0.5);
#endif
}
