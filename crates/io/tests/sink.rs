//! Positions straight into the caller's memory.

mod common;

use std::sync::atomic::{AtomicU32, Ordering};

use common::xml::Xml;
use meniscus_core::{Cancel, FrameRequest, FrameSource};
use meniscus_io::{Series, SeriesOptions, Sink};

/// Cannot be read, like write-combined memory; point `i` goes to place `order[i]`, as a page in chunk order needs it.
struct Scattered<'a> {
    places: &'a [AtomicU32],
    order: &'a [usize],
    /// Of the values of the whole, those that this piece takes.
    range: std::ops::Range<usize>,
}

impl Sink for Scattered<'_> {
    type Item = f32;

    fn len(&self) -> usize {
        self.range.len()
    }

    fn split_at(self, mid: usize) -> (Self, Self) {
        let at = self.range.start + mid;
        (Self { range: self.range.start..at, ..self }, Self { range: at..self.range.end, ..self })
    }

    fn copy_from(self, values: &[f32]) {
        assert_eq!(values.len(), self.len());
        for (value, i) in values.iter().zip(self.range) {
            let place = &self.places[3 * self.order[i / 3] + i % 3];
            assert_eq!(place.swap(value.to_bits(), Ordering::Relaxed), u32::MAX, "written twice");
        }
    }
}

#[test]
fn every_encoding_goes_into_memory_that_is_only_written() {
    let folder = tempfile::tempdir().expect("a folder");
    for case in Xml::all() {
        let path = folder.path().join("case.vtk");
        std::fs::write(&path, case.bytes()).expect("written");
        let series = Series::open(&path, &SeriesOptions::default()).expect("opens");
        let count = series.point_count(0).expect("opens");
        let frame = series.read(0, &FrameRequest::default(), &Cancel::default()).expect("reads");
        let places: Vec<AtomicU32> = (0..3 * count).map(|_| AtomicU32::new(u32::MAX)).collect();
        let order: Vec<usize> = (0..count).rev().collect();
        let sink = Scattered { places: &places, order: &order, range: 0..3 * count };
        series.positions_into(0, sink, &Cancel::default()).unwrap_or_else(|e| panic!("{case:?}: {e}"));
        let written: Vec<f32> = places.iter().map(|p| f32::from_bits(p.load(Ordering::Relaxed))).collect();
        let mut written = written.as_chunks::<3>().0.to_vec();
        written.reverse();
        assert_eq!(written, frame.sets[0].particles.positions, "{case:?}");
    }
}

#[test]
fn memory_of_another_size_is_refused() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("case.vtu");
    std::fs::write(&path, Xml::plain(common::xml::Format::Ascii).bytes()).expect("written");
    let series = Series::open(&path, &SeriesOptions::default()).expect("opens");
    for places in [0, 29, 31] {
        let mut out = vec![0.0; places];
        let error = series.positions_into(0, out.as_mut_slice(), &Cancel::default()).expect_err("refused");
        assert!(error.to_string().contains("10 points"), "{error}");
    }
}
