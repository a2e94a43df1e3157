//! Kernels that read sampled textures as storage textures.
use super::Library;
use crate::gpu::{Binding, BindingKind};
use naga::{Expression, Function, GlobalVariable, Handle, Module, Span, front::wgsl::parse_str};

impl Library {
    /// Declares sampled textures of a kernel as storage textures where `file` does, so that at most `most` of
    /// these are bound.
    pub(in crate::gpu) fn load_sampled(
        &self,
        module: &mut Module,
        bindings: &mut [Binding],
        file: &str,
        most: u32,
    ) {
        let declared = self.0.get(file).map_or(&[][..], |file| &file.items);
        let text = declared.iter().map(|item| item.text).collect::<Vec<_>>().join("\n");
        let Ok(source) = parse_str(&text) else { return };
        let is_stored = |it: &Binding| matches!(it.kind, BindingKind::StorageTexture { .. });
        let is_sampled = |it: &Binding| matches!(it.kind, BindingKind::Texture { .. });
        let stored = bindings.iter().filter(|it| is_stored(it)).count();
        let mut textures = Vec::new();
        for storage in declared.iter().filter_map(Binding::declared).filter(is_stored) {
            let sampled = bindings.iter_mut().find(|it| it.name == storage.name && is_sampled(it));
            let bound = [&source, module].map(|it| variable(it, storage.name));
            if let (Some(binding), [Some(from), Some(to)]) = (sampled, bound)
                && stored + textures.len() < most as usize
            {
                let ty = source.types[source.global_variables[from].ty].clone();
                module.global_variables[to].ty = module.types.insert(ty, Span::UNDEFINED);
                *binding = storage;
                textures.push(to);
            }
        }
        let entry_points = module.entry_points.iter_mut().map(|it| &mut it.function);
        let functions = module.functions.iter_mut().map(|(_, it)| it).chain(entry_points);
        functions.for_each(|function| load_without_level(function, &textures));
    }
}

fn variable(module: &Module, name: &str) -> Option<Handle<GlobalVariable>> {
    let mut variables = module.global_variables.iter();
    variables.find(|(_, it)| it.name.as_deref() == Some(name)).map(|(variable, _)| variable)
}

/// Storage textures have no mip levels.
fn load_without_level(function: &mut Function, textures: &[Handle<GlobalVariable>]) {
    let is_one = |expression: &Expression| {
        let Expression::GlobalVariable(texture) = expression else { return false };
        textures.contains(texture)
    };
    let images: Vec<_> =
        function.expressions.iter().filter(|(_, it)| is_one(it)).map(|(image, _)| image).collect();
    for (_, expression) in function.expressions.iter_mut() {
        if let Expression::ImageLoad { image, level, .. } = expression
            && images.contains(image)
        {
            *level = None;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gpu::link::prune;
    use naga::valid::{Capabilities, ValidationFlags, Validator};

    #[test]
    fn sampled_textures_become_storage_textures() {
        const KERNEL: &str = "import package::bind::sampled::{many, one};
            @compute @workgroup_size(1) fn k() {
                held = textureLoad(one, vec2(1u, 0u), 0).r + textureLoad(many, vec2(0u), 0).r;
            }
            var<private> held: u32;";
        const SAMPLED: &str = "@group(0) @binding(1) var one: texture_2d<u32>;
            @group(0) @binding(2) var many: texture_2d<u32>;";
        const LOADED: &str = "// Read.
            @group(0) @binding(1) var one: texture_storage_2d<r32uint, read>; // one
            @group(0) @binding(3) var other: texture_storage_2d<r32uint, read>;";
        let files = [("k.wgsl", KERNEL), ("bind/sampled.wgsl", SAMPLED), ("loaded.wgsl", LOADED)];
        let library = Library::new(&files).unwrap();
        let linked = library.link("k.wgsl", "k", &[]).unwrap();
        let mut bindings = linked.bindings().unwrap();
        let mut module = parse_str(&linked.wgsl).unwrap();
        prune(&mut module);
        library.load_sampled(&mut module, &mut bindings, "loaded.wgsl", 1);
        let validator = &mut Validator::new(ValidationFlags::all(), Capabilities::all());
        validator.validate(&module).unwrap_or_else(|error| panic!("{error:?}"));
        let is_stored = |it: &Binding| matches!(it.kind, BindingKind::StorageTexture { .. });
        let stored = bindings.iter().map(|it| (it.name, is_stored(it))).collect::<Vec<_>>();
        assert_eq!(stored, [("one", true), ("many", false)]);
    }
}
