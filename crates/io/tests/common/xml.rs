//! Small VTK XML files in every encoding, written by hand so that they do not share code with the reader.

use std::io::Write;

use base64::Engine;
use base64::prelude::BASE64_STANDARD;

#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Format {
    Ascii,
    Inline,
    AppendedRaw,
    AppendedBase64,
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Packing {
    None,
    Zlib,
    Lz4,
}

#[derive(Clone, Copy, Debug)]
pub struct Xml {
    pub format: Format,
    pub packing: Packing,
    pub wide_header: bool,
    pub big: bool,
    /// Coordinates as `Float32` instead of `Float64`.
    pub single: bool,
    /// Bytes per compressed block.
    pub block: usize,
    /// Points of each piece.
    pub pieces: &'static [usize],
    pub polydata: bool,
}

impl Xml {
    pub fn plain(format: Format) -> Self {
        Self {
            format,
            packing: Packing::None,
            wide_header: false,
            big: false,
            single: false,
            block: 64,
            pieces: &[10],
            polydata: false,
        }
    }

    /// Every sensible combination.
    pub fn all() -> Vec<Self> {
        let mut list = Vec::new();
        for format in [Format::Ascii, Format::Inline, Format::AppendedRaw, Format::AppendedBase64] {
            for packing in [Packing::None, Packing::Zlib, Packing::Lz4] {
                for bits in 0..8 {
                    let [wide_header, big, single] = [1, 2, 4].map(|bit| bits & bit != 0);
                    let polydata = bits % 3 == 0;
                    for (block, pieces) in [(64, &[10][..]), (40, &[0, 7, 0, 12]), (20, &[9, 1])] {
                        list.push(Self {
                            format,
                            packing,
                            wide_header,
                            big,
                            single,
                            block,
                            pieces,
                            polydata,
                        });
                    }
                }
            }
        }
        list
    }

    pub fn extension(&self) -> &'static str {
        if self.polydata { "vtp" } else { "vtu" }
    }

    /// Coordinates of point `i` of the whole file; exact in `f32`.
    pub fn point(i: usize) -> [f64; 3] {
        [i as f64 * 0.5, 1024.0 - i as f64 * 0.25, (i * i) as f64]
    }

    /// The attribute `density` of point `i`.
    pub fn density(i: usize) -> f64 {
        1000.0 + i as f64 / 3.0
    }

    /// The attribute `id` of point `i`.
    pub fn id(i: usize) -> i64 {
        (1 << 40) + 3 * i as i64
    }

    pub fn points(&self) -> usize {
        self.pieces.iter().sum()
    }

    /// The file.
    pub fn bytes(&self) -> Vec<u8> {
        let mut appended = Vec::new();
        let kind = if self.polydata { "PolyData" } else { "UnstructuredGrid" };
        let compressor = match self.packing {
            Packing::None => "",
            Packing::Zlib => " compressor=\"vtkZLibDataCompressor\"",
            Packing::Lz4 => " compressor=\"vtkLZ4DataCompressor\"",
        };
        let order = if self.big { "BigEndian" } else { "LittleEndian" };
        let header = if self.wide_header { "UInt64" } else { "UInt32" };
        let mut text = format!(
            "<?xml version='1.0'?>\n<VTKFile type='{kind}' version='1.0' byte_order='{order}' \
             header_type='{header}'{compressor}>\n<{kind}>\n"
        );
        let mut first = 0;
        for &count in self.pieces {
            let range = first..first + count;
            first += count;
            text += &format!("<Piece NumberOfPoints='{count}' NumberOfCells='0'>\n<PointData>\n");
            let density = range.clone().map(|i| self.number(Self::density(i), false)).collect();
            text += &self.array("density", "Float64", 1, density, &mut appended);
            let id = range.clone().map(|i| self.integer(Self::id(i))).collect();
            text += &self.array("id", "Int64", 1, id, &mut appended);
            text += "</PointData>\n<Points>\n";
            let ty = if self.single { "Float32" } else { "Float64" };
            let points = range.flat_map(Self::point).map(|c| self.number(c, self.single)).collect();
            text += &self.array("Points", ty, 3, points, &mut appended);
            text += "</Points>\n</Piece>\n";
        }
        text += &format!("</{kind}>\n");
        let mut file = text.into_bytes();
        let encoding = match self.format {
            Format::AppendedRaw => "raw",
            Format::AppendedBase64 => "base64",
            _ => "",
        };
        if !encoding.is_empty() {
            file.extend(format!("<AppendedData encoding='{encoding}'>\n  _").bytes());
            file.extend(appended);
            file.extend(b"\n</AppendedData>\n");
        }
        file.extend(b"</VTKFile>\n");
        file
    }

    /// A number as text and as bytes.
    fn number(&self, value: f64, single: bool) -> (String, Vec<u8>) {
        let bytes = match (single, self.big) {
            (false, false) => value.to_le_bytes().to_vec(),
            (false, true) => value.to_be_bytes().to_vec(),
            (true, false) => (value as f32).to_le_bytes().to_vec(),
            (true, true) => (value as f32).to_be_bytes().to_vec(),
        };
        (value.to_string(), bytes)
    }

    fn integer(&self, value: i64) -> (String, Vec<u8>) {
        let bytes = if self.big { value.to_be_bytes() } else { value.to_le_bytes() };
        (value.to_string(), bytes.to_vec())
    }

    fn array(
        &self,
        name: &str,
        ty: &str,
        components: usize,
        values: Vec<(String, Vec<u8>)>,
        appended: &mut Vec<u8>,
    ) -> String {
        let head = format!("<DataArray type='{ty}' Name='{name}' NumberOfComponents='{components}' ");
        let raw: Vec<u8> = values.iter().flat_map(|(_, bytes)| bytes.clone()).collect();
        match self.format {
            Format::Ascii => {
                let texts: Vec<String> = values.into_iter().map(|(text, _)| text).collect();
                format!("{head}format='ascii'>\n{}\n</DataArray>\n", texts.join(" "))
            }
            Format::Inline => {
                format!("{head}format='binary'>\n{}\n</DataArray>\n", self.base64(&raw))
            }
            Format::AppendedRaw | Format::AppendedBase64 => {
                let offset = appended.len();
                if self.format == Format::AppendedRaw {
                    let (head, data) = self.framed(&raw);
                    appended.extend(head);
                    appended.extend(data);
                } else {
                    appended.extend(self.base64(&raw).bytes());
                }
                format!("{head}format='appended' offset='{offset}'/>\n")
            }
        }
    }

    fn base64(&self, raw: &[u8]) -> String {
        let (mut head, data) = self.framed(raw);
        if self.packing == Packing::None {
            // One stream; with a table, table and data are encoded each on its own.
            head.extend(data);
            return BASE64_STANDARD.encode(head);
        }
        BASE64_STANDARD.encode(head) + &BASE64_STANDARD.encode(data)
    }

    /// Size word or block table, and the data.
    fn framed(&self, raw: &[u8]) -> (Vec<u8>, Vec<u8>) {
        if self.packing == Packing::None {
            return (self.words(&[raw.len()]), raw.to_vec());
        }
        let blocks: Vec<Vec<u8>> = raw.chunks(self.block).map(|block| self.pack(block)).collect();
        let mut table = vec![blocks.len(), self.block, raw.len() % self.block];
        table.extend(blocks.iter().map(Vec::len));
        (self.words(&table), blocks.concat())
    }

    fn words(&self, words: &[usize]) -> Vec<u8> {
        let of = |&word: &usize| match (self.wide_header, self.big) {
            (false, false) => (word as u32).to_le_bytes().to_vec(),
            (false, true) => (word as u32).to_be_bytes().to_vec(),
            (true, false) => (word as u64).to_le_bytes().to_vec(),
            (true, true) => (word as u64).to_be_bytes().to_vec(),
        };
        words.iter().flat_map(of).collect()
    }

    fn pack(&self, block: &[u8]) -> Vec<u8> {
        match self.packing {
            Packing::Lz4 => lz4_flex::block::compress(block),
            _ => {
                let mut encoder = flate2::write::ZlibEncoder::new(Vec::new(), flate2::Compression::default());
                encoder.write_all(block).expect("memory does not fail");
                encoder.finish().expect("memory does not fail")
            }
        }
    }
}
