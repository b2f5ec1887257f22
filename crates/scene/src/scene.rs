use std::sync::Arc;

use glam::{DVec3, Vec3};
use meniscus_core::{Aabb, Choice, UpAxis};

use crate::camera::facing;
use crate::{Environment, Material, Mesh, SceneError, Sides, Terrain, UpFrame};

/// The sun.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sun {
    /// Unit direction towards the sun, world.
    pub direction: Vec3,
    /// Irradiance on a surface that faces the sun, linear Rec. 709, relative: a white sunlit floor comes out near 1.
    pub irradiance: [f32; 3],
}

/// A clear-sky gradient; radiance, linear Rec. 709, on the scale of [`Sun::irradiance`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sky {
    /// Straight up.
    pub zenith: [f32; 3],
    /// At the horizon: the colour of the haze.
    pub horizon: [f32; 3],
    /// Below the horizon, where there is no floor.
    pub ground: [f32; 3],
    /// Brightness of the glow around the sun, >= 0.
    pub glow: f32,
}

impl Default for Sky {
    fn default() -> Self {
        Self {
            zenith: [0.09, 0.21, 0.45],
            horizon: [0.95, 1.04, 1.15],
            ground: [0.30, 0.29, 0.27],
            glow: 1.0,
        }
    }
}

/// A level floor without end that fades into the haze.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Floor {
    /// Height along the up axis, world.
    pub height_world: f32,
    /// Its surface; `scale` is positive.
    pub material: Material,
}

/// Something solid.
#[derive(Clone, Debug, PartialEq)]
pub struct Object {
    /// For messages.
    pub name: String,
    /// Its triangles, world space.
    pub mesh: Mesh,
    /// Its surface; `scale` is positive.
    pub material: Material,
    /// Which sides are drawn.
    pub sides: Sides,
}

/// Everything around the water, in world space.
#[derive(Clone, Debug, PartialEq)]
pub struct Scene {
    /// Which world axis points up.
    pub up: UpAxis,
    /// Centre of the data on the floor, world; patterns start there.
    pub anchor: Vec3,
    /// Diagonal of the data, world, > 0: what haze and patterns are scaled by.
    pub size_world: f32,
    /// The sun.
    pub sun: Sun,
    /// The sky.
    pub sky: Sky,
    /// A picture of the surroundings in place of the sky, the sun taken out of it.
    pub environment: Option<Arc<Environment>>,
    /// The floor, if any.
    pub floor: Option<Floor>,
    /// Walls, boxes, terrain.
    pub objects: Vec<Object>,
    /// Whether there is terrain among them, which may hide what is seen from near the ground.
    pub has_terrain: bool,
    /// The automatic choices that were made for it.
    pub choices: Vec<Choice>,
}

impl Scene {
    /// Sun's elevation of the automatic scene.
    pub(crate) const SUN_ELEVATION_DEG: f32 = 48.0;
    /// Irradiance of the automatic sun: 48 degrees high, slightly warm.
    pub(crate) const SUN_IRRADIANCE: [f32; 3] = [3.40, 3.15, 2.75];

    /// The automatic scene for particles with centres in `bounds` (world) and the given `spacing` (world): a tiled floor that
    /// touches the lowest particles' cells, half a spacing below their centres, under a clear sky with the sun over
    /// the left shoulder of the automatic camera.
    pub fn around(bounds: Aabb, up: UpAxis, spacing: f32) -> Self {
        let bounds = if bounds.is_empty() || !bounds.extent().is_finite() {
            Aabb { min: Vec3::ZERO, max: Vec3::ONE }
        } else {
            bounds
        };
        let spacing = if spacing.is_finite() && spacing > 0.0 { spacing } else { 0.0 };
        let bounds = bounds.inflated(0.5 * spacing);
        let size_world = bounds.extent().length().max(1e-6 * bounds.center().length()).max(1e-12);
        let height_world = bounds.min.dot(up.vector());
        let (across, away) = facing(bounds, up);
        let elevation = Self::SUN_ELEVATION_DEG.to_radians();
        // 135 degrees off the view axis: level water mirrors the sky, and only steep wave fronts the sun.
        let direction =
            -(away * 0.96 + across * 0.27).normalize() * elevation.cos() + up.vector() * elevation.sin();
        let mut scene = Self {
            up,
            anchor: bounds.center() - up.vector() * (bounds.center().dot(up.vector()) - height_world),
            size_world,
            sun: Sun { direction: direction.normalize(), irradiance: Self::SUN_IRRADIANCE },
            sky: Sky::default(),
            environment: None,
            floor: None,
            objects: Vec::new(),
            has_terrain: false,
            choices: Vec::new(),
        };
        let material = scene.scaled(Material::named("tiles").unwrap_or_default());
        scene.floor = Some(Floor { height_world, material });
        scene
    }

    /// `material` with a scale chosen from the size of the scene where it has none.
    pub(crate) fn scaled(&self, material: Material) -> Material {
        let scale = if material.scale > 0.0 { material.scale } else { round_down(self.size_world * 0.12) };
        Material { scale, ..material }
    }

    /// Adds `terrain`, whose file is called `name`, around data in `bounds` (world); `origin` (file) is where world space starts.
    ///
    /// # Errors
    /// [`SceneError::Terrain`] when there is nothing to draw of it, or when it is nowhere near the data, as in another map projection.
    pub fn add_terrain(
        &mut self,
        name: &str,
        terrain: &Terrain,
        origin: DVec3,
        bounds: Aabb,
        material: Material,
    ) -> Result<(), SceneError> {
        let mesh = terrain.mesh(UpFrame::new(self.up), origin);
        let fail = |message| SceneError::Terrain { file: name.to_owned(), message };
        if mesh.indices.is_empty() {
            return Err(fail("has no four heights around a square, so that there is nothing to draw".into()));
        }
        let covered = Aabb::of_points(&mesh.positions);
        let near = bounds.inflated(self.size_world);
        let is_apart =
            |axis: usize| !(covered.min[axis] <= near.max[axis] && covered.max[axis] >= near.min[axis]);
        let is_near = bounds.is_empty() || !(0..3).any(is_apart);
        if !is_near || !mesh.positions.iter().all(|&position| Vec3::from(position).is_finite()) {
            let file = |v: Vec3| (v.as_dvec3() + origin).to_array();
            let (land, data) = ([covered.min, covered.max].map(file), [bounds.min, bounds.max].map(file));
            let message = format!(
                "lies between {:?} and {:?}, the particles between {:?} and {:?}: are both in the same map projection and unit?",
                land[0], land[1], data[0], data[1]
            );
            return Err(fail(message));
        }
        let (step, [columns, rows]) = (terrain.step(), terrain.size());
        if step > 1 {
            self.choices.push(Choice {
                what: "terrain".into(),
                value: format!("every {step}. point of {columns} x {rows} to each side"),
                reason: format!("{name} has more than {} points", Terrain::MOST_POINTS),
                flag: "a smaller or coarser grid in --scene".into(),
            });
        }
        // Elements of a few squares: what is smaller than the squares has no shape to go with it.
        let scale =
            if material.scale > 0.0 { material.scale } else { terrain.spacing().max_element() as f32 * 4.0 };
        let material = Material { scale, ..material };
        self.has_terrain = true;
        self.objects.push(Object { name: name.to_owned(), mesh, material, sides: Sides::Both });
        Ok(())
    }

    /// Adds the walls of a tank around `bounds` (world), `height_world` high from its bottom, seen from inside only.
    pub fn add_walls(&mut self, bounds: Aabb, height_world: f32, material: Material) {
        let frame = UpFrame::new(self.up);
        let extent = bounds.extent();
        let half = |axis: Vec3| axis * extent.dot(axis.abs()) * 0.5;
        let (east, north, up) = (half(frame.east), half(frame.north), frame.up * height_world);
        let bottom = bounds.center() - half(frame.up);
        let mut mesh = Mesh::default();
        for (out, along) in [(east, north), (north, -east), (-east, -north), (-north, east)] {
            // up x along points inwards.
            mesh.push_quad(bottom + out - along, up, 2.0 * along);
        }
        let material = self.scaled(material);
        self.objects.push(Object { name: "walls".into(), mesh, material, sides: Sides::Front });
    }
}

/// The largest of 1, 1.5, 2, 3, 5 times a power of ten that is not above `x` > 0: tile sizes that people can count with.
fn round_down(x: f32) -> f32 {
    let decade = 10f32.powf(x.log10().floor());
    let leading = x / decade;
    // The comparison leaves room for the rounding of log10 and powf.
    decade * [5.0, 3.0, 2.0, 1.5].into_iter().find(|&step| leading >= step * 0.9999).unwrap_or(1.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn bounds() -> Aabb {
        Aabb { min: Vec3::new(-1.0, 0.5, 2.0), max: Vec3::new(3.0, 1.5, 8.0) }
    }

    #[test]
    fn the_floor_touches_the_lowest_cells() {
        for up in [UpAxis::X, UpAxis::Y, UpAxis::Z] {
            let scene = Scene::around(bounds(), up, 0.1);
            let floor = scene.floor.unwrap();
            // 1e-6: rounding of one subtraction.
            assert!((floor.height_world - (bounds().min[up.index()] - 0.05)).abs() < 1e-6);
            assert!((scene.anchor[up.index()] - floor.height_world).abs() < 1e-6);
            assert!((scene.sun.direction.length() - 1.0).abs() < 1e-6);
            assert!(scene.sun.direction.dot(up.vector()) > 0.5);
        }
    }

    #[test]
    fn the_scene_scales_with_the_data() {
        let small = Scene::around(bounds(), UpAxis::Z, 0.1);
        let scaled = Aabb { min: bounds().min * 1000.0, max: bounds().max * 1000.0 };
        let large = Scene::around(scaled, UpAxis::Z, 100.0);
        let ratio = large.floor.unwrap().material.scale / small.floor.unwrap().material.scale;
        // 1e-3: powers of ten in f32.
        assert!((ratio / 1000.0 - 1.0).abs() < 1e-3, "{ratio}");
        assert_eq!(small.sun, large.sun);
    }

    #[test]
    fn level_water_does_not_mirror_the_sun_into_the_automatic_camera() {
        for up in [UpAxis::X, UpAxis::Y, UpAxis::Z] {
            let scene = Scene::around(bounds(), up, 0.1);
            let forward = crate::automatic_camera(&bounds().corners(), up, [1280, 720]).forward();
            let mirrored = forward - 2.0 * forward.dot(up.vector()) * up.vector();
            // 60 degrees: beyond the slopes of waves, which turn the reflection by twice their angle.
            assert!(mirrored.dot(scene.sun.direction) < 0.5);
        }
    }

    #[test]
    fn land_has_to_be_where_the_data_is() {
        use glam::DVec2;
        let origin = DVec3::new(5e5, 3.4e6, 0.0);
        let add = |south_west: DVec2, height: f32| {
            let mut scene = Scene::around(bounds(), UpAxis::Z, 0.1);
            let terrain = Terrain::new(south_west, DVec2::splat(2.0), 3, vec![height; 9]);
            let added = scene.add_terrain("land.asc", &terrain, origin, bounds(), Material::default());
            added.map(|()| scene).map_err(|e| e.to_string())
        };
        let scene = add(origin.truncate(), 1.0).unwrap();
        // Of four squares.
        assert_eq!((scene.has_terrain, scene.objects[0].material.scale), (true, 8.0));
        for (south_west, height) in [
            (DVec2::ZERO, 1.0),
            (origin.truncate(), 1e4),
            (DVec2::splat(f64::MAX), 1.0),
            (origin.truncate(), f32::MAX),
        ] {
            let message = add(south_west, height).unwrap_err();
            assert!(message.contains("land.asc") && message.contains("same map projection"), "{message}");
        }
        let message = add(origin.truncate(), f32::NAN).unwrap_err();
        assert!(message.contains("nothing to draw"), "{message}");
    }

    #[test]
    fn walls_face_inwards() {
        for up in [UpAxis::X, UpAxis::Y, UpAxis::Z] {
            let mut scene = Scene::around(bounds(), up, 0.1);
            scene.add_walls(bounds(), 2.0, Material::default());
            let mesh = &scene.objects[0].mesh;
            assert_eq!(mesh.indices.len(), 24);
            for (&p, &n) in mesh.positions.iter().zip(&mesh.normals) {
                assert!((bounds().center() - Vec3::from(p)).dot(n.into()) > 0.1);
            }
        }
    }

    #[test]
    fn tile_sizes_are_round() {
        for (x, expected) in [(1.0, 1.0), (0.37, 0.3), (0.05, 0.05), (99.0, 50.0), (250.0, 200.0)] {
            // 1e-4: powers of ten in f32.
            assert!((round_down(x) / expected - 1.0f32).abs() < 1e-4, "{x} {}", round_down(x));
        }
    }

    #[test]
    fn nothing_to_surround_still_gives_a_scene() {
        let nan = Aabb { min: Vec3::NAN, max: Vec3::NAN };
        for bounds in [Aabb::EMPTY, nan, Aabb { min: Vec3::ZERO, max: Vec3::ZERO }] {
            let scene = Scene::around(bounds, UpAxis::Y, f32::NAN);
            assert!(scene.size_world > 0.0 && scene.floor.unwrap().material.scale > 0.0);
        }
    }
}
