//! Our side of `cargo xtask peers`: writes the files that all tools read, says where their cameras are, and reads files on a
//! clock. Prints JSON; the command around it makes tables.

#![expect(clippy::print_stdout, clippy::print_stderr, reason = "a program; printing is its job")]

mod files;
mod read;

use std::path::PathBuf;
use std::process::ExitCode;

use clap::{Parser, Subcommand};

/// As `meniscus` has it.
#[global_allocator]
static ALLOCATOR: meniscus_huge_pages::HugePages = meniscus_huge_pages::HugePages;

#[derive(Parser)]
#[command(about = "Our side of `cargo xtask peers`")]
struct Arguments {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    /// Write one frame of a committed view as a raw file, and print its camera and radius.
    Make {
        /// A file of benches/views, without its ending.
        view: String,
        /// Folder for the files; made if missing.
        folder: PathBuf,
        /// Divide the number of particles by this.
        #[arg(long, default_value_t = 1)]
        divide: u64,
        /// Write it as zlib and legacy binary files as well.
        #[arg(long)]
        encodings: bool,
    },
    /// Read a file as the pipeline does, again and again.
    Read(read::Options),
}

fn main() -> ExitCode {
    let outcome = match Arguments::parse().command {
        Command::Make { view, folder, divide, encodings } => files::make(&view, &folder, divide, encodings),
        Command::Read(options) => read::run(&options),
    };
    match outcome {
        Ok(json) => {
            println!("{json}");
            ExitCode::SUCCESS
        }
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::FAILURE
        }
    }
}
