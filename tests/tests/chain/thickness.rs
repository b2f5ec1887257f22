//! Thickness is a length of water: known bodies, known answers (`algorithms.md` 14, tests 2 and 3).

use glam::Vec3;
use meniscus_cases::lattice::{self, Body};
use meniscus_pipeline::Settings;
use meniscus_ssfr::Anisotropy;
use meniscus_tests::{Shot, Studio, space};

const SPACING: f32 = 0.05;

/// A box of 1.2 x 1.0 x 0.8. Jittered, so that its middle part in the picture has the same mean wherever it is cut; on a
/// regular lattice seen along its rows the mean depends on the half cells at the cut.
fn body() -> Body {
    lattice::cuboid([-0.6, -0.5, 0.0], [24, 20, 16], SPACING, 0.2, 1)
}

/// Full detail or less; no floor, which would hide what reaches below it.
fn settings(lod: f32) -> Settings {
    let mut settings = Settings::default();
    settings.lod.threshold = lod;
    settings.scene.floor = Some(false);
    // Mass is drawn as spheres; what of it sticks out of ellipsoids, a fraction of a radius all around, is not seen.
    settings.surface.anisotropy.form = Some(Anisotropy::None);
    settings
}

/// Along y: 1.0 deep, and 1.2 x 0.8 wide and high in the picture.
fn shoot(body: &Body, radius: f32, lod: f32, size: [u32; 2]) -> Shot {
    let mut studio =
        Studio::new(body.positions.clone(), space(SPACING, radius), settings(lod)).expect("a studio");
    let camera = studio.parallel(Vec3::Y, HEIGHT);
    studio.shoot(&camera, size).expect("a picture")
}

/// Of the picture, world units.
const HEIGHT: f32 = 1.6;

/// Splats of a few pixels and of dozens, which are drawn in different ways.
const SMALL_SPLATS: [u32; 2] = [320, 180];
const LARGE_SPLATS: [u32; 2] = [1280, 720];

/// Mean thickness of the pixels at least `margin` (world) inside of the body's outline in the picture, and the area that
/// they cover.
fn interior(shot: &Shot, margin: f32) -> (f64, f64) {
    let [width, height] = shot.size;
    let pixel = HEIGHT / height as f32;
    let inside = |index: usize| {
        let (x, y) = (index as u32 % width, index as u32 / width);
        let across = (x as f32 + 0.5 - width as f32 / 2.0) * pixel;
        let down = (y as f32 + 0.5 - height as f32 / 2.0) * pixel;
        across.abs() < 0.6 - margin && down.abs() < 0.4 - margin
    };
    let values: Vec<f64> =
        (0..shot.thickness.len()).filter(|i| inside(*i)).map(|i| f64::from(shot.thickness[i])).collect();
    (values.iter().sum::<f64>() / values.len() as f64, values.len() as f64 * f64::from(pixel * pixel))
}

#[test]
fn a_box_is_as_thick_as_it_is_deep_whatever_the_radius() {
    for size in [SMALL_SPLATS, LARGE_SPLATS] {
        for s in [1.0, 1.24, 1.5, 2.0] {
            let shot = shoot(&body(), s * SPACING / 2.0, 1.0, size);
            // The largest sphere's radius and three standard deviations of the smoothing away from the edge.
            let (mean, _) = interior(&shot, 0.2);
            // algorithms.md 14.2: one percent.
            assert!((mean - 1.0).abs() < 0.01, "s {s}, {size:?}: {mean}");
        }
    }
}

/// Seen from above: a floor that the water stands on takes nothing of it, one within it all that is below.
#[test]
fn a_floor_cuts_off_what_is_below_it() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("scene.toml");
    let mean = |floor: Option<bool>, height: Option<f32>, radius: f32| {
        let mut settings = settings(1.0);
        settings.scene.floor = floor;
        if let Some(height) = height {
            std::fs::write(&file, format!("[floor]\nheight = {height}\n")).unwrap();
            settings.scene.file = Some(file.clone());
        }
        let mut studio = Studio::new(body().positions, space(SPACING, radius), settings).expect("a studio");
        let camera = studio.parallel(Vec3::new(0.0, 1e-3, -1.0), HEIGHT);
        let shot = studio.shoot(&camera, SMALL_SPLATS).expect("a picture");
        let middle = |y: usize| &shot.thickness[y * shot.size[0] as usize..][140..180];
        let values: Vec<f64> = (80..100).flat_map(middle).map(|&t| f64::from(t)).collect();
        values.iter().sum::<f64>() / values.len() as f64
    };
    for radius in [0.625 * SPACING, SPACING] {
        let whole = mean(Some(false), None, radius);
        // 14.2 of algorithms.md: one percent.
        assert!((whole / 0.8 - 1.0).abs() < 0.01, "{whole}");
        assert_eq!(mean(Some(true), None, radius), whole);
        let cut = mean(None, Some(0.3), radius);
        // What is cut is counted per sphere, here and there by their share: a percent of the whole.
        assert!((cut - 0.5).abs() < 0.008, "{cut}");
    }
}

#[test]
fn a_thinned_box_keeps_its_depth() {
    let body = body();
    for p in [0.3, 0.6] {
        let shot = shoot(&body, 0.625 * SPACING, p, SMALL_SPLATS);
        let kept = shot.kept[0] as f64 / shot.kept[1] as f64;
        assert!((kept - f64::from(p)).abs() < 0.05, "{kept} kept");
        let (mean, area) = interior(&shot, 0.2);
        // Those of the particles that the interior pixels see.
        let seen = body.positions.len() as f64 * area / (1.2 * 0.8);
        let tolerance = f64::max(0.01, 4.0 * ((1.0 - kept) / (kept * seen)).sqrt());
        assert!((mean - 1.0).abs() < tolerance, "p {p}: {mean} +- {tolerance}");
    }
}

#[test]
fn the_integral_over_a_parallel_picture_is_the_volume() {
    let body = body();
    let mut settings = settings(1.0);
    // Smoothing keeps the mean of what is covered, not the integral over a sharp edge.
    settings.surface.thickness.smoothing = 0.0;
    settings.surface.thickness.scale = 1;
    let mut studio =
        Studio::new(body.positions.clone(), space(SPACING, 0.625 * SPACING), settings).expect("a studio");
    let camera = studio.parallel(Vec3::new(0.5, 1.0, -0.4), HEIGHT * 1.3);
    let shot = studio.shoot(&camera, [480, 360]).expect("a picture");
    let pixel = f64::from(HEIGHT * 1.3) / 360.0;
    let volume = shot.thickness.iter().map(|&t| f64::from(t)).sum::<f64>() * pixel * pixel;
    // algorithms.md 14.3: a tenth of a percent.
    assert!((volume / body.volume - 1.0).abs() < 1e-3, "{volume} of {}", body.volume);
}

#[test]
fn doubling_the_radius_leaves_the_mean_thickness() {
    let body = body();
    for size in [SMALL_SPLATS, LARGE_SPLATS] {
        let [one, two] = [0.625, 1.25].map(|r| shoot(&body, r * SPACING, 1.0, size));
        let ratio = |mean: &dyn Fn(&Shot) -> f64| mean(&two) / mean(&one);
        let inside = ratio(&|shot| interior(shot, 0.2).0);
        // One percent, as for the depth itself.
        assert!((inside - 1.0).abs() < 0.01, "inside, {size:?}: {inside}");
        let whole = ratio(&|shot| shot.thickness.iter().map(|&t| f64::from(t)).sum());
        assert!((whole - 1.0).abs() < 0.01, "over the whole picture, {size:?}: {whole}");
    }
}
