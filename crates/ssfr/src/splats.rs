use bytemuck::{Pod, Zeroable};
use meniscus_core::DEFAULT_RADIUS_PER_SPACING;
use meniscus_gpu::role::{Occludees, Particles, Shapes, StandIns};
use meniscus_gpu::{Buffer, HostField, HostStruct, Page, RangeList};

use crate::SsfrParams;

/// One page of particles and what of it is drawn. A workgroup draws one range, so ranges should be short (about a
/// thousand particles) and hold neighbours; nearest first is fastest.
#[derive(Clone, Copy, Debug)]
pub struct SplatInput<'a> {
    /// The particles.
    pub particles: &'a Page<Particles>,
    /// Their shapes, as the ranges say ([`crate::ShapePasses`]); without, and in a stage without anisotropy, all are spheres.
    pub shapes: Option<&'a Buffer<Shapes>>,
    /// The ranges that the surface is drawn from first.
    pub front: &'a RangeList,
    /// What the surface is drawn from after that.
    pub tested: Option<Tested<'a>>,
    /// The ranges that count in the thickness.
    pub mass: &'a RangeList,
    /// Spheres that count in the thickness for other particles, and which of them do.
    pub stand_ins: Option<(&'a Page<StandIns>, &'a RangeList)>,
}

/// Ranges that are only drawn where nothing hides them.
#[derive(Clone, Copy, Debug)]
pub struct Tested<'a> {
    /// The ranges and where they would show.
    pub occludees: &'a Buffer<Occludees>,
    /// Room for those of them that are not hidden.
    pub visible: &'a RangeList,
}

/// How the radii that particles of a set are drawn with differ.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Radii {
    /// All have the set's radius.
    Equal,
    /// Some are smaller while they fade in; the set's radius is right for the smoothing all the same.
    Fading,
    /// Level of detail makes some up to twice as large, none has a radius of its own: the last bits of the distance image tell the
    /// visible one's, to 2.4 percent.
    Grown,
    /// Some have radii of their own: a pass finds the radius of each pixel.
    Different,
}

/// Particles that are drawn with one radius and stand for one volume.
#[derive(Clone, Copy, Debug)]
pub struct SplatSet<'a> {
    /// The set's pages.
    pub pages: &'a [SplatInput<'a>],
    /// Radius drawn, world units, > 0.
    pub radius_world: f32,
    /// Volume that one particle stands for, world units cubed, > 0: the cube of the spacing.
    pub volume_world: f32,
    /// How the radii of what can be seen differ.
    pub radii: Radii,
    /// Whether every particle that counts in the thickness has the set's radius and volume.
    pub is_uniform_mass: bool,
    /// Whether nothing opaque cuts any of them: what of them lies behind the scene, as the lower rim of spheres on a floor may,
    /// counts in the thickness.
    pub is_in_front: bool,
    /// Half size in pixels that none of those exceeds that count in the thickness as themselves; infinite where that is not known.
    pub most_half_px: f32,
    /// Radius in pixels that no sphere exceeds at its point nearest to the eye; infinite where that is not known.
    pub most_radius_px: f32,
    /// Half size in pixels of what is drawn first, root of the mean square: what it costs goes with its pixels.
    pub front_half_px: f32,
    /// Thickness that a pixel does not exceed even if all of the set is piled up in it, spacings; infinite where that is not known.
    pub most_thickness: f64,
}

impl SplatSet<'_> {
    /// Distance of neighbouring particles, world units.
    pub fn spacing_world(&self) -> f32 {
        self.volume_world.cbrt()
    }
}

/// `meniscus::splat::SplatSet` of `shaders/ssfr/splat.inc.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub(crate) struct SplatUniform {
    pub(crate) radius_world: f32,
    pub(crate) volume_world: f32,
    pub(crate) steps_per_world: f32,
    pub(crate) closing: f32,
    pub(crate) is_graded: u32,
    pub(crate) most_shift_world: f32,
    pub(crate) longest_axis: f32,
}

impl HostStruct for SplatUniform {
    const WGSL_NAME: &'static str = "SplatSet";
    const FIELDS: &'static [HostField] = meniscus_gpu::host_fields!(SplatUniform {
        radius_world,
        volume_world,
        steps_per_world,
        closing,
        is_graded,
        most_shift_world,
        longest_axis,
    });
}

/// How much of the growth of thinned particles is needed to close holes, at most 1 (`meniscus::particle::kept`): spheres of the
/// default radius just cover what is behind them.
pub(crate) fn closing(radius_world: f32, spacing_world: f32) -> f32 {
    (DEFAULT_RADIUS_PER_SPACING as f32 * spacing_world / radius_world).min(1.0)
}

/// Most steps of the fixed-point thickness per spacing of the finest set: sums saturate at two million spacings.
const MOST_STEPS: f64 = 1024.0;
/// Fewest, where that leaves room for all sums. Rounding them is left to chance, so that many small ones are right in the mean.
const LEAST_STEPS: f64 = 128.0;
/// What sums may reach, of the 32 bits: as much again is room for rounding up and for what stand-ins are off.
const ROOM: f64 = (1u64 << 31) as f64;

/// Where the radius of the visible splat comes from.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum VisibleRadius {
    /// All have this one, world units.
    One(f32),
    /// The last bits of the distance tell how it compares with this one, world units.
    Graded(f32),
    /// A pass finds it.
    Found,
}

/// What the passes need to know of all sets together.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Common {
    pub(crate) steps_per_world: f32,
    pub(crate) visible_radius: VisibleRadius,
    /// Of the first set; the filters scale with it.
    pub(crate) spacing_per_radius: f32,
    /// Pixels that the radius of no sphere exceeds at its point nearest to the eye.
    pub(crate) most_radius_px: f32,
    /// Pixels that the radii of what is drawn first have in the root of the mean square, of the set with the largest.
    pub(crate) typical_radius_px: f32,
    /// Most that a half-axis of an ellipsoid is of the radius.
    pub(crate) longest_axis: f32,
    /// Whether nothing opaque cuts any of the sets.
    pub(crate) is_in_front: bool,
    /// Whether no sum of the thickness can exceed its 32 bits.
    pub(crate) is_bounded: bool,
}

impl Common {
    pub(crate) fn of(sets: &[SplatSet<'_>], params: &SsfrParams) -> Self {
        let finest = sets.iter().map(SplatSet::spacing_world).fold(f32::INFINITY, f32::min);
        let visible_radius = match sets {
            [only] if only.radii <= Radii::Fading => VisibleRadius::One(only.radius_world),
            [only] if only.radii == Radii::Grown => VisibleRadius::Graded(only.radius_world),
            _ => VisibleRadius::Found,
        };
        let samples_per_px = f64::from(params.thickness.scale).powi(-2);
        let most = |set: &SplatSet<'_>| {
            set.most_thickness * samples_per_px * f64::from(set.spacing_world() / finest)
        };
        let room = ROOM / sets.iter().map(most).sum::<f64>();
        let is_bounded = room >= LEAST_STEPS;
        // By factors of two, so that they seldom change.
        let steps = if is_bounded { room.log2().floor().exp2().min(MOST_STEPS) } else { MOST_STEPS };
        Self {
            steps_per_world: if finest.is_finite() { steps as f32 / finest } else { 1.0 },
            visible_radius,
            spacing_per_radius: sets.first().map_or(1.6, |set| set.spacing_world() / set.radius_world),
            most_radius_px: sets.iter().map(|set| set.most_radius_px).fold(0.0, f32::max),
            typical_radius_px: sets.iter().map(|set| set.front_half_px).fold(0.0, f32::max),
            longest_axis: params.anisotropy.longest_axis(),
            is_bounded,
            is_in_front: sets.iter().all(|set| set.is_in_front),
        }
    }
}
