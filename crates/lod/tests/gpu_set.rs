//! Against a real device: a missing adapter is a failure, not a skip.

#[allow(dead_code, reason = "shared with the other tests")]
mod common;

use common::{cameras, pool, viewpoint};
use glam::Vec3;
use meniscus_gpu::role::{AttributeValues, KeptRange, Scratch};
use meniscus_gpu::{
    AdapterChoice, Buffer, ComputePipelineDescriptor, Dispatch, Gpu, Recorder, Shader, Timing,
};
use meniscus_lod::cut::MIN_KEEP;
use meniscus_lod::weight::kept;
use meniscus_lod::{ChunkOptions, GpuSet, LodParams, Selector, chunks};

fn gpu() -> Gpu {
    Gpu::new(&AdapterChoice::default()).expect("an adapter, at least mesa-vulkan-drivers")
}

#[test]
fn pages_and_ranges_arrive_and_buffers_are_reused() {
    let gpu = gpu();
    let options = ChunkOptions::new(10_000, 1.0);
    let [large, small, like_small] =
        [[40, 30, 30], [20, 20, 10], [10, 20, 20]].map(|side| chunks::build(&pool(side, 9), &options));
    let camera = cameras(Vec3::new(-30.0, -20.0, 40.0), Vec3::new(20.0, 15.0, 10.0))[0];
    let mut on_gpu = GpuSet::default();
    assert_eq!(on_gpu.pages().len(), 0);
    let mut bytes = None;
    // The first round finds out how long the lists may get.
    for (round, threshold) in [1.0, 0.3, 0.7].into_iter().cycle().enumerate().take(6) {
        for set in [&large, &small, &like_small] {
            on_gpu.upload(&gpu, set).unwrap();
            assert_eq!(on_gpu.pages().len(), set.pages().len());
            for page in on_gpu.pages() {
                let lists = [&page.front, &page.mass, &page.stand_ins];
                assert!(lists.iter().all(|list| list.is_empty()), "ranges of the set before");
                assert!(page.occludees.is_empty(), "ranges of the set before");
            }
            let mut selector = Selector::default();
            let params = LodParams { threshold, ..Default::default() };
            selector.update(set, &viewpoint(&camera, [320, 200], 0.6), &params).unwrap();
            on_gpu.update(&gpu, selector.selection()).unwrap();
            // The set is there already: its ranges stay.
            on_gpu.upload(&gpu, set).unwrap();
            let host = set.pages().zip(&set.stand_ins).zip(&selector.selection().pages);
            for (page, ((particles, stand_ins), selected)) in on_gpu.pages().iter().zip(host) {
                assert_eq!(page.particles.read(&gpu).unwrap(), particles);
                assert_eq!(page.stand_in_spheres.read(&gpu).unwrap(), *stand_ins);
                assert_eq!(page.front.read(&gpu).unwrap(), selected.front);
                assert_eq!(page.occludees.read(&gpu).unwrap(), selected.occludees);
                assert_eq!(page.mass.read(&gpu).unwrap(), selected.mass);
                assert_eq!(page.stand_ins.read(&gpu).unwrap(), selected.stand_ins);
            }
            let now = gpu.memory().current();
            if round >= 3 {
                assert_eq!(*bytes.get_or_insert(now), now, "a buffer was allocated in the steady state");
            }
        }
    }
}

const WEIGHTS: Shader = Shader {
    name: "test/kept",
    source: "#import meniscus::particle::{kept}\n\
        @group(0) @binding(0) var<storage, read> cases: array<vec2<u32>>;\n\
        @group(0) @binding(1) var<storage, read_write> weights: array<vec2<f32>>;\n\
        @compute @workgroup_size(64)\n\
        fn main(@builtin(global_invocation_id) id: vec3<u32>) {\n\
          if id.x < arrayLength(&cases) {\n\
            let k = kept(cases[id.x].x, cases[id.x].y);\n\
            weights[id.x] = vec2(k.weight, k.radius);\n\
          }\n}",
};

#[test]
fn the_shader_weighs_like_its_twin() {
    let gpu = gpu();
    let keeps = [MIN_KEEP, 100, 5000, 19_661, 54_613, 60_000, 65_535, KeptRange::KEEP_ALL];
    let cases: Vec<[u32; 2]> = keeps
        .iter()
        .flat_map(|&keep| {
            (0..keep).step_by((keep / 300).max(1) as usize).map(move |hash| [0x3c00_0000 | hash, keep])
        })
        .collect();
    let pipeline = gpu.compute_pipeline(&ComputePipelineDescriptor::new(WEIGHTS)).unwrap();
    let input = Buffer::<Scratch>::from_slice(&gpu, bytemuck::cast_slice(&cases)).unwrap();
    let output = Buffer::<AttributeValues>::from_slice(&gpu, &vec![0.0; cases.len() * 2]).unwrap();
    let mut recorder = Recorder::new(&gpu, Timing::Stamps);
    recorder.compute(
        &gpu,
        "test.kept",
        &pipeline,
        &[("cases", input.bind()), ("weights", output.bind())],
        Dispatch::Groups(cases.len().div_ceil(64) as u64),
    );
    let _ = recorder.submit(&gpu).unwrap();
    for (case, found) in cases.iter().zip(output.read(&gpu).unwrap().chunks(2)) {
        let expected = kept(case[0], case[1]).unwrap();
        // WGSL's `pow` may be off by some 16 ulps of its exponent's product, here 1e-5 or less; division by 2.5 ulps.
        assert!((found[0] - expected.weight).abs() <= 1e-5 * expected.weight.max(1.0), "{case:?}: {found:?}");
        assert!((found[1] - expected.radius).abs() <= 1e-4, "{case:?}: {found:?} {expected:?}");
    }
}
