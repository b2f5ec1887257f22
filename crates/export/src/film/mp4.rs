//! MP4 with one H.264 track (ISO/IEC 14496-12, -14, -15). How long the index will be follows from the number of pictures, so that
//! room is left for it at the start: players can begin before they have all of the file, nothing is copied, and where the
//! disk is full, what was written can still be completed.

use std::path::Path;

use super::boxes::Boxes;
use super::even::{even, padded};
use super::h264::{H264, ParameterSets};
use super::spool::Spool;
use super::{Film, FilmOptions, FinishedFilm};
use crate::{ExportError, FrameRate};

/// What the header of a `free` box takes.
const FREE_HEADER: usize = 8;
/// Length 1, name, and the real length in 64 bits.
const DATA_HEADER: usize = 16;

/// A film in an `.mp4` file.
pub(super) struct Mp4Film {
    encoder: H264,
    spool: Spool,
    size: [u32; 2],
    index: Index,
    /// Where the first picture lies; known once the encoder has said its parameters.
    data: Option<u64>,
    pictures: u64,
}

impl Mp4Film {
    pub fn open(path: &Path, options: &FilmOptions) -> Result<Self, ExportError> {
        Ok(Self {
            encoder: H264::new(path, options)?,
            spool: Spool::new(path)?,
            size: options.size,
            index: Index {
                size: even(options.size),
                rate: options.rate,
                parameters: ParameterSets::default(),
                lengths: Vec::new(),
                keys: Vec::new(),
            },
            data: None,
            pictures: options.pictures,
        })
    }

    /// Leaves room for everything that is known at the end only.
    fn reserve(&mut self) -> Result<u64, ExportError> {
        let room = self.index.longest(self.pictures).head(0).len() + FREE_HEADER;
        let mut head = Boxes::default();
        head.zeros(room + DATA_HEADER);
        self.spool.append(&head.into_bytes())?;
        Ok(self.spool.length())
    }
}

impl Film for Mp4Film {
    fn push(&mut self, pixels: &[u32]) -> Result<(), ExportError> {
        let unit = self.encoder.encode(&padded(pixels, self.size))?;
        if self.data.is_none() {
            self.index.parameters = unit.parameters.unwrap_or_default();
            self.data = Some(self.reserve()?);
        }
        self.spool.append(&unit.bytes)?;
        self.index.lengths.push(unit.bytes.len() as u32);
        if unit.is_key {
            self.index.keys.push(self.index.lengths.len() as u32);
        }
        Ok(())
    }

    fn finish(mut self: Box<Self>, path: &Path) -> Result<FinishedFilm, ExportError> {
        let Some(data) = self.data else {
            return Err(ExportError::Encode { path: path.to_owned(), message: "there is no picture".into() });
        };
        let room = data as usize - DATA_HEADER;
        let mut head = Boxes::default();
        head.raw(&self.index.head(data));
        let filling = room.checked_sub(head.length() + FREE_HEADER).ok_or_else(|| ExportError::Encode {
            path: path.to_owned(),
            message: format!("{} pictures came, {} were announced", self.index.lengths.len(), self.pictures),
        })?;
        head.nest(b"free", |free| {
            free.zeros(filling);
        });
        head.u32(1).raw(b"mdat").u64(self.spool.length() - room as u64);
        self.spool.replace(0, &head.into_bytes())?;
        self.spool.persist(path)?;
        Ok(FinishedFilm { path: path.to_owned(), pictures: self.index.lengths.len() as u64 })
    }
}

/// What a player has to know about the pictures.
struct Index {
    size: [u32; 2],
    rate: FrameRate,
    parameters: ParameterSets,
    /// Bytes of each picture.
    lengths: Vec<u32>,
    /// Numbers, from 1, of pictures that need no other.
    keys: Vec<u32>,
}

impl Index {
    /// As long as an index of `pictures` can become.
    fn longest(&self, pictures: u64) -> Self {
        Self {
            size: self.size,
            rate: self.rate,
            parameters: self.parameters.clone(),
            lengths: vec![0; pictures as usize],
            keys: vec![0; pictures as usize],
        }
    }

    /// All that comes before the pictures, which begin at byte `data`.
    fn head(&self, data: u64) -> Vec<u8> {
        let mut boxes = Boxes::default();
        boxes.nest(b"ftyp", |ftyp| {
            ftyp.raw(b"isom").u32(0x200).raw(b"isomiso2avc1mp41");
        });
        boxes.nest(b"moov", |moov| self.movie(moov, data));
        boxes.into_bytes()
    }

    /// In units of [`Self::time_scale`].
    fn duration(&self) -> u64 {
        self.lengths.len() as u64 * u64::from(self.rate.denominator)
    }

    /// Units of time in a second: a picture lasts `rate.denominator` of them.
    fn time_scale(&self) -> u32 {
        self.rate.numerator
    }

    fn movie(&self, moov: &mut Boxes, data: u64) {
        moov.full(b"mvhd", 1, 0, |mvhd| {
            // Times of making and change are left open, so that the same pictures give the same bytes.
            mvhd.u64(0).u64(0).u32(self.time_scale()).u64(self.duration());
            mvhd.u32(0x1_0000).u16(0x100).zeros(10);
            unity(mvhd);
            mvhd.zeros(24).u32(2);
        });
        moov.nest(b"trak", |trak| {
            trak.full(b"tkhd", 1, 3, |tkhd| {
                tkhd.u64(0).u64(0).u32(1).u32(0).u64(self.duration()).zeros(16);
                unity(tkhd);
                tkhd.u32(self.size[0] << 16).u32(self.size[1] << 16);
            });
            trak.nest(b"mdia", |mdia| {
                mdia.full(b"mdhd", 1, 0, |mdhd| {
                    // Language "und".
                    mdhd.u64(0).u64(0).u32(self.time_scale()).u64(self.duration()).u16(0x55c4).u16(0);
                });
                mdia.full(b"hdlr", 0, 0, |hdlr| {
                    hdlr.u32(0).raw(b"vide").zeros(12).raw(b"meniscus\0");
                });
                mdia.nest(b"minf", |minf| {
                    minf.full(b"vmhd", 0, 1, |vmhd| {
                        vmhd.zeros(8);
                    });
                    minf.nest(b"dinf", |dinf| {
                        dinf.full(b"dref", 0, 0, |dref| {
                            dref.u32(1).full(b"url ", 0, 1, |_| {});
                        });
                    });
                    minf.nest(b"stbl", |stbl| self.samples(stbl, data));
                });
            });
        });
    }

    fn samples(&self, stbl: &mut Boxes, data: u64) {
        let count = self.lengths.len() as u32;
        stbl.full(b"stsd", 0, 0, |stsd| {
            stsd.u32(1).nest(b"avc1", |avc1| self.sample_entry(avc1));
        });
        stbl.full(b"stts", 0, 0, |stts| {
            stts.u32(1).u32(count).u32(self.rate.denominator);
        });
        stbl.full(b"stss", 0, 0, |stss| {
            stss.u32(self.keys.len() as u32).all_u32(&self.keys);
        });
        // About a second of film in each chunk.
        let per_chunk = (self.rate.per_second().ceil() as usize).max(1);
        let (whole, rest) = (self.lengths.len() / per_chunk, self.lengths.len() % per_chunk);
        stbl.full(b"stsc", 0, 0, |stsc| {
            let mut runs = Vec::new();
            if whole > 0 {
                runs.push([1, per_chunk as u32, 1]);
            }
            if rest > 0 {
                runs.push([whole as u32 + 1, rest as u32, 1]);
            }
            stsc.u32(runs.len() as u32).all_u32(runs.as_flattened());
        });
        stbl.full(b"stsz", 0, 0, |stsz| {
            stsz.u32(0).u32(count).all_u32(&self.lengths);
        });
        stbl.full(b"co64", 0, 0, |co64| {
            co64.u32(self.lengths.len().div_ceil(per_chunk) as u32);
            let mut offset = data;
            for chunk in self.lengths.chunks(per_chunk) {
                co64.u64(offset);
                offset += chunk.iter().map(|length| u64::from(*length)).sum::<u64>();
            }
        });
    }

    fn sample_entry(&self, avc1: &mut Boxes) {
        let [width, height] = self.size.map(|side| side as u16);
        avc1.zeros(6).u16(1).zeros(16).u16(width).u16(height);
        // 72 dots per inch, one picture per sample, no name, 24 bits, no colour table.
        avc1.u32(0x48_0000).u32(0x48_0000).u32(0).u16(1).zeros(32).u16(24).u16(0xffff);
        avc1.nest(b"avcC", |avcc| self.parameters.write(avcc));
        avc1.nest(b"colr", |colr| {
            // ITU-T H.273: primaries, transfer and matrix of BT.709, video range.
            colr.raw(b"nclx").u16(1).u16(1).u16(1).u8(0);
        });
        avc1.nest(b"pasp", |pasp| {
            pasp.u32(1).u32(1);
        });
    }
}

/// The matrix that shows pictures as they are.
fn unity(boxes: &mut Boxes) {
    boxes.all_u32(&[0x1_0000, 0, 0, 0, 0x1_0000, 0, 0, 0, 0x4000_0000]);
}
