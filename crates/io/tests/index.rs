//! Every file of the shared test data against what its index says.

mod common;

use std::path::Path;

use common::{Entry, data_dir, entries};
use meniscus_core::{Cancel, FrameRequest, FrameSource};
use meniscus_io::{Error, FrameInfo, Series, SeriesOptions};

/// Kinds of files that are read.
fn is_read(entry: &Entry) -> bool {
    let name = entry.file();
    [".vtk", ".vtu", ".vtp", ".pvtu", ".pvtp", ".pvd", ".series", ".bgeo", ".ply"]
        .iter()
        .any(|ext| name.ends_with(ext))
}

/// Opens the file, describes its first frame with statistics and reads it with all its attributes.
fn open_all(path: &Path) -> Result<(Series, FrameInfo), Error> {
    let series = Series::open(path, &SeriesOptions::default())?;
    let info = series.frame_info(0, true)?;
    let request = FrameRequest { attributes: info.attributes.iter().map(|a| a.name.clone()).collect() };
    let frame = series.read(0, &request, &Cancel::default()).expect("what `info` reads can be read");
    // Finite doubles may still be beyond what `f32` holds.
    let in_range = info.bounds.is_none_or(|bounds| bounds.iter().all(|b| b.abs() < 1e38));
    assert!(frame.len() == info.finite_points || !in_range, "{}: {} points", path.display(), frame.len());
    Ok((series, info))
}

#[test]
fn files_that_are_whole_open_with_the_listed_values() {
    let Some(dir) = data_dir() else { return };
    let mut failures = Vec::new();
    let mut count = 0;
    for entry in entries(&dir).iter().filter(|e| e.expect() == "ok" && is_read(e) && e.points().is_some()) {
        count += 1;
        let path = dir.join(entry.file());
        match open_all(&path) {
            Ok((_, info)) => failures.extend(entry.differences(&info)),
            Err(e) => failures.push(format!("{e}")),
        }
    }
    assert!(count > 250, "only {count} entries found");
    assert!(failures.is_empty(), "{} of {count}:\n{}", failures.len(), failures.join("\n"));
}

#[test]
fn files_that_are_broken_are_refused() {
    let Some(dir) = data_dir() else { return };
    let mut read = Vec::new();
    for entry in entries(&dir).iter().filter(|e| e.expect() == "fail") {
        if let Ok((_, info)) = open_all(&dir.join(entry.file())) {
            read.push(format!("{}: {} points", entry.file(), info.points));
        }
    }
    assert!(read.is_empty(), "read although broken:\n{}", read.join("\n"));
}

#[test]
fn doubtful_files_never_crash_and_read_right_if_at_all() {
    let Some(dir) = data_dir() else { return };
    let mut failures = Vec::new();
    for entry in entries(&dir).iter().filter(|e| matches!(e.expect(), "either" | "partial") && is_read(e)) {
        let Ok((_, info)) = open_all(&dir.join(entry.file())) else { continue };
        // Where the reference reader gives up, it lists no points.
        if entry.points().is_some_and(|points| points > 0) && entry.bounds().is_some() {
            failures.extend(entry.geometry_differences(&info));
        }
    }
    assert!(failures.is_empty(), "{}", failures.join("\n"));
}

#[test]
fn series_have_the_listed_times_and_files() {
    let Some(dir) = data_dir() else { return };
    let mut count = 0;
    for entry in entries(&dir) {
        let Some(steps) = entry.time_steps() else { continue };
        count += 1;
        let path = dir.join(entry.file());
        let series = Series::open(&path, &SeriesOptions::default()).unwrap_or_else(|e| panic!("{e}"));
        let times: Vec<f64> = series.times().into_iter().flatten().collect();
        assert_eq!(times, steps.iter().map(|s| s.0).collect::<Vec<_>>(), "{}", entry.file());
        for (i, (_, files)) in steps.iter().enumerate() {
            let folder = path.parent().expect("a folder");
            let real = |file: &Path| file.canonicalize().unwrap_or_else(|_| file.to_owned());
            let found: Vec<_> = series.files(i).iter().map(|file| real(file)).collect();
            let files: Vec<_> = files.iter().map(|file| real(&folder.join(file))).collect();
            assert_eq!(found, files, "{}, frame {i}", entry.file());
        }
    }
    assert!(count >= 7, "only {count} series found");
}

#[test]
fn a_missing_frame_fails_and_the_others_play() {
    let Some(dir) = data_dir() else { return };
    let path = dir.join("formats/series/missing_file.pvd");
    let series = Series::open(&path, &SeriesOptions::default()).expect("opens");
    let read = |i| series.read(i, &FrameRequest::default(), &Cancel::default());
    assert_eq!(series.frame_count(), 3);
    assert!(read(0).is_ok() && read(2).is_ok());
    let error = read(1).expect_err("the file is not there");
    assert_eq!(error.kind.as_str(), "not_found");
}
