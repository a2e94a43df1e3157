// Light of four texels in a column, by channel.
struct Light4 {
    red: vec4<f32>,
    green: vec4<f32>,
    blue: vec4<f32>,
}

fn white4() -> Light4 {
    return Light4(vec4(1.0), vec4(1.0), vec4(1.0));
}

fn black4() -> Light4 {
    return Light4(vec4(0.0), vec4(0.0), vec4(0.0));
}

fn light4(a: vec3<f32>, b: vec3<f32>, c: vec3<f32>, d: vec3<f32>) -> Light4 {
    return Light4(vec4(a.r, b.r, c.r, d.r), vec4(a.g, b.g, c.g, d.g), vec4(a.b, b.b, c.b, d.b));
}

fn plus(a: Light4, b: Light4) -> Light4 {
    return Light4(a.red + b.red, a.green + b.green, a.blue + b.blue);
}

fn scaled(a: Light4, b: Light4) -> Light4 {
    return Light4(a.red * b.red, a.green * b.green, a.blue * b.blue);
}

fn selected(a: Light4, b: Light4, is: vec4<bool>) -> Light4 {
    return Light4(select(a.red, b.red, is), select(a.green, b.green, is), select(a.blue, b.blue, is));
}
