//! Memory that reading takes beyond the map: little more than what is delivered, whatever the file is stored as.
//!
//! A single test, because the counter is of the whole process.

use std::alloc::{GlobalAlloc, Layout, System};
use std::path::Path;
use std::sync::atomic::{AtomicUsize, Ordering};

use meniscus_core::{Cancel, FrameRequest, FrameSource, ParticleFrame, ParticleSet, SetFrame};
use meniscus_io::writer::{self, Encoding, Format, Values, WriteAttribute, WriteParticles};
use meniscus_io::{IoMode, Series, SeriesOptions};

/// The system's allocator, counting.
struct Counting;

static NOW: AtomicUsize = AtomicUsize::new(0);
static PEAK: AtomicUsize = AtomicUsize::new(0);

fn count(added: usize, removed: usize) {
    let before = NOW.fetch_add(added, Ordering::Relaxed);
    PEAK.fetch_max(before + added, Ordering::Relaxed);
    NOW.fetch_sub(removed, Ordering::Relaxed);
}

// SAFETY: everything is passed on to the system's allocator as it comes.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        count(layout.size(), 0);
        // SAFETY: as above.
        unsafe { System.alloc(layout) }
    }

    unsafe fn alloc_zeroed(&self, layout: Layout) -> *mut u8 {
        count(layout.size(), 0);
        // SAFETY: as above.
        unsafe { System.alloc_zeroed(layout) }
    }

    unsafe fn dealloc(&self, place: *mut u8, layout: Layout) {
        count(0, layout.size());
        // SAFETY: as above.
        unsafe { System.dealloc(place, layout) }
    }

    unsafe fn realloc(&self, place: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        // Large blocks are moved by the page table, not copied.
        count(size.saturating_sub(layout.size()), layout.size().saturating_sub(size));
        // SAFETY: as above.
        unsafe { System.realloc(place, layout, size) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

/// Most bytes that `work` has beyond what was there before, and what it returns.
fn peak_of<T>(work: impl FnOnce() -> T) -> (usize, T) {
    let before = NOW.load(Ordering::Relaxed);
    PEAK.store(before, Ordering::Relaxed);
    let result = work();
    (PEAK.load(Ordering::Relaxed) - before, result)
}

const SIDE: usize = 84;
const POINTS: usize = SIDE * SIDE * SIDE;

const FORMATS: [(&str, Format); 6] = [
    ("raw.vtu", Format::Vtu(Encoding::Raw)),
    ("zlib.vtp", Format::Vtp(Encoding::Zlib)),
    ("base64.vtu", Format::Vtu(Encoding::Base64)),
    ("ascii.vtp", Format::Vtp(Encoding::Ascii)),
    ("binary.vtk", Format::LegacyBinary),
    ("ascii.vtk", Format::LegacyAscii),
];

/// A cube of particles of two kinds, one of them the wall. Only the raw file has a point that is broken.
fn write_all(folder: &Path) {
    let at = |i: usize| [i % SIDE, i / SIDE % SIDE, i / SIDE / SIDE];
    let mut positions: Vec<[f64; 3]> = (0..POINTS).map(|i| at(i).map(|c| c as f64 * 0.01)).collect();
    let kinds: Vec<i32> = (0..POINTS).map(|i| i32::from(at(i).contains(&0))).collect();
    let velocity: Vec<f32> = (0..3 * POINTS).map(|i| (i % 17) as f32).collect();
    let attributes = [
        WriteAttribute { name: "velocity", components: 3, values: Values::F32(&velocity) },
        WriteAttribute { name: "type", components: 1, values: Values::I32(&kinds) },
    ];
    for (name, format) in FORMATS {
        positions[7][1] = if name == "raw.vtu" { f64::NAN } else { 0.0 };
        let particles = WriteParticles { positions: &positions, attributes: &attributes, time: None };
        writer::write(&folder.join(name), &particles, format).expect("written");
    }
}

/// Bytes of the numbers in `frame`.
fn delivered(frame: &SetFrame) -> usize {
    let of = |set: &ParticleSet| {
        let ParticleFrame { positions, ids, attributes, sizes } = &set.particles;
        let values: usize = attributes.iter().map(|attribute| 4 * attribute.values.len()).sum();
        12 * positions.len() + 8 * ids.len() + values + 4 * sizes.len()
    };
    frame.sets.iter().map(of).sum()
}

/// What no number of points changes while a series is opened: the neighbourhoods of the particles sampled for the spacing.
const NEIGHBOURHOODS: usize = 11 << 20;

/// The blocks in work: what the destination does not excuse where little of the file is taken.
const BLOCKS: usize = 6 << 20;

#[test]
fn reading_takes_little_more_than_it_delivers() {
    // Each thread has its block; with very many, blocks would be what counts.
    rayon::ThreadPoolBuilder::new().num_threads(2).build_global().expect("the first pool");
    let folder = tempfile::tempdir().expect("a folder");
    write_all(folder.path());
    let cancel = Cancel::default();
    // The promise: 1.3 times the destination, which is three f32 for every point.
    let room = |destination: usize| destination * 13 / 10;
    let all = 12 * POINTS;
    for (name, _) in FORMATS {
        for io_mode in [IoMode::Map, IoMode::Read] {
            let path = folder.path().join(name);
            let check = |what: &str, peak: usize, bound: usize| {
                assert!(peak <= bound, "{name}, {io_mode:?}, {what}: {peak} bytes, at most {bound} expected");
            };
            let open = |where_expr: Option<&str>| {
                let where_expr = where_expr.map(str::to_owned);
                let options = SeriesOptions { io_mode, where_expr, ..Default::default() };
                peak_of(|| Series::open(&path, &options).expect("opens"))
            };
            let (peak, series) = open(None);
            check("to open", peak, room(all) + NEIGHBOURHOODS);

            let mut out = vec![0.0; 3 * POINTS];
            let (peak, ()) =
                peak_of(|| series.positions_into(0, out.as_mut_slice(), &cancel).expect("reads"));
            check("into the caller's memory", all + peak, room(all));
            drop(out);

            for attributes in [vec![], vec!["velocity".to_owned()]] {
                let request = FrameRequest { attributes };
                let (peak, frame) = peak_of(|| series.read(0, &request, &cancel).expect("reads"));
                assert_eq!(frame.len(), POINTS - usize::from(name == "raw.vtu"));
                check("to read", peak, room(delivered(&frame)));
            }

            let (peak, info) = peak_of(|| series.frame_info(0, true).expect("reads"));
            assert_eq!(info.points, POINTS);
            check("to describe", peak, BLOCKS);

            // A twentieth of the points: selecting them takes no column of all.
            let (_, series) = open(Some("type == 0 and z < 0.035 and velocity >= 0"));
            let (peak, frame) = peak_of(|| series.read(0, &FrameRequest::default(), &cancel).expect("reads"));
            assert_eq!(frame.len(), 83 * 83 * 3);
            check("to select", peak, room(delivered(&frame)) + BLOCKS);
        }
    }
}
