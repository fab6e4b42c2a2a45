//! How the tables of a run are shown on a terminal: in which order, and which columns of them.

use measurement::plan::error::PlanError;
use measurement::record::{AnsweredRays, RowRecord, SummaryRow};
use measurement::settings::choice::Choice;
use presentation::table::Table;
use presentation::text::{Screen, fitted, with_columns};

use crate::run::columns::RATIO;

#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum Sort {
    #[default]
    Trace,
    Build,
    /// Smallest first; in the table over all scenes as `trace`
    Memory,
    Registry,
}

impl Choice for Sort {
    const ALL: &'static [(Self, &'static str, &'static str)] = &[
        (Self::Trace, "trace", "Fastest at tracing first"),
        (Self::Build, "build", "Fastest to build first"),
        (Self::Memory, "memory", "Smallest first"),
        (Self::Registry, "registry", "As `rtbench list structures` has them"),
    ];
}

#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Columns {
    /// Columns that fit the screen.
    Fitting,
    /// All, however wide that is.
    All,
    /// These, however wide that is.
    Named(Vec<TableColumn>),
}

#[derive(Debug, Clone, PartialEq, Eq)]
pub struct View {
    pub sort: Sort,
    pub columns: Columns,
    pub screen: Screen,
}

/// A column by the name that it is asked for by.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct TableColumn {
    name: &'static str,
    /// Above it in tables.
    heads: &'static [&'static str],
}

const fn column(name: &'static str, heads: &'static [&'static str]) -> TableColumn {
    TableColumn { name, heads }
}

/// The columns that can be asked for, those of most weight first: these stay where not all fit.
const COLUMNS: [TableColumn; 19] = [
    column("ratio", &[RATIO, "trace ratio [95%]"]),
    column("build", &["build ms", "build ratio [95%]"]),
    column("verdict", &["verdict"]),
    column("trace", &["trace ms"]),
    column("memory", &["MiB"]),
    column("image", &["image ms"]),
    column("primary", &["primary"]),
    column("shadow", &["shadow"]),
    column("second", &["second."]),
    column("diffuse", &["diffuse"]),
    column("n_it", &["N_IT"]),
    column("n_ts", &["N_TS"]),
    column("n_oiv", &["N_OIV"]),
    column("n_v", &["N_V"]),
    column("n_ev", &["N_EV"]),
    column("n_in", &["N_IN"]),
    column("n_ets", &["N_ETS"]),
    column("n_eets", &["N_EETS"]),
    column("rays", &["rays"]),
];

/// Columns that say what a row is.
const ALWAYS: [&str; 2] = ["query", "scenes"];

impl TableColumn {
    pub fn named(name: &str) -> Result<Self, PlanError> {
        let names = || COLUMNS.iter().map(|c| c.name);
        let found = COLUMNS.iter().find(|c| c.name == name).copied();
        found.ok_or_else(|| PlanError::unknown("column", name, names()))
    }
}

/// The table with its columns in the order of their weight: where not all fit, the last ones are
/// out of sight.
pub fn by_weight(table: &Table) -> Table {
    let weights = View::fastest_first().by_weight();
    let place = |head: &&str| weights.iter().position(|h| h == head).unwrap_or(weights.len());
    let mut places: Vec<usize> = (1..table.header.len()).collect();
    places.sort_by_key(|c| table.header.get(*c).map(place));
    places.insert(0, 0);
    with_columns(table, &places)
}

impl View {
    /// The columns that fit a screen, the fastest rows first.
    pub fn on(screen: Screen) -> Self {
        Self { columns: Columns::Fitting, screen, ..Self::fastest_first() }
    }

    /// All columns, the fastest rows first.
    pub fn fastest_first() -> Self {
        Self { sort: Sort::Trace, columns: Columns::All, screen: Screen::UNLIMITED }
    }

    /// Returns whether the settings of a structure stand below it, indented.
    pub fn indents(&self) -> bool {
        self.sort == Sort::Registry
    }

    /// The table with the columns that are shown, and the heads of those that are not.
    pub fn shown(&self, table: &Table) -> (Table, Vec<&'static str>) {
        match &self.columns {
            Columns::All => (table.clone(), Vec::new()),
            Columns::Fitting => fitted(table, self.screen.width, &self.by_weight()),
            Columns::Named(named) => {
                let is_asked = |head: &&str| named.iter().any(|c| c.heads.contains(head));
                let is_shown = |head: &&str| ALWAYS.contains(head) || is_asked(head);
                let heads = table.header.iter().enumerate();
                let places = heads.filter(|(i, head)| *i == 0 || is_shown(head)).map(|(i, _)| i);
                (with_columns(table, &places.collect::<Vec<_>>()), Vec::new())
            }
        }
    }

    /// Heads, those of most weight first.
    fn by_weight(&self) -> Vec<&'static str> {
        let sorted_by = match self.sort {
            Sort::Memory => "memory",
            Sort::Build => "build",
            Sort::Trace | Sort::Registry => "ratio",
        };
        let (first, others): (Vec<TableColumn>, Vec<TableColumn>) =
            COLUMNS.iter().partition(|c| c.name == sorted_by);
        let all = first.iter().chain(&others).flat_map(|c| c.heads.iter().copied());
        ALWAYS.into_iter().chain(all).collect()
    }

    /// The rows of a scene in their order: those without times last, before them those of shadow
    /// rays alone.
    pub fn rows<'r>(&self, rows: &'r [RowRecord]) -> Vec<&'r RowRecord> {
        let last = f64::INFINITY;
        let median = |row: &RowRecord| row.ratio.map_or(last, |ratio| ratio.median);
        let key = |row: &RowRecord| match self.sort {
            Sort::Trace => median(row),
            Sort::Build => row.build_s.map_or(last, |build| build.median),
            Sort::Memory => row.stats.as_ref().map_or(last, |stats| stats.memory_bytes as f64),
            Sort::Registry => 0.0,
        };
        let class =
            |row: &RowRecord| (!row.verdict.is_timed(), row.answers == AnsweredRays::ShadowRays);
        self.sorted(rows, class, key)
    }

    /// The same over all scenes.
    pub fn summary<'r>(&self, rows: &'r [SummaryRow]) -> Vec<&'r SummaryRow> {
        let key = |row: &SummaryRow| {
            let of = match self.sort {
                Sort::Build => row.build_ratio,
                Sort::Trace | Sort::Memory | Sort::Registry => row.ratio,
            };
            of.map_or(f64::INFINITY, |ratio| ratio.median)
        };
        let class =
            |row: &SummaryRow| (!row.verdict.is_timed(), row.answers == AnsweredRays::ShadowRays);
        self.sorted(rows, class, key)
    }

    fn sorted<'r, R>(
        &self,
        rows: &'r [R],
        class: impl Fn(&R) -> (bool, bool),
        key: impl Fn(&R) -> f64,
    ) -> Vec<&'r R> {
        let mut rows: Vec<&R> = rows.iter().collect();
        if self.sort != Sort::Registry {
            rows.sort_by(|a, b| class(a).cmp(&class(b)).then(key(a).total_cmp(&key(b))));
        }
        rows
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::run::tables::scene_table;
    use measurement::record::Verdict;
    use measurement::record::made_up::run;

    fn view(sort: Sort, columns: Columns) -> View {
        let screen = Screen { width: 40, colors: false, is_wide: false };
        View { sort, columns, screen }
    }

    #[test]
    fn rows_are_sorted_by_what_was_asked() {
        let mut run =
            run(&[("tetra", &[("a", &[3.0]), ("b", &[1.0]), ("c", &[2.0]), ("d", &[0.5])])]);
        let rows = &mut run.scenes[0].rows;
        for (row, bytes) in rows.iter_mut().zip([10, 30, 20, 5]) {
            row.stats.as_mut().unwrap().memory_bytes = bytes;
            row.figure(1);
        }
        rows[3].verdict = Verdict::Wrong;
        let order = |sort| {
            let rows = view(sort, Columns::All).rows(&run.scenes[0].rows);
            rows.iter().map(|row| row.structure.as_str()).collect::<String>()
        };
        let orders: Vec<String> = Sort::ALL.iter().map(|(sort, ..)| order(*sort)).collect();
        assert_eq!(orders, ["bcad", "bcad", "acbd", "abcd"]);
    }

    fn table_of_one_row() -> Table {
        let run = run(&[("tetra", &[("a", &[3.0])])]);
        scene_table(&run, &run.scenes[0], &run.scenes[0].rows, true)
    }

    #[test]
    fn columns_are_known_and_each_is_a_column_of_the_table() {
        let table = table_of_one_row();
        for head in &table.header[1..] {
            let known = COLUMNS.iter().any(|c| c.heads.contains(head));
            assert!(known || ALWAYS.contains(head), "{head}");
        }
        assert_eq!(TableColumn::named("n_it").unwrap().heads, ["N_IT"]);
        let error = TableColumn::named("memry").unwrap_err().to_string();
        assert!(error.contains("did you mean 'memory'?"), "{error}");
    }

    #[test]
    fn the_sort_column_is_shown_first() {
        let table = table_of_one_row();
        let heads = |view: View| view.shown(&table).0.header;
        let narrow = |sort| heads(view(sort, Columns::Fitting));
        assert!(narrow(Sort::Trace).contains(&RATIO) && narrow(Sort::Memory).contains(&"MiB"));
        let named = Columns::Named(vec![TableColumn::named("n_it").unwrap()]);
        assert_eq!(heads(view(Sort::Trace, named)), ["structure", "N_IT"]);
        assert_eq!(heads(view(Sort::Trace, Columns::All)), table.header);
        let all = super::by_weight(&table);
        assert_eq!(all.header[..4], ["structure", RATIO, "build ms", "verdict"]);
        assert_eq!((all.header.len(), all.rows[0][3].text.as_str()), (table.header.len(), "ok"));
        let (_, left_out) = view(Sort::Trace, Columns::Fitting).shown(&table);
        assert!(left_out.contains(&"N_EETS"));
    }
}
