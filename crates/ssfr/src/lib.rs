//! Screen-space surface: splats, filters, normals.
