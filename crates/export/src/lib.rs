//! Images and image sequences on disk.
