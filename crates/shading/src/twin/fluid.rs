//! Twin of `shaders/shading/fluid.wgsl`.

use std::f32::consts::{LOG2_E, PI};

use glam::{IVec2, Vec2, Vec3, Vec4};

use super::brdf::{fresnel_dielectric, ggx};
use super::surroundings::{surroundings_radiance, trace_floor};
use super::view::{
    is_empty, point_to_world, project_px, px_per_world, to_world, towards_eye, unpack_normal, view_position,
};
use super::{TwinInput, mix, smoothstep};
use crate::WaterShadow;
use crate::models::FluidUniform;

const MARCH_STEPS: i32 = 4;
const BISECTIONS: i32 = 4;
const MIN_PATH_COSINE: f32 = 0.3;
const MIN_N_V: f32 = 0.03;
const STENCIL_SPACINGS: f32 = 0.3;
const MAX_STENCIL_PX: f32 = 4.0;
const EDGE_SPREAD: f32 = 0.5;
const DROP_SPACINGS: f32 = 1.6;
const MAX_DROP_PX: f32 = 64.0;
const MAX_SHADOW: f32 = 0.55;
const SHADOW_TINT: f32 = 0.7;
const INTERNAL_REFLECTANCE: f32 = 0.48;
const WET_SHARE: f32 = 0.7;
const MAX_GLINT: f32 = 6.0;

struct WaterPoint {
    position_view: Vec3,
    normal_view: Vec3,
    to_eye_view: Vec3,
    distance: f32,
    n_v: f32,
}

fn water_point(input: &TwinInput<'_>, pixel: [u32; 2], distance: f32, normal_view: Vec3) -> WaterPoint {
    let center = Vec2::new(pixel[0] as f32, pixel[1] as f32) + 0.5;
    let position_view = view_position(input.camera, center, distance);
    let to_eye_view = towards_eye(input.camera, position_view);
    let size = normal_view.length();
    let mut normal_view = if size > 1e-3 { normal_view / size } else { to_eye_view };
    let facing = normal_view.dot(to_eye_view);
    if facing < MIN_N_V {
        normal_view = (normal_view + (MIN_N_V - facing) * to_eye_view).normalize();
    }
    let n_v = normal_view.dot(to_eye_view).clamp(MIN_N_V, 1.0);
    WaterPoint { position_view, normal_view, to_eye_view, distance, n_v }
}

fn refract(incident: Vec3, normal: Vec3, eta: f32) -> Vec3 {
    let c = normal.dot(incident);
    let k = 1.0 - eta * eta * (1.0 - c * c);
    if k < 0.0 { Vec3::ZERO } else { eta * incident - (eta * c + k.sqrt()) * normal }
}

impl TwinInput<'_> {
    fn index(&self, at: IVec2) -> usize {
        at.y as usize * self.camera.size_px[0] as usize + at.x as usize
    }

    fn clamped(&self, at: IVec2) -> usize {
        self.index(at.clamp(IVec2::ZERO, self.size() - 1))
    }

    fn size(&self) -> IVec2 {
        IVec2::new(self.camera.size_px[0] as i32, self.camera.size_px[1] as i32)
    }

    fn inside(&self, px: Vec2) -> bool {
        px.cmpge(Vec2::ZERO).all() && px.cmplt(self.size().as_vec2()).all()
    }

    fn scene_rgb(&self, index: usize) -> Vec3 {
        Vec4::from(self.scene_color[index]).truncate()
    }
}

fn clearance(input: &TwinInput<'_>, position_view: Vec3, water_distance: f32, limit: f32) -> f32 {
    let px = project_px(input.camera, position_view);
    if !input.inside(px) {
        return limit;
    }
    let scene = input.scene_distance[input.index(px.as_ivec2())];
    if scene < water_distance { limit } else { (scene + position_view.z).clamp(-limit, limit) }
}

fn smooth_clearance(input: &TwinInput<'_>, position_view: Vec3, water_distance: f32, limit: f32) -> f32 {
    let px = project_px(input.camera, position_view);
    if !input.inside(px) {
        return limit;
    }
    let base = (px - 0.5).floor();
    let f = px - 0.5 - base;
    let corners = [IVec2::ZERO, IVec2::X, IVec2::Y, IVec2::ONE];
    let d = corners.map(|offset| input.scene_distance[input.clamped(base.as_ivec2() + offset)]);
    let weights = [(1.0 - f.x) * (1.0 - f.y), f.x * (1.0 - f.y), (1.0 - f.x) * f.y, f.x * f.y];
    let mean = |of: fn(f32) -> f32| d.iter().zip(weights).map(|(&d, w)| w * of(d)).sum::<f32>();
    let scene = if input.camera.orthographic != 0 {
        mean(|d| d.min(1e30))
    } else {
        1.0 / mean(|d| 1.0 / d).max(1e-30)
    };
    let in_front = d.iter().any(|&d| d < water_distance);
    if in_front { limit } else { (scene + position_view.z).clamp(-limit, limit) }
}

/// Where the march along the refracted ray ends.
struct March {
    length_world: f32,
    seen_world: f32,
}

fn trace_path(input: &TwinInput<'_>, water: &WaterPoint, direction: Vec3, reach: f32) -> March {
    let at = |s: f32| water.position_view + s * direction;
    let gap_at = |s: f32| clearance(input, at(s), water.distance, reach);
    let step_world = reach / MARCH_STEPS as f32;
    let (mut seen, mut seen_gap) = (0.0, reach);
    let mut hidden = false;
    for i in 1..=MARCH_STEPS {
        let end = step_world * i as f32;
        let end_gap = gap_at(end);
        if end_gap < 0.0 && !hidden {
            let (mut far, mut far_gap) = (end, end_gap);
            for _ in 0..BISECTIONS {
                let middle = 0.5 * (seen + far);
                let gap = gap_at(middle);
                if gap < 0.0 {
                    (far, far_gap) = (middle, gap);
                } else {
                    (seen, seen_gap) = (middle, gap);
                }
            }
            if seen_gap - far_gap <= 0.5 * step_world {
                let per_gap = (far - seen) / (seen_gap - far_gap);
                let s = seen + seen_gap * per_gap;
                let gap = smooth_clearance(input, at(s), water.distance, reach);
                let met = (s + gap * per_gap).clamp(seen, far);
                return March { length_world: met, seen_world: met };
            }
        }
        hidden = end_gap < 0.0;
        if !hidden {
            (seen, seen_gap) = (end, end_gap);
        }
    }
    March { length_world: reach, seen_world: seen }
}

fn background(input: &TwinInput<'_>, px: Vec2, nearest_distance: f32, fallback: Vec3) -> Vec3 {
    let corner = px - 0.5;
    let base = corner.floor();
    let f = corner - base;
    let (mut sum, mut total) = (Vec3::ZERO, 0.0);
    for k in 0..4 {
        let offset = IVec2::new(k & 1, k >> 1);
        let at = input.clamped(base.as_ivec2() + offset);
        let along = |axis: usize| if offset[axis] == 1 { f[axis] } else { 1.0 - f[axis] };
        if input.scene_distance[at] >= nearest_distance {
            let weight = along(0) * along(1) + 1e-4;
            sum += weight * input.scene_rgb(at);
            total += weight;
        }
    }
    if total > 0.0 { sum / total } else { fallback }
}

/// The normals around a pixel.
struct Neighbourhood {
    normal_sum: Vec3,
    spread: f32,
    isolation: f32,
}

fn neighbourhood(
    fluid: &FluidUniform,
    input: &TwinInput<'_>,
    pixel: [u32; 2],
    distance: f32,
) -> Neighbourhood {
    let spacing_px = fluid.spacing_world * px_per_world(input.camera, distance);
    let stride_px = (STENCIL_SPACINGS * spacing_px).clamp(1.0, MAX_STENCIL_PX).floor();
    let at = IVec2::new(pixel[0] as i32, pixel[1] as i32);
    let offsets = [IVec2::NEG_X, IVec2::X, IVec2::NEG_Y, IVec2::Y];
    let center = unpack_normal(input.normal[input.index(at)]);
    let (mut sum, mut spread) = (center, 0.0);
    for offset in offsets {
        let index = input.clamped(at + stride_px as i32 * offset);
        let same = (input.distance[index] - distance).abs() <= 2.0 * fluid.spacing_world;
        let normal = if same { unpack_normal(input.normal[index]) } else { center };
        sum += normal;
        spread += 0.25 * if same { normal.distance_squared(center) } else { EDGE_SPREAD };
    }
    let far_px = (DROP_SPACINGS * spacing_px).clamp(2.0, MAX_DROP_PX) as i32;
    let position = |at: IVec2, d| view_position(input.camera, at.as_vec2() + 0.5, d);
    let here = position(at, distance);
    let half_way = sum / sum.length().max(1e-3) + towards_eye(input.camera, here);
    let plane = half_way / half_way.length().max(1e-3);
    let mut isolation = 0.0;
    for offset in offsets {
        let at = (at + far_px * offset).clamp(IVec2::ZERO, input.size() - 1);
        let other = input.distance[input.index(at)].min(2.0 * distance);
        let below = plane.dot(here - position(at, other));
        let soft = fluid.spacing_world.max(1e-6 * distance);
        isolation += 0.25 * (below / soft - 1.0).clamp(0.0, 1.0);
    }
    Neighbourhood { normal_sum: sum, spread, isolation }
}

fn sun_path(input: &TwinInput<'_>, px: Vec2) -> f32 {
    let size = WaterShadow::size_blocks(input.camera.size_px);
    let last = IVec2::new(size[0] as i32, size[1] as i32) - 1;
    let corner = px / WaterShadow::BLOCK_PX as f32 - 0.5;
    let base = corner.floor();
    let f = corner - base;
    let low = base.as_ivec2().clamp(IVec2::ZERO, last);
    let high = (base.as_ivec2() + 1).clamp(IVec2::ZERO, last);
    let at = |x: i32, y: i32| input.sun_path[y as usize * size[0] as usize + x as usize];
    let row = |y: i32| at(low.x, y) * (1.0 - f.x) + at(high.x, y) * f.x;
    row(low.y) * (1.0 - f.y) + row(high.y) * f.y
}

fn shadow(fluid: &FluidUniform, input: &TwinInput<'_>, px: Vec2) -> Vec3 {
    let path = sun_path(input, px);
    if path <= 0.0 {
        return Vec3::ONE;
    }
    let sky = &input.surroundings.sky;
    let sun = Vec3::from(sky.sun_irradiance) * Vec3::from(sky.sun_direction).dot(sky.up.into()).max(0.0);
    let share = sun / (sun + Vec3::from(sky.irradiance_up)).max(Vec3::splat(1e-30));
    let absorption = Vec3::from(fluid.absorption);
    let tinted = mix(Vec3::splat(absorption.element_sum() / 3.0), absorption, SHADOW_TINT);
    let extinction = tinted + fluid.scattering + fluid.shadow_extinction;
    1.0 - MAX_SHADOW * share * (1.0 - (-LOG2_E * extinction * path).map(f32::exp2))
}

/// The refracted path in the water.
struct Path {
    length_world: f32,
    to_floor_world: f32,
    end_px: Vec2,
    nearest_distance: f32,
}

fn refracted_path(fluid: &FluidUniform, input: &TwinInput<'_>, water: &WaterPoint, thickness: f32) -> Path {
    let incident = -water.to_eye_view;
    let bent = refract(incident, water.normal_view, 1.0 / fluid.refractive_index);
    let direction = mix(incident, bent, fluid.refraction_scale).normalize();
    let position = point_to_world(input.camera, water.position_view);
    let floor_reach = trace_floor(input.surroundings, position, to_world(input.camera, direction));
    let reach = (thickness.max(0.0) / direction.dot(incident).max(MIN_PATH_COSINE)).min(floor_reach);
    let march = trace_path(input, water, direction, reach);
    let end = water.position_view + march.seen_world * direction;
    let hidden = march.seen_world < march.length_world;
    let tolerance = if hidden { 0.0 } else { fluid.spacing_world + 0.25 * march.seen_world };
    Path {
        length_world: march.length_world,
        to_floor_world: floor_reach - march.length_world,
        end_px: project_px(input.camera, end).clamp(Vec2::ZERO, input.size().as_vec2()),
        nearest_distance: (-end.z - tolerance).max(water.distance),
    }
}

fn wet(fluid: &FluidUniform, input: &TwinInput<'_>, path: &Path) -> f32 {
    let albedo = Vec3::from(input.surroundings.floor.color).element_sum() / 3.0;
    let ratio = (1.0 - INTERNAL_REFLECTANCE) / (1.0 - INTERNAL_REFLECTANCE * albedo);
    let near = fluid.spacing_world + 0.2 * path.length_world;
    let begin = smoothstep(0.0, 1.5 * fluid.spacing_world + 1e-30, path.length_world);
    let contact = WET_SHARE * begin * (1.0 - smoothstep(near, 2.0 * near + 1e-30, path.to_floor_world));
    1.0 - contact + ratio * contact
}

fn transmitted(fluid: &FluidUniform, input: &TwinInput<'_>, behind: Vec3, path_world: f32) -> Vec3 {
    let extinction = Vec3::from(fluid.absorption) + fluid.scattering;
    let transmittance = (-LOG2_E * extinction * path_world).map(f32::exp2);
    let sky = &input.surroundings.sky;
    let light = (Vec3::from(sky.irradiance_up) + Vec3::from(sky.irradiance_down)) / (2.0 * PI)
        + Vec3::from(sky.sun_irradiance) / (4.0 * PI);
    let albedo = fluid.scattering / extinction.max(Vec3::splat(1e-30));
    transmittance * behind + albedo * (1.0 - transmittance) * light
}

fn shade(
    fluid: &FluidUniform,
    input: &TwinInput<'_>,
    water: &WaterPoint,
    around: &Neighbourhood,
    through: Vec3,
) -> Vec3 {
    let (camera, sky) = (input.camera, &input.surroundings.sky);
    let normal = to_world(camera, water.normal_view);
    let to_eye = to_world(camera, water.to_eye_view);
    let position = point_to_world(camera, water.position_view);
    let (up, sun_direction) = (Vec3::from(sky.up), Vec3::from(sky.sun_direction));

    let mut mirrored = (-to_eye).reflect(normal);
    let level = smoothstep(0.15, 0.5, normal.dot(up));
    mirrored = (mirrored - 2.0 * level * mirrored.dot(up).min(0.0) * up).normalize();
    let environment = surroundings_radiance(input.surroundings, position, mirrored);

    let drop = smoothstep(0.65, 1.0, around.isolation);
    let alpha = (fluid.alpha * fluid.alpha + (0.5 - 0.4 * drop) * around.spread).sqrt().min(0.6);
    let facing = smoothstep(0.15, 0.5, water.n_v);
    let n_l = normal.dot(sun_direction);
    let half_way = (sun_direction + to_eye).normalize();
    let lobe = ggx(n_l.max(1e-3), water.n_v, normal.dot(half_way).max(0.0), alpha) * n_l.max(0.0);
    let glint = fresnel_dielectric(to_eye.dot(half_way), fluid.refractive_index)
        * lobe
        * Vec3::from(sky.sun_irradiance);

    let cosine = (water.n_v * water.n_v + 0.2 * around.spread).sqrt().min(1.0);
    let reflectance = fresnel_dielectric(cosine, fluid.refractive_index);
    let reflectance = reflectance + (1.0 - reflectance) * fluid.additional_reflection;
    let clear = mix(through, environment, reflectance) + facing * glint.min(Vec3::splat(MAX_GLINT));

    let white = fluid.spray * drop;
    let facing_up = 0.5 + 0.5 * normal.dot(up);
    let diffuse = mix(sky.irradiance_down.into(), sky.irradiance_up.into(), facing_up)
        + (0.3 + 0.7 * n_l.max(0.0)) * Vec3::from(sky.sun_irradiance);
    mix(clear, diffuse / PI, white)
}

/// Radiance and coverage of `pixel`.
pub(crate) fn shade_pixel(fluid: &FluidUniform, input: &TwinInput<'_>, pixel: [u32; 2]) -> [f32; 4] {
    let index = input.index(IVec2::new(pixel[0] as i32, pixel[1] as i32));
    let here_px = Vec2::new(pixel[0] as f32, pixel[1] as f32) + 0.5;
    let scene = Vec4::from(input.scene_color[index]);
    let (distance, thickness) = (input.distance[index], input.thickness[index]);
    if is_empty(distance) || thickness <= 0.0 || distance >= input.scene_distance[index] {
        return (scene * shadow(fluid, input, here_px).extend(1.0)).to_array();
    }
    let around = neighbourhood(fluid, input, pixel, distance);
    let water = water_point(input, pixel, distance, around.normal_sum);
    let path = refracted_path(fluid, input, &water, thickness);
    let dim = shadow(fluid, input, path.end_px);
    let behind = background(input, path.end_px, path.nearest_distance, scene.truncate());
    let behind = dim * wet(fluid, input, &path) * behind;
    let through = transmitted(fluid, input, behind, path.length_world);
    let color = shade(fluid, input, &water, &around, through);
    let coverage = smoothstep(0.0, (0.5 * fluid.spacing_world).max(1e-30), thickness);
    (scene * dim.extend(1.0) * (1.0 - coverage) + color.extend(1.0) * coverage).to_array()
}
