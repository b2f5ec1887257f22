//! Work counters: exact numbers that show a lost culling, a second upload or a filter on empty pixels without a clock.

use meniscus_tests::read_json;
use serde_json::Value;

use crate::{Program, program_with_dam};

fn counters(program: &Program, flags: &str) -> Vec<Value> {
    program.run(&format!("render dam -o o_%d.png --size 160x90 --report r.json {flags}")).ok();
    let report = read_json(&program.path("r.json"));
    let frames = report["frames"].as_array().expect("frames");
    frames.iter().map(|frame| frame["counters"].clone()).collect()
}

fn number(counters: &Value, name: &str) -> u64 {
    counters[name].as_u64().unwrap_or_else(|| panic!("{name} in {counters}"))
}

#[test]
fn the_same_run_counts_the_same() {
    let program = program_with_dam(20_000, 1);
    assert_eq!(counters(&program, "--frame 0"), counters(&program, "--frame 0 --threads 1"));
}

/// Two frames with the same particles are told apart by their data, so each is uploaded, but no second time: 16 bytes each.
#[test]
fn every_frame_uploads_its_particles_once() {
    let program = program_with_dam(20_000, 3);
    let frames = counters(&program, "");
    for frame in &frames {
        assert_eq!(number(frame, "particle_bytes_uploaded"), 16 * 20_000);
    }
    // Frames of one size share all images and buffers; nothing is left to allocate but what the first one made.
    assert!(number(&frames[0], "gpu_allocations") > 10);
    let live: Vec<u64> = frames[1..].iter().map(|frame| number(frame, "gpu_bytes_live")).collect();
    assert_eq!(live[0], live[1], "nothing leaks");
    assert_eq!(number(&frames[2], "gpu_allocations"), 0, "the steady state");
}

/// The positions are three doubles, the ids at most eight bytes; velocity, density and pressure, more than as much again,
/// were not asked for.
#[test]
fn only_what_is_asked_for_is_read() {
    let program = program_with_dam(20_000, 1);
    let frame = &counters(&program, "--frame 0")[0];
    assert_eq!(number(frame, "particles_read"), 20_000);
    let per_particle = number(frame, "file_bytes_read") as f64 / 20_000.0;
    assert!((12.0..=32.0).contains(&per_particle), "{per_particle} bytes");
}

#[test]
fn a_narrow_view_culls_chunks() {
    let program = program_with_dam(40_000, 1);
    let whole = &counters(&program, "--frame 0")[0];
    let part = &counters(&program, "--frame 0 --camera 0.1,-0.5,0.3/0.1,0,0.3/0,0,1/10")[0];
    assert_eq!(number(whole, "chunks_culled"), 0, "the automatic camera sees everything");
    assert_eq!(number(whole, "chunks"), number(part, "chunks"));
    assert!(number(part, "chunks_culled") > 0 && number(part, "particles_kept") < 40_000, "{part}");
}

/// Every pixel that the filter smooths reads at most its window, and no pixel outside of the water is smoothed.
#[test]
fn the_filter_reads_its_window_of_the_water_only() {
    let program = program_with_dam(20_000, 1);
    for iterations in [1, 2] {
        let frame = &counters(&program, &format!("--frame 0 --param filter.iterations={iterations}"))[0];
        let taps = number(frame, "filter_taps");
        let covered = number(frame, "covered_pixels");
        assert!(covered > 1000, "a picture with water");
        // Per row or column at most 24 taps to each side and two for the slope; 24 in the clean-up.
        assert!(taps <= covered * (2 * iterations * (2 * 24 + 2) + 24), "{taps} taps, {covered} pixels");
        assert!(taps > 0);
    }
    let none = &counters(&program, "--frame 0 --filter none")[0];
    assert!(none["filter_taps"].is_null(), "what was not measured is absent, not zero");
}

/// A parallel view of spheres of one radius: a splat's rectangle is the square of its diameter in pixels.
#[test]
fn splats_visit_the_pixels_of_their_squares() {
    let program = program_with_dam(2000, 1);
    // World units per pixel of the 90 pixel rows: half as high a picture has splats of four times the area.
    let visited = |height: f64| {
        let flags =
            format!("--frame 0 --view front --ortho {height} --radius 0.05 --param anisotropy.form=none");
        let frame = &counters(&program, &flags)[0];
        assert_eq!(number(frame, "particles_kept"), 2000, "none is outside");
        let diameter_px = 2.0 * 0.05 * 90.0 / height;
        number(frame, "splat_pixels_depth") as f64 / 2000.0 / (diameter_px * diameter_px)
    };
    for height in [3.0, 6.0] {
        // The mean number of pixel centres in a rectangle is its area. What lies behind the walls is visited as well; splats
        // that cross the border of the picture are cut.
        let ratio = visited(height);
        assert!((0.9..1.1).contains(&ratio), "{ratio} of the squares at height {height}");
    }
}
