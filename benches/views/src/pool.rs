use glam::{Mat4, Vec2, Vec3};
use meniscus_core::Camera;

/// Water with an analytic surface: what shading gets does not change when the surface stage does.
///
/// Waves of two lengths on a basin of 2 x 1 metres, 0.3 m deep, over a floor at height 0, z up; seen so that it fills most of
/// the picture, with its rim and the floor behind it.
#[derive(Clone, Debug)]
pub struct Pool {
    /// `[width, height]` in pixels.
    pub size: [u32; 2],
    /// Along the view axis; `f32::MAX` = no water.
    pub distance: Vec<f32>,
    /// Length of water along the ray, world.
    pub thickness: Vec<f32>,
    /// Octahedral view-space normals, 2 x snorm16.
    pub normal: Vec<u32>,
    /// Along the view axis; `f32::MAX` = sky.
    pub floor_distance: Vec<f32>,
}

/// Steps of the march through the basin; a hundredth of its length each.
const STEPS: u32 = 200;
const BASIN: Vec3 = Vec3::new(2.0, 1.0, 0.4);

impl Pool {
    /// Fraction of the picture that shows water.
    pub fn covered_fraction(&self) -> f32 {
        self.distance.iter().filter(|d| **d < f32::MAX).count() as f32 / self.distance.len() as f32
    }

    /// The camera.
    pub fn camera() -> Camera {
        Camera {
            eye: Vec3::new(2.6, -1.5, 1.3),
            target: Vec3::new(1.05, 0.45, 0.15),
            up: Vec3::Z,
            projection: meniscus_core::Projection::Perspective { fovy_rad: 0.45 },
            near: 1e-3,
        }
    }

    /// The pool in pictures of `size` pixels.
    pub fn new(size: [u32; 2]) -> Self {
        let camera = Self::camera();
        let (view_from_world, half) = (camera.view_from_world(), camera.half_extent(size));
        let world_from_view = view_from_world.inverse();
        let mut pool = Self {
            size,
            distance: Vec::new(),
            thickness: Vec::new(),
            normal: Vec::new(),
            floor_distance: Vec::new(),
        };
        for i in 0..size[0] * size[1] {
            let px = Vec2::new((i % size[0]) as f32 + 0.5, (i / size[0]) as f32 + 0.5);
            let ndc =
                px / Vec2::new(size[0] as f32, size[1] as f32) * Vec2::new(2.0, -2.0) + Vec2::new(-1.0, 1.0);
            // Parametrised by the distance along the view axis.
            let along = world_from_view.transform_vector3((ndc * half).extend(-1.0));
            pool.cast(camera.eye, along, &view_from_world);
        }
        pool
    }

    fn cast(&mut self, eye: Vec3, along: Vec3, view_from_world: &Mat4) {
        let floor = if along.z < 0.0 { -eye.z / along.z } else { f32::MAX };
        self.floor_distance.push(floor);
        let (a, b) = (-eye / along, (BASIN - eye) / along);
        let (enter, leave) = (a.min(b).max_element().max(0.0), a.max(b).min_element());
        let step = (leave - enter) / STEPS as f32;
        let depth = |d: f32| height(eye + d * along) - (eye + d * along).z;
        let wet =
            (0..STEPS).map(|k| enter + (k as f32 + 0.5) * step).filter(|&d| step > 0.0 && depth(d) > 0.0);
        let (mut front, mut count) = (None, 0);
        for d in wet {
            front.get_or_insert(d);
            count += 1;
        }
        let Some(mut front) = front else {
            self.distance.push(f32::MAX);
            self.thickness.push(0.0);
            self.normal.push(0);
            return;
        };
        let is_side = front - enter < step;
        // A few steps of the secant rule; enough for a surface without steps.
        for _ in 0..3 {
            front += if is_side {
                0.0
            } else {
                depth(front) / (along.z - slope(eye + front * along).dot(along.truncate()))
            };
        }
        let p = eye + front * along;
        let normal = if is_side { -along.with_z(0.0) } else { (-slope(p)).extend(1.0) };
        self.distance.push(front);
        self.thickness.push(count as f32 * step * along.length());
        self.normal.push(pack_normal(view_from_world.transform_vector3(normal.normalize())));
    }
}

fn height(p: Vec3) -> f32 {
    0.3 + 0.03 * (7.0 * p.x + 3.0 * p.y).sin() + 0.01 * (31.0 * p.y - 12.0 * p.x).sin()
}

/// Gradient of [`height`].
fn slope(p: Vec3) -> Vec2 {
    let (long, short) = (0.03 * (7.0 * p.x + 3.0 * p.y).cos(), 0.01 * (31.0 * p.y - 12.0 * p.x).cos());
    Vec2::new(7.0 * long - 12.0 * short, 3.0 * long + 31.0 * short)
}

/// Octahedral map of a unit vector to two snorm16, as `meniscus::surface::pack_normal`.
fn pack_normal(n: Vec3) -> u32 {
    let p = n.truncate() / (n.x.abs() + n.y.abs() + n.z.abs());
    let sign = |x: f32| if x >= 0.0 { 1.0 } else { -1.0 };
    let folded = Vec2::new((1.0 - p.y.abs()) * sign(p.x), (1.0 - p.x.abs()) * sign(p.y));
    let q = if n.z >= 0.0 { p } else { folded };
    let snorm = |x: f32| u32::from((x.clamp(-1.0, 1.0) * 32767.0).round() as i16 as u16);
    snorm(q.x) | snorm(q.y) << 16
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_pool_fills_most_of_the_picture() {
        let pool = Pool::new([160, 90]);
        let covered = pool.covered_fraction();
        assert!((0.4..0.9).contains(&covered), "{covered}");
        assert!(pool.distance.iter().zip(&pool.floor_distance).all(|(d, f)| d <= f || *d == f32::MAX));
        let deepest = pool.thickness.iter().copied().fold(0.0, f32::max);
        assert!((0.4..2.3).contains(&deepest), "{deepest}");
    }
}
