//! The smoke set of the image cases: those of `cases.toml` with `smoke = true`, one test each. `cargo xtask e2e` draws all.

use std::path::{Path, PathBuf};

use meniscus_tests::golden::{Case, Cases, Expected, Runner, Status, compare};
use meniscus_tests::{Mask, Pixels};

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

fn cases() -> Cases {
    Cases::read(&root().join("cases.toml")).unwrap_or_else(|e| panic!("{e}"))
}

/// Draws a case and compares it with its expected image. The pictures stay in the target folder, for whoever wants to see
/// what failed.
fn check(name: &str) {
    let out = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join("images").join(name);
    let binary = env!("CARGO_BIN_EXE_meniscus-under-test");
    let runner = Runner::new(root(), binary, out.clone()).unwrap_or_else(|e| panic!("{e}"));
    let chosen = runner.cases.choose(&[name.to_owned()]).unwrap_or_else(|e| panic!("{e}"));
    let outcome = runner.check(chosen[0]);
    assert!(outcome.status == Status::Passed, "pictures in {}\n{outcome:#?}", out.display());
}

/// One test per name, and the list of all names.
macro_rules! smoke {
    ($($test:ident $name:literal)*) => {
        const SMOKE: &[&str] = &[$($name),*];
        $(
            #[test]
            fn $test() {
                check($name);
            }
        )*
    };
}

smoke! {
    dam_break_early "dam-break-early"
    dam_break_late "dam-break-late"
    dam_break_lod "dam-break-lod"
    dam_break_unfiltered "dam-break-unfiltered"
    dam_break_solid "dam-break-solid"
}

/// The way from a wrong picture to a red line, and from a case that nobody has looked at to another.
#[test]
fn a_wrong_picture_and_a_missing_expectation_fail() {
    let out = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join("images-wrong");
    let binary = env!("CARGO_BIN_EXE_meniscus-under-test");
    let runner = Runner::new(root(), binary, out).unwrap_or_else(|e| panic!("{e}"));
    let right = runner.cases.cases.iter().find(|case| case.name == SMOKE[0]).expect("a smoke case").clone();

    let flags = "--param lighting.attenuation_scale=1.5".to_owned();
    let wrong = runner.check(&Case { flags, ..right.clone() });
    assert!(wrong.status == Status::Failed && wrong.problem.is_none(), "{wrong:#?}");
    assert!(wrong.metrics.iter().any(|metric| !metric.passed), "{wrong:#?}");

    let unseen = runner.check(&Case { name: "unseen".to_owned(), ..right.clone() });
    assert!(unseen.status == Status::Failed, "{unseen:#?}");
    assert!(unseen.problem.is_some_and(|text| text.contains("--update unseen")));

    let flags = "--no-such-flag".to_owned();
    let broken = runner.check(&Case { flags, ..right });
    assert!(broken.status == Status::Failed, "{broken:#?}");
    assert!(broken.problem.is_some_and(|text| text.contains("exit code 2")));
}

#[test]
fn every_smoke_case_has_a_test() {
    let cases = cases();
    let marked: Vec<&str> = cases.cases.iter().filter(|c| c.smoke).map(|c| c.name.as_str()).collect();
    assert_eq!(SMOKE, marked, "the list above and `smoke = true` in cases.toml");
}

#[test]
fn every_case_has_a_picture_and_every_picture_a_case() {
    let cases = cases();
    let expected = Expected::new(root().join("expected"));
    let names: Vec<&str> = cases.cases.iter().map(|case| case.name.as_str()).collect();
    assert_eq!(expected.stale(&names).unwrap_or_else(|e| panic!("{e}")), [""; 0], "belong to no case");
    for case in &cases.cases {
        let (picture, mask, origin) =
            expected.load(&case.name).unwrap_or_else(|e| panic!("{}: {e}", case.name));
        assert_eq!(format!("{}x{}", picture.size[0], picture.size[1]), cases.size, "{}", case.name);
        assert!(mask.area() > 0, "{} shows no water", case.name);
        let drawn_by = case.render_arguments(&cases.size);
        assert_eq!(origin.command, drawn_by, "{}: the flags changed, the picture did not", case.name);
    }
}

/// Everybody who clones the repository pays for them.
#[test]
fn the_expected_images_are_small() {
    let folder = std::fs::read_dir(root().join("expected")).expect("expected images");
    let bytes: u64 = folder.flatten().map(|entry| entry.metadata().map_or(0, |data| data.len())).sum();
    assert!(bytes > 0 && bytes < 900_000, "{bytes} bytes");
}

/// The limits for drivers that did not make the expected images are far from its own noise, yet what anybody would call a
/// mistake is outside of each.
#[test]
fn the_lenient_limits_notice_mistakes() {
    let limits = cases().other_driver;
    let expected = Expected::new(root().join("expected"));
    let (picture, mask, _) = expected.load("dam-break-late").unwrap_or_else(|e| panic!("{e}"));
    let failed = |ours: &Pixels, ours_mask: &Mask| -> Vec<&'static str> {
        let comparison =
            compare((ours, ours_mask), (&picture, &mask), &limits).unwrap_or_else(|e| panic!("{e}"));
        comparison.metrics.into_iter().filter(|metric| !metric.passed).map(|metric| metric.name).collect()
    };
    assert_eq!(failed(&picture, &mask), [""; 0]);

    let brighter = |steps: u8| {
        let mut pixels = picture.clone();
        pixels.rgba.iter_mut().for_each(|p| p[..3].iter_mut().for_each(|c| *c = c.saturating_add(steps)));
        pixels
    };
    assert_eq!(failed(&brighter(1), &mask), [""; 0], "rounding");
    assert_eq!(failed(&brighter(2), &mask), ["FLIP mean"]);
    assert_eq!(failed(&brighter(4), &mask), ["FLIP mean", "FLIP 99 %"]);

    let mut shifted = picture.clone();
    shifted.rgba.rotate_right(1);
    assert_eq!(failed(&shifted, &mask), ["FLIP mean", "FLIP 99 %", "SSIM"]);

    // One more pixel in each direction is what a radius too large by a fifth does here.
    assert_eq!(failed(&picture, &mask.dilated(1)), ["mask area"]);
}
