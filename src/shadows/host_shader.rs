//! The look-up of light in shaders of the host's: its text, and what it binds.
use super::{Maps, Prepared};
use crate::{
    error::Error,
    gpu::{Allocator, KernelError, Library, Linked, Memory},
    model::Light,
    stage::hits::Features,
};

/// What [`Maps::wgsl`] declares, bound. It holds until the maps are made anew: after each
/// [`prepare`](crate::Shadows::prepare) there is another.
#[derive(Debug)]
pub struct LightBindings {
    /// For the host's pipeline layout, at the group that the text was made for.
    pub layout: wgpu::BindGroupLayout,
    /// For its passes.
    pub group: wgpu::BindGroup,
    /// Bytes by buffer and texture, beside the maps.
    pub memory: Memory,
}

fn part() -> Result<Linked, KernelError> {
    Ok(Library::embedded()?.link("shade/light_through.wgsl", "light_at", &[])?)
}

impl Maps {
    /// WGSL to put beside the host's own, with every name prefixed:
    ///
    /// ```wgsl
    /// fn {prefix}light_through(light: u32, position: vec3<f32>, normal: vec3<f32>) -> vec3<f32>
    /// fn {prefix}light_at(light: u32, position: vec3<f32>) -> vec3<f32>
    /// ```
    ///
    /// What of a light reaches a point (world space [m], the normal unit): 1 where nothing is between,
    /// without falloff and cosine. `light` counts the lights that [`Prepared::bind_lights`] bound.
    /// The text is the same for all maps with as many nodes, with `gain` casters or without.
    ///
    /// # Errors
    /// Where `prefix` is not the beginning of a name.
    pub fn wgsl(&self, group: u32, prefix: &str) -> Result<String, Error> {
        let is_letter = |c: char| c.is_ascii_alphanumeric() || c == '_';
        let starts = prefix.starts_with(|c: char| c.is_ascii_digit()) || prefix.starts_with("__");
        if starts || prefix == "_" || !prefix.chars().all(is_letter) {
            let problem = "a name of WGSL must be able to begin with it";
            return Err(Error::Invalid { what: "prefix", index: 0, problem });
        }
        let features = Features { nodes: self.nodes, gain: self.gain, ..Features::NONE };
        Ok(part()?.host_part(group, prefix, &features.constants()))
    }
}

impl Prepared {
    /// Binds the maps and `chosen` of `lights`, which the views were made of, for [`Maps::wgsl`].
    ///
    /// # Errors
    /// Where a light cannot be used or is not there.
    pub fn bind_lights(&self, lights: &[Light], chosen: &[usize]) -> Result<LightBindings, Error> {
        let (device, _) = self.device();
        let mut memory = Memory::default();
        let mut allocator = Allocator { device, memory: &mut memory };
        let source = self.light_source(&mut allocator, lights, chosen)?;
        let resources = source.resources(self.maps());
        let (layout, group) = part()?.bind_host_part(device, "gobo lights", &resources)?;
        Ok(LightBindings { layout, group, memory })
    }
}
