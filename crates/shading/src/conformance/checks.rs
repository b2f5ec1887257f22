use meniscus_gpu::role::{NO_SURFACE, Radiance};
use serde_json::json;

use super::Frame;
use super::run::Run;
use super::water::{
    SIZE, add_wall, cameras, flat_frame, patterned_frame, pictured_scene, pool_frame, tiled_scene,
    uniform_picture, uniform_scene,
};
use crate::WaterScale;
use crate::twin::brdf::fresnel_dielectric;

type Outcome = Result<(), String>;

/// False for NaN.
fn is_near(found: f32, expected: f32, tolerance: f32) -> bool {
    (found - expected).abs() <= tolerance
}

/// Exact in half precision.
const SCENE: [f32; 4] = [0.25, 0.5, 0.75, 1.0];

pub(super) fn twin(run: &Run<'_>) -> Outcome {
    let model = run.model(&[])?;
    for camera in cameras(SIZE) {
        let plain = patterned_frame(&camera);
        let mut colored = plain.clone();
        // A quarter without colour, a quarter half coloured, the rest coloured.
        colored.surface_color = (0..plain.scene_color.len())
            .map(|i| [0.8, 0.1, 0.3, [0.0, 0.5, 1.0, 1.0][i % SIZE[0] as usize / 10 % 4]])
            .collect();
        let mut pictured = colored.clone();
        pictured.set_scene(pictured_scene());
        let mut dappled = plain.clone();
        dappled.dapple();
        let mut walled = plain.clone();
        add_wall(&mut walled, [0.5, 0.25, 0.125, 1.0]);
        for frame in [plain, colored, pictured, dappled, walled] {
            let (found, expected) = (run.on_gpu(&frame)?, frame.twin(&*model));
            let off = |i: usize| {
                let channel = |c: usize| (found[i][c] - expected[i][c]).abs() / (0.05 + expected[i][c].abs());
                (0..4).map(channel).fold(0.0, f32::max)
            };
            // Rounding: 1e-3 relative, since powers of cosines in highlights amplify the last bits a hundredfold, and that of the
            // stored result. At the rim of the water a last bit decides which pixel a refracted ray samples, and a mirrored ray near the horizon whether
            // it meets the floor: under 1 % of the pixels.
            let tolerance = 1e-3 + Radiance::ROUNDING;
            let wrong: Vec<usize> = (0..found.len()).filter(|&i| !is_near(off(i), 0.0, tolerance)).collect();
            if wrong.len() * 100 > found.len() {
                let first = wrong[0];
                let (place, found, expected) = (frame.place(first), found[first], expected[first]);
                let others = wrong.len() - 1;
                return Err(format!(
                    "the pass makes {found:?} of {place}, the twin {expected:?}; {others} more differ"
                ));
            }
        }
    }
    Ok(())
}

pub(super) fn no_water_is_the_scene(run: &Run<'_>) -> Outcome {
    for camera in cameras(SIZE) {
        let mut frame = patterned_frame(&camera);
        frame.water.distance.fill(NO_SURFACE);
        frame.water.thickness.fill(0.0);
        is_the_scene(&frame, &run.on_gpu(&frame)?, "there is no water")?;
    }
    Ok(())
}

pub(super) fn objects_hide_water(run: &Run<'_>) -> Outcome {
    for camera in cameras(SIZE) {
        let mut frame = pool_frame(&camera, SIZE, &tiled_scene(), SCENE);
        frame.scene_distance.fill(1e-2);
        is_the_scene(&frame, &run.on_gpu(&frame)?, "an object hides all water")?;
        frame.scene_distance.fill(NO_SURFACE);
        if run.on_gpu(&frame)? == frame.scene_color {
            return Err("water in front of the scene is not seen either".into());
        }
    }
    Ok(())
}

fn is_the_scene(frame: &Frame, found: &[[f32; 4]], why: &str) -> Outcome {
    match (0..found.len()).find(|&i| found[i] != frame.scene_color[i]) {
        None => Ok(()),
        Some(i) => Err(format!(
            "{} is {:?} where {why} and the scene has {:?}",
            frame.place(i),
            found[i],
            frame.scene_color[i]
        )),
    }
}

pub(super) fn alpha_is_coverage(run: &Run<'_>) -> Outcome {
    for camera in cameras(SIZE) {
        // Sky behind: alpha is the water's alone.
        let frame = pool_frame(&camera, SIZE, &tiled_scene(), [0.25, 0.5, 0.75, 0.0]);
        for (i, pixel) in run.on_gpu(&frame)?.iter().enumerate() {
            let expected = match frame.water.thickness[i] {
                t if t >= frame.scale.spacing_world => 1.0..=1.0,
                t if t > 0.0 => 0.0..=1.0,
                _ => 0.0..=0.0,
            };
            if !expected.contains(&pixel[3]) {
                let (place, thickness) = (frame.place(i), frame.water.thickness[i]);
                let (alpha, spacing) = (pixel[3], frame.scale.spacing_world);
                return Err(format!(
                    "{place} has alpha {alpha} with {thickness} of water, particles {spacing} apart, and only sky behind"
                ));
            }
        }
    }
    Ok(())
}

pub(super) fn absurd_inputs(run: &Run<'_>) -> Outcome {
    let odd_normals = [0u32, u32::MAX, 0x8000_8000, 0x7fff_7fff, 0x8001_0000];
    for camera in cameras(SIZE) {
        let mut frame = pool_frame(&camera, SIZE, &tiled_scene(), [6e4, 0.0, 1.0, 1.0]);
        frame.scene_distance.fill(NO_SURFACE);
        frame.surface_color = vec![[0.0; 4]; frame.scene_color.len()];
        for i in 0..frame.water.distance.len() {
            frame.water.distance[i] = [1e-3, 5.0, 1e12, 1e30, NO_SURFACE, f32::NAN, 0.0, -1.0][i % 8];
            frame.water.thickness[i] = [0.0, -1.0, 1e-30, 1e6, 1e20, 0.3, f32::NAN, f32::MAX][i % 9 % 8];
            frame.water.normal[i] = odd_normals[i % 7 % 5];
            frame.surface_color[i] = [[0.0; 4], [1.0; 4], [-3.0, 7.0, 1e30, 0.5]][i % 11 % 3];
        }
        let mut walled = frame.clone();
        add_wall(&mut walled, [6e4, 0.0, 1.0, 1.0]);
        for absurd in [0.0, 1e-20, 1.0, 1e20, -1.0, f32::NAN, f32::INFINITY] {
            let scale = WaterScale { depth_world: absurd, spacing_world: absurd, metres_per_world: absurd };
            for frame in [&mut frame, &mut walled] {
                frame.scale = scale;
                let found = run.on_gpu(frame)?;
                let is_sane = |pixel: &[f32; 4]| pixel.iter().all(|c| c.is_finite() && *c >= 0.0);
                if let Some(i) = found.iter().position(|pixel| !is_sane(pixel)) {
                    let (distance, thickness) = (frame.water.distance[i], frame.water.thickness[i]);
                    return Err(format!(
                        "{} is {:?} for a distance of {distance}, a thickness of {thickness}, the normal {:08x}, and a scale \
                         of {absurd}",
                        frame.place(i),
                        found[i],
                        frame.water.normal[i]
                    ));
                }
            }
        }
    }
    Ok(())
}

pub(super) fn deterministic(run: &Run<'_>) -> Outcome {
    for camera in cameras(SIZE) {
        let frame = patterned_frame(&camera);
        let (first, second) = (run.on_gpu(&frame)?, run.on_gpu(&frame)?);
        if let Some(i) = (0..first.len()).find(|&i| first[i].map(f32::to_bits) != second[i].map(f32::to_bits))
        {
            return Err(format!("{} is {:?} once and {:?} then", frame.place(i), first[i], second[i]));
        }
    }
    Ok(())
}

pub(super) fn odd_sizes(run: &Run<'_>) -> Outcome {
    for size in [[1, 1], [1, 7], [33, 1], [13, 9], [1025, 3]] {
        for camera in cameras(size) {
            let frame = pool_frame(&camera, size, &tiled_scene(), SCENE);
            let found = run.on_gpu(&frame)?;
            // -1 is what was there before.
            if let Some(i) = found.iter().position(|pixel| !pixel.iter().all(|c| c.is_finite() && *c >= 0.0))
            {
                return Err(format!("{} is {:?}", frame.place(i), found[i]));
            }
        }
    }
    Ok(())
}

pub(super) fn parameters(run: &Run<'_>) -> Outcome {
    let [camera, _] = cameras(SIZE);
    let frame = patterned_frame(&camera);
    let before = run.on_gpu(&frame)?;
    let unknown = json!({ "no such parameter": 1.0 });
    if run.set(unknown.as_object().unwrap_or(&Default::default())).is_ok() {
        return Err("the pass takes a parameter that it does not have".into());
    }
    if run.draw(&frame)? != before {
        return Err("parameters that the pass refused changed the picture".into());
    }
    Ok(())
}

pub(super) fn fades_with_thickness(run: &Run<'_>) -> Outcome {
    if !run.promises.fades_with_thickness {
        return Ok(());
    }
    for camera in cameras(SIZE) {
        let mut frame = pool_frame(&camera, SIZE, &tiled_scene(), SCENE);
        frame.water.thickness.iter_mut().for_each(|t| *t = t.min(1e-5));
        for (i, pixel) in run.on_gpu(&frame)?.iter().enumerate() {
            // 1e-3: the soft edge at a thousandth of its width, times a radiance of at most some tens.
            if (0..3).any(|c| (pixel[c] - SCENE[c]).abs() > 1e-3) {
                let place = frame.place(i);
                return Err(format!("{place} is {pixel:?} where water is 1e-5 thick over {SCENE:?}"));
            }
        }
    }
    Ok(())
}

pub(super) fn makes_no_light(run: &Run<'_>) -> Outcome {
    if !run.promises.makes_no_light {
        return Ok(());
    }
    for camera in cameras(SIZE) {
        let frame = pool_frame(&camera, SIZE, &uniform_scene(1.0), [1.0; 4]);
        let mut pictured = frame.clone();
        pictured.set_scene(uniform_picture(1.0));
        let mut walled = frame.clone();
        add_wall(&mut walled, [1.0; 4]);
        let bound = |image: Vec<[f32; 4]>, low: f32, what: &str| {
            // 2e-3: irradiance by quadrature, and sums of weights in f32.
            let off = |pixel: &[f32; 4]| pixel[..3].iter().any(|c| !(low - 2e-3..=1.0 + 2e-3).contains(c));
            match image.iter().position(off) {
                None => Ok(()),
                Some(i) => {
                    Err(format!("{} is {:?} in surroundings of radiance 1{what}", frame.place(i), image[i]))
                }
            }
        };
        for frame in [&frame, &pictured, &walled] {
            bound(run.on_gpu(frame)?, 0.0, "")?;
            if run.promises.reflects_by_fresnel {
                // Nothing absorbs: nothing may get lost either.
                let clear = [("attenuation_scale", json!(0.0))];
                bound(run.changed_on_gpu(frame, &clear)?, 1.0, ", without absorption")?;
            }
        }
    }
    Ok(())
}

pub(super) fn fresnel(run: &Run<'_>) -> Outcome {
    if !run.promises.reflects_by_fresnel {
        return Ok(());
    }
    for index in [1.333, 1.5] {
        let clear = [
            ("attenuation_scale", json!(0.0)),
            ("turbidity", json!(0.0)),
            ("additional_reflection", json!(0.0)),
            ("refractive_index", json!(index)),
        ];
        // The last one is beyond what models bend towards the eye; reflectance there is only known to be high.
        for degrees in [0.0f32, 20.0, 45.0, 60.0, 75.0, 85.0, 89.9] {
            let angle = degrees.to_radians();
            let expected = fresnel_dielectric(angle.cos(), index as f32);
            // Normals of 16 bits, whose cosine is off by up to 5e-5, times the slope at grazing, and the rounding of the result.
            let tolerance = if degrees > 87.0 { 0.25 } else { 1e-3 + Radiance::ROUNDING };
            // Bright surroundings over a dark scene show what is reflected, the other way round what comes through.
            for (around, behind, share) in [(1.0, 0.0, expected), (0.0, 1.0, 1.0 - expected)] {
                let frame = flat_frame(&uniform_scene(around), angle, |_| 1.0, behind);
                let found = run.changed_on_gpu(&frame, &clear)?;
                let middle = found[found.len() / 2];
                if middle[..3].iter().any(|c| !is_near(*c, share, tolerance)) {
                    let what = if behind > 0.0 { "comes through" } else { "is reflected" };
                    return Err(format!(
                        "at {degrees} degrees to the normal of water with index {index}, {middle:?} {what} of 1, {share} \
                         was expected"
                    ));
                }
            }
        }
    }
    Ok(())
}

pub(super) fn beer_lambert(run: &Run<'_>) -> Outcome {
    if !run.promises.absorbs_by_beer_lambert {
        return Ok(());
    }
    let sigma = [1.5, 0.5, 0.1];
    let changes = [
        ("attenuation_color", json!(sigma)),
        ("attenuation_depth", json!(1.0)),
        ("attenuation_scale", json!(1.0)),
        ("turbidity", json!(0.0)),
    ];
    // Dark surroundings: nothing on top of what comes through. The wedge against a plate, pixel by pixel.
    let thickness = |column: usize| 0.1 + 0.02 * column as f32;
    let [wedge, plate] = [0.02, 0.0]
        .map(|rise| flat_frame(&uniform_scene(0.0), 0.0, |column| thickness(0) + rise * column as f32, 1.0));
    let model = run.model(&changes)?;
    for (who, wedge, plate, rounding) in [
        (
            "pass",
            run.changed_on_gpu(&wedge, &changes)?,
            run.changed_on_gpu(&plate, &changes)?,
            Radiance::ROUNDING,
        ),
        ("twin", wedge.twin(&*model), plate.twin(&*model), 0.0),
    ] {
        let row = (SIZE[1] / 2 * SIZE[0]) as usize;
        for column in 10..SIZE[0] as usize {
            for c in 0..3 {
                let (thin, thick) = (plate[row + column][c], wedge[row + column][c]);
                let more = thickness(column) - thickness(0);
                let slope = (thin / thick).ln() / more;
                // 1e-3: logarithms of quotients near 1 in f32, over the smallest difference of thickness. Both of the quotient
                // are rounded.
                if !is_near(slope, sigma[c], 1e-3 + 2.0 * rounding / more) {
                    let t = thickness(column);
                    return Err(format!(
                        "channel {c} of the {who} falls by {slope} per length up to {t} of water, {} was asked for",
                        sigma[c]
                    ));
                }
            }
        }
    }
    Ok(())
}

pub(super) fn shows_attributes(run: &Run<'_>) -> Outcome {
    if !run.promises.shows_attributes {
        return Ok(());
    }
    let [camera, _] = cameras(SIZE);
    let mut frame = pool_frame(&camera, SIZE, &tiled_scene(), SCENE);
    let mut mean = |color: [f32; 4]| -> Result<[f32; 3], String> {
        frame.surface_color = vec![color; frame.scene_color.len()];
        let image = run.on_gpu(&frame)?;
        let water: Vec<_> = image.iter().zip(&frame.water.thickness).filter(|(_, t)| **t > 0.1).collect();
        Ok([0, 1, 2].map(|c| water.iter().map(|(pixel, _)| pixel[c]).sum::<f32>() / water.len() as f32))
    };
    let none = mean([1.0, 0.0, 0.0, 0.0])?;
    if none != mean([0.0, 0.0, 1.0, 0.0])? {
        return Err("a colour of alpha 0 changes the picture".into());
    }
    let (red, blue) = (mean([1.0, 0.0, 0.0, 1.0])?, mean([0.0, 0.0, 1.0, 1.0])?);
    // A fifth apart: what can be told from each other in any light.
    if red[0] - blue[0] < 0.2 || blue[2] - red[2] < 0.2 {
        return Err(format!("water that an attribute makes red is {red:?} on average, blue one {blue:?}"));
    }
    Ok(())
}
