use std::path::PathBuf;

use meniscus_compositor::CompositorParameters;
use meniscus_core::Choice;
use meniscus_gpu::AdapterSummary;
use meniscus_lod::{LodParams, Mode};
use meniscus_scene::Description;
use meniscus_shading::{LightingChoice, VTK_NAMES};
use meniscus_ssfr::{AnisotropyParams, FilterChoice, SsfrParams};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use serde_json::{Map, Value};

use crate::world::Water;
use crate::{ColorSettings, FoamSettings, Registry, World};

/// Every parameter of a picture besides its camera and size. Stages describe their own; `stage.name` is the key on the
/// command line.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Settings {
    /// Level of detail.
    pub lod: LodParams,
    /// Splats, filter, thickness.
    pub surface: SsfrParams,
    /// Lighting model of the water and its parameters.
    pub lighting: LightingChoice,
    /// Colour of the water by an attribute.
    pub color: ColorSettings,
    /// Foam, spray and bubbles.
    pub foam: FoamSettings,
    /// Surroundings.
    pub scene: SceneSettings,
    /// Tone mapping and what comes after.
    pub post: CompositorParameters,
}

/// What surrounds the water, beside what a scene file says.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct SceneSettings {
    /// Scene file (TOML); none: the automatic scene.
    pub file: Option<PathBuf>,
    /// Whether there is a floor, in place of what the file says.
    pub floor: Option<bool>,
    /// Whether the walls of a tank around the data are drawn, in place of what the file says.
    pub walls: Option<bool>,
    /// A picture of the surroundings, .hdr or .exr, in place of the sky.
    pub environment: Option<PathBuf>,
    /// Azimuth (from north, clockwise seen from above) and elevation of the sun in degrees; without a picture of the
    /// surroundings the sky is what the atmosphere makes of it.
    pub sun: Option<[f32; 2]>,
    /// Whether the sun throws shadows: of objects on objects and on water, and of water on what lies under and behind it. For these,
    /// the water is drawn a second time as the sun sees it, but only when data or sun change.
    pub shadows: bool,
    /// How strongly waves gather and scatter the sun's light on the ground, 0 (not at all) to 1 (as light does); needs shadows.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub caustics: f32,
}

impl Default for SceneSettings {
    fn default() -> Self {
        Self {
            file: None,
            floor: None,
            walls: None,
            environment: None,
            sun: None,
            shadows: true,
            caustics: 0.3,
        }
    }
}

impl SceneSettings {
    fn validate(&self) -> Result<(), SettingsError> {
        if (0.0..=1.0).contains(&self.caustics) {
            return Ok(());
        }
        Err(SettingsError::Stage(format!("scene.caustics is {}, expected 0 to 1", self.caustics)))
    }

    pub(crate) fn apply(&self, mut description: Description) -> Description {
        if let Some(floor) = self.floor {
            description.floor.visible = Some(floor);
        }
        if let Some(walls) = self.walls {
            description.walls.visible = walls;
        }
        if let Some(file) = &self.environment {
            // Relative to where the program runs, not to the scene file.
            let absolute = std::path::absolute(file).unwrap_or_else(|_| file.clone());
            description.environment.file = Some(absolute);
        }
        if let Some([azimuth, elevation]) = self.sun {
            description.sun.azimuth_deg = Some(azimuth);
            description.sun.elevation_deg = Some(elevation);
            description.sky.physical = true;
        }
        description
    }
}

/// A parameter that cannot be set.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum SettingsError {
    /// No such key.
    #[error(
        "there is no parameter `{key}`; under `{parent}` there are: {available}. `--param list` prints all"
    )]
    UnknownKey {
        /// As given.
        key: String,
        /// The longest known beginning, in words.
        parent: String,
        /// What follows it.
        available: String,
    },
    /// The value does not fit.
    #[error("parameter `{key}` cannot be `{value}`: {message}")]
    Value {
        /// The key.
        key: String,
        /// As given.
        value: String,
        /// What was expected.
        message: String,
    },
    /// A stage refuses its parameters.
    #[error("{0}")]
    Stage(String),
}

impl SettingsError {
    pub(crate) fn stage(error: impl std::fmt::Display) -> Self {
        Self::Stage(error.to_string())
    }
}

/// Maps whose keys are known to the chosen filter or lighting model, not to us.
const OPEN_MAPS: [&str; 2] = ["surface.filter.parameters", "lighting.parameters"];

/// Keys as users type and see them, and where they live; the first beginning that fits is taken.
const SHORT_KEYS: [(&str, &str); 6] = [
    ("filter.name", "surface.filter.name"),
    ("filter.", "surface.filter.parameters."),
    ("thickness.", "surface.thickness."),
    ("anisotropy.", "surface.anisotropy."),
    ("lighting.name", "lighting.name"),
    ("lighting.", "lighting.parameters."),
];

/// Keys that VTK's fluid mapper has another name for, beside those of lighting models. What differs in unit is no alias.
const VTK_KEYS: [(&str, &str); 1] = [("SurfaceFilterIterations", "filter.iterations")];

fn key_of_vtk(key: &str) -> Option<String> {
    let name = key.strip_prefix("lighting.").or(key.strip_prefix("filter.")).unwrap_or(key);
    let named = |(vtk, ours): &(&str, &'static str)| (*vtk == name).then_some(*ours);
    let lighting = || VTK_NAMES.iter().find_map(named).map(|ours| format!("lighting.{ours}"));
    VTK_KEYS.iter().find_map(named).map(str::to_owned).or_else(lighting)
}

fn long_key(key: &str) -> String {
    let translated = key_of_vtk(key);
    let key = translated.as_deref().unwrap_or(key);
    let found = SHORT_KEYS.iter().find_map(|(short, long)| Some((long, key.strip_prefix(short)?)));
    found.map_or_else(|| key.to_owned(), |(long, rest)| format!("{long}{rest}"))
}

fn short_key(key: &str) -> String {
    let found = SHORT_KEYS.iter().find_map(|(short, long)| Some((short, key.strip_prefix(long)?)));
    found.map_or_else(|| key.to_owned(), |(short, rest)| format!("{short}{rest}"))
}

impl Settings {
    /// The key that `key` stands for, if it is a name of VTK's fluid mapper: `RefractiveIndex`, or `lighting.RefractiveIndex`.
    pub fn key_of_vtk(key: &str) -> Option<String> {
        key_of_vtk(key)
    }

    /// Whether particles are left out in return for fewer details, and not only as far as nobody sees it.
    pub(crate) fn is_thinned(&self) -> bool {
        self.lod.mode == Mode::Threshold && !self.lod.is_full()
    }

    /// How the surface of `water` is made, where that is known: as [`Self::surface`] says, but where nothing is said of the
    /// smoothing, with less of it for ellipsoids: they lie closer to the surface than spheres, unless they grow to stand for others.
    /// And with more where larger spheres are drawn because particles lie unevenly.
    pub(crate) fn water_surface(&self, water: Option<Water>) -> SsfrParams {
        let mut surface = self.surface.clone();
        if let Some(water) = water {
            surface.anisotropy = surface.anisotropy.resolved(water.particles);
        }
        if surface.filter != FilterChoice::default() {
            return surface;
        }
        let unevenness = water.map_or(0.0, |water| water.unevenness);
        let smoothing = if surface.anisotropy.is_on() && !self.is_thinned() {
            // With 0.6, ellipsoids are nearer to a reconstructed mesh than spheres with the filter's own in 27 of 30 numbers
            // (benches/RESULTS.md); but where particles lie unevenly, lines that are seen through it are kinked.
            Some((0.8 + 1.2 * unevenness, if unevenness > 0.0 { 2 } else { 1 }))
        } else {
            (unevenness > 0.0).then_some((1.0 + unevenness, 2))
        };
        if let Some((sigma, iterations)) = smoothing {
            let sigma = (100.0 * sigma).round() / 100.0;
            let chosen = [
                ("sigma".to_owned(), Value::from(sigma)),
                ("iterations".to_owned(), Value::from(iterations)),
            ];
            surface.filter.parameters.extend(chosen);
        }
        surface
    }

    /// Sets the parameter `key` (dots between stage and name, as [`Self::describe`] lists them) to `value`, written as in
    /// TOML; a bare word is a string, and `auto` leaves the choice to the stage.
    ///
    /// # Errors
    /// An unknown key, with those that exist; a value of the wrong type.
    pub fn set(&mut self, key: &str, value: &str) -> Result<(), SettingsError> {
        let fail =
            |message: String| SettingsError::Value { key: key.to_owned(), value: value.to_owned(), message };
        let mut tree = serde_json::to_value(&*self).map_err(|e| fail(e.to_string()))?;
        *slot(&mut tree, &long_key(key))? = parse(value);
        *self = serde_json::from_value(tree).map_err(|e| fail(e.to_string()))?;
        Ok(())
    }

    /// Chooses the surface filter, with its default parameters unless it is chosen already.
    ///
    /// # Errors
    /// No filter of that name.
    pub fn choose_filter(&mut self, registry: &Registry, name: &str) -> Result<(), SettingsError> {
        if self.surface.filter.name != name {
            self.surface.filter.name = name.to_owned();
            self.surface.filter.parameters.clear();
        }
        self.validate(registry)
    }

    /// Chooses the lighting model, with its default parameters unless it is chosen already.
    ///
    /// # Errors
    /// No model of that name.
    pub fn choose_lighting(&mut self, registry: &Registry, name: &str) -> Result<(), SettingsError> {
        if self.lighting.name != name {
            self.lighting.name = name.to_owned();
            self.lighting.parameters.clear();
        }
        self.validate(registry)
    }

    /// Shortens the exposure for a white liquid, so that its lit side keeps its shape, and says so; `None` where that is not needed: the
    /// liquid is dark enough, or its colours stand for numbers. For pictures whose exposure nobody has set.
    pub fn expose_for_liquid(&mut self, registry: &Registry) -> Option<Choice> {
        let albedo = registry.lighting.make(&self.lighting).map_or(0.0, |model| model.body_albedo());
        let stops = (10.0 * (BRIGHTEST_ALBEDO / albedo).log2()).round() / 10.0;
        if stops >= 0.0 || self.color.by.is_some() {
            return None;
        }
        self.post.exposure = Some(stops);
        Some(Choice {
            what: "exposure".into(),
            value: format!("{stops} stops"),
            reason: "the liquid is white".into(),
            flag: "--exposure EV".into(),
        })
    }

    /// Chooses what suits `adapter`, where nothing else is asked for: a discrete GPU draws more particles as ellipsoids.
    pub fn suit(&mut self, adapter: &AdapterSummary) {
        if adapter.is_discrete() {
            let most = &mut self.surface.anisotropy.auto_particles;
            *most = most.or(Some(AnisotropyParams::AUTO_PARTICLES_DISCRETE));
        }
    }

    /// Checks all ranges and names.
    ///
    /// # Errors
    /// The first thing that does not fit.
    pub fn validate(&self, registry: &Registry) -> Result<(), SettingsError> {
        self.lod.validate().map_err(SettingsError::stage)?;
        self.surface.validate().map_err(SettingsError::stage)?;
        self.post.validate().map_err(SettingsError::stage)?;
        self.color.validate().map_err(SettingsError::stage)?;
        self.scene.validate()?;
        self.foam.validate()?;
        let known = |kind: &str, name: &str, names: Vec<&str>| {
            if names.contains(&name) {
                return Ok(());
            }
            Err(SettingsError::Stage(format!("there is no {kind} `{name}`; there are: {}", names.join(", "))))
        };
        known("filter", &self.surface.filter.name, registry.filter_names())?;
        known("lighting model", &self.lighting.name, registry.lighting_names())
    }

    /// Whether the picture has an alpha channel.
    pub fn transparent(&self) -> bool {
        self.post.transparent
    }

    /// All parameters as `(key, value)`, those of the chosen filter and lighting model with their defaults.
    pub fn describe(&self, registry: &Registry) -> Vec<(String, String)> {
        let mut lines = Vec::new();
        flatten("", &self.effective(registry, None), &mut lines);
        lines
    }

    /// All parameters as a tree of JSON, as they are used for the water of `world`, if it is known; those of the chosen filter and
    /// lighting model with their defaults.
    pub fn effective(&self, registry: &Registry, world: Option<&World>) -> Value {
        let surface = self.water_surface(world.map(World::water));
        let in_use = Self { surface, ..self.clone() };
        let mut tree = serde_json::to_value(in_use).unwrap_or_default();
        let defaults = [
            registry.filter_defaults(&self.surface.filter.name),
            registry.lighting_effective(&self.lighting),
        ];
        for (map, defaults) in OPEN_MAPS.iter().zip(defaults) {
            if let Ok(Value::Object(parameters)) = slot(&mut tree, map) {
                for (name, default) in defaults {
                    parameters.entry(name).or_insert(default);
                }
            }
        }
        tree
    }
}

/// Albedo of a body whose side that faces the sun is as bright as the neutral tone curve keeps, 0.8 (Khronos PBR neutral): in the
/// automatic scene, and in others that are brought to its brightness, sun and sky light that side by 1.2 of what they give a white level floor.
const BRIGHTEST_ALBEDO: f32 = 0.8 / 1.2;

/// The value at `key`.
fn slot<'a>(tree: &'a mut Value, key: &str) -> Result<&'a mut Value, SettingsError> {
    let mut here = tree;
    let mut path = String::new();
    for name in key.split('.') {
        let Value::Object(map) = here else {
            return Err(unknown(key, &path, &Map::new()));
        };
        if !map.contains_key(name) {
            if !OPEN_MAPS.contains(&path.as_str()) {
                return Err(unknown(key, &path, map));
            }
            map.insert(name.to_owned(), Value::Null);
        }
        if !path.is_empty() {
            path.push('.');
        }
        path.push_str(name);
        here = &mut map[name];
    }
    Ok(here)
}

fn unknown(key: &str, parent: &str, map: &Map<String, Value>) -> SettingsError {
    let available =
        if map.is_empty() { "none".to_owned() } else { map.keys().cloned().collect::<Vec<_>>().join(", ") };
    let parent =
        if parent.is_empty() { "the top level".to_owned() } else { format!("`{}`", short_key(parent)) };
    SettingsError::UnknownKey { key: key.to_owned(), parent, available }
}

/// A TOML value; what is none is a string, and so are `nan` and `inf`, for which JSON has nothing but what stands for `auto`.
fn parse(text: &str) -> Value {
    if text == AUTO {
        return Value::Null;
    }
    toml::from_str::<Map<String, Value>>(&format!("value = {text}"))
        .ok()
        .and_then(|mut table| table.remove("value"))
        .filter(|value| !value.is_null())
        .unwrap_or_else(|| Value::String(text.to_owned()))
}

/// What a parameter without a value is called.
const AUTO: &str = "auto";

fn flatten(path: &str, value: &Value, lines: &mut Vec<(String, String)>) {
    match value {
        Value::Object(map) => {
            for (name, inner) in map {
                let path = if path.is_empty() { name.clone() } else { format!("{path}.{name}") };
                flatten(&path, inner, lines);
            }
        }
        leaf => lines.push((short_key(path), display(leaf))),
    }
}

/// As a user would write it. Parameters are `f32`; their shortest form is that of an `f32`, not of the `f64` in JSON.
fn display(value: &Value) -> String {
    match value {
        Value::Null => AUTO.to_owned(),
        Value::Array(items) => format!("[{}]", items.iter().map(display).collect::<Vec<_>>().join(", ")),
        Value::Number(number) => match number.as_f64() {
            Some(float) if number.is_f64() => (float as f32).to_string(),
            _ => number.to_string(),
        },
        Value::String(text) => text.clone(),
        other => other.to_string(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_parameter_that_is_listed_can_be_set_to_what_is_listed() {
        let registry = Registry::builtin();
        let mut settings = Settings::default();
        let listed = settings.describe(&registry);
        assert!(listed.iter().any(|(key, _)| key == "filter.name"), "{listed:?}");
        for (key, value) in &listed {
            settings.set(key, value).unwrap();
        }
        settings.validate(&registry).unwrap();
        assert_eq!(settings.describe(&registry), listed);
    }

    #[test]
    fn values_are_taken_with_their_types() {
        let mut settings = Settings::default();
        settings.set("lod.threshold", "0.3").unwrap();
        settings.set("scene.walls", "true").unwrap();
        settings.set("scene.file", "my scene.toml").unwrap();
        settings.set("thickness.scale", "4").unwrap();
        settings.set("lighting.roughness", "0.5").unwrap();
        assert_eq!(settings.lod.threshold, 0.3);
        assert_eq!(settings.scene.walls, Some(true));
        assert_eq!(settings.scene.file, Some(PathBuf::from("my scene.toml")));
        assert_eq!(settings.surface.thickness.scale, 4);
        assert_eq!(settings.lighting.parameters["roughness"], 0.5);
        settings.set("scene.walls", "auto").unwrap();
        assert_eq!(settings.scene.walls, None);
        settings.set("post.exposure", "1.5").unwrap();
        assert_eq!(settings.post.exposure, Some(1.5));
        settings.set("post.exposure", "auto").unwrap();
        assert_eq!(settings.post.exposure, None);
    }

    #[test]
    fn the_surface_that_is_used_is_the_one_that_is_listed() {
        let registry = Registry::builtin();
        let listed = |settings: &Settings, key: &str| -> String {
            settings.describe(&registry).into_iter().find(|(found, _)| found == key).unwrap().1
        };
        let mut settings = Settings::default();
        assert_eq!(listed(&settings, "filter.sigma"), "1");
        let few = Water { particles: 1, unevenness: 0.0 };
        let of_few =
            |settings: &Settings| settings.water_surface(Some(few)).filter.parameters.contains_key("sigma");
        assert!(of_few(&settings));
        settings.set("lod.threshold", "0.3").unwrap();
        assert!(!of_few(&settings), "ellipsoids that stand for others");
        settings.lod.mode = Mode::ErrorBound;
        assert!(of_few(&settings));
        settings.set("anisotropy.form", "yu-turk").unwrap();
        assert_eq!(["filter.sigma", "filter.iterations"].map(|key| listed(&settings, key)), ["0.8", "1"]);
        // Random particles, few and many.
        for particles in [1, 10_000_000] {
            let random = Water { particles, unevenness: 1.0 };
            let parameters = Settings::default().water_surface(Some(random)).filter.parameters;
            assert_eq!((&parameters["sigma"], &parameters["iterations"]), (&2.0.into(), &2.into()));
        }
        settings.set("filter.sigma", "2").unwrap();
        assert_eq!(["filter.sigma", "filter.iterations"].map(|key| listed(&settings, key)), ["2", "2"]);
    }

    #[test]
    fn discrete_gpus_draw_more_particles_as_ellipsoids_unless_a_number_is_given() {
        let form = |device_type: &str, asked: Option<&str>| {
            let mut settings = Settings::default();
            if let Some(most) = asked {
                settings.set("anisotropy.auto_particles", most).unwrap();
            }
            settings.suit(&AdapterSummary {
                name: String::new(),
                backend: String::new(),
                device_type: device_type.to_owned(),
                driver: String::new(),
            });
            settings.water_surface(Some(Water { particles: 1_000_000, unevenness: 0.0 })).anisotropy.is_on()
        };
        assert_eq!(
            [form("DiscreteGpu", None), form("IntegratedGpu", None), form("Cpu", None)],
            [true, false, false]
        );
        assert_eq!([form("DiscreteGpu", Some("400000")), form("Cpu", Some("1000000"))], [false, true]);
    }

    #[test]
    fn vtk_names_stand_for_our_keys() {
        let mut settings = Settings::default();
        settings.set("RefractiveIndex", "1.4").unwrap();
        settings.set("lighting.AttenuationScale", "3").unwrap();
        settings.set("SurfaceFilterIterations", "4").unwrap();
        let listed = settings.describe(&Registry::builtin());
        for (key, value) in [
            ("lighting.refractive_index", "1.4"),
            ("lighting.attenuation_scale", "3"),
            ("filter.iterations", "4"),
        ] {
            assert!(listed.contains(&(key.to_owned(), value.to_owned())), "{key} in {listed:?}");
        }
        assert_eq!(Settings::key_of_vtk("lighting.roughness"), None);
    }

    #[test]
    fn presets_are_listed_with_what_they_mean() {
        let mut settings = Settings::default();
        settings.set("lighting.preset", "milk").unwrap();
        settings.set("lighting.roughness", "0.5").unwrap();
        let listed = settings.describe(&Registry::builtin());
        for (key, value) in
            [("lighting.preset", "milk"), ("lighting.turbidity", "60"), ("lighting.roughness", "0.5")]
        {
            assert!(listed.contains(&(key.to_owned(), value.to_owned())), "{key} in {listed:?}");
        }
    }

    #[test]
    fn white_liquids_are_exposed_for_and_no_others() {
        let registry = Registry::builtin();
        let exposed = |model: &str, parameters: &[(&str, &str)]| {
            let mut settings = Settings::default();
            settings.choose_lighting(&registry, model).unwrap();
            for (key, value) in parameters {
                settings.set(key, value).unwrap();
            }
            let choice = settings.expose_for_liquid(&registry);
            assert_eq!(choice.is_some(), settings.post.exposure != Some(0.0));
            settings.post.exposure
        };
        for dark in ["clear", "sea", "river", "mud", "oil"] {
            assert_eq!(exposed("fluid", &[("lighting.preset", dark)]), Some(0.0), "{dark}");
            assert_eq!(exposed("opaque", &[("lighting.preset", dark)]), Some(0.0), "{dark}");
        }
        // log2(0.8 / 1.2 / 0.93), to tenths.
        assert_eq!(exposed("fluid", &[("lighting.preset", "milk")]), Some(-0.5));
        assert_eq!(exposed("opaque", &[]), Some(-0.5));
        assert_eq!(exposed("opaque", &[("lighting.color", "[1.0, 1.0, 1.0]")]), Some(-0.6));
        assert_eq!(exposed("opaque", &[("color.by", "velocity")]), Some(0.0));
    }

    #[test]
    fn mistakes_show_what_there_is() {
        let mut settings = Settings::default();
        let before = settings.clone();
        let message = |result: Result<(), SettingsError>| result.unwrap_err().to_string();
        let unknown = message(settings.set("post.exposur", "1"));
        assert!(unknown.contains("post.exposur") && unknown.contains("exposure"), "{unknown}");
        assert!(message(settings.set("pots.exposure", "1")).contains("lighting"));
        for value in ["bright", "nan", "inf"] {
            let wrong = message(settings.set("post.exposure", value));
            assert!(wrong.contains(value), "{wrong}");
        }
        assert_eq!(settings, before);
        let filter = message(settings.choose_filter(&Registry::builtin(), "median"));
        assert!(filter.contains("median") && filter.contains("narrow-range"), "{filter}");
    }
}
