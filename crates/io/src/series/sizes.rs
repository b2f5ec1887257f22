//! Particles of different sizes: several resolutions, grains.
//!
//! What states a size, by name: a radius or a diameter; a volume; the mass, where the density hardly varies, so that masses are
//! volumes; the smoothing length, where the mass varies too. Solvers that find the volume or the smoothing length from each
//! particle's own density let both grow at a free surface although all particles are alike, so that a mass that is the same
//! everywhere overrules them. What does not vary says nothing.

use meniscus_core::{Cancel, Choice, SIZES};

use super::survey::choice;
use super::view::View;
use crate::analysis::{names, spacing};
use crate::frame_data::{AttributeInfo, FrameData};
use crate::scalar::ToF32;
use crate::{Error, SeriesOptions};

/// Sizes vary where one sampled particle in [`FEW`] is more than this off the median.
const ALIKE: f64 = 0.05;
/// See [`ALIKE`].
const FEW: usize = 100;
/// A density that hardly varies: of one liquid, whose particles know their density without counting their neighbours.
const ONE_LIQUID: f64 = 0.2;
/// Twice a radius whose name may mean something else is this near to the estimated spacing, as a factor.
const PLAUSIBLE: f64 = 2.0;
/// Particles whose size is this near to the median count when the spacing is estimated.
const USUAL: f64 = 0.1;

/// The attribute that states the sizes of particles.
#[derive(Clone, Debug)]
pub(crate) struct Sizes {
    name: String,
    /// Its value for a particle of the series' spacing and radius, > 0.
    reference: f64,
    /// How lengths follow from values.
    power: f64,
}

impl Sizes {
    /// The numbers of this kind in `frame`.
    pub fn find_in<'a>(&self, frame: &'a FrameData) -> Option<&'a AttributeInfo> {
        frame.attribute(&self.name).filter(|attribute| attribute.components == 1)
    }

    /// Name of the attribute.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// The relative sizes for `values` of the attribute, in [`SIZES`], and how many of them had to be replaced.
    pub fn relative(&self, mut values: Vec<f32>) -> (Vec<f32>, u64) {
        let mut replaced = 0;
        for value in &mut values {
            let size = (f64::from(*value) / self.reference).powf(self.power) as f32;
            *value = if size > 0.0 { size.clamp(*SIZES.start(), *SIZES.end()) } else { 1.0 };
            replaced += u64::from(*value != size);
        }
        (values, replaced)
    }

    /// Which points of the view have about the size of the series.
    pub fn usual(&self, view: &View, cancel: &Cancel) -> Result<Option<Vec<bool>>, Error> {
        let Some(attribute) = self.find_in(&view.frame) else { return Ok(None) };
        let sizes = self.relative(view.frame.values(attribute, &ToF32, cancel)?).0;
        Ok(Some(sizes.into_iter().map(|size| (f64::from(size) - 1.0).abs() < USUAL).collect()))
    }
}

/// What the values of an attribute mean for sizes.
#[derive(Clone, Copy, PartialEq)]
enum Kind {
    Length,
    Volume,
    Mass,
    SmoothingLength,
}

/// All, by the names of their attributes; what comes first counts.
const KINDS: [(Kind, &[&str]); 5] = [
    (Kind::Length, names::RADIUS),
    (Kind::Length, names::DIAMETER),
    (Kind::Volume, names::VOLUME),
    (Kind::Mass, names::MASS),
    (Kind::SmoothingLength, names::SMOOTHING_LENGTH),
];

/// An attribute that may state sizes, at sampled particles.
struct Candidate {
    kind: Kind,
    sizes: Sizes,
    /// Values, sorted; those that are no numbers above 0 left out.
    values: Vec<f32>,
}

impl Candidate {
    /// `None` where more than one value in [`FEW`] is no number above 0.
    fn new(
        view: &View,
        (kind, attribute): (Kind, &AttributeInfo),
        sample: &[usize],
        cancel: &Cancel,
    ) -> Result<Option<Self>, Error> {
        let mut values = view.frame.values_at(attribute, sample, &ToF32, cancel)?;
        let all = values.len();
        values.retain(|value| value.is_finite() && *value > 0.0);
        values.sort_by(f32::total_cmp);
        if values.is_empty() || (all - values.len()) * FEW > all {
            return Ok(None);
        }
        let dimensions = if view.flat_axis().is_some() { 2.0 } else { 3.0 };
        let power = if matches!(kind, Kind::Volume | Kind::Mass) { 1.0 / dimensions } else { 1.0 };
        let reference = f64::from(values[values.len() / 2]);
        Ok(Some(Self { kind, sizes: Sizes { name: attribute.name.clone(), reference, power }, values }))
    }

    fn varies(&self) -> bool {
        let Sizes { reference, power, .. } = self.sizes;
        vary(&self.values, |value| (value / reference).powf(power), ALIKE)
    }

    /// What is printed about it.
    fn choice(&self, reason: String) -> Choice {
        let at = |q: f64| self.values[((self.values.len() - 1) as f64 * q) as usize];
        let [small, large] = [at(0.01), at(0.99)].map(|value| self.sizes.relative(vec![value]).0[0]);
        let value = format!("{small:.2} to {large:.2} times the usual, by {:?}", self.sizes.name);
        choice("sizes", value, reason, "--radius-by NAME|none")
    }
}

/// Whether more than one of `values` in [`FEW`] is off 1 by more than `tolerance`, each on the scale of `relative`.
fn vary(values: &[f32], relative: impl Fn(f64) -> f64, tolerance: f64) -> bool {
    let is_off = |value: &&f32| (relative(f64::from(**value)) - 1.0).abs() > tolerance;
    values.iter().filter(is_off).count() * FEW > values.len()
}

/// The sizes of the water's particles, if they differ; says what was chosen. `sample`: rising indices of particles of the water.
pub(super) fn choose(
    view: &View,
    sample: &[usize],
    options: &SeriesOptions,
    choices: &mut Vec<Choice>,
    cancel: &Cancel,
) -> Result<Option<Sizes>, Error> {
    match options.radius_by.as_deref() {
        Some("none") => Ok(None),
        Some(name) => stated(view, name, sample, cancel).map(Some),
        None => found(view, sample, choices, cancel),
    }
}

/// By the attribute that the user names.
fn stated(view: &View, name: &str, sample: &[usize], cancel: &Cancel) -> Result<Sizes, Error> {
    let attribute = view.frame.require(name)?;
    if attribute.components != 1 {
        return Err(Error::usage(format_args!(
            "--radius-by {name:?}: it has {} numbers per particle; give an attribute with one",
            attribute.components
        )));
    }
    let is_called = |names: &[&str]| names.iter().any(|known| name.eq_ignore_ascii_case(known));
    let kind = KINDS.iter().find(|(_, names)| is_called(names)).map_or(Kind::Length, |(kind, _)| *kind);
    let values = view.frame.values_at(attribute, sample, &ToF32, cancel)?;
    let usable: Vec<usize> = std::iter::zip(sample, values)
        .filter(|(_, value)| value.is_finite() && *value > 0.0)
        .map(|(index, _)| *index)
        .collect();
    match Candidate::new(view, (kind, attribute), &usable, cancel)? {
        Some(candidate) => Ok(candidate.sizes),
        None => Err(Error::usage(format_args!(
            "--radius-by {name:?}: none of its values is a number above 0; give another attribute, or none"
        ))),
    }
}

/// By the first attribute that states different sizes.
fn found(
    view: &View,
    sample: &[usize],
    choices: &mut Vec<Choice>,
    cancel: &Cancel,
) -> Result<Option<Sizes>, Error> {
    let mut candidates = Vec::new();
    for (kind, names) in KINDS {
        let attribute = names::find(&view.frame, names, 1).filter(|attribute| !attribute.ty.is_integer());
        if let Some(attribute) = attribute {
            candidates.extend(Candidate::new(view, (kind, attribute), sample, cancel)?);
        }
    }
    let mut unused = doubtful(view, sample, &candidates, cancel)?;
    let mass_varies = candidates.iter().find(|candidate| candidate.kind == Kind::Mass).map(Candidate::varies);
    for candidate in candidates.iter().filter(|candidate| candidate.varies()) {
        let doubt = match candidate.kind {
            Kind::Length => implausible(view, candidate),
            Kind::Mass => no_one_liquid(view, sample, cancel)?,
            Kind::Volume if mass_varies == Some(false) => Some("the mass does not vary"),
            Kind::SmoothingLength if mass_varies != Some(true) => Some("no mass that varies confirms it"),
            Kind::Volume | Kind::SmoothingLength => None,
        };
        match doubt {
            None => {
                let reason = "the attribute varies by more than 5 %".into();
                choices.push(candidate.choice(reason));
                return Ok(Some(candidate.sizes.clone()));
            }
            Some(doubt) => {
                let name = &candidate.sizes.name;
                unused.get_or_insert_with(|| {
                    let reason = format!("{name:?} varies, but {doubt}");
                    choice("sizes", "all alike".into(), reason, &format!("--radius-by {name}"))
                });
            }
        }
    }
    choices.extend(unused);
    Ok(None)
}

/// Says why an attribute that is called a radius or diameter is not used: some of its values are no sizes.
fn doubtful(
    view: &View,
    sample: &[usize],
    candidates: &[Candidate],
    cancel: &Cancel,
) -> Result<Option<Choice>, Error> {
    for (_, names) in KINDS.iter().filter(|(kind, _)| *kind == Kind::Length) {
        let attribute = names::find(&view.frame, names, 1).filter(|attribute| !attribute.ty.is_integer());
        // A single letter may mean anything.
        let Some(attribute) = attribute.filter(|attribute| attribute.name.len() > 1) else { continue };
        let candidate = candidates.iter().find(|candidate| candidate.sizes.name == attribute.name);
        if candidate.is_some_and(Candidate::varies) {
            continue;
        }
        let values = view.frame.values_at(attribute, sample, &ToF32, cancel)?;
        let is_size = |value: &f32| match candidate {
            Some(candidate) => SIZES.contains(&((f64::from(*value) / candidate.sizes.reference) as f32)),
            None => value.is_finite() && *value > 0.0,
        };
        let odd = values.iter().filter(|value| !is_size(value)).count();
        if odd > 0 {
            let name = &attribute.name;
            let what = match candidate {
                Some(_) => "is no number above 0, or beyond 1/32 to 32 times the usual,",
                None => "is no number above 0",
            };
            let reason = format!("{name:?} {what} for {odd} of {} sampled particles", values.len());
            return Ok(Some(choice("sizes", "all alike".into(), reason, &format!("--radius-by {name}"))));
        }
    }
    Ok(None)
}

/// Why lengths called by a single letter, such as the distance from an axis, are no radii.
fn implausible(view: &View, candidate: &Candidate) -> Option<&'static str> {
    if candidate.sizes.name.len() > 1 {
        return None;
    }
    let is_radius = names::RADIUS.iter().any(|name| candidate.sizes.name.eq_ignore_ascii_case(name));
    let diameter = candidate.sizes.reference * if is_radius { 2.0 } else { 1.0 };
    let liquid = view.liquid(None);
    let ratio = diameter / spacing::estimate(&liquid, &liquid, view.flat_axis()).spacing;
    let agrees = (1.0 / PLAUSIBLE..=PLAUSIBLE).contains(&ratio);
    (!agrees).then_some("it is far from the distance of the particles")
}

/// Why masses are no volumes.
fn no_one_liquid(view: &View, sample: &[usize], cancel: &Cancel) -> Result<Option<&'static str>, Error> {
    let Some(density) = names::find(&view.frame, names::DENSITY, 1) else {
        return Ok(Some("there is no density beside it"));
    };
    let mut values = view.frame.values_at(density, sample, &ToF32, cancel)?;
    values.sort_by(f32::total_cmp);
    let Some(&median) = values.get(values.len() / 2) else { return Ok(None) };
    let relative = |value: f64| value / f64::from(median);
    // A density that is no number is off, whatever the tolerance.
    let is_one = median > 0.0 && values.iter().all(|v| v.is_finite()) && !vary(&values, relative, ONE_LIQUID);
    Ok((!is_one).then_some("so does the density"))
}
