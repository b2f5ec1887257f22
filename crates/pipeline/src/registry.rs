use meniscus_shading::{LightingChoice, LightingModel, LightingRegistry, Parameters, ShadingError};
use meniscus_ssfr::{FilterEntry, FilterRegistry};

/// The surface filters and lighting models that a program offers: a plain value, which a team extends with its own.
#[derive(Clone)]
pub struct Registry {
    pub(crate) filters: FilterRegistry,
    pub(crate) lighting: LightingRegistry,
}

impl Registry {
    /// What meniscus comes with.
    pub fn builtin() -> Self {
        Self { filters: FilterRegistry::builtin(), lighting: LightingRegistry::builtin() }
    }

    /// With another surface filter, which replaces one of the same name.
    #[must_use]
    pub fn with_filter(self, entry: FilterEntry) -> Self {
        Self { filters: self.filters.with_filter(entry), ..self }
    }

    /// With another lighting model, which replaces one of the same name.
    #[must_use]
    pub fn with_lighting(
        self,
        name: &'static str,
        make: fn(&Parameters) -> Result<Box<dyn LightingModel>, ShadingError>,
    ) -> Self {
        Self { lighting: self.lighting.with(name, make), ..self }
    }

    /// Names of the filters.
    pub fn filter_names(&self) -> Vec<&str> {
        self.filters.entries().iter().map(FilterEntry::name).collect()
    }

    /// Names of the lighting models.
    pub fn lighting_names(&self) -> Vec<&str> {
        self.lighting.names().collect()
    }

    /// Parameters of the filter `name` with their defaults; empty for an unknown one.
    pub(crate) fn filter_defaults(&self, name: &str) -> Parameters {
        let entry = self.filters.entries().iter().find(|entry| entry.name() == name);
        let properties = entry.and_then(|e| e.schema().get("properties")).and_then(|p| p.as_object());
        properties
            .into_iter()
            .flatten()
            .map(|(name, schema)| (name.clone(), schema.get("default").cloned().unwrap_or_default()))
            .collect()
    }

    /// All parameters of the chosen lighting model as they are in effect; empty for a model or parameters that do not exist.
    pub(crate) fn lighting_effective(&self, choice: &LightingChoice) -> Parameters {
        self.lighting.make(choice).map(|model| model.parameters()).unwrap_or_default()
    }
}
