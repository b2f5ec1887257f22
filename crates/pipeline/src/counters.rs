use meniscus_core::WorkCounters;
use meniscus_gpu::role::{AttributeValues, KeptRanges, Occludees, Particles, Role, StandIns};
use meniscus_gpu::{GpuMemory, GpuWork};
use meniscus_lod::ParticleCounts;

use crate::PreparedFrame;

/// What is known without asking the GPU.
pub(crate) fn of_host(
    frame: &PreparedFrame,
    counts: ParticleCounts,
    work: &GpuWork,
    memory: &GpuMemory,
) -> WorkCounters {
    let uploaded = |name: &str| work.uploaded.get(name).copied().unwrap_or(0);
    let known = [
        Particles::NAME,
        AttributeValues::NAME,
        KeptRanges::NAME,
        Occludees::NAME,
        StandIns::NAME,
        GpuWork::UNIFORMS,
    ];
    let other = work.uploaded.iter().filter(|(name, _)| !known.contains(name)).map(|(_, bytes)| bytes).sum();
    WorkCounters {
        file_bytes_read: frame.read.map(|read| read.bytes),
        particles_read: frame.read.map(|read| read.particles),
        particles: Some(counts.input),
        particles_kept: Some(counts.kept),
        particles_tested: Some(counts.tested),
        stand_ins: Some(counts.stand_ins),
        chunks: Some(counts.chunks),
        chunks_culled: Some(counts.chunks_culled),
        particle_bytes_uploaded: Some(uploaded(Particles::NAME)),
        attribute_bytes_uploaded: Some(uploaded(AttributeValues::NAME)),
        stand_in_bytes_uploaded: Some(uploaded(StandIns::NAME)),
        range_bytes_uploaded: Some(uploaded(KeptRanges::NAME) + uploaded(Occludees::NAME)),
        uniform_bytes_uploaded: Some(uploaded(GpuWork::UNIFORMS)),
        other_bytes_uploaded: Some(other),
        gpu_allocations: Some(work.allocations),
        gpu_bytes_allocated: Some(work.bytes_allocated),
        gpu_bytes_live: Some(memory.current()),
        compute_passes: Some(work.compute_passes),
        workgroups: Some(work.workgroups),
        raster_passes: Some(work.raster_passes),
        submissions: Some(work.submissions),
        ..Default::default()
    }
}
