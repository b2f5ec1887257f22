//! The reflectances that lighting models import, on numbers that rounding or a careless model may hand them.

use meniscus_gpu::role::AttributeValues;
use meniscus_gpu::{Buffer, ComputePipelineDescriptor, Dispatch, Recorder, Shader, Timing};
use meniscus_shading::{INCLUDES, twin::brdf::fresnel_dielectric};

use crate::support::gpu;

const FRESNEL: Shader = Shader {
    name: "test/fresnel",
    source: "#import meniscus::brdf::fresnel_dielectric\n\
        @group(0) @binding(0) var<storage, read> cosines: array<f32>;\n\
        @group(0) @binding(1) var<storage, read_write> reflectances: array<f32>;\n\
        @compute @workgroup_size(64)\n\
        fn main(@builtin(global_invocation_id) id: vec3<u32>) {\n\
          if id.x < arrayLength(&cosines) {\n\
            reflectances[id.x] = fresnel_dielectric(cosines[id.x], 1.333);\n\
          }\n}",
};

#[test]
fn fresnel_reflects_between_nothing_and_all_whatever_the_cosine() {
    let gpu = gpu();
    let cosines: Vec<f32> = (-64..=192).map(|i| i as f32 / 128.0).collect();
    let pipeline = gpu
        .compute_pipeline(&ComputePipelineDescriptor {
            includes: INCLUDES,
            ..ComputePipelineDescriptor::new(FRESNEL)
        })
        .expect("a shader");
    let input = Buffer::<AttributeValues>::from_slice(&gpu, &cosines).expect("a buffer");
    let output = Buffer::<AttributeValues>::from_slice(&gpu, &vec![-1.0; cosines.len()]).expect("a buffer");
    let mut recorder = Recorder::new(&gpu, Timing::Stamps);
    let bindings = [("cosines", input.bind()), ("reflectances", output.bind())];
    let groups = Dispatch::Groups(cosines.len().div_ceil(64) as u64);
    recorder.compute(&gpu, "test.fresnel", &pipeline, &bindings, groups);
    let _ = recorder.submit(&gpu).expect("a driver that runs it");
    for (cosine, found) in cosines.iter().zip(output.read(&gpu).expect("reflectances")) {
        let expected = fresnel_dielectric(*cosine, 1.333);
        assert!((0.0..=1.0).contains(&found), "{cosine}: {found}");
        // The same formula in the same order; the driver may fuse and divide to a few ulps.
        assert!((found - expected).abs() < 1e-5, "{cosine}: {found}, expected {expected}");
    }
}
