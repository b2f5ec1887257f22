//! Series that a solver still writes, and first impressions of their frames.

mod common;

use std::fs;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::thread;
use std::time::Duration;

use common::xml::{Format, Packing, Xml};
use meniscus_core::{Cancel, FrameRequest, FrameSource, SetFrame};
use meniscus_io::{Series, SeriesOptions};

fn put(folder: &Path, frame: usize) -> PathBuf {
    let path = folder.join(format!("f_{frame}.vtu"));
    fs::write(&path, Xml::plain(Format::AppendedRaw).bytes()).expect("written");
    path
}

fn open(input: &Path, time_step: Option<f64>) -> Series {
    Series::open(input, &SeriesOptions { time_step, ..Default::default() }).expect("opens")
}

#[test]
fn frames_are_added_behind_those_known() {
    for input in ["", "f_*.vtu", "f_%d.vtu"] {
        let folder = tempfile::tempdir().expect("a folder");
        let _known = [2, 3].map(|frame| put(folder.path(), frame));
        let series = open(&folder.path().join(input), Some(0.5));
        assert_eq!(series.look_again().expect("looks"), 2);
        // One before the others would move their numbers.
        let added: Vec<_> = [1, 4, 10].map(|frame| put(folder.path(), frame)).into();
        fs::remove_file(folder.path().join("f_1.vtu")).expect("removed");
        assert_eq!(series.look_again().expect("looks"), 4, "{input:?}");
        assert_eq!((series.files(2), series.files(3)), (vec![added[1].clone()], vec![added[2].clone()]));
        // The numbers of the files are 2, 3, 4 and 10.
        assert_eq!(series.times(), [0.0, 0.5, 1.0, 4.0].map(Some));
        put(folder.path(), 5);
        assert_eq!(
            series.look_again().expect("looks"),
            4,
            "one between the others would move their numbers, too"
        );
        fs::remove_file(folder.path().join("f_2.vtu")).expect("removed");
        assert_eq!(series.look_again().expect("looks"), 4);
        assert!(series.read(0, &FrameRequest::default(), &Cancel::default()).is_err());
        assert!(series.read(3, &FrameRequest::default(), &Cancel::default()).is_ok());
    }
}

#[test]
fn a_collection_grows_by_what_it_lists() {
    let folder = tempfile::tempdir().expect("a folder");
    let collection = folder.path().join("water.pvd");
    let list = |frames: &[usize]| {
        let entry = |frame: &usize| format!("<DataSet timestep=\"{frame}\" file=\"f_{frame}.vtu\"/>");
        let entries: String = frames.iter().map(entry).collect();
        let text = format!("<VTKFile type=\"Collection\"><Collection>{entries}</Collection></VTKFile>");
        fs::write(&collection, text).expect("written");
    };
    (0..4).for_each(|frame| drop(put(folder.path(), frame)));
    list(&[0, 1]);
    let series = [collection.as_path(), folder.path()].map(|input| open(input, None));
    let counts = || series.each_ref().map(|series| series.look_again().unwrap_or(series.frame_count()));
    assert_eq!(counts(), [2, 2]);
    fs::write(&collection, "<VTKFile type=\"Coll").expect("half written");
    assert_eq!(counts(), [2, 2], "the files beside it are another series");
    list(&[0, 1, 3]);
    assert_eq!(counts(), [3, 3]);
    assert_eq!(series[0].times(), [0.0, 1.0, 3.0].map(Some));
}

#[test]
fn a_series_that_is_followed_grows_by_itself() {
    let folder = tempfile::tempdir().expect("a folder");
    put(folder.path(), 0);
    let series = Arc::new(open(folder.path(), None));
    let follow = series.follow();
    put(folder.path(), 1);
    // A minute only keeps a broken build from hanging.
    for _ in 0..60_000 {
        if series.frame_count() == 2 {
            drop(follow);
            assert_eq!(Arc::strong_count(&series), 1, "its thread has ended");
            return;
        }
        thread::sleep(Duration::from_millis(1));
    }
    panic!("the frame was never noticed");
}

#[test]
fn versions_tell_what_happens_to_files() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = put(folder.path(), 0);
    let series = open(folder.path(), None);
    let version = || series.version(0).expect("a version");
    let first = version();
    assert_eq!(version(), first);
    fs::write(&path, "something longer or shorter").expect("written");
    let second = version();
    fs::remove_file(&path).expect("removed");
    let third = version();
    assert!(first != second && second != third && first != third);
}

#[test]
fn a_first_impression_is_a_part_spread_over_the_frame() {
    let request = FrameRequest::default();
    let coarse = |xml: Xml, share: u32| -> (Option<SetFrame>, SetFrame) {
        let folder = tempfile::tempdir().expect("a folder");
        fs::write(folder.path().join("f.vtu"), xml.bytes()).expect("written");
        let series = open(folder.path(), None);
        let part = series.read_coarse(0, share, &request, &Cancel::default()).expect("reads");
        (part, series.read(0, &request, &Cancel::default()).expect("reads"))
    };
    let large = Xml { pieces: &[20_000], block: 3000, ..Xml::plain(Format::AppendedRaw) };
    for xml in
        [large, Xml { packing: Packing::Zlib, ..large }, Xml { format: Format::AppendedBase64, ..large }]
    {
        let (part, whole) = coarse(xml, 2);
        let part = part.expect("a part");
        let all = &whole.sets[0].particles.positions;
        // The first, third and fifth run of 4096.
        let expected = [&all[..4096], &all[8192..12288], &all[16384..]].concat();
        assert!(part.sets[0].particles.positions == expected, "{xml:?}");
        assert_eq!((part.index, part.origin), (whole.index, whole.origin));
    }
    // Where all of it has to be looked at, or nothing is gained, there is none.
    assert!(coarse(Xml { format: Format::Ascii, ..large }, 2).0.is_none());
    assert!(coarse(large, 8).0.is_none());
}
