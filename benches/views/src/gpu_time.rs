use std::time::Duration;

use meniscus_gpu::{AdapterChoice, Gpu, Recorder, Timing};

/// Runs passes one by one and adds up their time on the wall: submission and waiting are part of it, which is what a pass
/// costs on a software driver and an upper bound on a GPU.
pub struct GpuTime {
    gpu: Gpu,
    recorder: Recorder,
}

impl GpuTime {
    /// Opens the adapter that the program would take (`WGPU_ADAPTER_NAME` and its like are respected) and prints its name.
    ///
    /// # Panics
    /// Without an adapter there is nothing to measure.
    #[expect(clippy::print_stderr, reason = "a figure without its adapter means nothing")]
    pub fn open() -> Self {
        let gpu = Gpu::new(&AdapterChoice::default()).expect("an adapter, at least mesa-vulkan-drivers");
        let recorder = Recorder::new(&gpu, Timing::Isolated);
        eprintln!("adapter: {} ({})", gpu.summary().name, gpu.summary().driver);
        Self { gpu, recorder }
    }

    /// The device.
    pub fn gpu(&self) -> &Gpu {
        &self.gpu
    }

    /// Records `passes` `times` times and gives the time that those with one of these `names` took; all of them for no name.
    ///
    /// # Panics
    /// When the driver reports an error, or no pass has such a name: a bench that measures nothing must not look fast.
    pub fn measure(
        &mut self,
        times: u64,
        names: &[&str],
        mut passes: impl FnMut(&mut Recorder, &Gpu),
    ) -> Duration {
        let mut total_ms = 0.0;
        for _ in 0..times {
            passes(&mut self.recorder, &self.gpu);
            let _ = self.recorder.submit(&self.gpu).expect("a frame");
            self.gpu.wait().expect("a finished frame");
            let costs = self.recorder.take_costs(&self.gpu);
            let named = costs.iter().filter(|c| names.is_empty() || names.contains(&c.name.as_str()));
            let walls: Vec<f64> = named.filter_map(|c| c.wall_ms).collect();
            assert!(!walls.is_empty(), "no pass is called {names:?}");
            total_ms += walls.iter().sum::<f64>();
        }
        Duration::from_secs_f64(total_ms * 1e-3)
    }
}
