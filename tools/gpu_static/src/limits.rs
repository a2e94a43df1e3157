//! What kernels may need on a GPU: `limits.toml`.
use crate::{Failure, compiler::Needs};
use serde::Deserialize;
use std::{collections::BTreeMap, path::Path};

#[derive(Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Limits {
    /// Of every kernel, by the GPU's name of `RADV_FORCE_FAMILY`.
    pub gpus: BTreeMap<String, Limit>,
    /// Of some kernels, smaller ones.
    pub smaller: Vec<Smaller>,
    /// Names of kernels that no scene uses on a GPU.
    pub unused: Vec<String>,
    /// Ends of ids, before `_native`, that few scenes use.
    pub seldom: Vec<String>,
    pub scenes: Vec<Scene>,
    #[serde(default)]
    pub exceptions: Vec<Exception>,
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
}

/// Kernels that need more than the limit.
#[derive(Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Exception {
    pub reason: String,
    pub kernels: Vec<Allowed>,
}

/// What a kernel needs today on a GPU, where that is more than the limit.
#[derive(Clone, Deserialize)]
pub struct Allowed {
    pub id: String,
    pub gpu: String,
    #[serde(flatten)]
    pub limit: Limit,
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
        }
    }

    /// Name, value and limit of each quantity.
    fn beside(self, needs: &Needs) -> [(&'static str, f64, Option<f64>); 5] {
        let whole = |limit: Option<u64>| limit.map(|limit| limit as f64);
        [
            ("vgprs", needs.vgprs as f64, whole(self.vgprs)),
            ("spilled", needs.spilled as f64, whole(self.spilled)),
            ("lds", needs.lds as f64, whole(self.lds)),
            ("code", needs.code as f64, whole(self.code)),
            ("seconds", needs.seconds, self.seconds),
        ]
    }
}

impl Limits {
    pub fn read(path: &Path) -> Result<Self, Failure> {
        let at = |error: &dyn std::fmt::Display| format!("{}: {error}", path.display());
        let text = std::fs::read_to_string(path).map_err(|error| at(&error))?;
        Ok(toml::from_str(&text).map_err(|error| at(&error))?)
    }

    /// Without exceptions.
    pub fn of(&self, gpu: &str, kernel: &str) -> Limit {
        let all = self.gpus.get(gpu).copied().unwrap_or_default();
        let smaller = self.smaller.iter().filter(|it| {
            it.gpu == gpu && it.kernels.iter().any(|start| kernel.starts_with(start))
        });
        smaller.fold(all, |limit, it| limit.under(it.limit))
    }

    /// What is wrong with a kernel: needs beyond a limit, and exceptions that allow more than is needed.
    pub fn complaints(&self, gpu: &str, kernel: &str, needs: &Needs) -> Vec<String> {
        let limit = self.of(gpu, kernel).beside(needs);
        let mut exceptions = self.exceptions.iter().flat_map(|it| &it.kernels);
        let own = exceptions.find(|it| it.id == kernel && it.gpu == gpu);
        let allowed = own.map_or(Limit::default(), |it| it.limit).beside(needs);
        let judge = |((name, value, limit), (_, _, allowed)): (
            (_, f64, Option<f64>),
            (_, _, Option<f64>),
        )| {
            let fits = limit.is_none_or(|limit| value <= limit);
            // The clock is no measure of the kernel alone.
            let is_timed = name == "seconds";
            match allowed {
                None if !fits => {
                    Some(format!("{name} {value}, of {} at most", limit.unwrap_or_default()))
                }
                Some(allowed) if value > allowed => {
                    Some(format!("{name} {value}, by exception {allowed} at most"))
                }
                Some(_) if fits && !is_timed => {
                    Some(format!("{name} {value} fits: its exception is needless"))
                }
                Some(allowed) if value < allowed && !is_timed => {
                    Some(format!("{name} {value}: its exception allows {allowed}, lower it"))
                }
                _ => None,
            }
        };
        let said = limit.into_iter().zip(allowed).filter_map(judge);
        said.map(|it| format!("{gpu}: {kernel}: {it}")).collect()
    }

    /// The reason and the line of `limits.toml` of a kernel's exception, as far as it is due.
    pub fn exception(&self, gpu: &str, kernel: &str, needs: &Needs) -> Option<(&str, String)> {
        let beyond = self.of(gpu, kernel).beside(needs).into_iter();
        let beyond = beyond.filter(|&(_, value, limit)| limit.is_some_and(|limit| value > limit));
        let values: Vec<_> = beyond
            .map(|(name, value, _)| {
                let room = if name == "seconds" { (1.5 * value).ceil() } else { value };
                format!("{name} = {room}")
            })
            .collect();
        let is_own = |it: &Allowed| it.id == kernel && it.gpu == gpu;
        let own = self.exceptions.iter().find(|it| it.kernels.iter().any(is_own));
        let line = format!("    {{ id = \"{kernel}\", gpu = \"{gpu}\", {} }},", values.join(", "));
        (!values.is_empty()).then_some((own.map_or("", |it| it.reason.as_str()), line))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const NEEDS: Needs =
        Needs { vgprs: 100, spilled: 3, lds: 0, waves: 8, instructions: 9, code: 50, seconds: 1.0 };

    fn limits(exceptions: &str) -> Limits {
        let text = "unused = []\nseldom = []\nscenes = []\nexceptions = [EXCEPTIONS]\n\
             smaller = [{ kernels = [\"curve\"], gpu = \"a\", limit = { vgprs = 96 } }]\n\
             [gpus.a]\nvgprs = 112\nspilled = 0\nlds = 0\ncode = 60\nseconds = 4.0\n";
        toml::from_str(&text.replace("EXCEPTIONS", exceptions)).unwrap()
    }

    #[test]
    fn what_exceeds_a_limit_is_named() {
        let none = limits("");
        assert_eq!(none.complaints("a", "disc", &NEEDS), ["a: disc: spilled 3, of 0 at most"]);
        assert_eq!(none.complaints("b", "disc", &NEEDS), [""; 0]);
        assert_eq!(
            none.complaints("a", "curve", &NEEDS),
            ["a: curve: vgprs 100, of 96 at most", "a: curve: spilled 3, of 0 at most"]
        );
        let slow = Needs { seconds: 4.5, code: 61, lds: 1, spilled: 0, ..NEEDS };
        assert_eq!(none.complaints("a", "disc", &slow).len(), 3);
    }

    #[test]
    fn exceptions_only_shrink() {
        let with = |spilled: u64| {
            limits(&format!(
                "{{ reason = \"\", kernels = [{{ id = \"disc\", gpu = \"a\", spilled = {spilled} }}] }}"
            ))
        };
        assert_eq!(with(3).complaints("a", "disc", &NEEDS), [""; 0]);
        assert_eq!(
            with(2).complaints("a", "disc", &NEEDS),
            ["a: disc: spilled 3, by exception 2 at most"]
        );
        assert_eq!(
            with(4).complaints("a", "disc", &NEEDS),
            ["a: disc: spilled 3: its exception allows 4, lower it"]
        );
        let none = Needs { spilled: 0, ..NEEDS };
        assert_eq!(
            with(4).complaints("a", "disc", &none),
            ["a: disc: spilled 0 fits: its exception is needless"]
        );
        assert_eq!(with(3).complaints("a", "other", &NEEDS).len(), 1);
    }
}
