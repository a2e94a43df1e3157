//! A compute kernel as data: its entry point, the files it is linked from, and the values of its overrides.
use super::{
    kernel_error::KernelError,
    link::{Constant, FEW_TURNS, Library, LinkError, Linked, SAMPLED, UNROLLED},
    resource::Binding,
    tier::Tier,
};
pub(super) use naga::Module;
use std::{
    fmt::{self, Write as _},
    hash::{DefaultHasher, Hash, Hasher},
};

/// A module in the form that wgpu takes.
#[cfg(not(target_arch = "wasm32"))]
pub(super) fn shader_source(module: &Module) -> wgpu::ShaderSource<'static> {
    wgpu::ShaderSource::Naga(std::borrow::Cow::Owned(module.clone()))
}

/// Description of a kernel. Tests read it without a GPU.
#[derive(Clone, Copy, Debug)]
pub struct KernelDesc {
    /// Debug label.
    pub name: &'static str,
    /// Entry point; kernels that differ only in their choices share it.
    pub entry: &'static str,
    /// File of `wgsl/` with the entry point.
    pub root: &'static str,
    /// Files for the imports from `choice::`.
    pub with: &'static [Choice],
    /// Files shared by all kernels of its kind, which need not import each; `with` comes first.
    pub shared: &'static [Choice],
    /// Overrides with defaults other than the WGSL's; [`Kernel::new`](super::Kernel::new) may replace them.
    pub constants: &'static [Constant],
    /// Library from which it is linked.
    pub library: fn() -> Result<&'static Library, LinkError>,
    /// Tiers with a source of their own; a tier between has the source of the one below.
    pub tiers: &'static [Tier],
}

/// The file of `wgsl/` for an import from `choice::`.
#[derive(Clone, Copy, Debug)]
pub struct Choice {
    /// Name after `choice::`.
    pub name: &'static str,
    /// Files by tier, core first.
    pub files: [&'static str; Tier::ALL.len()],
}

impl Choice {
    /// One file on all tiers.
    pub const fn new(name: &'static str, file: &'static str) -> Self {
        Self { name, files: [file; Tier::ALL.len()] }
    }

    /// `file` from `tier` on, `below` on tiers below.
    pub const fn by_tier(
        name: &'static str,
        below: &'static str,
        tier: Tier,
        file: &'static str,
    ) -> Self {
        let mut files = [file; Tier::ALL.len()];
        let mut at = 0;
        while at < tier as usize {
            files[at] = below;
            at += 1;
        }
        Self { name, files }
    }
}

/// Where every kernel reads and writes records; [`Tuning`](crate::stage::tuning::Tuning) may replace them.
const RECORDS: [Choice; 2] = [
    Choice::new("records", "records/in_buffers.wgsl"),
    Choice::new("writes", "records/write_buffers.wgsl"),
];

impl KernelDesc {
    /// A kernel with one source for all tiers, whose entry point has its name.
    pub const fn new(name: &'static str, root: &'static str) -> Self {
        let (with, shared, constants): (&[_], &[_], &[_]) = (&[], &[], &[]);
        let library = Library::embedded;
        Self { name, entry: name, root, with, shared, constants, library, tiers: &[Tier::Core] }
    }

    /// Its choices; the first of a name counts.
    pub fn choices(&self) -> impl Iterator<Item = &Choice> {
        self.with.iter().chain(self.shared).chain(&RECORDS)
    }

    /// The whole source for a tier. Without a variant for the tier, it is the source of the tier below.
    pub fn link(&self, tier: Tier) -> Result<Linked, KernelError> {
        self.link_with(tier, &[])
    }

    /// Like [`Self::link`], with other choices in place of the kernel's own of the same names.
    pub fn link_with(&self, tier: Tier, others: &[Choice]) -> Result<Linked, KernelError> {
        let choices: Vec<_> = others
            .iter()
            .chain(self.choices())
            .map(|choice| (choice.name, choice.files[tier as usize]))
            .collect();
        Ok((self.library)()?.link(self.root, self.entry, &choices)?)
    }

    /// The kernel with these values of its overrides, or else the description's.
    pub fn specialised(
        &self,
        tier: Tier,
        others: &[Choice],
        constants: &[Constant],
    ) -> Result<Specialised, KernelError> {
        let linked = self.link_with(tier, others)?;
        let constants = [constants, self.constants].concat();
        let writes_out = others.iter().any(|choice| choice.name == UNROLLED);
        let max_turns = if writes_out { u32::MAX } else { FEW_TURNS };
        let wgsl = linked.unrolled(linked.with_values(&constants), &constants, max_turns);
        let sampled = others.iter().find(|choice| choice.name == SAMPLED);
        Specialised::new(linked, wgsl, tier, sampled.map(|choice| choice.files[tier as usize]))
    }
}

/// Hash of a text in pieces, whose boundaries count.
struct Hashed(DefaultHasher);

impl fmt::Write for Hashed {
    fn write_str(&mut self, piece: &str) -> fmt::Result {
        piece.hash(&mut self.0);
        Ok(())
    }
}

/// A kernel with values for its overrides.
#[derive(Debug)]
pub struct Specialised {
    /// The source with its overrides.
    pub linked: Linked,
    /// Source with constants in place of overrides, with the lines of `linked`.
    pub wgsl: String,
    /// `wgsl` without the code that the constants make unreachable. `None` in browsers, where `wgsl` itself
    /// is without it, and for invalid WGSL, which a device reports.
    pub module: Option<Module>,
    /// Resources that the kernel reads and writes.
    pub bindings: Vec<Binding>,
}

impl Specialised {
    /// `sampled`: file whose storage textures replace sampled ones.
    #[cfg(not(target_arch = "wasm32"))]
    fn new(
        linked: Linked,
        wgsl: String,
        tier: Tier,
        sampled: Option<&str>,
    ) -> Result<Self, KernelError> {
        let mut bindings = linked.bindings()?;
        let mut module = naga::front::wgsl::parse_str(&wgsl).ok();
        if let Some(module) = &mut module {
            super::link::prune(module);
            let variables = || module.global_variables.iter().map(|(_, it)| it.name.as_deref());
            bindings.retain(|binding| variables().any(|name| name == Some(binding.name)));
            if let Some(file) = sampled {
                Library::embedded()?.load_sampled(
                    module,
                    &mut bindings,
                    file,
                    tier.storage_textures(),
                );
            }
        }
        Ok(Self { linked, wgsl, module, bindings })
    }

    /// Bindings count against limits, and are left out where the kernel never reaches them.
    #[cfg(target_arch = "wasm32")]
    fn new(linked: Linked, wgsl: String, _: Tier, _: Option<&str>) -> Result<Self, KernelError> {
        let mut bindings = linked.bindings()?;
        let pruned = naga::front::wgsl::parse_str(&wgsl).ok().and_then(|mut module| {
            super::link::prune(&mut module);
            Some((super::link::for_browsers(&module).ok()?, module))
        });
        let Some((wgsl, module)) = pruned else {
            return Ok(Self { linked, wgsl, module: None, bindings });
        };
        let variables = || module.global_variables.iter().map(|(_, it)| it.name.as_deref());
        bindings.retain(|binding| variables().any(|name| name == Some(binding.name)));
        Ok(Self { linked, wgsl, module: None, bindings })
    }

    /// A number that kernels with the same code share, and others do not.
    pub(super) fn fingerprint(&self) -> u64 {
        let mut hashed = Hashed(DefaultHasher::new());
        let _ = match &self.module {
            Some(module) => write!(hashed, "{module:?}"),
            None => hashed.write_str(&self.wgsl),
        };
        hashed.0.finish()
    }
}
