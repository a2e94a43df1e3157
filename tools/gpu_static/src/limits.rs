//! What kernels may need on a GPU: `limits.toml`.
use crate::{Failure, compiler::Needs};
use serde::Deserialize;
use std::collections::BTreeMap;

#[derive(Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Limits {
    /// Of every kernel, by the GPU's name of `RADV_FORCE_FAMILY`.
    pub gpus: BTreeMap<String, Limit>,
    /// Of some kernels, smaller ones.
    pub smaller: Vec<Smaller>,
    /// Names of kernels that no scene uses on a GPU.
    pub unused: Vec<String>,
    /// Ends of ids, before the tier, that few scenes use; so are kernels of a tier that a higher one has, too.
    pub seldom: Vec<String>,
    pub scenes: Vec<Scene>,
}

/// Most that a kernel may need; `None`: anything.
#[derive(Clone, Copy, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Limit {
    pub vgprs: Option<u64>,
    pub spilled: Option<u64>,
    /// [bytes]
    pub lds: Option<u64>,
    /// [bytes]
    pub code: Option<u64>,
    pub seconds: Option<f64>,
    /// That a lane reads [bytes], as `Traffic` counts.
    pub read: Option<u64>,
    /// That a lane writes to buffers [bytes].
    pub buffers: Option<u64>,
    /// That a lane writes to textures [bytes].
    pub textures: Option<u64>,
    /// Instructions of a visit.
    pub visit: Option<u64>,
}

#[derive(Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Smaller {
    /// Starts of ids, or whole ones.
    pub kernels: Vec<String>,
    /// The GPU that has the limit.
    pub gpu: String,
    pub limit: Limit,
}

/// Values of flags with which kernels are compiled; those that it does not name are as exported.
#[derive(Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Scene {
    pub name: String,
    /// Names of kernels. A kernel that no scene names is compiled once, as exported.
    pub kernels: Vec<String>,
    pub flags: BTreeMap<String, bool>,
    /// Whether it is compiled with `--all` alone.
    #[serde(default)]
    pub seldom: bool,
}

impl Limit {
    /// These, where `other` says nothing.
    fn under(self, other: Self) -> Self {
        Self {
            vgprs: other.vgprs.or(self.vgprs),
            spilled: other.spilled.or(self.spilled),
            lds: other.lds.or(self.lds),
            code: other.code.or(self.code),
            seconds: other.seconds.or(self.seconds),
            read: other.read.or(self.read),
            buffers: other.buffers.or(self.buffers),
            textures: other.textures.or(self.textures),
            visit: other.visit.or(self.visit),
        }
    }

    /// Name, value and limit of each quantity.
    fn beside(self, needs: &Needs) -> [(&'static str, f64, Option<f64>); 9] {
        let whole = |limit: Option<u64>| limit.map(|limit| limit as f64);
        let traffic = needs.traffic;
        [
            ("vgprs", needs.vgprs as f64, whole(self.vgprs)),
            ("spilled", needs.spilled as f64, whole(self.spilled)),
            ("lds", needs.lds as f64, whole(self.lds)),
            ("code", needs.code as f64, whole(self.code)),
            ("seconds", needs.seconds, self.seconds),
            ("read", traffic.read as f64, whole(self.read)),
            ("buffers", traffic.to_buffers as f64, whole(self.buffers)),
            ("textures", traffic.to_textures as f64, whole(self.textures)),
            ("visit", needs.visit.unwrap_or_default() as f64, whole(self.visit)),
        ]
    }
}

impl Limits {
    /// Those of `limits.toml`.
    pub fn read() -> Result<Self, Failure> {
        let limits = toml::from_str(include_str!("../limits.toml"));
        Ok(limits.map_err(|error| format!("limits.toml: {error}"))?)
    }

    /// A name of a GPU's smaller limits that is the start of none of `kernels`.
    pub fn unused<'a>(&'a self, gpu: &str, kernels: &[&str]) -> Option<&'a str> {
        let names = self.smaller.iter().filter(|it| it.gpu == gpu).flat_map(|it| &it.kernels);
        let mut unused = names.filter(|name| !kernels.iter().any(|it| it.starts_with(*name)));
        unused.next().map(String::as_str)
    }

    pub fn of(&self, gpu: &str, kernel: &str) -> Limit {
        let all = self.gpus.get(gpu).copied().unwrap_or_default();
        let smaller = self
            .smaller
            .iter()
            .filter(|it| it.gpu == gpu && it.kernels.iter().any(|start| kernel.starts_with(start)));
        smaller.fold(all, |limit, it| limit.under(it.limit))
    }

    /// What a kernel needs beyond its limits.
    pub fn complaints(&self, gpu: &str, kernel: &str, needs: &Needs) -> Vec<String> {
        let beyond = |(name, value, limit): (_, _, Option<f64>)| {
            let limit = limit.filter(|&limit| value > limit)?;
            Some(format!("{gpu}: {kernel}: {name} {value}, of {limit} at most"))
        };
        self.of(gpu, kernel).beside(needs).into_iter().filter_map(beyond).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::traffic::Traffic;

    const NEEDS: Needs = Needs {
        vgprs: 100,
        spilled: 3,
        lds: 0,
        waves: 8,
        instructions: 9,
        code: 50,
        traffic: Traffic { read: 16, to_buffers: 8, to_textures: 4 },
        visit: Some(7),
        seconds: 1.0,
    };

    const LIMITS: &str = "unused = []\nseldom = []\nscenes = []\n\
        smaller = [{ kernels = [\"curve\"], gpu = \"a\", limit = { vgprs = 96, read = 15, buffers = 7, textures = 0, visit = 6 } }]\n\
        [gpus.a]\nvgprs = 112\nspilled = 0\nlds = 0\ncode = 60\nseconds = 4.0\n";

    #[test]
    fn what_exceeds_a_limit_is_named() {
        let limits: Limits = toml::from_str(LIMITS).unwrap();
        assert_eq!(limits.complaints("a", "disc", &NEEDS), ["a: disc: spilled 3, of 0 at most"]);
        assert_eq!(limits.complaints("b", "disc", &NEEDS), [""; 0]);
        assert_eq!(
            limits.complaints("a", "curve", &NEEDS),
            [
                "a: curve: vgprs 100, of 96 at most",
                "a: curve: spilled 3, of 0 at most",
                "a: curve: read 16, of 15 at most",
                "a: curve: buffers 8, of 7 at most",
                "a: curve: textures 4, of 0 at most",
                "a: curve: visit 7, of 6 at most"
            ]
        );
        assert_eq!(limits.unused("a", &["disc", "curve_tiles"]), None);
        assert_eq!(limits.unused("a", &["disc"]), Some("curve"));
        let slow = Needs { seconds: 4.5, code: 61, lds: 1, spilled: 0, ..NEEDS };
        assert_eq!(limits.complaints("a", "disc", &slow).len(), 3);
    }
}
