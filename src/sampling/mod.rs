//! Floor 1: random numbers with names, and the warps that turn them into points and directions.

pub mod warp;
