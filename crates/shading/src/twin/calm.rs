//! Twin of `meniscus::calm` and of `shaders/shading/calm_normals.wgsl`, whose blocks it works out where it needs them.

use glam::{IVec2, Vec2, Vec3};

use super::view::{is_empty, px_per_world, unpack_normal, view_position};
use super::water::center_px;
use super::{TwinInput, smoothstep};
use crate::calm::BLOCK_PX;

const SAME: f32 = 0.94;
const OTHER: f32 = 0.82;
const STEP_SPACINGS: f32 = 1.3;
const SIGMA_STEPS: f32 = 1.3;
const MOST_STEP_PX: f32 = 1e4;
const RANGE_SPACINGS: f32 = 0.5;
const RIDGE: f32 = 1.2;

fn water_at(input: &TwinInput<'_>, pixel: IVec2) -> Option<f32> {
    let is_inside = pixel.cmpge(IVec2::ZERO).all() && pixel.cmplt(input.size()).all();
    is_inside.then(|| input.distance[input.index(pixel)]).filter(|&d| d > 0.0 && !is_empty(d))
}

fn fitted_normal(input: &TwinInput<'_>, pixel: IVec2, distance: f32, spacing_world: f32) -> Vec3 {
    let position_at = |at: IVec2, d| view_position(input.camera, at.as_vec2() + 0.5, d);
    let position = position_at(pixel, distance);
    let normal = unpack_normal(input.normal[input.index(pixel)]);
    let across = normal.cross(if normal.x.abs() > 0.7 { Vec3::Y } else { Vec3::X }).normalize();
    let along = normal.cross(across);
    let px = px_per_world(input.camera, distance);
    let step_px = (STEP_SPACINGS * spacing_world * px).clamp(1.0, MOST_STEP_PX) as i32;
    let step_world = step_px as f32 / px;
    let range = RANGE_SPACINGS * spacing_world.max(1e-6 * distance);

    let (mut weight_sum, mut place_sum, mut height_sum) = (0.0, Vec2::ZERO, 0.0);
    let (mut place_squares, mut place_heights) = (Vec3::ZERO, Vec2::ZERO);
    for offset in (-2i32..=2).flat_map(|y| (y.abs() - 2..=2 - y.abs()).map(move |x| IVec2::new(x, y))) {
        let at = pixel + step_px * offset;
        let Some(other) = water_at(input, at) else { continue };
        let away = (position_at(at, other) - position) / step_world;
        let height = normal.dot(away);
        let near = (-0.5 / (SIGMA_STEPS * SIGMA_STEPS) * offset.length_squared() as f32).exp();
        let weight = near * (2.0 - height.abs() * step_world / range).clamp(0.0, 1.0);
        if weight <= 0.0 {
            continue;
        }
        let place = Vec2::new(across.dot(away), along.dot(away));
        weight_sum += weight;
        place_sum += weight * place;
        height_sum += weight * height;
        place_squares += weight * Vec3::new(place.x * place.x, place.x * place.y, place.y * place.y);
        place_heights += weight * height * place;
    }
    let mean = place_sum / weight_sum;
    let xx = place_squares.x - mean.x * place_sum.x + RIDGE;
    let xy = place_squares.y - mean.x * place_sum.y;
    let yy = place_squares.z - mean.y * place_sum.y + RIDGE;
    let products = place_heights - mean * height_sum;
    let slope =
        Vec2::new(yy * products.x - xy * products.y, xx * products.y - xy * products.x) / (xx * yy - xy * xy);
    (normal - slope.x * across - slope.y * along).normalize()
}

fn block_normal(input: &TwinInput<'_>, block: IVec2, spacing_world: f32) -> Vec3 {
    let side = BLOCK_PX as i32;
    let inner = side * block + side / 2 - 1;
    (0..4)
        .map(|k| inner + IVec2::new(k & 1, k >> 1))
        .find_map(|pixel| Some(fitted_normal(input, pixel, water_at(input, pixel)?, spacing_world)))
        .unwrap_or(Vec3::NEG_Z)
}

/// Calm normals of a pixel and of those to its right and below it; not of unit length.
pub(super) struct Calm {
    pub own: Vec3,
    pub right: Vec3,
    pub below: Vec3,
}

fn calming(block: Vec3, own: Vec3, share: Vec2) -> Vec3 {
    share.x * share.y * smoothstep(OTHER, SAME, block.dot(own)) * (block - own)
}

/// Of a pixel whose own normal is the unit vector `normal_view`, which changes by `to_right` and `to_below` from pixel to pixel.
pub(super) fn calmed(
    input: &TwinInput<'_>,
    pixel: [u32; 2],
    normal_view: Vec3,
    [to_right, to_below]: [Vec3; 2],
    spacing_world: f32,
) -> Calm {
    let corner = center_px(pixel) / BLOCK_PX as f32 - 0.5;
    let base = corner.floor();
    let f = corner - base;
    let last = (input.size() - 1) / BLOCK_PX as i32;
    let (right, below) = (normal_view + to_right, normal_view + to_below);
    let mut calm = Calm { own: normal_view, right, below };
    for offset in [IVec2::ZERO, IVec2::X, IVec2::Y, IVec2::ONE] {
        let block = (base.as_ivec2() + offset).clamp(IVec2::ZERO, last);
        let normal = block_normal(input, block, spacing_world);
        let along = |axis: usize| if offset[axis] == 1 { f[axis] } else { 1.0 - f[axis] };
        let share = Vec2::new(along(0), along(1));
        let growth = (2.0 * offset.as_vec2() - 1.0) / BLOCK_PX as f32;
        calm.own += calming(normal, normal_view, share);
        calm.right += calming(normal, right, share + Vec2::new(growth.x, 0.0));
        calm.below += calming(normal, below, share + Vec2::new(0.0, growth.y));
    }
    calm
}

#[cfg(test)]
mod tests {
    use glam::{Mat4, Vec4};
    use meniscus_core::{Aabb, Camera, UpAxis};
    use meniscus_gpu::CameraUniform;
    use meniscus_gpu::role::NO_SURFACE;
    use meniscus_scene::Scene;

    use super::*;
    use crate::conformance::{Frame, Water, cast};

    const SIZE: [u32; 2] = [160, 160];
    const SPACING: f32 = 0.05;

    fn camera() -> Camera {
        let corners = [Vec3::ZERO, Vec3::ONE];
        Camera::fit(&corners, Vec3::new(-0.4, -0.6, -0.8), Vec3::Y, 0.8, SIZE, 0.9)
    }

    /// The normals, own and calm, of the pixels that show water, in world space.
    fn normals(water: Water) -> Vec<(Vec3, Vec3)> {
        let scene = Scene::around(Aabb::EMPTY, UpAxis::Y, 0.0);
        let mut frame = Frame::plain(&camera(), SIZE, &scene, water, [1.0; 4], NO_SURFACE);
        frame.scale.spacing_world = SPACING;
        let to_world = Mat4::from_cols_array_2d(&frame.camera.world_from_view);
        let of = |is_calm: bool| {
            frame.on_host(|input, pixel| {
                let index = input.pixel_index(pixel);
                if is_empty(input.distance[index]) {
                    return [0.0; 4];
                }
                let own = unpack_normal(input.normal[index]);
                let normal = if is_calm {
                    calmed(input, pixel, own, [Vec3::ZERO; 2], SPACING).own.normalize()
                } else {
                    own
                };
                to_world.transform_vector3(normal).extend(1.0).to_array()
            })
        };
        let pairs = of(false).into_iter().zip(of(true)).filter(|(own, _)| own[3] > 0.0);
        pairs.map(|(own, calm)| (Vec4::from(own).truncate(), Vec4::from(calm).truncate())).collect()
    }

    fn water(surface: impl Fn(Vec3) -> f32) -> Water {
        let bounds = Aabb { min: Vec3::splat(-0.1), max: Vec3::splat(1.1) };
        cast(&CameraUniform::new(&camera(), SIZE), bounds, 0.01, surface)
    }

    fn rms_degrees(pairs: &[(Vec3, Vec3)], of: impl Fn(&(Vec3, Vec3)) -> Vec3, expected: Vec3) -> f32 {
        let squares = pairs.iter().map(|pair| of(pair).angle_between(expected).to_degrees().powi(2));
        (squares.sum::<f32>() / pairs.len() as f32).sqrt()
    }

    #[test]
    fn planes_keep_their_normals_up_to_their_borders() {
        let plane = Vec3::new(0.3, 1.0, 0.2).normalize();
        let pairs = normals(water(|p| plane.dot(p - Vec3::splat(0.5))));
        assert!(pairs.len() > 1000, "{}", pairs.len());
        for (own, calm) in pairs {
            // Half a degree: the cast finds the surface to within a few thousandths of a spacing.
            assert!(own.angle_between(calm).to_degrees() < 0.5, "{own} became {calm}");
        }
    }

    #[test]
    fn bumps_of_three_spacings_go_and_waves_of_thirty_stay() {
        // Heights are such that both are up to two degrees steep.
        let wave = |spacings: f32| {
            let k = std::f32::consts::TAU / (spacings * SPACING);
            let pairs = normals(water(move |p| p.y - 0.5 - 0.035 / k * (k * p.x).sin() * (k * p.z).cos()));
            [rms_degrees(&pairs, |pair| pair.0, Vec3::Y), rms_degrees(&pairs, |pair| pair.1, Vec3::Y)]
        };
        let [bumps, calmed_bumps] = wave(3.0);
        assert!(calmed_bumps < 0.35 * bumps, "bumps of {bumps} degrees became {calmed_bumps}");
        let [waves, calmed_waves] = wave(30.0);
        assert!(calmed_waves > 0.8 * waves, "waves of {waves} degrees became {calmed_waves}");
    }

    #[test]
    fn edges_stay_where_they_are() {
        let pairs = normals(water(|p| ((p - 0.5).abs() - Vec3::new(0.5, 0.3, 0.4)).max_element()));
        // Within a pixel or two of an edge a pixel's own normal is none of the three sides'.
        let sound: Vec<_> = pairs.iter().filter(|(own, _)| own.abs().max_element() > 0.999).collect();
        assert!(sound.len() > 1000, "{}", sound.len());
        for (own, calm) in sound {
            assert!(own.angle_between(*calm).to_degrees() < 10.0, "{own} became {calm}");
        }
    }
}
