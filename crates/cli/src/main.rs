//! The `meniscus` program.

use std::process::ExitCode;

/// Frames are large; see there.
#[global_allocator]
static ALLOCATOR: meniscus_huge_pages::HugePages = meniscus_huge_pages::HugePages;

fn main() -> ExitCode {
    meniscus_cli::run(meniscus_cli::Registry::builtin())
}
