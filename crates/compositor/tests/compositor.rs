//! Against a real device: a missing adapter is a failure, not a skip.

use meniscus_compositor::{Compositor, CompositorParameters, Display, ToneCurve, twin};
use meniscus_gpu::role::Radiance;
use meniscus_gpu::{AdapterChoice, Gpu, Recorder, Texture, Timing};

fn gpu() -> Gpu {
    Gpu::new(&AdapterChoice::default()).expect("an adapter, at least mesa-vulkan-drivers")
}

fn display(
    gpu: &Gpu,
    size: [u32; 2],
    pixels: &[[f32; 4]],
    parameters: &CompositorParameters,
) -> Vec<[u8; 4]> {
    let mut compositor = Compositor::new(gpu, parameters).unwrap();
    compositor.resize(gpu, size).unwrap();
    let radiance = Texture::<Radiance>::from_floats(gpu, size, pixels).unwrap();
    let display = Display::new(gpu, size).unwrap();
    let mut recorder = Recorder::new(gpu, Timing::Stamps);
    compositor.record(gpu, &mut recorder, &radiance, &display);
    let _ = recorder.submit(gpu).unwrap();
    display.read(gpu).unwrap().into_iter().map(u32::to_le_bytes).collect()
}

#[test]
fn tone_curves_follow_their_twin() {
    let gpu = gpu();
    let levels: Vec<[f32; 4]> = (0..256)
        .map(|i| {
            let x = 1e-3 * 1.06f32.powi(i);
            [x, 0.5 * x, 0.1 + 0.2 * x, 1.0]
        })
        .collect();
    for tone_curve in [ToneCurve::Neutral, ToneCurve::Filmic, ToneCurve::Clip] {
        for (contrast, saturation, exposure) in [(1.0, 1.0, 0.0), (1.0, 0.3, 0.0), (1.4, 0.3, 1.5)] {
            let parameters = CompositorParameters {
                tone_curve,
                contrast,
                saturation,
                exposure: Some(exposure),
                anti_aliasing: false,
                ..Default::default()
            };
            let pixels = display(&gpu, [256, 1], &levels, &parameters);
            for (found, level) in pixels.iter().zip(&levels) {
                let expected = twin::display_color(&parameters, [level[0], level[1], level[2]]);
                for c in 0..3 {
                    let difference = f32::from(found[c]) - expected[c] * 255.0;
                    // One step: half of it dither, half of it rounding; 0.1 for the driver's pow of contrast.
                    assert!(difference.abs() <= 1.1, "{tone_curve:?} {level:?}: {found:?} {expected:?}");
                }
            }
        }
    }
}

#[test]
fn no_input_makes_a_pixel_that_is_not_a_colour() {
    let gpu = gpu();
    let odd = [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, f32::MAX, f32::MIN, -0.0, 1e-45, 0.5];
    let pixels: Vec<[f32; 4]> =
        (0..64).map(|i| [odd[i % 8], odd[i / 8], odd[(i + 3) % 8], odd[(i * 5) % 8]]).collect();
    for tone_curve in [ToneCurve::Neutral, ToneCurve::Filmic, ToneCurve::Clip] {
        for (contrast, exposure) in [(1.0, 0.0), (4.0, 20.0), (0.1, -20.0)] {
            let parameters = CompositorParameters {
                tone_curve,
                contrast,
                exposure: Some(exposure),
                anti_aliasing: false,
                transparent: true,
                ..Default::default()
            };
            let found = display(&gpu, [8, 8], &pixels, &parameters);
            for (pixel, input) in found.iter().zip(&pixels) {
                let expected = twin::display_color(&parameters, [input[0], input[1], input[2]]);
                for c in 0..3 {
                    assert!(expected[c].is_finite());
                    let difference = f32::from(pixel[c]) - expected[c] * 255.0;
                    // As above, and one more step for pow of extreme exponents.
                    assert!(difference.abs() <= 2.1, "{tone_curve:?} {input:?}: {pixel:?} {expected:?}");
                }
            }
        }
    }
}

#[test]
fn anti_aliasing_softens_a_slanted_edge_and_leaves_the_rest() {
    let gpu = gpu();
    let size = [64, 64];
    let pixels: Vec<[f32; 4]> = (0..64 * 64)
        .map(|i| {
            let (x, y) = (i % 64, i / 64);
            let v = if 4 * y < x + 100 { 0.6 } else { 0.05 };
            [v, v, v, 1.0]
        })
        .collect();
    let run = |anti_aliasing| {
        let parameters = CompositorParameters { anti_aliasing, ..Default::default() };
        display(&gpu, size, &pixels, &parameters)
    };
    let (hard, soft) = (run(false), run(true));
    let levels = |image: &[[u8; 4]]| {
        let mut steps: Vec<u8> = image.iter().map(|p| p[0] / 8).collect();
        steps.sort_unstable();
        steps.dedup();
        steps.len()
    };
    assert!(levels(&hard) <= 4, "{}", levels(&hard));
    assert!(levels(&soft) > levels(&hard) + 3, "{} levels", levels(&soft));
    for (i, (h, s)) in hard.iter().zip(&soft).enumerate() {
        let (x, y) = (i as i32 % 64, i as i32 / 64);
        if (4 * y - x - 100).abs() > 12 {
            assert_eq!(h, s, "far from the edge at {x}, {y}");
        }
    }
}

/// Rows begin and end within words of brightness, edges lie at borders, in corners and in alpha; lone pixels and stairs.
#[test]
fn anti_aliasing_follows_its_twin() {
    let gpu = gpu();
    for (size, transparent) in [
        ([67, 45], false),
        ([67, 45], true),
        // More pixels than there are in a row of the textures.
        ([131, 97], false),
        ([64, 3], false),
        ([1, 9], true),
        ([5, 1], false),
        ([3, 2], true),
    ] {
        let pixels: Vec<[f32; 4]> = (0..size[0] * size[1])
            .map(|i| {
                let (x, y) = (i % size[0], i / size[0]);
                // None whose brightness is so near the middle of two steps that both sides might round it differently.
                let level = |n: u32| [0.02, 0.11, 0.33, 0.72][(n % 4) as usize];
                // Stairs of several slopes, and a pixel here and there that has the colour of none.
                let a = (x / 3 + y) / 7 + (2 * x / 5 + 3 * y) / 11;
                let lone = if (x * 7 + y * 13) % 29 == 0 { 2 } else { 0 };
                [level(a), level(a + lone), level(a / 2), if (x + 2 * y) / 9 % 3 == 0 { 0.25 } else { 1.0 }]
            })
            .collect();
        let parameters = CompositorParameters { transparent, ..Default::default() };
        let found = display(&gpu, size, &pixels, &parameters);
        let colors: Vec<[f32; 4]> = pixels
            .iter()
            .map(|&[r, g, b, a]| {
                let [r, g, b] = twin::display_color(&parameters, [r, g, b]);
                [r, g, b, if transparent { a } else { 1.0 }]
            })
            .collect();
        let picture = twin::fxaa::Picture { colors: &colors, size, transparent };
        let mut mixed = 0;
        for (i, found) in (0..).zip(&found) {
            let at = [i % size[0], i / size[0]];
            let expected = picture.smoothed(at);
            mixed += u32::from(expected != colors[i as usize]);
            for (found, expected) in found.iter().zip(expected) {
                let difference = f32::from(*found) - expected * 255.0;
                // Half a step of dither and half of rounding of what is mixed, half a step of rounding after; 0.1 for sums.
                assert!(difference.abs() <= 1.6, "{size:?} {at:?}: {found} for {}", expected * 255.0);
            }
        }
        assert!(mixed > 0, "nothing to smooth in {size:?}");
    }
}

#[test]
fn alpha_is_coverage_only_on_request_and_one_pixel_is_enough() {
    let gpu = gpu();
    for (transparent, alpha) in [(false, 255), (true, 64)] {
        let parameters = CompositorParameters { transparent, ..Default::default() };
        let pixels = display(&gpu, [1, 1], &[[0.2, 0.3, 0.4, 0.25]], &parameters);
        assert_eq!(pixels[0][3], alpha);
    }
}

/// The thin edge of water on the default ground, both as bright to the eye, is a staircase that shows; the joints of the ground, which are
/// grey and averaged over pixels already, stay sharp.
#[test]
fn anti_aliasing_finds_the_edge_of_pale_water_and_leaves_the_joints_of_the_ground() {
    let gpu = gpu();
    let parameters = CompositorParameters { tone_curve: ToneCurve::Clip, ..Default::default() };
    let light = |[r, g, b]: [u8; 3]| {
        let [r, g, b] = [r, g, b].map(|c| meniscus_core::srgb::decode(f32::from(c) / 255.0));
        [r, g, b, 1.0]
    };
    let reds = |other: [u8; 3]| {
        let shows = |i: usize| if 4 * (i / 64) < i % 64 + 100 { [222, 218, 214] } else { other };
        let pixels: Vec<[f32; 4]> = (0..64 * 64).map(|i| light(shows(i))).collect();
        let pixels = display(&gpu, [64, 64], &pixels, &parameters);
        // Dither is one step.
        let between = |p: &&[u8; 4]| p[0] > other[0] + 3 && p[0] < 219;
        pixels.iter().filter(between).count()
    };
    let (water, joint) = (reds([186, 209, 213]), reds([198, 195, 192]));
    assert!(water > 30 && joint == 0, "{water} pixels between water and ground, {joint} beside joints");
}

/// A transparent picture is laid over another one: a staircase in alpha shows there, whatever the colours do.
#[test]
fn anti_aliasing_softens_the_edge_of_alpha_as_well() {
    let gpu = gpu();
    let pixels: Vec<[f32; 4]> = (0..64 * 64)
        .map(|i| {
            let coverage = if 4 * (i / 64) < i % 64 + 100 { 1.0 } else { 0.0 };
            [0.3 * coverage, 0.3 * coverage, 0.3 * coverage, coverage]
        })
        .collect();
    let levels = |anti_aliasing| {
        let parameters = CompositorParameters { anti_aliasing, transparent: true, ..Default::default() };
        let pixels = display(&gpu, [64, 64], &pixels, &parameters);
        pixels.iter().map(|p| p[3] / 8).collect::<std::collections::BTreeSet<_>>().len()
    };
    let (hard, soft) = (levels(false), levels(true));
    // The edge climbs one row in four columns, so that it cuts pixels in several ways.
    assert!(hard == 2 && soft > hard + 2, "{hard} and {soft} levels of alpha");
}

#[test]
fn the_same_picture_twice_is_the_same_bytes() {
    let gpu = gpu();
    let pixels: Vec<[f32; 4]> =
        (0..33 * 17).map(|i| [(i % 7) as f32 * 0.2, 0.3, (i % 5) as f32, 1.0]).collect();
    let run = || display(&gpu, [33, 17], &pixels, &CompositorParameters::default());
    assert_eq!(run(), run());
}

/// Odd sizes, one pixel, a long strip; glints, and what is no number.
#[test]
fn bloom_follows_its_twin() {
    let gpu = gpu();
    for (size, exposure, transparent) in
        [([1, 1], 0.0, false), ([61, 37], 0.0, false), ([64, 48], -3.0, true), ([4097, 3], 2.0, false)]
    {
        let pixels: Vec<[f32; 4]> = (0..size[0] * size[1])
            .map(|i| match i % 97 {
                11 => [300.0, 200.0, 100.0, 1.0],
                12 => [f32::NAN, f32::INFINITY, -1.0, 0.5],
                x => [0.002 * x as f32, 0.3, 0.5 - 0.004 * x as f32, 0.25],
            })
            .collect();
        let parameters = CompositorParameters {
            bloom: 0.4,
            exposure: Some(exposure),
            white_balance: [1.2, 1.0, 0.7],
            anti_aliasing: false,
            transparent,
            ..Default::default()
        };
        let found = display(&gpu, size, &pixels, &parameters);
        let bloomed = twin::bloom::bloomed(&parameters, &pixels, size);
        let mut changed = 0;
        for ((found, light), pixel) in found.iter().zip(&bloomed).zip(&pixels) {
            let color = |p: &[f32; 4]| twin::display_color(&parameters, [p[0], p[1], p[2]]);
            let (expected, plain) = (color(light), color(pixel));
            for c in 0..3 {
                let difference = f32::from(found[c]) - expected[c] * 255.0;
                // Half a step of dither, half of rounding; levels are half floats, off by 2^-11 each: half a step in all.
                assert!(difference.abs() <= 1.5, "{size:?}: {found:?} for {expected:?}");
                changed += u32::from((expected[c] - plain[c]).abs() * 255.0 > 3.0);
            }
        }
        assert!(size == [1, 1] || changed > 100, "{changed} channels scattered in {size:?}");
    }
}

/// Without bloom there are neither its passes nor its memory.
#[test]
fn no_bloom_costs_nothing() {
    let gpu = gpu();
    let cost = |bloom: f32| {
        let parameters = CompositorParameters { bloom, ..Default::default() };
        let before = gpu.memory().current();
        let mut compositor = Compositor::new(&gpu, &parameters).unwrap();
        compositor.resize(&gpu, [64, 36]).unwrap();
        let bytes = gpu.memory().current() - before;
        let radiance = Texture::<Radiance>::new(&gpu, [64, 36]).unwrap();
        let display = Display::new(&gpu, [64, 36]).unwrap();
        let mut recorder = Recorder::new(&gpu, Timing::Isolated);
        compositor.record(&gpu, &mut recorder, &radiance, &display);
        let _ = recorder.submit(&gpu).unwrap();
        let passes: Vec<_> = recorder.take_costs(&gpu).into_iter().map(|cost| cost.name).collect();
        (bytes, passes.iter().filter(|name| name.contains("bloom")).count())
    };
    let (without, with) = (cost(0.0), cost(0.1));
    assert_eq!((without.1, with.1), (0, 2));
    // Three levels of half floats, and two of them once more.
    assert_eq!(with.0 - without.0, 8 * (2 * 32 * 18 + 2 * 16 * 9 + 8 * 5));
}
