use bench_ssfr_splat::Spheres;
use glam::{DVec3, Vec2, Vec3};
use meniscus_core::{Camera, DEFAULT_RADIUS_PER_SPACING, Projection};

/// Radii measured, pixels.
const RADII_PX: [f32; 8] = [0.6, 1.25, 2.5, 5.0, 10.0, 14.0, 20.0, 40.0];
/// Pixels of all splats of a case together: a little more than four layers over the picture.
const SPLAT_PX: f32 = 4e6;
/// Most particles of a case; fewer pixels then.
const MOST: f32 = 1e6;
const SIZE: [u32; 2] = [1280, 720];
/// Particles lie at distances from 1 to this much more.
const DEPTH: f32 = 0.05;
/// Of the particles that lie close before the lens, among a million of 1 px: radii, pixels.
const CLOSE_PX: [f32; 2] = [80.0, 300.0];

/// Spheres of one radius, spread over a picture.
#[derive(Clone, Debug)]
pub struct Case {
    /// Name in reports.
    pub name: String,
    /// Radius of most particles, pixels; of the nearest of them, the others are up to a twentieth smaller.
    pub radius_px: f32,
    /// Their number.
    pub count: usize,
    /// Radius of those that are close, pixels.
    pub close_px: f32,
    /// Their number. They cover the left third, and are drawn first, as level of detail has it.
    pub close: usize,
    /// `[width, height]` in pixels.
    pub size: [u32; 2],
}

impl Case {
    /// One per radius, from small to large, then those of dust and a few close spheres.
    pub fn all() -> Vec<Self> {
        let equal = RADII_PX.map(|radius_px| Self {
            name: format!("{radius_px} px"),
            radius_px,
            count: (SPLAT_PX / (std::f32::consts::PI * radius_px * radius_px)).min(MOST) as usize,
            close_px: radius_px,
            close: 0,
            size: SIZE,
        });
        let mixed = CLOSE_PX.map(|close_px| Self {
            name: format!("1 and {close_px} px"),
            radius_px: 1.0,
            count: MOST as usize,
            close_px,
            close: 100,
            size: SIZE,
        });
        equal.into_iter().chain(mixed).collect()
    }

    /// Splats of the same size over an eighth of the width and the height; close ones cover as much of it.
    pub fn tiny(self) -> Self {
        let size = self.size.map(|side| side / 8);
        let (count, close) = (self.count.div_ceil(64), self.close.div_ceil(64));
        Self { count, close_px: self.close_px / 8.0, close, size, ..self }
    }

    /// Whether all particles are about as large as each other.
    pub fn is_equal(&self) -> bool {
        self.close == 0
    }

    /// Number of all particles.
    pub fn particles(&self) -> usize {
        self.count + self.close
    }

    /// The particles and the camera; the same for every call.
    pub fn spheres(&self) -> Spheres {
        let camera = Camera {
            eye: Vec3::ZERO,
            target: Vec3::Y,
            up: Vec3::Z,
            projection: Projection::Perspective { fovy_rad: 0.45 },
            near: 1e-3,
        };
        let half_extent = camera.half_extent(self.size);
        let world_from_view = camera.view_from_world().inverse();
        // `part` of the picture, from its left.
        let spread = |count, part: f32, distance: f32| {
            (0..count).map(move |i| {
                let at = evenly(i);
                let plane = (Vec2::new(part * at.x, at.y) * 2.0 - 1.0) * half_extent;
                let d = distance * (1.0 + DEPTH * at.z);
                world_from_view.transform_point3((plane * d).extend(-d)).to_array()
            })
        };
        let volume = 4.0 * half_extent.x * half_extent.y * DEPTH;
        let cell_world = 8.0 * (volume / self.count as f32).cbrt();
        let mut positions: Vec<_> = spread(self.close, 1.0 / 3.0, self.radius_px / self.close_px).collect();
        positions.extend(bench_views::ordered(spread(self.count, 1.0, 1.0).collect(), cell_world));
        let radius_world = self.radius_px / camera.px_per_world(self.size, 1.0);
        let spacing_world = radius_world / DEFAULT_RADIUS_PER_SPACING as f32;
        Spheres { positions, radius_world, spacing_world, camera, size: self.size }
    }
}

/// Points that fill the unit cube evenly, however many are taken: the additive recurrence R3 (M. Roberts, 2018).
fn evenly(index: usize) -> Vec3 {
    /// The root of x^4 = x + 1.
    const G: f64 = 1.220_744_084_605_759_5;
    let steps = DVec3::new(1.0 / G, 1.0 / (G * G), 1.0 / (G * G * G));
    (steps * index as f64 + 0.5).fract().as_vec3()
}
