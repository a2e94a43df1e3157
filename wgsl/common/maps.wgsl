// Where a tile is written that is finished.
@group(0) @binding(9) var filters: texture_storage_2d_array<rgba16float, write>;
@group(0) @binding(10) var nearests: texture_storage_2d_array<r32float, write>;

// Of texels that belong to nobody.
fn plain_alpha(texel: vec2<u32>, layer: u32) -> f32 {
    return 1.0;
}
