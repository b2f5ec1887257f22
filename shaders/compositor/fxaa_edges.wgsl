// Lists the pixels whose brightness differs enough from that of their neighbours for anti-aliasing to work on them. Each invocation
// looks at four neighbours of a row, which are one word.
#import meniscus::edges::{Smoothing, MIN_CONTRAST, RELATIVE_CONTRAST}
#import meniscus::luma::words_per_row
#import meniscus::texels::texel

// `Edges` while it is filled.
struct Filling {
    count: atomic<u32>,
    packed: array<u32>,
}

@group(0) @binding(0) var<uniform> smoothing: Smoothing;
@group(0) @binding(1) var lumas: texture_2d<u32>;
@group(0) @binding(2) var<storage, read_write> edges: Filling;

fn word_at(index: u32) -> u32 {
    return textureLoad(lumas, texel(index, smoothing.row_bits), 0).x;
}

@compute @workgroup_size(16, 4)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    let size = smoothing.size_px;
    let words = words_per_row(size.x);
    if id.x >= words || id.y >= size.y {
        return;
    }
    let row = id.y * words;
    let word = word_at(row + id.x);
    let m = unpack4x8unorm(word);
    let n = unpack4x8unorm(word_at(row - select(0u, words, id.y > 0u) + id.x));
    let s = unpack4x8unorm(word_at(row + select(0u, words, id.y + 1u < size.y) + id.x));
    let before = unpack4x8unorm(word_at(row + max(id.x, 1u) - 1u)).w;
    let after = unpack4x8unorm(word_at(row + min(id.x + 1u, words - 1u))).x;
    // At the border the picture goes on as it ends.
    let w = vec4(select(m.x, before, id.x > 0u), m.xyz);
    let e = vec4(m.yzw, select(m.w, after, id.x + 1u < words));
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
