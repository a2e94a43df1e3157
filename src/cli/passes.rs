//! `passes.json`: the passes that make a frame's maps from the exported kernels, by the tables that the
//! library itself records from. Format: `docs/export.md`.
use super::{
    export::{cuts, id},
    failure::Failure,
    specialise,
    structs::structs,
};
use gobo::{
    error::Error,
    gpu::{KernelDesc, Tier},
    records::{DEPTH_BITS, ROW},
    shadows::frame::{
        Groups, KEYS, PAIRS, ResourceChoice, Role, STEPS, SortOf, Step, Trait, Variants, When,
        Work,
        resources::{Initial, Kind, RESOURCES, ResourceDesc, SUMS},
        variants,
    },
    stage::{
        bin,
        formula::{
            Formula::{self, Is, Of},
            Number,
        },
        sort::{self, Shape},
    },
};
use serde_json::{Map, Value, json};

/// Lists of a batch, and whether they filter light.
const LISTS: [(&str, bool); 2] = [("blocking", false), ("filtering", true)];

pub(super) fn passes() -> Result<Value, Failure> {
    let mut book = Book::default();
    let mut lists = Vec::new();
    for (name, filters) in LISTS {
        let steps: Vec<_> = STEPS
            .iter()
            .filter(|step| filters || !step.when.contains(&When::Tiny))
            .map(|step| book.step(step, filters))
            .collect::<Result<_, _>>()?;
        lists.push(json!({ "name": name, "steps": steps }));
    }
    let resources: Vec<_> = RESOURCES.iter().map(|it| book.resource(it)).collect();
    let profiles = [
        ("wide", "GPUs", Shape::Wide, sort::MOST_BITS, &["wide"][..]),
        ("serial", "software adapters", Shape::Serial, sort::FEW_BITS, &[]),
        (
            "long",
            "software adapters, from about a million pairs",
            Shape::Serial,
            sort::MOST_BITS,
            &["long"],
        ),
    ];
    let profiles: Vec<_> = profiles
        .into_iter()
        .map(|(name, of, shape, digit_bits, traits)| {
            let cut = bin::numbers(shape)
                .with(Number::SortLanes, shape.lanes())
                .with(Number::DigitBits, digit_bits);
            let given = [Number::BinLanes, Number::UsualRuns, Number::SortLanes, Number::DigitBits];
            let numbers: Map<_, _> =
                given.iter().map(|&it| (it.name().to_owned(), cut.get(it).into())).collect();
            json!({
                "name": name, "for": of, "traits": traits, "numbers": numbers,
                "partition_limit": book.formula(&shape.partitions()),
            })
        })
        .collect();
    let named = |all: &[(&str, &str)]| -> Value {
        all.iter()
            .map(|&(name, meaning)| (name.to_owned(), meaning.into()))
            .collect::<Map<_, _>>()
            .into()
    };
    let numbers: Vec<_> = Number::ALL.iter().map(|it| (it.name(), it.meaning())).collect();
    let whens: Vec<_> = When::ALL.iter().map(|it| (it.name(), it.meaning())).collect();
    let mut traits: Vec<_> = Trait::ALL.iter().map(|it| (it.name(), it.meaning())).collect();
    traits.extend([("wide", "as the profile says"), ("long", "as the profile says")]);
    let ids: Map<_, _> = specialise::ids().map(|(name, id)| (name.to_owned(), id.into())).collect();
    Ok(json!({
        "gobo": env!("CARGO_PKG_VERSION"),
        "numbers": named(&numbers),
        "definitions": book.definitions,
        "conditions": named(&whens),
        "traits": named(&traits),
        "profiles": profiles,
        "specialisation": ids,
        "resources": resources,
        "structs": structs(&book.kernels)?,
        "lists": lists,
    }))
}

/// Definitions and kernels that steps and resources refer to.
#[derive(Default)]
struct Book {
    /// Name and formula, parts first.
    definitions: Vec<Value>,
    kernels: Vec<&'static KernelDesc>,
}

impl Book {
    fn formula(&mut self, formula: &Formula) -> String {
        for part in formula.parts() {
            if let Formula::Named(name, of) = part
                && !self.definitions.iter().any(|known| known["name"] == name)
            {
                self.definitions.push(json!({ "name": name, "formula": of.to_string() }));
            }
        }
        formula.to_string()
    }

    fn formulas(&mut self, formulas: &[Formula]) -> Vec<String> {
        formulas.iter().map(|it| self.formula(it)).collect()
    }

    fn step(&mut self, step: &Step, filters: bool) -> Result<Value, Failure> {
        let when: Vec<_> = step.when.iter().map(|when| when.name()).collect();
        Ok(match step.work {
            Work::Clear(all) => {
                let names: Vec<_> = all.iter().map(|it| it.name()).collect();
                json!({ "when": when, "clear": names })
            }
            Work::Sort(of) => self.sort(&when, of),
            Work::Kernel { role, groups, sources } => {
                let variants = variants(role, filters);
                let bind = bindings(&variants, sources)?;
                let mut step = json!({
                    "when": when,
                    "role": role.name(),
                    "kernels": self.variants(role, variants),
                    "bind": bind,
                });
                match groups {
                    Groups::Counts(groups) => step["groups"] = self.formulas(&groups).into(),
                    Groups::Indirect(dispatch) => {
                        step["indirect"] =
                            json!({ "buffer": "dispatches", "offset": dispatch.offset() });
                    }
                }
                step
            }
        })
    }

    /// Steps of a sort, one per digit.
    fn sort(&mut self, when: &[&str], of: SortOf) -> Value {
        let (name, names, bits, capacity) = match of {
            SortOf::Depth => ("depth", KEYS, Is(DEPTH_BITS.into()), Of(Number::FootprintCount)),
            SortOf::Tile => ("tile", PAIRS, bin::TILE_BITS, Of(Number::PairCapacity)),
        };
        let counts = match of {
            SortOf::Depth => "depth_count",
            SortOf::Tile => "counters",
        };
        let [a, b] = names;
        let bind = json!({
            "sort_pass": { "digit": format!("{name}_pass") },
            "counts": counts,
            "histograms": format!("{name}_histograms"),
            "pairs": { "digits": [a, b] },
            "sorted_pairs": { "digits": [b, a] },
        });
        let steps = [
            ([&sort::WIDE_COUNT, &sort::LONG_COUNT, &sort::SERIAL_COUNT], sort::PARTITION_GROUPS),
            ([&sort::WIDE_SCAN, &sort::SERIAL_SCAN, &sort::SERIAL_SCAN], sort::SCAN_GROUPS),
            (
                [&sort::WIDE_SCATTER, &sort::LONG_SCATTER, &sort::SERIAL_SCATTER],
                sort::PARTITION_GROUPS,
            ),
        ];
        let steps: Vec<_> = steps
            .into_iter()
            .map(|(kernels, groups)| {
                let whens = [&["wide"][..], &["long"], &[]];
                let kernels: Vec<_> = kernels
                    .into_iter()
                    .zip(whens)
                    .map(|(desc, traits)| self.choice(desc, "", traits, None))
                    .collect();
                let all = self.formulas(&groups);
                json!({ "kernels": kernels, "groups": all, "bind": bind })
            })
            .collect();
        json!({
            "when": when,
            "sort": name,
            "numbers": {
                "key_bits": self.formula(&bits),
                "sort_capacity": self.formula(&capacity),
            },
            "repeat": self.formula(&sort::DIGITS),
            "steps": steps,
        })
    }

    /// Variants in order: the first whose traits and nodes a list has is used.
    fn variants(&mut self, role: Role, variants: Variants) -> Vec<Value> {
        let mut choices = match role {
            Role::BinCount => vec![self.choice(&bin::WIDE_COUNT, "", &["wide"], None)],
            Role::BinEmit => vec![self.choice(&bin::WIDE_EMIT, "", &["wide"], None)],
            _ => Vec::new(),
        };
        for (traits, desc) in
            variants.special.iter().copied().chain([(&[][..], variants.otherwise)])
        {
            let names: Vec<_> = traits.iter().map(|it| it.name()).collect();
            for cut in cuts(desc).iter().rev() {
                let nodes = [&cut.constants, desc.constants].concat();
                let nodes =
                    nodes.iter().find(|(name, _)| *name == "NODES").map(|(_, nodes)| *nodes as u32);
                choices.push(self.choice(desc, cut.suffix, &names, nodes));
            }
        }
        debug_assert!(!choices.is_empty(), "{}", role.name());
        choices
    }

    fn choice(
        &mut self,
        desc: &'static KernelDesc,
        suffix: &str,
        traits: &[&str],
        nodes: Option<u32>,
    ) -> Value {
        if !self.kernels.iter().any(|known| known.name == desc.name) {
            self.kernels.push(desc);
        }
        let mut choice = json!({ "traits": traits });
        if let Some(nodes) = nodes {
            choice["nodes"] = nodes.into();
        }
        // A kernel with a single tier runs on both.
        for (name, tier) in [("core", Tier::Core), ("native", Tier::Native)] {
            let tier = if desc.tiers.contains(&tier) { tier } else { desc.tiers[0] };
            choice[name] = id(desc, suffix, tier).into();
        }
        choice
    }

    fn resource(&mut self, resource: &ResourceDesc) -> Value {
        let format = |format| format!("{format:?}").to_lowercase();
        let mut value = match resource.kind {
            Kind::Storage { element, count } => json!({
                "kind": "storage", "element_size": element, "count": self.formula(&count),
            }),
            Kind::Uniform { fields } => {
                json!({ "kind": "uniform", "words": self.formulas(fields) })
            }
            Kind::Words { words } => {
                json!({ "kind": "storage", "words": self.formulas(words) })
            }
            Kind::UniformOfDigits { fields, sort } => json!({
                "kind": "uniform", "per_digit": true, "sort": sort.name(),
                "words": self.formulas(fields),
            }),
            Kind::HostUniform { size } => json!({ "kind": "uniform", "size": size }),
            Kind::Records { format: of, texels } => {
                let texels = self.formula(&texels);
                records(&format(of), &texels)
            }
            Kind::Texture { format: of, size, sort } => {
                let [width, height] = size.map(|it| self.formula(&it));
                json!({
                    "kind": "texture", "format": format(of), "sort": sort.name(),
                    "width": width, "height": height,
                })
            }
            Kind::Array { format: of, size } => {
                let [width, height, layers] = size.map(|it| self.formula(&it));
                json!({
                    "kind": "texture_array", "format": format(of),
                    "width": width, "height": height, "layers": layers,
                })
            }
        };
        value["name"] = resource.name.into();
        value["initial"] = match resource.initial {
            Initial::Any => "any",
            Initial::Zero => "zero, by a step of each list",
            Initial::ZeroOnce => "zero, before the first frame",
            Initial::One => "any, or one: then a blocking list without casters may be left out",
            Initial::Host => match resource.kind {
                Kind::Words { .. } | Kind::Uniform { .. } | Kind::UniformOfDigits { .. } => {
                    "its words"
                }
                _ => "the host's",
            },
        }
        .into();
        if !resource.note.is_empty() {
            value["note"] = resource.note.into();
        }
        if let (true, Kind::Storage { count, .. }) = (SUMS.contains(&resource.name), resource.kind)
        {
            value["native"] = records("r32uint", &count.to_string());
        }
        value
    }
}

/// A texture of records.
fn records(format: &str, texels: &str) -> Value {
    let height = format!("div_up({texels}, {ROW})");
    json!({ "kind": "texture", "format": format, "width": ROW.to_string(), "height": height })
}

/// Union of the bindings of a kernel's variants.
fn bindings(
    variants: &Variants,
    sources: &[(&'static str, ResourceChoice)],
) -> Result<Map<String, Value>, Failure> {
    let mut bound = Map::new();
    let descs = variants.special.iter().map(|&(_, desc)| desc).chain([variants.otherwise]);
    for desc in descs {
        for &tier in desc.tiers {
            let linked = desc.link(tier).map_err(Error::from)?;
            for binding in linked.bindings().map_err(Error::from)? {
                let source = sources.iter().find(|(name, _)| *name == binding.name);
                let source = match source.map(|(_, source)| *source) {
                    None => binding.name.into(),
                    Some(ResourceChoice::Is(name)) => name.into(),
                    Some(ResourceChoice::Sorted(names, SortOf::Depth)) => {
                        json!({ "sorted": "depth", "of": names })
                    }
                    Some(ResourceChoice::Sorted(names, SortOf::Tile)) => {
                        json!({ "sorted": "tile", "of": names })
                    }
                    Some(ResourceChoice::Curves(a, b)) => {
                        json!({ "trait": "curves", "then": a, "otherwise": b })
                    }
                    Some(ResourceChoice::Composed(a, b)) => {
                        json!({ "trait": "composed", "then": a, "otherwise": b })
                    }
                };
                bound.insert(binding.name.to_owned(), source);
            }
        }
    }
    Ok(bound)
}
