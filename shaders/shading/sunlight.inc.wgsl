#define_import_path meniscus::sunlight

// How the light on the scene is focused, from 0 to just under 4, and the share of it that reaches the water, 0 to 1: in the
// low and the high half of a word. 1 is exact in both.

const FOCUS_STEPS: f32 = 16384.0;
const SHARE_STEPS: f32 = 65535.0;

fn pack_light(focus: f32, share: f32) -> u32 {
    let low = u32(clamp(focus * FOCUS_STEPS + 0.5, 0.0, 65535.0));
    return low | u32(clamp(share, 0.0, 1.0) * SHARE_STEPS + 0.5) << 16u;
}

fn focus_of(packed: u32) -> f32 {
    return f32(packed & 0xffffu) / FOCUS_STEPS;
}

fn share_of(packed: u32) -> f32 {
    return f32(packed >> 16u) / SHARE_STEPS;
}
