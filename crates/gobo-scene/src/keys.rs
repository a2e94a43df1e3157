//! A table of the scene file while it is read. The place that reads a key declares its name, default and
//! range.
use super::{
    SceneError,
    error::quoted,
    numbers::array,
    plain::{kind_of, nearest},
    source::SceneText,
};
use glam::Vec3;
use gobo::model::{MAX_MAP_SIZE, MIN_MAP_SIZE};
use serde::Deserialize;
use std::{
    cell::RefCell,
    fmt::Display,
    ops::{Range, RangeInclusive},
};
use toml::{
    Spanned,
    de::{DeTable, DeValue, Error, ValueDeserializer},
};

/// Least number above 0.
pub(super) const ABOVE_ZERO: f32 = f32::from_bits(1);

/// Dotted name of a table's key.
pub(super) fn dotted(table: &str, key: &str) -> String {
    if table.is_empty() { key.to_owned() } else { format!("{table}.{key}") }
}

pub(super) struct Keys<'a> {
    source: &'a SceneText<'a>,
    /// Dotted key of the table; empty for the whole file.
    path: String,
    /// The same with indices in lists, as the command line names it.
    place: String,
    table: &'a DeTable<'a>,
    span: Range<usize>,
    /// Keys that readers requested.
    known: RefCell<Vec<&'a str>>,
}

impl<'a> Keys<'a> {
    /// Reads the whole file.
    pub(super) fn of_file<T>(
        source: &'a SceneText<'a>,
        read: impl FnOnce(&Self) -> Result<T, SceneError>,
    ) -> Result<T, SceneError> {
        let (path, place) = (String::new(), String::new());
        let (table, known) = (source.tree(), RefCell::default());
        let keys = Self { source, path, place, table, span: 0..0, known };
        keys.finished(read)
    }

    /// Refuses keys that `read` does not ask for.
    fn finished<T>(
        &self,
        read: impl FnOnce(&Self) -> Result<T, SceneError>,
    ) -> Result<T, SceneError> {
        let value = read(self)?;
        let mut known = self.known.borrow_mut();
        known.sort_unstable();
        known.dedup();
        match self.table.keys().find(|key| !known.contains(&key.get_ref().as_ref())) {
            None => Ok(value),
            Some(key) => {
                let help = nearest(key.get_ref(), known.iter().copied());
                let message = format!("there is no key {} here", quoted(key.get_ref()));
                let help = help.unwrap_or_else(|| "remove it".to_owned());
                Err(self.source.error(key.span(), message, Some(help)))
            }
        }
    }

    fn get(&self, key: &'static str) -> Option<&'a Spanned<DeValue<'a>>> {
        self.known.borrow_mut().push(key);
        self.source.ask(&self.place, key);
        self.table.get(key)
    }

    pub(super) fn has(&self, key: &'static str) -> bool {
        self.get(key).is_some()
    }

    /// An error at the value of `key`, or at the table if the key is missing.
    pub(super) fn fault(&self, key: &str, message: impl Into<String>, help: &str) -> SceneError {
        let span = self.table.get(key).map_or_else(|| self.span.clone(), Spanned::span);
        let help = (!help.is_empty()).then(|| help.to_owned());
        self.source.error(span, message, help)
    }

    fn read<T>(
        &self,
        key: &'static str,
        read: impl FnOnce(ValueDeserializer<'a>) -> Result<T, Error>,
    ) -> Result<Option<T>, SceneError> {
        let Some(value) = self.get(key) else { return Ok(None) };
        let read = read(ValueDeserializer::from(value.clone()));
        read.map(Some).map_err(|error| self.source.explain(&error, value.span()))
    }

    pub(super) fn given<T: Deserialize<'a>>(
        &self,
        key: &'static str,
    ) -> Result<Option<T>, SceneError> {
        self.read(key, T::deserialize)
    }

    pub(super) fn value<T: Deserialize<'a>>(
        &self,
        key: &'static str,
        usual: T,
    ) -> Result<T, SceneError> {
        Ok(self.given(key)?.unwrap_or(usual))
    }

    pub(super) fn required<T: Deserialize<'a>>(&self, key: &'static str) -> Result<T, SceneError> {
        self.need(key, self.given(key)?)
    }

    /// The value of a required key.
    pub(super) fn need<T>(&self, key: &str, value: Option<T>) -> Result<T, SceneError> {
        value.ok_or_else(|| {
            let help = format!("add `{key} = ...`");
            self.source.error(self.span.clone(), format!("the key `{key}` is missing"), Some(help))
        })
    }

    /// Exactly N numbers.
    pub(super) fn array<T: Deserialize<'a>, const N: usize>(
        &self,
        key: &'static str,
    ) -> Result<Option<[T; N]>, SceneError> {
        self.read(key, array)
    }

    /// All keys of the table at once.
    pub(super) fn all<T: Deserialize<'a>>(&self) -> Result<T, SceneError> {
        let table = DeValue::Table(self.table.clone());
        let table = Spanned::new(self.span.clone(), table);
        let keys = || self.table.keys().map(|key| key.get_ref().as_ref());
        self.known.borrow_mut().extend(keys());
        keys().for_each(|key| self.source.ask(&self.place, key));
        T::deserialize(ValueDeserializer::from(table))
            .map_err(|error| self.source.explain(&error, self.span.clone()))
    }

    /// The table of a key.
    pub(super) fn one<T>(
        &self,
        key: &'static str,
        read: impl FnOnce(&Self) -> Result<T, SceneError>,
    ) -> Result<Option<Spanned<T>>, SceneError> {
        let help = match &self.path[..] {
            "" => format!("write its keys below [{key}]"),
            _ => format!("write a table: {key} = {{ ... }}"),
        };
        let of = |value| self.inner(key, None, value, help)?.finished(read);
        self.get(key).map(|value| Ok(Spanned::new(value.span(), of(value)?))).transpose()
    }

    /// The tables of a key.
    pub(super) fn many<T>(
        &self,
        key: &'static str,
        mut read: impl FnMut(&Self) -> Result<T, SceneError>,
    ) -> Result<Vec<Spanned<T>>, SceneError> {
        let Some(value) = self.get(key) else { return Ok(Vec::new()) };
        let help = || format!("write each as a table below [[{}]]", self.path_of(key));
        let DeValue::Array(items) = value.get_ref() else {
            return Err(self.no_table(key, value, help()));
        };
        let mut of = |index, item: &'a Spanned<_>| {
            self.inner(key, Some(index), item, help())?.finished(&mut read)
        };
        let of = |(index, item): (usize, &'a Spanned<_>)| {
            Ok(Spanned::new(item.span(), of(index, item)?))
        };
        items.iter().enumerate().map(of).collect()
    }

    fn path_of(&self, key: &str) -> String {
        dotted(&self.path, key)
    }

    fn inner(
        &self,
        key: &str,
        index: Option<usize>,
        value: &'a Spanned<DeValue<'a>>,
        help: String,
    ) -> Result<Self, SceneError> {
        let DeValue::Table(table) = value.get_ref() else {
            return Err(self.no_table(key, value, help));
        };
        let (source, path, span) = (self.source, self.path_of(key), value.span());
        let mut place = dotted(&self.place, key);
        if let Some(index) = index {
            place = dotted(&place, &index.to_string());
        }
        Ok(Self { source, path, place, table, span, known: RefCell::default() })
    }

    fn no_table(&self, key: &str, value: &Spanned<DeValue<'_>>, help: String) -> SceneError {
        let path = self.path_of(key);
        let message = match value.get_ref() {
            DeValue::Table(_) => format!("`{path}` is a single table here, not a list of tables"),
            other => format!("`{path}` is {} here, not a table", kind_of(other)),
        };
        self.source.error(value.span(), message, Some(help))
    }

    /// A whole number in a range.
    pub(super) fn whole<T: Deserialize<'a> + PartialOrd + Display>(
        &self,
        key: &'static str,
        usual: T,
        range: RangeInclusive<T>,
        help: &str,
    ) -> Result<T, SceneError> {
        match self.given(key)? {
            Some(value) if !range.contains(&value) => {
                Err(self.fault(key, format!("{key} is {value}"), help))
            }
            value => Ok(value.unwrap_or(usual)),
        }
    }

    /// A number in a range, with the range in words.
    pub(super) fn number(
        &self,
        key: &'static str,
        range: RangeInclusive<f32>,
        words: &str,
    ) -> Result<Option<f32>, SceneError> {
        let value = self.given(key)?;
        value.map_or(Ok(()), |value| self.check(key, &[value], range, words))?;
        Ok(value)
    }

    /// Checks numbers of a key.
    pub(super) fn check(
        &self,
        key: &str,
        values: &[f32],
        range: RangeInclusive<f32>,
        words: &str,
    ) -> Result<(), SceneError> {
        match values.iter().find(|value| !value.is_finite() || !range.contains(value)) {
            None => Ok(()),
            Some(value) => {
                let help = format!("{key} must be {words}");
                Err(self.fault(key, format!("{key} is {value}"), &help))
            }
        }
    }

    pub(super) fn share(&self, key: &'static str, usual: f32) -> Result<f32, SceneError> {
        Ok(self.number(key, 0.0..=1.0, "from 0 to 1")?.unwrap_or(usual))
    }

    /// A number in a range that needs no words.
    pub(super) fn within(
        &self,
        key: &'static str,
        usual: f32,
        range: RangeInclusive<f32>,
    ) -> Result<f32, SceneError> {
        let words = format!("{} to {}", range.start(), range.end());
        Ok(self.number(key, range, &words)?.unwrap_or(usual))
    }

    /// A bias \[m\] or \[texels\]; no scene is larger than its limit.
    pub(super) fn bias(&self, key: &'static str) -> Result<Option<f32>, SceneError> {
        self.number(key, 0.0..=1e7, "0 to 1e7")
    }

    /// Three numbers in a range, such as a colour.
    pub(super) fn three(
        &self,
        key: &'static str,
        range: RangeInclusive<f32>,
        words: &str,
    ) -> Result<Option<Vec3>, SceneError> {
        let values = self.array::<f32, 3>(key)?;
        self.check(key, values.as_ref().map_or(&[], |values| values), range, words)?;
        Ok(values.map(Vec3::from))
    }

    pub(super) fn vector(&self, key: &'static str) -> Result<Option<Vec3>, SceneError> {
        self.three(key, -1e7..=1e7, "finite and within 1e7")
    }

    pub(super) fn direction(&self, key: &'static str) -> Result<Option<Vec3>, SceneError> {
        let Some(vector) = self.vector(key)? else { return Ok(None) };
        // Squares of short vectors would underflow.
        let direction = (vector / vector.abs().max_element()).try_normalize();
        let fault = || self.fault(key, format!("{key} has no length"), "give it a direction");
        direction.ok_or_else(fault).map(Some)
    }

    /// Converts \[degrees\] to \[radians\]; the limits keep its tangent finite in 32 bits.
    pub(super) fn angle(&self, key: &'static str) -> Result<Option<f32>, SceneError> {
        let degrees = self.number(key, 0.01..=179.9, "between 0 and 180 (0.01 to 179.9)")?;
        Ok(degrees.map(f32::to_radians))
    }

    /// Edge of a map \[texels\].
    pub(super) fn map_size(&self) -> Result<Option<u32>, SceneError> {
        let help = format!("a map is {MIN_MAP_SIZE} to {MAX_MAP_SIZE} texels wide");
        let size = self.whole("size", 0, MIN_MAP_SIZE..=MAX_MAP_SIZE, &help)?;
        Ok(Some(size).filter(|&size| size > 0))
    }
}
