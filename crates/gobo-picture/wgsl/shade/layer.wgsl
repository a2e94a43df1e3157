// Layers of a pixel, as records of `layers`: colour and pairs, transmittance, two panes, and the place where
// the scene behind is seen. CPU reference: crates/gobo-reference/src/shade/mod.rs. Rust:
// crates/gobo-picture/src/stage/shade.rs.

import package::bind::picture_in::band;
import package::bind::picture_out::layered_tiles;
import package::bind::uniform::views;
import package::features::HAS_FRESNEL;
import package::hit::hit::{Hit, passed_share};
import package::records::material::{
    GpuMaterial, MAX_GAIN, TRANSFER_GAIN, TRANSFER_OVER, TRANSFER_SMOKE, shows_color,
};
import package::shade::band::{PIXELS_OF_TILE, indexed_pixel};
import package::shade::shading::{Gloss, mirrored_sky};
import choice::records::tile_at;

const LAYER_TEXELS: u32 = 5u;

const NOWHERE: f32 = 4.0; // depth of an empty slot

// A pane whose scattered and mirrored light is evaluated.
struct Pane {
    depth: f32,        // NOWHERE for none
    setup: u32,
    passed: vec3<f32>, // transmittance in front of it
}

const NO_PANE: Pane = Pane(NOWHERE, 0u, vec3(0.0));

fn packed_pane(pane: Pane) -> vec4<u32> {
    let red_green = pack2x16float(pane.passed.rg);
    return vec4(bitcast<u32>(pane.depth), pane.setup, red_green, pack2x16float(vec2(pane.passed.b, 0.0)));
}

fn pane_of(bits: vec4<u32>) -> Pane {
    let passed = vec3(unpack2x16float(bits.z), unpack2x16float(bits.w).x);
    return Pane(bitcast<f32>(bits.x), bits.y, passed);
}

// Tiles of a band that have translucent casters. `layered_tiles` holds the workgroups of a dispatch over them
// in x, y and z, and then their indices in the band.

const LAYERED_HEAD: u32 = 3u; // words

// Panes: thin surfaces that filter the light behind them, scatter some light and mirror some.

// Gloss of a pane, premultiplied: glass keeps its highlights where it is clear.
fn pane_gloss(hit: Hit, material: GpuMaterial) -> Gloss {
    let shines = select(1.0, 0.0, shows_color(material));
    return Gloss(material.reflectivity * shines, max(hit.opacity, material.transmission) * shines);
}

// Share of light that a pane scatters: all that it covers if its transfer attenuates the light behind by as
// much; else half of that, less the transmission, since it filters the rest. `of_emission`: the share that it
// sends; else the share that it takes from the light behind, beyond its transfer.
fn scattered_share(hit: Hit, material: GpuMaterial, of_emission: bool) -> f32 {
    let covers = material.transfer == TRANSFER_OVER || material.transfer == TRANSFER_SMOKE;
    let share = select(0.5 * (1.0 - material.transmission), select(0.0, 1.0, of_emission), covers);
    return hit.opacity * share * select(1.0, 0.0, shows_color(material));
}

// Mirrored share of the sky; `normal` is on the eye's side.
fn mirrored_share(hit: Hit, material: GpuMaterial, normal: vec3<f32>, to_eye: vec3<f32>) -> f32 {
    let gloss = pane_gloss(hit, material);
    let cosine = dot(normal, to_eye);
    if HAS_FRESNEL && material.fresnel != 0.0 {
        let share = 1.0 - passed_share(material.fresnel, cosine);
        return gloss.reflectivity + (1.0 - gloss.reflectivity) * gloss.polish * share;
    }
    return mirrored_sky(gloss, cosine, material.roughness);
}

// Albedo of a pane; `gain` scatters everything.
fn seen_color(hit: Hit, transfer: u32) -> vec3<f32> {
    return select(hit.color, min(hit.color * MAX_GAIN, vec3(1.0)), transfer == TRANSFER_GAIN);
}

override WORKGROUP_SIZE: u32;

// shade, layered: lists the tiles of a band that have translucent casters. One invocation per tile.
@compute @workgroup_size(WORKGROUP_SIZE)
fn shade_layered(@builtin(global_invocation_id) id: vec3<u32>) {
    let number = id.x;
    if number >= band.size.x * band.size.y {
        return;
    }
    let at = indexed_pixel(number * PIXELS_OF_TILE, views[0].tiles_x);
    let tile = tile_at(at.tile);
    if tile.first < tile.end {
        let slot = atomicAdd(&layered_tiles[0], 1u);
        atomicStore(&layered_tiles[LAYERED_HEAD + slot], number);
    }
}
