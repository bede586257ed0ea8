//! PLY meshes: ascii and binary of both endians.
