// From the sums of `coloring.wgsl` to a colour per pixel; alpha 0 where no particle near the surface has a value.

@group(0) @binding(0) var<storage, read> sums: array<u32>;
// Linear colours from the start to the end of the scale.
@group(0) @binding(1) var<storage, read> table: array<vec4<f32>>;
@group(0) @binding(2) var colors: texture_storage_2d<rgba32float, write>;

@compute @workgroup_size(64, 1)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    let size = textureDimensions(colors);
    if any(id.xy >= size) {
        return;
    }
    let pixel = id.y * size.x + id.x;
    let weight = sums[2u * pixel];
    if weight == 0u {
        textureStore(colors, id.xy, vec4(0.0));
        return;
    }
    let last = f32(arrayLength(&table) - 1u);
    let at = clamp(f32(sums[2u * pixel + 1u]) / f32(weight), 0.0, 1.0) * last;
    let low = floor(at);
    let color = mix(table[u32(low)], table[u32(min(low + 1.0, last))], at - low);
    textureStore(colors, id.xy, vec4(color.rgb, 1.0));
}
