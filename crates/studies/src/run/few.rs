//! Wording for runs of a few rounds: brackets are the least and the largest round, not 95%
//! intervals, and nothing is significant.

use measurement::record::RunRecord;
use presentation::table::{Cell, Table};
use statistics::series::FEWEST_ROUNDS;

use crate::run::columns::RATIO;

/// Heads of figures with an interval, and the same of ranges.
const HEADS: [(&str, &str, &str); 5] = [
    (RATIO, "ratio [range]", "ratio"),
    ("trace ratio [95%]", "trace ratio [range]", "trace ratio"),
    ("build ratio [95%]", "build ratio [range]", "build ratio"),
    ("to obvhs [95%]", "to obvhs [range]", "to obvhs"),
    ("time to image to obvhs [95%]", "time to image to obvhs [range]", "time to image to obvhs"),
];

/// Words of certainty, and what stands in their place.
const WORDS: [(&str, &str); 7] = [
    (
        "Intervals are 95% bootstrap percentile intervals (expanded, Hesterberg 2015); of fewer than six \
         rounds they reach from the least to the largest value.",
        "Brackets are the least and the largest value.",
    ),
    ("95% bootstrap interval", "range of the rounds"),
    ("95% intervals", "ranges of the rounds"),
    ("95% interval", "range of the rounds"),
    ("not significantly different", "not distinguished"),
    ("is significantly slower (or larger)", "is slower (or larger) in every round"),
    ("no significant difference", "not distinguished"),
];

/// How a run of a few rounds is shown.
#[derive(Debug, Clone, Copy)]
pub struct Few {
    rounds: usize,
}

impl Few {
    /// None of a run with enough rounds, or with several processes, whose medians have an interval.
    pub fn of(run: &RunRecord) -> Option<Self> {
        let rows = run.scenes.iter().flat_map(|scene| &scene.rows);
        let rounds = rows.map(|row| row.samples.len()).max().unwrap_or(0);
        let is_few = (1..FEWEST_ROUNDS).contains(&rounds) && run.settings.processes < 2;
        is_few.then_some(Self { rounds })
    }

    pub fn heading(self) -> String {
        match self.rounds {
            1 => "One round: figures without intervals.".to_owned(),
            n => format!(
                "{n} rounds: brackets are the least and the largest of {n}, no 95% intervals; \
                 nothing here is significant."
            ),
        }
    }

    /// The table with heads, cells and notes that claim no more than that.
    fn table(self, mut table: Table) -> Table {
        for head in &mut table.header {
            if let Some((_, range, alone)) = HEADS.iter().find(|(of, ..)| of == head) {
                *head = if self.rounds == 1 { alone } else { range };
            }
        }
        let cells = table.rows.iter_mut().flatten();
        cells.for_each(|Cell { text, .. }| *text = self.text(text));
        table.notes.iter_mut().for_each(|note| *note = self.text(note));
        table
    }

    /// A page likewise, which says so below its title.
    pub fn page(self, html: &str) -> String {
        let heading = format!("</h1><p class=\"notes\">{}</p>", self.heading());
        let html = self.text(html).replace("[95%]", "[range]").replace(">95%<", ">range<");
        html.replacen("</h1>", &heading, 1)
    }

    /// A text without words of certainty; of one round without brackets around one figure.
    fn text(self, text: &str) -> String {
        let mut text = text.to_owned();
        for (of, instead) in WORDS {
            text = text.replace(of, instead);
        }
        if self.rounds > 1 {
            return text;
        }
        let mut short = String::new();
        let mut rest = text.as_str();
        while let Some((before, behind)) = rest.split_once(" [") {
            short += before;
            let inside = behind.split_once(']');
            let ends = inside.and_then(|(inside, after)| Some((inside.split_once(", ")?, after)));
            match ends {
                Some(((low, high), after)) if low == high => rest = after,
                _ => {
                    short += " [";
                    rest = behind;
                }
            }
        }
        short + rest
    }
}

/// The table as a run may show it.
pub fn table(run: &RunRecord, table: Table) -> Table {
    match Few::of(run) {
        Some(few) => few.table(table),
        None => table,
    }
}

/// The text as a run may say it.
pub fn text(run: &RunRecord, text: &str) -> String {
    Few::of(run).map_or_else(|| text.to_owned(), |few| few.text(text))
}

#[cfg(test)]
mod tests {
    use super::*;
    use measurement::record::made_up::run;

    fn few(rounds: usize) -> Option<Few> {
        Few::of(&run(&[("tetra", &[("a", &[1.0; 9][..rounds])])]))
    }

    #[test]
    fn a_run_of_three_rounds_claims_no_interval() {
        assert!(few(5).is_none() && few(0).is_none());
        let few = few(3).unwrap();
        assert!(few.heading().contains("least and the largest of 3"), "{}", few.heading());
        let table = Table {
            header: vec!["structure", RATIO],
            rows: vec![["a", "0.51 [0.50, 0.52]"].map(|text| text.to_owned().into()).into()],
            notes: vec!["; not significantly different: b".into()],
            ..Table::default()
        };
        let shown = few.table(table);
        assert_eq!(shown.header, ["structure", "ratio [range]"]);
        assert_eq!(shown.rows[0][1].text, "0.51 [0.50, 0.52]");
        assert_eq!(shown.notes, ["; not distinguished: b"]);
    }

    #[test]
    fn a_page_shows_incompleteness_below_its_title() {
        let page = few(3).unwrap().page("<h1>run</h1><th>ratio [95%]</th><h1>more</h1>");
        assert!(page.starts_with("<h1>run</h1><p class=\"notes\">3 rounds: brackets"), "{page}");
        assert!(page.ends_with("<th>ratio [range]</th><h1>more</h1>"), "{page}");
    }

    #[test]
    fn intervals_of_one_round_are_not_printed() {
        let few = few(1).unwrap();
        assert_eq!(
            few.text("bvh 0.51 [0.51, 0.51]; next: a 2 x [2, 2]."),
            "bvh 0.51; next: a 2 x."
        );
        assert_eq!(few.text("from 3 rays [1, never] b [c"), "from 3 rays [1, never] b [c");
    }
}
