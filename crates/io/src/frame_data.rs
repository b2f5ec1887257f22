//! The particles of one time: all parts and pieces as if they were one file.

use std::path::PathBuf;
use std::sync::atomic::{AtomicU64, Ordering};

use meniscus_core::Cancel;

use crate::array::{CheckedArray, DataArray, check};
use crate::dataset::{Dataset, Piece};
use crate::discover::TimeStep;
use crate::expression::{Column, Expression, Part};
use crate::info::value_counts;
use crate::scalar::{Convert, Recentre, ScalarType, ToF64};
use crate::sink::Sink;
use crate::{Error, IoMode};

/// An attribute that every piece has.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct AttributeInfo {
    pub name: String,
    pub components: usize,
    pub ty: ScalarType,
}

/// The pieces that hold particles at one time.
pub(crate) struct FrameData {
    pieces: Vec<Piece>,
    pub time: Option<f64>,
    /// Number of points.
    pub points: usize,
    /// Files that hold surface meshes and were left out.
    pub meshes: Vec<PathBuf>,
    attributes: Vec<AttributeInfo>,
    bytes_read: AtomicU64,
}

/// Names of the array that identifies particles from frame to frame.
const ID_NAMES: [&str; 9] =
    ["id", "ids", "idp", "particle_id", "particleid", "particle_ids", "globalids", "global_ids", "origid"];

impl FrameData {
    /// Opens the files of `step`. Files whose cells are all faces are left out if others hold particles.
    pub fn open(step: &TimeStep, mode: IoMode, cancel: &Cancel) -> Result<Self, Error> {
        let mut pieces = Vec::new();
        let mut time = None;
        let mut mesh_pieces = Vec::new();
        let mut meshes = Vec::new();
        for path in &step.files {
            check(cancel)?;
            let dataset = Dataset::open(path, mode)?;
            // With one file there is no other to prefer; its cells need not be looked at.
            let is_mesh = step.files.len() > 1 && all_meshes(&dataset.pieces, cancel)?;
            if is_mesh {
                meshes.push(path.clone());
                mesh_pieces.extend(dataset.pieces);
            } else {
                time = time.or(dataset.time);
                pieces.extend(dataset.pieces);
            }
        }
        if pieces.is_empty() && !mesh_pieces.is_empty() {
            pieces = mesh_pieces;
            meshes.clear();
        }
        // Empty pieces have nothing to say, unless there is nothing else.
        if pieces.iter().any(|piece| piece.points > 0) {
            pieces.retain(|piece| piece.points > 0);
        }
        let points = pieces.iter().try_fold(0_usize, |sum, piece| sum.checked_add(piece.points));
        let points = points.ok_or_else(|| {
            Error::malformed(&step.files[0], "number of points", "the pieces declare more than can exist")
        })?;
        let attributes = common_attributes(&pieces);
        Ok(Self {
            pieces,
            time: step.time.or(time),
            points,
            meshes,
            attributes,
            bytes_read: AtomicU64::new(0),
        })
    }

    /// An error when a file was written to since it was opened. Asked once its values are read.
    pub fn check_unchanged(&self) -> Result<(), Error> {
        self.pieces.iter().try_for_each(|piece| piece.file.check_unchanged())
    }

    /// Whether the points are corners of meshes because there is nothing else.
    pub fn is_mesh(&self, cancel: &Cancel) -> Result<bool, Error> {
        all_meshes(&self.pieces, cancel)
    }

    /// The attributes that all pieces have, in the order of the first one.
    pub fn attributes(&self) -> &[AttributeInfo] {
        &self.attributes
    }

    /// The attribute `name`: exactly, else the only one that differs in case.
    pub fn attribute(&self, name: &str) -> Option<&AttributeInfo> {
        self.attributes.iter().find(|a| a.name == name).or_else(|| {
            let mut similar = self.attributes.iter().filter(|a| a.name.eq_ignore_ascii_case(name));
            similar.next().filter(|_| similar.next().is_none())
        })
    }

    /// The attribute `name`, or an error that lists those there are.
    pub fn require(&self, name: &str) -> Result<&AttributeInfo, Error> {
        self.attribute(name).ok_or_else(|| {
            Error::usage(format_args!("no attribute {name:?}; there are: {}", self.attribute_names()))
        })
    }

    fn attribute_names(&self) -> String {
        if self.attributes.is_empty() {
            return "none".into();
        }
        self.attributes.iter().map(|a| a.name.as_str()).collect::<Vec<_>>().join(", ")
    }

    /// The attribute that identifies particles.
    pub fn id_attribute(&self) -> Option<&AttributeInfo> {
        self.attributes.iter().find(|a| {
            a.components == 1
                && a.ty.is_integer()
                && ID_NAMES.iter().any(|name| a.name.eq_ignore_ascii_case(name))
        })
    }

    /// Type of the coordinates, of the first piece.
    pub fn point_type(&self) -> Option<ScalarType> {
        self.pieces.first()?.positions.as_ref().map(|positions| positions.ty)
    }

    /// A finite point near the start, or zero: near enough to the others to subtract it before rounding to `f32`.
    pub fn some_point(&self, cancel: &Cancel) -> Result<[f64; 3], Error> {
        let arrays = self.check(|piece| piece.positions.as_ref())?;
        let Some(first) = arrays.first() else { return Ok([0.0; 3]) };
        let mut values = vec![0.0; first.len().min(3 * 1024)];
        first.decode(&ToF64, values.as_mut_slice(), cancel)?;
        let finite = |p: &&[f64; 3]| p.iter().all(|c| c.is_finite());
        Ok(values.as_chunks::<3>().0.iter().find(finite).copied().unwrap_or_default())
    }

    /// Coordinates minus `origin`.
    pub fn positions(&self, origin: [f64; 3], cancel: &Cancel) -> Result<Vec<[f32; 3]>, Error> {
        let mut out = vec![[0.0_f32; 3]; self.points];
        self.positions_into(origin, out.as_flattened_mut(), cancel)?;
        Ok(out)
    }

    /// Coordinates minus `origin`, x, y, z, x, ..., into `out`, which has three places for every point.
    pub fn positions_into<S: Sink<Item = f32>>(
        &self,
        origin: [f64; 3],
        out: S,
        cancel: &Cancel,
    ) -> Result<(), Error> {
        let arrays = self.check(|piece| piece.positions.as_ref())?;
        self.decode_all(&arrays, &Recentre { origin }, out, cancel)
    }

    /// Coordinates in the file's space, x, y, z, x, ...
    pub fn coordinates(&self, cancel: &Cancel) -> Result<Vec<f64>, Error> {
        self.coordinates_as(&ToF64, cancel)
    }

    /// Coordinates as `convert` gives them, x, y, z, x, ...
    pub fn coordinates_as<C: Convert>(&self, convert: &C, cancel: &Cancel) -> Result<Vec<C::Out>, Error> {
        self.collect(|piece| piece.positions.as_ref(), convert, cancel)
    }

    /// Which points are no ghosts; `None` when none is.
    pub fn not_ghosts(&self, cancel: &Cancel) -> Result<Option<Vec<bool>>, Error> {
        if !self.pieces.iter().any(Piece::may_have_ghosts) {
            return Ok(None);
        }
        let mut mask = Vec::with_capacity(self.points);
        for piece in &self.pieces {
            mask.extend(piece.not_ghosts(cancel)?);
        }
        Ok(mask.contains(&false).then_some(mask))
    }

    /// All values of `attribute`.
    pub fn values<C: Convert>(
        &self,
        attribute: &AttributeInfo,
        convert: &C,
        cancel: &Cancel,
    ) -> Result<Vec<C::Out>, Error> {
        self.collect(|piece| piece.attributes.iter().find(|a| a.name == attribute.name), convert, cancel)
    }

    /// The tuples of `attribute` at the points `indices`, which rise.
    pub fn values_at<C: Convert>(
        &self,
        attribute: &AttributeInfo,
        indices: &[usize],
        convert: &C,
        cancel: &Cancel,
    ) -> Result<Vec<C::Out>, Error> {
        let arrays = self.check(|piece| piece.attributes.iter().find(|a| a.name == attribute.name))?;
        let mut out = Vec::with_capacity(indices.len() * attribute.components);
        let (mut rest, mut first) = (indices, 0);
        for array in arrays {
            let end = first + array.len() / attribute.components;
            let (here, later) = rest.split_at(rest.partition_point(|&index| index < end));
            let local: Vec<usize> = here.iter().map(|index| index - first).collect();
            if !local.is_empty() {
                out.extend(array.pick(&local, convert, cancel)?);
            }
            (rest, first) = (later, end);
        }
        Ok(out)
    }

    fn collect<C: Convert>(
        &self,
        find: impl Fn(&Piece) -> Option<&DataArray>,
        convert: &C,
        cancel: &Cancel,
    ) -> Result<Vec<C::Out>, Error> {
        let arrays = self.check(find)?;
        let mut out = vec![C::Out::default(); arrays.iter().map(CheckedArray::len).sum()];
        self.decode_all(&arrays, convert, out.as_mut_slice(), cancel)?;
        Ok(out)
    }

    fn check(&self, find: impl Fn(&Piece) -> Option<&DataArray>) -> Result<Vec<CheckedArray<'_>>, Error> {
        self.pieces
            .iter()
            .filter_map(|piece| Some((find(piece)?, &piece.file)))
            .map(|(a, f)| a.check(f))
            .collect()
    }

    /// Bytes of the files that hold what was decoded so far, as stored; an array decoded twice counts twice.
    pub fn bytes_read(&self) -> u64 {
        self.bytes_read.load(Ordering::Relaxed)
    }

    fn decode_all<C: Convert, S: Sink<Item = C::Out>>(
        &self,
        arrays: &[CheckedArray<'_>],
        convert: &C,
        out: S,
        cancel: &Cancel,
    ) -> Result<(), Error> {
        let mut rest = out;
        for array in arrays {
            let (head, tail) = rest.split_at(array.len());
            array.decode(convert, head, cancel)?;
            self.bytes_read.fetch_add(array.stored_bytes(), Ordering::Relaxed);
            rest = tail;
        }
        Ok(())
    }

    /// Which points `expression` selects.
    pub fn select(&self, expression: &Expression, cancel: &Cancel) -> Result<Vec<bool>, Error> {
        use rayon::prelude::*;
        let columns = expression
            .columns()
            .iter()
            .map(|column| self.column(expression, column, cancel))
            .collect::<Result<Vec<_>, _>>()?;
        check(cancel)?;
        Ok((0..self.points)
            .into_par_iter()
            .map(|point| expression.matches(&|column| columns[column].value(point)))
            .collect())
    }

    /// What the quantities of `expression` are here: `; type has the values 0, 1, 2`, `; z is from 0 to 2.5`.
    pub fn describe_values(&self, expression: &Expression, cancel: &Cancel) -> Result<String, Error> {
        let mut text = String::new();
        for (i, column) in expression.columns().iter().enumerate() {
            let same = |other: &Column| (&other.name, other.part) == (&column.name, column.part);
            if expression.columns()[..i].iter().any(same) {
                continue;
            }
            let values = self.column(expression, column, cancel)?;
            let values: Vec<f64> =
                (0..self.points).map(|point| values.value(point)).filter(|value| value.is_finite()).collect();
            text += &format!("; {column} {}", describe_values(&values));
        }
        Ok(text)
    }

    fn column(&self, expression: &Expression, column: &Column, cancel: &Cancel) -> Result<Values, Error> {
        if let Some(attribute) = self.attribute(&column.name) {
            let components = attribute.components;
            if let Part::Component(index) = column.part
                && index >= components
            {
                let message = format!("{:?} has {components} components, the first is 0", attribute.name);
                return Err(expression.error_at(column, message).into());
            }
            let values = self.values(attribute, &ToF64, cancel)?;
            return Ok(Values { values, components, part: column.part });
        }
        let axis = ["x", "y", "z"].iter().position(|axis| column.name.eq_ignore_ascii_case(axis));
        match (axis, column.part) {
            (Some(axis), Part::Whole) => {
                let part = Part::Component(axis);
                Ok(Values { values: self.coordinates(cancel)?, components: 3, part })
            }
            (None, Part::Whole) if column.name.eq_ignore_ascii_case("id") => {
                let values = match self.id_attribute() {
                    Some(ids) => self.values(ids, &ToF64, cancel)?,
                    None => (0..self.points).map(|i| i as f64).collect(),
                };
                Ok(Values { values, components: 1, part: Part::Whole })
            }
            _ => {
                // Where the file has no id of that name, the index in the file answers to it.
                let id = if self.id_attribute().is_some_and(|a| a.name == "id") { "" } else { "id, " };
                let names = self.attribute_names();
                let message = format!("no attribute {:?}; there are: x, y, z, {id}{names}", column.name);
                Err(expression.error_at(column, message).into())
            }
        }
    }
}

/// A column of an expression, decoded.
struct Values {
    values: Vec<f64>,
    components: usize,
    part: Part,
}

impl Values {
    fn value(&self, point: usize) -> f64 {
        let tuple = &self.values[point * self.components..(point + 1) * self.components];
        match (self.part, tuple) {
            (Part::Component(index), _) => tuple[index],
            (Part::Whole, [value]) => *value,
            (Part::Whole, _) => tuple.iter().map(|v| v * v).sum::<f64>().sqrt(),
        }
    }
}

/// The values themselves where they are few whole numbers, else their range.
fn describe_values(values: &[f64]) -> String {
    let whole = values.iter().all(|value| value.fract() == 0.0);
    if let Some(counts) = value_counts(values).filter(|counts| whole && !counts.is_empty()) {
        let list: Vec<String> = counts.iter().map(|count| count.value.to_string()).collect();
        return format!("has the value{} {}", if list.len() == 1 { "" } else { "s" }, list.join(", "));
    }
    let low = values.iter().copied().reduce(f64::min);
    let high = values.iter().copied().reduce(f64::max);
    match (low, high) {
        (Some(low), Some(high)) => format!("is from {} to {}", low as f32, high as f32),
        _ => "has no finite value".into(),
    }
}

fn all_meshes(pieces: &[Piece], cancel: &Cancel) -> Result<bool, Error> {
    for piece in pieces {
        if !piece.is_mesh(cancel)? {
            return Ok(false);
        }
    }
    Ok(!pieces.is_empty())
}

fn common_attributes(pieces: &[Piece]) -> Vec<AttributeInfo> {
    let Some((first, others)) = pieces.split_first() else { return Vec::new() };
    let mut list: Vec<AttributeInfo> = Vec::new();
    for array in &first.attributes {
        let everywhere = others.iter().all(|piece| {
            piece.attributes.iter().any(|a| a.name == array.name && a.components == array.components)
        });
        if everywhere && !list.iter().any(|known| known.name == array.name) {
            list.push(AttributeInfo { name: array.name.clone(), components: array.components, ty: array.ty });
        }
    }
    list
}
