//! Damaged files: whatever is wrong with them, the answer is particles or an error, never a crash, a hang, or memory that the
//! file does not back. A bounded, seeded run; the same every time.

mod common;

use std::path::Path;

use common::legacy;
use common::records::{self, PLY_FORMATS};
use common::xml::{Format, Packing, Xml};
use meniscus_core::{Cancel, FrameRequest, FrameSource};
use meniscus_io::{Series, SeriesOptions};

/// Damaged copies of each file.
const ROUNDS: u64 = 150;

/// SplitMix64 (Steele et al. 2014).
struct Random(u64);

impl Random {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ z >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ z >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ z >> 31
    }

    fn below(&mut self, end: usize) -> usize {
        (self.next() % end.max(1) as u64) as usize
    }
}

/// Numbers that readers get wrong.
const NUMBERS: [&str; 9] = [
    "0",
    "-1",
    "1",
    "255",
    "4294967295",
    "4294967296",
    "9223372036854775807",
    "18446744073709551615",
    "1e400",
];

fn damage(bytes: &mut Vec<u8>, random: &mut Random) {
    let at = random.below(bytes.len());
    match random.below(6) {
        0 => bytes[at] ^= 1 << random.below(8),
        1 => bytes[at] = random.next() as u8,
        2 => bytes.truncate(at),
        3 => {
            let end = (at + random.below(40)).min(bytes.len());
            bytes.drain(at..end);
        }
        4 => {
            let end = (at + random.below(40)).min(bytes.len());
            let copy = bytes[at..end].to_vec();
            bytes.splice(at..at, copy);
        }
        _ => {
            // The next run of digits becomes another number.
            let Some(start) = bytes[at..].iter().position(u8::is_ascii_digit).map(|i| at + i) else { return };
            let length = bytes[start..].iter().take_while(|b| b.is_ascii_digit()).count();
            bytes.splice(start..start + length, NUMBERS[random.below(NUMBERS.len())].bytes());
        }
    }
}

/// Everything a caller may do with a file.
fn use_it(path: &Path) {
    let Ok(series) = Series::open(path, &SeriesOptions::default()) else { return };
    let Ok(info) = series.frame_info(0, true) else { return };
    let attributes = info.attributes.iter().map(|a| a.name.clone()).collect();
    let _ = series.read(0, &FrameRequest { attributes }, &Cancel::default());
}

#[test]
fn damaged_files_are_survived() {
    let xml = |format, packing| ("vtu", Xml { packing, pieces: &[3, 0, 8], ..Xml::plain(format) }.bytes());
    let seeds = [
        xml(Format::Ascii, Packing::None),
        xml(Format::Inline, Packing::None),
        xml(Format::Inline, Packing::Zlib),
        xml(Format::AppendedRaw, Packing::None),
        xml(Format::AppendedRaw, Packing::Zlib),
        xml(Format::AppendedRaw, Packing::Lz4),
        xml(Format::AppendedBase64, Packing::Lz4),
        ("vtk", legacy::ASCII.as_bytes().to_vec()),
        ("vtk", legacy::binary()),
        ("vtp", include_bytes!("data/lzma.vtp").to_vec()),
        ("bgeo", records::bgeo(8)),
        ("bgeo", records::gzip(&records::bgeo(8))),
        ("ply", records::ply(8, PLY_FORMATS[0], "\n")),
        ("ply", records::ply(8, PLY_FORMATS[1], "\n")),
        ("csv", records::table(8, "id,x,y,z,u,v,w\n", ",")),
        ("pvd", b"<VTKFile type='Collection'><Collection><DataSet timestep='1' file='a.vtu'/></Collection></VTKFile>".to_vec()),
        ("series", br#"{"file-series-version":"1.0","files":[{"name":"a.vtu","time":0.5}]}"#.to_vec()),
    ];
    let folder = tempfile::tempdir().expect("a folder");
    std::fs::write(folder.path().join("a.vtu"), Xml::plain(Format::Ascii).bytes()).expect("written");
    for (index, (extension, seed)) in seeds.iter().enumerate() {
        let path = folder.path().join(format!("damaged.{extension}"));
        std::fs::write(&path, seed).expect("written");
        assert!(Series::open(&path, &SeriesOptions::default()).is_ok(), "the seed {index} must be sound");
        for round in 0..ROUNDS {
            let mut random = Random(1000 * index as u64 + round);
            let mut bytes = seed.clone();
            for _ in 0..=random.below(3) {
                if !bytes.is_empty() {
                    damage(&mut bytes, &mut random);
                }
            }
            std::fs::write(&path, &bytes).expect("written");
            use_it(&path);
        }
    }
}
