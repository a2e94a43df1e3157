//! Each kernel with poisoned outputs: every word of the lists is written, and none beyond them.
use super::{cpu, grid, reaches, stage};
use crate::{
    common::{TIERS, gpu},
    stages::by_hand::{POISON, records, run_all},
};
use gobo::{
    gpu::Resources,
    records::ALL_LIGHTS,
    stage::features::Features,
    wgpu::{BufferUsages, TextureFormat as Format},
};
use gobo_picture::stage::cluster;
use gobo_reference::records::ClusterCounters;
use gobo_scene::Scene;

#[test]
fn every_word_of_the_lists_is_written_and_no_other() {
    // Two words of bits per cluster, the second not full; with room, and without.
    let mut scene = stage(43);
    scene.clusters.tile = 32;
    let needed = cpu(&scene).counters.needed;
    for (tier, budget) in TIERS.into_iter().zip([1 << 20, needed / 2]) {
        scene.clusters.budget = budget;
        let (gpu, grid, expected) = (gpu(tier), grid(&scene), cpu(&scene));
        let params = grid.params(&scene.clusters, scene.lights.len());
        assert_eq!(params.word_count, 2);
        let count = params.cluster_count as usize;
        assert!(!count.is_multiple_of(cluster::LANES as usize), "{count} fill their workgroups");
        let usage = BufferUsages::STORAGE | BufferUsages::COPY_SRC;
        let uniform = gpu.upload("cluster_params", &[params], BufferUsages::UNIFORM);
        let counters = gpu.upload("cluster_counters", &[ClusterCounters::default()], usage);
        let poison = |texels: usize| vec![[POISON]; texels];
        let [masks, clusters] = [("masks", 2 * count), ("clusters", 2 * count + needed as usize)]
            .map(|(name, texels)| records(&gpu, name, Format::R32Uint, &poison(texels + 99)));
        let reaches: Vec<[u32; 4]> = reaches(&scene)
            .iter()
            .flat_map(|reach| bytemuck::cast::<_, [[u32; 4]; 4]>(*reach))
            .collect();
        let reaches = records(&gpu, "reaches", Format::Rgba32Uint, &reaches);
        let bounds: Vec<_> = grid.bounds.iter().map(|ends| ends.map(f32::to_bits)).collect();
        let cells = records(&gpu, "cells", Format::Rg32Float, &bounds);
        let offsets = gpu.upload("offsets", &vec![POISON; count + 99], usage);
        let resources = Resources::new()
            .with("cluster_params", &uniform)
            .with("cluster_counters", &counters)
            .with("cells", &cells)
            .with("reaches", &reaches)
            .with("masks", &masks)
            .with("offsets", &offsets)
            .with("clusters", &clusters);
        let groups = [params.cluster_count.div_ceil(cluster::LANES) + 1, 1, 1];
        let none = Features::NONE.constants();
        run_all(&gpu, tier, &none, &resources, &[(&cluster::COUNT, groups)]);
        let lengths: Vec<u32> = gpu.read(&offsets);
        let bits: Vec<u32> = gpu.read_texture(&masks);
        let full = assign_all(&scene);
        for (i, list) in full.iter().enumerate() {
            let own = u64::from(bits[2 * i]) | u64::from(bits[2 * i + 1]) << 32;
            let expected = list.iter().fold(0_u64, |mask, light| mask | 1 << light);
            assert_eq!((own, lengths[i]), (expected, list.len() as u32), "{tier:?}: {i}");
        }
        assert!(lengths[count..].iter().all(|&word| word == POISON), "{tier:?}: lengths");
        assert!(bits[2 * count..].iter().all(|&word| word == POISON), "{tier:?}: bits");

        let later = [(&cluster::SCAN, [1, 1, 1]), (&cluster::EMIT, groups)];
        run_all(&gpu, tier, &none, &resources, &later);
        let starts: Vec<u32> = gpu.read(&offsets);
        let words: Vec<u32> = gpu.read_texture(&clusters);
        // Expected headers and lists: the lists follow each other.
        let mut all = vec![POISON; words.len()];
        let mut next = 2 * count;
        for (i, list) in expected.lists.iter().enumerate() {
            let start = next;
            let header = list.as_ref().map_or([ALL_LIGHTS, params.light_count], |list| {
                all[start..start + list.len()].copy_from_slice(list);
                [start as u32, list.len() as u32]
            });
            all[2 * i..2 * i + 2].copy_from_slice(&header);
            next += full[i].len();
            let offset = if list.is_some() { (start - 2 * count) as u32 } else { ALL_LIGHTS };
            assert_eq!(starts[i], offset, "{tier:?}: start {i}");
        }
        assert_eq!(words, all, "{tier:?}: lists");
        assert!(starts[count..].iter().all(|&word| word == POISON), "{tier:?}: starts");
        assert_eq!(gpu.read::<ClusterCounters>(&counters), [expected.counters], "{tier:?}");
        assert_eq!(expected.counters.overflowed > 0, budget < needed, "{tier:?}");
    }
}

/// The list of each cluster, with an unlimited budget.
fn assign_all(scene: &Scene) -> Vec<Vec<u32>> {
    let mut scene = scene.clone();
    scene.clusters.budget = 1 << 20;
    cpu(&scene).lists.into_iter().map(Option::unwrap).collect()
}
