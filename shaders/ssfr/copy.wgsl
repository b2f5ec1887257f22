// The filter that leaves the surface as it is.
#import meniscus::camera::Camera

@group(0) @binding(0) var<uniform> camera: Camera;
@group(0) @binding(1) var<storage, read> source: array<f32>;
@group(0) @binding(2) var<storage, read_write> destination: array<f32>;

@compute @workgroup_size(64, 1)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if all(id.xy < camera.size_px) {
        let pixel = id.y * camera.size_px.x + id.x;
        destination[pixel] = source[pixel];
    }
}
