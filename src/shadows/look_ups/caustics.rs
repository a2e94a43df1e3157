//! Light that glass and lit surfaces throw, made after the maps.
use super::bounce::Bounces;
use crate::{
    error::Error,
    frame::Commands,
    gpu::{Allocator, Memory, allocated},
    model::{Casters, Light, View, ViewRole},
    records::{CausticTexel, GLASS_VECTORS, GlassFace, GpuView, glass_faces},
    shadows::{Caustics, Prepared, batch::context::view_uniform},
    stage::{
        caustics::{CausticParams, DEPTHS, FACE_LANES, OWNERS, TEXEL_LANES, THROW, THROW_IN_CUBE},
        features::Features,
    },
};
use glam::Vec4;
use std::ops::Range;
use wgpu::{Buffer, BufferUsages};

const _: () = assert!(size_of::<GlassFace>() == GLASS_VECTORS as usize * size_of::<Vec4>());

/// Label of the commands.
pub(super) const LABEL: &str = "gobo caustics";
/// Workgroups in x of a dispatch over faces or texels.
const ROW: u32 = 32768;
/// Workgroups in all, so that a few large faces keep a device busy.
const SHARED: u32 = 8192;
/// Most workgroups of a face.
const SLICES: u32 = 256;

/// A grid of `count` workgroups.
pub(super) fn grid(count: u32, z: u32) -> [u32; 3] {
    [count.min(ROW), count.div_ceil(ROW), z]
}

/// Workgroups that share the large ones of `count` faces, and those of all faces.
pub(super) fn of_faces(count: u32) -> (u32, [u32; 3]) {
    let groups = count.div_ceil(FACE_LANES).max(1);
    let slices = (SHARED / groups).clamp(1, SLICES);
    (slices, grid(groups, slices))
}

/// A buffer of faces.
pub(super) fn face_buffer(
    allocator: &mut Allocator<'_>,
    queue: &wgpu::Queue,
    faces: &[GlassFace],
) -> Result<Buffer, Error> {
    let buffer =
        allocator.storage::<GlassFace>("glass", faces.len() as u64, BufferUsages::COPY_SRC)?;
    queue.write_buffer(&buffer, 0, bytemuck::cast_slice(faces));
    Ok(buffer)
}

/// Views whose rays land in each other's maps: the faces of a cube, or one view.
fn shadows_of(views: &[View]) -> impl Iterator<Item = Range<usize>> + '_ {
    let starts = (0..views.len()).filter(|&i| !matches!(views[i].role, ViewRole::Face(1..)));
    starts.map(|first| match views[first].role {
        ViewRole::Face(_) => first..(first + 6).min(views.len()),
        _ => first..first + 1,
    })
}

impl Prepared {
    /// `None` without light that glass or lit surfaces throw. `lights`: those that the views were made of.
    ///
    /// # Errors
    /// If the device has no room, or refuses a kernel, or more points send light on than
    /// [`MAX_BOUNCES`](crate::model::MAX_BOUNCES).
    pub fn throw_light(
        &self,
        lights: &[Light],
        casters: &Casters<'_>,
    ) -> Result<Option<Caustics>, Error> {
        let of = |index: usize| self.views()[index].light.and_then(|light| lights.get(light));
        let rays = |index: usize| of(index).map_or(0, |light| light.caustics);
        let bounces = |index: usize| of(index).map_or(0, Light::bounce_count);
        if (0..self.views().len()).all(|view| rays(view) == 0 && bounces(view) == 0) {
            return Ok(None);
        }
        let views = self.gpu_views();
        let (device, queue) = self.device();
        allocated(device, || {
            let mut memory = Memory::default();
            let mut allocator = Allocator::new(device, &mut memory);
            let size = |index: usize| self.views()[index].size.element_product();
            let (mut firsts, mut end) = (Vec::new(), views.len() as u32);
            for index in 0..views.len() {
                firsts.push(if rays(index) > 0 { end } else { 0 });
                end += if rays(index) > 0 { size(index) } else { 0 };
            }
            let copied = BufferUsages::COPY_SRC;
            let texels = allocator.storage::<CausticTexel>("caustics", end.into(), copied)?;
            let head: Vec<CausticTexel> = firsts.iter().map(|&first| [first, 0, 0, 0]).collect();
            let head = allocator.filled("caustic_views", &head, copied);
            let mut commands = Commands::new();
            commands.clear(LABEL, &texels);
            commands.copy_buffer(LABEL, (&head, 0), (&texels, 0), head.size());
            let shadows: Vec<_> =
                shadows_of(self.views()).filter(|shadow| rays(shadow.start) > 0).collect();
            let faces = if shadows.is_empty() { Vec::new() } else { glass_faces(casters) };
            if !faces.is_empty() {
                let most = shadows.iter().map(|shadow| shadow.clone().map(size).sum::<u32>());
                let pairs = 2 * u64::from(most.max().unwrap_or(0));
                let thrower = Thrower {
                    prepared: self,
                    depths: allocator.storage::<u32>("glass_depths", pairs, copied)?,
                    owners: allocator.storage::<u32>("glass_owners", pairs, copied)?,
                    glass: face_buffer(&mut allocator, queue, &faces)?,
                    face_count: faces.len() as u32,
                    channels: if faces.iter().any(|face| face.corners[1].w > 0.0) { 3 } else { 1 },
                    texels: &texels,
                };
                for shadow in shadows {
                    let first = firsts[shadow.start];
                    let rays = rays(shadow.start);
                    let views = &views[shadow];
                    thrower.throw(&mut allocator, &mut commands, views, first, rays)?;
                }
            }
            let points = Bounces::new(self, &mut allocator, &mut commands, lights, casters)?;
            commands.compile()?;
            debug_assert!(FACE_LANES <= device.limits().max_compute_workgroup_size_x);
            Ok(Some(Caustics { texels, firsts, bounces: points.buffer, commands, memory }))
        })
    }
}

/// Throws the light of one shadow after the other.
struct Thrower<'a> {
    prepared: &'a Prepared,
    depths: Buffer,
    owners: Buffer,
    glass: Buffer,
    face_count: u32,
    /// Channels of light that are refracted apart.
    channels: u32,
    texels: &'a Buffer,
}

impl Thrower<'_> {
    /// `views` of a shadow; `first`: of its texels.
    fn throw(
        &self,
        allocator: &mut Allocator<'_>,
        commands: &mut Commands,
        views: &[GpuView],
        first: u32,
        rays: u32,
    ) -> Result<(), Error> {
        let kernels = self.prepared.kernels_on(None);
        let resources = self
            .prepared
            .maps()
            .resources()
            .with("glass", &self.glass)
            .with("glass_depths", &self.depths)
            .with("glass_owners", &self.owners)
            .with("caustics", self.texels);
        let &Self { face_count, channels, .. } = self;
        let (slices, of_faces) = of_faces(face_count);
        let (mut searches, mut throws) = (Vec::new(), Vec::new());
        let all_views = view_uniform(allocator, views);
        let mut base = 0;
        for (number, view) in (0..).zip(views) {
            let texels = view.size.x as u32 * view.size.y as u32;
            let params = CausticParams { first, base, number, face_count, rays, slices };
            let params = allocator.uniform("caustic_params", &params);
            let own = view_uniform(allocator, std::slice::from_ref(view));
            let resources = resources.clone().with("caustic_params", &params);
            let of_view = resources.clone().with("views", &own);
            let of_shadow = resources.with("views", &all_views);
            let of_texels = grid(texels.div_ceil(TEXEL_LANES), channels);
            let none = Features::NONE;
            for kernel in [&DEPTHS, &OWNERS] {
                searches.push(kernels.dispatch(kernel, none, &of_view, of_faces)?);
            }
            let throw = if views.len() > 1 { &THROW_IN_CUBE } else { &THROW };
            throws.push(kernels.dispatch(throw, none, &of_shadow, of_texels)?);
            base += texels;
        }
        commands.clear(LABEL, &self.depths);
        commands.clear(LABEL, &self.owners);
        commands.pass(LABEL, searches.into_iter().chain(throws));
        Ok(())
    }
}
