use glam::Vec3;

/// What is seen of a surface, pixel by pixel, row by row from the top left.
#[derive(Clone, Debug, PartialEq)]
pub struct Surface {
    /// Unit normals in view space (x to the right, y up, z towards the eye); zero where there is no surface.
    pub normal: Vec<Vec3>,
    /// Along the view axis, world units; means nothing where there is no normal. `None` where whoever drew it does not tell.
    pub distance: Option<Vec<f32>>,
}

impl Surface {
    /// Whether the surface is seen in a pixel.
    pub fn covers(&self, pixel: usize) -> bool {
        self.normal[pixel] != Vec3::ZERO
    }
}
