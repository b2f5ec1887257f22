use std::sync::Arc;

use meniscus_gpu::Gpu;
use schemars::{JsonSchema, Schema, schema_for};
use serde::de::DeserializeOwned;

use super::{
    Adaptive, Bilateral, CurvatureFlow, Gaussian, NarrowRange, NarrowRangePaper, NoFilter, SurfaceFilter,
};
use crate::{FilterChoice, SsfrError};

/// Name of the filter that is used where none is named.
pub const DEFAULT: &str = NarrowRange::NAME;

type Parameters = serde_json::Map<String, serde_json::Value>;
type Create = dyn Fn(&Gpu, &Parameters) -> Result<Box<dyn SurfaceFilter>, SsfrError> + Send + Sync;

/// A filter by name: what it is, what parameters it takes, how it is made.
#[derive(Clone)]
pub struct FilterEntry {
    name: &'static str,
    about: &'static str,
    schema: Schema,
    create: Arc<Create>,
}

impl FilterEntry {
    /// A filter with parameters `P`, which describe themselves and have defaults; `create` checks their ranges.
    pub fn new<P: DeserializeOwned + JsonSchema>(
        name: &'static str,
        about: &'static str,
        create: impl Fn(&Gpu, P) -> Result<Box<dyn SurfaceFilter>, SsfrError> + Send + Sync + 'static,
    ) -> Self {
        let create = move |gpu: &Gpu, parameters: &Parameters| {
            let parameters = serde_json::from_value(serde_json::Value::Object(parameters.clone()))
                .map_err(|e| SsfrError::FilterParameters { filter: name, message: e.to_string() })?;
            create(gpu, parameters)
        };
        Self { name, about, schema: schema_for!(P), create: Arc::new(create) }
    }

    /// The name users type.
    pub fn name(&self) -> &'static str {
        self.name
    }

    /// One line for users.
    pub fn about(&self) -> &'static str {
        self.about
    }

    /// JSON schema of the parameters.
    pub fn schema(&self) -> &Schema {
        &self.schema
    }
}

/// The filters a program offers: a plain value.
#[derive(Clone)]
pub struct FilterRegistry(Vec<FilterEntry>);

/// The filters without parameters.
#[derive(serde::Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct NoParameters {}

impl FilterRegistry {
    /// The filters of this crate.
    pub fn builtin() -> Self {
        Self(vec![
            FilterEntry::new(
                NarrowRange::NAME,
                "smooths a surface without mixing it with others in front or behind (Truong and Yuksel 2018)",
                |gpu, params| Ok(Box::new(NarrowRange::new(gpu, params)?)),
            ),
            FilterEntry::new(
                NarrowRangePaper::NAME,
                "the narrow-range filter as published, without compensation of slopes; for comparison",
                |gpu, params| Ok(Box::new(NarrowRangePaper::new(gpu, params)?)),
            ),
            FilterEntry::new(
                Bilateral::NAME,
                "weighs by depth as well as by place; leaves silhouettes rough (Tomasi and Manduchi 1998)",
                |gpu, params| Ok(Box::new(Bilateral::new(gpu, params)?)),
            ),
            FilterEntry::new(
                CurvatureFlow::NAME,
                "moves the surface with its mean curvature, across no edge (van der Laan et al. 2009)",
                |gpu, params| Ok(Box::new(CurvatureFlow::new(gpu, params)?)),
            ),
            FilterEntry::new(
                Adaptive::NAME,
                "bilateral in simple tiles, narrow-range in complex ones; looks like narrow-range and costs more",
                |gpu, params| Ok(Box::new(Adaptive::new(gpu, params)?)),
            ),
            FilterEntry::new(
                Gaussian::NAME,
                "averages all that is near in the picture, at any depth; for comparison",
                |gpu, params| Ok(Box::new(Gaussian::new(gpu, params)?)),
            ),
            FilterEntry::new::<NoParameters>(
                NoFilter::NAME,
                "no smoothing: every particle shows as a sphere",
                |gpu, _| Ok(Box::new(NoFilter::new(gpu)?)),
            ),
        ])
    }

    /// Adds `entry`, in place of one of the same name.
    #[must_use]
    pub fn with_filter(mut self, entry: FilterEntry) -> Self {
        self.0.retain(|e| e.name != entry.name);
        self.0.push(entry);
        self
    }

    /// All filters, in the order added.
    pub fn entries(&self) -> &[FilterEntry] {
        &self.0
    }

    /// Makes the filter that `choice` names.
    ///
    /// # Errors
    /// Unknown name, parameters that do not fit, or a shader that the driver does not take.
    pub fn create(&self, gpu: &Gpu, choice: &FilterChoice) -> Result<Box<dyn SurfaceFilter>, SsfrError> {
        let entry = self.0.iter().find(|e| e.name == choice.name).ok_or_else(|| SsfrError::NoSuchFilter {
            wanted: choice.name.clone(),
            available: self.0.iter().map(|e| e.name).collect::<Vec<_>>().join(", "),
        })?;
        (entry.create)(gpu, &choice.parameters)
    }
}
