//! Layers of OpenEXR files.

use std::collections::BTreeMap;
use std::path::Path;

use exr::prelude::{FlatSamples, ReadChannels, ReadLayers, read};

use crate::program_with_dam;

/// All channels of the file by name.
fn channels(path: &Path) -> BTreeMap<String, Vec<f32>> {
    let image =
        read().no_deep_data().largest_resolution_level().all_channels().first_valid_layer().all_attributes();
    let image = image.from_file(path).expect("an OpenEXR file");
    let values = |samples: &FlatSamples| samples.values_as_f32().collect();
    image.layer_data.channel_data.list.iter().map(|c| (c.name.to_string(), values(&c.sample_data))).collect()
}

#[test]
fn layers_fit_each_other_and_the_picture() {
    let program = program_with_dam(20_000, 2);
    let view = "render dam/dam_break.pvd --frame 1 --size 160x90 --lod 0.5 -o p.exr";
    program.run(&format!("{view} --layers depth,normal,thickness,kept,fluid,scene")).ok();
    let all = channels(&program.path("p.exr"));
    let names: Vec<&str> = all.keys().map(String::as_str).collect();
    assert_eq!(names.len(), 3 + 1 + 3 + 1 + 1 + 4 + 3, "{names:?}");
    let of = |name: &str| all[name].as_slice();
    let (mut water, mut floor) = (0, 0);
    for i in 0..160 * 90 {
        let normal = ["normal.X", "normal.Y", "normal.Z"].map(|name| of(name)[i]);
        let length = normal.iter().map(|c| c * c).sum::<f32>().sqrt();
        let (thickness, kept, depth) = (of("thickness.Z")[i], of("kept.Z")[i], of("depth.Z")[i]);
        assert!(all.values().all(|channel| channel[i].is_finite()));
        if of("fluid.A")[i] == 1.0 {
            water += 1;
            assert!((length - 1.0).abs() < 1e-3 && thickness > 0.0 && kept > 0.0 && kept <= 1.0);
            // The water's colour is the picture's; half floats have eleven bits.
            for c in ["R", "G", "B"] {
                let (whole, fluid) = (of(c)[i], of(&format!("fluid.{c}"))[i]);
                assert!((whole - fluid).abs() <= 1e-3 * fluid + 1e-6, "{whole} {fluid}");
            }
        } else {
            assert_eq!((length, thickness, kept, of("fluid.R")[i]), (0.0, 0.0, 0.0, 0.0));
            floor += usize::from(depth < 1e9);
        }
    }
    assert!(water > 1000 && floor > 1000, "{water} {floor}");
    // Looking down at the floor, upper rows are farther away.
    let row = |y: usize| of("depth.Z")[y * 160 + 2];
    assert!(row(10) > row(80) && row(80) > 0.0);
    // Nothing of this without being asked for, and the picture is the same.
    program.run(view).ok();
    let plain = channels(&program.path("p.exr"));
    assert_eq!(plain.keys().map(String::as_str).collect::<Vec<_>>(), ["B", "G", "R"]);
    assert!(["B", "G", "R"].iter().all(|c| plain[*c] == all[*c]));
}

#[test]
fn layers_that_cannot_be_are_refused() {
    let program = program_with_dam(300, 2);
    for (flags, code, words) in [
        ("-o p.png --layers depth", 5, "only .exr has layers"),
        ("-o p.exr --layers depth,height", 2, "there is no layer `height`"),
        ("-o p.exr --layers depth --samples 4", 5, "a single picture"),
    ] {
        let outcome = program.run(&format!("render dam --frame 0 --size 64x36 {flags}")).expect(code);
        assert!(outcome.stderr.contains(words), "{flags}: {outcome:#?}");
    }
}
