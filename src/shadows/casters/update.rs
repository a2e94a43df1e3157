//! Updates of the casters on the GPU from a changed scene.
use super::{
    CasterSet,
    features::{asks_for_owners, features_of},
    group::Members,
    groups::next_generation,
    record_sources::{RecordSources, layout, materials_of},
    upload::{material_records, upload_image, upload_parts},
    uploaded::hash,
};
use crate::{
    model::{
        CLASSES, Casters, Class, Grid, Material, Texture, Triangle, absorptions, dither::window,
    },
    records::{Capsules, TriangleRecord},
};
use std::ops::Range;

impl CasterSet {
    /// Uploads changes of the scene and of `host_grids`, the host's grids with bricks. Returns false if a new
    /// set must be made: for another number of casters, materials or textures, other sizes of textures,
    /// casters of another class, or particles that have drifted so far apart that they need new groups.
    pub fn update(
        &mut self,
        queue: &wgpu::Queue,
        casters: &Casters<'_>,
        host_grids: &[Grid],
    ) -> bool {
        let &Casters {
            gaussians, triangles, grids, strands, materials, textures, in_order, ..
        } = casters;
        let Some(new_bricks) = self.bricks.update(queue, grids, host_grids) else { return false };
        let first_brick = casters.particles.len();
        let capsules = &Capsules::new(strands);
        let particles = &*capsules.among(self.bricks.among(casters.particles));
        let casters = &Casters { particles, ..*casters };
        if self.uploaded.in_order != in_order
            || particles.len() != self.uploaded.particle_count
            || !self.is_laid_out_as(casters)
        {
            return false;
        }
        let sources = RecordSources::new(casters, capsules);
        let is_new = self.update_materials(queue, triangles, materials, textures);
        self.features = features_of(particles, gaussians, triangles, materials);
        self.add_emitted_features();
        self.dither_window = window(materials);
        self.owners = asks_for_owners(materials);
        let is_new_brick = |particle: u32| {
            let brick = (particle as usize).checked_sub(first_brick);
            brick.and_then(|brick| new_bricks.get(brick)) == Some(&true)
        };
        self.update_casters(queue, sources, triangles, &is_new, is_new_brick)
    }

    /// Whether every caster and texture keeps its place in the upload.
    fn is_laid_out_as(&self, casters: &Casters<'_>) -> bool {
        let &Casters { particles, gaussians, triangles, materials, textures, .. } = casters;
        let uploaded = &self.uploaded;
        let same_layouts = materials.len() == uploaded.materials.len()
            && materials.iter().map(layout).eq(uploaded.materials.iter().map(layout));
        let sizes = textures.iter().map(|t| (t.width, t.height));
        if !same_layouts
            || particles.len() + gaussians.len() != uploaded.particle_order.len()
            || triangles.len() != uploaded.triangle_order.len()
            || !sizes.eq(uploaded.texture_sizes.iter().copied())
        {
            return false;
        }
        let classes: Vec<_> = materials.iter().map(Class::of).collect();
        let in_place = |order: &[u32], ranges: &[Range<u32>; CLASSES], of: &dyn Fn(u32) -> u32| {
            Class::ALL.into_iter().zip(ranges).all(|(class, range)| {
                let members = &order[range.start as usize..range.end as usize];
                members.iter().all(|&i| classes[of(i) as usize] == class)
            })
        };
        let of_particles: Vec<_> = materials_of(particles, gaussians).collect();
        in_place(&uploaded.particle_order, &self.particle_ranges, &|i| of_particles[i as usize])
            && in_place(&uploaded.triangle_order, &self.triangle_ranges, &|i| {
                triangles[i as usize].material
            })
    }

    /// Updates the materials; returns for each whether it or its texture changed.
    fn update_materials(
        &mut self,
        queue: &wgpu::Queue,
        triangles: &[Triangle],
        materials: &[Material],
        textures: &[Texture],
    ) -> Vec<bool> {
        let uploaded = &mut self.uploaded;
        let hashes: Vec<u64> = textures.iter().map(hash).collect();
        let new_texture: Vec<bool> =
            hashes.iter().zip(&uploaded.textures).map(|(new, old)| new != old).collect();
        for (layer, _) in new_texture.iter().enumerate().filter(|&(_, &new)| new) {
            upload_image(queue, &self.images, layer, &textures[layer]);
        }
        let new_material: Vec<bool> = materials
            .iter()
            .zip(&uploaded.materials)
            .map(|(new, old)| new != old || new.texture.is_some_and(|t| new_texture[t as usize]))
            .collect();
        if new_material.contains(&true) {
            let absorptions = absorptions(materials, triangles);
            let records = material_records(materials, textures, uploaded.blue_first, &absorptions);
            queue.write_buffer(&self.materials, 0, bytemuck::cast_slice(&records));
        }
        (uploaded.materials, uploaded.textures) = (materials.to_vec(), hashes);
        new_material
    }

    /// Updates the casters; `is_new_brick`: whether a particle stands for a brick that changed. Returns false
    /// if particles have drifted too far apart.
    fn update_casters(
        &mut self,
        queue: &wgpu::Queue,
        sources: RecordSources<'_>,
        triangles: &[Triangle],
        new_material: &[bool],
        is_new_brick: impl Fn(u32) -> bool,
    ) -> bool {
        let Self { uploaded, groups, .. } = self;
        let materials = sources.materials;
        let changed_at = next_generation();
        let (mut new_particles, mut new_triangles) = (Vec::new(), Vec::new());
        let first = sources.axes_first as usize;
        let behind = uploaded.casters.split_off(first);
        uploaded.casters.extend(sources.all_behind());
        if behind.len() + first != uploaded.casters.len() {
            return false;
        }
        let has_new_behind = |i: u32| {
            let records = sources.behind(i);
            !records.is_empty()
                && behind[records.start - first..records.end - first] != uploaded.casters[records]
        };
        let new_behind: Vec<_> =
            uploaded.particle_order.iter().map(|&index| has_new_behind(index)).collect();
        let mut new_occluders = false;
        for index in 0..groups.groups.len() {
            if groups.is_emitted(&groups.groups[index]) {
                continue;
            }
            let group = &mut groups.groups[index];
            let range = group.casters.start as usize..group.casters.end as usize;
            let is_new = if group.is_triangles() {
                let records = &mut uploaded.triangles[range.clone()];
                replace(records, &uploaded.triangle_order[range], |i| {
                    let triangle = &triangles[i as usize];
                    (TriangleRecord::new(triangle), new_material[triangle.material as usize])
                })
            } else {
                let records = &mut uploaded.casters[range.clone()];
                replace(records, &uploaded.particle_order[range.clone()], |i| {
                    let must = new_material[sources.material(i) as usize] || is_new_brick(i);
                    (sources.record(i), must)
                }) | new_behind[range].contains(&true)
            };
            if is_new {
                let order = &uploaded.triangle_order;
                let members = Members { casters: &uploaded.casters, triangles, order, materials };
                group.refit(members, changed_at);
                new_occluders |= group.may_hide();
                let parts =
                    if group.is_triangles() { &mut new_triangles } else { &mut new_particles };
                parts.push(group.casters.clone());
            }
        }
        if new_occluders {
            let order = &uploaded.triangle_order;
            let members = Members { casters: &uploaded.casters, triangles, order, materials };
            groups.find_occluders(members, changed_at);
        }
        if new_behind.contains(&true) {
            new_particles.push(sources.axes_first..uploaded.casters.len() as u32);
        }
        self.casters.update(queue, &uploaded.casters, &new_particles);
        upload_parts(queue, &self.triangles, &uploaded.triangles, &new_triangles);
        (new_particles.is_empty() && new_triangles.is_empty()) || groups.refit()
    }
}

/// Replaces the record of each index by `make`'s. Returns whether a record differs, or must be new.
fn replace<T: PartialEq>(
    records: &mut [T],
    order: &[u32],
    make: impl Fn(u32) -> (T, bool),
) -> bool {
    let mut is_new = false;
    for (record, &index) in records.iter_mut().zip(order) {
        let (made, must) = make(index);
        is_new |= must || *record != made;
        *record = made;
    }
    is_new
}
