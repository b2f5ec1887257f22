//! What a frame of a file holds, as `meniscus info` prints it.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use meniscus_core::{Cancel, Look, SpacingSource, UpAxis};
use serde::{Serialize, Serializer};

use crate::Error;
use crate::frame_data::{AttributeInfo, FrameData};
use crate::scalar::ToF64;
use crate::series::sets::{self, SetSource};
use crate::series::{Series, companions};

/// Integer attributes with at most this many values are listed value by value.
const MAX_LISTED_VALUES: usize = 32;

/// A frame of the file as it is: numbers of the whole file, before any selection, in the file's coordinates.
#[derive(Clone, Debug, Serialize)]
pub struct FrameInfo {
    /// Index in the series.
    pub index: usize,
    /// The first file.
    #[serde(serialize_with = "as_text")]
    pub file: PathBuf,
    /// All files, where there are several.
    #[serde(skip_serializing_if = "Vec::is_empty", serialize_with = "as_texts")]
    pub files: Vec<PathBuf>,
    /// Simulation time, of the series or of the file.
    pub time: Option<f64>,
    /// Points in the file.
    pub points: usize,
    /// Points with three finite coordinates.
    pub finite_points: usize,
    /// `points - finite_points`.
    pub dropped: usize,
    /// Type of the coordinates, in VTK's words.
    pub point_type: Option<&'static str>,
    /// `[xmin, xmax, ymin, ymax, zmin, zmax]` of the finite points; `None` without any.
    pub bounds: Option<[f64; 6]>,
    /// Mean of the finite points.
    pub centroid: Option<[f64; 3]>,
    /// The series' origin.
    pub origin: [f64; 3],
    /// The series' spacing.
    pub spacing: f64,
    /// How the spacing was found.
    pub spacing_source: SpacingSource,
    /// The radius drawn.
    pub radius: f64,
    /// The axis that points up.
    pub up: UpAxis,
    /// Point attributes.
    pub attributes: Vec<AttributeSummary>,
    /// The sets that are drawn of this frame.
    pub sets: Vec<SetSummary>,
}

/// An attribute of a frame.
#[derive(Clone, Debug, Serialize)]
pub struct AttributeSummary {
    /// Name in the file.
    pub name: String,
    /// Numbers per point.
    pub components: usize,
    /// Type in VTK's words.
    #[serde(rename = "type")]
    pub ty: &'static str,
    /// Smallest finite value of each component; only with statistics.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub min: Option<Vec<Option<f64>>>,
    /// Largest finite value of each component; only with statistics.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub max: Option<Vec<Option<f64>>>,
    /// How often each value occurs, for whole numbers with at most 32 different values.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub values: Vec<ValueCount>,
}

/// A value and how often it occurs.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct ValueCount {
    /// The value.
    pub value: i64,
    /// Points that have it.
    pub count: u64,
}

/// A set of a frame.
#[derive(Clone, Debug, Serialize)]
pub struct SetSummary {
    /// Its name.
    pub name: String,
    /// How it is drawn.
    pub look: Look,
    /// Points in it, finite or not.
    pub points: usize,
}

/// Names that are not UTF-8 are still worth printing.
fn as_text<S: Serializer>(path: &Path, serializer: S) -> Result<S::Ok, S::Error> {
    serializer.serialize_str(&path.to_string_lossy())
}

fn as_texts<S: Serializer>(paths: &[PathBuf], serializer: S) -> Result<S::Ok, S::Error> {
    serializer.collect_seq(paths.iter().map(|path| path.to_string_lossy()))
}

pub(crate) fn describe(series: &Series, index: usize, stats: bool) -> Result<FrameInfo, Error> {
    let cancel = Cancel::default();
    let frame = series.frame_data(index, &cancel)?;
    let coordinates = Coordinates::of(&frame, &cancel)?;
    let attributes = frame
        .attributes()
        .iter()
        .map(|attribute| summarise(&frame, attribute, stats, &cancel))
        .collect::<Result<_, _>>()?;
    frame.check_unchanged()?;
    let space = series.space();
    let files = series.files(index);
    Ok(FrameInfo {
        index,
        file: files.first().cloned().unwrap_or_default(),
        files: if files.len() > 1 { files } else { Vec::new() },
        time: frame.time,
        points: frame.points,
        finite_points: coordinates.finite,
        dropped: frame.points - coordinates.finite,
        point_type: frame.point_type().map(|ty| ty.name()),
        bounds: coordinates.bounds(),
        centroid: coordinates.centroid(),
        origin: space.origin.to_array(),
        spacing: space.spacing,
        spacing_source: space.spacing_source,
        radius: space.radius,
        up: space.up,
        attributes,
        sets: set_summaries(series, index, &frame, &cancel)?,
    })
}

/// Bounds and mean of the finite points.
struct Coordinates {
    finite: usize,
    min: [f64; 3],
    max: [f64; 3],
    /// Sum, and what rounding took from it (Neumaier 1974): sums of millions of map coordinates would lose the decimals.
    sum: [f64; 3],
    lost: [f64; 3],
}

impl Coordinates {
    const EMPTY: Self = Self {
        finite: 0,
        min: [f64::INFINITY; 3],
        max: [f64::NEG_INFINITY; 3],
        sum: [0.0; 3],
        lost: [0.0; 3],
    };

    fn of(frame: &FrameData, cancel: &Cancel) -> Result<Self, Error> {
        let positions = frame.positions_array()?;
        let mut whole = Self::EMPTY;
        for block in frame.blocks() {
            let values = positions.values(&block, &ToF64, cancel)?;
            whole.add_block(&Self::of_piece(values.as_chunks::<3>().0));
        }
        Ok(whole)
    }

    fn add_block(&mut self, block: &Self) {
        self.finite += block.finite;
        for axis in 0..3 {
            self.min[axis] = self.min[axis].min(block.min[axis]);
            self.max[axis] = self.max[axis].max(block.max[axis]);
            self.add(axis, block.sum[axis]);
            self.lost[axis] += block.lost[axis];
        }
    }

    fn of_piece(points: &[[f64; 3]]) -> Self {
        let mut whole = Self::EMPTY;
        for point in points.iter().filter(|p| p.iter().all(|c| c.is_finite())) {
            whole.finite += 1;
            for (axis, &value) in point.iter().enumerate() {
                whole.min[axis] = whole.min[axis].min(value);
                whole.max[axis] = whole.max[axis].max(value);
                whole.add(axis, value);
            }
        }
        whole
    }

    fn add(&mut self, axis: usize, value: f64) {
        let sum = self.sum[axis];
        let next = sum + value;
        self.lost[axis] += if sum.abs() >= value.abs() { (sum - next) + value } else { (value - next) + sum };
        self.sum[axis] = next;
    }

    fn bounds(&self) -> Option<[f64; 6]> {
        let ([x, y, z], [u, v, w]) = (self.min, self.max);
        (self.finite > 0).then_some([x, u, y, v, z, w])
    }

    fn centroid(&self) -> Option<[f64; 3]> {
        let mean = |axis: usize| (self.sum[axis] + self.lost[axis]) / self.finite as f64;
        (self.finite > 0).then(|| [mean(0), mean(1), mean(2)])
    }
}

fn summarise(
    frame: &FrameData,
    attribute: &AttributeInfo,
    stats: bool,
    cancel: &Cancel,
) -> Result<AttributeSummary, Error> {
    let components = attribute.components;
    let countable = components == 1 && attribute.ty.is_integer();
    let mut limits: Vec<Option<(f64, f64)>> = vec![None; components];
    let mut counts = ValueCounts::default();
    if stats || countable {
        let array = frame.attribute_array(attribute)?;
        for block in frame.blocks() {
            let values = array.values(&block, &ToF64, cancel)?;
            for (limits, component) in std::iter::zip(&mut limits, 0..) {
                let finite = values.iter().skip(component).step_by(components).filter(|v| v.is_finite());
                *limits = finite.fold(*limits, |limits, &v| {
                    Some(limits.map_or((v, v), |(low, high): (f64, f64)| (low.min(v), high.max(v))))
                });
            }
            if countable {
                values.into_iter().for_each(|value| counts.add(value));
            }
            if !stats && counts.are_too_many() {
                break;
            }
        }
    }
    let side = |pick: fn((f64, f64)) -> f64| stats.then(|| limits.iter().map(|l| l.map(pick)).collect());
    Ok(AttributeSummary {
        name: attribute.name.clone(),
        components,
        ty: attribute.ty.name(),
        min: side(|(low, _)| low),
        max: side(|(_, high)| high),
        values: counts.into_list().unwrap_or_default(),
    })
}

/// How often each whole number occurs, as long as there are few.
#[derive(Clone, Default)]
pub(crate) struct ValueCounts(BTreeMap<i64, u64>);

impl ValueCounts {
    pub fn add(&mut self, value: f64) {
        if !self.are_too_many() {
            *self.0.entry(value as i64).or_insert(0) += 1;
        }
    }

    /// Whether there are more than [`MAX_LISTED_VALUES`] different ones.
    pub fn are_too_many(&self) -> bool {
        self.0.len() > MAX_LISTED_VALUES
    }

    /// In rising order; `None` when there are too many.
    pub fn into_list(self) -> Option<Vec<ValueCount>> {
        let list = |(value, count)| ValueCount { value, count };
        (!self.are_too_many()).then(|| self.0.into_iter().map(list).collect())
    }
}

fn set_summaries(
    series: &Series,
    index: usize,
    frame: &FrameData,
    cancel: &Cancel,
) -> Result<Vec<SetSummary>, Error> {
    let counts = sets::count(series.sets(), frame, cancel)?;
    let mut summaries = Vec::new();
    for (plan, count) in std::iter::zip(series.sets().iter(), counts) {
        let points = match &plan.source {
            SetSource::Files(steps) => match companions::companion(steps, index, frame.time) {
                Some(step) => FrameData::open(step, series.sets().io_mode, cancel)?.points,
                None => 0,
            },
            _ => count,
        };
        summaries.push(SetSummary { name: plan.name.clone(), look: plan.look, points });
    }
    Ok(summaries)
}
