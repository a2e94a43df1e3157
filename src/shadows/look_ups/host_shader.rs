//! Light look-up in the host's shaders: its WGSL and bindings.
use crate::shadows::{AreaLevels, Maps, Prepared};
use crate::{
    error::{Error, Input},
    gpu::{
        Allocator, Binding, Choice, Constant, KernelError, Library, Linked, Memory, Timeline,
        allocated, bind_host_part,
    },
    model::Light,
    stage::{
        features::{Features, Flags},
        levels::{OF_AREA, OF_POINT},
    },
};
use std::sync::LazyLock;
use wgpu::{TextureFormat::Rgba32Uint, TextureUsages};

/// Bindings of the declarations of [`Maps::wgsl`], for one frame: bind again after each
/// [`prepare`](crate::Shadows::prepare). Layout and group stay the same while no size changes, and only the
/// lights are written, before the next submission: submit the recorded commands of a frame before you prepare
/// the next.
#[derive(Debug)]
pub struct LightBindings {
    /// Layout for the host's pipeline, at the group that the text was made for.
    pub layout: wgpu::BindGroupLayout,
    /// Bind group for the host's passes.
    pub group: wgpu::BindGroup,
    /// Bytes by buffer and texture, without the maps.
    pub memory: Memory,
    levels: Option<AreaLevels>,
}

impl LightBindings {
    /// Records the levels of area lights, after the maps and before the host's passes. Records nothing for
    /// [`Prepared::bind_lights`], nor where another look-up has made the same levels since the maps were
    /// drawn.
    pub fn record(&self, encoder: &mut wgpu::CommandEncoder) {
        if let Some(levels) = &self.levels {
            levels.record(encoder, &mut Timeline::untimed());
        }
    }
}

/// A look-up, and its bindings.
struct Part {
    linked: Linked,
    bindings: Vec<Binding>,
    label: &'static str,
}

/// The look-ups for point and area lights.
static PARTS: LazyLock<[Result<Part, KernelError>; 2]> = LazyLock::new(|| {
    [(OF_POINT, "gobo lights"), (OF_AREA, "gobo area lights")].map(|(source, label)| {
        let choices = [(source.name, source.files[0])];
        let linked = Library::embedded()?.link("shade/light_through.wgsl", "light_at", &choices)?;
        let bindings = linked.bindings()?;
        Ok(Part { linked, bindings, label })
    })
});

fn part(source: Choice) -> Result<&'static Part, KernelError> {
    let is_area = source.files == OF_AREA.files;
    PARTS[usize::from(is_area)].as_ref().map_err(Clone::clone)
}

impl Maps {
    /// WGSL to add to the host's own, with a prefix before every name:
    ///
    /// ```wgsl
    /// fn {prefix}light_through(light: u32, position: vec3<f32>, normal: vec3<f32>) -> vec3<f32>
    /// fn {prefix}light_at(light: u32, position: vec3<f32>) -> vec3<f32>
    /// ```
    ///
    /// The share of a light that reaches a point (world space \[m\], the normal unit): 1 if nothing is in
    /// between, without falloff and cosine; 0 behind the far plane of its view. `light` indexes the lights
    /// that [`Prepared::bind_lights`] bound. The text is the same for all maps with the same number of nodes,
    /// with `gain` or `over` casters or without, with curves in pages or without.
    ///
    /// # Errors
    /// If `prefix` cannot begin a name.
    pub fn wgsl(&self, group: u32, prefix: &str) -> Result<String, Error> {
        self.text(OF_POINT, group, prefix)
    }

    /// Like [`Self::wgsl`], for the lights that [`Prepared::bind_area_lights`] bound: area lights have
    /// penumbrae.
    ///
    /// # Errors
    /// If `prefix` cannot begin a name.
    pub fn area_wgsl(&self, group: u32, prefix: &str) -> Result<String, Error> {
        self.text(OF_AREA, group, prefix)
    }

    fn text(&self, source: Choice, group: u32, prefix: &str) -> Result<String, Error> {
        let is_letter = |c: char| c.is_ascii_alphanumeric() || c == '_';
        let starts = prefix.starts_with(|c: char| c.is_ascii_digit()) || prefix.starts_with("__");
        if starts || prefix == "_" || !prefix.chars().all(is_letter) {
            let problem = "a name of WGSL must be able to begin with it";
            return Err(Input::Prefix.invalid(0, problem));
        }
        Ok(part(source)?.linked.host_part(group, prefix, &constants(self.features())))
    }
}

fn constants(maps: Features) -> Vec<Constant> {
    // The text is the same for all bound lights.
    maps.with(Flags::HAS_FILTERS, true).constants()
}

/// Text of [`Maps::wgsl`] and its bindings, for maps with `nodes` nodes, with or without `gain` or `over`
/// casters.
#[doc(hidden)]
pub fn look_up_text(
    nodes: u32,
    gain: bool,
    group: u32,
    prefix: &str,
) -> Result<(String, Vec<Binding>), Error> {
    let part = part(OF_POINT)?;
    let text = part.linked.host_part(group, prefix, &constants(Features::of_maps(nodes, gain)));
    Ok((text, part.bindings.clone()))
}

impl Prepared {
    /// Binds the maps and `chosen` of `lights`, which the views were made of, for [`Maps::wgsl`]. Area
    /// lights are treated as points.
    ///
    /// # Errors
    /// If a light is invalid or does not exist, a later `prepare` has taken the maps over, or the device is
    /// lost.
    pub fn bind_lights(&self, lights: &[Light], chosen: &[usize]) -> Result<LightBindings, Error> {
        self.bind_source(OF_POINT, lights, chosen)
    }

    /// Like [`Self::bind_lights`], for [`Maps::area_wgsl`]. [`LightBindings::record`] must be recorded after
    /// the maps of each frame. Kernels are compiled here unless
    /// [`HostInputs::area_lights`](crate::HostInputs::area_lights) announced them.
    ///
    /// # Errors
    /// Those of [`Self::bind_lights`], or there are too many area lights.
    pub fn bind_area_lights(
        &self,
        lights: &[Light],
        chosen: &[usize],
    ) -> Result<LightBindings, Error> {
        self.bind_source(OF_AREA, lights, chosen)
    }

    fn bind_source(
        &self,
        choice: Choice,
        lights: &[Light],
        chosen: &[usize],
    ) -> Result<LightBindings, Error> {
        self.check_usable()?;
        let (device, _) = self.device();
        allocated(device, || {
            let mut memory = Memory::default();
            let shelf = self.light_shelf.take();
            let mut allocator = Allocator { shelf, ..Allocator::new(device, &mut memory) };
            let with_areas = choice.files == OF_AREA.files;
            let source = self.light_source(&mut allocator, lights, chosen, with_areas, None)?;
            source.levels.iter().try_for_each(AreaLevels::compile)?;
            let none = match &source.levels {
                None if with_areas => {
                    Some(allocator.records("levels", Rgba32Uint, 1, TextureUsages::empty())?)
                }
                _ => None,
            };
            let resources = source.resources.with_any("levels", none.as_ref());
            let Part { bindings, label, .. } = part(choice)?;
            let (layout, group) = bind_host_part(device, shelf, label, bindings, &resources)?;
            Ok(LightBindings { layout, group, memory, levels: source.levels })
        })
    }
}
