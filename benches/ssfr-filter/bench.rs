//! The built-in surface filters.

use meniscus_ssfr::FilterRegistry;

fn main() {
    bench_ssfr_filter::main("ssfr-filter", &FilterRegistry::builtin());
}
