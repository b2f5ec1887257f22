// Lists the pixels whose brightness differs enough from that of their neighbours for anti-aliasing to work on them. Each invocation
// looks at four neighbours of a row, which are one word.
#import meniscus::edges::{Smoothing, MIN_CONTRAST, RELATIVE_CONTRAST}

// `Edges` while it is filled.
struct Filling {
    count: atomic<u32>,
    packed: array<u32>,
}

@group(0) @binding(0) var<uniform> smoothing: Smoothing;
@group(0) @binding(1) var lumas: texture_2d<u32>;
@group(0) @binding(2) var<storage, read_write> edges: Filling;

fn lumas_at(at: vec2<u32>) -> vec4<f32> {
    return unpack4x8unorm(textureLoad(lumas, at, 0).x);
}

@compute @workgroup_size(16, 4)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    let size = smoothing.size_px;
    let last = textureDimensions(lumas) - 1u;
    if any(id.xy > last) {
        return;
    }
    let m = lumas_at(id.xy);
    let n = lumas_at(vec2(id.x, max(id.y, 1u) - 1u));
    let s = lumas_at(vec2(id.x, min(id.y + 1u, last.y)));
    let before = lumas_at(vec2(max(id.x, 1u) - 1u, id.y)).w;
    let after = lumas_at(vec2(min(id.x + 1u, last.x), id.y)).x;
    // At the border the picture goes on as it ends.
    let w = vec4(select(m.x, before, id.x > 0u), m.xyz);
    let e = vec4(m.yzw, select(m.w, after, id.x < last.x));
    let brightest = max(m, max(max(n, s), max(w, e)));
    let contrast = brightest - min(m, min(min(n, s), min(w, e)));
    let limit = max(vec4(MIN_CONTRAST), RELATIVE_CONTRAST * (smoothing.luma_scale * brightest + smoothing.luma_offset));
    let x = 4u * id.x + vec4(0u, 1u, 2u, 3u);
    let is_edge = (smoothing.luma_scale * contrast >= limit) & (x < vec4(size.x));
    let bits = select(vec4(0u), vec4(1u, 2u, 4u, 8u), is_edge);
    var found = bits.x | bits.y | bits.z | bits.w;
    if found != 0u {
        var slot = atomicAdd(&edges.count, countOneBits(found));
        while found != 0u {
            edges.packed[slot] = (4u * id.x + firstTrailingBit(found)) | (id.y << 16u);
            found &= found - 1u;
            slot++;
        }
    }
}
