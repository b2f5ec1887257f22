// The entry points of lighting models, which are modules `meniscus::model`: one over all pixels of the scene, and one over those
// that show water. A software driver would run through the water's code for pixels without any as well.

#ifdef HARDWARE
#import meniscus::lighting_inputs::{camera, covered, radiance, shows_water}
#import meniscus::covered::unpack_pixel
#else
#import meniscus::lighting_inputs::{camera, shows_water}
#import meniscus::picture::corner
#endif
#ifdef WATER
#import meniscus::model::water_radiance

#ifdef HARDWARE
@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>) {
    let end = covered.count;
    for (var i = id.x; i < end; i += groups.x * 64u) {
        let pixel = unpack_pixel(covered.packed[i]);
        if shows_water(pixel) {
            textureStore(radiance, pixel, water_radiance(pixel));
        }
    }
}
#else
@fragment
fn fragment(@builtin(position) at_px: vec4<f32>) -> @location(0) vec4<f32> {
    let pixel = vec2<u32>(at_px.xy);
    if !shows_water(pixel) {
        discard;
    }
    return water_radiance(pixel);
}
#endif
#else
#import meniscus::model::scene_radiance
#ifdef HARDWARE

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if any(id.xy >= camera.size_px) {
        return;
    }
    textureStore(radiance, id.xy, scene_radiance(id.xy));
}
#else
@fragment
fn fragment(@builtin(position) at_px: vec4<f32>) -> @location(0) vec4<f32> {
    return scene_radiance(vec2<u32>(at_px.xy));
}
#endif
#endif
#ifndef HARDWARE

@vertex
fn vertex(@builtin(vertex_index) index: u32) -> @builtin(position) vec4<f32> {
    return corner(index);
}
#endif
