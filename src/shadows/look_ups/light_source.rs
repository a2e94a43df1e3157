//! Inputs of every light look-up besides the maps: the lights, their views and biases, and the levels of
//! area lights.
use crate::shadows::{AreaLevels, Prepared};
use crate::{
    error::{Error, Input},
    frame::Kernels,
    gpu::{Allocator, Resources, Shelf, write_records},
    model::{Light, View},
    records::LightRecords,
    stage::light_points::PictureParams,
};
use bytemuck::Zeroable as _;
use glam::Mat4;
use wgpu::{Texture, TextureFormat, TextureUsages};

/// Some lights on the device.
#[derive(Debug)]
pub(in crate::shadows) struct LightSource {
    /// All resources that `light_through` binds.
    pub resources: Resources,
    /// Levels of area lights, if there are any.
    pub levels: Option<AreaLevels>,
    /// Whether some map is read with another filter than the spline.
    pub is_filtered: bool,
}

impl Prepared {
    /// The kernels, with dispatches that take over a shelf's bind groups.
    pub(in crate::shadows) fn kernels_on(&self, shelf: Option<&Shelf>) -> Kernels {
        shelf.map_or_else(|| self.kernels.clone(), |shelf| self.kernels.with_shelf(shelf))
    }

    /// Uploads `chosen` of `lights`, which the views were made of. `with_areas`: whether area lights keep
    /// their size; `camera`: the view whose pixels the points are, if any.
    pub(in crate::shadows) fn light_source(
        &self,
        allocator: &mut Allocator<'_>,
        lights: &[Light],
        chosen: &[usize],
        with_areas: bool,
        camera: Option<&View>,
    ) -> Result<LightSource, Error> {
        for &index in chosen {
            let unknown = Input::Light.invalid(index, "it is not among the lights");
            lights.get(index).ok_or(unknown)?.check(index)?;
        }
        let (_, queue) = self.device();
        let maps = self.maps();
        let of_light = chosen.iter().map(|&index| (index, &lights[index]));
        let records = LightRecords::new(of_light, &self.views, self.gpu_views(), &self.settings);
        let lights = light_texture(allocator, queue, &records)?;
        let values = PictureParams {
            light_count: chosen.len() as u32,
            colored: u32::from(maps.colored.is_some()),
            first_area: records.first_area(),
            world_from_view: camera.map_or(Mat4::IDENTITY, |it| it.view_from_world.inverse()),
            // No pixel belongs to a cluster.
            tile: 1,
            first_slice: 1.0,
            ..PictureParams::zeroed()
        };
        let params = allocator.uniform("picture_params", &values);
        let resources =
            maps.look_up_resources().with("lights", &lights).with("picture_params", &params);
        let levels = if with_areas {
            let kernels = self.kernels_on(allocator.shelf);
            AreaLevels::new(allocator, &kernels, maps, &self.light_shelf, &records, &resources)?
        } else {
            None
        };
        let resources = resources.with_any("levels", levels.as_ref().map(AreaLevels::texture));
        Ok(LightSource { resources, levels, is_filtered: records.is_filtered() })
    }
}

/// Records of all lights, then of all shadow views, then of areas, for `wgsl/records/light.wgsl` and
/// `area.wgsl`.
pub fn light_texture(
    allocator: &mut Allocator<'_>,
    queue: &wgpu::Queue,
    records: &LightRecords,
) -> Result<Texture, Error> {
    let bytes = records.bytes();
    let format = TextureFormat::Rgba32Uint;
    let texels = bytes.len() as u64 / 16;
    let usage = TextureUsages::COPY_DST | TextureUsages::STORAGE_BINDING;
    let texture = allocator.records("lights", format, texels, usage)?;
    write_records(queue, &texture, bytes);
    Ok(texture)
}
