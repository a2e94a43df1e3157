//! Scene files, particle files, models, and what is made from them.
mod defaults;
mod displace;
mod document;
mod gltf;
mod hostile;
mod noise;
mod particles;
