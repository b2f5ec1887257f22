//! Physics through the whole chain, with the pipeline as a library: what the pictures rest on but do not show.

mod between_frames;
mod colored_sets;
mod colors;
mod coordinates;
mod detail;
mod foam;
mod mirrored_sets;
mod playback;
mod sizes;
mod thickness;
