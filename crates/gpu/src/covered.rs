//! The pixels that show fluid.

use std::sync::atomic::{AtomicBool, Ordering};

use crate::role::{CoverMask, Scratch};
use crate::{Binding, Buffer, Dispatch, Gpu, GpuError, Recorder, Texture};

/// Pixels per side of a tile; WGSL: `TILE` in `shaders/common/covered.inc.wgsl`.
const TILE: u32 = 4;

/// The pixels that show fluid, in the forms that passes work on: as a mask for what is drawn, as a list for what is computed, and
/// as a list of tiles. WGSL: `meniscus::covered` in `shaders/common/covered.inc.wgsl`.
#[derive(Debug)]
pub struct Covered {
    size: [u32; 2],
    /// A single pixel on GPUs, which compute what software drivers draw.
    mask: Texture<CoverMask>,
    list: Buffer<Scratch>,
    tiles: Buffer<Scratch>,
    /// Whether the list is that of the mask. Where pictures are drawn, few passes ask for it.
    is_listed: AtomicBool,
}

impl Covered {
    /// Room for those of a picture of `size` = `[width, height]` pixels.
    ///
    /// # Errors
    /// [`GpuError::TooLarge`] beyond the device's limits.
    pub fn new(gpu: &Gpu, size: [u32; 2]) -> Result<Self, GpuError> {
        Ok(Self {
            size,
            mask: Texture::new(gpu, mask_size(gpu, size))?,
            list: Buffer::new(gpu, 1 + pixels(size))?,
            tiles: Buffer::new(gpu, 2 + pixels(in_tiles(size)))?,
            is_listed: AtomicBool::new(false),
        })
    }

    /// Those whose index `shows` is true for, row by row from the top left.
    ///
    /// # Errors
    /// As [`Self::new`].
    pub fn of(gpu: &Gpu, size: [u32; 2], shows: impl Fn(usize) -> bool) -> Result<Self, GpuError> {
        let mask_size = mask_size(gpu, size);
        let marks: Vec<u16> =
            (0..pixels(mask_size)).map(|pixel| if shows(pixel) { u16::MAX } else { 0 }).collect();
        let places = |size: [u32; 2]| (0..size[1]).flat_map(move |y| (0..size[0]).map(move |x| [x, y]));
        let shows_at = |[x, y]: [u32; 2]| shows(y as usize * size[0] as usize + x as usize);
        let shows_in = |[column, row]: [u32; 2]| {
            let mut inside = places([TILE; 2]).map(|[x, y]| [TILE * column + x, TILE * row + y]);
            inside.any(|at| at[0] < size[0] && at[1] < size[1] && shows_at(at))
        };
        let packed = |[x, y]: [u32; 2]| x | y << 16;
        let list: Vec<u32> = places(size).filter(|&at| shows_at(at)).map(packed).collect();
        let tiles: Vec<u32> = places(in_tiles(size)).filter(|&tile| shows_in(tile)).map(packed).collect();
        let count = list.len() as u32;
        // Bindings have room for at least one.
        let list = [&[count], &list[..], &[0]].concat();
        let tiles = [&[tiles.len() as u32, count], &tiles[..], &[0]].concat();
        Ok(Self {
            size,
            mask: Texture::from_texels(gpu, mask_size, &marks)?,
            list: Buffer::from_slice(gpu, &list)?,
            tiles: Buffer::from_slice(gpu, &tiles)?,
            is_listed: AtomicBool::new(true),
        })
    }

    /// `[width, height]` of the picture.
    pub fn size(&self) -> [u32; 2] {
        self.size
    }

    /// Width and height in tiles.
    pub fn size_in_tiles(&self) -> [u32; 2] {
        in_tiles(self.size)
    }

    /// The list, which is made now if no pass of this frame asked for it: `CoveredPixels`.
    pub fn list(&self, recorder: &mut Recorder, gpu: &Gpu) -> Binding {
        if !self.is_listed.swap(true, Ordering::Relaxed) {
            let bindings = [("mask", self.mask.bind()), ("covered", self.list.bind())];
            recorder.compute(gpu, "ssfr.list", &gpu.list_covered, &bindings, Dispatch::Pixels(self.size));
        }
        self.list.bind()
    }

    /// Room for the list, for the pass that makes it.
    pub(crate) fn room(&self) -> Binding {
        self.list.bind()
    }

    /// The tiles that show fluid: `CoveredTiles`.
    pub fn tiles(&self) -> Binding {
        self.tiles.bind()
    }

    /// Dispatch of a pass over the list in groups of 64, each invocation of which walks on through it: only the GPU knows how long it is.
    pub fn dispatch(&self) -> Dispatch {
        dispatch(self.size)
    }

    /// As [`Self::dispatch`], over the rows or columns of all tiles in the list.
    pub fn dispatch_lines(&self) -> Dispatch {
        let [width, height] = in_tiles(self.size);
        dispatch([width, TILE * height])
    }

    /// How many there were in the last frame; waits for the GPU.
    ///
    /// # Errors
    /// The GPU's.
    pub fn count(&self, gpu: &Gpu) -> Result<u32, GpuError> {
        Ok(self.tiles.read_first(gpu, 2)?.get(1).copied().unwrap_or(0))
    }

    /// Empties both lists, before passes fill them; timed as `name`.
    pub fn empty(&self, recorder: &mut Recorder, gpu: &Gpu, name: &str) {
        recorder.zero(gpu, name, &self.list, 1);
        recorder.zero(gpu, name, &self.tiles, 2);
    }

    /// The depth attachment of passes that draw the picture.
    pub(crate) fn mask(&self) -> &wgpu::TextureView {
        self.mask.view()
    }

    /// Notes that a pass made another mask or, if it `is_listed`, another list.
    pub(crate) fn note_marks(&self, is_listed: bool) {
        self.is_listed.store(is_listed, Ordering::Relaxed);
    }
}

fn mask_size(gpu: &Gpu, size: [u32; 2]) -> [u32; 2] {
    if gpu.computes_pictures() { [1, 1] } else { size }
}

fn in_tiles(size: [u32; 2]) -> [u32; 2] {
    size.map(|side| side.div_ceil(TILE))
}

fn pixels(size: [u32; 2]) -> usize {
    size[0] as usize * size[1] as usize
}

/// Dispatch of a pass over a list of pixels of a picture of `size`, in groups of 64.
pub fn dispatch(size: [u32; 2]) -> Dispatch {
    Dispatch::Shares((pixels(size) as u64).div_ceil(64))
}
