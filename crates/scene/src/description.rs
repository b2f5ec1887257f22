use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use glam::{DVec3, Vec3};
use meniscus_core::{Aabb, UpAxis};
use schemars::JsonSchema;
use serde::Deserialize;

use crate::{
    Environment, Floor, Material, Mesh, Object, Scene, SceneError, Sides, Terrain, UpFrame, physical_sky,
};

/// A scene file. Everything is optional; what is left out is chosen as in [`Scene::around`]. Lengths and coordinates are
/// the particle file's own.
#[derive(Clone, Debug, Default, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Description {
    /// The sun.
    pub sun: SunDescription,
    /// The sky.
    pub sky: SkyDescription,
    /// A picture of the surroundings.
    pub environment: EnvironmentDescription,
    /// The floor.
    pub floor: FloorDescription,
    /// Walls of the tank.
    pub walls: WallsDescription,
    /// Solid boxes, `[[box]]` in the file.
    #[serde(rename = "box")]
    pub boxes: Vec<BoxDescription>,
    /// Elevation grids, `[[terrain]]` in the file.
    pub terrain: Vec<TerrainDescription>,
    /// Materials by name, beside the built-in ones.
    pub materials: BTreeMap<String, Material>,
}

/// `[sun]`
#[derive(Clone, Debug, Default, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct SunDescription {
    /// Degrees above the horizon, in (0, 90].
    pub elevation_deg: Option<f32>,
    /// Degrees from north, clockwise seen from above. North is +y for z up, -z for y up, +z for x up.
    pub azimuth_deg: Option<f32>,
    /// Irradiance facing the sun, linear red, green, blue; about 3 is a clear day.
    pub irradiance: Option<[f32; 3]>,
}

/// `[sky]`: linear radiance.
#[derive(Clone, Debug, Default, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct SkyDescription {
    /// Straight up.
    pub zenith: Option<[f32; 3]>,
    /// At the horizon.
    pub horizon: Option<[f32; 3]>,
    /// Below the horizon, where there is no floor.
    pub ground: Option<[f32; 3]>,
    /// Glow around the sun, 1 = clear day.
    pub glow: Option<f32>,
    /// Sky and sun as the atmosphere makes them at the sun's position, in place of the colours above; `ground` still counts.
    pub physical: bool,
}

/// `[environment]`: replaces sun and sky, unless a sun is given.
#[derive(Clone, Debug, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct EnvironmentDescription {
    /// An `.hdr` or `.exr` picture, equirectangular or cube faces in a cross or a strip; relative to the scene file.
    pub file: Option<PathBuf>,
    /// Degrees by which it is turned clockwise, seen from above. Unturned, its middle is north.
    pub rotation_deg: f32,
    /// Factor on its brightness, 0 to 100. At 1 level ground gets as much light as in the automatic scene.
    pub intensity: f32,
}

impl Default for EnvironmentDescription {
    fn default() -> Self {
        Self { file: None, rotation_deg: 0.0, intensity: 1.0 }
    }
}

/// `[floor]`
#[derive(Clone, Debug, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct FloorDescription {
    /// Whether there is one; left out: unless there is terrain.
    pub visible: Option<bool>,
    /// Coordinate along the up axis; left out: just under the water.
    pub height: Option<f64>,
    /// Name of a built-in material or of one under `[materials]`.
    pub material: String,
}

impl Default for FloorDescription {
    fn default() -> Self {
        Self { visible: None, height: None, material: "tiles".into() }
    }
}

/// `[walls]`: the box around the data, drawn from inside only.
#[derive(Clone, Debug, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct WallsDescription {
    /// Whether they are drawn.
    pub visible: bool,
    /// Height above the bottom of the data; left out: the data's own.
    pub height: Option<f32>,
    /// Name of a material.
    pub material: String,
}

impl Default for WallsDescription {
    fn default() -> Self {
        Self { visible: false, height: None, material: "concrete".into() }
    }
}

/// `[[box]]`
#[derive(Clone, Debug, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct BoxDescription {
    /// Smallest corner, file coordinates.
    pub min: [f64; 3],
    /// Largest corner, file coordinates.
    pub max: [f64; 3],
    /// Name of a material.
    #[serde(default = "concrete")]
    pub material: String,
}

fn concrete() -> String {
    "concrete".into()
}

/// `[[terrain]]`
#[derive(Clone, Debug, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct TerrainDescription {
    /// An ESRI ASCII grid or a USGS DEM in the particle file's coordinates, x east and y north where z is up; relative to the
    /// scene file.
    pub file: PathBuf,
    /// Name of a material.
    #[serde(default = "rock")]
    pub material: String,
}

fn rock() -> String {
    "rock".into()
}

impl Description {
    /// Parses a scene file; `file` is its name for messages.
    ///
    /// # Errors
    /// [`SceneError::Toml`] with line and column.
    pub fn from_toml(text: &str, file: &str) -> Result<Self, SceneError> {
        toml::from_str(text).map_err(|e| SceneError::Toml {
            file: file.to_owned(),
            message: e.to_string().trim_end().to_owned(),
        })
    }

    /// Completes the description for data with particle centres in `bounds` (world), series origin `origin` (file) and
    /// `spacing` (world). `file` is its name for messages.
    ///
    /// # Errors
    /// A value out of range or the name of a material that does not exist.
    pub fn resolve(
        &self,
        bounds: Aabb,
        origin: DVec3,
        up: UpAxis,
        spacing: f32,
        file: &str,
    ) -> Result<Scene, SceneError> {
        let check = Check { file };
        let mut scene = Scene::around(bounds, up, spacing);
        self.apply_light(&mut scene, &check)?;
        self.apply_environment(&mut scene, &check)?;

        let floor_material = self.material("floor.material", &self.floor.material, &check)?;
        let automatic_height = scene.floor.map_or(0.0, |f| f.height_world);
        let height_world = match self.floor.height {
            Some(height) => check.length("floor.height", height - origin[up.index()])?,
            None => automatic_height,
        };
        let has_floor = self.floor.visible.unwrap_or(self.terrain.is_empty());
        scene.floor = has_floor.then_some(Floor { height_world, material: scene.scaled(floor_material) });

        if self.walls.visible {
            let material = self.material("walls.material", &self.walls.material, &check)?;
            let room = if bounds.is_empty() { Aabb { min: Vec3::ZERO, max: Vec3::ONE } } else { bounds };
            let room = room.inflated(0.5 * spacing.max(0.0));
            let height = self.walls.height.unwrap_or(room.extent()[up.index()]);
            let height = check.range("walls.height", height, height > 0.0, "a positive length")?;
            scene.add_walls(room, height, material);
        }
        for (i, solid) in self.boxes.iter().enumerate() {
            let key = |field: &str| format!("box[{i}].{field}");
            let material = self.material(&key("material"), &solid.material, &check)?;
            let corner = |field: &str, c: [f64; 3]| -> Result<Vec3, SceneError> {
                let relative = DVec3::from(c) - origin;
                for component in relative.to_array() {
                    check.length(&key(field), component)?;
                }
                Ok(relative.as_vec3())
            };
            let (min, max) = (corner("min", solid.min)?, corner("max", solid.max)?);
            if !min.cmplt(max).all() {
                return Err(check.error(
                    &key("max"),
                    format!("{:?}", solid.max),
                    "more than min in every axis",
                ));
            }
            let mesh = Mesh::cuboid(Aabb { min, max });
            let material = scene.scaled(material);
            scene.objects.push(Object { name: format!("box {i}"), mesh, material, sides: Sides::Both });
        }
        for (i, ground) in self.terrain.iter().enumerate() {
            let material = self.material(&format!("terrain[{i}].material"), &ground.material, &check)?;
            let terrain = Terrain::read(&check.beside(&ground.file))?;
            let name = ground.file.display().to_string();
            scene.add_terrain(&name, &terrain, origin, bounds, material)?;
        }
        Ok(scene)
    }

    fn apply_light(&self, scene: &mut Scene, check: &Check<'_>) -> Result<(), SceneError> {
        let frame = UpFrame::new(scene.up);
        let automatic = scene.sun.direction;
        let automatic_azimuth = automatic.dot(frame.east).atan2(automatic.dot(frame.north)).to_degrees();
        let elevation = self.sun.elevation_deg.unwrap_or(Scene::SUN_ELEVATION_DEG);
        let in_range = elevation > 0.0 && elevation <= 90.0;
        check.range("sun.elevation_deg", elevation, in_range, "more than 0 and at most 90")?;
        let azimuth = self.sun.azimuth_deg.unwrap_or(automatic_azimuth);
        check.range("sun.azimuth_deg", azimuth, true, "a finite angle")?;
        if self.sun.elevation_deg.is_some() || self.sun.azimuth_deg.is_some() {
            scene.sun.direction = frame.direction(azimuth.to_radians(), elevation.to_radians());
        }
        let sky = &mut scene.sky;
        for (key, given, target) in [
            ("sun.irradiance", self.sun.irradiance, &mut scene.sun.irradiance),
            ("sky.zenith", self.sky.zenith, &mut sky.zenith),
            ("sky.horizon", self.sky.horizon, &mut sky.horizon),
            ("sky.ground", self.sky.ground, &mut sky.ground),
        ] {
            if let Some(color) = given {
                *target = check.color(key, color, 1e3, "three numbers from 0 to 1000")?;
            }
        }
        if let Some(glow) = self.sky.glow {
            sky.glow = check.range("sky.glow", glow, (0.0..=100.0).contains(&glow), "0 to 100")?;
        }
        Ok(())
    }

    fn apply_environment(&self, scene: &mut Scene, check: &Check<'_>) -> Result<(), SceneError> {
        let frame = UpFrame::new(scene.up);
        let EnvironmentDescription { file, rotation_deg, intensity } = &self.environment;
        check.range("environment.rotation_deg", *rotation_deg, true, "a finite angle")?;
        check.range(
            "environment.intensity",
            *intensity,
            (0.0..=100.0).contains(intensity),
            "a number from 0 to 100",
        )?;
        let (mut environment, sun) = if let Some(file) = file {
            let mut picture = Environment::read(&check.beside(file))?.turned(*rotation_deg);
            let mut sun = picture.split_sun(frame, None);
            // A sun that is given stands where it is said, with the light of the picture's if it has any.
            if self.sun.elevation_deg.is_some() || self.sun.azimuth_deg.is_some() {
                sun.direction = scene.sun.direction;
            }
            (picture, sun)
        } else if self.sky.physical {
            let towards = scene.sun.direction;
            let azimuth = towards.dot(frame.east).atan2(towards.dot(frame.north)).to_degrees();
            let elevation = towards.dot(frame.up).clamp(-1.0, 1.0).asin().to_degrees();
            physical_sky(frame, azimuth, elevation, scene.sky.ground)
        } else {
            return Ok(());
        };
        environment.scale(*intensity);
        scene.sun.direction = sun.direction;
        scene.sun.irradiance = self.sun.irradiance.unwrap_or(sun.irradiance.map(|e| e * intensity));
        scene.environment = Some(Arc::new(environment));
        Ok(())
    }

    fn material(&self, key: &str, name: &str, check: &Check<'_>) -> Result<Material, SceneError> {
        let own = self.materials.get(name).copied();
        let material = own.or_else(|| Material::named(name)).ok_or_else(|| SceneError::UnknownMaterial {
            file: check.file.to_owned(),
            key: key.to_owned(),
            found: name.to_owned(),
            available: Material::NAMES
                .into_iter()
                .chain(self.materials.keys().map(String::as_str))
                .collect::<Vec<_>>()
                .join(", "),
        })?;
        let of = |field: &str| format!("materials.{name}.{field}");
        check.color(&of("color"), material.color, 1.0, "three numbers from 0 to 1")?;
        for (field, value) in [("roughness", material.roughness), ("metallic", material.metallic)] {
            check.range(&of(field), value, (0.0..=1.0).contains(&value), "0 to 1")?;
        }
        check.range(&of("scale"), material.scale, material.scale >= 0.0, "a length, or 0 for automatic")?;
        Ok(material)
    }
}

/// Range checks that know the file's name.
struct Check<'a> {
    file: &'a str,
}

impl Check<'_> {
    fn error(&self, key: &str, found: String, expected: &'static str) -> SceneError {
        SceneError::OutOfRange { file: self.file.to_owned(), key: key.to_owned(), found, expected }
    }

    /// A file that is named in the scene file.
    fn beside(&self, file: &Path) -> PathBuf {
        Path::new(self.file).parent().unwrap_or(Path::new("")).join(file)
    }

    fn range(&self, key: &str, value: f32, ok: bool, expected: &'static str) -> Result<f32, SceneError> {
        if ok && value.is_finite() { Ok(value) } else { Err(self.error(key, value.to_string(), expected)) }
    }

    /// A coordinate relative to the origin, as `f32`.
    fn length(&self, key: &str, value: f64) -> Result<f32, SceneError> {
        self.range(key, value as f32, true, "a finite number")
    }

    fn color(
        &self,
        key: &str,
        color: [f32; 3],
        max: f32,
        expected: &'static str,
    ) -> Result<[f32; 3], SceneError> {
        let ok = color.iter().all(|c| (0.0..=max).contains(c));
        if ok { Ok(color) } else { Err(self.error(key, format!("{color:?}"), expected)) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const BOUNDS: Aabb = Aabb { min: Vec3::ZERO, max: Vec3::new(4.0, 2.0, 1.0) };

    fn resolve(text: &str) -> Result<Scene, SceneError> {
        let origin = DVec3::new(5e5, 0.0, 100.0);
        Description::from_toml(text, "scene.toml")?.resolve(BOUNDS, origin, UpAxis::Z, 0.1, "scene.toml")
    }

    #[test]
    fn an_empty_file_is_the_automatic_scene() {
        assert_eq!(resolve("").unwrap(), Scene::around(BOUNDS, UpAxis::Z, 0.1));
    }

    #[test]
    fn a_full_file_is_taken_at_its_word() {
        let scene = resolve(
            "[sun]\nelevation_deg = 30\nazimuth_deg = 90\n[sky]\nglow = 0\n\
             [floor]\nheight = 99.5\nmaterial = 'mine'\n[walls]\nvisible = true\nheight = 2\n\
             [[box]]\nmin = [500001, 0, 100]\nmax = [500002, 1, 101]\nmaterial = 'steel'\n\
             [materials.mine]\npattern = 'concrete'\ncolor = [0.2, 0.3, 0.4]\nscale = 0.25",
        )
        .unwrap();
        // 1e-6: sines in f32.
        assert!(scene.sun.direction.distance(Vec3::new(0.75f32.sqrt(), 0.0, 0.5)) < 1e-6);
        let floor = scene.floor.unwrap();
        assert_eq!((floor.height_world, floor.material.scale), (-0.5, 0.25));
        assert_eq!(scene.objects.len(), 2);
        assert_eq!(
            Aabb::of_points(&scene.objects[1].mesh.positions),
            Aabb { min: Vec3::X, max: Vec3::new(2.0, 1.0, 1.0) }
        );
        assert!(resolve("[floor]\nvisible = false").unwrap().floor.is_none());
    }

    #[test]
    fn the_manual_shows_what_can_be_read() {
        let manual = include_str!("../../../docs/scene.md");
        let example = manual.split("```toml").nth(1).and_then(|rest| rest.split("```").next()).unwrap();
        let description = Description::from_toml(example, "docs/scene.md").unwrap();
        assert!(
            !description.terrain.is_empty()
                && !description.boxes.is_empty()
                && !description.materials.is_empty()
        );
        // Other names are written out.
        for name in Material::NAMES {
            assert!(manual.contains(name), "{name}");
        }
    }

    #[test]
    fn mistakes_are_named_with_their_place() {
        let message = |text: &str| resolve(text).unwrap_err().to_string();
        let unknown = message("[floor]\nheigth = 1");
        assert!(
            unknown.contains("scene.toml") && unknown.contains("line 2") && unknown.contains("heigth"),
            "{unknown}"
        );
        let material = message("[floor]\nmaterial = 'marble'");
        assert!(material.contains("floor.material") && material.contains("tiles"), "{material}");
        assert!(message("[sun]\nelevation_deg = -3").contains("sun.elevation_deg is -3"));
        assert!(message("[sky]\nzenith = [nan, 0, 0]").contains("sky.zenith"));
        assert!(message("[[box]]\nmin = [0, 0, 0]\nmax = [1, 0, 1]").contains("box[0].max"));
        assert!(
            message("[materials.x]\nroughness = 7\n[floor]\nmaterial = 'x'")
                .contains("materials.x.roughness")
        );
    }
}
