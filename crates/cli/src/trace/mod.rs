//! `--trace`: what ran when, in the Trace Event Format that Perfetto (ui.perfetto.dev) and chrome://tracing open. Only what
//! was seen to begin and to end has a place on the time line; costs without a known begin are arguments.

mod source;

use std::borrow::Cow;
use std::path::Path;
use std::sync::{Mutex, PoisonError};
use std::time::Instant;

use meniscus_core::WorkCounters;
use meniscus_export::{ExportError, write_text};
use meniscus_gpu::{Span, SpanRow};
use serde_json::{Value, json};

pub use self::source::TracedSource;
use crate::failure::Failure;

/// A row of the time line, in the order shown. Spans on one row never overlap.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Track {
    /// From wanting a frame to having its picture on disk.
    Frames,
    /// The parts of that, on the thread that draws.
    Drawing,
    /// What drawing a picture consists of.
    Steps,
    /// Passes by the GPU's time stamps.
    Stamps,
    /// Passes submitted and waited for one by one.
    Isolated,
    /// A thread that reads ahead, by its name.
    Reader(String),
}

#[derive(Debug)]
enum Event {
    Span { track: Track, name: Cow<'static, str>, begin: Instant, end: Instant, args: Value },
    Counter { name: &'static str, at: Instant, value: u64 },
}

/// The events of a run; does nothing unless asked for.
#[derive(Debug)]
pub struct Trace {
    wanted: bool,
    origin: Instant,
    events: Mutex<Vec<Event>>,
}

impl Trace {
    /// A trace that begins now.
    pub fn new(wanted: bool) -> Self {
        Self { wanted, origin: Instant::now(), events: Mutex::default() }
    }

    /// Notes something that ran from `begin` until now.
    pub fn span(&self, track: Track, name: &'static str, begin: Instant, args: Value) {
        self.push(Event::Span { track, name: name.into(), begin, end: Instant::now(), args });
    }

    /// Notes what the renderer did.
    pub fn renderer(&self, spans: Vec<Span>) {
        for Span { name, row, begin, end } in spans {
            let track = match row {
                SpanRow::Host => Track::Steps,
                SpanRow::Stamps => Track::Stamps,
                SpanRow::Isolated => Track::Isolated,
            };
            self.push(Event::Span { track, name: name.into(), begin, end, args: Value::Null });
        }
    }

    /// Notes all counters of a frame that were measured.
    pub fn counters(&self, counters: &WorkCounters) {
        for (name, _, value) in counters.iter() {
            if let Some(value) = value {
                self.counter(name, value);
            }
        }
    }

    /// Notes a number as it is now.
    pub fn counter(&self, name: &'static str, value: u64) {
        self.push(Event::Counter { name, at: Instant::now(), value });
    }

    fn push(&self, event: Event) {
        if self.wanted {
            self.events.lock().unwrap_or_else(PoisonError::into_inner).push(event);
        }
    }

    /// Writes the trace, whole or not at all.
    pub fn write(&self, path: &Path) -> Result<(), Failure> {
        let unwritable =
            |e: serde_json::Error| ExportError::Encode { path: path.to_owned(), message: e.to_string() };
        Ok(write_text(path, &serde_json::to_string(&self.to_json()).map_err(unwritable)?)?)
    }

    fn to_json(&self) -> Value {
        let events = self.events.lock().unwrap_or_else(PoisonError::into_inner);
        let mut tracks: Vec<&Track> = events
            .iter()
            .filter_map(|event| match event {
                Event::Span { track, .. } => Some(track),
                Event::Counter { .. } => None,
            })
            .collect();
        tracks.sort();
        tracks.dedup();
        // Threads are numbered from 1: viewers take 0 for the idle thread.
        let tid = |track: &Track| tracks.iter().position(|t| *t == track).map_or(0, |index| index + 1);
        let us = |at: Instant| at.saturating_duration_since(self.origin).as_secs_f64() * 1e6;
        let meta = |name: &str, tid: usize, args: Value| json!({"name": name, "ph": "M", "pid": 1, "tid": tid, "args": args});

        let mut out = vec![meta("process_name", 0, json!({"name": "meniscus"}))];
        for track in &tracks {
            out.push(meta("thread_name", tid(track), json!({"name": title(track)})));
            out.push(meta("thread_sort_index", tid(track), json!({"sort_index": tid(track)})));
        }
        let mut timed: Vec<(f64, Value)> = events
            .iter()
            .map(|event| match event {
                Event::Span { track, name, begin, end, args } => {
                    let (ts, dur) = (us(*begin), us(*end) - us(*begin));
                    let event = json!({"name": name, "cat": title(track), "ph": "X", "ts": ts, "dur": dur, "pid": 1, "tid": tid(track), "args": args});
                    (ts, event)
                }
                Event::Counter { name, at, value } => {
                    let ts = us(*at);
                    (ts, json!({"name": name, "ph": "C", "ts": ts, "pid": 1, "tid": 0, "args": {"value": value}}))
                }
            })
            .collect();
        timed.sort_by(|a, b| a.0.total_cmp(&b.0));
        out.extend(timed.into_iter().map(|(_, event)| event));
        json!({"traceEvents": out, "displayTimeUnit": "ms", "otherData": {"version": env!("CARGO_PKG_VERSION")}})
    }
}

fn title(track: &Track) -> &str {
    match track {
        Track::Frames => "frames",
        Track::Drawing => "drawing",
        Track::Steps => "steps of drawing",
        Track::Stamps => "passes on the GPU (time stamps, placed to end with the wait)",
        Track::Isolated => "passes run one by one, slower than in a frame",
        Track::Reader(name) => name,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_trace_nobody_wants_holds_nothing() {
        let trace = Trace::new(false);
        trace.span(Track::Frames, "frame", Instant::now(), Value::Null);
        assert!(trace.events.lock().unwrap().is_empty());
    }

    #[test]
    fn rows_are_named_and_numbered_in_order() {
        let trace = Trace::new(true);
        trace.span(Track::Reader("read-1".into()), "read", Instant::now(), json!({"frame": 3}));
        trace.span(Track::Drawing, "draw", Instant::now(), Value::Null);
        let json = trace.to_json();
        let names: Vec<_> = json["traceEvents"]
            .as_array()
            .unwrap()
            .iter()
            .filter(|e| e["name"] == "thread_name")
            .map(|e| (e["tid"].as_u64().unwrap(), e["args"]["name"].as_str().unwrap()))
            .collect();
        // A row without a span does not exist.
        assert_eq!(names, [(1, "drawing"), (2, "read-1")]);
    }
}
