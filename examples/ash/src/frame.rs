//! Runs a frame as `passes.json` says.
use crate::{
    Failure,
    formula::Numbers,
    kernel::{Groups, Kernel, Resource},
    vulkan::{Buffer, Format, Vulkan},
};
use ash::vk;
use serde_json::Value;
use std::{cell::RefCell, collections::HashMap, path::Path, rc::Rc};

/// What is run.
pub struct Frame<'a> {
    pub vulkan: &'a Vulkan,
    pub dir: &'a Path,
    pub manifest: &'a Value,
    pub passes: &'a Value,
    pub frame: &'a Value,
    /// `core` or `native`.
    pub tier: &'a str,
    /// Of `passes`.
    pub profile: &'a Value,
    /// Whether all conditions are taken to hold.
    pub all: bool,
    /// Those that are made.
    pub kernels: &'a Kernels,
}

/// By id and constants.
pub type Kernels = RefCell<HashMap<String, Rc<Kernel>>>;

/// What a list has at hand.
struct List<'a> {
    numbers: Numbers,
    resources: HashMap<String, Resource>,
    /// By name and digit.
    of_digits: HashMap<(String, u64), Buffer>,
    conditions: Vec<&'a str>,
    traits: Vec<&'a str>,
    value: &'a Value,
}

fn each(value: &Value) -> impl Iterator<Item = &Value> {
    value.as_array().into_iter().flatten()
}

fn texts(value: &Value) -> impl Iterator<Item = &str> {
    each(value).filter_map(Value::as_str)
}

/// The four maps, which all batches write.
pub const MAPS: [&str; 4] = ["filters", "nearests", "opaques", "curves"];

impl Frame<'_> {
    /// The maps by name.
    pub fn run(&self) -> Result<HashMap<String, Resource>, Failure> {
        let mut numbers = Numbers::new(&self.passes["definitions"]);
        numbers.add(&self.frame["numbers"]);
        numbers.add(&self.profile["numbers"]);
        numbers.add(&self.frame["batches"][0]["lists"][1]["numbers"]);
        let mut maps = HashMap::new();
        for resource in each(&self.passes["resources"]) {
            let name = resource["name"].as_str().unwrap_or_default();
            if MAPS.contains(&name) {
                maps.insert(name.to_owned(), self.make(resource, &numbers)?);
            }
        }
        for batch in each(&self.frame["batches"]) {
            let lists = each(&self.passes["lists"]).zip(each(&batch["lists"]));
            for (passes, list) in lists {
                self.run_list(passes, batch, list, &maps)?;
            }
        }
        Ok(maps)
    }

    fn run_list(
        &self,
        passes: &Value,
        batch: &Value,
        value: &Value,
        maps: &HashMap<String, Resource>,
    ) -> Result<(), Failure> {
        let mut numbers = Numbers::new(&self.passes["definitions"]);
        for given in [&self.frame["numbers"], &self.profile["numbers"], &value["numbers"]] {
            numbers.add(given);
        }
        let of_profile = texts(&self.profile["traits"]);
        let mut list = List {
            numbers,
            resources: maps.clone(),
            of_digits: HashMap::new(),
            conditions: texts(&value["conditions"]).collect(),
            traits: texts(&value["traits"]).chain(of_profile).collect(),
            value,
        };
        if self.all {
            let all = self.passes["conditions"].as_object().into_iter().flatten();
            list.conditions = all.map(|(name, _)| name.as_str()).collect();
        }
        for resource in each(&self.passes["resources"]) {
            self.add(resource, batch, &mut list)?;
        }
        let mut recorded = Vec::new();
        for step in each(&passes["steps"]) {
            if texts(&step["when"]).all(|when| list.conditions.contains(&when)) {
                self.step(step, &mut list, &mut recorded)?;
            }
        }
        self.vulkan.run(|commands| {
            for (record, set, groups) in &recorded {
                match record {
                    Recorded::Clear(buffer) => {
                        self.vulkan.barrier(commands);
                        // SAFETY: `commands` is being recorded.
                        unsafe {
                            let (buffer, size) = (buffer.buffer, vk::WHOLE_SIZE);
                            self.vulkan.device.cmd_fill_buffer(commands, buffer, 0, size, 0);
                        }
                    }
                    Recorded::Kernel(kernel) => kernel.record(self.vulkan, commands, *set, groups),
                }
            }
        })
    }

    /// Made and filled.
    fn add(&self, resource: &Value, batch: &Value, list: &mut List<'_>) -> Result<(), Failure> {
        let name = resource["name"].as_str().unwrap_or_default().to_owned();
        if MAPS.contains(&name.as_str()) {
            return Ok(());
        }
        let numbers = match resource["sort"].as_str() {
            Some(sort) => self.of_sort(sort, &list.numbers)?,
            None => list.numbers.clone(),
        };
        if resource["per_digit"] == true {
            for digit in 0..numbers.of(&self.sort_step(resource)?["repeat"])? {
                let mut numbers = numbers.clone();
                numbers.set("digit", digit);
                let Resource::Buffer(buffer) = self.make(resource, &numbers)? else { continue };
                list.of_digits.insert((name.clone(), digit), buffer);
            }
            return Ok(());
        }
        let made = self.make(resource, &numbers)?;
        list.resources.insert(name.clone(), made);
        let uploads = [&self.frame["uploads"], &batch["uploads"], &list.value["uploads"]];
        let file = uploads.iter().find_map(|it| it[&name].as_str());
        if let Some(file) = file {
            let bytes = std::fs::read(self.dir.join(file)).map_err(|e| format!("{file}: {e}"))?;
            match made {
                Resource::Buffer(buffer) => buffer.write(&bytes),
                Resource::Image(image) => self.vulkan.write_image(&image, &bytes)?,
            }
        }
        Ok(())
    }

    /// Of its size, with its words, or zero where it must be, or what nobody may read.
    fn make(&self, resource: &Value, numbers: &Numbers) -> Result<Resource, Failure> {
        let own = &resource[self.tier];
        let kind = if own.is_object() { own } else { resource };
        let is_zero = resource["initial"].as_str().is_some_and(|it| it.starts_with("zero, before"));
        let made = match kind["kind"].as_str().unwrap_or_default() {
            "storage" | "uniform" if resource["words"].is_array() => {
                let words = each(&resource["words"]).map(|it| Ok(numbers.of(it)? as u32));
                let words = words.collect::<Result<Vec<_>, Failure>>()?;
                let buffer = self.vulkan.buffer(words.len() as u64 * 4)?;
                buffer.write(&words.iter().flat_map(|it| it.to_le_bytes()).collect::<Vec<_>>());
                Resource::Buffer(buffer)
            }
            "uniform" => {
                Resource::Buffer(self.vulkan.buffer(kind["size"].as_u64().unwrap_or_default())?)
            }
            "storage" => {
                let element = kind["element_size"].as_u64().unwrap_or_default();
                let buffer = self.vulkan.buffer(numbers.of(&kind["count"])? * element)?;
                if is_zero {
                    buffer.write(&vec![0; buffer.size as usize]);
                }
                Resource::Buffer(buffer)
            }
            _ => {
                let layers =
                    if kind["layers"].is_string() { numbers.of(&kind["layers"])? } else { 1 };
                let size = [numbers.of(&kind["width"])?, numbers.of(&kind["height"])?, layers];
                let format = Format::named(kind["format"].as_str().unwrap_or_default())?;
                let image = self.vulkan.image(format, size.map(|edge| edge as u32))?;
                if is_zero {
                    self.vulkan.write_image(&image, &[])?;
                }
                Resource::Image(image)
            }
        };
        Ok(made)
    }

    /// The step that is a resource's sort.
    fn sort_step(&self, resource: &Value) -> Result<&Value, Failure> {
        let steps = each(&self.passes["lists"][0]["steps"]);
        let mut sorts = steps.filter(|step| step["sort"] == resource["sort"]);
        Ok(sorts.next().ok_or_else(|| format!("{} has no sort", resource["name"]))?)
    }

    /// What holds during a sort.
    fn of_sort(&self, sort: &str, numbers: &Numbers) -> Result<Numbers, Failure> {
        let mut steps = each(&self.passes["lists"][0]["steps"]);
        let step = steps.find(|step| step["sort"] == sort).ok_or("no such sort")?;
        let mut own = numbers.clone();
        for (name, formula) in step["numbers"].as_object().into_iter().flatten() {
            own.set(name, numbers.of(formula)?);
        }
        let partitions = own.of(&self.profile["partition_limit"])?;
        own.set("partition_limit", partitions);
        Ok(own)
    }

    fn step(
        &self,
        step: &Value,
        list: &mut List<'_>,
        recorded: &mut Vec<(Recorded, vk::DescriptorSet, Groups)>,
    ) -> Result<(), Failure> {
        for name in texts(&step["clear"]) {
            let Resource::Buffer(buffer) = list.resources[name] else { continue };
            let none = (vk::DescriptorSet::null(), Groups::Counts([0; 3]));
            recorded.push((Recorded::Clear(buffer), none.0, none.1));
        }
        if let Some(sort) = step["sort"].as_str() {
            let mut numbers = self.of_sort(sort, &list.numbers)?;
            for digit in 0..numbers.of(&step["repeat"])? {
                numbers.set("digit", digit);
                for part in each(&step["steps"]) {
                    self.kernel(part, list, &numbers, digit, recorded)?;
                }
            }
        } else if step["kernels"].is_array() {
            self.kernel(step, list, &list.numbers.clone(), 0, recorded)?;
        }
        Ok(())
    }

    fn kernel(
        &self,
        step: &Value,
        list: &mut List<'_>,
        numbers: &Numbers,
        digit: u64,
        recorded: &mut Vec<(Recorded, vk::DescriptorSet, Groups)>,
    ) -> Result<(), Failure> {
        let nodes = &list.value["numbers"]["nodes"];
        let fits = |choice: &&Value| {
            let has_traits = texts(&choice["traits"]).all(|it| list.traits.contains(&it));
            has_traits && (choice["nodes"].is_null() || choice["nodes"] == *nodes)
        };
        let choice = each(&step["kernels"]).find(fits).ok_or("no kernel fits")?;
        let id = choice[self.tier].as_str().unwrap_or_default();
        let constants = &list.value["constants"];
        let key = format!("{id} {constants}");
        let made = self.kernels.borrow().get(&key).cloned();
        let kernel = match made {
            Some(kernel) => kernel,
            None => {
                let entry = each(&self.manifest["kernels"]).find(|it| it["id"] == id);
                let entry = entry.ok_or_else(|| format!("there is no kernel {id}"))?;
                let kernel = Rc::new(Kernel::new(self.vulkan, self.dir, entry, constants)?);
                self.kernels.borrow_mut().insert(key, Rc::clone(&kernel));
                kernel
            }
        };
        let set = kernel.bind(self.vulkan, |binding| {
            self.resource(&step["bind"][binding], list, digit)
                .map_err(|error| format!("{id} binds {binding}: {error}").into())
        })?;
        let groups = match step["indirect"]["buffer"].as_str() {
            Some(buffer) => {
                let Resource::Buffer(buffer) = list.resources[buffer] else {
                    return Err("workgroup counts are in a buffer".into());
                };
                Groups::Indirect(buffer, step["indirect"]["offset"].as_u64().unwrap_or_default())
            }
            None => {
                let mut counts = [1; 3];
                for (count, formula) in counts.iter_mut().zip(each(&step["groups"])) {
                    *count = numbers.of(formula)? as u32;
                }
                Groups::Counts(counts)
            }
        };
        recorded.push((Recorded::Kernel(kernel), set, groups));
        Ok(())
    }

    /// What a step binds.
    fn resource(&self, source: &Value, list: &List<'_>, digit: u64) -> Result<Resource, Failure> {
        let of_parity = |names: &Value, number: u64| names[(number % 2) as usize].clone();
        let name = if let Some(name) = source["digit"].as_str() {
            let buffer = list.of_digits.get(&(name.to_owned(), digit)).ok_or("no such digit")?;
            return Ok(Resource::Buffer(*buffer));
        } else if source["digits"].is_array() {
            of_parity(&source["digits"], digit)
        } else if let Some(sort) = source["sorted"].as_str() {
            let numbers = self.of_sort(sort, &list.numbers)?;
            let step = self.sort_step(&serde_json::json!({ "sort": sort }))?;
            // A list without casters is not sorted.
            let is_sorted = texts(&step["when"]).all(|when| list.conditions.contains(&when));
            let digits = if is_sorted { numbers.of(&step["repeat"])? } else { 0 };
            of_parity(&source["of"], digits)
        } else if let Some(wanted) = source["trait"].as_str() {
            let has = list.traits.contains(&wanted);
            if has { source["then"].clone() } else { source["otherwise"].clone() }
        } else {
            source.clone()
        };
        let name = name.as_str().ok_or("nobody says what it is")?;
        Ok(*list.resources.get(name).ok_or_else(|| format!("there is no {name}"))?)
    }
}

enum Recorded {
    Clear(Buffer),
    Kernel(Rc<Kernel>),
}
