//! What is printed, and to whom: results to standard output, everything said about them to standard error.

use std::io::Write;
use std::sync::OnceLock;
use std::time::Duration;

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use meniscus_core::{Cancel, Choice, Flaws};

/// How much is said.
#[derive(Clone, Copy, Debug)]
pub struct Terminal {
    quiet: bool,
}

impl Terminal {
    /// `quiet` leaves only errors.
    pub fn new(quiet: bool) -> Self {
        Self { quiet }
    }

    /// One line about what is going on.
    pub fn say(&self, line: impl std::fmt::Display) {
        if !self.quiet {
            eprintln!("{line}");
        }
    }

    /// The automatic choices, one line each.
    pub fn choices(&self, choices: &[Choice]) {
        choices.iter().for_each(|choice| self.say(choice));
    }

    /// The ways in which the result is not what was asked, one line each.
    pub fn flaws(&self, flaws: &Flaws) {
        flaws.iter().for_each(|flaw| self.say(format_args!("note: {flaw}")));
    }

    /// A progress bar over `steps`, invisible when quiet or when standard error is no terminal.
    pub fn progress(&self, steps: u64, what: &'static str) -> ProgressBar {
        let target = if self.quiet { ProgressDrawTarget::hidden() } else { ProgressDrawTarget::stderr() };
        let style =
            ProgressStyle::with_template("{prefix} {bar:32} {pos}/{len}  {elapsed} elapsed, {eta} left")
                .unwrap_or_else(|_| ProgressStyle::default_bar());
        let bar = ProgressBar::with_draw_target(Some(steps), target).with_style(style).with_prefix(what);
        bar.enable_steady_tick(Duration::from_millis(500));
        bar
    }
}

/// Prints a result to standard output. Where nobody reads any more (`| head`), the rest is not printed and nothing is wrong.
pub fn print(line: impl std::fmt::Display) {
    let _ = writeln!(std::io::stdout(), "{line}");
}

/// Set by Ctrl-C and SIGTERM: running work stops at the next safe point. A second signal ends the process at once, which
/// is safe as well: unfinished outputs do not have their final names yet.
pub fn interrupt() -> Cancel {
    static CANCEL: OnceLock<Cancel> = OnceLock::new();
    CANCEL
        .get_or_init(|| {
            let cancel = Cancel::default();
            let seen = cancel.clone();
            let installed = ctrlc::set_handler(move || {
                if seen.is_cancelled() {
                    std::process::exit(130);
                }
                seen.cancel();
            });
            if let Err(error) = installed {
                tracing::warn!("Ctrl-C will end the program without clean-up: {error}");
            }
            cancel
        })
        .clone()
}
