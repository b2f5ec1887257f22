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
use crate::format::skip_mark;
use crate::format::xml::builder::Builder;
use crate::forward::Forward;
use crate::input_file::InputFile;

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

/// Bytes of an element with its attributes, or of a comment; also bounds what is in memory while scanning.
const MAX_MARKUP: usize = 64 << 20;

/// More than any VTK file gives an element; who looks for doubles compares each with each.
const MAX_ATTRIBUTES: usize = 64;

/// An element's attributes, with lower-case names.
pub(super) struct Attributes(Vec<(String, String)>);

impl Attributes {
    fn read(file: &InputFile, place: u64, element: &BytesStart<'_>) -> Result<Self, Error> {
        let mut list = Vec::new();
        for attribute in element.attributes() {
            let fault =
                |e: &dyn std::fmt::Display| Error::malformed(file.path(), format_args!("byte {place}"), e);
            let attribute = attribute.map_err(|e| fault(&e))?;
            if list.len() >= MAX_ATTRIBUTES {
                return Err(fault(&format_args!("an element with more than {MAX_ATTRIBUTES} attributes")));
            }
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
pub(crate) fn parse(file: &InputFile) -> Result<Document, Error> {
    let mut place = Forward::new(file, 0);
    skip_mark(&mut place)?;
    let mut reader = Reader::from_reader(place);
    let mut builder = Builder::new(file);
    let mut open: Vec<String> = Vec::new();
    let mut markup = Vec::new();
    loop {
        // Text is never given to the reader, which would copy it.
        let (text, is_blank) = reader.get_mut().skip_text()?;
        let in_array = open.last().is_some_and(|name| name == "DataArray");
        if in_array {
            builder.array_text(text, is_blank)?;
        } else {
            builder.text(text);
        }
        let start = reader.get_ref().position();
        let malformed = |message: &dyn std::fmt::Display| {
            Error::malformed(file.path(), format_args!("byte {start}"), message)
        };
        reader.get_mut().limit(MAX_MARKUP);
        markup.clear();
        let event = match reader.read_event_into(&mut markup) {
            Ok(event) => event,
            Err(_) if reader.get_ref().is_exhausted() => {
                return Err(malformed(&format_args!(
                    "markup longer than {MAX_MARKUP} bytes; expected VTK's"
                )));
            }
            Err(e) => {
                let failure = reader.get_mut().take_failure();
                let damaged = || malformed(&format_args!("{e}; the file is damaged or cut off"));
                return Err(failure.unwrap_or_else(damaged));
            }
        };
        match event {
            Event::Start(element) | Event::Empty(element) if open.len() >= MAX_DEPTH => {
                let name = element.name();
                return Err(malformed(&format_args!(
                    "{:?} is nested deeper than {MAX_DEPTH}",
                    name.as_ref()
                )));
            }
            Event::Start(element) => {
                let attributes = Attributes::read(file, start as u64, &element)?;
                let qualified = element.name();
                let name: &str = qualified.as_ref();
                if name == "AppendedData" && builder.appended(&attributes, reader.get_mut())? {
                    // Raw bytes follow: no markup from here on.
                    return builder.finish();
                }
                builder.start(&open, name, &attributes, start as u64)?;
                open.push(name.to_owned());
            }
            Event::Empty(element) => {
                let attributes = Attributes::read(file, start as u64, &element)?;
                let qualified = element.name();
                let name: &str = qualified.as_ref();
                builder.start(&open, name, &attributes, start as u64)?;
                builder.end(name)?;
            }
            Event::End(element) => {
                open.pop();
                builder.end(element.name().as_ref())?;
            }
            Event::CData(text) if in_array => builder.owned_text(text.into_inner().as_bytes())?,
            Event::GeneralRef(reference) if in_array => {
                match reference.resolve_char_ref().map_err(|e| malformed(&e))? {
                    Some(letter) => builder.owned_text(letter.encode_utf8(&mut [0; 4]).as_bytes())?,
                    None => return Err(malformed(&"an entity in the data; expected numbers")),
                }
            }
            Event::DocType(_) => {
                return Err(malformed(&"a document type declaration; VTK files have none, remove it"));
            }
            Event::Text(_)
            | Event::Comment(_)
            | Event::Decl(_)
            | Event::PI(_)
            | Event::CData(_)
            | Event::GeneralRef(_) => {}
            Event::Eof if open.is_empty() => return builder.finish(),
            Event::Eof => {
                let message = format!("the file ends inside <{}>; it is cut off", open.join("><"));
                return Err(malformed(&message));
            }
        }
    }
}
