//! What `bench --play` found, for people.

use super::super::spread::Spread;
use super::report::PlayReport;
use crate::terminal::print;

/// Prints `report`.
pub fn print_table(report: &PlayReport) {
    let (apart, play, memory) = (&report.apart, &report.play, &report.memory);
    print(format_args!("{} ({})", report.adapter, report.driver));
    print(format_args!(
        "{}x{}, {} pictures of {} frames, {} read at once",
        report.size[0],
        report.size[1],
        play.pictures,
        report.frames.len(),
        report.readers
    ));
    print(format_args!("{:28} {:>9} {:>9}   {:17}", "ms, median", "wall", "cpu", "wall min-max"));
    let row = |name: &str, wall: Option<Spread>, cpu: Option<Spread>| {
        let range = wall.map_or_else(String::new, |s| format!("{:.2}-{:.2}", s.min, s.max));
        let line = format!("{name:28} {:>9} {:>9}   {range:17}", cell(wall), cell(cpu));
        print(line.trim_end());
    };
    row("reading, apart", apart.read_ms, apart.read_cpu_ms);
    row("drawing, apart", apart.draw_ms, apart.draw_cpu_ms);
    row("drawing, while reading", play.draw_ms, None);
    row("picture to picture", play.picture_ms, None);
    if let Some(jumps) = &report.jumps {
        row("jump to first impression", jumps.first_impression_ms, None);
        row("jump to whole frame", jumps.whole_ms, None);
        let (jumped, at_hand, failed) = (jumps.jumps, jumps.at_hand, jumps.failed);
        print(format_args!("jumps: {jumped}; {at_hand} to frames in memory, {failed} to frames that failed"));
    }
    print(format_args!(
        "processor time: {:.0} ms; {:.0} ms for the same reading and drawing apart ({:+.1} %)",
        play.cpu_ms,
        play.cpu_apart_ms,
        100.0 * (play.cpu_ms / play.cpu_apart_ms - 1.0)
    ));
    print(format_args!(
        "start: {:.0} ms; stalls: {} ({:.1} % of the pictures), {:.0} ms of {:.0} ms",
        play.start_ms,
        play.stalls,
        100.0 * play.stall_share,
        play.stalled_ms,
        play.wall_ms
    ));
    let rate = |rate: Option<f64>| rate.map_or_else(|| "-".to_owned(), |rate| format!("{rate:.1} MB/s"));
    print(format_args!(
        "delivered: {}; the medium gives {} ({})",
        rate(play.delivered_mb_per_s),
        rate(play.medium_mb_per_s),
        play.medium
    ));
    let mib = |bytes: u64| bytes as f64 / f64::from(1 << 20);
    print(format_args!(
        "memory of frames: {:.0} MiB at most, ready ones {:.0} MiB above the budget at most; the budget is {:.0} MiB",
        mib(memory.peak_held_bytes),
        mib(memory.peak_over_budget_bytes),
        mib(memory.budget_bytes)
    ));
    if let (Some(before), Some(peak)) = (memory.resident_before_bytes, memory.resident_peak_bytes) {
        print(format_args!(
            "memory of the process: {:.0} MiB before, {:.0} MiB at most",
            mib(before),
            mib(peak)
        ));
    }
    print(format_args!(
        "on the GPU: {} sets uploaded ahead, {} when drawn, {} found there; particles {:.0} MiB at most, the budget is {:.0} MiB",
        play.uploads_ahead,
        play.uploads,
        play.found_on_gpu,
        mib(memory.gpu_peak_particle_bytes),
        mib(memory.gpu_budget_bytes)
    ));
    print(format_args!(
        "reads: {} frames, {} cancelled, {} failed; {} frames changed, {} added",
        play.frames_read, play.reads_cancelled, play.reads_failed, play.frames_changed, play.frames_added
    ));
    for frame in &report.frames {
        if let Some(error) = &frame.error {
            print(format_args!("frame {} failed: {error}", frame.frame));
        }
    }
}

fn cell(spread: Option<Spread>) -> String {
    spread.map_or_else(|| "-".to_owned(), |s| format!("{:.2}", s.median))
}
