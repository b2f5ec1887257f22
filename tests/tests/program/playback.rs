//! `bench --play`: a series as viewers play it.

use std::fs::{self, OpenOptions};

use rustix::process::{Pid, Signal, kill_process};
use serde_json::Value;

use crate::program_with_dam;

const SMALL: &str = "--size 96x54 --warmup 1 --json";

fn number(json: &Value, key: &str) -> f64 {
    json[key].as_f64().unwrap_or_else(|| panic!("{key} is no number in {json}"))
}

/// The frames that were read, in order, and how often.
fn reads(json: &Value) -> Vec<(u64, u64)> {
    let frames = json["frames"].as_array().expect("frames");
    let read = |frame: &Value| Some((frame["frame"].as_u64()?, frame["reads"].as_u64()?));
    frames.iter().filter_map(read).filter(|(_, reads)| *reads > 0).collect()
}

#[test]
fn every_frame_is_shown_and_accounted_for() {
    let program = program_with_dam(2000, 5);
    let outcome = program.run(&format!("bench dam/dam_break.pvd --play --rounds 3 {SMALL}")).ok();
    assert!(outcome.stderr.contains("playing 15 pictures of 5 frames"), "{outcome:#?}");
    let json = outcome.json();
    let play = &json["play"];
    assert_eq!((&play["pictures"], &play["missing"]), (&15.into(), &0.into()));
    // Frames that were shown are kept: there is room for a thousand times as many.
    assert_eq!(reads(&json), [(0, 1), (1, 1), (2, 1), (3, 1), (4, 1)]);
    assert!(number(play, "stalls") <= 4.0, "{play}");
    for key in ["start_ms", "wall_ms", "cpu_ms", "cpu_apart_ms", "delivered_mb_per_s", "medium_mb_per_s"] {
        assert!(number(play, key) > 0.0, "{key}");
    }
    let memory = &json["memory"];
    assert_eq!(memory["peak_over_budget_bytes"], 0);
    assert!(number(memory, "peak_held_bytes") > 5.0 * 16.0 * 2000.0, "five frames of 16 bytes a particle");
    let frame = &json["frames"][4];
    assert!(number(frame, "file_bytes") > 12.0 * 2000.0 && number(frame, "mb_per_s") > 0.0, "{frame}");
    let text = program.run("bench dam --play --size 96x54 --warmup 0 --step -1 --frame 3").ok().stdout;
    for words in
        ["4 pictures of 5 frames", "stalls:", "delivered:", "the medium gives", "processor time", "MiB"]
    {
        assert!(text.contains(words), "{words} in\n{text}");
    }
}

#[test]
fn direction_and_step_decide_what_is_read() {
    let program = program_with_dam(200, 9);
    let frames = |flags: &str| {
        let json = program.run(&format!("bench dam --play {flags} {SMALL}")).ok().json();
        reads(&json).into_iter().map(|(frame, _)| frame).collect::<Vec<_>>()
    };
    assert_eq!(frames("--frame 4 --step -2"), [0, 2, 4]);
    assert_eq!(frames("--frame 1 --step 4"), [1, 5]);
    assert_eq!(
        frames("--frame 1 --step 4 --rounds 2"),
        [0, 1, 2, 3, 4, 5, 6, 7, 8],
        "four is no divisor of nine"
    );
    let refused = program.run("bench dam --play --step 0").expect(2);
    assert!(refused.stderr.contains("--step"), "{refused:#?}");
    let refused = program.run("bench dam --rounds 2").expect(2);
    assert!(refused.stderr.contains("--play"), "{refused:#?}");
}

#[test]
fn an_emulated_medium_gives_no_more_than_it_has() {
    let program = program_with_dam(2000, 4);
    let json = program.run(&format!("bench dam --play --medium 1.5 {SMALL}")).ok().json();
    let play = &json["play"];
    assert_eq!(play["medium"], "emulated");
    // Times are in whole nanoseconds.
    assert!((number(play, "medium_mb_per_s") - 1.5).abs() < 1e-6, "{play}");
    assert!(number(play, "delivered_mb_per_s") <= 1.5, "{play}");
    let four_frames_ms = 4.0 * 1e3 * number(&json["frames"][1], "file_bytes") / 1.5e6;
    assert!(number(play, "start_ms") + number(play, "wall_ms") >= four_frames_ms, "{play}");
}

#[test]
fn memory_for_frames_is_what_was_said() {
    let program = program_with_dam(20_000, 6);
    let played = |memory: &str| {
        program.run(&format!("bench dam --play --rounds 3 --memory {memory} {SMALL}")).ok().json()
    };
    // Not a frame fits: one is read at a time, and none is kept.
    let none = played("1B");
    assert_eq!(reads(&none)[1..], [1, 2, 3, 4, 5].map(|frame| (frame, 3)));
    assert!((3..=4).contains(&reads(&none)[0].1), "once more where the end is not yet known to be one");
    let frame = number(&none["memory"], "peak_held_bytes");
    // As decoded (20 bytes a particle) and as prepared (at least 16).
    assert!((36.0 * 20_000.0..100.0 * 20_000.0).contains(&frame), "{frame}");
    let all = played("0.5");
    assert_eq!(number(&all["play"], "frames_read"), 6.0);
    // Room for some.
    let budget = 3.0 * frame;
    let some = played(&format!("{budget}B"));
    let memory = &some["memory"];
    assert_eq!(number(memory, "budget_bytes"), budget.floor());
    assert_eq!(memory["peak_over_budget_bytes"], 0);
    let peak = number(memory, "peak_held_bytes");
    assert!(peak > frame && peak <= budget, "{peak} of {budget}");
    let read = number(&some["play"], "frames_read");
    // No more than each frame every round, and what fits into memory of a fourth, which readers do not know will not come.
    assert!((6.0..=18.0 + 6.0).contains(&read), "{read} reads");
}

/// What the program asks for beyond the limit it does not get, which would be its end: it must see the limit coming. Less
/// than half of the frames would fit into it. Frames have to be this large for their arrays to be mapped on their own: smaller ones
/// come from heaps that keep what was freed, by which the program was seen to come within a megabyte of the limit.
#[test]
fn a_limit_of_the_process_is_kept() {
    let program = program_with_dam(200_000, 16);
    let play = format!("bench dam --play --rounds 2 --io read {SMALL}");
    let least = program.run(&format!("{play} --memory 1B")).ok();
    let frame = number(&least.json()["memory"], "peak_held_bytes");
    let room = (8.0 * frame) as u64;
    let outcome = program.run_within(least.peak_data_bytes + room, &play).ok();
    let json = outcome.json();
    assert_eq!((&json["play"]["pictures"], &json["play"]["missing"]), (&32.into(), &0.into()));
    let memory = &json["memory"];
    assert!(number(memory, "budget_bytes") <= room as f64, "{memory}");
    assert!(number(memory, "peak_held_bytes") > 2.0 * frame, "what there is, is used: {memory}");
    assert_eq!(memory["peak_over_budget_bytes"], 0);
}

#[test]
fn frames_stay_on_the_gpu_within_its_budget() {
    let program = program_with_dam(20_000, 5);
    let played = |memory: &str| {
        let json =
            program.run(&format!("bench dam --play --rounds 3 --gpu-memory {memory} {SMALL}")).ok().json();
        let [uploads, ahead, found] =
            ["uploads", "uploads_ahead", "found_on_gpu"].map(|key| number(&json["play"], key));
        assert_eq!(uploads + found, 15.0, "one set of particles is drawn in every picture");
        let [budget, peak] =
            ["gpu_budget_bytes", "gpu_peak_particle_bytes"].map(|key| number(&json["memory"], key));
        (uploads + ahead, peak, budget)
    };
    let (uploads, of_one, _) = played("0B");
    assert_eq!(uploads, 15.0, "there is room for what is drawn only");
    let (uploads, peak, budget) = played("100MB");
    assert_eq!(uploads, 5.0, "every frame once");
    assert!(peak > 4.0 * of_one && peak <= budget, "{peak} of {budget}");
    let (uploads, peak, budget) = played(&format!("{}B", 3.5 * of_one));
    assert!(peak > 2.0 * of_one && peak <= budget, "{peak} of {budget}");
    // How many are found, and how many are uploaded ahead too late, depends on when the other thread gets to run: at most one for
    // every picture but the first. What is given up first is tested in `lod`.
    assert!((5.0..=29.0).contains(&uploads), "{uploads}");
    let refused = program.run("bench dam --play --gpu-memory 0.5").expect(2);
    assert!(refused.stderr.contains("bytes like"), "{refused:#?}");
}

/// Rounds enough for whatever is not given back to add up. The least that playing takes, with memory for no frame at all,
/// is everything but the frames that are read ahead.
#[test]
fn memory_of_a_long_run_stays_within_its_budget() {
    let program = program_with_dam(200_000, 8);
    // On a GPU with memory of its own, what the driver copies uploads through is not in the budget.
    // Nor what finding ellipsoids takes for a moment, which is more than a frame of so few particles.
    let spheres = "--param anisotropy.form=none";
    let play = format!("bench dam --play --rounds 5 --io read --gpu-memory 0B {spheres} {SMALL}");
    let least = program.run(&format!("{play} --memory 1B")).ok();
    let frame = number(&least.json()["memory"], "peak_held_bytes");
    let budget = 3.0 * frame;
    let most = program.run(&format!("{play} --memory {budget}B")).ok();
    let json = most.json();
    assert_eq!((&json["play"]["pictures"], &json["play"]["missing"]), (&40.into(), &0.into()));
    assert!(number(&json["play"], "frames_read") > 20.0, "eight frames do not fit: {}", json["play"]);
    // The kernel's own high-water marks of the memory in RAM.
    let ahead = most.peak_bytes as f64 - least.peak_bytes as f64;
    // In the least, too, a frame is read.
    assert!(ahead <= 1.05 * budget - frame, "{ahead} bytes for frames ahead, the budget is {budget}");
    assert!(ahead > 0.3 * budget, "what may be taken is used: {ahead} of {budget}");
}

/// Who takes more than a container has is killed.
#[test]
#[expect(clippy::print_stderr, reason = "a skipped test must not look like a passed one")]
fn a_limit_of_the_container_is_kept() {
    let program = program_with_dam(200_000, 12);
    let play = format!("bench dam --play --rounds 3 --io read {SMALL}");
    let least = program.run(&format!("{play} --memory 1B")).ok();
    let frame = number(&least.json()["memory"], "peak_held_bytes");
    // All twelve would take more. What is mapped from files does not count: the system takes it back.
    let room = 6.0 * frame;
    let needed = number(&least.json()["memory"], "resident_peak_bytes");
    let Some(outcome) = program.run_in_group((needed + room) as u64, &play) else {
        eprintln!("SKIPPED: this process may not make control groups that limit memory");
        return;
    };
    let json = outcome.ok().json();
    assert_eq!((&json["play"]["pictures"], &json["play"]["missing"]), (&36.into(), &0.into()));
    let memory = &json["memory"];
    assert!(number(memory, "peak_held_bytes") <= room, "{memory}");
    assert!(number(memory, "peak_held_bytes") > 1.5 * frame, "what there is, is used: {memory}");
}

#[test]
fn files_that_vanish_shrink_and_change_while_they_are_played() {
    let program = program_with_dam(2000, 6);
    let path = |frame: usize| program.path(&format!("dam/dam_break_{frame:04}.vtu"));
    let play = "bench dam --play --rounds 1000000 --memory 1B --size 32x18 --warmup 0 --json";
    let mut running = program.start(play, &[]);
    running.wait_for_words("playing");
    fs::remove_file(path(1)).expect("removed");
    OpenOptions::new().write(true).open(path(2)).and_then(|file| file.set_len(9000)).expect("shortened");
    fs::write(path(3), "no particles any more").expect("written");
    fs::write(program.path("other"), fs::read(path(5)).expect("a file")).expect("written");
    fs::rename(program.path("other"), path(4)).expect("replaced");
    for frame in 1..4 {
        running.wait_for_words(&format!("frame {frame} is missing"));
    }
    kill_process(Pid::from_raw(running.id() as i32).expect("a process"), Signal::INT).expect("a signal");
    let outcome = running.finish().ok();
    let json = outcome.json();
    for frame in 1..4 {
        let error = json["frames"][frame]["error"].as_str().expect("an error");
        assert!(error.contains(&format!("dam_break_000{frame}.vtu")), "{error}");
    }
    for frame in [0, 4, 5] {
        assert!(json["frames"][frame]["error"].is_null(), "{json}");
    }
    assert!(number(&json["play"], "missing") >= 3.0 && number(&json["play"], "pictures") >= 1.0);
    let flaws = json["flaws"].as_array().expect("flaws");
    assert!(flaws.iter().filter(|flaw| flaw["kind"] == "frame_missing").count() >= 3, "{flaws:?}");
}

#[test]
fn frames_that_a_solver_adds_are_played() {
    let program = program_with_dam(200, 8);
    for frame in 3..8 {
        let name = |folder: &str| program.path(&format!("{folder}/dam_break_{frame:04}.vtu"));
        program.write("later/.keep", "");
        fs::rename(name("dam"), name("later")).expect("moved");
    }
    fs::remove_file(program.path("dam/dam_break.pvd")).expect("removed");
    let mut running = program.start("bench dam --play --follow --fps 1 --size 32x18 --warmup 0 --json", &[]);
    running.wait_for_words("playing 3 pictures of 3 frames");
    for frame in 3..8 {
        let name = |folder: &str| program.path(&format!("{folder}/dam_break_{frame:04}.vtu"));
        fs::rename(name("later"), name("dam")).expect("moved");
    }
    let json = running.finish().ok().json();
    assert_eq!((&json["play"]["pictures"], &json["play"]["frames_added"]), (&8.into(), &5.into()));
}

#[test]
fn jumps_end_with_whole_frames() {
    let program = program_with_dam(40_000, 5);
    let jumps = |memory: &str| {
        let flags = format!("--jumps 12 --memory {memory} --medium 20");
        let json = program.run(&format!("bench dam --play {flags} {SMALL}")).ok().json();
        (json["jumps"].clone(), json["play"]["pictures"].clone())
    };
    let (few, pictures) = jumps("1B");
    assert_eq!((&few["jumps"], &few["failed"], pictures), (&12.into(), &0.into(), 0.into()));
    // 40,000 particles are ten runs, of which a first impression takes two.
    let impressions = |jumps: &Value| jumps["first_impression_ms"].clone();
    assert!(number(&impressions(&few), "min") < number(&few["whole_ms"], "max"), "{few}");
    // Five frames, twelve jumps.
    let (all, _) = jumps("0.5");
    assert!(number(&all, "at_hand") >= 1.0, "{all}");
}
