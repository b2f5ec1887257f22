//! Air beside the water: what is far lighter than the rest.

use meniscus_core::Cancel;

use super::groups::{Groups, quoted};
use super::names;
use super::others::Other;
use crate::Error;
use crate::frame_data::{AttributeInfo, FrameData};
use crate::scalar::ToF64;

/// The name of a set of it.
pub(super) const NAME: &str = "air";

/// A kind that is this many times lighter than another one that weighs what water weighs is a gas. Solvers lessen the true
/// factor of 830; oils and ice are within it.
const LIGHTER_THAN_WATER: f64 = 3.0;

/// A kind that is this many times lighter than any other is a gas: water is 20 times lighter than the heaviest metal.
const LIGHTER: f64 = 25.0;

/// The gap in the densities of single particles that divides gas from liquid. The density of a lone particle, if found from its
/// neighbours, is as far below the usual, but those between it and the liquid fill the gap.
const GAP: f64 = 10.0;

/// One particle in so many has to be on either side of the gap.
const FEW: usize = 100;

/// Particles whose density is looked at.
const SAMPLES: usize = 1 << 16;

/// The attribute that states densities.
pub(super) fn density(frame: &FrameData) -> Option<&AttributeInfo> {
    names::find(frame, names::DENSITY, 1).filter(|attribute| !attribute.ty.is_integer())
}

/// Whether `density` is that of water, in kg/m3 or in g/cm3.
pub(super) fn weighs_as_water(density: f64) -> bool {
    (900.0..=1100.0).contains(&density) || (0.9..=1.1).contains(&density)
}

/// The median density of each group; `None` where it is no number above 0.
pub(super) fn densities(
    frame: &FrameData,
    groups: &Groups,
    cancel: &Cancel,
) -> Result<Vec<Option<f64>>, Error> {
    let Some(density) = density(frame) else { return Ok(vec![None; groups.len()]) };
    let sample = sample(frame.points, |i| groups.of(i).is_some());
    let mut of_groups = vec![Vec::new(); groups.len()];
    for (&i, value) in sample.iter().zip(frame.values_at(density, &sample, &ToF64, cancel)?) {
        if let Some(group) = groups.of(i) {
            of_groups[group].push(value);
        }
    }
    let median = |values: &mut Vec<f64>| {
        values.sort_by(f64::total_cmp);
        values.get(values.len() / 2).copied().filter(|median| median.is_finite() && *median > 0.0)
    };
    Ok(of_groups.iter_mut().map(median).collect())
}

/// Which of the groups with these median densities are gases.
pub(super) fn among(densities: &[Option<f64>]) -> Vec<bool> {
    let is_gas_beside = |light: f64, heavy: f64| {
        let factor = if weighs_as_water(heavy) { LIGHTER_THAN_WATER } else { LIGHTER };
        heavy > factor * light
    };
    let is_gas = |light: f64| densities.iter().flatten().any(|&heavy| is_gas_beside(light, heavy));
    densities.iter().map(|density| density.is_some_and(is_gas)).collect()
}

/// The gas among the `selected` particles where their densities fall into two clusters.
pub(super) fn by_density(
    frame: &FrameData,
    selected: &[bool],
    cancel: &Cancel,
) -> Result<Option<Other>, Error> {
    let Some(density) = density(frame) else { return Ok(None) };
    let sample = sample(frame.points, |i| selected[i]);
    let values = frame.values_at(density, &sample, &ToF64, cancel)?;
    let Some(limit) = limit(values) else { return Ok(None) };
    let name = quoted(&density.name);
    let is_gas = |value: f64| 0.0 < value && value < limit;
    let values = frame.values(density, &ToF64, cancel)?;
    let members = selected.iter().zip(values).map(|(selected, value)| *selected && is_gas(value)).collect();
    Ok(Some(Other {
        name: NAME,
        look: "water",
        flag: format!("--where '{name} >= {limit}'"),
        pattern: format!("0 < {name} < {limit}"),
        certain_as: Some("they are far lighter than the others".into()),
        members,
    }))
}

/// The density that divides gas from liquid: a short number in the widest gap.
fn limit(mut densities: Vec<f64>) -> Option<f64> {
    densities.retain(|density| density.is_finite() && *density > 0.0);
    densities.sort_by(f64::total_cmp);
    let gaps = densities.windows(2).enumerate().map(|(i, pair)| (i + 1, pair[1] / pair[0]));
    let (light, gap) = gaps.max_by(|a, b| a.1.total_cmp(&b.1))?;
    let (gas, liquid) = densities.split_at(light);
    let is_few = |side: &[f64]| side.len() * FEW < densities.len();
    let medians = [gas, liquid].map(|side| Some(side[side.len() / 2]));
    if gap < GAP || is_few(gas) || is_few(liquid) || !among(&medians)[0] {
        return None;
    }
    // Two digits, which stay within a gap of ten.
    format!("{:.1e}", gas[gas.len() - 1].sqrt() * liquid[0].sqrt()).parse().ok()
}

/// Points of which `takes` is true, evenly spread over the file, in rising order.
fn sample(points: usize, takes: impl Fn(usize) -> bool) -> Vec<usize> {
    // An odd step does not stay on one plane of a lattice, whose rows mostly have even lengths.
    (0..points).step_by((points / SAMPLES) | 1).filter(|&i| takes(i)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn light_kinds_are_gases_unless_they_weigh_what_water_weighs() {
        let among = |densities: &[f64]| among(&densities.iter().map(|d| Some(*d)).collect::<Vec<_>>());
        assert_eq!(among(&[1000.0, 1.2]), [false, true]);
        assert_eq!(among(&[100.0, 1000.0]), [true, false]);
        assert_eq!(among(&[1.0, 0.1]), [false, true]);
        // Steel and gold beside water, in both units; then air beside them.
        assert_eq!(among(&[1000.0, 7850.0]), [false, false]);
        assert_eq!(among(&[1.0, 19.3]), [false, false]);
        assert_eq!(among(&[1000.0, 7850.0, 1.2]), [false, false, true]);
        // Soil; oil; a solver whose units nobody knows.
        assert_eq!(among(&[1000.0, 2650.0]), [false, false]);
        assert_eq!(among(&[1000.0, 800.0]), [false, false]);
        assert_eq!(among(&[12.0, 0.4]), [false, true]);
    }

    #[test]
    fn densities_divide_only_across_a_gap() {
        let of = |parts: &[(f64, usize)]| {
            limit(parts.iter().flat_map(|&(density, count)| vec![density; count]).collect())
        };
        assert_eq!(of(&[(1000.0, 500), (1.2, 500)]), Some(35.0));
        assert_eq!(of(&[(1.2, 400), (1.4, 100), (1000.0, 500)]), Some(37.0));
        assert_eq!(of(&[(0.001, 400), (0.1, 100), (1.0, 500)]), Some(0.01));
        // A few strays; a continuous fall towards lone particles; bad values.
        assert_eq!(of(&[(1.2, 5), (1000.0, 995)]), None);
        assert_eq!(of(&[(40.0, 50), (120.0, 50), (400.0, 50), (1000.0, 500)]), None);
        assert_eq!(of(&[(f64::NAN, 50), (0.0, 50), (-1.0, 50), (1000.0, 500)]), None);
        assert_eq!(limit(vec![]), None);
    }
}
