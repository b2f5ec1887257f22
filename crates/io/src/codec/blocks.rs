//! VTK's compressed arrays: a table of block sizes, then the blocks, each compressed on its own.

use std::io::{self, Read, Write};
use std::ops::Range;

use flate2::Compression;
use flate2::write::ZlibEncoder;
use libdeflater::{DecompressionError, Decompressor};
use lzma_rust2::{XzOptions, XzReader, XzWriter};

use crate::Error;
use crate::error::Fault;

/// How blocks are compressed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Compressor {
    Zlib,
    Lz4,
    Lzma,
}

/// Memory an xz stream may ask for, KiB: twice the largest dictionary of its presets (64 MiB).
const XZ_MEMORY_KIB: u32 = 128 << 10;

/// Bytes that matches reach back in the xz blocks we write.
const SMALL_DICTIONARY: u32 = 1 << 16;

impl Compressor {
    /// VTK's class name.
    pub fn name(self) -> &'static str {
        match self {
            Self::Zlib => "vtkZLibDataCompressor",
            Self::Lz4 => "vtkLZ4DataCompressor",
            Self::Lzma => "vtkLZMADataCompressor",
        }
    }

    /// From VTK's class name.
    pub fn from_name(name: &str) -> Option<Self> {
        [Self::Zlib, Self::Lz4, Self::Lzma].into_iter().find(|compressor| compressor.name() == name)
    }

    /// `raw` as a block, packed fast rather than small.
    pub fn compress(self, raw: &[u8]) -> io::Result<Vec<u8>> {
        let room = Vec::with_capacity(raw.len());
        match self {
            Self::Zlib => {
                let mut encoder = ZlibEncoder::new(room, Compression::fast());
                encoder.write_all(raw)?;
                encoder.finish()
            }
            Self::Lz4 => Ok(lz4_flex::block::compress(raw)),
            Self::Lzma => {
                let mut options = XzOptions::with_preset(1);
                // Blocks are short; who reads them takes memory for the dictionary at each.
                options.lzma_options.dict_size = SMALL_DICTIONARY;
                let mut encoder = XzWriter::new(room, options)?;
                encoder.write_all(raw)?;
                encoder.finish()
            }
        }
    }

    /// The most bytes that one compressed byte can stand for; a table that claims more lies. Deflate: 1032 (zlib's technical
    /// notes); LZ4: 255 (one length byte); LZMA: about 7090 measured for constant input, doubled.
    fn max_ratio(self) -> usize {
        match self {
            Self::Zlib => 1032,
            Self::Lz4 => 255,
            Self::Lzma => 14_180,
        }
    }
}

/// Unpacks blocks; kept from block to block, because making a decoder takes a while.
pub(crate) struct Inflater {
    zlib: Decompressor,
}

impl Default for Inflater {
    fn default() -> Self {
        Self { zlib: Decompressor::new() }
    }
}

impl Inflater {
    /// Decompresses `block` into exactly `out`.
    pub fn decompress(&mut self, compressor: Compressor, block: &[u8], out: &mut [u8]) -> Result<(), String> {
        let expected = out.len();
        let wrong_size = |found: usize| format!("the block holds {found} bytes, expected {expected}");
        match compressor {
            Compressor::Zlib => match self.zlib.zlib_decompress(block, out) {
                Ok(found) if found == expected => Ok(()),
                Ok(found) => Err(wrong_size(found)),
                Err(DecompressionError::InsufficientSpace) => {
                    Err(format!("the block holds more than the {expected} bytes expected"))
                }
                Err(DecompressionError::BadData) => Err("the zlib stream is broken or cut off".into()),
            },
            Compressor::Lz4 => match lz4_flex::block::decompress_into(block, out) {
                Ok(found) if found == expected => Ok(()),
                Ok(found) => Err(wrong_size(found)),
                Err(e) => Err(format!("broken LZ4 block ({e})")),
            },
            Compressor::Lzma => {
                let mut reader = XzReader::new_mem_limit(block, false, XZ_MEMORY_KIB);
                reader.read_exact(out).map_err(|e| format!("broken xz stream ({e})"))?;
                match reader.read(&mut [0]) {
                    Ok(0) => Ok(()),
                    Ok(_) => Err(format!("the block holds more than the {expected} bytes expected")),
                    Err(e) => Err(format!("broken xz stream ({e})")),
                }
            }
        }
    }
}

/// Where each compressed block lies, checked against the array's size and the bytes that are there.
#[derive(Debug)]
pub(crate) struct BlockTable {
    /// Uncompressed size of all blocks but a shorter last one.
    pub block_size: usize,
    /// Uncompressed size of the array.
    pub total: usize,
    /// Byte ranges of the compressed blocks, from the first block's start.
    pub blocks: Vec<Range<usize>>,
}

impl BlockTable {
    /// Reads the table through `words`, which gives a range of its numbers (`None` beyond the end of the data): number of blocks,
    /// block size, size of a shorter last block (0 for none), compressed sizes. `total` is the array's size in bytes;
    /// `available` the bytes behind the table, given its number of words and how many bytes are expected there.
    pub fn read(
        compressor: Compressor,
        total: usize,
        words: impl Fn(Range<usize>) -> Result<Option<Vec<u64>>, Error>,
        available: impl Fn(usize, usize) -> Result<usize, Error>,
    ) -> Result<Self, Fault> {
        let cut_off = "the block table runs past the end of the data";
        // An empty array may have no more than the number of its blocks.
        if words(0..1)?.ok_or(cut_off)? == [0] {
            return if total == 0 {
                Ok(Self { block_size: 1, total, blocks: Vec::new() })
            } else {
                Err(format!("the block table is empty, expected {total} bytes of data").into())
            };
        }
        let head = words(0..3)?.ok_or(cut_off)?;
        let (end, block_size) = Self::check_head(&head, total)?;
        let sizes = words(3..end)?.ok_or(cut_off)?;
        let expected = sizes.iter().fold(0_u64, |sum, &size| sum.saturating_add(size));
        let available = available(end, usize::try_from(expected).unwrap_or(usize::MAX))?;
        Ok(Self::from_sizes(compressor, &sizes, block_size, total, available)?)
    }

    /// Number of words in the table that starts with `head`, and uncompressed size of its blocks.
    fn check_head(head: &[u64], total: usize) -> Result<(usize, usize), String> {
        let number =
            |i: usize| head.get(i).and_then(|&word| usize::try_from(word).ok()).unwrap_or(usize::MAX);
        let (count, block_size, last) = (number(0), number(1), number(2));
        let full_blocks = if last == 0 { count } else { count - 1 };
        let declared = full_blocks.checked_mul(block_size).and_then(|bytes| bytes.checked_add(last));
        if block_size == 0 || last > block_size || declared != Some(total) {
            return Err(format!(
                "{count} blocks of {block_size} bytes (last {last}) do not make the expected {total} bytes"
            ));
        }
        let end = count.checked_add(3).ok_or("the number of blocks overflows")?;
        Ok((end, block_size))
    }

    fn from_sizes(
        compressor: Compressor,
        sizes: &[u64],
        block_size: usize,
        total: usize,
        available: usize,
    ) -> Result<Self, String> {
        let mut table = Self { block_size, total, blocks: Vec::with_capacity(sizes.len()) };
        let mut start = 0_usize;
        for (i, &size) in sizes.iter().enumerate() {
            let size = usize::try_from(size).unwrap_or(usize::MAX);
            let end = start.checked_add(size).filter(|&end| end <= available).ok_or_else(|| {
                format!("block {i} of {size} bytes runs past the end of the data ({available} bytes)")
            })?;
            let raw = table.raw_size(i);
            // 64: room for headers and check sums of tiny blocks.
            if raw > size.saturating_mul(compressor.max_ratio()).saturating_add(64) {
                return Err(format!("block {i} claims to unpack {size} bytes into {raw}, which cannot be"));
            }
            table.blocks.push(start..end);
            start = end;
        }
        Ok(table)
    }

    /// Uncompressed size of block `i`.
    pub fn raw_size(&self, i: usize) -> usize {
        self.block_size.min(self.total - i * self.block_size)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(total: usize, words: &[u64], available: usize) -> Result<BlockTable, Fault> {
        let get = |range: Range<usize>| Ok(words.get(range).map(<[u64]>::to_vec));
        BlockTable::read(Compressor::Zlib, total, get, |_, _| Ok(available))
    }

    #[test]
    fn a_sound_table_is_accepted() {
        let table = read(250, &[3, 100, 50, 10, 20, 30], 60).expect("sound");
        assert_eq!(table.blocks, [0..10, 10..30, 30..60]);
        assert_eq!([0, 1, 2].map(|i| table.raw_size(i)), [100, 100, 50]);
    }

    #[test]
    fn lies_are_refused() {
        for (what, total, words) in [
            ("wrong total", 251, &[3, 100, 50, 10, 20, 30][..]),
            ("block size zero", 250, &[3, 0, 50, 10, 20, 30]),
            ("last longer than a block", 350, &[3, 100, 150, 10, 20, 30]),
            ("count overflow", 250, &[u64::MAX, 100, 50, 10, 20, 30]),
            ("size overflow", 250, &[3, u64::MAX, 50, 10, 20, 30]),
            ("past the end", 250, &[3, 100, 50, 10, 20, 31]),
            ("table cut off", 250, &[3, 100, 50, 10, 20]),
            ("ratio", 250_000, &[3, 100_000, 50_000, 10, 20, 30]),
            ("empty", 250, &[0]),
        ] {
            assert!(read(total, words, 60).is_err(), "{what}");
        }
    }
}
