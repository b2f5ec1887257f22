use bytemuck::{Pod, Zeroable};
use meniscus_core::Aabb;
use meniscus_gpu::{HostField, HostStruct, host_fields};

/// A box around all objects as the GPU sees it; WGSL: `ObjectBounds` in `shaders/shading/reflected_objects.inc.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct ObjectBounds {
    /// World.
    pub min: [f32; 3],
    /// Pad.
    pub pad_a: f32,
    /// World.
    pub max: [f32; 3],
    /// Pad.
    pub pad_b: f32,
}

impl From<Aabb> for ObjectBounds {
    /// A little larger, so that rays are in front of a surface that lies in a side of the box when they enter it.
    fn from(bounds: Aabb) -> Self {
        let bounds = bounds.inflated(0.01 * bounds.extent().length());
        Self { min: bounds.min.to_array(), pad_a: 0.0, max: bounds.max.to_array(), pad_b: 0.0 }
    }
}

impl HostStruct for ObjectBounds {
    const WGSL_NAME: &'static str = "ObjectBounds";
    const FIELDS: &'static [HostField] = host_fields!(ObjectBounds { min, pad_a, max, pad_b });
}

#[cfg(test)]
mod tests {
    use meniscus_gpu::shader;

    use super::*;

    #[test]
    fn the_box_has_the_layout_of_its_shader() {
        ObjectBounds::check_layout(&shader!(include "shading/reflected_objects"), crate::INCLUDES).unwrap();
    }
}
