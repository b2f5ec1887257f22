use std::cell::{OnceCell, RefCell};

use meniscus_gpu::role::Scratch;
use meniscus_gpu::{
    AdapterChoice, Buffer, ComputePipelineDescriptor, Dispatch, Gpu, Recorder, Shader, Timing,
};

use crate::Sample;

/// One word per invocation, as the passes read and write their images.
const COPY: Shader = Shader { name: "bench/copy", source: include_str!("copy.wgsl") };

/// Runs passes one by one and adds up what they take. On the wall, submission and waiting are part of it, which is what a
/// pass costs on a software driver and an upper bound on a GPU; time stamps are the GPU's own.
pub struct GpuTime {
    gpu: Gpu,
    recorder: RefCell<Recorder>,
    device: String,
    copy_gb_per_s: OnceCell<f64>,
}

impl GpuTime {
    /// Opens the adapter that the program would take (`WGPU_ADAPTER_NAME` and its like are respected) and prints its name.
    ///
    /// # Panics
    /// Without an adapter there is nothing to measure.
    #[expect(clippy::print_stderr, reason = "a figure without its adapter means nothing")]
    pub fn open() -> Self {
        let gpu = Gpu::new(&AdapterChoice::default()).expect("an adapter, at least mesa-vulkan-drivers");
        let recorder = RefCell::new(Recorder::new(&gpu, Timing::Isolated));
        let device = format!("{} ({})", gpu.summary().name, gpu.summary().driver);
        eprintln!("adapter: {device}");
        Self { gpu, recorder, device, copy_gb_per_s: OnceCell::new() }
    }

    /// The device.
    pub fn gpu(&self) -> &Gpu {
        &self.gpu
    }

    /// Adapter and driver.
    pub(crate) fn device(&self) -> &str {
        &self.device
    }

    /// Records `passes` `times` times and gives what those with one of these `names` took on average; all of them for no
    /// name.
    ///
    /// # Panics
    /// When the driver reports an error, or no pass has such a name: a bench that measures nothing must not look fast.
    pub fn measure(&self, times: u64, names: &[&str], mut passes: impl FnMut(&mut Recorder, &Gpu)) -> Sample {
        let mut recorder = self.recorder.borrow_mut();
        let runs = times.max(1) as f64;
        let mut sum = Sample { wall_ms: 0.0, cpu_ms: 0.0, gpu_ms: Some(0.0) };
        for _ in 0..times {
            passes(&mut recorder, &self.gpu);
            let _ = recorder.submit(&self.gpu).expect("a frame");
            self.gpu.wait().expect("a finished frame");
            let costs = recorder.take_costs(&self.gpu);
            let named: Vec<_> =
                costs.iter().filter(|c| names.is_empty() || names.contains(&c.name.as_str())).collect();
            let timed = named.iter().filter(|cost| cost.wall_ms.is_some()).count();
            assert!(timed > 0, "no pass is called {names:?}");
            for cost in named {
                sum.wall_ms += cost.wall_ms.unwrap_or(0.0) / runs;
                sum.cpu_ms += cost.cpu_ms.unwrap_or(0.0) / runs;
                // One pass without its stamps, and the sum would be too small.
                sum.gpu_ms = sum.gpu_ms.zip(cost.gpu_ms).map(|(sum, ms)| sum + ms / runs);
            }
        }
        sum
    }

    /// Bytes read and written per second, 1e9, by a pass that copies a buffer of 64 MiB or, where a binding may be larger,
    /// up to 512 MiB: the best of five, by time stamps where they are trusted. A pass and not the driver's copy command,
    /// because passes are what it is compared with.
    pub(crate) fn copy_gb_per_s(&self) -> f64 {
        const LARGEST: usize = 512 << 20;
        const RUNS: usize = 5;
        *self.copy_gb_per_s.get_or_init(|| {
            let gpu = &self.gpu;
            let words = gpu.page_elements::<u32>().min(LARGEST / 4);
            let source = Buffer::<Scratch>::new(gpu, words).expect("a buffer that the device allows");
            let target = Buffer::<Scratch>::new(gpu, words).expect("a buffer that the device allows");
            let copy = gpu.compute_pipeline(&ComputePipelineDescriptor::new(COPY)).expect("the copying pass");
            let groups = Dispatch::Groups((words as u64 / 4).div_ceil(256));
            let bindings = [("source", source.bind()), ("words", target.bind())];
            let run = || {
                self.measure(1, &[], |recorder, gpu| {
                    recorder.compute(gpu, COPY.name, &copy, &bindings, groups);
                })
            };
            run(); // Compiles.
            let ms = (0..RUNS).map(|_| run()).map(|sample| sample.gpu_ms.unwrap_or(sample.wall_ms));
            (8 * words) as f64 / ms.fold(f64::MAX, f64::min) * 1e-6
        })
    }
}
