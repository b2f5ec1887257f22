//! Pictures of what level of detail decided, for people who tune it or ask where the time goes. Drawn on the processor: they
//! are looked at, not played.

use std::str::FromStr;

use glam::{Vec2, Vec3};
use meniscus_color::ColorMap;
use meniscus_core::{Aabb, Camera, UpAxis};
use meniscus_gpu::role::NO_SURFACE;
use meniscus_lod::{Chunk, Coarseness, Fate};

/// What to show.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LodView {
    /// The kept fraction of each chunk on the water: violet for none, yellow for all.
    Kept,
    /// Every chunk in a colour of its own.
    Chunks,
    /// What stands for the particles in the thickness: grey themselves, then green, orange and red, the coarser the redder.
    Levels,
    /// A map from above of what became of all chunks, seen or not: green drawn first, blue drawn where nothing hides it, red
    /// outside of the view, violet before the near plane, grey beyond the far distance; white, the view's sides.
    Culled,
}

impl LodView {
    /// All, by the names that users type.
    pub const NAMES: [(&str, Self); 4] = [
        ("lod-kept", Self::Kept),
        ("lod-chunks", Self::Chunks),
        ("lod-levels", Self::Levels),
        ("lod-culled", Self::Culled),
    ];
}

impl FromStr for LodView {
    type Err = String;

    fn from_str(name: &str) -> Result<Self, String> {
        let names = || Self::NAMES.map(|(name, _)| name).join(", ");
        let found = Self::NAMES.iter().find(|(known, _)| *known == name).map(|(_, view)| *view);
        found.ok_or_else(|| format!("there is no view `{name}`; there are {}", names()))
    }
}

/// A chunk and what became of it.
pub(crate) type Explained<'a> = (&'a Chunk, Fate);

/// The picture to paint on.
pub(crate) struct Canvas<'a> {
    /// sRGB, red in the lowest byte, row by row from the top left.
    pub(crate) pixels: &'a mut [u32],
    pub(crate) size: [u32; 2],
    pub(crate) camera: &'a Camera,
}

type Colour = [f32; 3];

impl Canvas<'_> {
    /// Paints `view` over the picture. `distance`: of the water, per pixel; `reach_world`: how far from its chunk's centres
    /// the surface of particles of size 1 may be.
    pub(crate) fn paint(
        &mut self,
        view: LodView,
        chunks: &[Explained],
        distance: &[f32],
        reach_world: f32,
        up: UpAxis,
    ) {
        if view == LodView::Culled {
            return self.map(chunks, up);
        }
        for (pixel, chunk) in self.chunk_of_pixels(chunks, distance, reach_world).into_iter().enumerate() {
            if let Some(index) = chunk {
                self.tint(pixel, colour(view, index, &chunks[index]));
            }
        }
    }

    /// The chunk in view whose centre is nearest among those that the surface in a pixel may belong to.
    fn chunk_of_pixels(&self, chunks: &[Explained], distance: &[f32], reach: f32) -> Vec<Option<usize>> {
        let view = self.camera.view_from_world();
        let world = view.inverse();
        let half = self.camera.half_extent(self.size);
        let size = Vec2::new(self.size[0] as f32, self.size[1] as f32);
        let scale = |d: f32| if self.camera.is_orthographic() { 1.0 } else { d };
        let mut best = vec![(f32::INFINITY, None); distance.len()];
        for (index, (chunk, _)) in chunks.iter().enumerate().filter(|(_, (_, fate))| is_selected(fate)) {
            let bounds = chunk.bounds.inflated(reach * chunk.largest);
            let corners = bounds.corners().map(|corner| view.transform_point3(corner));
            let (mut low, mut high) = (size, Vec2::ZERO);
            for corner in corners {
                let d = (-corner.z).max(self.camera.near);
                let px = (corner.truncate() / (half * scale(d)) * Vec2::new(0.5, -0.5) + 0.5) * size;
                (low, high) = (low.min(px), high.max(px));
            }
            let (low, high) =
                (low.max(Vec2::ZERO).as_uvec2(), high.min(size).ceil().max(Vec2::ZERO).as_uvec2());
            for (y, x) in (low.y..high.y).flat_map(|y| (low.x..high.x).map(move |x| (y, x))) {
                let pixel = (y * self.size[0] + x) as usize;
                let d = distance[pixel];
                if d >= NO_SURFACE {
                    continue;
                }
                let ndc = (Vec2::new(x as f32, y as f32) + 0.5) / size * Vec2::new(2.0, -2.0)
                    + Vec2::new(-1.0, 1.0);
                let at = world.transform_point3((ndc * half * scale(d)).extend(-d));
                let apart = at.distance_squared(bounds.center());
                if at.cmpge(bounds.min).all() && at.cmple(bounds.max).all() && apart < best[pixel].0 {
                    best[pixel] = (apart, Some(index));
                }
            }
        }
        best.into_iter().map(|(_, chunk)| chunk).collect()
    }

    /// All chunks from above, the higher over the lower, and the sides of the view.
    fn map(&mut self, chunks: &[Explained], up: UpAxis) {
        let background = pack([0.07; 3]);
        self.pixels.fill(background);
        let (a, b) = ((up.index() + 1) % 3, (up.index() + 2) % 3);
        let eye = self.camera.eye;
        let all = chunks.iter().fold(Aabb::EMPTY, |all, (chunk, _)| all.union(chunk.bounds));
        if all.is_empty() {
            return;
        }
        // The eye belongs in the picture, but not at the price of the chunks.
        let shown = all.union(Aabb { min: eye, max: eye }.inflated(0.0)).inflated(0.0);
        let limit = all.inflated(all.extent().max_element());
        let shown = Aabb { min: shown.min.max(limit.min), max: shown.max.min(limit.max) };
        let flat = |p: Vec3| Vec2::new(p[a], p[b]);
        let size = Vec2::new(self.size[0] as f32, self.size[1] as f32);
        let extent = (flat(shown.max) - flat(shown.min)).max(Vec2::splat(f32::MIN_POSITIVE));
        let scale = 0.95 * (size / extent).min_element();
        let middle = flat(shown.center());
        let to_px = |p: Vec2| (p - middle) * scale * Vec2::new(1.0, -1.0) + 0.5 * size;
        let mut by_height: Vec<&Explained> = chunks.iter().collect();
        by_height.sort_by(|x, y| x.0.bounds.max[up.index()].total_cmp(&y.0.bounds.max[up.index()]));
        for (chunk, fate) in by_height {
            let (low, high) = (to_px(flat(chunk.bounds.min)), to_px(flat(chunk.bounds.max)));
            self.fill(low.min(high), low.max(high), fate_colour(fate));
        }
        let forward = self.camera.forward();
        let right = forward.cross(self.camera.up).normalize_or_zero();
        let half = self.camera.half_extent(self.size).x;
        for side in [-1.0, 1.0] {
            let (start, direction) = if self.camera.is_orthographic() {
                (eye + right * half * side, forward)
            } else {
                (eye, forward + right * half * side)
            };
            let reach = 2.0 * (all.extent().length() + eye.distance(all.center()));
            self.line(to_px(flat(start)), to_px(flat(start + direction * reach)), [1.0; 3]);
        }
    }

    fn fill(&mut self, low: Vec2, high: Vec2, colour: Colour) {
        let last = Vec2::new(self.size[0] as f32, self.size[1] as f32) - 1.0;
        if high.cmplt(Vec2::ZERO).any() || low.cmpgt(last).any() {
            return;
        }
        let (low, high) = (low.clamp(Vec2::ZERO, last).as_uvec2(), high.clamp(Vec2::ZERO, last).as_uvec2());
        for y in low.y..=high.y {
            for x in low.x..=high.x {
                // A dark rim, so that chunks can be told apart where they are large enough.
                let is_rim = (x == low.x || y == low.y) && (high - low).min_element() > 2;
                let shade = if is_rim { 0.5 } else { 1.0 };
                self.pixels[(y * self.size[0] + x) as usize] = pack(colour.map(|c| c * shade));
            }
        }
    }

    fn line(&mut self, from: Vec2, to: Vec2, colour: Colour) {
        let size = Vec2::new(self.size[0] as f32, self.size[1] as f32);
        // Lines leave the picture by far; what is drawn of them is no longer than twice its diagonal.
        let direction = (to - from).normalize_or_zero();
        let steps = (to - from).length().min(4.0 * size.length());
        for step in 0..=steps as u32 {
            let at = from + direction * step as f32;
            if at.cmpge(Vec2::ZERO).all() && at.cmplt(size).all() {
                self.pixels[at.y as usize * self.size[0] as usize + at.x as usize] = pack(colour);
            }
        }
    }

    /// Three quarters of the colour over the picture's grey.
    fn tint(&mut self, pixel: usize, colour: Colour) {
        let [r, g, b, _] = self.pixels[pixel].to_le_bytes().map(f32::from);
        let grey = (0.2126 * r + 0.7152 * g + 0.0722 * b) / 255.0;
        self.pixels[pixel] = pack(colour.map(|c| 0.75 * c + 0.25 * grey));
    }
}

/// The kept fraction of the chunk that each pixel shows; as of [`Canvas::paint`].
pub(crate) fn kept_fractions(
    chunks: &[Explained],
    distance: &[f32],
    reach_world: f32,
    size: [u32; 2],
    camera: &Camera,
) -> Vec<f32> {
    let canvas = Canvas { pixels: &mut [], size, camera };
    let kept = |index: usize| match &chunks[index] {
        (chunk, Fate::Selected { kept, .. }) => *kept as f32 / chunk.count as f32,
        _ => 0.0,
    };
    let of_pixels = canvas.chunk_of_pixels(chunks, distance, reach_world);
    of_pixels.into_iter().map(|chunk| chunk.map_or(0.0, kept)).collect()
}

fn is_selected(fate: &Fate) -> bool {
    matches!(fate, Fate::Selected { .. })
}

fn pack(colour: Colour) -> u32 {
    let [r, g, b] = colour.map(|c| (c * 255.0).round() as u8);
    u32::from_le_bytes([r, g, b, 255])
}

fn colour(view: LodView, index: usize, (chunk, fate): &Explained) -> Colour {
    let Fate::Selected { kept, stand_ins, .. } = fate else { return [0.0; 3] };
    match view {
        LodView::Kept => ColorMap::Viridis.srgb(f64::from(*kept) / f64::from(chunk.count)).to_array(),
        LodView::Chunks => {
            // Steps of the golden ratio around the circle of hues: neighbours along the curve differ most.
            let hue = (index as f32 * 0.618_034).fract() * 6.0;
            [0.0, 4.0, 2.0].map(|offset| (((hue + offset) % 6.0 - 3.0).abs() - 1.0).clamp(0.1, 0.9))
        }
        _ => match stand_ins[0].or(stand_ins[1]) {
            None => [0.7; 3],
            Some(Coarseness::Cells) => [0.2, 0.7, 0.3],
            Some(Coarseness::Blocks) => [0.95, 0.6, 0.1],
            Some(Coarseness::Whole) => [0.85, 0.15, 0.15],
        },
    }
}

fn fate_colour(fate: &Fate) -> Colour {
    match fate {
        Fate::Selected { tested: false, .. } => [0.2, 0.7, 0.3],
        Fate::Selected { tested: true, .. } => [0.2, 0.4, 0.9],
        Fate::Outside => [0.75, 0.2, 0.15],
        Fate::TooNear => [0.6, 0.2, 0.8],
        Fate::TooFar => [0.5; 3],
    }
}
