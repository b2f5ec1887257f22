use meniscus_compositor::Meter;
use meniscus_core::{Camera, Choice, Flaw};

use crate::{PipelineError, PreparedFrame, Renderer, World};

/// Width or height, whichever is more, of the pictures that exposure is metered on: it is a mean over them, and they are to cost little.
const METERED_PX: u32 = 192;

impl Renderer {
    /// Adds the light of `frame` to `meter`, drawn small for pictures of `size` pixels.
    ///
    /// # Errors
    /// As [`Self::render`].
    pub fn meter(
        &mut self,
        meter: &mut Meter,
        frame: &PreparedFrame,
        world: &World,
        camera: &Camera,
        size: [u32; 2],
    ) -> Result<(), PipelineError> {
        self.draw_and_wait(frame, world, camera, reduced(size))?;
        meter.add(&self.settings().post, &self.images().radiance.read_floats(self.gpu())?);
        // What metering costs is a part of no frame.
        let _ = self.take_costs();
        let _ = self.take_spans();
        Ok(())
    }

    /// Exposes the following pictures as `meter` says, all alike; says how, and where there was nothing to meter.
    pub fn expose_by(&mut self, meter: &Meter) -> Result<Choice, Flaw> {
        let stops = meter.exposure();
        self.set_exposure(stops.unwrap_or(0.0));
        let stops = stops.ok_or(Flaw::NothingToMeter)?;
        Ok(Choice {
            what: "exposure".into(),
            value: format!("{stops} stops"),
            reason: "metered once for all pictures".into(),
            flag: "--exposure EV".into(),
        })
    }
}

/// The size of a small picture of the same shape.
fn reduced(size: [u32; 2]) -> [u32; 2] {
    let longer = size[0].max(size[1]).max(METERED_PX);
    size.map(|side| (u64::from(side) * u64::from(METERED_PX) / u64::from(longer)).max(1) as u32)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn small_pictures_have_the_shape_of_large_ones() {
        assert_eq!(reduced([1920, 1080]), [192, 108]);
        assert_eq!(reduced([1000, 2000]), [96, 192]);
        assert_eq!(reduced([64, 36]), [64, 36]);
        assert_eq!(reduced([16384, 1]), [192, 1]);
    }
}
