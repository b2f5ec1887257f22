//! Command line of meniscus.
