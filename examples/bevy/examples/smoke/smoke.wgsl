struct Smoke {
    place: vec3<f32>, // world space [m]
    radius: f32,      // [m]; 0 where there is none
    speed: vec3<f32>, // [m] in a frame
    age: f32,         // of its life, 0..=1
    color: vec4<f32>,
}
