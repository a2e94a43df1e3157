// Scattering of a point. CPU reference: crates/gobo-reference/src/shading/reflectance.rs.

import package::records::point::{POINT_COVER, POINT_LEAF, POINT_PANE, POINT_SOLID, Point};
import package::shade::shading::{HEAD_ON, PER_FOUR_PI, PER_PI};

// Share of the light from `toward` that a point of albedo 1 scatters to the eye, without mirrored light.
fn scattered(point: Point, cosine: f32) -> f32 {
    switch point.kind {
        // A highlight never sends more than its head-on share.
        case POINT_SOLID, POINT_LEAF: { return max(cosine, 0.0) * PER_PI * (1.0 - HEAD_ON * point.polish); }
        case POINT_COVER: { return max(cosine, 0.0) * PER_PI; }
        case POINT_PANE: { return abs(cosine) * PER_PI; }
        // Evenly to all sides.
        default: { return PER_FOUR_PI; }
    }
}
