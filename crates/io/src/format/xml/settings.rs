use super::Attributes;
use crate::Error;
use crate::codec::blocks::Compressor;
use crate::input_file::InputFile;

/// Settings of the `VTKFile` element.
#[derive(Clone, Debug, Default)]
pub(super) struct Settings {
    pub kind: String,
    pub big: bool,
    pub wide_header: bool,
    pub compressor: Option<Compressor>,
    /// A compressor that is not known; fatal for the first array that needs it.
    pub unknown_compressor: Option<String>,
}

impl Settings {
    /// Reads and checks the attributes of `VTKFile`.
    pub fn read(file: &InputFile, attributes: &Attributes) -> Result<Self, Error> {
        let malformed = |message: String| Error::malformed(file.path(), "element VTKFile", message);
        let kind = attributes.get("type").unwrap_or_default().to_owned();
        if !matches!(
            kind.as_str(),
            "UnstructuredGrid" | "PolyData" | "PUnstructuredGrid" | "PPolyData" | "Collection"
        ) {
            let advice = match kind.as_str() {
                "vtkMultiBlockDataSet"
                | "vtkMultiPieceDataSet"
                | "vtkPartitionedDataSet"
                | "vtkPartitionedDataSetCollection" => {
                    "open one of the files that it lists, or list them in a .pvd file"
                }
                _ => "write the points as .vtu or .vtp, for example with ParaView",
            };
            let message = format!(
                "data of type {kind:?}; expected UnstructuredGrid, PolyData or a collection: {advice}"
            );
            return Err(Error::unsupported(file.path(), message));
        }
        let big = match attributes.get("byte_order") {
            Some(order) if order.eq_ignore_ascii_case("BigEndian") => true,
            Some(order) if order.eq_ignore_ascii_case("LittleEndian") => false,
            None => false,
            Some(other) => {
                let message = format!("byte_order={other:?}, expected LittleEndian or BigEndian");
                return Err(malformed(message));
            }
        };
        let wide_header = match attributes.get("header_type") {
            Some("UInt64") => true,
            Some("UInt32") | None => false,
            Some(other) => {
                let message = format!("header_type={other:?}, expected UInt32 or UInt64");
                return Err(malformed(message));
            }
        };
        let name = attributes.get("compressor").filter(|name| !name.is_empty());
        let compressor = name.and_then(Compressor::from_name);
        let unknown_compressor = name.filter(|_| compressor.is_none()).map(str::to_owned);
        Ok(Self { kind, big, wide_header, compressor, unknown_compressor })
    }
}
