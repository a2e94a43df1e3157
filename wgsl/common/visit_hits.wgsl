// A caster of any kind meets the four texels; every hit goes into its curve at once.
// Needs common/gather_curve.wgsl, crossing.wgsl and what they need.
fn ordered() -> bool {
    return false;
}

fn blocked() -> bool {
    return true;
}

fn slabbed() -> bool {
    return false;
}

fn hit_texel(view: GpuView, place: vec4<u32>, look: vec4<u32>, i: u32) -> Hit {
    let hit = caster_hit(view, place, look, corner + vec2(0.5, f32(i) + 0.5), opaque_depth[i]);
    if !(hit.depth >= 0.0 && hit.depth < opaque_depth[i]) {
        return MISS;
    }
    return hit;
}

fn added4(a: Hit, b: Hit, c: Hit, d: Hit) -> Light4 {
    return light4(added_light(a), added_light(b), added_light(c), added_light(d));
}

fn face_texel(view: GpuView, look: vec4<u32>, i: u32) -> Face {
    let face = volume_face(view, look, corner + vec2(0.5, f32(i) + 0.5), opaque_depth[i]);
    crossed[i] += face_crossing(face);
    return face;
}

fn density_change(face: Face) -> vec3<f32> {
    return face.metres * face.absorption * f32(-face.leaves);
}

fn cross_faces(view: GpuView, look: vec4<u32>) -> vec4<bool> {
    let a = face_texel(view, look, 0u);
    let b = face_texel(view, look, 1u);
    let c = face_texel(view, look, 2u);
    let d = face_texel(view, look, 3u);
    let meets = vec4(a.leaves, b.leaves, c.leaves, d.leaves) != vec4(0);
    // Nothing changes at the last face.
    let depth = select(last_face, vec4(a.depth, b.depth, c.depth, d.depth), meets);
    let change = light4(density_change(a), density_change(b), density_change(c), density_change(d));
    return join_ramp(change_density(depth, selected(black4(), change, meets)));
}

// True where the hits cannot wait.
fn visit(view: GpuView, place: vec4<u32>, look: vec4<u32>) -> bool {
    var ramps = vec4(false);
    if HAS_VOLUMES {
        ramps = cross_faces(view, look);
    }
    let a = hit_texel(view, place, look, 0u);
    let b = hit_texel(view, place, look, 1u);
    let c = hit_texel(view, place, look, 2u);
    let d = hit_texel(view, place, look, 3u);
    let light = light4(a.light, b.light, c.light, d.light);
    let opacity = vec4(a.opacity, b.opacity, c.opacity, d.opacity);
    let placed = meet(light, vec4(a.depth, b.depth, c.depth, d.depth), opacity);
    if HAS_PUFFS {
        open_end = select(open_end, max(open_end, vec4(a.end, b.end, c.end, d.end)), placed);
    }
    if HAS_OVER || HAS_VOLUMES {
        scale = scaled(scale, light);
        surfaces = scaled(surfaces, light);
        surface_scale = scaled(surface_scale, light);
    }
    if HAS_OVER {
        let added = added4(a, b, c, d);
        open_added = plus(scaled(open_added, light), added);
        surfaces = plus(surfaces, added);
    }
    return must_flush(ramps | placed);
}
