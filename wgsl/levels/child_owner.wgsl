// Source of a child of a block: beyond the edge of a cube's face, a child of the neighbouring face; else the
// nearest child.

import package::curve::mean::Ramp;
import package::curve::node::DEPTHS;
import package::features::HAS_FACES;
import package::records::area::leveled_view;
import package::records::light::shadow_view;
import package::records::view::{GpuView, ROLE_FACE};
import package::shade::incoming::cube_face;

// `shift` turns its depths into this face's: times x, plus y, in fixed point.
struct ChildOwner {
    view: GpuView,
    leveled: u32,
    at: vec2<i32>,
    shift: vec2<f32>,
}

// `size`: number of children of the face [children], `edge`: edge of a child [texels].
fn child_owner(
    view: GpuView,
    leveled: u32,
    first_face: u32,
    size: vec2<i32>,
    edge: f32,
    at: vec2<i32>,
) -> ChildOwner {
    let nearest = clamp(at, vec2(0), size - 1);
    var owner = ChildOwner(view, leveled, nearest, vec2(1.0, 0.0));
    if HAS_FACES && any(nearest != at) && view.role == ROLE_FACE {
        let slope = ((vec2<f32>(at) + 0.5) * edge - view.size * 0.5) / view.scale;
        let away = (vec4(slope.x, -slope.y, -1.0, 0.0) * view.view_from_world).xyz;
        owner.leveled = first_face + cube_face(away);
        owner.view = shadow_view(leveled_view(owner.leveled).x);
        let p = (owner.view.view_from_world * vec4(away, 0.0)).xyz;
        // Depth along the neighbour's axis per unit of depth along this face's.
        let along = max(-p.z, 1e-6);
        let position = vec2(p.x, -p.y) * (owner.view.scale / along) + owner.view.size * 0.5;
        let range = view.far - view.near;
        let offset = (owner.view.near / along - view.near) / range * DEPTHS;
        owner.shift = vec2((owner.view.far - owner.view.near) / (along * range), offset);
        let last = ceil(owner.view.size / edge) - 1.0;
        owner.at = vec2<i32>(clamp(floor(position / edge), vec2(0.0), last));
    }
    return owner;
}

// The ramp of a child, with its depths turned into this face's.
fn shifted(ramp: Ramp, shift: vec2<f32>) -> Ramp {
    if HAS_FACES {
        let start = clamp(round(ramp.start * shift.x + shift.y), 1.0, DEPTHS);
        return Ramp(select(0.0, start, ramp.start > 0.0), ramp.length * shift.x, ramp.drop);
    }
    return ramp;
}
