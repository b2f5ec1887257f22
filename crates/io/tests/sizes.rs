//! Sizes of particles of their own.

use std::path::Path;

use meniscus_core::{Cancel, Choice, Flaw, FrameRequest, FrameSource, ParticleFrame};
use meniscus_io::writer::{Values, WriteAttribute, WriteParticles, write_vtu_raw};
use meniscus_io::{Series, SeriesOptions, SetSpec};
use tempfile::TempDir;

/// A block of `n`³ particles `spacing` apart from `corner` on.
fn block(corner: [f64; 3], n: usize, spacing: f64) -> Vec<[f64; 3]> {
    let at = |i: usize| [i % n, i / n % n, i / n / n];
    let place = |i| std::array::from_fn(|axis| corner[axis] + (at(i)[axis] as f64 + 0.5) * spacing);
    (0..n.pow(3)).map(place).collect()
}

/// A block of spacing 0.1 and one of 0.2 beside it; the lengths of their particles, in spacings of the first.
fn two_blocks(fine: usize, coarse: usize) -> (Vec<[f64; 3]>, Vec<f64>) {
    let mut positions = block([0.0; 3], fine, 0.1);
    positions.extend(block([fine as f64 * 0.1, 0.0, 0.0], coarse, 0.2));
    let lengths = (0..positions.len()).map(|i| if i < fine.pow(3) { 1.0 } else { 2.0 }).collect();
    (positions, lengths)
}

struct File {
    folder: TempDir,
}

impl File {
    fn new(positions: &[[f64; 3]], attributes: &[(&str, Vec<f64>)]) -> Self {
        let folder = tempfile::tempdir().expect("a folder");
        let attributes: Vec<WriteAttribute<'_>> = attributes
            .iter()
            .map(|(name, values)| WriteAttribute {
                name,
                components: values.len() / positions.len(),
                values: Values::F64(values),
            })
            .collect();
        let data = WriteParticles { positions, attributes: &attributes, time: None };
        write_vtu_raw(&folder.path().join("a.vtu"), &data).expect("written");
        Self { folder }
    }

    fn open(&self, options: &SeriesOptions) -> Result<Series, meniscus_io::Error> {
        Series::open(&Path::join(self.folder.path(), "a.vtu"), options)
    }

    fn series(&self) -> Series {
        self.open(&SeriesOptions::default()).expect("opens")
    }
}

fn by(name: &str) -> SeriesOptions {
    SeriesOptions { radius_by: Some(name.into()), ..Default::default() }
}

fn water(series: &Series) -> ParticleFrame {
    let frame = series.read(0, &FrameRequest::default(), &Cancel::default()).expect("reads");
    frame.sets.into_iter().next().expect("a set").particles
}

fn line(series: &Series) -> Option<&Choice> {
    series.choices().iter().find(|choice| choice.what == "sizes")
}

#[track_caller]
fn assert_sizes(found: &[f32], expected: &[f64]) {
    assert_eq!(found.len(), expected.len());
    for (found, expected) in std::iter::zip(found, expected) {
        // Two roundings of f32 and a root.
        assert!((f64::from(*found) / expected - 1.0).abs() < 1e-6, "{found}, not {expected}");
    }
}

#[test]
fn sizes_are_found_under_many_names() {
    let (positions, lengths) = two_blocks(20, 10);
    let scaled = |factor: f64, power: i32| lengths.iter().map(|l| factor * l.powi(power)).collect::<Vec<_>>();
    let mass = || ("m", scaled(1.0, 3));
    let two_liquids =
        || ("rho", (0..positions.len()).map(|i| if i % 2 == 0 { 1000.0 } else { 500.0 }).collect());
    for attributes in [
        vec![("radius", scaled(0.05, 1))],
        // In another unit.
        vec![("Radius", scaled(50.0, 1))],
        vec![("particle_radius", scaled(0.05, 1))],
        vec![("r", scaled(0.05, 1))],
        vec![("Diameter", scaled(0.1, 1))],
        vec![("d", scaled(0.1, 1))],
        vec![("volume", scaled(0.001, 3))],
        vec![("volume", scaled(0.001, 3)), mass()],
        vec![mass(), ("rho", vec![1000.0; positions.len()])],
        vec![mass(), two_liquids(), ("h", scaled(0.13, 1))],
    ] {
        let file = File::new(&positions, &attributes);
        let series = file.series();
        let line = line(&series).unwrap_or_else(|| panic!("{}: no line", attributes[0].0));
        assert!(line.value.starts_with("1.00 to 2.00 times the usual"), "{line:?}");
        assert!(line.flag.starts_with("--radius-by"), "{line:?}");
        assert_sizes(&water(&series).sizes, &lengths);
        // 5 %: the promise of the specification.
        assert!((series.space().spacing / 0.1 - 1.0).abs() < 0.05, "{}", series.space().spacing);
    }
}

/// Sizes are counted from the median; the spacing has to be that of the same particles.
#[test]
fn the_spacing_is_that_of_particles_of_size_one() {
    // More coarse particles than fine ones, but where it is denser an estimate is surer.
    let (positions, lengths) = two_blocks(20, 21);
    let plain = File::new(&positions, &[]).series().space().spacing;
    assert!((plain / 0.1 - 1.0).abs() < 0.05, "the trap: {plain}");
    let file = File::new(&positions, &[("diameter", lengths.iter().map(|l| 0.1 * l).collect())]);
    let series = file.series();
    assert_sizes(&water(&series).sizes, &lengths.iter().map(|l| 0.5 * l).collect::<Vec<_>>());
    // 5 %: the promise of the specification.
    assert!((series.space().spacing / 0.2 - 1.0).abs() < 0.05, "{}", series.space().spacing);
}

#[test]
fn what_does_not_vary_is_neither_read_nor_mentioned() {
    let positions = block([0.0; 3], 12, 0.1);
    let n = positions.len();
    // A few percent, and a single one that is off.
    let nearly: Vec<f64> =
        (0..n).map(|i| if i == 7 { 1.0 } else { 0.05 * (1.0 + 0.03 * (i as f64).sin()) }).collect();
    for attribute in [("radius", vec![0.05; n]), ("diameter", nearly), ("mass", vec![1.0; n])] {
        let file = File::new(&positions, &[attribute]);
        let series = file.series();
        assert_eq!(line(&series), None);
        assert_eq!(series.radius_by(), None);
        let frame = water(&series);
        assert_eq!((frame.sizes.len(), frame.sizes.capacity()), (0, 0));
    }
}

#[test]
fn broken_radii_that_are_not_used_are_said() {
    let positions = block([0.0; 3], 12, 0.1);
    let n = positions.len();
    let holes = (0..n).map(|i| if i % 7 == 0 { f64::NAN } else { 0.05 * (1.0 + 0.3 * (i as f64).sin()) });
    let zeros = (0..n).map(|i| if i % 7 == 0 { 0.0 } else { 0.05 });
    let stray = (0..n).map(|i| if i == 7 { 1e30 } else { 0.05 });
    for (name, values, count) in [
        ("radius", holes.collect::<Vec<_>>(), 247),
        ("diameter", zeros.collect(), 247),
        ("radius", stray.collect(), 1),
    ] {
        let series = File::new(&positions, &[(name, values)]).series();
        let line = line(&series).expect("a line");
        assert_eq!((line.value.as_str(), line.flag.clone()), ("all alike", format!("--radius-by {name}")));
        let counted = format!("for {count} of {n} sampled particles");
        assert!(
            line.reason.starts_with(&format!("{name:?} is no number")) && line.reason.ends_with(&counted),
            "{}",
            line.reason
        );
        assert_eq!(series.radius_by(), None);
    }
    // A letter may mean a distance from anywhere.
    let series = File::new(&positions, &[("r", vec![0.0; n])]).series();
    assert_eq!(line(&series), None);
}

#[test]
fn what_may_mean_something_else_is_said_and_not_used() {
    let (positions, lengths) = two_blocks(16, 8);
    let n = positions.len();
    let cubes: Vec<f64> = lengths.iter().map(|l| l.powi(3)).collect();
    let from_axis = positions.iter().map(|p| 1e-3 + p[0].hypot(p[1])).collect();
    for (attributes, name) in [
        (vec![("h", lengths.clone())], "h"),
        (vec![("smoothing_length", lengths.clone()), ("mass", vec![1.0; n])], "smoothing_length"),
        (vec![("volume", cubes.clone()), ("mass", vec![1.0; n])], "volume"),
        (vec![("mass", cubes.clone()), ("density", cubes.clone())], "mass"),
        (vec![("mass", cubes.clone())], "mass"),
        (vec![("r", from_axis)], "r"),
    ] {
        let file = File::new(&positions, &attributes);
        let series = file.series();
        let line = line(&series).unwrap_or_else(|| panic!("{name}: no line"));
        assert_eq!(
            (line.value.as_str(), line.flag.as_str()),
            ("all alike", format!("--radius-by {name}").as_str())
        );
        assert!(line.reason.contains(&format!("{name:?} varies, but")), "{line:?}");
        assert!(water(&series).sizes.is_empty());
        // And the flag that the line names does it.
        assert!(!water(&file.open(&by(name)).expect("opens")).sizes.is_empty(), "{name}");
    }
}

#[test]
fn broken_sizes_are_replaced_and_counted() {
    let (positions, lengths) = two_blocks(16, 8);
    let mut radii: Vec<f64> = lengths.iter().map(|l| 0.05 * l).collect();
    let mut expected = lengths;
    let broken =
        [(3, f64::NAN, 1.0), (10, 0.0, 1.0), (20, -1.0, 1.0), (30, 1e30, 32.0), (40, 1e-30, 0.031_25)];
    for (i, radius, size) in broken {
        (radii[i], expected[i]) = (radius, size);
    }
    let file = File::new(&positions, &[("radius", radii)]);
    let series = file.series();
    assert_sizes(&water(&series).sizes, &expected);
    let frame = series.read(0, &FrameRequest::default(), &Cancel::default()).expect("reads");
    let flaw = Flaw::SizesReplaced { attribute: "radius".into(), count: 5 };
    assert_eq!(frame.flaws.iter().collect::<Vec<_>>(), [&flaw]);
}

#[test]
fn the_user_has_the_last_word() {
    let (positions, lengths) = two_blocks(16, 8);
    let n = positions.len();
    let attributes = [
        ("radius", lengths.clone()),
        ("size", vec![7.0; n]),
        ("v", vec![1.0; 3 * n]),
        ("zero", vec![0.0; n]),
    ];
    let file = File::new(&positions, &attributes);
    let open = |name: &str| file.open(&by(name));
    let none = open("none").expect("opens");
    assert_eq!((line(&none), water(&none).sizes.len()), (None, 0));
    // Frames that come later may have others.
    assert_eq!(water(&open("size").expect("opens")).sizes, vec![1.0; n]);
    for (name, of) in [("v", "3 numbers"), ("zero", "above 0"), ("width", "radius")] {
        let error = open(name).err().unwrap_or_else(|| panic!("{name}: no error")).to_string();
        assert!(error.contains(name) && error.contains(of), "{error}");
    }
}

#[test]
fn sizes_stay_with_their_particles() {
    let (mut positions, lengths) = two_blocks(16, 8);
    positions[5] = [f64::NAN; 3];
    let whole: Vec<f64> = (0..positions.len()).map(|i| (i % 3) as f64).collect();
    let file = File::new(&positions, &[("radius", lengths.clone()), ("part", whole)]);
    let kept = |is_in: &dyn Fn(usize) -> bool| {
        (0..lengths.len()).filter(|&i| i != 5 && is_in(i)).map(|i| lengths[i]).collect::<Vec<_>>()
    };
    assert_sizes(&water(&file.series()).sizes, &kept(&|_| true));
    let sets = vec![SetSpec::parse("other=part > 0.5").expect("a set")];
    let series = file.open(&SeriesOptions { sets, ..Default::default() }).expect("opens");
    let frame = series.read(0, &FrameRequest::default(), &Cancel::default()).expect("reads");
    assert_sizes(&frame.sets[0].particles.sizes, &kept(&|i| i % 3 == 0));
    assert_sizes(&frame.sets[1].particles.sizes, &kept(&|i| i % 3 != 0));
    let dropped = Flaw::NonFiniteDropped { count: 1 };
    assert_eq!(frame.flaws.iter().collect::<Vec<_>>(), [&dropped]);
    assert_eq!(frame.bytes(), frame.sets.iter().map(|set| 24 * set.particles.len() as u64).sum::<u64>());
}

/// Walls often have none.
#[test]
fn sizes_of_what_is_left_out_do_not_matter() {
    let (positions, mut radii) = two_blocks(16, 8);
    let whole: Vec<f64> = (0..positions.len()).map(|i| (i % 3) as f64).collect();
    radii.iter_mut().step_by(3).for_each(|radius| *radius = 0.0);
    let file = File::new(&positions, &[("radius", radii), ("part", whole)]);
    let options = SeriesOptions { where_expr: Some("part > 0.5".into()), ..Default::default() };
    let series = file.open(&options).expect("opens");
    let frame = series.read(0, &FrameRequest::default(), &Cancel::default()).expect("reads");
    assert_eq!(frame.sets[0].particles.sizes.len(), frame.len());
    assert!(frame.flaws.is_empty(), "{:?}", frame.flaws);
}
