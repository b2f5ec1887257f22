use meniscus_gpu::role::{EyeDistance, FilterStep, FrontSphere, NO_SURFACE, Scratch};
use meniscus_gpu::{Buffer, CameraUniform, Covered, Gpu, GpuError, Recorder, Texture, Timing};

use super::pictures::{Picture, SPACING_PER_RADIUS, is_surface};
use crate::filter::{FilterImages, HostSurface, SurfaceFilter, TAPS, scratch_len};

/// A filter on a device.
pub(super) struct Run<'a> {
    pub gpu: &'a Gpu,
    pub filter: &'a dyn SurfaceFilter,
}

impl Run<'_> {
    /// The passes' result; everywhere a surface where `picture` has one, and nowhere else.
    pub fn on_gpu(&self, picture: &Picture) -> Result<Vec<f32>, String> {
        let (found, _) = self.counted(picture, false)?;
        Ok(found)
    }

    /// The same where the filter takes spheres for this large in pixels, typically and at the most.
    pub fn of_size(&self, picture: &Picture, radii_px: [f32; 2]) -> Result<Vec<f32>, String> {
        let (found, _) = self.kept(picture, radii_px, false)?;
        Ok(found)
    }

    /// As [`Self::on_gpu`] with the number of samples that the passes read, if they count them.
    pub fn counted(&self, picture: &Picture, counting: bool) -> Result<(Vec<f32>, Option<u64>), String> {
        self.kept(picture, [picture.most_radius_px(); 2], counting)
    }

    fn kept(
        &self,
        picture: &Picture,
        radii_px: [f32; 2],
        counting: bool,
    ) -> Result<(Vec<f32>, Option<u64>), String> {
        let recorded = self.recorded(picture, radii_px, counting);
        let (found, taps) = recorded.map_err(|e| format!("the device: {e}"))?;
        keeps_the_mask(picture, &found, "passes")?;
        Ok((found, taps))
    }

    /// The twin's result, held to the same.
    pub fn on_cpu(&self, picture: &Picture) -> Result<Vec<f32>, String> {
        let surface = HostSurface {
            distance: &picture.distance,
            radius: &picture.radius,
            spacing_per_radius: SPACING_PER_RADIUS,
        };
        let camera = CameraUniform::new(&picture.camera, picture.size);
        let found = self.filter.filter_on_cpu(&camera, &surface);
        if found.len() != picture.distance.len() {
            return Err(format!("the twin gives {} pixels of {}", found.len(), picture.distance.len()));
        }
        keeps_the_mask(picture, &found, "twin")?;
        Ok(found)
    }

    fn recorded(
        &self,
        picture: &Picture,
        [typical_radius_px, most_radius_px]: [f32; 2],
        counting: bool,
    ) -> Result<(Vec<f32>, Option<u64>), GpuError> {
        let (gpu, size) = (self.gpu, picture.size);
        let front: Vec<_> = picture.distance.iter().zip(&picture.radius).map(|(d, r)| [*d, *r]).collect();
        let front = Texture::<FrontSphere>::from_texels(gpu, size, &front)?;
        let empty = vec![NO_SURFACE; picture.distance.len()];
        let target = Texture::<EyeDistance>::from_texels(gpu, size, &empty)?;
        let covered = Covered::of(gpu, size, |pixel| is_surface(picture.distance[pixel]))?;
        // Contents do not matter, but are there: what a filter forgets to write is then seen.
        let left_over = vec![0x40a0_0000; scratch_len(size)];
        let scratch = [
            Buffer::<Scratch>::from_slice(gpu, &left_over)?,
            Buffer::<Scratch>::from_slice(gpu, &left_over)?,
        ];
        let left_over = vec![5.0; picture.distance.len()];
        let steps = [
            Texture::<FilterStep>::from_texels(gpu, size, &left_over)?,
            Texture::<FilterStep>::from_texels(gpu, size, &left_over)?,
        ];
        let mut recorder = Recorder::new(gpu, Timing::Stamps);
        recorder.set_counting(gpu, counting);
        let camera = recorder.uniform(&CameraUniform::new(&picture.camera, size));
        let images = FilterImages {
            front: &front,
            target: &target,
            covered: &covered,
            steps: [&steps[0], &steps[1]],
            scratch: [&scratch[0], &scratch[1]],
            spacing_per_radius: SPACING_PER_RADIUS,
            most_radius_px,
            typical_radius_px,
        };
        self.filter.record(&mut recorder, gpu, &camera, &images);
        let _ = recorder.submit(gpu)?;
        let found = target.read(gpu)?;
        let counted = recorder.tallies(gpu)?.into_iter().find(|(name, _)| *name == TAPS);
        Ok((found, counted.map(|(_, taps)| taps)))
    }
}

fn keeps_the_mask(picture: &Picture, found: &[f32], what: &str) -> Result<(), String> {
    for (pixel, (&found, &given)) in found.iter().zip(&picture.distance).enumerate() {
        let place = || picture.place(pixel);
        if !is_surface(given) && found.to_bits() != NO_SURFACE.to_bits() {
            return Err(format!("the {what} wrote {found} to {}, which has no surface", place()));
        }
        if is_surface(given) && !is_surface(found) {
            return Err(format!("the {what} made {found} of {given} at {}", place()));
        }
    }
    Ok(())
}
