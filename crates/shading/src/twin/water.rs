//! Twin of `meniscus::water` and of what `meniscus::lighting_inputs` does with images.

use glam::{IVec2, Vec2, Vec3, Vec4};

use super::view::{is_empty, towards_eye, unpack_normal, view_position};
use super::{TwinInput, smoothstep};

const MIN_N_V: f32 = 0.03;

/// What every lighting model knows about the water surface in a pixel.
pub(super) struct WaterPoint {
    pub position_view: Vec3,
    pub normal_view: Vec3,
    pub to_eye_view: Vec3,
    pub distance: f32,
    pub n_v: f32,
}

/// The unit normal along `normal_view`, bent towards the eye where it would face away.
pub(super) fn faced(normal_view: Vec3, to_eye: Vec3) -> Vec3 {
    let size = normal_view.length();
    let normal = if size > 1e-3 { normal_view / size } else { to_eye };
    let facing = normal.dot(to_eye);
    if facing < MIN_N_V { (normal + (MIN_N_V - facing) * to_eye).normalize() } else { normal }
}

/// `normal_view` need not be of unit length.
pub(super) fn water_point(
    input: &TwinInput<'_>,
    pixel: [u32; 2],
    distance: f32,
    normal_view: Vec3,
) -> WaterPoint {
    let center = Vec2::new(pixel[0] as f32, pixel[1] as f32) + 0.5;
    let position_view = view_position(input.camera, center, distance);
    let to_eye_view = towards_eye(input.camera, position_view);
    let normal_view = faced(normal_view, to_eye_view);
    let n_v = normal_view.dot(to_eye_view).clamp(MIN_N_V, 1.0);
    WaterPoint { position_view, normal_view, to_eye_view, distance, n_v }
}

impl TwinInput<'_> {
    pub(super) fn index(&self, at: IVec2) -> usize {
        at.y as usize * self.camera.size_px[0] as usize + at.x as usize
    }

    pub(super) fn clamped(&self, at: IVec2) -> usize {
        self.index(at.clamp(IVec2::ZERO, self.size() - 1))
    }

    pub(super) fn size(&self) -> IVec2 {
        IVec2::new(self.camera.size_px[0] as i32, self.camera.size_px[1] as i32)
    }

    pub(super) fn inside(&self, px: Vec2) -> bool {
        px.cmpge(Vec2::ZERO).all() && px.cmplt(self.size().as_vec2()).all()
    }

    pub(super) fn scene_rgb(&self, index: usize) -> Vec3 {
        Vec4::from(self.scene_color[index]).truncate()
    }

    /// Place of `pixel` in all images.
    pub(super) fn pixel_index(&self, pixel: [u32; 2]) -> usize {
        self.index(IVec2::new(pixel[0] as i32, pixel[1] as i32))
    }

    /// Whether the pixel shows water: there is some, in front of the scene.
    pub(super) fn shows_water(&self, index: usize) -> bool {
        let distance = self.distance[index];
        distance > 0.0
            && !is_empty(distance)
            && self.thickness[index] > 0.0
            && distance < self.scene_distance[index]
    }

    /// Colour that an attribute gives the water, each in [0, 1].
    pub(super) fn tint(&self, index: usize) -> Vec4 {
        Vec4::from(self.surface_color_at(index)).clamp(Vec4::ZERO, Vec4::ONE)
    }

    /// [`water_point`] with the pixel's own normal.
    pub(super) fn plain_water_point(&self, pixel: [u32; 2], index: usize) -> WaterPoint {
        water_point(self, pixel, self.distance[index], unpack_normal(self.normal[index]))
    }
}

/// Middle of a pixel.
pub(super) fn center_px(pixel: [u32; 2]) -> Vec2 {
    Vec2::new(pixel[0] as f32, pixel[1] as f32) + 0.5
}

/// Less water than a fraction of a particle is a soft edge, not a surface.
pub(super) fn coverage(thickness: f32, spacing_world: f32) -> f32 {
    smoothstep(0.0, (0.5 * spacing_world).max(1e-30), thickness)
}

/// `color` over the scene, as far as there is water.
pub(super) fn over(scene: Vec4, color: Vec3, coverage: f32) -> [f32; 4] {
    (scene * (1.0 - coverage) + color.extend(1.0) * coverage).to_array()
}
