//! The command line of meniscus: argument parsing and printing, nothing else. A team's own program is one call,
//! `meniscus_cli::run(Registry::builtin().with_filter(MyFilter::entry()))`.
#![expect(clippy::print_stderr, reason = "printing is what this crate is for")]

mod args;
mod bench;
mod convert;
mod failure;
mod info;
mod input;
mod join;
mod make;
mod picture;
mod render;
mod report;
mod terminal;
mod trace;
mod values;

use std::process::ExitCode;

use clap::{CommandFactory, Parser};
pub use meniscus_pipeline::Registry;

use crate::args::{Cli, Command};
use crate::failure::Failure;
use crate::terminal::{Printable, Terminal, print};

/// Runs the program on this process's arguments with the filters and lighting models of `registry`.
pub fn run(registry: Registry) -> ExitCode {
    hush_mesa();
    let cli = match Cli::try_parse() {
        Ok(cli) => cli,
        Err(error) => return refuse(&error),
    };
    let level = match (cli.global.quiet, cli.global.verbose) {
        (true, _) => "error",
        (_, 0) => "warn",
        (_, 1) => "info,wgpu=warn,naga=warn",
        _ => "debug",
    };
    let filter = tracing_subscriber::EnvFilter::try_from_default_env().unwrap_or_else(|_| level.into());
    tracing_subscriber::fmt().with_env_filter(filter).with_writer(std::io::stderr).without_time().init();
    guard_maps();
    meniscus_huge_pages::give_back();
    #[cfg(unix)]
    allow_open_files();
    if let Some(threads) = cli.global.threads
        && let Err(error) = rayon::ThreadPoolBuilder::new().num_threads(threads.into()).build_global()
    {
        tracing::warn!("--threads {threads} has no effect: {error}");
    }

    let terminal = Terminal::new(cli.global.quiet);
    let json = matches!(&cli.command, Some(Command::Info(a)) if a.json)
        || matches!(&cli.command, Some(Command::Bench(a)) if a.json);
    let result = if cli.global.list_adapters {
        list_adapters()
    } else {
        match &cli.command {
            Some(Command::Info(args)) => info::run(args, &terminal),
            Some(Command::Render(args)) => render::run(args, &cli.global, registry, &terminal),
            Some(Command::Bench(args)) => bench::run(args, &cli.global, registry, &terminal),
            Some(Command::Convert(args)) => convert::run(args, &terminal),
            Some(Command::Make(args)) => make::run(args, &terminal),
            Some(Command::Join(args)) => join::run(args, &terminal),
            None => {
                // Without a terminal or with a closed one there is nobody to help.
                let _ = Cli::command().print_help();
                return ExitCode::from(2);
            }
        }
    };
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => {
            eprintln!("meniscus: {}", Printable(&failure));
            if json {
                print(report::error_json(&failure));
            }
            ExitCode::from(failure.exit_code())
        }
    }
}

/// A mapped file that shrinks becomes an error of its frame instead of the end of the program.
fn guard_maps() {
    if let Err(error) = meniscus_io::map_guard::install() {
        tracing::warn!("files that shrink while they are read will end the program: {error}");
    }
}

/// A parallel file of thousands of pieces that are read in blocks has as many files open; shells mostly allow a thousand unless
/// asked for more.
#[cfg(unix)]
fn allow_open_files() {
    use rustix::process::{Resource, Rlimit, getrlimit, setrlimit};

    let limit = getrlimit(Resource::Nofile);
    if limit.current != limit.maximum
        && let Err(error) = setrlimit(Resource::Nofile, Rlimit { current: limit.maximum, ..limit })
    {
        tracing::debug!("no more files can be open than the shell allows: {error}");
    }
}

/// Prints what clap has to say (help and version too), and as JSON where that was asked for.
fn refuse(error: &clap::Error) -> ExitCode {
    // Nobody is left to be told when printing fails.
    let _ = error.print();
    if error.use_stderr() && std::env::args_os().any(|arg| arg == "--json") {
        let message = error.render().to_string();
        print(report::error_json(&Failure::Usage(message.trim().to_owned())));
    }
    ExitCode::from(u8::try_from(error.exit_code()).unwrap_or(2))
}

/// On a machine without a desktop session, Mesa's device selection layer complains on standard error about a missing
/// XDG_RUNTIME_DIR, once per adapter query. It has nothing to select there.
fn hush_mesa() {
    if std::env::var_os("XDG_RUNTIME_DIR").is_none() {
        // SAFETY: called first thing, before any thread is started.
        unsafe { std::env::set_var("NODEVICE_SELECT", "1") };
    }
}

fn list_adapters() -> Result<(), Failure> {
    let adapters = meniscus_gpu::list_adapters();
    if adapters.is_empty() {
        return Err(meniscus_gpu::GpuError::NoAdapter.into());
    }
    for (i, adapter) in adapters.iter().enumerate() {
        print(format_args!(
            "{i}: {} ({}, {}, driver {})",
            adapter.name, adapter.device_type, adapter.backend, adapter.driver
        ));
    }
    Ok(())
}
