// Edge anti-aliasing after Lottes 2009 (FXAA): where brightness changes sharply, find the ends of the edge that the pixel
// lies on and mix with the neighbour across it by the share of the pixel that the true edge would cut off.
#import meniscus::edges::{Edges, Smoothing}

@group(0) @binding(0) var<uniform> smoothing: Smoothing;
// Four neighbours of a row in a texel.
@group(0) @binding(1) var source: texture_2d<u32>;
@group(0) @binding(2) var lumas: texture_2d<u32>;
@group(0) @binding(3) var<storage, read> edges: Edges;
// Holds `source` already.
@group(0) @binding(4) var<storage, read_write> smoothed: array<u32>;

// Pixels searched along the edge in each direction.
const SEARCH: i32 = 10;

fn inside(pixel: vec2<i32>) -> vec2<u32> {
    return vec2<u32>(clamp(pixel, vec2(0), vec2<i32>(smoothing.size_px) - 1));
}

fn at(pixel: vec2<i32>) -> vec4<f32> {
    let p = inside(pixel);
    return unpack4x8unorm(textureLoad(source, vec2(p.x / 4u, p.y), 0)[p.x & 3u]);
}

// Brightness in bytes of `meniscus::luma`.
fn luma_at(pixel: vec2<i32>) -> f32 {
    let p = inside(pixel);
    let word = textureLoad(lumas, vec2(p.x / 4u, p.y), 0).x;
    return f32((word >> (8u * (p.x & 3u))) & 0xffu);
}

// Steps along the edge until the mean brightness across it leaves `mean` by more than `gradient`, at most SEARCH, and the
// sign of the difference there.
fn edge_end(pixel: vec2<i32>, along: vec2<i32>, across: vec2<i32>, mean: f32, gradient: f32) -> vec2<f32> {
    var difference = 0.0;
    for (var i = 1; i <= SEARCH; i++) {
        let p = pixel + i * along;
        difference = 0.5 * (luma_at(p) + luma_at(p + across)) - mean;
        if abs(difference) >= gradient {
            return vec2(f32(i), difference);
        }
    }
    return vec2(f32(SEARCH), difference);
}

fn filtered(pixel: vec2<i32>) -> vec4<f32> {
    let m = luma_at(pixel);
    let n = luma_at(pixel + vec2(0, -1));
    let s = luma_at(pixel + vec2(0, 1));
    let w = luma_at(pixel + vec2(-1, 0));
    let e = luma_at(pixel + vec2(1, 0));
    let contrast = max(m, max(max(n, s), max(w, e))) - min(m, min(min(n, s), min(w, e)));
    let nw = luma_at(pixel + vec2(-1, -1));
    let ne = luma_at(pixel + vec2(1, -1));
    let sw = luma_at(pixel + vec2(-1, 1));
    let se = luma_at(pixel + vec2(1, 1));
    // Second differences: a horizontal edge changes strongly from row to row.
    let horizontal = abs(nw - 2.0 * w + sw) + 2.0 * abs(n - 2.0 * m + s) + abs(ne - 2.0 * e + se);
    let vertical = abs(nw - 2.0 * n + ne) + 2.0 * abs(w - 2.0 * m + e) + abs(sw - 2.0 * s + se);
    let is_horizontal = horizontal >= vertical;
    let before = select(w, n, is_horizontal);
    let after = select(e, s, is_horizontal);
    var across = select(vec2(1, 0), vec2(0, 1), is_horizontal);
    let along = across.yx;
    let is_before = abs(before - m) >= abs(after - m);
    if is_before {
        across = -across;
    }
    let opposite = select(after, before, is_before);
    let mean = 0.5 * (m + opposite);
    let gradient = 0.25 * abs(opposite - m);
    let forward = edge_end(pixel, along, across, mean, gradient);
    let backward = edge_end(pixel, -along, across, mean, gradient);
    let nearest = select(backward, forward, forward.x < backward.x);
    // Only if the edge turns towards this pixel at its nearer end does it cut the pixel.
    var blend = 0.0;
    if (nearest.y < 0.0) != (m < mean) {
        blend = max(0.5 - nearest.x / (forward.x + backward.x), 0.0);
    }
    // Single bright or dark pixels have no edge to follow: smooth them by how much they stand out of their neighbourhood.
    let around = (2.0 * (n + s + w + e) + nw + ne + sw + se) / 12.0;
    let stands_out = smoothstep(0.0, 1.0, clamp(abs(around - m) / contrast, 0.0, 1.0));
    blend = max(blend, 0.5 * stands_out * stands_out);
    return mix(at(pixel), at(pixel + across), blend);
}

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>) {
    for (var i = id.x; i < edges.count; i += groups.x * 64u) {
        let pixel = vec2(edges.packed[i] & 0xffffu, edges.packed[i] >> 16u);
        smoothed[pixel.y * smoothing.row_px + pixel.x] = pack4x8unorm(filtered(vec2<i32>(pixel)));
    }
}
