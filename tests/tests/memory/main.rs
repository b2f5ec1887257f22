//! How much memory the program holds, by the kernel's high-water mark of the process. Software drivers keep "GPU memory" in
//! the process as well, so that its buffers count.

use meniscus_tests::Program;

/// The most memory held while a made dam break was drawn, bytes.
fn peak(particles: u32, frames: u32, flags: &str) -> u64 {
    let program = Program::new(env!("CARGO_BIN_EXE_meniscus-under-test"));
    program.run(&format!("make dam-break -o dam --particles {particles} --frames {frames} -q")).ok();
    // Read, not mapped: pages of a mapped file count as the process's as long as nobody else needs the memory.
    let bytes = program.run(&format!("render dam -o o_%d.png -q --io read {flags}")).ok().peak_bytes;
    // Less than the program's own text has means that nobody looked in time.
    assert!(bytes > 20_000_000, "{bytes} bytes");
    bytes
}

/// What a particle of a frame may take at once: as decoded, position 3 x 4 and id 8; sort key and index 4 + 4; packed (16), and
/// its share of the stand-ins (3), in the chunks, in the upload and on the GPU; and 16 for what lives for a moment. Measured
/// are 90 to 93. A copy of the decoded frame is 20 more.
const BYTES_PER_PARTICLE: u64 = 20 + 8 + 3 * (16 + 3) + 16;

#[test]
#[expect(clippy::print_stderr, reason = "a skipped test must not look like a passed one")]
fn memory_for_a_frame_is_what_its_particles_take() {
    let program = Program::new(env!("CARGO_BIN_EXE_meniscus-under-test"));
    let adapters = program.run("--list-adapters").ok().stdout;
    let drawing = adapters.lines().next().unwrap_or_default();
    if !drawing.contains("(Cpu,") {
        eprintln!("SKIPPED: {drawing} has memory of its own, and its driver needs more than a frame");
        return;
    }
    // Spheres both, as so many are: few would be ellipsoids, whose passes take tens of megabytes to compile.
    let flags = "--frame 0 --size 160x90 --param anisotropy.form=none";
    let [few, many] = [1000, 1_000_000].map(|particles| peak(particles, 1, flags));
    let per_particle = (many - few) / 999_000;
    assert!(per_particle <= BYTES_PER_PARTICLE, "{per_particle} bytes per particle");
    // Less than what certainly lies there, decoded and on the GPU, would mean that nothing was measured.
    assert!(per_particle >= 20 + 16, "{per_particle} bytes per particle");
}

/// Lavapipe of Mesa 22.3.6 loses 23 to 26 kB per submission itself, whatever is drawn at whatever size; with SwiftShader 240
/// frames end with the peak of 12.
const DRIVER_BYTES_PER_SUBMISSION: u64 = 27_000;
/// Where passes are timed one by one, those of what the sun sees included; 26 without shadows, which lose as much each.
const SUBMISSIONS_PER_FRAME: u64 = 46;

/// A quarter of what one 32-bit image that is kept per frame would take.
#[test]
fn sixty_frames_take_no_more_than_twelve() {
    let [short, long] = [12, 60].map(|frames| peak(300, frames, "--size 480x270"));
    let image = 480 * 270 * 4;
    let bound = 48 * (SUBMISSIONS_PER_FRAME * DRIVER_BYTES_PER_SUBMISSION + image / 4);
    assert!(long <= short + bound, "{short} bytes for 12 frames, {long} for 60");
}
