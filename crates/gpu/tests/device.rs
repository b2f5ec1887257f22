//! Against a real device: a missing adapter is a failure, not a skip.

use std::sync::{LazyLock, Mutex, MutexGuard, PoisonError};

use meniscus_gpu::role::{
    AttributeValues, FilterStep, Lumas, PackedParticle, Particles, Scratch, Shapes, TextureRole,
};
use meniscus_gpu::{
    AdapterChoice, Buffer, ComputePipelineDescriptor, Covered, Dispatch, Gpu, GpuError, Image, Page,
    PicturePipelineDescriptor, Pixels, Recorder, Shader, Texture, Timing,
};

/// One device for all tests, one after the other, which is never given back: NVIDIA's driver 580 deadlocks where threads end that used
/// one device while another is destroyed, as they do when tests have one each.
fn gpu() -> MutexGuard<'static, Gpu> {
    static GPU: LazyLock<Mutex<Gpu>> = LazyLock::new(|| {
        Mutex::new(Gpu::new(&AdapterChoice::default()).expect("an adapter, at least mesa-vulkan-drivers"))
    });
    // A test that is to panic does so with the lock held.
    GPU.lock().unwrap_or_else(PoisonError::into_inner)
}

const DOUBLE: Shader = Shader {
    name: "test/double",
    source: "@group(0) @binding(0) var<uniform> factor: vec4<u32>;\n\
        @group(0) @binding(1) var<storage, read> source: array<u32>;\n\
        @group(0) @binding(2) var<storage, read_write> doubled: array<u32>;\n\
        @compute @workgroup_size(64)\n\
        fn main(@builtin(workgroup_id) group: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>, @builtin(local_invocation_index) lane: u32) {\n\
          let i = (group.y * groups.x + group.x) * 64u + lane;\n\
          if i < arrayLength(&source) { doubled[i] = source[i] * factor.x; }\n}",
};

#[test]
fn a_pass_runs_is_named_and_timed() {
    let gpu = gpu();
    let pipeline = gpu.compute_pipeline(&ComputePipelineDescriptor::new(DOUBLE)).unwrap();
    assert_eq!(pipeline.workgroup_size(), [64, 1, 1]);
    // More groups than one dimension holds, so that folding is exercised: 65536 * 64 elements and a rest.
    let input: Vec<u32> = (0..65_536 * 64 + 17).collect();
    let source = Buffer::<Scratch>::from_slice(&gpu, &input).unwrap();
    let target = Buffer::<Scratch>::from_slice(&gpu, &vec![0; input.len()]).unwrap();
    for timing in [Timing::Stamps, Timing::Isolated] {
        let mut recorder = Recorder::new(&gpu, timing);
        let factor = recorder.uniform(&[3u32, 0, 0, 0]);
        let bindings = [("doubled", target.bind()), ("source", source.bind()), ("factor", factor)];
        recorder.compute(
            &gpu,
            "test.double",
            &pipeline,
            &bindings,
            Dispatch::Groups(input.len().div_ceil(64) as u64),
        );
        let _ = recorder.submit(&gpu).unwrap();
        gpu.wait().unwrap();
        let costs = recorder.take_costs(&gpu);
        if timing == Timing::Stamps && !gpu.trusts_time_stamps() {
            assert!(costs.is_empty(), "no figure is better than a wrong one: {costs:?}");
            continue;
        }
        assert_eq!(costs.len(), 1, "{costs:?}");
        assert_eq!(costs[0].name, "test.double");
        assert_eq!(costs[0].wall_ms.is_some(), timing == Timing::Isolated);
    }
    let output = target.read(&gpu).unwrap();
    assert!(output.iter().zip(&input).all(|(o, i)| *o == i * 3));
}

#[test]
fn an_image_is_cleared_to_the_empty_value_of_its_role() {
    let gpu = gpu();
    let image = Image::<AttributeValues>::from_pixels(&gpu, [33, 7], &[7.0; 33 * 7]).unwrap();
    let mut recorder = Recorder::new(&gpu, Timing::Stamps);
    recorder.clear(&gpu, "test.clear", image.buffer(), 33 * 7);
    let _ = recorder.submit(&gpu).unwrap();
    assert_eq!(image.read(&gpu).unwrap(), vec![0.0; 33 * 7]);
}

/// Fluid where a pattern says so.
const MARK: Shader = Shader {
    name: "test/mark",
    source: "#import meniscus::covered::{Filling, pack_pixel}\n\
        @group(0) @binding(0) var<uniform> every: vec4<u32>;\n\
        fn shows(p: vec2<u32>) -> bool { return (7u * p.x + 3u * p.y) % every.x == 0u; }\n\
        #ifdef HARDWARE\n\
        @group(0) @binding(1) var marked: texture_storage_2d<r32float, write>;\n\
        @group(0) @binding(2) var<storage, read_write> covered: Filling;\n\
        @compute @workgroup_size(8, 8) fn main(@builtin(global_invocation_id) id: vec3<u32>) {\n\
          if any(id.xy >= textureDimensions(marked)) { return; }\n\
          textureStore(marked, id.xy, vec4(1.0));\n\
          if shows(id.xy) { covered.packed[atomicAdd(&covered.count, 1u)] = pack_pixel(id.xy); }\n}\n\
        #else\n\
        @vertex fn vertex(@builtin(vertex_index) i: u32) -> @builtin(position) vec4<f32> {\n\
          return vec4(4.0 * vec2<f32>(vec2(i & 1u, i >> 1u)) - 1.0, 0.5, 1.0);\n}\n\
        struct Out { @location(0) marked: f32, @builtin(frag_depth) mask: f32 }\n\
        @fragment fn fragment(@builtin(position) at: vec4<f32>) -> Out {\n\
          return Out(1.0, f32(shows(vec2<u32>(at.xy))));\n}\n\
        #endif\n",
};

/// Column + 100 rows in each pixel that shows fluid.
const PAINT: Shader = Shader {
    name: "test/paint",
    source: "#import meniscus::covered::{CoveredPixels, unpack_pixel}\n\
        fn color(p: vec2<u32>) -> f32 { return f32(p.x + 100u * p.y); }\n\
        #ifdef HARDWARE\n\
        @group(0) @binding(0) var painted: texture_storage_2d<r32float, write>;\n\
        @group(0) @binding(1) var<storage, read> covered: CoveredPixels;\n\
        @compute @workgroup_size(64) fn main(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) n: vec3<u32>) {\n\
          for (var i = id.x; i < covered.count; i += n.x * 64u) {\n\
            let p = unpack_pixel(covered.packed[i]);\n\
            textureStore(painted, p, vec4(color(p)));\n}}\n\
        #else\n\
        @vertex fn vertex(@builtin(vertex_index) i: u32) -> @builtin(position) vec4<f32> {\n\
          return vec4(4.0 * vec2<f32>(vec2(i & 1u, i >> 1u)) - 1.0, 0.5, 1.0);\n}\n\
        @fragment fn fragment(@builtin(position) at: vec4<f32>) -> @location(0) f32 { return color(vec2<u32>(at.xy)); }\n\
        #endif\n",
};

/// The same by way of the list, into a buffer.
const WALK: Shader = Shader {
    name: "test/walk",
    source: "#import meniscus::covered::{CoveredPixels, unpack_pixel}\n\
        @group(0) @binding(0) var<storage, read> covered: CoveredPixels;\n\
        @group(0) @binding(1) var<storage, read_write> words: array<u32>;\n\
        @compute @workgroup_size(64) fn main(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) n: vec3<u32>) {\n\
          for (var i = id.x; i < covered.count; i += n.x * 64u) {\n\
            let p = unpack_pixel(covered.packed[i]);\n\
            words[p.y * 37u + p.x] += p.x + 100u * p.y;\n}}\n",
};

#[test]
fn passes_over_fluid_leave_the_other_pixels_alone_drawn_or_listed() {
    let gpu = gpu();
    let size = [37, 11];
    let picture = |shader, pixels| {
        let targets = &[FilterStep::FORMAT];
        let (includes, definitions) = (&[][..], &[][..]);
        gpu.picture_pipeline(&PicturePipelineDescriptor { shader, includes, definitions, targets, pixels })
            .unwrap()
    };
    let (mark, paint) = (picture(MARK, Pixels::Marked), picture(PAINT, Pixels::Covered));
    let walk = gpu.compute_pipeline(&ComputePipelineDescriptor::new(WALK)).unwrap();
    let covered = Covered::new(&gpu, size).unwrap();
    let [marked, painted] = [(); 2].map(|()| Texture::<FilterStep>::new(&gpu, size).unwrap());
    let mut recorder = Recorder::new(&gpu, Timing::Stamps);
    // Of one set of pixels after the other, and at last of pixels that the host names; also where there are none.
    for every in [5, 3, 1 << 20, 4] {
        let shows = |i: usize| (7 * (i as u32 % 37) + 3 * (i as u32 / 37)).is_multiple_of(every);
        let named = (every == 4).then(|| Covered::of(&gpu, size, shows).unwrap());
        painted.write(&gpu, &[-1.0; 37 * 11]);
        let words = Buffer::<Scratch>::from_slice(&gpu, &[0; 37 * 11]).unwrap();
        if named.is_none() {
            covered.empty(&mut recorder, &gpu, "test.empty");
            let bindings = [("every", recorder.uniform(&[every, 0, 0, 0]))];
            let targets = [("marked", marked.view())];
            recorder.picture(&gpu, "test.mark", &mark, &bindings, &targets, Some(&covered));
        }
        let covered = named.as_ref().unwrap_or(&covered);
        let targets = [("painted", painted.view())];
        recorder.picture(&gpu, "test.paint", &paint, &[], &targets, Some(covered));
        let bindings = [("covered", covered.list(&mut recorder, &gpu)), ("words", words.bind())];
        recorder.compute(&gpu, "test.walk", &walk, &bindings, covered.dispatch());
        let _ = recorder.submit(&gpu).unwrap();
        let color = |i: usize| i as u32 % 37 + 100 * (i as u32 / 37);
        let expected = |none: f32| {
            (0..37 * 11).map(|i| if shows(i) { color(i) as f32 } else { none }).collect::<Vec<_>>()
        };
        assert_eq!(painted.read(&gpu).unwrap(), expected(-1.0), "{every}");
        let walked: Vec<f32> = words.read(&gpu).unwrap().into_iter().map(|word| word as f32).collect();
        assert_eq!(walked, expected(0.0), "{every}");
    }
}

#[test]
fn rows_of_any_length_are_copied_one_after_the_other() {
    let gpu = gpu();
    for size in [[64, 3], [37, 5], [1, 1]] {
        let texels: Vec<u32> = (0..size[0] * size[1]).collect();
        let texture = Texture::<Lumas>::from_texels(&gpu, size, &texels).unwrap();
        let buffer = Buffer::<Scratch>::from_slice(&gpu, &vec![9; texels.len() + 2]).unwrap();
        let mut recorder = Recorder::new(&gpu, Timing::Stamps);
        recorder.copy_rows(&gpu, "test.copy", &texture, &buffer);
        let _ = recorder.submit(&gpu).unwrap();
        assert_eq!(buffer.read(&gpu).unwrap(), [&texels[..], &[9, 9]].concat(), "{size:?}");
        recorder.zero(&gpu, "test.zero", &buffer, 1);
        let _ = recorder.submit(&gpu).unwrap();
        let expected = [&[0], &texels[1..], &[9, 9]].concat();
        assert_eq!(buffer.read(&gpu).unwrap(), expected, "{size:?}");
    }
}

const COPY_PAGE: Shader = Shader {
    name: "test/copy_page",
    source: "#import meniscus::page::particle_at\n\
        @group(0) @binding(0) var<storage, read_write> copied: array<vec4<u32>>;\n\
        @compute @workgroup_size(64)\n\
        fn main(@builtin(global_invocation_id) id: vec3<u32>) {\n\
          if id.x >= arrayLength(&copied) { return; }\n\
          let particle = particle_at(id.x);\n\
          copied[id.x] = vec4(bitcast<vec3<u32>>(particle.position_world), particle.packed);\n}",
};

#[test]
fn passes_find_the_particles_of_a_page_in_their_order() {
    let gpu = gpu();
    let pass = gpu.compute_pipeline(&ComputePipelineDescriptor::new(COPY_PAGE)).unwrap();
    let particle = |i: usize| PackedParticle { position_world: [i as f32, -1.0, 0.5], packed: !(i as u32) };
    let mut page = Page::<Particles>::from_slice(&gpu, &[]).unwrap();
    assert!(page.is_empty() && page.read(&gpu).unwrap().is_empty());
    // Rows of 4096 in a texture: part of one, whole ones, pieces of 256 of them with a rest, and less than before.
    for len in [1, 4096, 4097, 3 * 4096, 2 * 256 * 4096 + 4095, 5000] {
        let particles: Vec<_> = (0..len).map(particle).collect();
        page.write(&gpu, &particles).unwrap();
        assert_eq!(page.len(), len);
        assert!(page.bytes() >= Page::<Particles>::bytes_for(&gpu, len));
        assert!(page.read(&gpu).unwrap() == particles, "{len} read back");
        let copied = Image::<Shapes>::new(&gpu, [len as u32, 1]).unwrap();
        let mut recorder = Recorder::new(&gpu, Timing::Stamps);
        let bindings = [("page", page.bind()), ("copied", copied.bind())];
        recorder.compute(&gpu, "test.copy_page", &pass, &bindings, Dispatch::Pixels([len as u32, 1]));
        let _ = recorder.submit(&gpu).unwrap();
        let copied: Vec<PackedParticle> = bytemuck::cast_vec(copied.read(&gpu).unwrap());
        assert!(copied == particles, "{len} read by a pass");
    }
}

#[test]
fn memory_is_counted_and_given_back() {
    let gpu = gpu();
    let before = gpu.memory().current();
    let buffer = Buffer::<Scratch>::new(&gpu, 1000).unwrap();
    assert_eq!(gpu.memory().current() - before, 4000);
    drop(buffer);
    assert_eq!(gpu.memory().current(), before);
    assert!(gpu.memory().peak() >= before + 4000);
}

#[test]
fn a_buffer_beyond_the_limit_is_refused_with_the_limit() {
    let gpu = gpu();
    let elements = gpu.page_elements::<u32>() + 1;
    match Buffer::<Scratch>::new(&gpu, elements) {
        Err(GpuError::TooLarge { bytes, limit, .. }) => assert!(bytes > limit),
        other => panic!("{other:?}"),
    }
}

#[test]
#[should_panic(expected = "no binding source")]
fn a_wrong_binding_name_is_a_loud_mistake() {
    let gpu = gpu();
    let pipeline = gpu.compute_pipeline(&ComputePipelineDescriptor::new(DOUBLE)).unwrap();
    let buffer = Buffer::<Scratch>::new(&gpu, 1).unwrap();
    let mut recorder = Recorder::new(&gpu, Timing::Stamps);
    let factor = recorder.uniform(&[3u32, 0, 0, 0]);
    let bindings = [("doubled", buffer.bind()), ("sauce", buffer.bind()), ("factor", factor)];
    recorder.compute(&gpu, "test.double", &pipeline, &bindings, Dispatch::Groups(1));
}

/// Variants are composed when they are recorded: one that cannot be is told then, and the frame goes on without it.
#[test]
fn a_variant_that_does_not_compose_is_told_when_it_is_drawn() {
    let gpu = gpu();
    let broken =
        Shader { name: "test/broken", source: "@compute @workgroup_size(1) fn main() { let x: u32 = 1.5; }" };
    let descriptor = ComputePipelineDescriptor::new(broken);
    assert!(gpu.compute_pipeline(&descriptor).is_err());
    let variant = gpu.compute_variant(&descriptor);
    gpu.wait().unwrap();
    let mut recorder = Recorder::new(&gpu, Timing::Stamps);
    recorder.compute(&gpu, "test.broken", &variant, &[], Dispatch::Groups(1));
    let error = gpu.wait().unwrap_err().to_string();
    assert!(error.contains("test/broken"), "{error}");
}

#[test]
fn all_variants_are_composed_on_request() {
    let gpu = gpu();
    let _ = gpu.compute_variant(&ComputePipelineDescriptor::new(DOUBLE));
    gpu.compose_variants().unwrap();
    let broken =
        Shader { name: "test/other", source: "@compute @workgroup_size(1) fn main() { let x: i32 = 1.5; }" };
    let _ = gpu.compute_variant(&ComputePipelineDescriptor::new(broken));
    let error = gpu.compose_variants().unwrap_err().to_string();
    assert!(error.contains("test/other"), "{error}");
}

/// Large data may be written where the GPU reads it, small data goes through a copy: what is there is what was written last,
/// whatever the GPU was about to do with it.
#[test]
fn buffers_hold_what_was_written_last_whatever_its_size() {
    let gpu = gpu();
    let values = |count: usize, first: f32| -> Vec<f32> { (0..count).map(|i| first + i as f32).collect() };
    let mut buffer = Buffer::<AttributeValues>::new(&gpu, 600_001).unwrap();
    let mut recorder = Recorder::new(&gpu, Timing::Stamps);
    for (round, count) in [600_001, 7, 300_000, 600_000].into_iter().enumerate() {
        let written = values(count, round as f32);
        gpu.restart_work();
        buffer.write(&gpu, &written).unwrap();
        assert_eq!(gpu.work().uploaded["AttributeValues"], 4 * count as u64);
        assert!(buffer.read(&gpu).unwrap() == written, "round {round}");
        // Clearing is still on its way when the next round writes.
        recorder.clear(&gpu, "clear", &buffer, 600_001);
        let _ = recorder.submit(&gpu).unwrap();
    }
    gpu.wait().unwrap();
    assert!(buffer.read(&gpu).unwrap().iter().all(|value| *value == 0.0));
    // A buffer that grows is another one.
    let more = values(2_000_000, 0.5);
    buffer.write(&gpu, &more).unwrap();
    assert!(buffer.read(&gpu).unwrap() == more);
}
