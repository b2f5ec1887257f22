//! `info --json`: the numbers of the file, whatever its format.

use meniscus_cases::{Case, CaseOptions};
use serde_json::{Value, json};

use crate::{program, program_with_dam};

fn numbers(value: &Value) -> Vec<f64> {
    value.as_array().into_iter().flatten().filter_map(Value::as_f64).collect()
}

#[test]
fn every_made_format_comes_back_number_by_number() {
    let options = CaseOptions { particles: 3000, frames: 3, seed: 7 };
    let expected = Case::FjordTsunami.frame(&options, 1);
    for format in ["vtu-raw", "vtu-zlib", "vtk-binary"] {
        let program = program();
        let make = "make fjord-tsunami -o fjord --particles 3000 --frames 3 --seed 7 --format";
        program.run(&format!("{make} {format}")).ok();
        let json = program.run("info fjord/fjord_tsunami.pvd --frame 1 --stats --json").ok().json();

        assert_eq!(json["frames"], 3, "{format}");
        assert_eq!(json["times"], json!([0.0, 100.0, 200.0]), "{format}");
        let frame = &json["frame"];
        assert_eq!(frame["index"], 1);
        let file = frame["file"].as_str().expect("a file");
        assert!(file.contains("fjord_tsunami_0001.vt"), "{file}");
        assert_eq!(frame["points"], 3000);
        assert_eq!(frame["finite_points"], 3000);
        assert_eq!(frame["dropped"], 0);
        let point_type = frame["point_type"].as_str().expect("a type");
        assert!(["Float64", "double"].contains(&point_type), "{point_type}");
        assert_eq!(frame["sets"], json!([{ "name": "water", "look": "water", "points": 3000 }]));
        assert_eq!(frame["up"], "z");

        // Double precision all the way: not one bit may be lost.
        let column = |axis: usize| expected.positions.iter().map(move |p| p[axis]);
        let bounds: Vec<f64> = (0..3)
            .flat_map(|axis| [column(axis).fold(f64::MAX, f64::min), column(axis).fold(f64::MIN, f64::max)])
            .collect();
        assert_eq!(numbers(&frame["bounds"]), bounds, "{format}");
        for (axis, mean) in numbers(&frame["centroid"]).into_iter().enumerate() {
            let exact = column(axis).sum::<f64>() / 3000.0;
            // A sum of 3000 doubles, relative to its size: 3000 roundings of 1e-16 each.
            assert!((mean - exact).abs() <= 1e-12 * exact.abs(), "{format}: {mean} {exact}");
        }

        let attributes: Vec<(&str, u64, &str)> = frame["attributes"]
            .as_array()
            .expect("attributes")
            .iter()
            .map(|a| {
                let text = |key: &str| a[key].as_str().expect("a text");
                (text("name"), a["components"].as_u64().expect("a number"), text("type"))
            })
            .collect();
        let wanted = [
            ("velocity", 3, "Float32"),
            ("density", 1, "Float32"),
            ("pressure", 1, "Float32"),
            ("id", 1, "Int64"),
        ];
        assert_eq!(attributes, wanted, "{format}");
        let largest = expected.pressure.iter().copied().fold(f32::MIN, f32::max);
        assert_eq!(numbers(&frame["attributes"][2]["max"]), [f64::from(largest)], "{format}");
        assert_eq!(numbers(&frame["attributes"][3]["max"]).len(), 1);
        assert_eq!(numbers(&frame["attributes"][0]["min"]).len(), 3);
    }
}

#[test]
fn spacing_radius_and_origin_are_stated_with_their_source() {
    let program = program_with_dam(8000, 1);
    let info = |flags: &str| {
        program.run(&format!("info dam/dam_break.pvd --json {flags}")).ok().json()["frame"].clone()
    };
    let (found, given) = (info(""), info("--spacing 0.05 --radius 0.04"));
    let options = CaseOptions { particles: 8000, frames: 1, seed: 1 };
    let spacing = found["spacing"].as_f64().expect("a number");
    // The jitter of the made lattice moves the estimate by a percent or two.
    assert!((spacing / Case::DamBreak.spacing(&options) - 1.0).abs() < 0.05, "{spacing}");
    assert_eq!(found["spacing_source"], "estimate");
    assert_eq!(found["radius"].as_f64(), Some(0.625 * spacing));
    assert_eq!(given["spacing_source"], "user");
    assert_eq!([&given["spacing"], &given["radius"]], [&json!(0.05), &json!(0.04)]);
    // The origin is near the particles, so that what is left fits 32 bits.
    let bounds = numbers(&found["bounds"]);
    for (axis, origin) in numbers(&found["origin"]).into_iter().enumerate() {
        assert!(bounds[2 * axis] <= origin && origin <= bounds[2 * axis + 1], "{axis}: {origin}");
    }
}

/// The numbers are those of the whole file; a selection changes what is drawn, not what is there.
#[test]
fn a_selection_changes_the_sets_and_nothing_else() {
    let program = program_with_dam(2000, 1);
    let info = |flags: &str| program.run(&format!("info dam --json {flags}")).ok().json()["frame"].clone();
    let (all, half) = (info("--spacing 0.07"), info("--spacing 0.07 --where 'id < 1000'"));
    assert_eq!(half["sets"][0]["points"], 1000);
    for key in ["points", "finite_points", "bounds", "centroid"] {
        assert_eq!(all[key], half[key], "{key}");
    }
}

#[test]
fn the_text_says_what_the_json_says() {
    let program = program_with_dam(2000, 3);
    let text = program.run("info dam/dam_break.pvd").ok().stdout;
    for part in ["3 frames, time 0 to 2", "points          2000", "velocity", "Int64", "water"] {
        assert!(text.contains(part), "{part} in\n{text}");
    }
}
