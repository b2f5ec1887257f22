//! Pictures that are the mean of several.

use meniscus_tests::{Pixels, Program};

use crate::program_with_dam;

fn picture(program: &Program, flags: &str) -> Pixels {
    program.run(&format!("render dam/dam_break.pvd --frame 1 {flags} -o p.png")).ok();
    Pixels::read(&program.path("p.png"))
}

/// Sixteen samples a pixel come nearer to sixty-four than a single one does, in any format: how much of a pixel spheres cover.
/// (Water is another surface where pixels are smaller.)
#[test]
fn samples_smooth_edges() {
    let program = program_with_dam(3000, 3);
    let spheres = "--size 160x90 --set 'water=id >= 0:spheres' --param scene.floor=false --transparent";
    let coverage = |flags: &str| -> Vec<f64> {
        let pixels = picture(&program, &format!("{spheres} {flags}"));
        pixels.rgba.iter().map(|p| f64::from(p[3]) / 255.0).collect()
    };
    let reference = coverage("--supersample 8");
    let error = |flags: &str| -> f64 {
        std::iter::zip(coverage(flags), &reference).map(|(a, b)| (a - b).powi(2)).sum()
    };
    let (one, sixteen) = (error("--param post.anti_aliasing=false"), error("--samples 16"));
    assert!(sixteen < 0.1 * one, "{sixteen} against {one}");
    let outcome =
        program.run(&format!("render dam/dam_break.pvd --frame 1 {spheres} --bits 16 -o p.png")).ok();
    assert!(outcome.stderr.contains("add --samples"), "{outcome:#?}");
    let deep = error("--samples 16 --bits 16");
    assert!((deep / sixteen - 1.0).abs() < 0.1, "{deep} against {sixteen}");
}

/// Along a tiled floor with a drop of water on it.
const FLOOR: &str = "--camera '0.8,-3,0.4/0.8,0,0.1/0,0,1/40'";

/// Contrast between neighbouring pixels, summed up over a part of the rows.
fn sharpness(pixels: &Pixels, rows: std::ops::Range<usize>) -> f64 {
    let width = pixels.size[0] as usize;
    let light = |i: usize| pixels.rgba[i][..3].iter().map(|c| f64::from(*c)).sum::<f64>();
    let pairs = rows.flat_map(|y| (1..width).map(move |x| y * width + x));
    pairs.map(|i| (light(i) - light(i - 1)).powi(2)).sum()
}

/// Looking along the tiled floor, what is in focus stays sharp and what is not blurs.
#[test]
fn a_lens_blurs_what_is_out_of_focus() {
    let program = program_with_dam(300, 3);
    let picture = |lens: &str| picture(&program, &format!("--size 200x120 {FLOOR} --samples 24 {lens}"));
    let (sharp, near, far) =
        (picture(""), picture("--aperture 0.1 --focus 1.2"), picture("--aperture 0.1 --focus 8"));
    // Upper rows of the floor are far, lower ones near.
    let (upper, lower) = (30..50, 100..120);
    let kept = |blurred: &Pixels, rows: &std::ops::Range<usize>| {
        sharpness(blurred, rows.clone()) / sharpness(&sharp, rows.clone())
    };
    assert!(
        kept(&near, &lower) > 0.55 && kept(&near, &upper) < 0.4,
        "{} {}",
        kept(&near, &lower),
        kept(&near, &upper)
    );
    assert!(
        kept(&far, &upper) > 0.35 && kept(&far, &lower) < 0.2,
        "{} {}",
        kept(&far, &upper),
        kept(&far, &lower)
    );
}
