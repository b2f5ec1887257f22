//! What of a file is taken: every n-th, a box, no ghosts; and the times of frames that state none.

mod common;

use std::path::{Path, PathBuf};

use common::xml::{Format, Packing, Xml};
use meniscus_core::{Cancel, FrameRequest, FrameSource};
use meniscus_io::{Error, Region, Series, SeriesOptions};

/// Ten points on a line of slope: x = 0, 0.5, ..., 4.5.
fn file(folder: &Path, edit: impl Fn(String) -> String) -> PathBuf {
    let path = folder.join("points.vtu");
    let text = String::from_utf8(Xml::plain(Format::Ascii).bytes()).expect("text");
    std::fs::write(&path, edit(text)).expect("written");
    path
}

fn x_of(path: &Path, options: &SeriesOptions) -> Result<Vec<f64>, Error> {
    let series = Series::open(path, options)?;
    let frame = series.read(0, &FrameRequest::default(), &Cancel::default()).expect("reads");
    Ok(frame.sets[0].particles.positions.iter().map(|p| f64::from(p[0]) + frame.origin.x).collect())
}

#[test]
fn every_nth_goes_by_id_else_by_index() {
    let folder = tempfile::tempdir().expect("a folder");
    let with_ids = |ids: &'static str| {
        let text = format!(
            "<VTKFile type='UnstructuredGrid'><UnstructuredGrid><Piece NumberOfPoints='6' NumberOfCells='0'>
            <PointData><DataArray type='Int64' Name='id' format='ascii'>{ids}</DataArray></PointData>
            <Points><DataArray type='Float64' NumberOfComponents='3' format='ascii'>
            0 0 0 1 0 0 2 0 0 3 0 0 4 0 1 5 1 0</DataArray></Points></Piece></UnstructuredGrid></VTKFile>"
        );
        file(folder.path(), |_| text.clone())
    };
    for (ids, every, expected) in [
        ("5 4 3 2 1 0", 2, &[1.0, 3.0, 5.0][..]),
        ("5 4 3 2 1 0", 3, &[2.0, 5.0]),
        ("5 4 3 2 1 0", 1, &[0.0, 1.0, 2.0, 3.0, 4.0, 5.0]),
        // All even: ids would take all of them.
        ("0 2 4 6 8 10", 2, &[0.0, 2.0, 4.0]),
    ] {
        let options = SeriesOptions { every: Some(every), ..Default::default() };
        assert_eq!(x_of(&with_ids(ids), &options).expect("opens"), expected, "every {every} of {ids}");
    }
}

/// More points than one block has, in two pieces: what is selected is what a look at all of them selects.
#[test]
fn many_points_are_selected_by_their_own_values() {
    let folder = tempfile::tempdir().expect("a folder");
    for (format, packing) in [
        (Format::AppendedRaw, Packing::None),
        (Format::AppendedRaw, Packing::Zlib),
        (Format::Inline, Packing::None),
        (Format::Ascii, Packing::None),
    ] {
        let case = Xml { packing, block: 32_768, pieces: &[70_001, 150_000], ..Xml::plain(format) };
        let path = folder.path().join("many.vtu");
        std::fs::write(&path, case.bytes()).expect("written");
        let options = SeriesOptions {
            where_expr: Some("x > 20000 and id > 1099511807779".into()),
            region: Some(",,,-1000,,".parse().expect("a box")),
            every: Some(7),
            ..Default::default()
        };
        let series = Series::open(&path, &options).expect("opens");
        let request = FrameRequest { attributes: vec!["density".into()] };
        let frame = series.read(0, &request, &Cancel::default()).expect("reads");
        let is_in = |i: &usize| {
            let [x, y, _] = Xml::point(*i);
            x > 20_000.0 && y <= -1000.0 && Xml::id(*i) > 1_099_511_807_779 && Xml::id(*i) % 7 == 0
        };
        let expected: Vec<usize> = (0..220_001).filter(is_in).collect();
        let water = &frame.sets[0].particles;
        let ids: Vec<u64> = expected.iter().map(|&i| Xml::id(i) as u64).collect();
        let densities: Vec<f32> = expected.iter().map(|&i| Xml::density(i) as f32).collect();
        assert_eq!(water.ids, ids, "{format:?} {packing:?}");
        assert_eq!(water.attributes[0].values, densities, "{format:?} {packing:?}");
        assert_eq!(water.positions.len(), ids.len());
        assert_eq!(series.frame_info(0, false).expect("reads").sets[0].points, ids.len());
    }
}

#[test]
fn a_box_is_in_file_coordinates_and_closed() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = file(folder.path(), |text| text);
    let region: Region = "0.5,2,,,,".parse().expect("a box");
    let options = SeriesOptions { region: Some(region), ..Default::default() };
    assert_eq!(x_of(&path, &options).expect("opens"), [0.5, 1.0, 1.5, 2.0]);
    let region: Region = "90,100,,,,".parse().expect("a box");
    let options = SeriesOptions { region: Some(region), ..Default::default() };
    let error = x_of(&path, &options).expect_err("nothing there").to_string();
    assert!(error.contains("--box") && error.contains("x 0 to 4.5"), "{error}");
}

#[test]
fn ghost_points_are_left_out_and_said() {
    let folder = tempfile::tempdir().expect("a folder");
    let ghosts = "<DataArray type='UInt8' Name='vtkGhostType' format='ascii'>0 1 2 3 4 0 0 0 0 0</DataArray>";
    let path = file(folder.path(), |text| text.replace("</PointData>", &format!("{ghosts}</PointData>")));
    let x = x_of(&path, &SeriesOptions::default()).expect("opens");
    assert_eq!(x, [0.0, 2.0, 2.5, 3.0, 3.5, 4.0, 4.5]);
    let series = Series::open(&path, &SeriesOptions::default()).expect("opens");
    let said = series.choices().iter().find(|choice| choice.what == "ghosts").expect("a choice");
    assert!(said.value.starts_with("3 of 10"), "{said}");
    let keep = SeriesOptions { keep_ghosts: true, ..Default::default() };
    assert_eq!(x_of(&path, &keep).expect("opens").len(), 10);
}

#[test]
fn points_of_ghost_cells_only_are_left_out() {
    let folder = tempfile::tempdir().expect("a folder");
    // Cell 0 is a copy, cell 2 is hidden; cell 3 shares the point of cell 2 and is real.
    let text = "<VTKFile type='UnstructuredGrid'><UnstructuredGrid><Piece NumberOfPoints='3' NumberOfCells='4'>
        <CellData><DataArray type='UInt8' Name='vtkGhostType' format='ascii'>1 0 32 0</DataArray></CellData>
        <Points><DataArray type='Float64' NumberOfComponents='3' format='ascii'>0 0 0 1 0 0 2 0 0</DataArray></Points>
        <Cells><DataArray type='Int64' Name='connectivity' format='ascii'>0 1 2 2</DataArray>
        <DataArray type='Int64' Name='offsets' format='ascii'>1 2 3 4</DataArray>
        <DataArray type='UInt8' Name='types' format='ascii'>1 1 1 1</DataArray></Cells>
        </Piece></UnstructuredGrid></VTKFile>";
    let path = folder.path().join("cells.vtu");
    std::fs::write(&path, text).expect("written");
    assert_eq!(x_of(&path, &SeriesOptions::default()).expect("opens"), [1.0, 2.0]);
}

#[test]
fn the_time_step_counts_missing_numbers() {
    let folder = tempfile::tempdir().expect("a folder");
    for number in [2, 3, 5] {
        let bytes = Xml::plain(Format::AppendedRaw).bytes();
        std::fs::write(folder.path().join(format!("f_{number}.vtu")), bytes).expect("written");
    }
    let options = SeriesOptions { time_step: Some(0.25), ..Default::default() };
    let series = Series::open(folder.path(), &options).expect("opens");
    assert_eq!(series.times(), [Some(0.0), Some(0.25), Some(0.75)]);
    let frame = series.read(2, &FrameRequest::default(), &Cancel::default()).expect("reads");
    assert_eq!(frame.time, Some(0.75));

    // However the files are named, the gap is said.
    for input in [".", "f_%d.vtu", "f_*.vtu"] {
        let series = Series::open(&folder.path().join(input), &options).expect("opens");
        let said: Vec<String> = series.choices().iter().map(ToString::to_string).collect();
        let gap = said.iter().find(|line| line.starts_with("frames: 3 files (1 file is missing: number 4;"));
        assert!(gap.is_some(), "{input}: {said:?}");
    }
}

#[test]
fn opening_stops_on_request() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = file(folder.path(), |text| text);
    let cancel = Cancel::default();
    assert!(Series::open_unless(&path, &SeriesOptions::default(), &cancel).is_ok());
    cancel.cancel();
    let stopped = Series::open_unless(&path, &SeriesOptions::default(), &cancel);
    assert!(matches!(stopped, Err(Error::Cancelled)));
}
