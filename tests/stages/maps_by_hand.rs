//! Maps of two views in a poisoned atlas, whose sizes are no multiples of tiles or workgroups.
use super::by_hand::{ATLAS, POISON, TILE, upload_views, views};
use crate::common::scenes::{Chance, flat_view};
use gobo::{
    glam::{UVec2, Vec3},
    gpu::Gpu,
    model::View,
    records::{CurveMap, GpuView, ViewMaps},
    wgpu::{self, TextureFormat as Format},
};
use gobo_reference::curve::Streaming;
use half::f16;

/// Sizes of the views [texels].
const SIZES: [UVec2; 2] = [UVec2::new(45, 27), UVec2::new(30, 13)];
/// Nodes of a curve (K).
pub(super) const NODES: usize = 4;
/// Workgroups of 8 x 8 texels that cover both views, with one more on each side.
pub(super) const GROUPS: [u32; 3] = [7, 5, 2];
/// Rounding of a half float below 1, and of a sum of some of them.
pub(super) const HALF: f32 = 1e-3;

pub(super) fn odd_views() -> [GpuView; 2] {
    let [first, second] = views();
    [GpuView { size: SIZES[0].as_vec2(), ..first }, GpuView { size: SIZES[1].as_vec2(), ..second }]
}

pub(super) fn odd_view_buffer(gpu: &Gpu) -> wgpu::Buffer {
    upload_views(gpu, odd_views())
}

/// Random maps of both views. A third of the opaque depths are dithered, and a third are empty.
pub(super) fn random_maps(seed: u64) -> [ViewMaps; 2] {
    let mut chance = Chance::new(seed);
    SIZES.map(|size| {
        let mut maps = ViewMaps {
            view: View { size, ..flat_view(64, 1.0) },
            filter: Vec::new(),
            nearest: Vec::new(),
            opaque: Vec::new(),
            colored: Vec::new(),
            curve: None,
            caustics: Vec::new(),
            sums: Vec::new(),
            owner: Vec::new(),
        };
        let mut packed = Vec::new();
        for _ in 0..size.element_product() {
            let half = |v: f32| f16::from_f32(v).to_f32();
            maps.filter.push(chance.vec3(0.0, 1.0).to_array().map(half));
            maps.nearest.push(if chance.below(4) == 0 { 1.0 } else { chance.within(0.1, 0.9) });
            let depth = chance.within(0.3, 0.9).to_bits() & !1;
            let depth = [1.0_f32.to_bits(), depth, depth | 1][chance.below(3)];
            maps.opaque.push(f32::from_bits(depth));
            let mut curve = Streaming::new(NODES as u32, false);
            for _ in 0..chance.below(NODES + 1) {
                let start = chance.within(0.05, 0.8);
                curve.insert(start, start + chance.within(0.0, 0.1), chance.vec3(0.3, 1.0));
            }
            packed.extend(curve.pack());
        }
        maps.curve = Some(CurveMap { nodes: NODES, gain: false, packed });
        maps
    })
}

/// Index of texel `i` of a view in `layer` of an atlas with `layers` layers per layer of the maps.
pub(super) fn place(view: usize, i: usize, layers: u32, layer: u32) -> usize {
    let (size, GpuView { origin, layer: own, .. }) = (SIZES[view], odd_views()[view]);
    let at = origin + UVec2::new(i as u32 % size.x, i as u32 / size.x);
    (((own * layers + layer) * ATLAS[1] + at.y) * ATLAS[0] + at.x) as usize
}

fn atlas(gpu: &Gpu, name: &str, format: Format, layers: u32) -> wgpu::Texture {
    gpu.texture_array(name, [ATLAS[0], ATLAS[1], ATLAS[2] * layers], format)
}

/// An atlas full of poison, except for `texels`: index and words.
pub(super) fn filled<const N: usize>(
    gpu: &Gpu,
    name: &str,
    format: Format,
    layers: u32,
    texels: impl Iterator<Item = (usize, [u32; N])>,
) -> wgpu::Texture {
    let texture = atlas(gpu, name, format, layers);
    let count = ATLAS.iter().product::<u32>() * layers;
    let mut all = vec![[POISON; N]; count as usize];
    texels.for_each(|(at, words)| all[at] = words);
    gpu.write_texture(&texture, &all);
    texture
}

/// An atlas full of poison.
pub(super) fn poisoned<const N: usize>(
    gpu: &Gpu,
    name: &str,
    format: Format,
    layers: u32,
) -> wgpu::Texture {
    filled::<N>(gpu, name, format, layers, std::iter::empty())
}

/// Words of a filter; its alpha is 1.
fn half_words([r, g, b]: [f32; 3]) -> [u32; 2] {
    let bits = [r, g, b, 1.0].map(|v| u32::from(f16::from_f32(v).to_bits()));
    [bits[0] | bits[1] << 16, bits[2] | bits[3] << 16]
}

/// Filters, nearest and opaque depths, and curves, as the kernels before would have written them.
pub(super) struct Inputs {
    pub(super) filters: wgpu::Texture,
    pub(super) nearests: wgpu::Texture,
    pub(super) opaques: wgpu::Texture,
    pub(super) curves: wgpu::Texture,
}

impl Inputs {
    pub(super) fn new(gpu: &Gpu, maps: &[ViewMaps; 2]) -> Self {
        let texels = || {
            let of = |view: usize| (0..maps[view].filter.len()).map(move |i| (view, i));
            of(0).chain(of(1))
        };
        let depths = |name, depth: &dyn Fn(usize, usize) -> f32| {
            let texels =
                texels().map(|(view, i)| (place(view, i, 1, 0), [depth(view, i).to_bits()]));
            filled(gpu, name, Format::R32Float, 1, texels)
        };
        let filters =
            texels().map(|(view, i)| (place(view, i, 1, 0), half_words(maps[view].filter[i])));
        let pairs = texels().flat_map(|(view, i)| {
            let packed = &maps[view].curve.as_ref().unwrap().packed;
            (0..NODES / 2).map(move |pair| {
                let [a, b] = [0, 1].map(|k| packed[i * NODES + 2 * pair + k]);
                (place(view, i, NODES as u32 / 2, pair as u32), [a[0], a[1], b[0], b[1]])
            })
        });
        Self {
            filters: filled(gpu, "filters", Format::Rgba16Float, 1, filters),
            nearests: depths("nearests", &|view, i| maps[view].nearest[i]),
            opaques: depths("opaques", &|view, i| maps[view].opaque[i]),
            curves: filled(gpu, "curves", Format::Rgba32Uint, NODES as u32 / 2, pairs),
        }
    }
}

/// A kernel's output in an atlas. Texels are taken out; the others must be poison.
pub(super) struct Written<const N: usize> {
    what: String,
    layers: u32,
    texels: Vec<[u32; N]>,
}

impl<const N: usize> Written<N>
where
    [u32; N]: bytemuck::Pod,
{
    pub(super) fn new(gpu: &Gpu, what: &str, texture: &wgpu::Texture) -> Self {
        let layers = texture.depth_or_array_layers() / ATLAS[2];
        Self { what: what.to_owned(), layers, texels: gpu.read_texture(texture) }
    }

    /// Words of texel `i` of a view.
    pub(super) fn take(&mut self, view: usize, i: usize, layer: u32) -> [u32; N] {
        let at = place(view, i, self.layers, layer);
        let words = std::mem::replace(&mut self.texels[at], [POISON; N]);
        assert_ne!(words, [POISON; N], "{}: texel {i} of view {view} was not written", self.what);
        words
    }

    /// Takes every layer of both views.
    pub(super) fn take_all(&mut self) {
        for (view, size) in SIZES.into_iter().enumerate() {
            for i in 0..size.element_product() as usize {
                for layer in 0..self.layers {
                    self.take(view, i, layer);
                }
            }
        }
    }

    /// Takes the texels beside the views in their last tiles: an invocation may write four texels of a
    /// column.
    fn take_tiles(&mut self) {
        for (view, size) in odd_views().into_iter().zip(SIZES) {
            for y in size.y..size.y.next_multiple_of(TILE) {
                let first = (view.layer * self.layers * ATLAS[1] + view.origin.y + y) * ATLAS[0];
                for layer in 0..self.layers {
                    let at = (first + layer * ATLAS[0] * ATLAS[1] + view.origin.x) as usize;
                    self.texels[at..at + size.x as usize].fill([POISON; N]);
                }
            }
        }
    }

    /// Nothing else was written.
    pub(super) fn assert_rest(&self) {
        let rest = self.texels.iter().filter(|words| **words != [POISON; N]).count();
        assert_eq!(rest, 0, "{}: texels outside the views", self.what);
    }
}

/// Asserts that filters and nearest depths of both views equal `expected`, and that nothing else was written.
pub(super) fn assert_filters(
    gpu: &Gpu,
    what: &str,
    [filters, nearests]: [&wgpu::Texture; 2],
    expected: &[ViewMaps; 2],
) {
    let mut filters = Written::<2>::new(gpu, &format!("{what}: F"), filters);
    let mut nearests = Written::<1>::new(gpu, &format!("{what}: D"), nearests);
    for (view, maps) in expected.iter().enumerate() {
        for i in 0..maps.filter.len() {
            let [red_green, blue_alpha] = filters.take(view, i, 0);
            let bits = [red_green, red_green >> 16, blue_alpha].map(|bits| bits as u16);
            let found = Vec3::from_array(bits.map(|bits| f16::from_bits(bits).to_f32()));
            let off = (found - Vec3::from(maps.filter[i])).abs().max_element();
            assert!(off <= HALF, "{what}: {found} in view {view}, texel {i}");
            let [nearest] = nearests.take(view, i, 0);
            assert_eq!(f32::from_bits(nearest), maps.nearest[i], "{what}: view {view}, texel {i}");
        }
    }
    filters.assert_rest();
    nearests.assert_rest();
}

/// Asserts that curves of both views give the light of `expected`, except in a share `most` of the samples,
/// where rounding decides the merges.
pub(super) fn assert_curves(
    gpu: &Gpu,
    what: &str,
    curves: &wgpu::Texture,
    expected: &[ViewMaps; 2],
    most: f64,
) {
    let mut written = Written::<4>::new(gpu, &format!("{what}: curves"), curves);
    let (mut apart, mut count) = (0, 0);
    for (view, maps) in expected.iter().enumerate() {
        let expected = maps.curve.as_ref().unwrap();
        for i in 0..maps.filter.len() {
            let pairs = [0, 1].map(|pair| written.take(view, i, pair));
            let packed = pairs.iter().flat_map(|&[a, b, c, d]| [[a, b], [c, d]]).collect();
            let found = CurveMap { nodes: NODES, gain: false, packed };
            for k in 0..16 {
                let z = (k as f32 + 0.37) / 16.0;
                let off = (found.light_at(0, z) - expected.light_at(i, z)).abs().max_element();
                apart += u32::from(off > 2e-3);
                count += 1;
            }
        }
    }
    assert!(f64::from(apart) <= most * f64::from(count), "{what}: {apart} of {count}");
    written.take_tiles();
    written.assert_rest();
}
