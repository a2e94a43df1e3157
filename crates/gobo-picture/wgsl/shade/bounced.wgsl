// Light that lit surfaces send to the points of a picture. CPU reference:
// crates/gobo-reference/src/bounce.rs.

import package::bind::uniform::bounces;
import package::records::bounce::BOUNCE_VECTORS;
import package::records::point::{POINT_NONE, Point};
import package::shade::scattered::scattered;

// Light that a point scatters to the eye, per albedo, with light that lit surfaces send it: the light of a
// disc at the distance of its middle.
fn with_bounced(point: Point, light: vec3<f32>) -> vec3<f32> {
    let count = select(bitcast<u32>(bounces[0].x), 0u, point.kind == POINT_NONE);
    var sum = light;
    for (var i = 0u; i < count; i += 1u) {
        let disc = bounces[BOUNCE_VECTORS * i + 1u];
        let facing = bounces[BOUNCE_VECTORS * i + 2u].xyz;
        let away = disc.xyz - point.position;
        let square = dot(away, away);
        let toward = away * inverseSqrt(max(square, 1e-12));
        let passed = max(-dot(facing, toward), 0.0) / (square + disc.w);
        let sent = bounces[BOUNCE_VECTORS * i + 3u].xyz;
        sum += sent * (passed * scattered(point, dot(point.normal, toward)));
    }
    return sum;
}
