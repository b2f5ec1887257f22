use glam::Vec3;

use crate::{PipelineError, Renderer};

/// The light of several pictures of one size, of which the mean is one picture: what falls in while a shutter is open.
#[derive(Clone, Debug, Default)]
pub struct Exposure {
    /// Per pixel the sums of radiance, of radiance times coverage, and of coverage.
    sums: Vec<(Vec3, Vec3, f32)>,
    pictures: u32,
}

impl Exposure {
    /// Adds a picture: linear radiance and coverage. What is no number counts as nothing.
    ///
    /// # Panics
    /// If it has another number of pixels than those before.
    fn add(&mut self, radiance: &[[f32; 4]]) {
        self.sums.resize(radiance.len().max(self.sums.len()), Default::default());
        assert_eq!(self.sums.len(), radiance.len(), "pixels of the pictures of one exposure");
        self.pictures += 1;
        for ((plain, covered, coverage), pixel) in self.sums.iter_mut().zip(radiance) {
            let [r, g, b, a] = pixel.map(|c| if c.is_finite() { c } else { 0.0 });
            let color = Vec3::new(r, g, b);
            *plain += color;
            *covered += color * a;
            *coverage += a;
        }
    }

    /// The mean. In a transparent picture, colours count by how much they cover.
    fn mean(&self, transparent: bool) -> Vec<[f32; 4]> {
        let count = self.pictures.max(1) as f32;
        let pixel = |&(plain, covered, coverage): &(Vec3, Vec3, f32)| {
            let by_cover = transparent && coverage > 0.0;
            let color = if by_cover { covered / coverage } else { plain / count };
            color.extend(coverage / count).to_array()
        };
        self.sums.iter().map(pixel).collect()
    }
}

impl Renderer {
    /// Adds the light of the picture that was just drawn to `exposure`.
    ///
    /// # Errors
    /// The GPU's.
    ///
    /// # Panics
    /// Before the first frame, or if earlier pictures of the exposure were of another size.
    pub fn expose(&self, exposure: &mut Exposure) -> Result<(), PipelineError> {
        exposure.add(&self.images().radiance.read_floats(self.gpu())?);
        Ok(())
    }

    /// Puts the mean of `exposure` in place of the picture that was just drawn; its display pixels.
    ///
    /// # Errors
    /// The GPU's.
    ///
    /// # Panics
    /// If nothing was exposed since the size of pictures changed.
    pub fn fix(&mut self, exposure: &Exposure) -> Result<Vec<u32>, PipelineError> {
        let mean = exposure.mean(self.settings().transparent());
        self.recompose(&mean)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn light_adds_up_and_what_is_no_number_does_not() {
        let mut exposure = Exposure::default();
        exposure.add(&[[8.0, 0.0, 0.0, 1.0], [f32::NAN, 1.0, f32::INFINITY, 1.0]]);
        exposure.add(&[[0.0, 2.0, 0.0, 0.0], [1.0, 1.0, 0.0, 1.0]]);
        assert_eq!(exposure.mean(false), [[4.0, 1.0, 0.0, 0.5], [0.5, 1.0, 0.0, 1.0]]);
        // A drop that passes in front of nothing keeps its colour and gets thinner.
        assert_eq!(exposure.mean(true)[0], [8.0, 0.0, 0.0, 0.5]);
        assert!(Exposure::default().mean(true).is_empty());
    }
}
