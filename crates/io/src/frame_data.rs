//! The particles of one time: all parts and pieces as if they were one file.

mod blocks;
mod selector;

use std::collections::HashSet;
use std::path::PathBuf;
use std::sync::atomic::{AtomicU64, Ordering};

use meniscus_core::Cancel;

use crate::array::{CheckedArray, Content, DataArray, check};
use crate::dataset::{Dataset, Piece};
use crate::discover::TimeStep;
use crate::expression::Expression;
use crate::scalar::{Convert, Recentre, ScalarType, ToF64};
use crate::sink::Sink;
use crate::{Error, IoMode};

pub(crate) use blocks::{Block, FrameArray};
pub(crate) use selector::Selector;

/// An attribute that every piece has.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct AttributeInfo {
    pub name: String,
    pub components: usize,
    pub ty: ScalarType,
    /// Its place in the first piece, which mostly is its place in all.
    place: usize,
}

impl AttributeInfo {
    /// Its array in `piece`.
    fn find_in<'p>(&self, piece: &'p Piece) -> Option<&'p DataArray> {
        let is_it = |array: &&DataArray| array.name == self.name;
        piece.attributes.get(self.place).filter(is_it).or_else(|| piece.attributes.iter().find(is_it))
    }
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

/// Whether an attribute of this name has the identities of particles.
pub(crate) fn is_id(name: &str) -> bool {
    ID_NAMES.iter().any(|known| name.eq_ignore_ascii_case(known))
}

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

    pub fn attribute_names(&self) -> String {
        if self.attributes.is_empty() {
            return "none".into();
        }
        self.attributes.iter().map(|a| a.name.as_str()).collect::<Vec<_>>().join(", ")
    }

    /// The attribute that identifies particles.
    pub fn id_attribute(&self) -> Option<&AttributeInfo> {
        self.attributes.iter().find(|a| a.components == 1 && a.ty.is_integer() && is_id(&a.name))
    }

    /// Whether coordinates are in text, of which no part can be found without looking at all before it.
    pub fn is_text(&self) -> bool {
        let is_text = |array: &DataArray| matches!(array.content, Content::Text { .. });
        self.pieces.iter().any(|piece| piece.positions.as_ref().is_some_and(is_text))
    }

    /// Type of the coordinates, of the first piece.
    pub fn point_type(&self) -> Option<ScalarType> {
        self.pieces.first()?.positions.as_ref().map(|positions| positions.ty)
    }

    /// The median, along each axis, of the finite points near the start, or zero: mostly near enough to the others to subtract it
    /// before rounding to `f32`, even where the first particle is lost far away.
    pub fn some_place(&self, cancel: &Cancel) -> Result<[f64; 3], Error> {
        let arrays = self.check(|piece| piece.positions.as_ref())?;
        let Some(first) = arrays.first() else { return Ok([0.0; 3]) };
        let mut values = vec![0.0; first.len().min(3 * 1024)];
        first.decode(&ToF64, 0, values.as_mut_slice(), cancel)?;
        let points = values.as_chunks::<3>().0.iter().filter(|p| p.iter().all(|c| c.is_finite()));
        let points: Vec<&[f64; 3]> = points.collect();
        Ok(std::array::from_fn(|axis| {
            let mut along: Vec<f64> = points.iter().map(|p| p[axis]).collect();
            along.sort_unstable_by(f64::total_cmp);
            along.get(along.len() / 2).copied().unwrap_or_default()
        }))
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

    /// The frame in blocks, in the order of its points.
    pub fn blocks(&self) -> impl Iterator<Item = Block> + use<> {
        self.blocks_of(blocks::BLOCK)
    }

    /// The frame in blocks of at most `size` points, in the order of its points.
    pub fn blocks_of(&self, size: usize) -> impl Iterator<Item = Block> + use<> {
        let pieces: Vec<usize> = self.pieces.iter().map(|piece| piece.points).collect();
        let mut start = 0;
        pieces.into_iter().enumerate().flat_map(move |(piece, points)| {
            let before = start;
            start += points;
            (0..points).step_by(size).map(move |at| Block {
                piece,
                range: at..points.min(at + size),
                first: before + at,
            })
        })
    }

    /// The coordinates in the file's space, to be read in blocks.
    pub fn positions_array(&self) -> Result<FrameArray<'_>, Error> {
        self.array(3, self.point_type().unwrap_or(ScalarType::F64), |piece| piece.positions.as_ref())
    }

    /// `attribute`, to be read in blocks.
    pub fn attribute_array(&self, attribute: &AttributeInfo) -> Result<FrameArray<'_>, Error> {
        self.array(attribute.components, attribute.ty, |piece| attribute.find_in(piece))
    }

    fn array(
        &self,
        components: usize,
        ty: ScalarType,
        find: impl Fn(&Piece) -> Option<&DataArray>,
    ) -> Result<FrameArray<'_>, Error> {
        Ok(FrameArray { arrays: self.check(find)?, components, ty, bytes_read: &self.bytes_read })
    }

    /// `expression` over the points of this frame.
    pub fn selector<'a>(&'a self, expression: &'a Expression) -> Result<Selector<'a>, Error> {
        Selector::new(self, expression)
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
        self.collect(|piece| attribute.find_in(piece), convert, cancel)
    }

    /// The tuples of `attribute` at the points `indices`, which rise.
    pub fn values_at<C: Convert>(
        &self,
        attribute: &AttributeInfo,
        indices: &[usize],
        convert: &C,
        cancel: &Cancel,
    ) -> Result<Vec<C::Out>, Error> {
        let arrays = self.check(|piece| attribute.find_in(piece))?;
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
            array.decode(convert, 0, head, cancel)?;
            self.bytes_read.fetch_add(array.stored_bytes(), Ordering::Relaxed);
            rest = tail;
        }
        Ok(())
    }

    /// Whether `expression` selects any point.
    pub fn has_match(&self, expression: &Expression, cancel: &Cancel) -> Result<bool, Error> {
        let selector = self.selector(expression)?;
        for block in self.blocks() {
            if selector.block(&block, cancel)?.contains(&true) {
                return Ok(true);
            }
        }
        Ok(false)
    }

    /// What the quantities of `expression` are here: `; type has the values 0, 1, 2`, `; z is from 0 to 2.5`.
    pub fn describe_values(&self, expression: &Expression, cancel: &Cancel) -> Result<String, Error> {
        self.selector(expression)?.describe(self, cancel)
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
    let (mut list, mut names) = (Vec::new(), HashSet::new());
    for (place, array) in first.attributes.iter().enumerate() {
        let (name, components, ty) = (array.name.clone(), array.components, array.ty);
        let attribute = AttributeInfo { name, components, ty, place };
        let is_it = |found: &DataArray| found.components == components;
        let everywhere = || others.iter().all(|piece| attribute.find_in(piece).is_some_and(is_it));
        if names.insert(array.name.as_str()) && everywhere() {
            list.push(attribute);
        }
    }
    list
}
