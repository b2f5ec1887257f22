//! Readers for VTK particle files and their series.
