//! The model on the CPU: what its pass is tested against.

use glam::{Mat4, Vec2, Vec3, Vec4};
use meniscus_gpu::role::NO_SURFACE;
use meniscus_shading::twin::TwinInput;

use crate::{ChartUniform, STOPS};

/// Radiance and coverage of one pixel.
pub fn shade_pixel(chart: &ChartUniform, input: &TwinInput<'_>, pixel: [u32; 2]) -> [f32; 4] {
    let index = (pixel[1] * input.camera.size_px[0] + pixel[0]) as usize;
    let distance = input.distance[index];
    let thickness = input.thickness[index];
    let shown = 0.0..input.scene_distance[index].min(NO_SURFACE);
    if distance <= 0.0 || !shown.contains(&distance) || thickness.is_nan() || thickness <= 0.0 {
        return input.scene_color[index];
    }
    let world_from_view = Mat4::from_cols_array_2d(&input.camera.world_from_view);
    let normal = world_from_view.transform_vector3(unpack_normal(input.normal[index]));
    let facing_sun = 0.5 + 0.5 * normal.dot(input.surroundings.sky.sun_direction.into());
    let light = 0.25 + 0.75 * facing_sun;
    let ink = 1.0 - 0.75 * contour(chart, input, pixel.map(|c| c as i32), thickness);
    let color = map_color(chart, thickness) * (1.0 + (light - 1.0) * chart.relief) * ink;
    color.extend(1.0).to_array()
}

/// The colour map, linear between its stops.
fn map_color(chart: &ChartUniform, thickness: f32) -> Vec3 {
    let place = (thickness / chart.depth_world).clamp(0.0, 1.0) * (STOPS - 1) as f32;
    let stop = (place as usize).min(STOPS - 2);
    let [low, high] = [stop, stop + 1].map(|stop| Vec4::from(chart.map[stop]).truncate());
    low.lerp(high, place - stop as f32)
}

/// How much of a pixel a contour line covers: the distance to it in pixels is the difference of thickness over its change
/// per pixel.
fn contour(chart: &ChartUniform, input: &TwinInput<'_>, at: [i32; 2], thickness: f32) -> f32 {
    let per_px = Vec2::new(slope(input, at, [1, 0]), slope(input, at, [0, 1])).length();
    if chart.step_world <= 0.0 || per_px < 1e-6 * chart.step_world {
        return 0.0;
    }
    let nearest = (thickness / chart.step_world).round_ties_even().max(1.0) * chart.step_world;
    let off_px = (thickness - nearest).abs() / per_px;
    let room = chart.step_world / (per_px * chart.line_px * 4.0);
    let t = ((room - 0.25) / 0.75).clamp(0.0, 1.0);
    (0.5 * chart.line_px + 0.5 - off_px).clamp(0.0, 1.0) * t * t * (3.0 - 2.0 * t)
}

/// Change of thickness per pixel along an axis: over both neighbours, or the one that is water.
fn slope(input: &TwinInput<'_>, at: [i32; 2], axis: [i32; 2]) -> f32 {
    let size = input.camera.size_px.map(|side| side as i32);
    let water = |[x, y]: [i32; 2]| {
        let inside = (0..size[0]).contains(&x) && (0..size[1]).contains(&y);
        inside.then(|| (y * size[0] + x) as usize).filter(|&i| input.distance[i] < NO_SURFACE)
    };
    let here = (at[1] * size[0] + at[0]) as usize;
    let after = water([at[0] + axis[0], at[1] + axis[1]]);
    let before = water([at[0] - axis[0], at[1] - axis[1]]);
    let apart = u8::from(after.is_some()) + u8::from(before.is_some());
    let rise = input.thickness[after.unwrap_or(here)] - input.thickness[before.unwrap_or(here)];
    rise / f32::from(apart.max(1))
}

/// Unit vector from its octahedral map in two snorm16; `meniscus::surface::unpack_normal`.
fn unpack_normal(bits: u32) -> Vec3 {
    let snorm = |half: u32| (f32::from(half as u16 as i16) / 32767.0).max(-1.0);
    let p = Vec2::new(snorm(bits), snorm(bits >> 16));
    let z = 1.0 - p.x.abs() - p.y.abs();
    let fold = (-z).max(0.0);
    let sign = |x: f32| if x >= 0.0 { 1.0 } else { -1.0 };
    Vec3::new(p.x - fold * sign(p.x), p.y - fold * sign(p.y), z).normalize()
}
