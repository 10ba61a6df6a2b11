//! A TOML table with its place in the file: typed look-ups whose errors name file:line:column, key and nearest key.

use std::ops::Range;
use std::path::Path;

use toml::Spanned;
use toml::de::{DeString, DeTable, DeValue};

use super::keys::Section;
use crate::scene::Error;

pub type Item<'a> = Spanned<DeValue<'a>>;

/// The text errors point into.
#[derive(Clone, Copy)]
pub struct Source<'a> {
    pub path: &'a Path,
    pub text: &'a str,
}

impl Source<'_> {
    pub fn error(&self, at: Range<usize>, reason: impl Into<String>) -> Error {
        let before = self.text.get(..at.start.min(self.text.len())).unwrap_or("");
        let line = before.matches('\n').count() + 1;
        let column = before.rsplit('\n').next().unwrap_or("").chars().count() + 1;
        Error::Text { path: self.path.to_path_buf(), line, column, reason: reason.into() }
    }

    /// True for `{ ... }`, false for a table that a `[header]` opened.
    pub fn is_inline(&self, at: &Range<usize>) -> bool {
        self.text.get(at.start..).is_some_and(|t| t.starts_with('{'))
    }
}

/// A table whose keys have been checked.
pub struct Table<'a> {
    pub source: Source<'a>,
    pub section: &'static str,
    pub at: Range<usize>,
    entries: &'a DeTable<'a>,
}

impl<'a> Table<'a> {
    /// `known` lists the sections whose keys are allowed; `more` further names (the inputs of a BSDF).
    pub fn open(
        source: Source<'a>,
        item: &'a Item<'a>,
        known: &[&Section],
        more: &[&'static str],
    ) -> Result<Self, Error> {
        let section = known[known.len() - 1].name;
        let DeValue::Table(entries) = item.get_ref() else {
            return Err(source.error(item.span(), format!("{section} must be a table, not {}", kind(item))));
        };
        let table = Self { source, section, at: item.span(), entries };
        table.check_keys(known, more)?;
        Ok(table)
    }

    /// Without a check of the keys.
    pub fn over(source: Source<'a>, section: &'static str, at: Range<usize>, entries: &'a DeTable<'a>) -> Self {
        Self { source, section, at, entries }
    }

    pub fn check_keys(&self, known: &[&Section], more: &[&'static str]) -> Result<(), Error> {
        let names = || known.iter().flat_map(|s| s.keys.iter().map(|k| k.name)).chain(more.iter().copied());
        for (key, _) in self.entries.iter() {
            if names().any(|n| n == key.get_ref()) {
                continue;
            }
            return Err(self.unknown(key, &nearest(key.get_ref(), names())));
        }
        Ok(())
    }

    pub fn unknown(&self, key: &Spanned<DeString<'a>>, hint: &str) -> Error {
        self.source.error(key.span(), format!("unknown key `{}` in {}; {hint}", key.get_ref(), self.section))
    }

    pub fn entries(&self) -> impl Iterator<Item = (&'a Spanned<DeString<'a>>, &'a Item<'a>)> {
        self.entries.iter()
    }

    pub fn get(&self, key: &str) -> Option<&'a Item<'a>> {
        self.entries.get(key)
    }

    /// An error at the value of a key, or at the table where it is missing.
    pub fn error(&self, key: &str, reason: impl std::fmt::Display) -> Error {
        let at = self.get(key).map_or(self.at.clone(), |item| item.span());
        self.source.error(at, format!("`{key}` in {} {reason}", self.section))
    }

    pub fn missing(&self, key: &str) -> Error {
        self.source.error(self.at.clone(), format!("{} has no `{key}`; add it", self.section))
    }

    fn wrong(&self, key: &str, wanted: &str) -> Error {
        let found = self.get(key).map_or("nothing".into(), kind);
        self.error(key, format!("must be {wanted}, and is {found}"))
    }

    pub fn text(&self, key: &str) -> Result<Option<&'a str>, Error> {
        let Some(item) = self.get(key) else { return Ok(None) };
        item.get_ref().as_str().map(Some).ok_or_else(|| self.wrong(key, "a string"))
    }

    /// A list of strings.
    pub fn texts(&self, key: &str) -> Result<Option<Vec<&'a str>>, Error> {
        let Some(item) = self.get(key) else { return Ok(None) };
        let wrong = || self.wrong(key, "a list of strings");
        let list = item.get_ref().as_array().ok_or_else(wrong)?;
        list.iter().map(|i| i.get_ref().as_str().ok_or_else(wrong)).collect::<Result<_, _>>().map(Some)
    }

    /// A list of numbers.
    pub fn list_of(&self, key: &str, item: &Item<'_>) -> Result<Vec<f64>, Error> {
        let list = item.get_ref().as_array().ok_or_else(|| self.wrong(key, "a list of numbers"))?;
        list.iter().map(|i| self.number_of(key, i)).collect()
    }

    pub fn boolean(&self, key: &str) -> Result<Option<bool>, Error> {
        let Some(item) = self.get(key) else { return Ok(None) };
        item.get_ref().as_bool().map(Some).ok_or_else(|| self.wrong(key, "true or false"))
    }

    pub fn number(&self, key: &str) -> Result<Option<f64>, Error> {
        let Some(item) = self.get(key) else { return Ok(None) };
        self.number_of(key, item).map(Some)
    }

    pub fn whole(&self, key: &str, range: Range<u64>) -> Result<Option<u64>, Error> {
        let Some(item) = self.get(key) else { return Ok(None) };
        let number = item.get_ref().as_integer().and_then(|i| u64::from_str_radix(i.as_str(), i.radix()).ok());
        match number {
            Some(n) if range.contains(&n) => Ok(Some(n)),
            _ => Err(self.error(key, format!("must be a whole number from {} to {}", range.start, range.end - 1))),
        }
    }

    pub fn numbers<const N: usize>(&self, key: &str) -> Result<Option<[f64; N]>, Error> {
        let Some(item) = self.get(key) else { return Ok(None) };
        self.numbers_of(key, item).map(Some)
    }

    /// One number for all N, or N numbers.
    pub fn splat<const N: usize>(&self, key: &str) -> Result<Option<[f64; N]>, Error> {
        let Some(item) = self.get(key) else { return Ok(None) };
        if item.get_ref().is_array() {
            return self.numbers_of(key, item).map(Some);
        }
        Ok(Some([self.number_of(key, item)?; N]))
    }

    /// Rows of N numbers.
    pub fn rows<const N: usize>(&self, key: &str) -> Result<Option<Vec<[f64; N]>>, Error> {
        let Some(item) = self.get(key) else { return Ok(None) };
        let rows = item.get_ref().as_array().ok_or_else(|| self.wrong(key, &format!("an array of [{N} numbers]")))?;
        rows.iter().map(|row| self.numbers_of(key, row)).collect::<Result<_, _>>().map(Some)
    }

    pub fn number_of(&self, key: &str, item: &Item<'_>) -> Result<f64, Error> {
        let fail = |reason: &str| self.source.error(item.span(), format!("`{key}` in {} {reason}", self.section));
        let number = match item.get_ref() {
            DeValue::Integer(i) => i64::from_str_radix(i.as_str(), i.radix()).ok().map(|n| n as f64),
            DeValue::Float(f) => f.as_str().parse::<f64>().ok(),
            _ => return Err(fail(&format!("must be a number, and is {}", kind(item)))),
        };
        match number {
            Some(x) if x.is_finite() => Ok(x),
            _ => Err(fail("must be a finite number")),
        }
    }

    pub fn numbers_of<const N: usize>(&self, key: &str, item: &Item<'_>) -> Result<[f64; N], Error> {
        let fail = |found: String| {
            self.source
                .error(item.span(), format!("`{key}` in {} must be {N} numbers in [ ], and is {found}", self.section))
        };
        let DeValue::Array(array) = item.get_ref() else {
            return Err(fail(kind(item)));
        };
        let entries: Vec<_> = array.iter().collect();
        if entries.len() != N {
            return Err(fail(format!("{} of them", entries.len())));
        }
        let mut numbers = [0.0; N];
        for (slot, entry) in numbers.iter_mut().zip(entries) {
            *slot = self.number_of(key, entry)?;
        }
        Ok(numbers)
    }

    /// The tables of `[[key]]`.
    pub fn tables(&self, key: &str) -> Result<Vec<&'a Item<'a>>, Error> {
        let Some(item) = self.get(key) else { return Ok(Vec::new()) };
        match item.get_ref() {
            DeValue::Array(array) => Ok(array.iter().collect()),
            _ => Err(self.source.error(item.span(), format!("write [[{key}]] in two brackets: there may be several"))),
        }
    }
}

/// What an item is, for messages: "a string", "an integer".
fn kind(item: &Item<'_>) -> String {
    let word = item.get_ref().type_str();
    let article = if word.starts_with(['a', 'i']) { "an" } else { "a" };
    format!("{article} {word}")
}

/// "did you mean `x`?" where something is near, else the list.
pub fn nearest<'n>(word: &str, names: impl Iterator<Item = &'n str>) -> String {
    let names: Vec<&str> = names.collect();
    let best = names.iter().map(|n| (strsim::jaro_winkler(word, n), *n)).max_by(|a, b| a.0.total_cmp(&b.0));
    match best {
        Some((score, name)) if score > 0.7 => format!("did you mean `{name}`?"),
        Some((_, name)) if names.len() > 24 => format!("the nearest is `{name}`"),
        Some(_) => format!("known are: {}", names.join(", ")),
        None => "there is none".into(),
    }
}
