//! Which times decide, and what programs are called with so that they print them.

use std::ffi::OsString;

use crate::bisect::error::BisectError;
use crate::gate::contest::Key;

/// A row of rtbench: `teapot/kd-tree`, `teapot/hug density=9/build`.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct BisectRow {
    scene: String,
    label: String,
    quantity: Option<String>,
}

impl BisectRow {
    /// Reads it.
    ///
    /// # Errors
    /// [`BisectError::Malformed`].
    pub fn parse(text: &str) -> Result<Self, BisectError> {
        let malformed = || BisectError::Malformed { text: text.into() };
        let (rest, quantity) = match text.rsplit_once('/') {
            Some((rest, end)) if ["build", "trace"].contains(&end) => (rest, Some(end.to_owned())),
            _ => (text, None),
        };
        // files of scenes have slashes in their names
        let (scene, label) = rest.rsplit_once('/').ok_or_else(malformed)?;
        if scene.is_empty() || label.is_empty() {
            return Err(malformed());
        }
        Ok(Self { scene: scene.into(), label: label.replace(':', " "), quantity })
    }

    fn is(&self, key: &Key) -> bool {
        let is_asked = self.quantity.as_ref().is_none_or(|quantity| quantity == key.quantity);
        key.scene == self.scene && key.row == self.label && is_asked
    }
}

/// What programs are called with, and which of their times decide.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Chosen {
    /// rtbench: these rows.
    Rows(Vec<BisectRow>),
    /// Another program: all that it prints, called with these arguments.
    All(Vec<OsString>),
}

impl Chosen {
    /// What the programs are called with.
    pub fn arguments(&self) -> Vec<OsString> {
        let rows = match self {
            Self::All(arguments) => return arguments.clone(),
            Self::Rows(rows) => rows,
        };
        let mut arguments: Vec<OsString> = vec!["run".into()];
        let mut push = |text: &str| {
            if !arguments.iter().any(|known| known == text) {
                arguments.push(text.into());
            }
        };
        rows.iter().for_each(|row| push(&row.scene));
        for row in rows {
            arguments.extend(["-s".into(), row.label.clone().into()]);
        }
        arguments.extend(["--quick", "--quiet", "--export-json", "-"].map(OsString::from));
        arguments
    }

    /// Whether a time decides.
    pub fn decides(&self, key: &Key) -> bool {
        match self {
            Self::All(_) => true,
            Self::Rows(rows) => rows.iter().any(|row| row.is(key)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_are_read_and_asked_for() {
        let read = |text: &str| BisectRow::parse(text).unwrap();
        let key = |row: &str, quantity| Key { scene: "teapot".into(), row: row.into(), quantity };
        let hug = read("teapot/hug:density=9/build");
        assert!(hug.is(&key("hug density=9", "build")) && !hug.is(&key("hug density=9", "trace")));
        assert!(read("teapot/kd-tree").is(&key("kd-tree", "trace")));
        assert!(read("scenes/hall.obj/kd-tree").scene == "scenes/hall.obj");
        let arguments = Chosen::Rows(vec![read("teapot/kd-tree"), hug]).arguments();
        let expected = "run teapot -s kd-tree -s hug density=9 --quick --quiet --export-json -";
        assert_eq!(arguments.join(" ".as_ref()), expected);
        for bad in ["teapot", "/kd-tree", "teapot/", "build", "teapot/build"] {
            let error = BisectRow::parse(bad).unwrap_err().to_string();
            assert!(error.contains("SCENE/STRUCTURE"), "{error}");
        }
    }
}
