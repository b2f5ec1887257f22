//! Films read back: by the decoder for what is seen, by their bytes for what players are told.

use std::path::Path;

use openh264::decoder::Decoder;
use openh264::formats::YUVSource;

use super::*;

/// Waves that move, of all colours.
fn picture(size: [u32; 2], number: u32) -> Vec<u32> {
    let wave = |x: f32| ((x.sin() * 0.5 + 0.5) * 200.0) as u32 + 20;
    let pixel = |i: u32| {
        let (x, y) = ((i % size[0]) as f32, (i / size[0]) as f32);
        let [r, g, b] =
            [wave(x * 0.05 + number as f32 * 0.3), wave(y * 0.06 + x * 0.02), wave((x - y) * 0.03 + 2.0)];
        0xff00_0000 | b << 16 | g << 8 | r
    };
    (0..size[0] * size[1]).map(pixel).collect()
}

fn options(size: [u32; 2], pictures: u64) -> FilmOptions {
    FilmOptions {
        size,
        rate: FrameRate { numerator: 30000, denominator: 1001 },
        pictures,
        quality: DEFAULT_FILM_QUALITY,
        bits_per_second: None,
        encoder: Encoder::BuiltIn,
    }
}

/// A film of `count` pictures at `path`.
fn make(path: &Path, options: &FilmOptions, count: u32) -> FinishedFilm {
    let mut film = open_film(path, options).unwrap();
    for number in 0..count {
        film.push(&picture(options.size, number)).unwrap();
    }
    film.finish(path).unwrap()
}

/// Peak signal-to-noise ratio of red, green and blue, dB.
fn psnr(a: &[u32], b: &[u32]) -> f64 {
    assert_eq!(a.len(), b.len());
    let channels = |p: u32| p.to_le_bytes().into_iter().take(3).map(f64::from);
    let squares: f64 =
        a.iter().zip(b).flat_map(|(a, b)| channels(*a).zip(channels(*b))).map(|(a, b)| (a - b).powi(2)).sum();
    10.0 * (255.0_f64.powi(2) * (3 * a.len()) as f64 / squares.max(1e-9)).log10()
}

/// Content of the box that lies at `names`, one in the other.
fn find<'a>(mut bytes: &'a [u8], names: &[&str]) -> &'a [u8] {
    for name in names {
        let (mut rest, mut found) = (bytes, None);
        while rest.len() >= 8 {
            let length = u32::from_be_bytes(rest[..4].try_into().unwrap()) as usize;
            let (header, length) = match length {
                1 => (16, u64::from_be_bytes(rest[8..16].try_into().unwrap()) as usize),
                length => (8, length),
            };
            if &rest[4..8] == name.as_bytes() {
                found = Some(&rest[header..length]);
                break;
            }
            rest = &rest[length..];
        }
        bytes = found.unwrap_or_else(|| panic!("no {name} of {names:?}"));
        // What comes before the boxes inside.
        bytes = match *name {
            "stsd" => &bytes[8..],
            "avc1" => &bytes[78..],
            _ => bytes,
        };
    }
    bytes
}

fn u32_at(bytes: &[u8], offset: usize) -> u32 {
    u32::from_be_bytes(bytes[offset..offset + 4].try_into().unwrap())
}

const SAMPLES: [&str; 5] = ["moov", "trak", "mdia", "minf", "stbl"];

fn samples(bytes: &[u8], name: &'static str) -> Vec<u8> {
    find(bytes, &[&SAMPLES[..], &[name]].concat()).to_vec()
}

/// A decoded picture as colours of a display, by the formulas of BT.709 in floating point; every colour holds for two by two
/// pixels.
fn colours(frame: &impl YUVSource) -> Vec<u32> {
    let ((width, height), (y_stride, u_stride, v_stride)) = (frame.dimensions(), frame.strides());
    let colour = |i: usize| {
        let (x, y) = (i % width, i / width);
        let brightness = (f64::from(frame.y()[y * y_stride + x]) - 16.0) / 219.0;
        let blue = (f64::from(frame.u()[y / 2 * u_stride + x / 2]) - 128.0) / 224.0;
        let red = (f64::from(frame.v()[y / 2 * v_stride + x / 2]) - 128.0) / 224.0;
        let (r, b) = (brightness + 1.5748 * red, brightness + 1.8556 * blue);
        let g = (brightness - 0.2126 * r - 0.0722 * b) / 0.7152;
        let [r, g, b] = [r, g, b].map(|c| (c * 255.0).round().clamp(0.0, 255.0) as u32);
        0xff00_0000 | b << 16 | g << 8 | r
    };
    (0..width * height).map(colour).collect()
}

/// Every picture of an `.mp4` as a player finds it: by the tables of chunks, sizes and key pictures.
fn decode(bytes: &[u8]) -> (Vec<Vec<u32>>, [u32; 2]) {
    let avcc = find(bytes, &[&SAMPLES[..], &["stsd", "avc1", "avcC"]].concat());
    let sps_length = usize::from(u16::from_be_bytes([avcc[6], avcc[7]]));
    let sps = &avcc[8..8 + sps_length];
    let rest = &avcc[8 + sps_length + 1..];
    let pps = &rest[2..2 + usize::from(u16::from_be_bytes([rest[0], rest[1]]))];
    let mut decoder = Decoder::new().unwrap();
    let start = [0, 0, 0, 1];
    let _ = decoder.decode(&[&start[..], sps, &start, pps].concat()).unwrap();

    let (sizes, chunks, runs) = (samples(bytes, "stsz"), samples(bytes, "co64"), samples(bytes, "stsc"));
    let mut sample = 0;
    let (mut pictures, mut size) = (Vec::new(), [0, 0]);
    for chunk in 0..u32_at(&chunks, 4) as usize {
        let mut offset = u64::from_be_bytes(chunks[8 + 8 * chunk..][..8].try_into().unwrap()) as usize;
        let runs =
            (0..u32_at(&runs, 4) as usize).map(|i| (u32_at(&runs, 8 + 12 * i), u32_at(&runs, 12 + 12 * i)));
        let (_, in_chunk) = runs.take_while(|(first, _)| *first as usize <= chunk + 1).last().unwrap();
        for _ in 0..in_chunk {
            let length = u32_at(&sizes, 12 + 4 * sample) as usize;
            let mut units = &bytes[offset..offset + length];
            let mut annex_b = Vec::new();
            while !units.is_empty() {
                let unit = u32_at(units, 0) as usize;
                annex_b.extend(start);
                annex_b.extend(&units[4..4 + unit]);
                units = &units[4 + unit..];
            }
            let frame = decoder.decode(&annex_b).unwrap().expect("a picture for every sample");
            let (width, height) = frame.dimensions();
            size = [width as u32, height as u32];
            pictures.push(colours(&frame));
            offset += length;
            sample += 1;
        }
    }
    (pictures, size)
}

#[test]
fn an_mp4_shows_the_pictures_that_went_in() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("film.mp4");
    // More than two seconds: several chunks and key pictures.
    let (size, count) = ([128, 72], 64);
    let film = make(&path, &options(size, u64::from(count)), count);
    assert_eq!(film, FinishedFilm { path: path.clone(), pictures: u64::from(count) });
    let bytes = std::fs::read(&path).unwrap();
    let (pictures, decoded_size) = decode(&bytes);
    assert_eq!((pictures.len(), decoded_size), (count as usize, size));
    for (number, decoded) in pictures.iter().enumerate() {
        // What films are held to. A shift of colours by another matrix or range stays below 30.
        let psnr = psnr(decoded, &picture(size, number as u32));
        assert!(psnr >= 38.0, "picture {number}: {psnr} dB");
    }
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1, "nothing else is left");
}

#[test]
fn players_are_told_rate_size_colours_and_where_to_jump_before_the_pictures() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("film.mp4");
    make(&path, &options([128, 72], 100), 64);
    let bytes = std::fs::read(&path).unwrap();
    let mut order = Vec::new();
    let mut rest = &bytes[..];
    while !rest.is_empty() {
        order.push(String::from_utf8_lossy(&rest[4..8]).into_owned());
        let length = u32_at(rest, 0);
        rest = &rest[if length == 1 { u32_at(rest, 12) } else { length } as usize..];
    }
    assert_eq!(order, ["ftyp", "moov", "free", "mdat"]);
    let header = find(&bytes, &["moov", "trak", "mdia", "mdhd"]);
    assert_eq!((u32_at(header, 20), u32_at(header, 28)), (30000, 64 * 1001));
    assert_eq!(samples(&bytes, "stts")[4..], [0, 0, 0, 1, 0, 0, 0, 64, 0, 0, 3, 233]);
    let track = find(&bytes, &["moov", "trak", "tkhd"]);
    assert_eq!((u32_at(track, 88) >> 16, u32_at(track, 92) >> 16), (128, 72));
    let colours = find(&bytes, &[&SAMPLES[..], &["stsd", "avc1", "colr"]].concat());
    assert_eq!(colours, [b"nclx", &[0, 1, 0, 1, 0, 1, 0][..]].concat());
    let keys = samples(&bytes, "stss");
    assert_eq!((u32_at(&keys, 4), u32_at(&keys, 8), u32_at(&keys, 12)), (2, 1, 61), "every two seconds");
}

/// The stream says its colours as well: some players look only there.
#[test]
fn the_stream_itself_is_tagged_bt709() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("film.mp4");
    make(&path, &options([128, 72], 1), 1);
    let bytes = std::fs::read(&path).unwrap();
    let avcc = find(&bytes, &[&SAMPLES[..], &["stsd", "avc1", "avcC"]].concat());
    let sps = &avcc[8..8 + usize::from(u16::from_be_bytes([avcc[6], avcc[7]]))];
    // video_signal_type_present, format 5 (unspecified), video range, colours present, then 1, 1, 1: ITU-T H.264, E.1.1.
    let expected = "1101010000000100000001".to_owned() + "00000001";
    let bits: String = sps.iter().map(|byte| format!("{byte:08b}")).collect();
    assert!(bits.contains(&expected), "{bits}");
}

#[test]
fn odd_sizes_grow_by_their_last_pixels() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("film.mp4");
    let size = [65, 33];
    make(&path, &options(size, 2), 2);
    let (pictures, decoded) = decode(&std::fs::read(&path).unwrap());
    assert_eq!(decoded, [66, 34]);
    assert!(psnr(&pictures[1], &even::padded(&picture(size, 1), size)) >= 38.0);
}

#[test]
fn more_quality_is_nearer_and_larger_and_a_bit_rate_is_kept_to() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("film.mp4");
    let size = [128, 72];
    let measured = |change: &dyn Fn(&mut FilmOptions)| {
        let mut options = options(size, 48);
        change(&mut options);
        make(&path, &options, 48);
        let bytes = std::fs::read(&path).unwrap();
        (psnr(&decode(&bytes).0[40], &picture(size, 40)), bytes.len())
    };
    let (bad, good) = (measured(&|o| o.quality = 30), measured(&|o| o.quality = 95));
    assert!(good.0 > bad.0 + 5.0 && good.1 > 2 * bad.1, "{bad:?} {good:?}");
    let [slow, fast] = [100_000, 400_000].map(|bits| measured(&|o| o.bits_per_second = Some(bits)).1);
    // 48 pictures are 1.6 s. A rate is kept to over seconds, not in the first of them.
    assert!(slow < 100_000 / 8 * 3 && fast > slow, "{slow} {fast}");
}

#[test]
fn the_same_pictures_are_the_same_bytes() {
    let folder = tempfile::tempdir().unwrap();
    for name in ["film.mp4", "film.avi"] {
        let bytes = [0, 1].map(|run| {
            let path = folder.path().join(format!("{run}{name}"));
            make(&path, &options([64, 48], 5), 5);
            std::fs::read(path).unwrap()
        });
        assert!(bytes[0] == bytes[1], "{name}");
    }
}

#[test]
fn a_film_that_is_not_finished_leaves_nothing_and_one_that_is_cut_short_plays() {
    let folder = tempfile::tempdir().unwrap();
    for name in ["film.mp4", "film.avi"] {
        let path = folder.path().join(name);
        let mut film = open_film(&path, &options([64, 48], 50)).unwrap();
        film.push(&picture([64, 48], 0)).unwrap();
        drop(film);
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
    }
    let path = folder.path().join("part.mp4");
    make(&path, &options([64, 48], 50), 3);
    assert_eq!(decode(&std::fs::read(&path).unwrap()).0.len(), 3);
    let empty = open_film(&path, &options([64, 48], 50)).unwrap().finish(&path);
    assert!(empty.unwrap_err().to_string().contains("no picture"));
}

#[test]
fn what_an_encoder_cannot_do_is_refused_before_anything_is_drawn() {
    let folder = tempfile::tempdir().unwrap();
    let refused = |name: &str, change: &dyn Fn(&mut FilmOptions)| {
        let mut options = options([64, 48], 1);
        change(&mut options);
        let Err(error) = open_film(&folder.path().join(name), &options) else { panic!("{name}") };
        error.to_string()
    };
    assert!(refused("a.mp4", &|o| o.size = [4096, 2160]).contains("--encoder ffmpeg"));
    assert!(refused("a.mp4", &|o| o.size = [8, 64]).contains("16x16"));
    assert!(refused("a.avi", &|o| o.bits_per_second = Some(1)).contains("--quality"));
    assert!(refused("a.webm", &|_| {}).contains("--encoder ffmpeg"));
    assert!(refused("a.png", &|_| {}).contains("single pictures"));
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
}
