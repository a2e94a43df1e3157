//! The formulas of `passes.json`: numbers, names, `(a + b)` and the like, and functions.
use crate::Failure;
use serde_json::Value;
use std::collections::HashMap;

/// What names stand for.
#[derive(Clone, Default)]
pub struct Numbers {
    pub values: HashMap<String, u64>,
    /// Formulas by name.
    pub definitions: HashMap<String, String>,
}

impl Numbers {
    pub fn new(definitions: &Value) -> Self {
        let all = definitions.as_array().into_iter().flatten();
        let text = |it: &Value| it.as_str().unwrap_or_default().to_owned();
        let definitions = all.map(|it| (text(&it["name"]), text(&it["formula"]))).collect();
        Self { values: HashMap::new(), definitions }
    }

    pub fn add(&mut self, numbers: &Value) {
        for (name, value) in numbers.as_object().into_iter().flatten() {
            self.set(name, value.as_u64().unwrap_or_default());
        }
    }

    pub fn set(&mut self, name: &str, value: u64) {
        self.values.insert(name.to_owned(), value);
    }

    pub fn eval(&self, formula: &str) -> Result<u64, Failure> {
        let mut reader = Reader { numbers: self, rest: formula };
        let value = reader.term()?;
        match reader.rest.trim() {
            "" => Ok(value),
            rest => Err(format!("{formula:?}: what is {rest:?}?").into()),
        }
    }

    /// A string of JSON.
    pub fn of(&self, formula: &Value) -> Result<u64, Failure> {
        self.eval(formula.as_str().ok_or_else(|| format!("{formula} is no formula"))?)
    }

    fn name(&self, name: &str) -> Result<u64, Failure> {
        match (self.values.get(name), self.definitions.get(name)) {
            (Some(&value), _) => Ok(value),
            (None, Some(formula)) => self.eval(formula),
            (None, None) => Err(format!("nobody says what {name} is").into()),
        }
    }
}

struct Reader<'a> {
    numbers: &'a Numbers,
    rest: &'a str,
}

impl Reader<'_> {
    fn term(&mut self) -> Result<u64, Failure> {
        self.rest = self.rest.trim_start();
        if self.takes("(") {
            let a = self.term()?;
            self.rest = self.rest.trim_start();
            let (operator, rest) = self.rest.split_at(1.min(self.rest.len()));
            self.rest = rest;
            let b = self.term()?;
            self.closes()?;
            return Ok(match operator {
                "+" => a + b,
                "-" => a.saturating_sub(b),
                "*" => a * b,
                "/" => a.checked_div(b).unwrap_or(0),
                "%" => a.checked_rem(b).unwrap_or(0),
                _ => return Err(format!("{operator:?} is no operator").into()),
            });
        }
        let is_in = |c: char| c.is_ascii_alphanumeric() || c == '_';
        let end = self.rest.find(|c| !is_in(c)).unwrap_or(self.rest.len());
        let (word, rest) = self.rest.split_at(end);
        self.rest = rest;
        if let Ok(number) = word.parse() {
            return Ok(number);
        }
        if !self.takes("(") {
            return self.numbers.name(word);
        }
        let a = self.term()?;
        let b = if self.takes(",") { Some(self.term()?) } else { None };
        self.closes()?;
        Ok(match (word, b) {
            ("div_up", Some(b)) => a.div_ceil(b.max(1)),
            ("min", Some(b)) => a.min(b),
            ("max", Some(b)) => a.max(b),
            ("power", None) => 1 << a.min(63),
            ("bits", None) => u64::from(u64::BITS - a.leading_zeros()),
            ("rows", None) => {
                let fits = |rows: &u64| a.is_multiple_of(*rows) && a / rows <= 65535;
                (1..=a).find(fits).unwrap_or(1)
            }
            _ => return Err(format!("{word} is no function of so many").into()),
        })
    }

    fn takes(&mut self, mark: &str) -> bool {
        let rest = self.rest.strip_prefix(mark);
        self.rest = rest.unwrap_or(self.rest);
        rest.is_some()
    }

    fn closes(&mut self) -> Result<(), Failure> {
        if self.takes(")") { Ok(()) } else { Err(format!("no ) before {:?}", self.rest).into()) }
    }
}
