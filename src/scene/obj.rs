//! OBJ meshes with MTL materials.
