use std::fmt;
use std::str::FromStr;

use crate::ColorError;

/// Which of an attribute's numbers.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Component {
    /// The length of the vector; of a scalar, the number itself.
    #[default]
    Magnitude,
    /// One of them, from 0.
    Index(usize),
}

/// A number per particle: an attribute, or a component of one.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Quantity {
    /// Name of the attribute, as in the file.
    pub attribute: String,
    /// Which of its numbers.
    pub component: Component,
}

impl Quantity {
    /// The quantity of a particle whose attribute has the `numbers`; NaN where it has no such component.
    pub fn of(&self, numbers: &[f32]) -> f32 {
        match self.component {
            Component::Index(index) => numbers.get(index).copied().unwrap_or(f32::NAN),
            Component::Magnitude => match numbers {
                [only] => *only,
                // In f64: squares of large numbers overflow.
                _ => numbers.iter().map(|&x| f64::from(x).powi(2)).sum::<f64>().sqrt() as f32,
            },
        }
    }
}

impl FromStr for Quantity {
    type Err = ColorError;

    /// `NAME`, or with a component `NAME:x`, `NAME:1`, `NAME:magnitude`. A colon that is followed by something else is a part of
    /// the name.
    fn from_str(text: &str) -> Result<Self, ColorError> {
        let (name, component) = match text.rsplit_once(':') {
            Some((name, component)) => match component.trim().to_ascii_lowercase().as_str() {
                "x" => (name, Component::Index(0)),
                "y" => (name, Component::Index(1)),
                "z" => (name, Component::Index(2)),
                "magnitude" => (name, Component::Magnitude),
                number => match number.parse() {
                    Ok(index) => (name, Component::Index(index)),
                    Err(_) => (text, Component::Magnitude),
                },
            },
            None => (text, Component::Magnitude),
        };
        if name.trim().is_empty() {
            return Err(ColorError::NoName { found: text.to_owned() });
        }
        Ok(Self { attribute: name.trim().to_owned(), component })
    }
}

impl fmt::Display for Quantity {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.component {
            Component::Magnitude => f.write_str(&self.attribute),
            Component::Index(index @ 0..3) => write!(f, "{}:{}", self.attribute, ["x", "y", "z"][index]),
            Component::Index(index) => write!(f, "{}:{index}", self.attribute),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn components_are_named_by_axis_or_number() {
        let parse = |text: &str| text.parse::<Quantity>().map(|q| (q.attribute, q.component)).ok();
        let expect = |name: &str, component| Some((name.to_owned(), component));
        assert_eq!(parse("rho"), expect("rho", Component::Magnitude));
        assert_eq!(parse("v:Y"), expect("v", Component::Index(1)));
        assert_eq!(parse("stress:5"), expect("stress", Component::Index(5)));
        assert_eq!(parse("v:magnitude"), expect("v", Component::Magnitude));
        assert_eq!(parse("sph:rho"), expect("sph:rho", Component::Magnitude));
        assert_eq!((parse(""), parse(":x")), (None, None));
        for text in ["rho", "v:y", "stress:5"] {
            assert_eq!(text.parse::<Quantity>().unwrap().to_string(), text);
        }
    }

    #[test]
    fn a_quantity_is_a_number_its_component_or_a_length() {
        let of = |text: &str, numbers: &[f32]| text.parse::<Quantity>().unwrap().of(numbers);
        assert_eq!(of("rho", &[-3.0]), -3.0);
        assert_eq!(of("v", &[3.0, 0.0, -4.0]), 5.0);
        assert_eq!(of("v:z", &[3.0, 0.0, -4.0]), -4.0);
        assert_eq!(of("v", &[3e30, 0.0, 4e30]), 5e30);
        assert!(of("v:3", &[3.0, 0.0, -4.0]).is_nan() && of("v", &[f32::NAN, 0.0]).is_nan());
    }
}
