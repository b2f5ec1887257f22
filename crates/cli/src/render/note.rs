//! What a picture says about how it was made, by which `--resume` knows it again.

use meniscus_core::{Camera, PixelDepth};
use meniscus_overlay::Overlay;
use meniscus_timeline::Sample;

use crate::args::{InputArgs, RenderArgs};
use crate::picture::Studio;

/// What is the same for all pictures of a run.
pub struct Maker {
    hash: u64,
}

impl Maker {
    /// Everything that the pixels depend on, besides the particles, the moment and the camera.
    pub fn new(studio: &Studio, args: &RenderArgs, depth: PixelDepth) -> Self {
        let renderer = &studio.renderer;
        let RenderArgs { supersample, show, layers, .. } = args;
        let quality = args.encoding.still_quality();
        let InputArgs { sets, where_expr, every, region, keep_ghosts, .. } = &args.input;
        let text = format!(
            "{:?} {} {:?} {:?} {supersample} {depth:?} {quality} {show:?} {layers:?} {sets:?} {where_expr:?} {every:?} \
             {region:?} {keep_ghosts}",
            renderer.gpu().summary(),
            renderer.settings().effective(renderer.registry(), Some(&studio.world)),
            studio.world,
            studio.size,
        );
        Self { hash: hash(&text) }
    }

    /// The note of a picture of these parts with this written over it: the program's version and a number.
    pub fn note(&self, parts: &[(Sample, Camera)], overlay: &Overlay) -> String {
        let hash = hash(&format!("{} {parts:?} {overlay:?}", self.hash));
        format!("{} {hash:016x}", env!("CARGO_PKG_VERSION"))
    }
}

/// FNV-1a, which is the same in every build.
fn hash(text: &str) -> u64 {
    text.bytes().fold(0xcbf2_9ce4_8422_2325, |hash, byte| {
        (hash ^ u64::from(byte)).wrapping_mul(0x0000_0100_0000_01b3)
    })
}
