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
            eprintln!("{}", Printable(line));
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
    let _ = writeln!(std::io::stdout(), "{}", Printable(line));
}

/// Text without what a terminal would obey instead of show: names in files may hold anything. Only the ends of lines are left.
pub struct Printable<T>(pub T);

impl<T: std::fmt::Display> std::fmt::Display for Printable<T> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        use std::fmt::Write;
        for letter in self.0.to_string().chars() {
            if letter.is_control() && letter != '\n' {
                write!(f, "{}", letter.escape_default())?;
            } else {
                f.write_char(letter)?;
            }
        }
        Ok(())
    }
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

#[cfg(test)]
mod tests {
    use super::Printable;

    #[test]
    fn a_name_in_a_file_does_not_command_the_terminal() {
        let shown = Printable("a\x1b[2J\x07 \u{9b}31m ρ 水\r\nb").to_string();
        assert_eq!(shown, "a\\u{1b}[2J\\u{7} \\u{9b}31m ρ 水\\r\nb");
    }
}
