//! A run in parts, for more than one machine: `--shard 2/8` measures the second of eight parts.
//!
//! What is divided is the table of scenes and rows, without the reference row: scene after scene,
//! row after row, cut into as many runs of cells as there are shards, equal in number but for one.
//! So a shard has few scenes (each costs its rays and its oracle), the rows of a scene stay
//! together where they can, and the division depends on nothing but the two lists. The reference
//! row is measured in every shard, in each of its scenes: ratios are taken within a shard.

use serde::de::Error;
use serde::{Deserialize, Deserializer, Serialize};

/// One of several parts; in files as typed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(try_from = "String", into = "String")]
pub struct Shard {
    /// Which, from 1.
    pub index: u32,
    pub count: u32,
}

/// Most parts of a run.
const MOST: u32 = 10_000;

impl Shard {
    /// Parses `2/8` for clap.
    pub fn parse(text: &str) -> Result<Self, String> {
        let expected = || format!("expected I/N, like 2/8: I from 1 to N, N from 1 to {MOST}");
        let (index, count) = text.split_once('/').ok_or_else(expected)?;
        let number = |text: &str| text.parse::<u32>().map_err(|_| expected());
        let shard = Self { index: number(index)?, count: number(count)? };
        let is_valid =
            (1..=MOST).contains(&shard.count) && (1..=shard.count).contains(&shard.index);
        is_valid.then_some(shard).ok_or_else(expected)
    }
}

impl TryFrom<String> for Shard {
    type Error = String;

    fn try_from(text: String) -> Result<Self, String> {
        Self::parse(&text)
    }
}

impl From<Shard> for String {
    fn from(shard: Shard) -> Self {
        shard.to_string()
    }
}

impl std::fmt::Display for Shard {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}/{}", self.index, self.count)
    }
}

/// What a part of a run records of the whole.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "testing", derive(schemars::JsonSchema))]
pub struct ShardRecord {
    /// Which part, from 1.
    #[serde(deserialize_with = "of_parts")]
    pub index: u32,
    /// Of how many.
    #[serde(deserialize_with = "of_parts")]
    pub count: u32,
    /// All scenes of the whole run, in order.
    pub scenes: Vec<String>,
    /// All rows of a scene in the whole run, in order: structure and settings.
    pub rows: Vec<String>,
    /// The place of the reference row among them, from 0.
    pub reference: usize,
    /// How many rounds were asked for.
    pub rounds: String,
}

/// A number of parts, or of one of them.
fn of_parts<'de, D: Deserializer<'de>>(from: D) -> Result<u32, D::Error> {
    let number = u32::deserialize(from)?;
    let expected =
        || D::Error::custom(format!("{number} parts, expected a number from 1 to {MOST}"));
    (1..=MOST).contains(&number).then_some(number).ok_or_else(expected)
}

impl ShardRecord {
    pub fn shard(&self) -> Shard {
        Shard { index: self.index, count: self.count }
    }

    /// Cells that are divided: those of the reference only where there are no others.
    pub fn cells(&self) -> usize {
        self.scenes.len() * self.width()
    }

    /// Cells of a scene.
    fn width(&self) -> usize {
        self.rows.len().saturating_sub(1).max(1)
    }

    /// The places of the rows that it measures in a scene, in their order, the reference among
    /// them; none where it has nothing to do there.
    pub fn rows_of(&self, scene: usize) -> Vec<usize> {
        let bound = |index: u32| index as usize * self.cells() / self.count as usize;
        let own = bound(self.index.saturating_sub(1))..bound(self.index);
        let first = scene * self.width();
        let rows = 0..self.rows.len();
        let others = rows.clone().filter(|&row| row != self.reference);
        let taken: Vec<usize> = match self.rows.len() {
            1 => Vec::from_iter(own.contains(&first).then_some(self.reference)),
            _ => others.zip(first..).filter(|(_, cell)| own.contains(cell)).map(|c| c.0).collect(),
        };
        rows.filter(|row| !taken.is_empty() && (*row == self.reference || taken.contains(row)))
            .collect()
    }
}

/// A part of a run; the scenes of its plan are those in which it has rows to measure.
#[derive(Debug, Clone)]
pub struct PlannedPart {
    pub record: ShardRecord,
    /// The places of its rows, for each of its scenes.
    pub rows: Vec<Vec<usize>>,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shards_are_read() {
        assert_eq!(Shard::parse("2/8"), Ok(Shard { index: 2, count: 8 }));
        for bad in ["", "2", "0/8", "9/8", "1/0", "a/b", "1/99999", "-1/2", "1/2/3"] {
            assert!(Shard::parse(bad).is_err(), "{bad}");
        }
    }

    /// A part of a table of so many scenes and rows, with the place of the reference.
    fn part(index: u32, count: u32, [scenes, rows, reference]: [usize; 3]) -> ShardRecord {
        let names = |n| vec![String::new(); n];
        let (scenes, rows, rounds) = (names(scenes), names(rows), String::new());
        ShardRecord { index, count, scenes, rows, reference, rounds }
    }

    #[test]
    fn every_cell_is_in_one_shard_and_the_reference_in_all_that_need_it() {
        for (scenes, rows, reference) in [(8, 29, 5), (3, 2, 0), (5, 1, 0), (2, 4, 3), (1, 7, 2)] {
            let table = [scenes, rows, reference];
            for count in 1..=part(1, 1, table).cells() as u32 {
                let mut seen = vec![0; scenes * rows];
                let mut sizes = Vec::new();
                for index in 1..=count {
                    let (mut size, shard) = (0, part(index, count, table));
                    for scene in 0..scenes {
                        let own = shard.rows_of(scene);
                        assert!(own.is_sorted());
                        assert!(own.is_empty() || own.contains(&reference));
                        for row in own {
                            seen[scene * rows + row] += 1;
                            size += usize::from(row != reference || rows == 1);
                        }
                    }
                    sizes.push(size);
                }
                let (least, most) = (sizes.iter().min().unwrap(), sizes.iter().max().unwrap());
                assert!(*least >= 1 && most - least <= 1, "{sizes:?}");
                for (i, times) in seen.iter().enumerate() {
                    assert!(*times == 1 || (i % rows == reference && *times > 1), "{seen:?}");
                }
            }
        }
    }

    #[test]
    fn surplus_shards_are_empty() {
        let works = |index| !part(index, 3, [1, 3, 0]).rows_of(0).is_empty();
        assert_eq!([works(1), works(2), works(3)].iter().filter(|w| **w).count(), 2);
    }
}
