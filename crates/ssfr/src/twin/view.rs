use glam::{DMat4, DVec2, DVec3, Mat4};
use meniscus_gpu::CameraUniform;

/// A camera in double precision; `meniscus::camera` of `shaders/common/camera.inc.wgsl`.
#[derive(Clone, Copy, Debug)]
pub struct HostView {
    /// `[width, height]` in pixels.
    pub size_px: [usize; 2],
    pub(crate) view_from_world: DMat4,
    pub(crate) half_extent: DVec2,
    pub(crate) is_parallel: bool,
    pub(crate) near_world: f64,
    px_per_world_at_one: f64,
}

impl HostView {
    /// The camera that the shaders get as `camera`.
    pub fn new(camera: &CameraUniform) -> Self {
        Self {
            size_px: camera.size_px.map(|side| side as usize),
            view_from_world: Mat4::from_cols_array_2d(&camera.view_from_world).as_dmat4(),
            half_extent: DVec2::new(camera.half_extent[0].into(), camera.half_extent[1].into()),
            is_parallel: camera.orthographic != 0,
            near_world: camera.near_world.into(),
            px_per_world_at_one: camera.px_per_world_at_one.into(),
        }
    }

    /// Ray through a point of the picture in pixels, by distance along the view axis: `position(d) = origin + d * step`.
    pub fn ray(&self, point_px: DVec2) -> (DVec3, DVec3) {
        let size = DVec2::new(self.size_px[0] as f64, self.size_px[1] as f64);
        let ndc = point_px / size * DVec2::new(2.0, -2.0) + DVec2::new(-1.0, 1.0);
        let offset = ndc * self.half_extent;
        if self.is_parallel { (offset.extend(0.0), DVec3::NEG_Z) } else { (DVec3::ZERO, offset.extend(-1.0)) }
    }

    /// Ray through the centre of pixel `(x, y)`.
    pub(crate) fn pixel_ray(&self, x: usize, y: usize) -> (DVec3, DVec3) {
        self.ray(DVec2::new(x as f64 + 0.5, y as f64 + 0.5))
    }

    /// Picture point, in pixels, of a position in view space.
    pub fn project_px(&self, position_view: DVec3) -> DVec2 {
        let scale = if self.is_parallel { 1.0 } else { -position_view.z };
        let ndc = position_view.truncate() / (self.half_extent * scale);
        let size = DVec2::new(self.size_px[0] as f64, self.size_px[1] as f64);
        (ndc * DVec2::new(0.5, -0.5) + 0.5) * size
    }

    /// Pixels per world unit at `distance`.
    pub fn px_per_world(&self, distance: f64) -> f64 {
        self.px_per_world_at_one / if self.is_parallel { 1.0 } else { distance }
    }

    /// World area of a pixel, perpendicular to the view axis, at `distance`.
    pub(crate) fn pixel_area(&self, distance: f64) -> f64 {
        let side = 2.0 * self.half_extent / DVec2::new(self.size_px[0] as f64, self.size_px[1] as f64);
        side.x * side.y * if self.is_parallel { 1.0 } else { distance * distance }
    }

    /// A number that is affine in the pixel on every plane and greater for what is nearer: 1/d under perspective, -d in
    /// parallel projection (`algorithms.md` 3.7).
    pub(crate) fn key(&self, distance: f64) -> f64 {
        if self.is_parallel { -distance } else { 1.0 / distance }
    }

    /// The same view over blocks of `scale` x `scale` pixels; what the last row or column lacks is added on the outside.
    pub(crate) fn reduced(&self, scale: usize) -> Self {
        let size_px = self.size_px.map(|side| side.div_ceil(scale));
        Self { size_px, ..*self }
    }

    /// Centre, in pixels of this view, of pixel `(x, y)` of [`Self::reduced`].
    pub(crate) fn block_center(&self, scale: usize, x: usize, y: usize) -> DVec2 {
        DVec2::new(x as f64 + 0.5, y as f64 + 0.5) * scale as f64
    }
}
