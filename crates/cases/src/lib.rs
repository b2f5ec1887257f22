//! Generated particle cases for tests, benches and meniscus make.
