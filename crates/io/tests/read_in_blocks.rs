//! Files that are read in blocks instead of mapped: the same particles, the same refusals.

mod common;

use std::path::{Path, PathBuf};

use common::xml::{Format, Packing, Xml};
use common::{data_dir, legacy};
use meniscus_core::{Cancel, FrameRequest, FrameSource, SetFrame};
use meniscus_io::{Error, IoMode, Series, SeriesOptions};

/// Everything of the first frame.
fn read(path: &Path, io_mode: IoMode) -> Result<(SetFrame, serde_json::Value), Error> {
    let series = Series::open(path, &SeriesOptions { io_mode, ..Default::default() })?;
    let info = series.frame_info(0, true)?;
    let attributes = info.attributes.iter().map(|a| a.name.clone()).collect();
    let frame = series.read(0, &FrameRequest { attributes }, &Cancel::default());
    let frame = frame.map_err(|e| Error::Usage { message: e.to_string() })?;
    Ok((frame, serde_json::to_value(info).expect("plain data")))
}

/// The two ways of reading `path` agree, also in what they refuse; whether it could be read.
fn agree(path: &Path) -> bool {
    let (mapped, blocks) = (read(path, IoMode::Map), read(path, IoMode::Read));
    match (mapped, blocks) {
        (Ok((mapped, mapped_info)), Ok((blocks, blocks_info))) => {
            // As text, in which NaN equals NaN.
            assert_eq!(format!("{:?}", mapped.sets), format!("{:?}", blocks.sets), "{}", path.display());
            assert_eq!(mapped.read, blocks.read, "{}", path.display());
            assert_eq!(mapped_info, blocks_info, "{}", path.display());
            true
        }
        (Err(mapped), Err(blocks)) => {
            assert_eq!(mapped.to_string(), blocks.to_string());
            false
        }
        (mapped, blocks) => {
            panic!("{}: mapped {:?}, in blocks {:?}", path.display(), mapped.err(), blocks.err())
        }
    }
}

fn put(folder: &Path, name: &str, bytes: impl AsRef<[u8]>) -> PathBuf {
    let path = folder.join(name);
    std::fs::write(&path, bytes).expect("written");
    path
}

#[test]
fn every_encoding_of_files_longer_than_a_block() {
    let folder = tempfile::tempdir().expect("a folder");
    // 20 000 points are 480 kB of coordinates: several blocks of bytes, of characters and of numbers.
    for format in [Format::Ascii, Format::Inline, Format::AppendedRaw, Format::AppendedBase64] {
        for packing in [Packing::None, Packing::Zlib, Packing::Lz4] {
            let case = Xml { packing, block: 32_768, pieces: &[20_000, 3], ..Xml::plain(format) };
            assert!(agree(&put(folder.path(), "case.vtu", case.bytes())), "{format:?} {packing:?}");
            // Values that cross the ends of compressed blocks.
            let case = Xml { block: 32_765, ..case };
            assert!(agree(&put(folder.path(), "case.vtu", case.bytes())), "{format:?} {packing:?}");
        }
    }
}

#[test]
fn base64_in_short_lines() {
    let folder = tempfile::tempdir().expect("a folder");
    for packing in [Packing::None, Packing::Zlib] {
        let case = Xml { packing, block: 32_768, pieces: &[20_000], ..Xml::plain(Format::Inline) }.bytes();
        let mut broken = Vec::new();
        for word in case.split_inclusive(|byte| matches!(byte, b' ' | b'<' | b'>' | b'\n')) {
            // Only data has so long runs without a blank or a bracket.
            if word.len() > 200 {
                word.chunks(76).for_each(|line| broken.extend([line, b"\r\n"].concat()));
            } else {
                broken.extend(word);
            }
        }
        assert!(broken.len() > case.len() + 1000, "lines were broken");
        let (whole, broken) =
            (put(folder.path(), "whole.vtu", case), put(folder.path(), "broken.vtu", broken));
        assert!(agree(&broken), "{packing:?}");
        let sets = |path: &Path| read(path, IoMode::Read).expect("reads").0.sets;
        assert_eq!(sets(&whole), sets(&broken), "{packing:?}");
    }
}

#[test]
fn legacy_files_whose_parts_are_longer_than_a_window() {
    let folder = tempfile::tempdir().expect("a folder");
    assert!(agree(&put(folder.path(), "sections.vtk", legacy::ASCII)));
    assert!(agree(&put(folder.path(), "binary.vtk", legacy::binary())));
    let title = "x".repeat(200_000);
    let blanks = " \n".repeat(100_000);
    let numbers = |count: usize| (0..count).map(|i| format!("{}.25 ", i % 1000)).collect::<String>();
    let text = format!(
        "# vtk DataFile Version 3.0\n{title}\nASCII\nDATASET POLYDATA\nPOINTS 30000 double\n{}\n{blanks}\
         POINT_DATA 30000\nSCALARS p float\nLOOKUP_TABLE default\n{}\nFIELD f 1\nnotes 1 2 string\n{title}\n{title}\n",
        numbers(90_000),
        numbers(30_000)
    );
    let path = put(folder.path(), "long.vtk", text);
    assert!(agree(&path));
    let (frame, _) = read(&path, IoMode::Read).expect("reads");
    assert_eq!(frame.sets[0].particles.attributes[0].values[29_999], 999.25);
}

#[test]
fn files_that_are_cut_off_are_refused_in_the_same_words() {
    let folder = tempfile::tempdir().expect("a folder");
    let xml = Xml { pieces: &[5000], ..Xml::plain(Format::AppendedRaw) }.bytes();
    let base64 = Xml { pieces: &[5000], packing: Packing::Zlib, ..Xml::plain(Format::Inline) }.bytes();
    for (name, bytes) in
        [("a.vtu", xml), ("b.vtu", base64), ("c.vtk", legacy::ASCII.into()), ("d.vtk", legacy::binary())]
    {
        for share in 0..20 {
            agree(&put(folder.path(), name, &bytes[..bytes.len() * share / 20]));
        }
    }
}

#[test]
fn third_party_files() {
    let Some(dir) = data_dir() else { return };
    let is_particles = |entry: &&common::Entry| {
        let name = entry.file();
        [".vtk", ".vtu", ".vtp", ".pvtu", ".pvtp", ".pvd", ".series"].iter().any(|end| name.ends_with(end))
    };
    let entries = common::entries(&dir);
    let read = entries.iter().filter(is_particles).filter(|entry| agree(&dir.join(entry.file()))).count();
    assert!(read > 250, "only {read} could be read");
}
