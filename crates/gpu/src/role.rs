//! What a GPU resource means: element, space, unit, the value for "nothing here" and the valid range. Stages take and
//! return roles.

use bytemuck::{Pod, Zeroable};
use half::f16;

/// Meaning of a storage buffer's or storage image's elements.
pub trait Role: 'static {
    /// Element type as stored.
    type Element: Pod;
    /// Name in messages and debug labels.
    const NAME: &'static str;
    /// Space and unit of an element.
    const UNIT: &'static str;
    /// Value that means "nothing here".
    const EMPTY: Self::Element;
}

/// Meaning of a texture's texels.
pub trait TextureRole: 'static {
    /// A texel on the host.
    type Texel: Pod;
    /// Texel format.
    const FORMAT: wgpu::TextureFormat;
    /// Name in messages and debug labels.
    const NAME: &'static str;
    /// Space and unit of a texel.
    const UNIT: &'static str;
}

/// Distance that means "no surface": a large finite number, because WGSL may assume that infinities do not occur.
pub const NO_SURFACE: f32 = f32::MAX;

macro_rules! roles {
    ($($(#[$doc:meta])* $name:ident: $element:ty, unit $unit:literal, empty $empty:expr;)*) => {$(
        $(#[$doc])*
        #[derive(Clone, Copy, Debug)]
        pub enum $name {}
        impl Role for $name {
            type Element = $element;
            const NAME: &'static str = stringify!($name);
            const UNIT: &'static str = $unit;
            const EMPTY: Self::Element = $empty;
        }
    )*};
}

roles! {
    /// One page of particles in chunk order.
    Particles: PackedParticle, unit "world", empty PackedParticle { position_world: [0.0; 3], packed: 0 };
    /// Runs of a page's particles or stand-ins; the first element is the list's length ([`crate::RangeList`]).
    KeptRanges: KeptRange, unit "particles", empty KeptRange { first: 0, count: 0, keep: 0, shape: 0 };
    /// Runs of a page's particles that are drawn unless something hides them.
    Occludees: Occludee, unit "particles", empty Occludee {
        range: KeptRange { first: 0, count: 0, keep: 0, shape: 0 }, front: 0.0, first_tile: 0, last_tile: 0, pad: 0,
    };
    /// Coarse stand-ins for the particles of a page.
    StandIns: StandIn, unit "world", empty StandIn { center_world: [0.0; 3], packed: 0 };
    /// Shapes of the particles of a page's shell, chunk by chunk: WGSL `meniscus::shape`.
    Shapes: [u32; 4], unit "relative to a sphere", empty [0; 4];
    /// Drops of foam.
    FoamDrops: FoamDrop, unit "world", empty FoamDrop { center_world: [0.0; 3], packed: 0 };
    /// Optical depth of foam: in front of the surface, in it, behind it, and the last times its depth behind the surface in
    /// spacings; in [`FoamDrop::STEPS`].
    FoamLayers: [u32; 4], unit "optical depth in fixed point", empty [0; 4];
    /// One attribute value per particle of a page, in the page's order.
    AttributeValues: f32, unit "the attribute's own", empty 0.0;
    /// Colours of a scale from its start to its end, linear Rec. 709.
    ColorTable: [f32; 4], unit "linear, 0 to 1", empty [0.0; 4];
    /// Display image, sRGB transfer, 8 bits per channel, red in the lowest byte.
    DisplayImage: u32, unit "sRGB rgba8", empty 0;
    /// Raw numbers private to one pass chain.
    Scratch: u32, unit "private", empty 0;
}

macro_rules! texture_roles {
    ($($(#[$doc:meta])* $name:ident: $format:ident as $texel:ty, unit $unit:literal;)*) => {$(
        $(#[$doc])*
        #[derive(Clone, Copy, Debug)]
        pub enum $name {}
        impl TextureRole for $name {
            type Texel = $texel;
            const FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::$format;
            const NAME: &'static str = stringify!($name);
            const UNIT: &'static str = $unit;
        }
    )*};
}

texture_roles! {
    /// The nearest sphere: its distance along the view axis, (0, MAX), MAX = none; its drawn radius, 0 = none.
    FrontSphere: Rg32Float as [f32; 2], unit "world units along the view axis, world units";
    /// Distance of the nearest surface along the view axis; (0, MAX), MAX = no surface.
    EyeDistance: R32Float as f32, unit "world units along the view axis";
    /// Length of fluid along the view ray up to the opaque scene; [0, inf), 0 = none.
    Thickness: R32Float as f32, unit "world units along the ray";
    /// Farthest distance that a tile of the picture shows while splats are drawn.
    FarthestDistance: R32Float as f32, unit "world units along the view axis";
    /// Unit normal in view space, octahedral in two snorm16; bits 0 = straight at the viewer.
    ViewNormal: R32Uint as u32, unit "view space, octahedral 2 x snorm16";
    /// What a pass of a filter leaves for the next one.
    FilterStep: R32Float as f32, unit "private";
    /// Elements of a page of particles or stand-ins, 16 bytes each ([`crate::Page`]).
    PageTexels: Rgba32Uint as [u32; 4], unit "as the page's role";
    /// Particles by cell of a grid, while shapes are found: centre in world space, volume relative to the set's own, at most 1;
    /// folded into rows.
    GridParticles: Rgba32Float as [f32; 4], unit "world, 0 to 1";
    /// What a block of the picture tells the smoothing of the thickness: WGSL `meniscus::thickness::Block`.
    ReducedSurface: Rgba32Float as [f32; 4], unit "private";
    /// Thickness at reduced size, times and beside the part of a block that it covers.
    ReducedThickness: Rg32Float as [f32; 2], unit "world units along the ray, 0 to 1";
    /// The same smoothed along rows, with the standard deviation; along columns, WGSL `meniscus::thickness::SmoothedBlock`.
    SmoothedThickness: Rgba32Float as [f32; 4], unit "private";
    /// Colour that an attribute gives the surface, linear Rec. 709; alpha = how much of the surface's own colour it replaces.
    SurfaceColor: Rgba32Float as [f32; 4], unit "linear, 0 to 1";
    /// What becomes of the sun's light on its way, one value per block of pixels: length of water that it crosses to the opaque
    /// scene (world units), its irradiance there relative to water without waves, and the share that reaches the water's
    /// surface (0 to 1), packed by [`Sunlight::pack`].
    Sunlight: Rg32Uint as [u32; 2], unit "world units towards the sun, ratio, share";
    /// Lit opaque scene.
    SceneColor: Rgba16Float as [f16; 4], unit "linear radiance, Rec. 709";
    /// Distance of the opaque scene along the view axis; MAX = sky.
    SceneDistance: R32Float as f32, unit "world units along the view axis";
    /// Linear radiance, Rec. 709 primaries, alpha = coverage.
    Radiance: Rgba16Float as [f16; 4], unit "linear, relative";
    /// Four neighbours in a row of the display image, as that has them ([`DisplayImage`]).
    FourPixels: Rgba32Uint as [u32; 4], unit "4 x sRGB rgba8";
    /// Brightness of four neighbours in a row of the picture, a byte each.
    Lumas: R32Uint as u32, unit "4 x 8 bits";
    /// A level of the pyramid that bloom is made of.
    BloomLevel: Rgba16Float as [f16; 4], unit "linear radiance, exposed, Rec. 709";
    /// Which pixels show fluid ([`crate::Covered`]).
    CoverMask: Depth16Unorm as u16, unit "65535 = fluid, 0 = none";
    /// Depth attachment of the opaque scene, reversed z.
    SceneDepth: Depth32Float as f32, unit "reversed clip z";
}

impl Radiance {
    /// Most that a stored channel is off, relative to it: halves have 11 bits, and drivers may cut off the others.
    pub const ROUNDING: f32 = 1.0 / 1024.0;
}

impl Sunlight {
    /// No water, all light.
    pub const UNCHANGED: [u32; 2] = [0, 0xffff_4000];

    /// A value from its three numbers, a length in world units, a ratio below 4, and a share; `shaders/shading/sunlight.inc.wgsl`.
    pub fn pack(path_world: f32, focus: f32, share: f32) -> [u32; 2] {
        let low = (focus * 16384.0 + 0.5).clamp(0.0, 65535.0) as u32;
        [path_world.to_bits(), low | ((share.clamp(0.0, 1.0) * 65535.0 + 0.5) as u32) << 16]
    }

    /// The inverse of [`Self::pack`].
    pub fn unpack([path, rest]: [u32; 2]) -> [f32; 3] {
        [f32::from_bits(path), (rest & 0xffff) as f32 / 16384.0, (rest >> 16) as f32 / 65535.0]
    }
}

/// A particle as the GPU reads it: 16 bytes, one aligned load.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct PackedParticle {
    /// Centre, world space.
    pub position_world: [f32; 3],
    /// Low 16 bits: hash of the particle's identity, which orders it within its chunk. High 16 bits: its radius relative
    /// to the set's radius, as an IEEE half.
    pub packed: u32,
}

impl PackedParticle {
    /// Half-precision bits of 1.0: the radius of the set.
    pub const UNIT_RADIUS_BITS: u32 = 0x3C00;

    /// A particle with the set's own radius.
    pub fn new(position_world: [f32; 3], hash: u16) -> Self {
        Self { position_world, packed: Self::UNIT_RADIUS_BITS << 16 | u32::from(hash) }
    }

    /// A particle with `relative` times the set's own radius, >= 0.
    pub fn sized(position_world: [f32; 3], hash: u16, relative: f32) -> Self {
        let bits = u32::from(f16::from_f32(relative).to_bits());
        Self { position_world, packed: bits << 16 | u32::from(hash) }
    }

    /// The 16-bit identity hash.
    pub fn hash(&self) -> u16 {
        self.packed as u16
    }
}

/// A run of particles within one page that is drawn with one keep probability.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq, Pod, Zeroable)]
pub struct KeptRange {
    /// Index of the first particle in the page.
    pub first: u32,
    /// Number of particles kept.
    pub count: u32,
    /// Keep probability in 1/65536: 1..=65536, where 65536 keeps all and switches fading off.
    pub keep: u32,
    /// 1 + the place of the first one's shape among the page's [`Shapes`], those of the others following; 0: all are spheres.
    pub shape: u32,
}

impl KeptRange {
    /// `keep` of a range in which every particle is drawn.
    pub const KEEP_ALL: u32 = 65536;
}

/// A run of particles and where it would show, for the test against what is drawn already.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct Occludee {
    /// The particles.
    pub range: KeptRange,
    /// Distance along the view axis that none of their spheres comes nearer than, world units.
    pub front: f32,
    /// The tiles of [`Occludee::TILE_PX`] pixels that hold all they could show in: column of the first in the low, row in
    /// the high 16 bits.
    pub first_tile: u32,
    /// The last of them, inclusive, in the same way.
    pub last_tile: u32,
    /// 0.
    pub pad: u32,
}

impl Occludee {
    /// Side of a tile in pixels.
    pub const TILE_PX: u32 = 8;
}

/// A sphere in place of a group of particles: 16 bytes, as a particle.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct StandIn {
    /// Centre of mass, world space.
    pub center_world: [f32; 3],
    /// Low 16 bits: volume in those of a particle of the set's own size. High 16 bits: radius in spacings. Both IEEE halves.
    pub packed: u32,
}

/// A soft white drop, of which foam, spray and bubbles are made: 16 bytes, as a particle.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct FoamDrop {
    /// Centre, world space.
    pub center_world: [f32; 3],
    /// Low 16 bits: optical depth along a line through the centre. High 16 bits: radius in spacings. Both IEEE halves.
    pub packed: u32,
}

impl FoamDrop {
    /// Steps of fixed point for an optical depth of 1: sums saturate at a million.
    pub const STEPS: u32 = 4096;

    /// A drop of this radius in spacings and optical depth at its centre.
    pub fn new(center_world: [f32; 3], radius_spacings: f32, optical_depth: f32) -> Self {
        let half = |value: f32| u32::from(f16::from_f32(value).to_bits());
        Self { center_world, packed: half(radius_spacings) << 16 | half(optical_depth) }
    }

    /// Radius in spacings.
    pub fn radius_spacings(&self) -> f32 {
        f16::from_bits((self.packed >> 16) as u16).to_f32()
    }

    /// Optical depth along a line through the centre.
    pub fn optical_depth(&self) -> f32 {
        f16::from_bits(self.packed as u16).to_f32()
    }
}

impl crate::HostStruct for FoamDrop {
    const WGSL_NAME: &'static str = "FoamDrop";
    const FIELDS: &'static [crate::HostField] = crate::host_fields!(FoamDrop { center_world, packed });
}

impl crate::HostStruct for Occludee {
    const WGSL_NAME: &'static str = "Occludee";
    const FIELDS: &'static [crate::HostField] =
        crate::host_fields!(Occludee { range, front, first_tile, last_tile, pad });
}

impl crate::HostStruct for StandIn {
    const WGSL_NAME: &'static str = "StandIn";
    const FIELDS: &'static [crate::HostField] = crate::host_fields!(StandIn { center_world, packed });
}

impl crate::HostStruct for PackedParticle {
    const WGSL_NAME: &'static str = "PackedParticle";
    const FIELDS: &'static [crate::HostField] =
        crate::host_fields!(PackedParticle { position_world, packed });
}

impl crate::HostStruct for KeptRange {
    const WGSL_NAME: &'static str = "KeptRange";
    const FIELDS: &'static [crate::HostField] = crate::host_fields!(KeptRange { first, count, keep, shape });
}
