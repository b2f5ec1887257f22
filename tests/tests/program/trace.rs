//! `--trace`: a time line that holds only what happened.

use std::collections::BTreeMap;

use meniscus_tests::read_json;
use serde_json::Value;

use crate::program_with_dam;

/// A microsecond is the unit; a thousandth of it is what doubles leave of an hour.
const ROUNDING_US: f64 = 1e-3;

fn number(event: &Value, key: &str) -> f64 {
    event[key].as_f64().unwrap_or_else(|| panic!("{key} in {event}"))
}

/// Spans by row, with the row's name.
fn rows(trace: &Value) -> BTreeMap<String, Vec<&Value>> {
    let events = trace["traceEvents"].as_array().expect("events");
    let of_kind = |kind: &'static str| events.iter().filter(move |event| event["ph"] == kind);
    let mut rows: BTreeMap<String, Vec<&Value>> = BTreeMap::new();
    for span in of_kind("X") {
        let name = of_kind("M").find(|m| m["name"] == "thread_name" && m["tid"] == span["tid"]);
        let name = name.and_then(|m| m["args"]["name"].as_str()).expect("a named row");
        rows.entry(name.to_owned()).or_default().push(span);
    }
    rows
}

#[test]
fn spans_of_a_row_follow_each_other_and_lie_in_their_frame() {
    let program = program_with_dam(2000, 4);
    program.run("render dam -o o_%d.png --size 64x36 --threads 2 --trace new/t.json --report r.json").ok();
    let trace = read_json(&program.path("new/t.json"));
    assert_eq!(trace["displayTimeUnit"], "ms");
    let rows = rows(&trace);
    for (name, spans) in &rows {
        for pair in spans.windows(2) {
            let end = number(pair[0], "ts") + number(pair[0], "dur");
            assert!(
                number(pair[0], "dur") >= 0.0 && end <= number(pair[1], "ts") + ROUNDING_US,
                "{name}: {pair:?}"
            );
        }
    }
    let frames = &rows["frames"];
    assert_eq!(
        frames.iter().map(|f| f["args"]["frame"].as_u64()).collect::<Vec<_>>(),
        [0, 1, 2, 3].map(Some)
    );
    for part in &rows["drawing"] {
        let frame = frames.iter().find(|f| f["args"]["frame"] == part["args"]["frame"]).expect("its frame");
        let (from, to) = (number(frame, "ts"), number(frame, "ts") + number(frame, "dur"));
        let end = number(part, "ts") + number(part, "dur");
        assert!(number(part, "ts") >= from - ROUNDING_US && end <= to + ROUNDING_US, "{part} in {frame}");
    }
    for name in ["draw", "encode and write"] {
        assert_eq!(rows["drawing"].iter().filter(|span| span["name"] == name).count(), 4, "{name}");
    }
    // Every frame was read once, then prepared, by a reading thread; and it was there before it was drawn.
    let reading: Vec<&&Value> = rows
        .iter()
        .filter(|(name, _)| name.starts_with("meniscus-read"))
        .flat_map(|(_, spans)| spans)
        .collect();
    for index in 0..4 {
        let of = |name: &str| {
            let mut spans = reading.iter().filter(|s| s["name"] == name && s["args"]["frame"] == index);
            let span = spans.next().unwrap_or_else(|| panic!("{name} of frame {index}"));
            assert!(spans.next().is_none(), "{name} of frame {index} twice");
            (number(span, "ts"), number(span, "ts") + number(span, "dur"))
        };
        let (read, prepare) = (of("read"), of("prepare"));
        assert!(read.1 <= prepare.0 + ROUNDING_US, "read before it is prepared");
        let draw = rows["drawing"].iter().find(|s| s["name"] == "draw" && s["args"]["frame"] == index);
        assert!(
            prepare.1 <= number(draw.expect("a picture"), "ts") + ROUNDING_US,
            "prepared before it is drawn"
        );
    }
    // Passes have a cost and no place: the same as in the report.
    let report = read_json(&program.path("r.json"));
    let draw = rows["drawing"].iter().find(|s| s["name"] == "draw").expect("a picture");
    assert_eq!(draw["args"]["stages"], report["frames"][0]["stages"]);
    let events = trace["traceEvents"].as_array().expect("events");
    let counts: Vec<_> = events.iter().filter(|e| e["ph"] == "C" && e["name"] == "frame bytes").collect();
    // Positions alone are three floats each.
    assert!(counts.len() == 4 && counts.iter().all(|c| c["args"]["value"].as_u64() >= Some(2000 * 12)));
}

#[test]
fn a_frame_that_cannot_be_read_is_in_the_trace_and_a_folder_is_no_file() {
    let program = program_with_dam(500, 3);
    program.write("dam/dam_break_0001.vtu", "broken");
    let _ = program.run("render dam/dam_break.pvd -o o_%d.png --size 16x9 --trace t.json").expect(3);
    let trace = read_json(&program.path("t.json")).to_string();
    assert!(trace.contains("\"error\":"), "{trace}");
    let refused = program.run("render dam/dam_break.pvd -o o_%d.png --trace dam").expect(2).stderr;
    assert!(refused.contains("--trace dam"), "{refused}");
}

/// Every picture of a bench with its steps; passes where they were run one by one, with the names of the report; time stamps
/// only where they are believed; what the counted picture did.
#[test]
fn a_bench_shows_its_pictures_steps_and_passes() {
    let program = program_with_dam(2000, 1);
    let run = program.run("bench dam --size 64x36 --frames 2 --warmup 1 --json --trace t.json").ok();
    let (report, trace) = (run.json(), read_json(&program.path("t.json")));
    let rows = rows(&trace);
    for (name, spans) in &rows {
        for pair in spans.windows(2) {
            let end = number(pair[0], "ts") + number(pair[0], "dur");
            assert!(end <= number(pair[1], "ts") + ROUNDING_US, "{name}: {pair:?}");
        }
    }
    let pictures = &rows["frames"];
    let called = |name: &str| pictures.iter().filter(|p| p["name"] == name).count();
    assert_eq!((called("picture"), called("picture, counted")), (2, 1));
    assert!(called("warm-up picture") >= 1 && called("picture, pass by pass") > 1);
    let steps = &rows["steps of drawing"];
    let steps_of_all =
        ["upload particles", "select", "upload what is drawn", "record", "submit", "wait for the GPU"];
    for name in steps_of_all {
        assert_eq!(steps.iter().filter(|s| s["name"] == name).count(), pictures.len(), "{name}");
    }
    let isolated = rows.iter().find(|(name, _)| name.starts_with("passes run one by one")).expect("passes").1;
    let inside = |part: &Value, whole: &Value| {
        let end = |span: &Value| number(span, "ts") + number(span, "dur");
        number(part, "ts") >= number(whole, "ts") - ROUNDING_US && end(part) <= end(whole) + ROUNDING_US
    };
    for part in steps.iter().chain(isolated) {
        assert_eq!(pictures.iter().filter(|picture| inside(part, picture)).count(), 1, "{part}");
    }
    let stages: std::collections::BTreeSet<_> =
        report["stages"].as_array().expect("stages").iter().map(|stage| stage["name"].as_str()).collect();
    assert_eq!(
        isolated.iter().map(|pass| pass["name"].as_str()).collect::<std::collections::BTreeSet<_>>(),
        stages
    );
    let believed = report["device"]["time_stamps_believed"].as_bool().expect("a device");
    assert_eq!(rows.keys().any(|name| name.contains("time stamps")), believed);
    let events = trace["traceEvents"].as_array().expect("events");
    for (name, value) in report["counters"].as_object().expect("counters") {
        let event = events.iter().find(|e| e["ph"] == "C" && e["name"] == name.as_str());
        assert_eq!(event.map(|e| &e["args"]["value"]), Some(value), "{name}");
    }
    let _ = program.run("bench dam --size 64x36 --frames 1 --warmup 0 --trace dam").expect(5);
}

/// With memory for no frame at all, one is read at a time.
#[test]
fn memory_decides_how_many_frames_are_read_at_once() {
    let program = program_with_dam(20_000, 4);
    let picture = |name: &str, frame: u32| {
        std::fs::read(program.path(&format!("{name}_{frame}.png"))).expect("a picture")
    };
    let reads_at_once = |memory: &str, name: &str| {
        let flags = format!("--size 64x36 --threads 2 --memory {memory} --trace t.json");
        program.run(&format!("render dam -o {name}_%d.png {flags}")).ok();
        let trace = read_json(&program.path("t.json"));
        let rows = rows(&trace);
        let reading = |number: u32| {
            rows.get(&format!("meniscus-read-{number}"))
                .into_iter()
                .flatten()
                .filter(|span| span["name"] == "read")
        };
        let ends = |span: &Value| (number(span, "ts"), number(span, "ts") + number(span, "dur"));
        let overlap =
            |a: &Value, b: &Value| ends(a).0 < ends(b).1 - ROUNDING_US && ends(b).0 < ends(a).1 - ROUNDING_US;
        reading(0).any(|a| reading(1).any(|b| overlap(a, b)))
    };
    assert!(!reads_at_once("1B", "least"), "two frames were read at once");
    reads_at_once("0.5", "most");
    assert!((0..4).all(|frame| picture("least", frame) == picture("most", frame)));
    let refused = program.run("render dam -o x.png --memory 2").expect(2);
    assert!(refused.stderr.contains("a share above 0 and at most 1"), "{refused:#?}");
}
