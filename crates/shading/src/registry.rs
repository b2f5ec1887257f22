use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::{
    BlinnPhong, Fluid, Granular, Lambert, LightingModel, OpaqueLiquid, Parameters, PointLight, ShadingError,
    Vtk,
};

/// Which lighting model shades the water.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct LightingChoice {
    /// Name in the [`LightingRegistry`].
    pub name: String,
    /// The model's own parameters, as its schema describes; what is left out has its default.
    pub parameters: Parameters,
}

impl Default for LightingChoice {
    fn default() -> Self {
        Self { name: Fluid::NAME.to_owned(), parameters: Parameters::new() }
    }
}

/// Makes a model from parameters, of which any may be left out.
type Make = fn(&Parameters) -> Result<Box<dyn LightingModel>, ShadingError>;

/// The lighting models that a program knows: a plain value.
#[derive(Clone, Debug)]
pub struct LightingRegistry {
    entries: Vec<(&'static str, Make)>,
}

impl LightingRegistry {
    /// The models of this crate, the default first.
    pub fn builtin() -> Self {
        Self { entries: Vec::new() }
            .with(Fluid::NAME, Fluid::make)
            .with(Vtk::NAME, Vtk::make)
            .with(PointLight::NAME, PointLight::make)
            .with(Lambert::NAME, Lambert::make)
            .with(BlinnPhong::NAME, BlinnPhong::make)
            .with(OpaqueLiquid::NAME, OpaqueLiquid::make)
            .with(Granular::NAME, Granular::make)
    }

    /// With the model `name`, which replaces one of the same name.
    #[must_use]
    pub fn with(mut self, name: &'static str, make: Make) -> Self {
        match self.entries.iter_mut().find(|(n, _)| *n == name) {
            Some(entry) => entry.1 = make,
            None => self.entries.push((name, make)),
        }
        self
    }

    /// All names, the default first.
    pub fn names(&self) -> impl Iterator<Item = &'static str> + '_ {
        self.entries.iter().map(|(name, _)| *name)
    }

    /// The chosen model.
    ///
    /// # Errors
    /// A name that is not registered, or parameters that the model refuses.
    pub fn make(&self, choice: &LightingChoice) -> Result<Box<dyn LightingModel>, ShadingError> {
        let (_, make) = self.entries.iter().find(|(name, _)| *name == choice.name).ok_or_else(|| {
            ShadingError::UnknownModel {
                found: choice.name.clone(),
                available: self.names().collect::<Vec<_>>().join(", "),
            }
        })?;
        make(&choice.parameters)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn models_are_found_by_name_and_mistakes_are_named() {
        let registry = LightingRegistry::builtin();
        for name in registry.names() {
            let choice = LightingChoice { name: name.to_owned(), ..Default::default() };
            let model = registry.make(&choice).unwrap();
            assert_eq!(model.name(), name);
            // What a model says of itself is what it takes.
            registry.make(&LightingChoice { parameters: model.parameters(), ..choice }).unwrap();
        }
        let choose = |name: &str, parameters: serde_json::Value| {
            let parameters = parameters.as_object().unwrap().clone();
            registry.make(&LightingChoice { name: name.into(), parameters }).err().unwrap().to_string()
        };
        assert!(choose("fluit", serde_json::json!({})).contains("fluid"));
        assert!(choose("fluid", serde_json::json!({"roughnes": 1})).contains("roughness"));
        assert!(choose("fluid", serde_json::json!({"roughness": 9})).contains("roughness is 9"));
    }
}
