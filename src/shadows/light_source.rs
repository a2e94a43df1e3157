//! What every look-up of light reads beside the maps: the lights, their views and the biases.
use super::{Maps, Prepared};
use crate::{
    error::Error,
    gpu::{Allocator, Resources, write_records},
    model::Light,
    records::{GpuLight, GpuView, LIGHT_TEXELS, VIEW_TEXELS},
    stage::shade::PictureParams,
};
use bytemuck::Zeroable as _;
use wgpu::{Buffer, Texture, TextureFormat, TextureUsages};

/// Some lights on the device.
#[derive(Debug)]
pub(super) struct LightSource {
    lights: Texture,
    params: Buffer,
}

impl LightSource {
    /// All that `light_through` binds.
    pub(super) fn resources<'a>(&'a self, maps: &'a Maps) -> Resources<'a> {
        maps.resources()
            .with("opaques", maps.colored.as_ref().unwrap_or(&maps.opaques))
            .with("lights", &self.lights)
            .with("picture_params", &self.params)
    }
}

impl Prepared {
    /// `chosen` of `lights`, which the views were made of.
    pub(super) fn light_source(
        &self,
        allocator: &mut Allocator<'_>,
        lights: &[Light],
        chosen: &[usize],
    ) -> Result<LightSource, Error> {
        for &index in chosen {
            let (what, problem) = ("light", "it is not among the lights");
            lights.get(index).ok_or(Error::Invalid { what, index, problem })?.check(index)?;
        }
        let (_, queue) = self.device();
        let maps = self.maps();
        let records: Vec<_> =
            chosen.iter().map(|&index| GpuLight::new(&lights[index], index, &self.views)).collect();
        let views: Vec<_> = self
            .views
            .iter()
            .zip(&maps.places)
            .map(|(view, place)| view.to_gpu(0, place.origin, place.layer))
            .collect();
        let lights = light_texture(allocator, queue, &records, &views)?;
        let params = allocator.uniform::<PictureParams>("picture_params");
        let values = PictureParams {
            light_count: chosen.len() as u32,
            bias: self.settings.bias,
            normal_bias: self.settings.normal_bias,
            colored: u32::from(maps.colored.is_some()),
            ..PictureParams::zeroed()
        };
        queue.write_buffer(&params, 0, bytemuck::bytes_of(&values));
        Ok(LightSource { lights, params })
    }
}

/// Records of all lights, then of all shadow views: what `wgsl/records/light.wgsl` reads.
pub(crate) fn light_texture(
    allocator: &mut Allocator<'_>,
    queue: &wgpu::Queue,
    lights: &[GpuLight],
    views: &[GpuView],
) -> Result<Texture, Error> {
    let texels =
        lights.len() as u64 * u64::from(LIGHT_TEXELS) + views.len() as u64 * u64::from(VIEW_TEXELS);
    let format = TextureFormat::Rgba32Uint;
    let texture = allocator.records("lights", format, texels, TextureUsages::COPY_DST)?;
    let mut bytes = bytemuck::cast_slice(lights).to_vec();
    bytes.extend_from_slice(bytemuck::cast_slice(views));
    write_records(queue, &texture, bytes);
    Ok(texture)
}
