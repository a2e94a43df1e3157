//! A compute kernel as data: its entry point, the files it is linked from, and the values of its overrides.
use super::{
    kernel::KernelError,
    link::{Library, Linked, SAMPLED},
};

/// A WGSL `override` and its value.
pub type Constant = (&'static str, f64);

/// Description of a kernel. Tests read it without a GPU.
#[derive(Debug)]
pub struct KernelDesc {
    /// Debug label.
    pub name: &'static str,
    /// Entry point; kernels that differ only in their choices share it.
    pub entry: &'static str,
    /// File of `wgsl/` with the entry point.
    pub root: &'static str,
    /// Files that the imports from `choice::` stand for.
    pub with: &'static [Choice],
    /// Overrides with defaults different from the WGSL's; [`Kernel::new`](super::Kernel::new) may replace them.
    pub constants: &'static [Constant],
    /// Tiers on which the kernel runs.
    pub tiers: &'static [Tier],
}

/// The file of `wgsl/` that an import from `choice::` stands for.
#[derive(Clone, Copy, Debug)]
pub struct Choice {
    pub name: &'static str,
    /// Files by tier, core first.
    pub files: [&'static str; 2],
}

impl Choice {
    pub const fn new(name: &'static str, file: &'static str) -> Self {
        Self { name, files: [file, file] }
    }

    pub const fn by_tier(name: &'static str, core: &'static str, native: &'static str) -> Self {
        Self { name, files: [core, native] }
    }
}

/// Set of device features that kernels use.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Tier {
    /// WebGPU's own limits and features.
    #[default]
    Core,
    /// `SUBGROUP` and `TEXTURE_ATOMIC`; kernels for software adapters also
    /// [`FETCH_FEATURES`](super::FETCH_FEATURES).
    Native,
}

impl Tier {
    pub const ALL: &'static [Self] = &[Self::Core, Self::Native];
}

impl std::fmt::Display for Tier {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Self::Core => "core",
            Self::Native => "native",
        })
    }
}

impl KernelDesc {
    /// The whole source on a tier. A kernel of a single tier has the same source on both.
    pub fn link(&self, tier: Tier) -> Result<Linked, KernelError> {
        self.link_with(tier, &[])
    }

    /// Like [`Self::link`], with other choices in place of the kernel's own of the same names.
    pub fn link_with(&self, tier: Tier, others: &[Choice]) -> Result<Linked, KernelError> {
        let choices: Vec<_> = others
            .iter()
            .chain(self.with)
            .map(|choice| (choice.name, choice.files[tier as usize]))
            .collect();
        let library = Library::embedded()?;
        let linked = library.link(self.root, self.entry, &choices)?;
        Ok(match choices.iter().find(|(name, _)| *name == SAMPLED) {
            Some((_, file)) => library.loaded(linked, file),
            None => linked,
        })
    }

    /// The source without what these values of its overrides leave unreached, and the values of those that
    /// are left: of `constants`, or else of the description.
    pub fn specialised(
        &self,
        tier: Tier,
        others: &[Choice],
        constants: &[Constant],
    ) -> Result<(Linked, Vec<Constant>), KernelError> {
        let constants = [constants, self.constants].concat();
        let given = |name| constants.iter().find(|(known, _)| *known == name).copied();
        let linked = self.link_with(tier, others)?;
        let values: Vec<_> = linked.overrides().filter_map(given).collect();
        let linked = linked.pruned(self.entry, &values);
        let values = linked.overrides().filter_map(given).collect();
        Ok((linked, values))
    }
}
