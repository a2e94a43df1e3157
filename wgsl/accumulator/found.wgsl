// Light and nearest depth that a walk has found at a texel.

struct Found {
    light: vec3<f32>, // transmittance of all hits in front of the opaque surface
    nearest: f32,     // light depth of the nearest visible hit
    owner: u32,       // its owner tag
}
