//! Parsers of what is typed.

use clap::builder::{OsStringValueParser, PossibleValue, PossibleValuesParser, TypedValueParser};
use measurement::settings::choice::Choice;
use scene_loading::source_names::name_of_path;

/// The name of a scene; of a file of any name, UTF-8 or not.
pub(crate) fn scene_name() -> impl TypedValueParser<Value = String> {
    OsStringValueParser::new().map(|name| name_of_path(&name))
}

/// One of the values of a setting.
pub(crate) fn choice<T: Choice + Send + Sync>() -> impl TypedValueParser<Value = T> {
    let values = T::ALL.iter().map(|(_, name, help)| PossibleValue::new(*name).help(*help));
    PossibleValuesParser::new(values).try_map(|text| T::typed(&text).ok_or("no such value"))
}
