//! Merge, tone mapping, display transform.
