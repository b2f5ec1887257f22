//! The plane fit beside the built-in filters: `cargo xtask bench custom-filter`.

use custom_filter::PlaneFit;
use meniscus_ssfr::FilterRegistry;

fn main() {
    bench_ssfr_filter::main("custom-filter", &FilterRegistry::builtin().with_filter(PlaneFit::entry()));
}
