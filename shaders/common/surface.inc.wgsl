#define_import_path meniscus::surface

// f32::MAX: "no surface". A large finite number, because WGSL may assume that infinities do not occur.
const NO_SURFACE: f32 = 0x1.fffffep+127f;
const NO_SURFACE_BITS: u32 = 0x7f7fffffu;

fn is_empty(distance: f32) -> bool {
    // Half of the sentinel, so that a value that went through arithmetic still counts as empty.
    return distance >= 1.7e38;
}

// Octahedral map of a unit vector to two snorm16. (0, 0, 1) maps to the bits 0.
fn pack_normal(n: vec3<f32>) -> u32 {
    let p = n.xy / (abs(n.x) + abs(n.y) + abs(n.z));
    let folded = (1.0 - abs(p.yx)) * select(vec2(-1.0), vec2(1.0), p >= vec2(0.0));
    return pack2x16snorm(select(folded, p, n.z >= 0.0));
}

fn unpack_normal(bits: u32) -> vec3<f32> {
    let p = unpack2x16snorm(bits);
    let z = 1.0 - abs(p.x) - abs(p.y);
    let fold = max(-z, 0.0);
    return normalize(vec3(p - fold * select(vec2(-1.0), vec2(1.0), p >= vec2(0.0)), z));
}
