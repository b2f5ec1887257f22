//! VTK's XML files: `.vtu`, `.vtp`, their parallel forms, and `.pvd` collections.
//!
//! The markup is scanned once without unpacking any data; entity declarations are refused, nesting is bounded, and a raw
//! `AppendedData` element is never scanned.

mod builder;
mod settings;

use quick_xml::events::{BytesStart, Event};
use quick_xml::{Reader, XmlVersion};

use crate::Error;
use crate::dataset::Dataset;
use crate::format::xml::builder::Builder;
use crate::mapped::MappedFile;

/// What an XML file is.
pub(crate) enum Document {
    /// Points.
    Dataset(Dataset),
    /// The piece files of a parallel file.
    Parallel(Vec<String>),
    /// The files of a `.pvd` collection.
    Collection(Vec<CollectionEntry>),
}

/// A `DataSet` element of a collection.
#[derive(Clone, Debug)]
pub(crate) struct CollectionEntry {
    pub time: Option<f64>,
    pub part: u64,
    pub file: String,
}

/// Deeper than any VTK file; a deeper one is an attack on readers that recurse.
const MAX_DEPTH: usize = 64;

/// An element's attributes, with lower-case names.
pub(super) struct Attributes(Vec<(String, String)>);

impl Attributes {
    fn read(file: &MappedFile, place: u64, element: &BytesStart<'_>) -> Result<Self, Error> {
        let mut list = Vec::new();
        for attribute in element.attributes() {
            let fault =
                |e: &dyn std::fmt::Display| Error::malformed(file.path(), format_args!("byte {place}"), e);
            let attribute = attribute.map_err(|e| fault(&e))?;
            let value = attribute.normalized_value(XmlVersion::Implicit1_0).map_err(|e| fault(&e))?;
            list.push((attribute.key.as_ref().to_ascii_lowercase(), value.into_owned()));
        }
        Ok(Self(list))
    }

    /// Value of the attribute `name` (lower case).
    pub fn get(&self, name: &str) -> Option<&str> {
        self.0.iter().find(|(key, _)| key == name).map(|(_, value)| value.trim())
    }
}

/// Scans `file`.
pub(crate) fn parse(file: &MappedFile) -> Result<Document, Error> {
    // The reader does not count a byte order mark in its positions.
    let mark = if file.starts_with(b"\xef\xbb\xbf") { 3 } else { 0 };
    let mut reader = Reader::from_reader(&file[mark..]);
    let mut builder = Builder::new(file);
    let mut open: Vec<String> = Vec::new();
    loop {
        let start = reader.buffer_position() + mark as u64;
        let malformed = |message: &dyn std::fmt::Display| {
            Error::malformed(file.path(), format_args!("byte {start}"), message)
        };
        let event = reader
            .read_event()
            .map_err(|e| malformed(&format_args!("{e}; the file is damaged or cut off")))?;
        let inner = start as usize..reader.buffer_position() as usize + mark;
        let in_array = open.last().is_some_and(|name| name == "DataArray");
        match event {
            Event::Start(element) | Event::Empty(element) if open.len() >= MAX_DEPTH => {
                let name = element.name();
                return Err(malformed(&format_args!(
                    "{:?} is nested deeper than {MAX_DEPTH}",
                    name.as_ref()
                )));
            }
            Event::Start(element) => {
                let attributes = Attributes::read(file, start, &element)?;
                let qualified = element.name();
                let name: &str = qualified.as_ref();
                if name == "AppendedData" && builder.appended(&attributes, inner.end)? {
                    // Raw bytes follow: no markup from here on.
                    return builder.finish();
                }
                builder.start(&open, name, &attributes, start)?;
                open.push(name.to_owned());
            }
            Event::Empty(element) => {
                let attributes = Attributes::read(file, start, &element)?;
                let qualified = element.name();
                let name: &str = qualified.as_ref();
                builder.start(&open, name, &attributes, start)?;
                builder.end(name)?;
            }
            Event::End(element) => {
                open.pop();
                builder.end(element.name().as_ref())?;
            }
            Event::Text(_) if in_array => builder.array_text(inner),
            Event::Text(_) => builder.text(inner),
            Event::CData(text) if in_array => builder.owned_text(text.into_inner().as_bytes()),
            Event::GeneralRef(reference) if in_array => {
                match reference.resolve_char_ref().map_err(|e| malformed(&e))? {
                    Some(letter) => builder.owned_text(letter.encode_utf8(&mut [0; 4]).as_bytes()),
                    None => return Err(malformed(&"an entity in the data; expected numbers")),
                }
            }
            Event::DocType(_) => {
                return Err(malformed(&"a document type declaration; VTK files have none, remove it"));
            }
            Event::Comment(_) | Event::Decl(_) | Event::PI(_) | Event::CData(_) | Event::GeneralRef(_) => {}
            Event::Eof if open.is_empty() => return builder.finish(),
            Event::Eof => {
                let message = format!("the file ends inside <{}>; it is cut off", open.join("><"));
                return Err(malformed(&message));
            }
        }
    }
}
