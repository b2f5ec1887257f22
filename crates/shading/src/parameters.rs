use serde_json::Value;

use crate::vtk_names;
use crate::{Formula, Liquid, Parameters, ShadingError};

/// The parameters of `F` from JSON: what the preset says, and over it what is given; null leaves a value as it is.
///
/// # Errors
/// Names that `F` does not have, wrong types, values outside of the ranges in the schema.
pub(crate) fn read<F: Formula>(given: &Parameters) -> Result<F, ShadingError> {
    let fail = |message: String| ShadingError::Parameters { model: F::NAME, message };
    let base =
        match given.get(PRESET).filter(|name| !name.is_null()) {
            Some(name) => F::of_liquid(serde_json::from_value(name.clone()).map_err(|_| {
                fail(format!("preset is {name}, expected one of {}", Liquid::NAMES.join(", ")))
            })?),
            None => F::default(),
        };
    let mut all = write(&base);
    for (name, value) in given.iter().filter(|(_, value)| !value.is_null()) {
        let known = vtk_names::ours(name).unwrap_or(name);
        if !all.contains_key(known) {
            let names = all.keys().map(String::as_str).collect::<Vec<_>>().join(", ");
            return Err(fail(format!("there is no parameter `{name}`; there are: {names}")));
        }
        // Each value on its own, so that the message can name it.
        let mut one = all.clone();
        one[known] = value.clone();
        serde_json::from_value::<F>(one.clone().into()).map_err(|e| fail(format!("{known}: {e}")))?;
        all = one;
    }
    let parameters: F = serde_json::from_value(all.into()).map_err(|e| fail(e.to_string()))?;
    check(&parameters)?;
    Ok(parameters)
}

/// The parameter that says what the others are if they are not given.
const PRESET: &str = "preset";

/// All parameters as JSON.
pub(crate) fn write<F: Formula>(parameters: &F) -> Parameters {
    match serde_json::to_value(parameters) {
        Ok(Value::Object(map)) => map,
        _ => Parameters::new(),
    }
}

/// Compares every value with its range in the schema.
///
/// # Errors
/// [`ShadingError::OutOfRange`] for the first value that does not fit (NaN never fits).
pub(crate) fn check<F: Formula>(parameters: &F) -> Result<(), ShadingError> {
    let schema = schemars::schema_for!(F);
    let properties = schema.get("properties").and_then(Value::as_object);
    for (name, value) in write(parameters) {
        let Some(property) = properties.and_then(|all| all.get(&name)) else { continue };
        match &value {
            Value::Array(items) => {
                let each = property.get("items").unwrap_or(&Value::Null);
                for (item, value) in items.iter().enumerate() {
                    check_one::<F>(&format!("{name}[{item}]"), value, each)?;
                }
            }
            one => check_one::<F>(&name, one, property)?,
        }
    }
    Ok(())
}

fn check_one<F: Formula>(name: &str, value: &Value, property: &Value) -> Result<(), ShadingError> {
    let limit = |key: &str| property.get(key).and_then(Value::as_f64).map(|limit| limit as f32);
    let (Some(low), Some(high)) = (limit("minimum"), limit("maximum")) else { return Ok(()) };
    // What is not finite has no number in JSON; neither has what is left out, where the schema allows that.
    let may_be_left_out =
        property.get("type").and_then(Value::as_array).is_some_and(|types| types.contains(&"null".into()));
    if value.is_null() && may_be_left_out {
        return Ok(());
    }
    let found = value.as_f64().map_or(f32::NAN, |found| found as f32);
    if (low..=high).contains(&found) {
        return Ok(());
    }
    let expected = format!("{low} to {high}");
    Err(ShadingError::OutOfRange { model: F::NAME, name: name.to_owned(), found, expected })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{FluidParameters, LightingChoice, LightingRegistry, VtkParameters};

    fn fluid(json: &str) -> Result<FluidParameters, ShadingError> {
        read(&serde_json::from_str(json).unwrap())
    }

    #[test]
    fn presets_give_way_to_what_is_given() {
        let milk = fluid(r#"{"preset": "milk"}"#).unwrap();
        let thin = fluid(r#"{"turbidity": 3.0, "preset": "milk"}"#).unwrap();
        assert_eq!(milk, FluidParameters::of_liquid(Liquid::Milk));
        assert_eq!(thin.medium.turbidity, 3.0);
        assert_eq!(thin.medium.attenuation_color, milk.medium.attenuation_color);
        assert_ne!(milk.medium.attenuation_color, FluidParameters::default().medium.attenuation_color);
        let unknown = fluid(r#"{"preset": "beer"}"#).unwrap_err().to_string();
        assert!(unknown.contains("beer") && unknown.contains("mud"), "{unknown}");
    }

    #[test]
    fn vtk_names_are_understood() {
        let ours = fluid(r#"{"refractive_index": 1.5, "attenuation_scale": 2.0}"#).unwrap();
        assert_eq!(fluid(r#"{"RefractiveIndex": 1.5, "AttenuationScale": 2.0}"#).unwrap(), ours);
        let all = write(&VtkParameters::default());
        for (vtk, ours) in vtk_names::VTK_NAMES {
            assert!(all.contains_key(ours), "{vtk}");
        }
    }

    #[test]
    fn what_is_left_to_the_model_has_its_default() {
        assert_eq!(fluid(r#"{"roughness": null, "preset": null}"#).unwrap(), FluidParameters::default());
    }

    /// Of every model: each number is checked, on both sides of its range, and the message names it.
    #[test]
    fn every_range_is_checked() {
        let registry = LightingRegistry::builtin();
        for name in registry.names() {
            let choice = LightingChoice { name: name.into(), ..Default::default() };
            for (key, value) in registry.make(&choice).unwrap().parameters() {
                if value.is_boolean() || value.is_string() {
                    continue;
                }
                for bad in [-1.0, 1e31] {
                    let bad =
                        if value.is_array() { serde_json::json!([0.5, bad, 0]) } else { Value::from(bad) };
                    let mut choice = choice.clone();
                    choice.parameters.insert(key.clone(), bad);
                    let error = registry.make(&choice).err().map(|e| e.to_string()).unwrap_or_default();
                    assert!(error.contains(&key) && error.contains("expected"), "{name}.{key}: {error}");
                }
            }
        }
        let wrong = fluid(r#"{"roughness": "smooth"}"#).unwrap_err().to_string();
        assert!(wrong.contains("roughness") && wrong.contains("smooth"), "{wrong}");
        assert!(crate::Fluid::new(FluidParameters { spray: f32::NAN, ..Default::default() }).is_err());
    }
}
