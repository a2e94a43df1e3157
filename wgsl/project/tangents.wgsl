// Slopes of a sphere. CPU reference: crates/gobo-reference/src/project.rs.

// Slopes between which a sphere of radius `sphere` at `(x, distance)` is seen; unbounded if the eye is
// inside.
fn tangents(x: f32, distance: f32, sphere: f32) -> vec2<f32> {
    const ENDLESS: f32 = 1e6;
    let t2 = x * x + distance * distance - sphere * sphere;
    if t2 <= 0.0 {
        return vec2(-ENDLESS, ENDLESS);
    }
    let t = sqrt(t2);
    let low = vec2(x * t - distance * sphere, distance * t + x * sphere);
    let high = vec2(x * t + distance * sphere, distance * t - x * sphere);
    return vec2(
        select(-ENDLESS, low.x / low.y, low.y > 0.0),
        select(ENDLESS, high.x / high.y, high.y > 0.0),
    );
}
