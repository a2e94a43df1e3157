//! Kernels that read sampled textures as storage textures.
use super::{Item, Library, Linked};
use crate::gpu::NATIVE_STORAGE_TEXTURES;

/// Choice whose file declares sampled textures as storage textures.
pub const SAMPLED: &str = "sampled";

impl Library {
    /// The kernel with sampled textures declared as in `file` where it declares them, as storage textures:
    /// at most as many as the native tier has.
    pub(in crate::gpu) fn loaded(&self, linked: Linked, file: &'static str) -> Linked {
        let is_stored = |item: &&Item| item.text.contains("texture_storage_");
        let stored = linked.items.iter().filter(is_stored).count();
        let sampled =
            |item: &Item| item.text.contains("@binding(") && item.text.contains(": texture_2d");
        let (mut items, mut names) = (linked.items, Vec::new());
        for item in items.iter_mut().filter(|item| sampled(item)) {
            let found = self.item(file, item.name, (file, 1)).ok().filter(is_stored);
            if let Some(found) = found
                && stored + names.len() < NATIVE_STORAGE_TEXTURES as usize
            {
                *item = found.clone();
                names.push(found.name);
            }
        }
        let mut linked = Linked::new(items);
        for name in names {
            linked.wgsl = without_level(&linked.wgsl, name);
        }
        linked
    }
}

/// A source whose loads from `texture` name no mip level, as of storage textures.
fn without_level(wgsl: &str, texture: &str) -> String {
    let load = format!("textureLoad({texture}, ");
    let mut calls = wgsl.split(&load);
    let mut text = calls.next().unwrap_or_default().to_owned();
    for call in calls {
        let mut depth = 1;
        let end = call.find(|c| {
            depth += i32::from(c == '(') - i32::from(c == ')');
            depth == 0
        });
        let (arguments, rest) = call.split_at(end.unwrap_or_default());
        let arguments = arguments.strip_suffix(", 0").unwrap_or(arguments);
        text.extend([load.as_str(), arguments, rest]);
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gpu::link::SourceFile;

    #[test]
    fn sampled_textures_become_storage_textures() {
        const KERNEL: SourceFile = (
            "k.wgsl",
            "import package::bind::sampled::{many, one};\nfn k() -> u32 {\n    \
             return textureLoad(one, at(vec2(1u, 0u)), 0).r + textureLoad(many, at(vec2(0u)), 0).r;\n}\n\
             fn at(place: vec2<u32>) -> vec2<u32> { return place; }\n",
        );
        const SAMPLED: SourceFile = (
            "bind/sampled.wgsl",
            "@group(0) @binding(1) var one: texture_2d<u32>;\n\
             @group(0) @binding(2) var many: texture_2d<u32>;\n",
        );
        const LOADED: SourceFile = (
            "bind/loaded.wgsl",
            "@group(0) @binding(1) var one: texture_storage_2d<r32uint, read>;\n",
        );
        let library = Library::new(&[KERNEL, SAMPLED, LOADED]).unwrap();
        let own = library.link(KERNEL.0, "k", &[]).unwrap();
        let lines = own.wgsl.lines().count();
        let loaded = library.loaded(own, LOADED.0);
        for part in [
            "var one: texture_storage_2d<r32uint, read>;",
            "textureLoad(one, at(vec2(1u, 0u))).r",
            "var many: texture_2d<u32>;",
            "textureLoad(many, at(vec2(0u)), 0).r",
        ] {
            assert!(loaded.wgsl.contains(part), "{part}: {}", loaded.wgsl);
        }
        assert!(!loaded.wgsl.contains("var one: texture_2d"), "{}", loaded.wgsl);
        assert_eq!(loaded.wgsl.lines().count(), lines);
    }
}
