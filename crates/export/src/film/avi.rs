//! AVI with Motion JPEG: the RIFF form of Microsoft's multimedia interface, and from the second gigabyte on further RIFF lists
//! with their own indices as in "OpenDML AVI File Format Extensions", version 1.02 (1997).

use std::path::{Path, PathBuf};

use super::spool::Spool;
use super::{Film, FilmOptions, FinishedFilm};
use crate::still::compress_jpeg;
use crate::{ExportError, FrameRate};

/// From this length on a RIFF list is closed: old readers take offsets above 2 GiB for negative ones, and some already fail
/// above 1 GiB.
const LONGEST_LIST: u64 = 1 << 30;
/// Lists that the index of indices has room for: a quarter of a terabyte.
const MOST_LISTS: usize = 256;

/// Four letters of a chunk of the video stream, and of its index.
const VIDEO: &[u8; 4] = b"00dc";
const VIDEO_INDEX: &[u8; 4] = b"ix00";
/// What comes before the content of a chunk.
const CHUNK_HEADER: u64 = 8;

/// A film in an `.avi` file.
pub(super) struct AviFilm {
    spool: Spool,
    path: PathBuf,
    size: [u32; 2],
    rate: FrameRate,
    quality: u8,
    longest_list: u64,
    head: Head,
    lists: Vec<List>,
    largest: u32,
}

/// Places of what is filled in at the end.
struct Head {
    main_header: u64,
    stream_header: u64,
    super_index: u64,
    extended_header: u64,
}

/// One RIFF list with pictures.
struct List {
    /// Where its `RIFF` begins.
    start: u64,
    /// Where the four letters `movi` are.
    movie: u64,
    /// Place and length of each picture's content.
    pictures: Vec<(u64, u32)>,
    /// Place and length of its index, once closed.
    index: Option<(u64, u32)>,
}

impl AviFilm {
    pub fn open(path: &Path, options: &FilmOptions) -> Result<Self, ExportError> {
        Self::with_lists_up_to(path, options, LONGEST_LIST)
    }

    /// As [`Self::open`], with lists of at most about `longest_list` bytes.
    fn with_lists_up_to(path: &Path, options: &FilmOptions, longest_list: u64) -> Result<Self, ExportError> {
        let mut spool = Spool::new(path)?;
        let mut film = Riff::default();
        let (mut main_header, mut stream_header, mut super_index, mut extended_header) = (0, 0, 0, 0);
        film.list(b"RIFF", b"AVI ", |riff| {
            riff.list(b"LIST", b"hdrl", |header| {
                header.chunk(b"avih", |avih| {
                    main_header = avih.place();
                    avih.main_header(options, 0, 0);
                });
                header.list(b"LIST", b"strl", |stream| {
                    stream.chunk(b"strh", |strh| {
                        stream_header = strh.place();
                        strh.stream_header(options, 0, 0);
                    });
                    stream.chunk(b"strf", |strf| strf.bitmap_header(options.size));
                    stream.chunk(b"indx", |indx| {
                        super_index = indx.place();
                        indx.super_index(&[]);
                    });
                });
                header.list(b"LIST", b"odml", |odml| {
                    odml.chunk(b"dmlh", |dmlh| {
                        extended_header = dmlh.place();
                        dmlh.u32(0);
                    });
                });
            });
        });
        spool.append(&film.bytes)?;
        let head = Head { main_header, stream_header, super_index, extended_header };
        let mut film = Self {
            spool,
            path: path.to_owned(),
            size: options.size,
            rate: options.rate,
            quality: options.quality,
            longest_list,
            head,
            lists: Vec::new(),
            largest: 0,
        };
        film.begin_list(0)?;
        Ok(film)
    }

    /// Begins the list of pictures in the RIFF list that starts at `start`.
    fn begin_list(&mut self, start: u64) -> Result<(), ExportError> {
        let mut begin = Riff::default();
        if start > 0 {
            begin.raw(b"RIFF").u32(0).raw(b"AVIX");
        }
        begin.raw(b"LIST").u32(0);
        let movie = self.spool.length() + begin.bytes.len() as u64;
        begin.raw(b"movi");
        self.spool.append(&begin.bytes)?;
        self.lists.push(List { start, movie, pictures: Vec::new(), index: None });
        Ok(())
    }

    fn list(&mut self) -> &mut List {
        self.lists.last_mut().expect("a film has a list from its beginning")
    }

    /// Closes the last list. Where its indices do not fit on the disk any more, pictures give way.
    fn end_list(&mut self) -> Result<(), ExportError> {
        let first = self.lists.len() == 1;
        loop {
            let list = self.list();
            let (movie, index) = (list.movie, list.standard_index());
            let mut end = Riff::default();
            end.chunk_of(VIDEO_INDEX, &index);
            let index_length = end.bytes.len() as u32;
            let index_at = self.spool.length();
            let movie_end = index_at + u64::from(index_length);
            if first {
                let old_index = self.list().old_index();
                end.chunk_of(b"idx1", &old_index);
            }
            match self.spool.append(&end.bytes) {
                Ok(()) => {
                    let start = self.list().start;
                    self.list().index = Some((index_at, index_length));
                    let length = |from: u64, to: u64| ((to - from) as u32).to_le_bytes();
                    let end = self.spool.length();
                    self.spool.replace(movie - 4, &length(movie, movie_end))?;
                    return self.spool.replace(start + 4, &length(start + CHUNK_HEADER, end));
                }
                Err(error) => {
                    let Some((place, _)) = self.list().pictures.pop() else { return Err(error) };
                    self.spool.shorten(place - CHUNK_HEADER)?;
                }
            }
        }
    }

    fn pictures(&self) -> u64 {
        self.lists.iter().map(|list| list.pictures.len() as u64).sum()
    }
}

impl Film for AviFilm {
    fn push(&mut self, pixels: &[u32]) -> Result<(), ExportError> {
        let jpeg = compress_jpeg(&self.path, self.size, pixels, self.quality)?;
        let mut chunk = Riff::default();
        chunk.chunk_of(VIDEO, &jpeg);
        let list = self.list();
        // Both indices take 8 and 16 bytes a picture.
        let indices = 24 * (list.pictures.len() as u64 + 1);
        let start = list.start;
        let length = self.spool.length() - start + chunk.bytes.len() as u64 + indices;
        if length > self.longest_list && !self.list().pictures.is_empty() {
            if self.lists.len() == MOST_LISTS {
                let message = format!(
                    "an .avi has at most {MOST_LISTS} parts of 1 GiB; make an .mp4, or shorter films"
                );
                return Err(ExportError::Encode { path: self.path.clone(), message });
            }
            self.end_list()?;
            self.begin_list(self.spool.length())?;
        }
        let place = self.spool.length() + CHUNK_HEADER;
        self.spool.append(&chunk.bytes)?;
        self.list().pictures.push((place, jpeg.len() as u32));
        self.largest = self.largest.max(jpeg.len() as u32);
        Ok(())
    }

    fn finish(mut self: Box<Self>, path: &Path) -> Result<FinishedFilm, ExportError> {
        self.end_list()?;
        let pictures = self.pictures();
        if pictures == 0 {
            return Err(ExportError::Encode { path: path.to_owned(), message: "there is no picture".into() });
        }
        let options = FilmOptions {
            size: self.size,
            rate: self.rate,
            pictures,
            quality: self.quality,
            bits_per_second: None,
            encoder: super::Encoder::BuiltIn,
        };
        let written = |fill: &dyn Fn(&mut Riff)| {
            let mut riff = Riff::default();
            fill(&mut riff);
            riff.bytes
        };
        // The main header counts the pictures that readers without the extensions see.
        let first = self.lists[0].pictures.len() as u32;
        let main = written(&|avih| avih.main_header(&options, first, self.largest));
        let stream = written(&|strh| strh.stream_header(&options, pictures as u32, self.largest));
        let index = written(&|indx| indx.super_index(&self.lists));
        self.spool.replace(self.head.main_header, &main)?;
        self.spool.replace(self.head.stream_header, &stream)?;
        self.spool.replace(self.head.super_index, &index)?;
        self.spool.replace(self.head.extended_header, &(pictures as u32).to_le_bytes())?;
        self.spool.persist(path)?;
        Ok(FinishedFilm { path: path.to_owned(), pictures })
    }
}

impl List {
    /// Content of the `ix00` chunk: offsets from `movi` and lengths.
    fn standard_index(&self) -> Vec<u8> {
        let mut index = Riff::default();
        // Two numbers an entry, an index of chunks.
        index.u16(2).raw(&[0, 1]).u32(self.pictures.len() as u32).raw(VIDEO).u64(self.movie).u32(0);
        for (place, length) in &self.pictures {
            index.u32((place - self.movie) as u32).u32(*length);
        }
        index.bytes
    }

    /// Content of the `idx1` chunk, for readers without the extensions.
    fn old_index(&self) -> Vec<u8> {
        let mut index = Riff::default();
        for (place, length) in &self.pictures {
            // Every picture is a key frame.
            index.raw(VIDEO).u32(0x10).u32((place - CHUNK_HEADER - self.movie) as u32).u32(*length);
        }
        index.bytes
    }
}

/// Builds nested chunks: four letters, a length of 32 bits, content, filled up to an even length. Numbers are little-endian.
#[derive(Default)]
struct Riff {
    bytes: Vec<u8>,
}

impl Riff {
    fn chunk(&mut self, name: &[u8; 4], content: impl FnOnce(&mut Self)) {
        let start = self.bytes.len();
        self.raw(name).u32(0);
        content(self);
        let length = (self.bytes.len() - start) as u32 - CHUNK_HEADER as u32;
        self.bytes[start + 4..start + 8].copy_from_slice(&length.to_le_bytes());
        self.bytes.resize(self.bytes.len().next_multiple_of(2), 0);
    }

    fn chunk_of(&mut self, name: &[u8; 4], content: &[u8]) {
        self.chunk(name, |chunk| {
            chunk.raw(content);
        });
    }

    fn list(&mut self, name: &[u8; 4], kind: &[u8; 4], content: impl FnOnce(&mut Self)) {
        self.chunk(name, |list| {
            list.raw(kind);
            content(list);
        });
    }

    /// Bytes so far.
    fn place(&self) -> u64 {
        self.bytes.len() as u64
    }

    fn raw(&mut self, bytes: &[u8]) -> &mut Self {
        self.bytes.extend_from_slice(bytes);
        self
    }

    fn u16(&mut self, value: u16) -> &mut Self {
        self.raw(&value.to_le_bytes())
    }

    fn u32(&mut self, value: u32) -> &mut Self {
        self.raw(&value.to_le_bytes())
    }

    fn u64(&mut self, value: u64) -> &mut Self {
        self.raw(&value.to_le_bytes())
    }

    /// `AVIMAINHEADER`
    fn main_header(&mut self, options: &FilmOptions, pictures: u32, largest: u32) {
        const HAS_INDEX: u32 = 0x10;
        const IS_INTERLEAVED: u32 = 0x100;
        let microseconds = (1e6 / options.rate.per_second()).round() as u32;
        let most_bytes = (f64::from(largest) * options.rate.per_second()) as u32;
        self.u32(microseconds).u32(most_bytes).u32(0).u32(HAS_INDEX | IS_INTERLEAVED).u32(pictures);
        self.u32(0).u32(1).u32(largest).u32(options.size[0]).u32(options.size[1]).raw(&[0; 16]);
    }

    /// `AVISTREAMHEADER`
    fn stream_header(&mut self, options: &FilmOptions, pictures: u32, largest: u32) {
        self.raw(b"vidsMJPG").u32(0).u32(0).u32(0);
        self.u32(options.rate.denominator).u32(options.rate.numerator).u32(0).u32(pictures);
        let [width, height] = options.size.map(|side| side as u16);
        self.u32(largest).u32(u32::MAX).u32(0).u16(0).u16(0).u16(width).u16(height);
    }

    /// `BITMAPINFOHEADER`
    fn bitmap_header(&mut self, [width, height]: [u32; 2]) {
        self.u32(40).u32(width).u32(height).u16(1).u16(24).raw(b"MJPG").u32(width * height * 3).raw(&[0; 16]);
    }

    /// `AVISUPERINDEX` with room for [`MOST_LISTS`].
    fn super_index(&mut self, lists: &[List]) {
        // Four numbers an entry, an index of indices.
        self.u16(4).raw(&[0, 0]).u32(lists.len() as u32).raw(VIDEO).raw(&[0; 12]);
        for list in lists {
            let (place, length) = list.index.unwrap_or_default();
            self.u64(place).u32(length).u32(list.pictures.len() as u32);
        }
        let missing = MOST_LISTS.saturating_sub(lists.len()) * 16;
        self.bytes.resize(self.bytes.len() + missing, 0);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Encoder;

    const SIZE: [u32; 2] = [33, 17];

    fn options(pictures: u64) -> FilmOptions {
        FilmOptions {
            size: SIZE,
            rate: FrameRate { numerator: 25, denominator: 2 },
            pictures,
            quality: 90,
            bits_per_second: None,
            encoder: Encoder::BuiltIn,
        }
    }

    /// Noise, so that pictures have different lengths, around a grey that says the number.
    fn picture(number: u32) -> Vec<u32> {
        let grey = |i: u32| (number * 7 + i.wrapping_mul(2_654_435_761).wrapping_shr(28 - number % 4)) & 0xff;
        (0..SIZE[0] * SIZE[1]).map(|i| 0xff00_0000 | (grey(i) * 0x1_0101)).collect()
    }

    fn u32_at(bytes: &[u8], offset: usize) -> usize {
        u32::from_le_bytes(bytes[offset..offset + 4].try_into().unwrap()) as usize
    }

    fn u64_at(bytes: &[u8], offset: usize) -> usize {
        u64::from_le_bytes(bytes[offset..offset + 8].try_into().unwrap()) as usize
    }

    /// Name and content of each chunk; lists begin with their kind.
    fn chunks(mut bytes: &[u8]) -> Vec<(&[u8], &[u8])> {
        let mut found = Vec::new();
        while bytes.len() >= 8 {
            let length = u32_at(bytes, 4);
            found.push((&bytes[..4], &bytes[8..8 + length]));
            bytes = &bytes[8 + length.next_multiple_of(2)..];
        }
        assert!(bytes.is_empty(), "chunks fill their list");
        found
    }

    fn child<'a>(bytes: &'a [u8], name: &[u8; 4], kind: &[u8]) -> &'a [u8] {
        let is_it = |(n, content): &(&[u8], &[u8])| *n == name && content.starts_with(kind);
        let (_, content) = chunks(bytes).into_iter().find(is_it).expect("a chunk of this name");
        &content[kind.len()..]
    }

    fn make(path: &Path, longest_list: u64, pictures: u32) -> Vec<u8> {
        let mut film = AviFilm::with_lists_up_to(path, &options(u64::from(pictures)), longest_list).unwrap();
        (0..pictures).for_each(|number| film.push(&picture(number)).unwrap());
        let finished = Box::new(film).finish(path).unwrap();
        assert_eq!(finished.pictures, u64::from(pictures));
        std::fs::read(path).unwrap()
    }

    /// All pictures by the indices of the extensions, as readers beyond 2 GiB find them.
    fn by_super_index(bytes: &[u8]) -> Vec<&[u8]> {
        let header = child(&chunks(bytes)[0].1[4..], b"LIST", b"hdrl");
        let index = child(child(header, b"LIST", b"strl"), b"indx", b"");
        assert_eq!((u32_at(index, 0), &index[8..12]), (4, &VIDEO[..]));
        let mut found = Vec::new();
        for entry in index[24..].chunks(16).take(u32_at(index, 4)) {
            let (place, length) = (u64_at(entry, 0), u32_at(entry, 8));
            let (name, standard) = chunks(&bytes[place..place + length])[0];
            assert_eq!((name, u32_at(standard, 4)), (&VIDEO_INDEX[..], u32_at(entry, 12)));
            let base = u64_at(standard, 12);
            for picture in standard[24..].chunks(8) {
                let start = base + u32_at(picture, 0);
                assert_eq!(bytes[start - 8..start - 4], *VIDEO);
                found.push(&bytes[start..start + u32_at(picture, 4)]);
            }
        }
        found
    }

    fn is_near(jpeg: &[u8], number: u32) -> bool {
        let image = image::load_from_memory(jpeg).unwrap().into_rgb8();
        let pairs = image.as_raw().iter().zip(crate::still::channels(&picture(number), false));
        let sum: u64 = pairs.map(|(a, b)| u64::from(a.abs_diff(b))).sum();
        // Noise is what JPEG is bad at; another picture differs by 7 per step in its grey alone, and in its noise.
        image.dimensions() == (SIZE[0], SIZE[1]) && sum < 12 * 3 * u64::from(SIZE[0] * SIZE[1])
    }

    #[test]
    fn a_film_is_one_list_that_old_readers_know() {
        let folder = tempfile::tempdir().unwrap();
        let bytes = make(&folder.path().join("a.avi"), LONGEST_LIST, 9);
        let lists = chunks(&bytes);
        let [(b"RIFF", riff)] = lists[..] else { panic!("one list") };
        assert!(riff.starts_with(b"AVI "));
        let header = child(&riff[4..], b"LIST", b"hdrl");
        let main = child(header, b"avih", b"");
        assert_eq!((u32_at(main, 0), u32_at(main, 16), u32_at(main, 32)), (80_000, 9, 33), "12.5 a second");
        let stream = child(child(header, b"LIST", b"strl"), b"strh", b"");
        assert_eq!((&stream[..8], u32_at(stream, 20), u32_at(stream, 24)), (&b"vidsMJPG"[..], 2, 25));
        let index = child(&riff[4..], b"idx1", b"");
        let movie = child(&riff[4..], b"LIST", b"");
        assert_eq!(index.len(), 9 * 16, "{}", movie.len());
        let all = by_super_index(&bytes);
        let start = |jpeg: &[u8]| jpeg.as_ptr() as usize - bytes.as_ptr() as usize;
        let movie = bytes.windows(4).position(|four| four == b"movi").unwrap();
        for (entry, jpeg) in index.chunks(16).zip(&all) {
            assert_eq!((movie + u32_at(entry, 8) + 8, u32_at(entry, 12)), (start(jpeg), jpeg.len()));
        }
        assert!(all.iter().zip(0..).all(|(jpeg, number)| is_near(jpeg, number)));
    }

    /// What happens beyond a gibibyte, at eight kilobytes.
    #[test]
    fn long_films_go_on_in_further_lists_and_no_picture_is_lost() {
        let folder = tempfile::tempdir().unwrap();
        let limit = 8_000;
        let bytes = make(&folder.path().join("a.avi"), limit, 40);
        let lists = chunks(&bytes);
        assert!(lists.len() > 3, "{} lists", lists.len());
        for (number, (name, list)) in lists.iter().enumerate() {
            assert_eq!(
                (*name, &list[..4]),
                (&b"RIFF"[..], &(if number == 0 { *b"AVI " } else { *b"AVIX" })[..])
            );
            // Headers and the begin of an index come on top of what is counted.
            assert!(list.len() < limit as usize + 200, "{}", list.len());
        }
        let all = by_super_index(&bytes);
        assert_eq!(all.len(), 40);
        assert!(all.iter().zip(0..).all(|(jpeg, number)| is_near(jpeg, number)));
        let header = child(&lists[0].1[4..], b"LIST", b"hdrl");
        assert_eq!(u32_at(child(child(header, b"LIST", b"odml"), b"dmlh", b""), 0), 40);
        let in_first = child(&lists[0].1[4..], b"idx1", b"").len() / 16;
        assert_eq!(u32_at(child(header, b"avih", b""), 16), in_first);
        assert!((1..40).contains(&in_first));
    }
}
