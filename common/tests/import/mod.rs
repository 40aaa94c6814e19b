//! Import of OBJ, MTL, glTF and GLB: features and messages for faults.

mod damage;
mod data;
pub mod files;
mod gltf;
mod gltf_extensions;
mod gltf_faults;
mod obj;
mod obj_faults;
mod paint;
mod textures;
