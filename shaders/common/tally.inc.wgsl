#define_import_path meniscus::tally

// A pass counts its own work by calling `count` once per invocation with what that invocation did. Only the variant that is
// compiled with COUNT adds it up; in the other the compiler drops the sum and all that leads to it.

#ifdef COUNT
// 64 bits: low word, high word.
@group(0) @binding(15) var<storage, read_write> tally: array<atomic<u32>, 2>;
#endif

fn count(work: u32) {
#ifdef COUNT
    if work > 0u {
        let before = atomicAdd(&tally[0], work);
        // The low word ran over.
        if before + work < before {
            atomicAdd(&tally[1], 1u);
        }
    }
#endif
}
