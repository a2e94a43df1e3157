struct Frame { number: u32, born: u32, capacity: u32 }
@group(0) @binding(0) var<storage, read_write> smoke: array<Smoke>;
@group(0) @binding(1) var<storage, read_write> alive: array<u32>;
@group(0) @binding(2) var<uniform> frame: Frame;

/// A particle at one of three chimneys, in turn.
fn spawn(number: u32) -> Smoke {
    let chimney = number % 3u;
    let turn = chance(5u * number) * 6.2831853;
    let spread = 0.12 * sqrt(chance(5u * number + 1u));
    let foot = vec3(-0.55 + 0.6 * f32(chimney), 0.0, 0.35 - 0.45 * f32(chimney));
    let rise = 0.020 + 0.012 * chance(5u * number + 2u);
    let colors = array(vec3(1.0, 0.25, 0.1), vec3(0.15, 0.85, 0.3), vec3(0.15, 0.35, 1.0));
    return Smoke(
        foot + spread * vec3(cos(turn), 0.0, sin(turn)), 0.035,
        vec3(0.004 * cos(turn), rise, 0.004 * sin(turn)), 0.0,
        vec4(colors[chimney], 0.16),
    );
}

@compute @workgroup_size(64)
fn move_smoke(@builtin(global_invocation_id) id: vec3<u32>) {
    let i = id.x;
    let born = frame.number * frame.born; // before this frame
    if i == 0u { alive[0] = min(born + frame.born, frame.capacity); }
    if i >= frame.capacity { return; }
    let since = (i + frame.capacity - born % frame.capacity) % frame.capacity;
    if since < frame.born {
        smoke[i] = spawn(born + since);
        return;
    }
    var one = smoke[i];
    if one.radius == 0.0 { return; }
    one.age = min(one.age + f32(frame.born) / f32(frame.capacity), 1.0);
    let swirl = 0.0016 * vec3(sin(5.0 * one.place.y), 0.0, cos(4.0 * one.place.y));
    one.speed = one.speed * 0.99 + swirl * 0.25;
    one.place += one.speed;
    one.radius = 0.035 + 0.11 * one.age;
    one.color.a = 0.16 * (1.0 - one.age) * (1.0 - one.age) + 0.003;
    smoke[i] = one;
}
