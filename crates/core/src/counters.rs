//! How much work a frame was, as exact numbers: unlike times they are the same on every run, so that tests can bound them.

use serde::ser::SerializeMap;
use serde::{Serialize, Serializer};

/// What reading a frame took.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct FrameRead {
    /// Bytes of the file that hold the arrays which were decoded, as stored (compressed, base64, text).
    pub bytes: u64,
    /// Particles in the files, before any selection.
    pub particles: u64,
}

macro_rules! work_counters {
    ($($(#[doc = $doc:literal])+ $name:ident: $unit:literal,)+) => {
        /// How much work a frame was. A counter that was not measured is `None` and absent from JSON, never zero.
        #[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
        pub struct WorkCounters {
            $($(#[doc = $doc])+ pub $name: Option<u64>,)+
        }

        impl WorkCounters {
            /// Every counter as name, unit and value, in the order of the frame's stages.
            pub fn iter(&self) -> impl Iterator<Item = (&'static str, &'static str, Option<u64>)> {
                [$((stringify!($name), $unit, self.$name)),+].into_iter()
            }

            /// The work of two frames together; of memory in use, the most.
            #[must_use]
            pub fn plus(&self, other: &Self) -> Self {
                let sum = |a: Option<u64>, b: Option<u64>| a.zip(b).map(|(a, b)| a.saturating_add(b));
                let gpu_bytes_live = self.gpu_bytes_live.max(other.gpu_bytes_live);
                Self { gpu_bytes_live, ..Self { $($name: sum(self.$name, other.$name)),+ } }
            }

            /// Sets the counter `name`; `false` where there is none of that name.
            pub fn set(&mut self, name: &str, value: u64) -> bool {
                match name {
                    $(stringify!($name) => self.$name = Some(value),)+
                    _ => return false,
                }
                true
            }
        }
    };
}

work_counters! {
    /// Bytes of the file that hold the arrays which were decoded, as stored.
    file_bytes_read: "bytes",
    /// Particles in the files, before any selection.
    particles_read: "particles",
    /// Particles of the sets that are drawn.
    particles: "particles",
    /// Particles left after culling and thinning, once per frame.
    particles_kept: "particles",
    /// Of the kept, those that the surface is drawn from only where nothing hides them.
    particles_tested: "particles",
    /// Of the tested, those that were hidden.
    particles_hidden: "particles",
    /// Spheres that count in the thickness for groups of particles.
    stand_ins: "spheres",
    /// Chunks of neighbouring particles that were looked at.
    chunks: "chunks",
    /// Chunks outside of the view.
    chunks_culled: "chunks",
    /// Particle data copied to the GPU.
    particle_bytes_uploaded: "bytes",
    /// Values that colour the water copied to the GPU.
    attribute_bytes_uploaded: "bytes",
    /// Stand-ins for groups of particles copied to the GPU.
    stand_in_bytes_uploaded: "bytes",
    /// Lists of what is kept copied to the GPU.
    range_bytes_uploaded: "bytes",
    /// Parameters of passes copied to the GPU.
    uniform_bytes_uploaded: "bytes",
    /// Everything else copied to the GPU: the objects of the scene.
    other_bytes_uploaded: "bytes",
    /// Buffers and textures made, also those that read results back.
    gpu_allocations: "resources",
    /// Their size.
    gpu_bytes_allocated: "bytes",
    /// Memory of all live buffers and textures after the frame.
    gpu_bytes_live: "bytes",
    /// Compute passes, one dispatch each.
    compute_passes: "passes",
    /// Workgroups of all dispatches.
    workgroups: "workgroups",
    /// Raster passes.
    raster_passes: "passes",
    /// Command buffers handed to the GPU; with isolated timing one per pass.
    submissions: "submissions",
    /// Pixels in the bounding rectangles of the splats that the depth pass walked through.
    splat_pixels_depth: "pixels",
    /// The same of the thickness pass, in pixels of the reduced image.
    splat_pixels_thickness: "pixels",
    /// Pixels of the picture that show water.
    covered_pixels: "pixels",
    /// Samples that the surface filter read besides the pixel's own, all its passes together.
    filter_taps: "samples",
}

impl Serialize for WorkCounters {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let measured = || self.iter().filter_map(|(name, _, value)| Some((name, value?)));
        let mut map = serializer.serialize_map(Some(measured().count()))?;
        for (name, value) in measured() {
            map.serialize_entry(name, &value)?;
        }
        map.end()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_was_not_measured_is_absent() {
        let mut counters = WorkCounters { chunks: Some(0), ..Default::default() };
        assert!(counters.set("filter_taps", 7));
        assert!(!counters.set("filter_tap", 7));
        let measured: Vec<_> = counters.iter().filter_map(|(name, _, value)| Some((name, value?))).collect();
        assert_eq!(measured, [("chunks", 0), ("filter_taps", 7)]);
    }

    #[test]
    fn work_adds_up_and_memory_does_not() {
        let one = WorkCounters { chunks: Some(2), gpu_bytes_live: Some(5), ..Default::default() };
        let other = WorkCounters { chunks: Some(3), gpu_bytes_live: Some(4), stand_ins: Some(1), ..one };
        let both = one.plus(&other);
        assert_eq!((both.chunks, both.gpu_bytes_live, both.stand_ins), (Some(5), Some(5), None));
    }
}
