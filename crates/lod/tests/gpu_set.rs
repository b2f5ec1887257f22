//! Against a real device: a missing adapter is a failure, not a skip.

#[allow(dead_code, reason = "shared with the other tests")]
mod common;

use std::sync::Arc;

use common::{cameras, pool, viewpoint};
use glam::Vec3;
use meniscus_gpu::role::{AttributeValues, KeptRange, Scratch};
use meniscus_gpu::{
    AdapterChoice, Buffer, ComputePipelineDescriptor, Dispatch, Gpu, Recorder, Shader, Timing,
};
use meniscus_lod::cut::MIN_KEEP;
use meniscus_lod::weight::kept;
use meniscus_lod::{ChunkOptions, ChunkedSet, GpuSet, LodParams, Selector, SetStore, SetStoreStats, chunks};

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
    let (mut on_gpu, store) = (GpuSet::default(), SetStore::default());
    assert_eq!(on_gpu.pages().len(), 0);
    let mut bytes = None;
    // The first round finds out how long the lists may get.
    for (round, threshold) in [1.0, 0.3, 0.7].into_iter().cycle().enumerate().take(6) {
        for set in [&large, &small, &like_small] {
            on_gpu.upload(&gpu, &store, set).unwrap();
            assert_eq!(on_gpu.pages().len(), set.pages().len());
            for (_, lists) in on_gpu.pages() {
                let ranges = [&lists.front, &lists.mass, &lists.stand_ins];
                assert!(ranges.iter().all(|list| list.is_empty()), "ranges of the set before");
                assert!(lists.occludees.is_empty(), "ranges of the set before");
            }
            let mut selector = Selector::default();
            let params = LodParams { threshold, ..Default::default() };
            selector.update(set, &viewpoint(&camera, [320, 200], 0.6), &params).unwrap();
            on_gpu.update(&gpu, selector.selection()).unwrap();
            // The set is there already: its ranges stay.
            on_gpu.upload(&gpu, &store, set).unwrap();
            let host = set.pages().zip(&set.stand_ins).zip(&selector.selection().pages);
            for ((page, lists), ((particles, stand_ins), selected)) in on_gpu.pages().zip(host) {
                assert_eq!(page.particles.read(&gpu).unwrap(), particles);
                assert_eq!(page.stand_in_spheres.read(&gpu).unwrap(), *stand_ins);
                assert_eq!(lists.front.read(&gpu).unwrap(), selected.front);
                assert_eq!(lists.occludees.read(&gpu).unwrap(), selected.occludees);
                assert_eq!(lists.mass.read(&gpu).unwrap(), selected.mass);
                assert_eq!(lists.stand_ins.read(&gpu).unwrap(), selected.stand_ins);
            }
            let now = gpu.memory().current();
            if round >= 3 {
                assert_eq!(*bytes.get_or_insert(now), now, "a buffer was allocated in the steady state");
            }
        }
    }
}

/// A pool moved on by whole spacings from set to set: all take the same room.
fn moved_pools(count: u8) -> Vec<ChunkedSet> {
    let moved = |by: u8| {
        let mut frame = pool([20, 20, 20], 0);
        frame.positions.iter_mut().for_each(|position| position[0] += f32::from(by));
        chunks::build(&frame, &ChunkOptions::new(10_000, 1.0))
    };
    (0..count).map(moved).collect()
}

/// Five sets of the same size on the GPU, of which `room` fit into the budget, played round after round as a viewer does: each is
/// drawn while the next one is uploaded. Returns what was done, and the bytes of one set.
fn play(gpu: &Gpu, sets: &[ChunkedSet], room: f64, rounds: usize) -> (SetStoreStats, u64) {
    let one = SetStore::default();
    drop(one.get(gpu, &sets[0]).unwrap());
    let bytes = one.stats().peak_bytes;
    drop(one);
    let before = gpu.memory().current();
    let store = SetStore::new((room * bytes as f64) as u64);
    let (mut drawn, mut ahead) = (GpuSet::default(), None);
    for shown in 0..sets.len() * rounds {
        drawn.upload(gpu, &store, &sets[shown % sets.len()]).unwrap();
        drop(ahead.take());
        ahead = store.get_ahead(gpu, &sets[(shown + 1) % sets.len()]).unwrap();
        let particles = sets[shown % sets.len()].pages().flatten();
        let on_gpu: Vec<_> = drawn.pages().flat_map(|(page, _)| page.particles.read(gpu).unwrap()).collect();
        assert!(on_gpu.iter().eq(particles), "picture {shown} shows another set");
        // Lists of ranges and what particles are read back through are small, and not in the budget.
        let most = (room.max(1.0) + 1.5) * bytes as f64;
        assert!(((gpu.memory().current() - before) as f64) < most, "picture {shown}");
    }
    (store.stats(), bytes)
}

#[test]
fn sets_are_uploaded_ahead_and_kept_within_the_budget() {
    let gpu = gpu();
    let sets = moved_pools(5);
    let (stats, bytes) = play(&gpu, &sets, 0.0, 2);
    assert_eq!(
        (stats.uploads, stats.uploads_ahead, stats.found),
        (10, 0, 0),
        "there is room for what is drawn only"
    );
    assert!(stats.peak_bytes < 2 * bytes, "{stats:?}");

    let (stats, bytes) = play(&gpu, &sets, 2.5, 3);
    assert_eq!(
        (stats.uploads, stats.uploads_ahead, stats.found),
        (1, 15, 14),
        "all but the first one are there when drawn"
    );
    assert!(stats.peak_bytes <= stats.limit_bytes && stats.peak_bytes > bytes, "{stats:?}");

    // Four of five: in each round after the first one, those that make way are the ones just shown, so that three are there
    // still when their turn comes.
    let (stats, _) = play(&gpu, &sets, 4.5, 5);
    assert!(stats.peak_bytes <= stats.limit_bytes, "{stats:?}");
    assert_eq!(stats.uploads + stats.found, 25);
    assert!((5..=12).contains(&(stats.uploads + stats.uploads_ahead)), "{stats:?}");

    let (stats, _) = play(&gpu, &sets, 9.0, 4);
    assert_eq!((stats.uploads, stats.uploads_ahead, stats.found), (1, 4, 19), "each once, and never again");
}

#[test]
fn what_was_uploaded_ahead_stays_until_it_is_shown() {
    let gpu = gpu();
    let sets = moved_pools(4);
    let store = SetStore::default();
    drop(store.get(&gpu, &sets[0]).unwrap());
    let room = |sets: f64| (sets * store.stats().peak_bytes as f64) as u64;
    let store = SetStore::new(room(2.5));
    let mut drawn = GpuSet::default();
    drawn.upload(&gpu, &store, &sets[0]).unwrap();
    // An uploader that is told of the one after the next before the next is drawn keeps neither in its hands.
    assert!(store.get_ahead(&gpu, &sets[1]).unwrap().is_some());
    assert!(store.get_ahead(&gpu, &sets[2]).unwrap().is_none(), "there is no room beside what waits");
    drawn.upload(&gpu, &store, &sets[1]).unwrap();
    assert_eq!((store.stats().uploads, store.stats().found), (1, 1), "the next one is there");
    // What has been shown makes way; what is drawn now, not even for what waits.
    assert!(store.get_ahead(&gpu, &sets[2]).unwrap().is_some());
    drawn.upload(&gpu, &store, &sets[3]).unwrap();
    assert_eq!(store.stats().uploads, 2);
    assert!(store.stats().peak_bytes <= store.stats().limit_bytes);
}

#[test]
fn what_is_asked_for_ahead_too_late_does_not_wait() {
    let gpu = gpu();
    let sets = moved_pools(3);
    let store = SetStore::default();
    drop(store.get(&gpu, &sets[0]).unwrap());
    let store = SetStore::new((2.5 * store.stats().peak_bytes as f64) as u64);
    let mut drawn = GpuSet::default();
    drawn.upload(&gpu, &store, &sets[0]).unwrap();
    assert!(store.get_ahead(&gpu, &sets[0]).unwrap().is_some(), "it is drawn");
    drawn.upload(&gpu, &store, &sets[1]).unwrap();
    assert!(store.get_ahead(&gpu, &sets[2]).unwrap().is_some(), "the first one has been shown and makes way");
}

#[test]
fn what_is_there_can_be_drawn_while_the_next_is_uploaded() {
    let gpu = gpu();
    let sets = moved_pools(2);
    let store = SetStore::new(u64::MAX);
    let shown = store.get(&gpu, &sets[0]).unwrap();
    // A set that takes a while: whoever had to wait for it would not see it under way before and after. Each try may be over
    // before this thread runs again.
    let under_way = (0..50).any(|_| {
        let mut frame = pool([20, 20, 20], 0);
        frame.positions = frame.positions.repeat(200);
        let large = chunks::build(&frame, &ChunkOptions::new(1_000_000, 1.0));
        std::thread::scope(|threads| {
            let upload = threads.spawn(|| store.get_ahead(&gpu, &large).unwrap().is_some());
            let mut seen = false;
            while !upload.is_finished() {
                let before = store.stats().uploading_bytes;
                let found = store.get(&gpu, &sets[0]).unwrap();
                assert!(Arc::ptr_eq(&found, &shown));
                seen |= before > 0 && store.stats().uploading_bytes > 0;
            }
            assert!(upload.join().unwrap());
            seen
        })
    });
    assert!(under_way, "the store gives nothing while it uploads");
    assert_eq!(store.stats().uploading_bytes, 0);
}

#[test]
fn who_asks_for_a_set_that_is_being_uploaded_gets_that_one() {
    let gpu = gpu();
    for set in moved_pools(8) {
        let store = SetStore::new(u64::MAX);
        std::thread::scope(|threads| {
            let ahead = threads.spawn(|| store.get_ahead(&gpu, &set).unwrap().unwrap());
            let drawn = store.get(&gpu, &set).unwrap();
            assert!(Arc::ptr_eq(&drawn, &ahead.join().unwrap()), "uploaded twice");
        });
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
            let k = kept(cases[id.x].x, cases[id.x].y, 0.7);\n\
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
        let expected = kept(case[0], case[1], 0.7).unwrap();
        // WGSL's `pow` may be off by some 16 ulps of its exponent's product, here 1e-5 or less; division by 2.5 ulps.
        assert!((found[0] - expected.weight).abs() <= 1e-5 * expected.weight.max(1.0), "{case:?}: {found:?}");
        assert!((found[1] - expected.radius).abs() <= 1e-4, "{case:?}: {found:?} {expected:?}");
    }
}
