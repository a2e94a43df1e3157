//! Light that glass throws, made after the maps.
use crate::{
    error::Error,
    frame::Commands,
    gpu::{Allocator, Memory, allocated},
    model::{Casters, Light},
    records::{CausticTexel, GlassFace, glass_faces},
    shadows::{Caustics, Prepared, batch::context::view_uniform},
    stage::{
        caustics::{CausticParams, DEPTHS, FACE_LANES, OWNERS, TEXEL_LANES, THROW},
        features::Features,
    },
};
use wgpu::BufferUsages;

/// Workgroups in x of a dispatch over faces or texels.
const ROW: u32 = 32768;
/// Workgroups that all faces share, so that a few large faces keep a device busy.
const SHARED: u32 = 65536;
/// Most workgroups of a face.
const SLICES: u32 = 64;

impl Prepared {
    /// `None` without light that glass throws. `lights`: those that the views were made of.
    ///
    /// # Errors
    /// If the device has no room, or refuses a kernel.
    pub fn throw_light(
        &self,
        lights: &[Light],
        casters: &Casters<'_>,
    ) -> Result<Option<Caustics>, Error> {
        let rays =
            |index: usize| self.views()[index].light.map_or(0, |light| lights[light].caustics);
        if (0..self.views().len()).all(|view| rays(view) == 0) {
            return Ok(None);
        }
        let faces = glass_faces(casters);
        let views = self.gpu_views();
        let (device, queue) = self.device();
        let kernels = self.kernels_on(None);
        allocated(device, || {
            let mut memory = Memory::default();
            let mut allocator = Allocator::new(device, &mut memory);
            let size = |index: usize| self.views()[index].size.element_product();
            let (mut firsts, mut end, mut largest) = (Vec::new(), views.len() as u32, 0);
            for index in 0..views.len() {
                firsts.push(if rays(index) > 0 { end } else { 0 });
                if rays(index) > 0 {
                    end += size(index);
                    largest = largest.max(size(index));
                }
            }
            let copied = BufferUsages::COPY_SRC;
            let texels = allocator.storage::<CausticTexel>("caustics", end.into(), copied)?;
            let head: Vec<CausticTexel> = firsts.iter().map(|&first| [first, 0, 0, 0]).collect();
            let head = allocator.filled("caustic_views", &head, copied);
            let pairs = 2 * u64::from(largest);
            let depths = allocator.storage::<u32>("glass_depths", pairs, copied)?;
            let owners = allocator.storage::<u32>("glass_owners", pairs, copied)?;
            let count = faces.len().max(1) as u64;
            let glass = allocator.storage::<GlassFace>("glass", count, copied)?;
            queue.write_buffer(&glass, 0, bytemuck::cast_slice(&faces));
            let mut commands = Commands::new();
            const LABEL: &str = "gobo caustics";
            commands.clear(LABEL, &texels);
            commands.copy_buffer(LABEL, (&head, 0), (&texels, 0), head.size());
            for index in (0..views.len()).filter(|&index| rays(index) > 0 && !faces.is_empty()) {
                let face_count = faces.len() as u32;
                let slices = (SHARED / face_count).clamp(1, SLICES);
                let values =
                    CausticParams { first: firsts[index], face_count, rays: rays(index), slices };
                let params = allocator.uniform("caustic_params", &values);
                let view = view_uniform(&mut allocator, &views[index..=index]);
                let resources = self
                    .maps()
                    .resources()
                    .with("glass", &glass)
                    .with("glass_depths", &depths)
                    .with("glass_owners", &owners)
                    .with("caustics", &texels)
                    .with("caustic_params", &params)
                    .with("views", &view);
                commands.clear(LABEL, &depths);
                commands.clear(LABEL, &owners);
                let grid = |count: u32, z: u32| [count.min(ROW), count.div_ceil(ROW), z];
                let of_faces = grid(face_count, slices);
                let of_texels = grid(size(index).div_ceil(TEXEL_LANES), 1);
                let none = Features::NONE;
                commands.pass(
                    LABEL,
                    [
                        kernels.dispatch(&DEPTHS, none, &resources, of_faces)?,
                        kernels.dispatch(&OWNERS, none, &resources, of_faces)?,
                        kernels.dispatch(&THROW, none, &resources, of_texels)?,
                    ],
                );
            }
            commands.compile()?;
            debug_assert!(FACE_LANES <= device.limits().max_compute_workgroup_size_x);
            Ok(Some(Caustics { texels, firsts, commands, memory }))
        })
    }
}
