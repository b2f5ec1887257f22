use std::time::{Duration, Instant};

/// Where something ran.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SpanRow {
    /// On the thread that draws.
    Host,
    /// A pass that was submitted and waited for on its own ([`crate::Timing::Isolated`]).
    Isolated,
    /// A pass by the GPU's time stamps. Their zero is unknown: a frame's passes keep their lengths and gaps and are placed as
    /// a whole, so that the last ends with what the host did last for the frame: waiting for it.
    Stamps,
}

/// Something that ran, on the host's clock.
#[derive(Clone, Debug)]
pub struct Span {
    /// A pass (`stage.pass`), or what the host did.
    pub name: String,
    /// Where.
    pub row: SpanRow,
    /// When it began.
    pub begin: Instant,
    /// When it had ended.
    pub end: Instant,
}

/// Spans while somebody traces; keeps nothing otherwise.
#[derive(Debug, Default)]
pub(crate) struct Spans {
    kept: Option<Vec<Span>>,
    host_end: Option<Instant>,
}

impl Spans {
    pub(crate) fn trace(&mut self, wanted: bool) {
        *self = Self { kept: wanted.then(Vec::new), host_end: None };
    }

    pub(crate) fn take(&mut self) -> Vec<Span> {
        self.kept.as_mut().map(std::mem::take).unwrap_or_default()
    }

    /// Something that ran from `begin` until now.
    pub(crate) fn push(&mut self, row: SpanRow, name: &str, begin: Instant) {
        if let Some(spans) = &mut self.kept {
            let end = Instant::now();
            spans.push(Span { name: name.to_owned(), row, begin, end });
            if row == SpanRow::Host {
                self.host_end = Some(end);
            }
        }
    }

    /// Passes of one frame by time stamps: name, begin and end in seconds.
    pub(crate) fn push_stamps(&mut self, passes: &[(String, f64, f64)]) {
        let (Some(spans), Some(end)) = (&mut self.kept, self.host_end) else { return };
        let last_s = passes.iter().map(|(_, _, end_s)| *end_s).fold(f64::MIN, f64::max);
        let before_end =
            |s: f64| Duration::try_from_secs_f64(last_s - s).ok().and_then(|d| end.checked_sub(d));
        for (name, begin_s, end_s) in passes {
            // A wrapped clock has no place on the time line.
            let Some((begin, end)) = before_end(*begin_s).zip(before_end(*end_s)) else { continue };
            spans.push(Span { name: name.clone(), row: SpanRow::Stamps, begin, end });
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn passes_by_time_stamps_keep_lengths_and_gaps() {
        let mut spans = Spans::default();
        let passes = [("a".to_owned(), 1000.0, 1000.25), ("b".to_owned(), 1000.5, 1001.0)];
        spans.push(SpanRow::Host, "wait", Instant::now());
        spans.push_stamps(&passes);
        assert!(spans.take().is_empty(), "nobody traces");
        spans.trace(true);
        spans.push(SpanRow::Host, "wait", Instant::now());
        let end = spans.take()[0].end;
        spans.push_stamps(&passes);
        let taken = spans.take();
        let ms = |from: Instant, to: Instant| (to - from).as_secs_f64() * 1e3;
        assert_eq!(taken[1].end, end);
        // Differences of f64 seconds, in nanoseconds.
        assert!((ms(taken[0].begin, taken[0].end) - 250.0).abs() < 1e-3);
        assert!((ms(taken[0].end, taken[1].begin) - 250.0).abs() < 1e-3);
        assert!((ms(taken[1].begin, taken[1].end) - 500.0).abs() < 1e-3);
        assert!(spans.take().is_empty(), "taken once");
    }
}
