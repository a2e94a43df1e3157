// Masks of a pixel that one invocation looks up or filters together: surfaces' weights are computed once for
// all of them.

import package::bind::sampled::light_masks;
import package::bind::stored::new_masks;
import package::bind::uniform::mask_params;

override MASKS: u32 = 1u; // per invocation: 1, 2 or 4

struct MaskGroup {
    first: vec4<f32>,
    second: vec4<f32>,
    third: vec4<f32>,
    fourth: vec4<f32>,
}

fn even_group(value: f32) -> MaskGroup {
    return MaskGroup(vec4(value), vec4(value), vec4(value), vec4(value));
}

// Past the last mask, the last one is loaded.
fn load_mask(texel: vec2<u32>, mask: u32) -> vec4<f32> {
    return textureLoad(light_masks, texel, min(mask, mask_params.mask_count - 1u), 0);
}

// `group`: index of the group.
fn load_group(texel: vec2<u32>, group: u32) -> MaskGroup {
    let mask = group * MASKS;
    var masks = even_group(0.0);
    masks.first = load_mask(texel, mask);
    if MASKS > 1u {
        masks.second = load_mask(texel, mask + 1u);
    }
    if MASKS > 2u {
        masks.third = load_mask(texel, mask + 2u);
        masks.fourth = load_mask(texel, mask + 3u);
    }
    return masks;
}

fn weighted(sum: MaskGroup, other: MaskGroup, weight: f32) -> MaskGroup {
    return MaskGroup(
        sum.first + other.first * weight,
        sum.second + other.second * weight,
        sum.third + other.third * weight,
        sum.fourth + other.fourth * weight,
    );
}

fn divided(sum: MaskGroup, by: f32) -> MaskGroup {
    return MaskGroup(sum.first / by, sum.second / by, sum.third / by, sum.fourth / by);
}

fn either_group(no: MaskGroup, yes: MaskGroup, which: bool) -> MaskGroup {
    return MaskGroup(
        select(no.first, yes.first, which),
        select(no.second, yes.second, which),
        select(no.third, yes.third, which),
        select(no.fourth, yes.fourth, which),
    );
}

fn store_group(texel: vec2<u32>, group: u32, masks: MaskGroup) {
    let mask = group * MASKS;
    let count = mask_params.mask_count;
    textureStore(new_masks, texel, mask, masks.first);
    if MASKS > 1u && mask + 1u < count {
        textureStore(new_masks, texel, mask + 1u, masks.second);
    }
    if MASKS > 2u && mask + 2u < count {
        textureStore(new_masks, texel, mask + 2u, masks.third);
    }
    if MASKS > 3u && mask + 3u < count {
        textureStore(new_masks, texel, mask + 3u, masks.fourth);
    }
}
