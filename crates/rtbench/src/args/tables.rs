//! How tables of a run are printed.

use clap::Args;
use clap::builder::TypedValueParser;
use measurement::settings::choice::Choice;
use studies::run::view::{Columns, Sort, TableColumn, View};

use crate::args::parsers::choice;

/// How tables of a run are printed; files have all columns and the order of the registry.
#[derive(Debug, Clone, Args)]
#[command(next_help_heading = "Tables")]
pub struct TableArgs {
    /// Order of the rows printed
    #[arg(long, value_parser = choice::<Sort>(), default_value = Sort::default().as_typed())]
    pub sort: Sort,
    /// Print all columns [default: those that fit the terminal, or 120 characters]
    #[arg(long, conflicts_with = "columns")]
    pub wide: bool,
    /// Print these columns: ratio, build, trace, image, memory, primary, shadow, second, diffuse, rays, n_it, ...,
    /// verdict
    #[arg(long, value_name = "COLUMN", value_delimiter = ',', value_parser = column())]
    pub columns: Vec<TableColumn>,
}

fn column() -> impl TypedValueParser<Value = TableColumn> {
    clap::builder::NonEmptyStringValueParser::new().try_map(|name| TableColumn::named(&name))
}

impl TableArgs {
    /// How tables look within so many characters.
    pub fn view(&self, width: usize, colors: bool) -> View {
        let columns = match &self.columns[..] {
            [] if self.wide => Columns::All,
            [] => Columns::Within(width),
            named => Columns::Named(named.to_vec()),
        };
        View { sort: self.sort, columns, colors }
    }
}
