use glam::{DVec2, DVec3, Vec3};
use meniscus_core::{Camera, Projection};
use meniscus_gpu::CameraUniform;
use meniscus_gpu::role::NO_SURFACE;

use crate::twin::HostView;

/// Picture size of most checks: wider than high, and not a multiple of any workgroup.
pub(super) const SIZE: [u32; 2] = [150, 110];

/// Distance of neighbouring particles per drawn radius in all pictures: the default radius of 1.25 half spacings.
pub(super) const SPACING_PER_RADIUS: f32 = 1.6;

/// What a filter is given.
#[derive(Clone)]
pub(super) struct Picture {
    pub camera: Camera,
    pub size: [u32; 2],
    pub distance: Vec<f32>,
    pub radius: Vec<f32>,
}

/// At the origin, looking along -z, with a vertical field of view in radians.
pub(super) fn perspective(fovy_rad: f32) -> Camera {
    camera(Projection::Perspective { fovy_rad })
}

/// The same in parallel projection, `height_world` high.
pub(super) fn parallel(height_world: f32) -> Camera {
    camera(Projection::Orthographic { height_world })
}

fn camera(projection: Projection) -> Camera {
    Camera { eye: Vec3::ZERO, target: Vec3::NEG_Z, up: Vec3::Y, projection, near: 1e-4 }
}

pub(super) fn is_surface(distance: f32) -> bool {
    distance > 0.0 && distance < NO_SURFACE
}

/// Where the ray meets a plane.
pub(super) fn plane(normal: DVec3, point: DVec3) -> impl Fn(DVec3, DVec3) -> Option<f64> {
    move |origin, step| Some(normal.dot(point - origin) / normal.dot(step))
}

impl Picture {
    /// What `along` says of the ray of each pixel, of particles of one radius.
    pub fn new(
        camera: Camera,
        size: [u32; 2],
        radius: f32,
        along: impl Fn(DVec3, DVec3) -> Option<f64>,
    ) -> Self {
        let view = HostView::new(&CameraUniform::new(&camera, size));
        let distances = (0..size[0] * size[1]).map(|i| {
            let at = DVec2::new(f64::from(i % size[0]) + 0.5, f64::from(i / size[0]) + 0.5);
            let (origin, step) = view.ray(at);
            along(origin, step).map_or(NO_SURFACE, |d| d as f32)
        });
        let distance: Vec<f32> = distances.collect();
        let radius = distance.iter().map(|&d| if is_surface(d) { radius } else { 0.0 }).collect();
        Self { camera, size, distance, radius }
    }

    /// The same surface drawn with particles of another radius.
    pub fn with_radius(&self, radius: f32) -> Self {
        let radius = self.radius.iter().map(|&r| if r > 0.0 { radius } else { 0.0 }).collect();
        Self { radius, ..self.clone() }
    }

    /// A plane that faces the viewer at distance 5, in both projections.
    pub fn flat() -> [Self; 2] {
        [perspective(1.0), parallel(5.0)]
            .map(|camera| Self::new(camera, SIZE, 0.1, plane(DVec3::Z, DVec3::new(0.0, 0.0, -5.0))))
    }

    /// A disc of bumps, a third of it two units further back: small bumps of about a particle's size, an edge, a silhouette.
    pub fn bumpy(camera: Camera, size: [u32; 2], radius: f32) -> Self {
        Self::new(camera, size, radius, |origin, step| {
            let seen = if camera.is_orthographic() { origin / 5.0 } else { step };
            let (u, v) = (seen.x * 40.0, seen.y * 40.0);
            let bump = 0.1 * (u.sin() * v.cos() + 0.3 * (0.7 * u).cos());
            let far = if seen.x + 0.6 * seen.y > 0.2 { 2.0 } else { 0.0 };
            (seen.x * seen.x + seen.y * seen.y < 0.25).then_some(5.0 + bump + far)
        })
    }

    /// [`Self::bumpy`] in both projections.
    pub fn both_bumpy() -> [Self; 2] {
        [perspective(1.2), parallel(6.0)].map(|camera| Self::bumpy(camera, SIZE, 0.12))
    }

    /// Two planes facing the viewer at distances 4 and 6, next to each other.
    pub fn step(radius: f32) -> Self {
        Self::new(perspective(1.0), SIZE, radius, |_, step| Some(if step.x < 0.0 { 4.0 } else { 6.0 }))
    }

    /// Spheres on a square lattice that faces the viewer at distance 5 with a projected spacing of `spacing_px`, in a picture
    /// of `side` x `side` pixels.
    pub fn lattice(spacing_px: f64, side: u32) -> Self {
        let radius = 0.5;
        let spacing = radius * f64::from(SPACING_PER_RADIUS);
        let camera = parallel((f64::from(side) * spacing / spacing_px) as f32);
        Self::new(camera, [side; 2], radius as f32, |origin, _| {
            let cell = |c: f64| c - spacing * (c / spacing).round();
            let squared = cell(origin.x).powi(2) + cell(origin.y).powi(2);
            Some(5.0 - (radius * radius - squared).max(0.0).sqrt())
        })
    }

    /// The largest radius in pixels.
    pub fn most_radius_px(&self) -> f32 {
        let surface =
            std::iter::zip(&self.distance, &self.radius).filter(|(distance, _)| is_surface(**distance));
        let radii_px =
            surface.map(|(&distance, radius)| radius * self.camera.px_per_world(self.size, distance));
        radii_px.fold(0.0, f32::max)
    }

    /// A pixel's place, for messages.
    pub fn place(&self, pixel: usize) -> String {
        let width = self.size[0] as usize;
        format!("pixel ({}, {}) of {}x{}", pixel % width, pixel / width, self.size[0], self.size[1])
    }

    /// Mirrored from left to right (axis 0) or upside down (axis 1).
    pub fn mirrored(&self, axis: usize) -> Self {
        let size = self.size;
        Self {
            distance: mirrored(&self.distance, size, axis),
            radius: mirrored(&self.radius, size, axis),
            ..self.clone()
        }
    }

    /// All lengths times `factor`.
    pub fn scaled(&self, factor: f32) -> Self {
        let projection = match self.camera.projection {
            Projection::Orthographic { height_world } => {
                Projection::Orthographic { height_world: height_world * factor }
            }
            perspective @ Projection::Perspective { .. } => perspective,
        };
        let longer = |d: &f32| if is_surface(*d) { d * factor } else { *d };
        Self {
            camera: Camera { projection, ..self.camera },
            size: self.size,
            distance: self.distance.iter().map(longer).collect(),
            radius: self.radius.iter().map(longer).collect(),
        }
    }
}

/// An image mirrored from left to right (axis 0) or upside down (axis 1).
pub(super) fn mirrored(image: &[f32], size: [u32; 2], axis: usize) -> Vec<f32> {
    let rows = image.chunks(size[0] as usize);
    if axis == 0 {
        rows.flat_map(|row| row.iter().rev().copied()).collect()
    } else {
        rows.rev().flatten().copied().collect()
    }
}
