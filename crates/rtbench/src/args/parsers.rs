//! Parsers of what is typed.

use clap::builder::{OsStringValueParser, PossibleValue, PossibleValuesParser, TypedValueParser};
use measurement::settings::MeasuringSettings;
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

/// A number of threads.
pub(crate) fn threads() -> impl TypedValueParser<Value = u16> {
    clap::value_parser!(u16).range(1..=MeasuringSettings::MOST_THREADS.into())
}

/// A share as typed: `5%`. There is one way to write it, so that no `5` is taken for 500%.
pub(crate) fn percent(text: &str) -> Result<f64, String> {
    let number = text.strip_suffix('%').and_then(|number| number.trim().parse::<f64>().ok());
    match number {
        Some(percent) if (0.0..=1000.0).contains(&percent) => Ok(percent / 100.0),
        _ => Err("expected a percentage from 0% to 1000%: 5%, 0.5%".into()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_percentage_has_its_sign() {
        assert_eq!(
            [percent("3%"), percent("0.5%"), percent("0 %")],
            [Ok(0.03), Ok(0.005), Ok(0.0)]
        );
        for bad in ["", "%", "3", "0.05", "-1%", "nan%", "1001%", "three"] {
            assert!(percent(bad).is_err(), "{bad}");
        }
    }
}
