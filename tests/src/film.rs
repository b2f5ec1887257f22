//! Films as players find them, decoded by a library.

use openh264::decoder::Decoder;
use openh264::formats::YUVSource;

use crate::Pixels;

/// A film read back.
pub struct Film {
    /// The boxes of the file, in order.
    pub boxes: Vec<String>,
    /// Pictures per second, numerator and denominator.
    pub rate: [u32; 2],
    /// Primaries, transfer and matrix that the container states.
    pub colours: [u16; 3],
    /// All pictures.
    pub pictures: Vec<Pixels>,
}

/// The boxes around the tables.
const SAMPLES: [&str; 5] = ["moov", "trak", "mdia", "minf", "stbl"];
/// What begins a unit in the form that decoders read.
const START: [u8; 4] = [0, 0, 0, 1];

impl Film {
    /// Decodes an `.mp4` file with H.264.
    ///
    /// # Panics
    /// When anything about it is not as it should be.
    pub fn decode(bytes: &[u8]) -> Self {
        let table = |names: &[&str]| content(bytes, &[&SAMPLES[..], names].concat());
        let entry = table(&["stsd", "avc1", "avcC"]);
        let (sequence, rest) = set(&entry[6..]);
        let (picture, _) = set(&rest[1..]);
        let mut decoder = Decoder::new().expect("a decoder");
        decoder.decode(&[&START, sequence, &START, picture].concat()).expect("parameters");
        let (times, sizes, chunks, runs) =
            (table(&["stts"]), table(&["stsz"]), table(&["co64"]), table(&["stsc"]));
        assert_eq!(number(times, 4), 1, "one length for all pictures");
        let time_scale = number(content(bytes, &["moov", "trak", "mdia", "mdhd"]), 20);
        let mut pictures = Vec::new();
        for chunk in 0..number(chunks, 4) {
            let place = number(chunks, 8 + 8 * chunk) << 32 | number(chunks, 12 + 8 * chunk);
            let starts = (0..number(runs, 4)).map(|i| (number(runs, 8 + 12 * i), number(runs, 12 + 12 * i)));
            let (_, count) = starts.take_while(|(first, _)| *first <= chunk + 1).last().expect("a run");
            let mut place = place;
            for _ in 0..count {
                let length = number(sizes, 12 + 4 * pictures.len());
                let units = with_start_codes(&bytes[place..place + length]);
                pictures.push(colours(&decoder.decode(&units).expect("a picture").expect("a whole one")));
                place += length;
            }
        }
        assert_eq!(pictures.len(), number(sizes, 8), "all pictures are in chunks");
        let colr = table(&["stsd", "avc1", "colr"]);
        Self {
            boxes: boxes(bytes).into_iter().map(|(name, _)| name).collect(),
            rate: [time_scale as u32, number(times, 12) as u32],
            colours: [4, 6, 8].map(|at| u16::from_be_bytes([colr[at], colr[at + 1]])),
            pictures,
        }
    }
}

impl Pixels {
    /// Peak signal-to-noise ratio of red, green and blue against `other`, dB.
    ///
    /// # Panics
    /// When the sizes differ.
    pub fn psnr(&self, other: &Self) -> f64 {
        assert_eq!(self.size, other.size);
        let pairs = self.rgba.iter().zip(&other.rgba).flat_map(|(a, b)| a[..3].iter().zip(&b[..3]));
        let squares: f64 = pairs.map(|(a, b)| f64::from(a.abs_diff(*b)).powi(2)).sum();
        10.0 * (255.0_f64.powi(2) * (3 * self.rgba.len()) as f64 / squares.max(1e-9)).log10()
    }
}

/// Name and content of each box.
fn boxes(mut bytes: &[u8]) -> Vec<(String, &[u8])> {
    let mut found = Vec::new();
    while bytes.len() >= 8 {
        let (header, length) = match number(bytes, 0) {
            1 => (16, number(bytes, 8) << 32 | number(bytes, 12)),
            length => (8, length),
        };
        found.push((String::from_utf8_lossy(&bytes[4..8]).into_owned(), &bytes[header..length]));
        bytes = &bytes[length..];
    }
    found
}

/// Content of the box that lies at `names`, one in the other.
fn content<'a>(bytes: &'a [u8], names: &[&str]) -> &'a [u8] {
    names.iter().fold(bytes, |bytes, name| {
        let found = boxes(bytes).into_iter().find(|(found, _)| found == name);
        let (_, inner) = found.unwrap_or_else(|| panic!("no {name} of {names:?}"));
        // What comes before the boxes inside.
        match *name {
            "stsd" => &inner[8..],
            "avc1" => &inner[78..],
            _ => inner,
        }
    })
}

/// 32 bits at `offset`.
fn number(bytes: &[u8], offset: usize) -> usize {
    u32::from_be_bytes(bytes[offset..offset + 4].try_into().expect("four bytes")) as usize
}

/// A parameter set after its length, and what follows.
fn set(bytes: &[u8]) -> (&[u8], &[u8]) {
    bytes[2..].split_at(usize::from(u16::from_be_bytes([bytes[0], bytes[1]])))
}

fn with_start_codes(mut units: &[u8]) -> Vec<u8> {
    let mut out = Vec::new();
    while !units.is_empty() {
        let (unit, rest) = units[4..].split_at(number(units, 0));
        out.extend(START);
        out.extend(unit);
        units = rest;
    }
    out
}

/// By the formulas of ITU-T BT.709; every colour holds for two by two pixels.
fn colours(frame: &impl YUVSource) -> Pixels {
    let ((width, height), (y_stride, u_stride, v_stride)) = (frame.dimensions(), frame.strides());
    let colour = |i: usize| {
        let (x, y) = (i % width, i / width);
        let brightness = (f64::from(frame.y()[y * y_stride + x]) - 16.0) / 219.0;
        let blue = (f64::from(frame.u()[y / 2 * u_stride + x / 2]) - 128.0) / 224.0;
        let red = (f64::from(frame.v()[y / 2 * v_stride + x / 2]) - 128.0) / 224.0;
        let (r, b) = (brightness + 1.5748 * red, brightness + 1.8556 * blue);
        let g = (brightness - 0.2126 * r - 0.0722 * b) / 0.7152;
        let [r, g, b] = [r, g, b].map(|c| (c * 255.0).round().clamp(0.0, 255.0) as u8);
        [r, g, b, 255]
    };
    Pixels { size: [width as u32, height as u32], rgba: (0..width * height).map(colour).collect() }
}
