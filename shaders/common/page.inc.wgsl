#define_import_path meniscus::page
#import meniscus::particle::{PackedParticle, StandIn}

// The elements of a page, 16 bytes each (`page.rs`). Software drivers read a texel for all lanes at once, a word of a buffer lane by
// lane.
#ifdef HARDWARE
@group(0) @binding(11) var<storage, read> page: array<vec4<u32>>;
#else
@group(0) @binding(11) var page: texture_2d<u32>;

// Elements of a row: `ROW` of `page.rs`.
const ROW: u32 = 4096u;
#endif

fn element_at(index: u32) -> vec4<u32> {
#ifdef HARDWARE
    return page[index];
#else
    return textureLoad(page, vec2(index % ROW, index / ROW), 0);
#endif
}

fn particle_at(index: u32) -> PackedParticle {
    let element = element_at(index);
    return PackedParticle(bitcast<vec3<f32>>(element.xyz), element.w);
}

fn stand_in_at(index: u32) -> StandIn {
    let element = element_at(index);
    return StandIn(bitcast<vec3<f32>>(element.xyz), element.w);
}
