//! What is found out about real series instead of asked.

mod common;

use std::path::Path;

use common::data_dir;
use meniscus_core::{Cancel, Flaw, FrameRequest, FrameSource, Look, RadiusChoice, SpacingSource, UpAxis};
use meniscus_io::{IoMode, Series, SeriesOptions, SetSpec};

fn open(path: &Path) -> Series {
    Series::open(path, &SeriesOptions::default()).unwrap_or_else(|e| panic!("{e}"))
}

#[test]
fn spacing_and_up_axis_of_known_series() {
    let Some(dir) = data_dir() else { return };
    // Spacings as the data's README and the solvers' inputs give them.
    for (name, spacing, up) in [
        ("sphere_entry/fluid.pvd", 0.0036, UpAxis::Y),
        ("sphere_entry/fluid_0000.vtu", 0.0036, UpAxis::Y),
        ("sphere_entry/fluid_0019.vtu", 0.0036, UpAxis::Y),
        ("sphere_entry/solver_writer/ParticleData_Fluid_15.vtk", 0.0036, UpAxis::Y),
        ("pysph_dam_break/dam.pvd", 0.045, UpAxis::Z),
        ("pysph_dam_break/dam_0000.vtu", 0.045, UpAxis::Z),
        ("pysph_dam_break/dam_0001.vtu", 0.045, UpAxis::Z),
        ("pysph_dam_break/dam_0003.vtu", 0.045, UpAxis::Z),
        ("pysph_dam_break/dam_0006.vtk", 0.045, UpAxis::Z),
        ("sphinxsys_soil_water/WaterBlock_*.vtp", 0.02, UpAxis::Y),
        ("liggghts_sph/sph_4000.vtk", 0.01, UpAxis::Z),
        ("splashsurf/double_dam_break_frame_01_4732_particles.vtk", 0.05, UpAxis::Y),
        ("splashsurf/double_dam_break_frame_26_4732_particles.vtk", 0.05, UpAxis::Y),
    ] {
        let series = open(&dir.join(name));
        let space = series.space();
        let error = space.spacing / spacing - 1.0;
        // 5 %: the promise of the specification.
        assert!(error.abs() < 0.05, "{name}: spacing {} is {:.1} % off", space.spacing, error * 100.0);
        assert_eq!(space.up, up, "{name}: {:?}", series.choices());
        assert_eq!(space.radius_choice, RadiusChoice::FromSpacing);
        assert!((space.radius / space.spacing - 0.625).abs() < 1e-12, "{name}");
        for flag in ["--spacing", "--radius", "--up", "--unit"] {
            let lines = series.choices().iter().filter(|choice| choice.flag == flag).count();
            assert_eq!(lines, 1, "{name}: lines with {flag}");
        }
    }
}

#[test]
fn every_single_frame_of_the_sphere_entry_is_upright() {
    let Some(dir) = data_dir() else { return };
    for frame in 0..20 {
        let series = open(&dir.join(format!("sphere_entry/fluid_{frame:04}.vtu")));
        assert_eq!(series.space().up, UpAxis::Y, "frame {frame}: {:?}", series.choices());
    }
}

#[test]
fn what_the_user_says_is_no_choice() {
    let Some(dir) = data_dir() else { return };
    let options = SeriesOptions {
        spacing: Some(0.004),
        radius: Some(0.002),
        up: Some(UpAxis::X),
        metres_per_unit: Some(0.01),
        io_mode: IoMode::Map,
        ..Default::default()
    };
    let series = Series::open(&dir.join("sphere_entry/fluid.pvd"), &options).expect("opens");
    let space = series.space();
    assert_eq!((space.spacing, space.spacing_source), (0.004, SpacingSource::User));
    assert_eq!((space.radius, space.radius_choice), (0.002, RadiusChoice::User));
    assert_eq!((space.up, space.metres_per_unit), (UpAxis::X, 0.01));
    assert_eq!(series.choices(), []);
}

#[test]
fn walls_are_no_water() {
    let Some(dir) = data_dir() else { return };
    for name in ["dam.pvd", "dam_0000.vtu", "dam_0003.vtu", "dam_0006.vtk"] {
        let path = dir.join("pysph_dam_break").join(name);
        let read = |series: &Series| -> Vec<(Look, usize)> {
            let frame = series.read(0, &FrameRequest::default(), &Cancel::default()).expect(name);
            frame.sets.iter().map(|set| (set.look, set.particles.len())).collect()
        };
        let series = open(&path);
        assert!(series.flaws().is_empty(), "{name}: {:?}", series.flaws());
        assert_eq!(read(&series), [(Look::Water, 7128), (Look::Hidden, 10_432)], "{name}");
        let lines: Vec<String> = series.choices().iter().map(ToString::to_string).collect();
        let line = lines
            .iter()
            .find(|line| line.starts_with("walls: 10432 of 17560 particles, not drawn"))
            .expect(name);
        let flag = "--set \"walls=type in (1, 2):solid\"";
        assert!(line.contains(flag), "{name}: {line}");
        assert_eq!(
            series.frame_info(0, false).expect(name).points,
            17_560,
            "{name}: info is of the whole file"
        );

        // The flag draws them, and nothing more is said of walls.
        let shown = SetSpec { name: "walls".into(), pattern: "type in (1, 2)".into(), look: Look::Solid };
        let shown =
            Series::open(&path, &SeriesOptions { sets: vec![shown], ..Default::default() }).expect(name);
        assert_eq!(read(&shown), [(Look::Water, 7128), (Look::Solid, 10_432)], "{name}");
        let kept =
            Series::open(&path, &SeriesOptions { keep_others: true, ..Default::default() }).expect(name);
        assert_eq!(read(&kept), [(Look::Water, 17_560)], "{name}");
        let flaws: Vec<_> = kept.flaws().iter().cloned().collect();
        assert_eq!(
            flaws,
            [Flaw::OthersDrawnAsWater { what: "walls", flag: "--where 'type == 0'".to_owned() }],
            "{name}"
        );
    }
}

/// A lake that something is about to fall into has no speed either: it is pointed out and drawn.
#[test]
fn what_only_has_no_speed_is_drawn() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("slide.vtk");
    let points: Vec<String> = (0..1000).map(|i| format!("{} {} {}", i % 10, i / 10 % 10, i / 100)).collect();
    let is_slide = |i: usize| i % 10 < 2;
    let kinds: Vec<&str> = (0..1000).map(|i| if is_slide(i) { "1" } else { "0" }).collect();
    let speeds: Vec<&str> = (0..1000).map(|i| if is_slide(i) { "3 0 -1" } else { "0 0 0" }).collect();
    let text = format!(
        "# vtk DataFile Version 3.0\nslide\nASCII\nDATASET POLYDATA\nPOINTS 1000 float\n{}\nPOINT_DATA 1000\n\
         SCALARS type int 1\nLOOKUP_TABLE default\n{}\nVECTORS velocity float\n{}\n",
        points.join("\n"),
        kinds.join("\n"),
        speeds.join("\n")
    );
    std::fs::write(&path, text).unwrap();
    let series = open(&path);
    let flaw = Flaw::OthersDrawnAsWater { what: "walls", flag: "--where 'type == 1'".to_owned() };
    assert!(series.flaws().iter().any(|found| *found == flaw), "{:?}", series.flaws());
    assert_eq!(series.read(0, &FrameRequest::default(), &Cancel::default()).unwrap().len(), 1000);
}

#[test]
fn a_folder_gives_the_fluid_and_lists_the_rest() {
    let Some(dir) = data_dir() else { return };
    for (folder, chosen, frames, other) in [
        ("sphere_entry", "fluid.pvd", 20, "sphere.pvd"),
        ("sphinxsys_soil_water", "WaterBlock_*.vtp", 22, "SoilBlock_*.vtp"),
        ("liggghts_chute", "chute_*.vtk", 10, "mesh_30000.vtk"),
    ] {
        let series = open(&dir.join(folder));
        assert_eq!(series.frame_count(), frames, "{folder}");
        let choice = &series.choices()[0];
        assert!(choice.value.starts_with(chosen) && choice.reason.contains(other), "{folder}: {choice}");
    }
}

#[test]
fn a_surface_mesh_among_the_parts_is_not_water() {
    let Some(dir) = data_dir() else { return };
    let series = open(&dir.join("sphere_entry/fluid_with_sphere.pvd"));
    for index in [0, 19] {
        let frame = series.read(index, &FrameRequest::default(), &Cancel::default()).expect("reads");
        assert_eq!(frame.len(), 61_952, "frame {index}");
    }
    let choice = &series.choices()[0];
    assert_eq!((choice.what.as_str(), choice.value.as_str()), ("parts left out", "sphere_0000.vtp"));
}

#[test]
fn flat_data_is_said_to_be_flat() {
    let Some(dir) = data_dir() else { return };
    let series = open(&dir.join("sphinxsys_soil_water"));
    assert!(series.flaws().iter().any(|flaw| *flaw == Flaw::Planar { axis: 'z' }), "{:?}", series.flaws());
}
