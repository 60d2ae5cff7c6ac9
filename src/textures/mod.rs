//! textures
