//! Scene files, particle files, models, and generated contents.
mod alone;
mod animate;
mod defaults;
mod displace;
mod document;
mod emitters;
mod far;
mod gltf;
mod gltf_files;
mod hostile;
mod issues;
mod limits;
mod messages;
mod noise;
mod particles;
mod ply;
mod sources;
