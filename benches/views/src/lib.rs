//! The inputs of all benches: cases seen by committed cameras, so that no figure depends on a lucky view, and analytic water
//! for the stages after the surface.
//!
//! `cargo bench -p bench-<stage>` measures a stage; `cargo test --all-targets` runs every bench once on [`View::tiny`] to see
//! that it still works.

mod clock;
#[cfg(feature = "gpu")]
mod gpu_time;
mod pool;
mod record;
mod splat;
mod stage;
mod view;

#[cfg(feature = "gpu")]
pub use gpu_time::GpuTime;
pub use pool::Pool;
pub use record::Sample;
pub use stage::Stage;
pub use view::{View, ordered};

/// Whether this is `cargo bench` and not the single run that `cargo test` makes of a bench.
pub fn is_measured() -> bool {
    let flags: Vec<String> = std::env::args().collect();
    let has = |flag: &str| flags.iter().any(|f| f == flag);
    has("--bench") && !has("--test")
}

/// Whether a look is enough (`--quick`).
pub(crate) fn is_quick() -> bool {
    std::env::args().any(|flag| flag == "--quick")
}

/// `views` for a measurement, small stand-ins of them otherwise.
pub fn views<const N: usize>(views: [View; N]) -> [View; N] {
    views.map(|view| if is_measured() { view } else { view.tiny() })
}
