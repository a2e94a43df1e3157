// shade, composite: translucent layers over the opaque surface, and the tone curve. One invocation per pixel
// of a band. CPU reference: crates/gobo-reference/src/shade/mod.rs. Rust:
// crates/gobo-picture/src/stage/shade.rs.

import package::bind::picture_in::{band, layers, lit, seen_pixels};
import package::bind::picture_out::{pixels, radiance};
import package::bind::uniform::views;
import package::features::{COUNT_COST, HAS_AIR, HAS_LAYERS, HAS_PANES};
import package::records::light::cluster_list;
import package::records::point::{POINT_NONE, load_point};
import package::records::record::record_texel;
import package::shade::air::air_at;
import package::shade::band::band_pixel;
import package::shade::layer::{LAYER_TEXELS, NOWHERE, pane_of};
import package::shade::tone::on_screen;
import package::traversal::lane::LANES;
import choice::ambient::{IS_LAST, keep_ambient};
import choice::records::tile_at;
import choice::refraction::{REFRACTS, keep_behind, keep_bend, keep_straight};

fn light_of(point: u32) -> vec3<f32> {
    return textureLoad(lit, record_texel(point), 0).rgb;
}

fn lights_asked(index: u32) -> u32 {
    let point = load_point(index);
    return select(cluster_list(point.cluster).count, 0u, point.kind == POINT_NONE);
}

@compute @workgroup_size(LANES)
fn shade_composite(
    @builtin(workgroup_id) workgroup: vec3<u32>,
    @builtin(num_workgroups) workgroups: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    let view = views[0];
    let at = band_pixel(workgroup, workgroups, lane, view.tiles_x);
    let size = vec2<u32>(view.size);
    if any(at.pixel >= size) {
        return;
    }
    let pixel = vec2<f32>(at.pixel) + 0.5;
    let seen = textureLoad(seen_pixels, record_texel(at.index), 0);
    let depth = bitcast<f32>(seen.x);
    var cost = vec2(seen.w, 0u);
    var light = light_of(at.index);
    // Share of the surface's light that reaches the eye.
    var passed = vec3(1.0);
    if HAS_AIR {
        let before = air_at(view, pixel, depth);
        light = light * before.left + before.light;
        passed = before.left;
    }
    if COUNT_COST {
        cost.y += lights_asked(at.index);
    }
    keep_behind(at.pixel, depth, light);
    var nearest = NOWHERE;
    var is_bent = false;
    // A tile without translucent casters has no layers.
    let tile = tile_at(at.tile);
    if HAS_LAYERS && tile.first < tile.end {
        let first = at.index * LAYER_TEXELS;
        let front = textureLoad(layers, record_texel(first), 0);
        var color = bitcast<vec3<f32>>(front.xyz);
        cost.x += front.w;
        for (var i = 0u; HAS_PANES && i < 2u; i += 1u) {
            let pane = pane_of(textureLoad(layers, record_texel(first + 2u + i), 0));
            if pane.depth < NOWHERE {
                nearest = min(nearest, pane.depth);
                let point = (1u + i) * band.pixel_count + at.index;
                var shown = pane.passed * light_of(point);
                if HAS_AIR {
                    shown *= air_at(view, pixel, pane.depth).left;
                }
                color += shown;
                if COUNT_COST {
                    cost.y += lights_asked(point);
                }
            }
        }
        var through = bitcast<vec3<f32>>(textureLoad(layers, record_texel(first + 1u), 0).xyz);
        if REFRACTS && HAS_PANES {
            is_bent = keep_bend(at.pixel, first, nearest, through);
        }
        // Light that is seen displaced is added by `refraction`.
        through = select(through, vec3(0.0), is_bent);
        light = color + through * light;
        passed *= through;
    } else if REFRACTS {
        keep_straight(at.pixel);
    }
    keep_ambient(at.pixel, at.index, depth, passed);
    textureStore(radiance, at.pixel, vec4(light, depth));
    if IS_LAST && !REFRACTS {
        var shown = on_screen(light);
        if COUNT_COST {
            cost = min(cost, vec2(0xffffu));
            shown = cost.x | (cost.y << 16u);
        }
        pixels[at.pixel.y * size.x + at.pixel.x] = shown;
    }
}
