//! Sets as they lie on the GPU, and what the splat passes take of them.

use meniscus_core::{Aabb, Camera, Look};
use meniscus_gpu::role::KeptRange;
use meniscus_lod::weight::{GROWS_BELOW, MAX_GROWTH};
use meniscus_lod::{GpuSet, PageLists, Selection, Selector, SetPage, Viewpoint};
use meniscus_shading::SceneGeometry;
use meniscus_ssfr::{Radii, SplatInput, SplatSet, SsfrParams, Tested};

use crate::colors::GpuValues;
use crate::foam::GpuFoam;
use crate::shapes::SetShapes;
use crate::{PreparedFrame, PreparedSet, World};

/// A set on the GPU and what of it is drawn.
pub(crate) struct DrawnSet {
    pub(crate) look: Look,
    pub(crate) gpu: GpuSet,
    pub(crate) values: GpuValues,
    pub(crate) foam: GpuFoam,
    pub(crate) selector: Selector,
    pub(crate) shapes: SetShapes,
}

/// Looks that become part of the opaque scene, in the order drawn.
pub(crate) const OPAQUE_LOOKS: [Look; 2] = [Look::Solid, Look::Spheres];

impl DrawnSet {
    pub(crate) fn new() -> Self {
        Self {
            look: Look::Hidden,
            gpu: GpuSet::default(),
            values: GpuValues::default(),
            foam: GpuFoam::default(),
            selector: Selector::default(),
            shapes: SetShapes::default(),
        }
    }

    pub(crate) fn splat_inputs(&self) -> Vec<SplatInput<'_>> {
        let mut inputs = splat_inputs(&self.gpu);
        for (input, shapes) in inputs.iter_mut().zip(self.shapes.pages()) {
            input.shapes = Some(shapes);
        }
        inputs
    }
}

/// Box around all that is opaque but the floor: objects of the scene and particles that are drawn opaque.
pub(crate) fn objects(frame: &PreparedFrame, world: &World, geometry: &SceneGeometry) -> Option<Aabb> {
    let sets = frame.sets.iter().filter(|set| OPAQUE_LOOKS.contains(&set.look));
    let of_set = |set: &PreparedSet| {
        let largest = set.chunked.chunks.iter().map(|chunk| chunk.largest).fold(1.0, f32::max);
        // Particles that are kept for others grow.
        set.chunked.bounds.inflated(MAX_GROWTH * largest * world.space().radius as f32)
    };
    let bounds =
        sets.filter(|set| !set.chunked.chunks.is_empty()).map(of_set).fold(geometry.objects(), Aabb::union);
    (!bounds.is_empty()).then_some(bounds)
}

/// Part of a spacing that rounding may let the floor reach into the cells of the lowest particles.
const ROUNDING: f32 = 0.01;

/// Whether nothing opaque cuts the water of `frame`: there are no objects, and the floor does not reach into the cells of particles.
pub(crate) fn is_water_in_front(frame: &PreparedFrame, world: &World, geometry: &SceneGeometry) -> bool {
    if objects(frame, world, geometry).is_some() {
        return false;
    }
    let Some(floor) = world.scene().floor else { return true };
    let up = world.space().up.index();
    let half_cell = (0.5 - ROUNDING) * world.space().spacing as f32;
    let mut chunks =
        frame.sets.iter().filter(|set| set.look == Look::Water).flat_map(|set| &set.chunked.chunks);
    chunks.all(|chunk| chunk.bounds.min[up] - half_cell * chunk.largest.max(1.0) >= floor.height_world)
}

/// What a camera sees of spheres.
pub(crate) fn viewpoint(
    world: &World,
    camera: &Camera,
    size_px: [u32; 2],
    surface: &SsfrParams,
) -> Viewpoint {
    Viewpoint {
        camera: *camera,
        size_px,
        radius_world: world.space().radius as f32,
        shell_reach: 1.0,
        spacing_world: world.space().spacing as f32,
        sample_px: surface.thickness.scale,
    }
}

pub(crate) fn splat_set<'a>(
    pages: &'a [SplatInput<'a>],
    world: &World,
    selection: &Selection,
    is_in_front: bool,
) -> SplatSet<'a> {
    SplatSet {
        pages,
        radius_world: world.space().radius as f32,
        volume_world: (world.space().spacing as f32).powi(3),
        radii: if selection.is_uniform_surface {
            Radii::Equal
        } else if !selection.has_sizes
            && selection.least_keep as f32 >= GROWS_BELOW * KeptRange::KEEP_ALL as f32
        {
            Radii::Fading
        } else if !selection.has_sizes {
            Radii::Grown
        } else {
            Radii::Different
        },
        is_uniform_mass: selection.is_uniform_mass,
        is_in_front,
        most_half_px: selection.most_half_px,
        most_radius_px: selection.most_radius_px,
        front_half_px: selection.front_half_px(),
        most_thickness: selection.most_thickness,
    }
}

pub(crate) fn splat_inputs(set: &GpuSet) -> Vec<SplatInput<'_>> {
    set.pages().map(|(page, lists)| splat_input(page, lists)).collect()
}

fn splat_input<'a>(page: &'a SetPage, lists: &'a PageLists) -> SplatInput<'a> {
    let SetPage { particles, stand_in_spheres } = page;
    let PageLists { front, occludees, visible, mass, stand_ins } = lists;
    SplatInput {
        particles,
        shapes: None,
        front,
        tested: Some(Tested { occludees, visible }),
        mass,
        stand_ins: Some((stand_in_spheres, stand_ins)),
    }
}
