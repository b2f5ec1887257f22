//! Spacing and radius of a series.

use std::ops::Deref;

use meniscus_core::{
    Cancel, Choice, DEFAULT_RADIUS_PER_SPACING, Flaw, Flaws, RadiusChoice, Short, SpacingSource,
    UNEVEN_RADIUS_PER_SPACING,
};

use super::sizes::Sizes;
use super::survey::choice;
use super::view::View;
use crate::analysis::{names, spacing};
use crate::scalar::ToF32;
use crate::{Error, SeriesOptions};

/// What is chosen, file units.
pub(super) struct Lengths {
    pub spacing: f64,
    pub spacing_source: SpacingSource,
    pub radius: f64,
    pub radius_choice: RadiusChoice,
}

/// A spacing, why, and the radius that comes with it.
struct Spacing {
    value: f64,
    source: SpacingSource,
    reason: String,
    radius: Option<Radius>,
    /// As [`spacing::Estimate::unevenness`].
    unevenness: f64,
}

/// A radius that the file states.
struct Radius {
    value: f64,
    reason: String,
}

/// Factor between the spacing by density and twice the file's radius beyond which the radius is believed.
const MAX_DISAGREEMENT: f64 = 2.0;

/// Unevenness up to which particles are drawn with the usual radius, and from which on with that of random ones. Weakly
/// compressible SPH has 0.01 to 0.3, FLIP that seeds one particle anywhere in each eighth of a cell 0.45.
const UNEVEN: [f64; 2] = [0.3, 0.8];

/// Unevenness below which particles have hardly left the lattice that they began on: a later frame tells how they will lie.
const LATTICE: f64 = 0.1;

/// Most particles for which that later frame is read: of more, each is hardly larger than a pixel, and reading takes seconds.
const MOST_READ_AGAIN: usize = 5_000_000;

/// The particles that lengths are chosen for.
#[derive(Clone, Copy)]
pub(super) struct Liquid<'a> {
    pub view: &'a View,
    /// Marks particles that do not count.
    pub walls: Option<&'a [bool]>,
    /// Those of the usual size count where there are several.
    pub sizes: Option<&'a Sizes>,
}

/// Chooses what `options` leave open. `last` is the last frame, if there is another one.
pub(super) fn choose(
    liquid: Liquid<'_>,
    last: &impl Deref<Target = Option<View>>,
    options: &SeriesOptions,
    choices: &mut Vec<Choice>,
    flaws: &mut Flaws,
    cancel: &Cancel,
) -> Result<Lengths, Error> {
    let (spacing, spacing_source, stated, unevenness) = match options.spacing {
        Some(spacing) => {
            let uneven = options.radius.is_none() && liquid.sizes.is_none();
            let unevenness = if uneven { of_all(liquid.view, liquid.walls).unevenness } else { 0.0 };
            (spacing, SpacingSource::User, None, unevenness)
        }
        None => {
            let chosen = choose_spacing(liquid, options.every.unwrap_or(1), flaws, cancel)?;
            choices.push(choice("spacing", Short(chosen.value).to_string(), chosen.reason, "--spacing"));
            (chosen.value, chosen.source, chosen.radius, chosen.unevenness)
        }
    };
    let (radius, radius_choice) = match options.radius {
        Some(radius) => (radius, RadiusChoice::User),
        None => {
            let Radius { value, reason } = stated.unwrap_or_else(|| {
                let is_few = liquid.view.positions.len() <= MOST_READ_AGAIN;
                let asks_later = unevenness < LATTICE && is_few && liquid.sizes.is_none();
                let later = if asks_later { last.as_ref() } else { None };
                let later = later.map_or(0.0, |last| of_all(last, liquid.walls).unevenness);
                of_spacing(spacing, unevenness.max(later))
            });
            choices.push(choice("radius", Short(value).to_string(), reason, "--radius"));
            (value, RadiusChoice::FromSpacing)
        }
    };
    Ok(Lengths { spacing, spacing_source, radius, radius_choice })
}

/// The radius for a `spacing` of particles that lie as unevenly as said.
fn of_spacing(spacing: f64, unevenness: f64) -> Radius {
    let [even, random] = UNEVEN;
    let share = ((unevenness - even) / (random - even)).clamp(0.0, 1.0);
    let more = share * (UNEVEN_RADIUS_PER_SPACING - DEFAULT_RADIUS_PER_SPACING);
    let per_spacing = DEFAULT_RADIUS_PER_SPACING + more;
    let why = if share > 0.0 { ": particles lie unevenly" } else { "" };
    Radius { value: per_spacing * spacing, reason: format!("{} of the spacing{why}", Short(per_spacing)) }
}

/// The estimate for all particles of the default set, but for those of `walls` where these are of the same number.
fn of_all(view: &View, walls: Option<&[bool]>) -> spacing::Estimate {
    let liquid = view.liquid(walls.filter(|walls| walls.len() == view.positions.len()));
    spacing::estimate(&liquid, &liquid, view.flat_axis())
}

fn choose_spacing(
    Liquid { view, walls, sizes }: Liquid<'_>,
    every: u32,
    flaws: &mut Flaws,
    cancel: &Cancel,
) -> Result<Spacing, Error> {
    let flat_axis = view.flat_axis();
    let sample = view.sample(walls);
    let estimate = match sizes.map(|sizes| sizes.usual(view, cancel)).transpose()?.flatten() {
        Some(usual) => {
            let is_left_out = |i: usize| walls.is_some_and(|walls| walls[i]);
            let left_out: Vec<bool> = usual.iter().enumerate().map(|(i, is)| !is || is_left_out(i)).collect();
            spacing::estimate(&view.liquid(walls), &view.liquid(Some(&left_out)), flat_axis)
        }
        None => of_all(view, walls),
    };
    // Particles of several sizes are uneven by design.
    let unevenness = if sizes.is_some() { 0.0 } else { estimate.unevenness };
    let dimensions = if flat_axis.is_some() { 2.0 } else { 3.0 };
    // What the file states is of all its particles; each one taken stands for several. The estimate sees only those taken.
    let thinned = f64::from(every).powf(1.0 / dimensions);
    let by_mass = from_mass(view, &sample, dimensions, cancel)?.map(|spacing| spacing * thinned);
    let mass = |value| Spacing {
        value,
        source: SpacingSource::MassAndDensity,
        reason: "from the median mass and a rest density, the upper quartile of the density".into(),
        radius: None,
        unevenness,
    };
    // Mass in another unit than density and coordinates would be off by a power of ten.
    if let Some(value) = by_mass.filter(|spacing| (spacing / estimate.spacing - 1.0).abs() < 0.2) {
        return Ok(mass(value));
    }
    if let Some((name, radius)) = median_radius(view, &sample, cancel)? {
        let radius = radius * thinned;
        let ratio = 2.0 * radius / estimate.spacing;
        let agrees = (1.0 / MAX_DISAGREEMENT..=MAX_DISAGREEMENT).contains(&ratio);
        if estimate.doubt.is_some() || !agrees {
            let reason = format!("twice the median of the attribute {name:?}");
            let stated = Radius { value: radius, reason: format!("the median of the attribute {name:?}") };
            return Ok(Spacing {
                value: 2.0 * radius,
                source: SpacingSource::Estimate,
                reason,
                radius: Some(stated),
                unevenness,
            });
        }
    }
    if let Some(value) = by_mass.filter(|_| estimate.doubt.is_some()) {
        return Ok(mass(value));
    }
    let reason = match estimate.doubt {
        Some(doubt) => {
            flaws.add(Flaw::SpacingUncertain { reason: doubt.clone() });
            format!("a guess: {doubt}")
        }
        None => "estimated from the local density of sampled particles".into(),
    };
    Ok(Spacing { value: estimate.spacing, source: SpacingSource::Estimate, reason, radius: None, unevenness })
}

/// Spacing from mass and density where the file has both. The rest density is the upper quartile over all particles: a
/// particle's own density falls to a third at a free surface.
fn from_mass(view: &View, sample: &[usize], dimensions: f64, cancel: &Cancel) -> Result<Option<f64>, Error> {
    let mass = names::find(&view.frame, names::MASS, 1);
    let density = names::find(&view.frame, names::DENSITY, 1);
    let (Some(mass), Some(density)) = (mass, density) else { return Ok(None) };
    let quantile = |attribute, q: f64| -> Result<Option<f64>, Error> {
        let values = view.frame.values_at(attribute, sample, &ToF32, cancel)?;
        let positive = |v: &f32| v.is_finite() && *v > 0.0;
        Ok(quantile(values.into_iter().filter(positive).collect(), q))
    };
    let (Some(mass), Some(density)) = (quantile(mass, 0.5)?, quantile(density, 0.75)?) else {
        return Ok(None);
    };
    Ok(Some((mass / density).powf(1.0 / dimensions)))
}

/// Name and median of the attribute that gives every particle's radius: positive everywhere, no particle larger than the data.
fn median_radius(view: &View, sample: &[usize], cancel: &Cancel) -> Result<Option<(String, f64)>, Error> {
    let attribute = names::find(&view.frame, names::RADIUS, 1).filter(|a| !a.ty.is_integer());
    let Some(attribute) = attribute else { return Ok(None) };
    let radii = view.frame.values_at(attribute, sample, &ToF32, cancel)?;
    let extent = view.bounds.extent().max_element();
    let may_be = |radius: &f32| *radius > 0.0 && radius.is_finite() && (extent == 0.0 || *radius <= extent);
    if !radii.iter().all(may_be) {
        return Ok(None);
    }
    Ok(quantile(radii, 0.5).map(|radius| (attribute.name.clone(), radius)))
}

fn quantile(mut values: Vec<f32>, q: f64) -> Option<f64> {
    values.sort_by(f32::total_cmp);
    let index = (values.len().saturating_sub(1) as f64 * q) as usize;
    values.get(index).map(|v| f64::from(*v))
}
