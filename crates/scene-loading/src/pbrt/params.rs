//! Parameter lists: `"float radius" 2 "point3 P" [0 0 0 1 0 0]`.

use std::rc::Rc;

use crate::error::{FilePlace, LoadError, shortened};
use crate::limits::{self, MAX_ELEMENTS, MAX_NAME};
use crate::mesh::coordinate;
use crate::scene::Rgb;
use crate::words::{Word, Words};

/// The most parameters of a statement.
const MAX_PARAMS: usize = 1 << 12;

/// The most numbers of a parameter.
const MAX_NUMBERS: usize = 3 * MAX_ELEMENTS;

/// The values of a parameter: numbers, or strings and `true` and `false`.
#[derive(Debug)]
struct Param {
    kind: String,
    name: String,
    place: FilePlace,
    numbers: Vec<f64>,
    words: Vec<String>,
}

/// The parameters of a statement.
#[derive(Debug)]
pub(super) struct Params {
    /// First line of the statement.
    place: FilePlace,
    all: Vec<Param>,
    /// The last `Attribute` that gives it parameters which it does not have itself.
    inherited: Option<Rc<Params>>,
    /// Number of `Attribute` statements that do so.
    depth: usize,
}

/// The most `Attribute` statements that apply to one statement.
const MAX_INHERITED: usize = 256;

impl Params {
    /// Reads parameters up to the next statement; others are inherited.
    pub fn read(
        words: &mut Words<'_>,
        line: usize,
        inherited: Option<&Rc<Self>>,
    ) -> Result<Self, LoadError> {
        let mut all = Vec::new();
        while let Some(declared) = words.peek().filter(|word| !word.is_directive()) {
            let place = words.place(declared.line);
            limits::check(all.len() + 1, MAX_PARAMS, "the number of parameters", || place.clone())?;
            let text = words.name("type name")?;
            let parts: Vec<&str> = text.split_ascii_whitespace().collect();
            let &[kind, name] = parts.as_slice() else {
                return Err(LoadError::syntax(place, &text, "a parameter: \"type name\""));
            };
            let (kind, name) = (kind.to_owned(), name.to_owned());
            let mut param = Param { kind, name, place, numbers: Vec::new(), words: Vec::new() };
            let first = words.any("a value, or [")?;
            if first.is_bracket("[") {
                loop {
                    let value = words.any("a value, or ]")?;
                    if value.is_bracket("]") {
                        break;
                    }
                    param.push(value, words)?;
                }
            } else {
                param.push(first, words)?;
            }
            all.push(param);
        }
        words.check_closed()?;
        let depth = inherited.map_or(0, |params| params.depth + 1);
        Ok(Self { place: words.place(line), all, inherited: inherited.cloned(), depth })
    }

    /// Refuses an `Attribute` statement that adds to too many others.
    pub fn check_depth(&self) -> Result<(), LoadError> {
        let what = "the number of Attribute statements that apply";
        limits::check(self.depth + 1, MAX_INHERITED, what, || self.place())
    }

    pub fn place(&self) -> FilePlace {
        self.place.clone()
    }

    fn find(&self, name: &str) -> Option<&Param> {
        let mut all = std::iter::successors(Some(self), |params| params.inherited.as_deref());
        all.find_map(|params| params.all.iter().find(|param| param.name == name))
    }

    /// The numbers of a parameter; empty where it is not there.
    ///
    /// # Errors
    /// [`LoadError::Syntax`] for strings, [`LoadError::OutOfRange`].
    pub fn numbers(&self, name: &str) -> Result<&[f64], LoadError> {
        let Some(param) = self.find(name) else { return Ok(&[]) };
        for &value in self.any_numbers(name)? {
            coordinate(value, name, || param.place.clone())?;
        }
        Ok(&param.numbers)
    }

    /// As [`Params::numbers`], but they may be NaN, infinite or too large.
    pub fn any_numbers(&self, name: &str) -> Result<&[f64], LoadError> {
        let Some(param) = self.find(name) else { return Ok(&[]) };
        if let Some(word) = param.words.first() {
            let place = param.place.clone();
            return Err(LoadError::syntax(place, word, format!("numbers ({name})")));
        }
        Ok(&param.numbers)
    }

    /// One number; spectra and textures are none.
    ///
    /// # Errors
    /// As [`Params::numbers`], and [`LoadError::Syntax`] for more.
    pub fn number(&self, name: &str, default: f64) -> Result<f64, LoadError> {
        let varies =
            |param: &Param| matches!(&*param.kind, "spectrum" | "texture" | "rgb" | "color");
        if self.find(name).is_some_and(varies) {
            return Ok(default);
        }
        match self.numbers(name)? {
            [] => Ok(default),
            [value] => Ok(*value),
            more => Err(self.other_count(more, &format!("one ({name})"))),
        }
    }

    /// Three numbers.
    pub fn vector(&self, name: &str, default: [f64; 3]) -> Result<[f64; 3], LoadError> {
        match self.numbers(name)? {
            [] => Ok(default),
            [x, y, z] => Ok([*x, *y, *z]),
            other => Err(self.other_count(other, &format!("three ({name})"))),
        }
    }

    fn other_count(&self, numbers: &[f64], expected: &str) -> LoadError {
        LoadError::syntax(self.place(), &format!("{} numbers", numbers.len()), expected)
    }

    /// A colour that is given as `rgb`, or `color` as before version 4; spectra, textures and
    /// temperatures are none.
    pub fn rgb(&self, name: &str) -> Result<Option<Rgb>, LoadError> {
        match self.find(name) {
            Some(param) if matches!(&*param.kind, "rgb" | "color") => {
                self.vector(name, [0.0; 3]).map(Some)
            }
            _ => Ok(None),
        }
    }

    pub fn string(&self, name: &str) -> Option<&str> {
        self.find(name)?.words.first().map(String::as_str)
    }

    /// True where there is a parameter of that name.
    pub fn has(&self, name: &str) -> bool {
        self.find(name).is_some()
    }

    /// True where a parameter names a texture.
    pub fn has_texture(&self) -> bool {
        self.all.iter().any(|param| param.kind == "texture")
    }
}

impl Param {
    fn push(&mut self, value: Word<'_>, words: &Words<'_>) -> Result<(), LoadError> {
        let place = || words.place(value.line);
        if let Some(number) = value.number() {
            self.numbers.push(number);
            return limits::check(self.numbers.len(), MAX_NUMBERS, &self.name, place);
        }
        if value.is_quoted || matches!(value.text, "true" | "false") {
            limits::check(value.text.len(), MAX_NAME, "the length of a string", place)?;
            self.words.push(value.text.to_owned());
            return limits::check(self.words.len(), MAX_ELEMENTS, &self.name, place);
        }
        let expected = format!("a value of {} {}", shortened(&self.kind), shortened(&self.name));
        Err(LoadError::syntax(place(), value.text, expected))
    }
}
