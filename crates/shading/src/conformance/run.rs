use std::cell::RefCell;

use meniscus_gpu::Gpu;
use serde_json::Value;

use super::Frame;
use crate::{
    LightingChoice, LightingModel, LightingPass, LightingRegistry, Parameters, Promises, ShadingError,
};

/// A lighting model on a device.
pub(super) struct Run<'a> {
    gpu: &'a Gpu,
    registry: &'a LightingRegistry,
    choice: &'a LightingChoice,
    pass: RefCell<Box<dyn LightingPass>>,
    pub promises: Promises,
}

impl<'a> Run<'a> {
    pub fn new(
        gpu: &'a Gpu,
        registry: &'a LightingRegistry,
        choice: &'a LightingChoice,
    ) -> Result<Self, ShadingError> {
        let model = registry.make(choice)?;
        let pass = RefCell::new(model.compile(gpu)?);
        Ok(Self { gpu, registry, choice, pass, promises: model.promises() })
    }

    /// The model with some parameters changed; those that it does not have are left out.
    pub fn model(&self, changes: &[(&str, Value)]) -> Result<Box<dyn LightingModel>, String> {
        let mut choice = self.choice.clone();
        let known = self.registry.make(&choice).map_err(|e| e.to_string())?.parameters();
        for (name, value) in changes.iter().filter(|(name, _)| known.contains_key(*name)) {
            choice.parameters.insert((*name).to_owned(), value.clone());
        }
        self.registry.make(&choice).map_err(|e| e.to_string())
    }

    /// The pass's picture.
    pub fn on_gpu(&self, frame: &Frame) -> Result<Vec<[f32; 4]>, String> {
        self.changed_on_gpu(frame, &[])
    }

    /// The pass's picture with some parameters changed.
    pub fn changed_on_gpu(&self, frame: &Frame, changes: &[(&str, Value)]) -> Result<Vec<[f32; 4]>, String> {
        let parameters = self.model(changes)?.parameters();
        self.set(&parameters).map_err(|e| format!("the pass refuses what the model takes: {e}"))?;
        self.draw(frame)
    }

    /// Sets the pass's parameters as they are.
    pub fn set(&self, parameters: &Parameters) -> Result<(), ShadingError> {
        self.pass.borrow_mut().set_parameters(parameters)
    }

    /// The pass's picture with the parameters it has.
    pub fn draw(&self, frame: &Frame) -> Result<Vec<[f32; 4]>, String> {
        frame.draw(self.gpu, &**self.pass.borrow()).map_err(|e| format!("the device: {e}"))
    }
}
