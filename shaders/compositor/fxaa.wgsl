// Edge anti-aliasing after Lottes 2009 (FXAA): where brightness changes sharply, find the ends of the edge that the pixel
// lies on and mix with the neighbour across it by the share of the pixel that the true edge would cut off.

@group(0) @binding(0) var<uniform> size_px: vec4<u32>;
@group(0) @binding(1) var<storage, read> source: array<u32>;
@group(0) @binding(2) var<storage, read_write> smoothed: array<u32>;

// Least contrast that is treated, absolute and relative to the brightest neighbour.
const MIN_CONTRAST: f32 = 0.035;
const RELATIVE_CONTRAST: f32 = 0.11;
// Pixels searched along the edge in each direction.
const SEARCH: i32 = 10;

fn at(pixel: vec2<i32>) -> vec4<f32> {
    let p = vec2<u32>(clamp(pixel, vec2(0), vec2<i32>(size_px.xy) - 1));
    return unpack4x8unorm(source[p.y * size_px.x + p.x]);
}

// Brightness as the eye weighs it, with alpha so that the edges of a transparent picture are found too.
fn luma_of(color: vec4<f32>) -> f32 {
    return dot(color, vec4(0.299, 0.587, 0.114, 0.5));
}

fn luma(pixel: vec2<i32>) -> f32 {
    return luma_of(at(pixel));
}

// Steps along the edge until the mean brightness across it leaves `mean` by more than `gradient`, at most SEARCH, and the
// sign of the difference there.
fn edge_end(pixel: vec2<i32>, along: vec2<i32>, across: vec2<i32>, mean: f32, gradient: f32) -> vec2<f32> {
    var difference = 0.0;
    for (var i = 1; i <= SEARCH; i++) {
        let p = pixel + i * along;
        difference = 0.5 * (luma(p) + luma(p + across)) - mean;
        if abs(difference) >= gradient {
            return vec2(f32(i), difference);
        }
    }
    return vec2(f32(SEARCH), difference);
}

fn filtered(pixel: vec2<i32>) -> vec4<f32> {
    let center = at(pixel);
    let m = luma_of(center);
    let n = luma(pixel + vec2(0, -1));
    let s = luma(pixel + vec2(0, 1));
    let w = luma(pixel + vec2(-1, 0));
    let e = luma(pixel + vec2(1, 0));
    let brightest = max(m, max(max(n, s), max(w, e)));
    let contrast = brightest - min(m, min(min(n, s), min(w, e)));
    if contrast < max(MIN_CONTRAST, RELATIVE_CONTRAST * brightest) {
        return center;
    }
    let nw = luma(pixel + vec2(-1, -1));
    let ne = luma(pixel + vec2(1, -1));
    let sw = luma(pixel + vec2(-1, 1));
    let se = luma(pixel + vec2(1, 1));
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
    return mix(center, at(pixel + across), blend);
}

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if any(id.xy >= size_px.xy) {
        return;
    }
    smoothed[id.y * size_px.x + id.x] = pack4x8unorm(filtered(vec2<i32>(id.xy)));
}
