//! Parts of `wgsl/` for shaders of the host: their source and bindings.
use super::{
    kernel::bind,
    kernel_error::KernelError,
    link::{Constant, Item, Linked, words},
    resource::{Binding, Resources},
    shelf::Shelf,
};
use std::collections::HashSet;
use wgpu::ShaderStages;

impl Linked {
    /// The source for the host's shader: `prefix` goes before every name that could collide with the host's,
    /// and resources are bound in `group`. Overrides become constants: the values in `constants`, or else
    /// their defaults.
    pub fn host_part(&self, group: u32, prefix: &str, constants: &[Constant]) -> String {
        self.prefixed(group, prefix, constants, &[])
    }

    /// Like [`Self::host_part`], but without the prefix before the names `shared`. Lines keep their
    /// positions.
    pub(super) fn prefixed(
        &self,
        group: u32,
        prefix: &str,
        constants: &[Constant],
        shared: &[&str],
    ) -> String {
        let names = self.items.iter().map(|item| item.name);
        let names: HashSet<_> = names.filter(|name| !shared.contains(name)).collect();
        let mut part = String::new();
        for item in &self.items {
            match item.constant(constants) {
                Some((comment, constant)) => part += &format!("{comment}const {prefix}{constant}"),
                None => {
                    let prefixed_item = prefixed(item, &names, prefix);
                    part += &prefixed_item.replace("@group(0)", &format!("@group({group})"));
                }
            }
            part += "\n\n";
        }
        part
    }
}

/// A bind group of `bindings` for [`Linked::host_part`], visible to all stages that may read it, and its
/// layout; both may be the last frame's.
pub fn bind_host_part(
    device: &wgpu::Device,
    shelf: Option<&Shelf>,
    label: &'static str,
    bindings: &[Binding],
    resources: &Resources,
) -> Result<(wgpu::BindGroupLayout, wgpu::BindGroup), KernelError> {
    let layout = || {
        let stages = ShaderStages::VERTEX_FRAGMENT | ShaderStages::COMPUTE;
        let entries: Vec<_> = bindings.iter().map(|binding| binding.entry(stages)).collect();
        device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
            label: Some(label),
            entries: &entries,
        })
    };
    let Some(shelf) = shelf else {
        let layout = layout();
        let group = bind(device, label, bindings, &layout, resources)?;
        return Ok((layout, group));
    };
    let layout = shelf.layout(label, layout);
    let named = bindings.iter().filter_map(|binding| resources.get(binding.name));
    let all = named.cloned().collect();
    let make = || bind(device, label, bindings, &layout, resources);
    Ok((layout.clone(), shelf.group(&layout, all, make)?))
}

fn prefixed(item: &Item, names: &HashSet<&str>, prefix: &str) -> String {
    let (mut text, mut end) = (String::new(), 0);
    for (at, word) in words(item.text).filter(|(_, word)| names.contains(word)) {
        // A member keeps its name, like the expressions that access it.
        let is_member = item.keyword == "struct" && item.text[at + word.len()..].starts_with(':');
        if !is_member {
            text += &item.text[end..at];
            text += prefix;
            end = at;
        }
    }
    text + &item.text[end..]
}
