//! CSV: fields and files.

use csv::{ReaderBuilder, Writer};

use crate::json::FormatError;
use crate::outside::field;
use statistics::estimate::Estimate;

/// The text that `fill` writes, its fields [defused](field).
pub fn written(
    fill: impl FnOnce(&mut Writer<Vec<u8>>) -> Result<(), csv::Error>,
) -> Result<String, FormatError> {
    let format = |message: String| FormatError { format: "CSV", message };
    let bytes = |writer: Writer<Vec<u8>>| writer.into_inner().map_err(|e| format(e.to_string()));
    let mut filled = Writer::from_writer(Vec::new());
    fill(&mut filled).map_err(|e| format(e.to_string()))?;
    let filled = bytes(filled)?;
    let mut writer = Writer::from_writer(Vec::with_capacity(filled.len()));
    for row in ReaderBuilder::new().has_headers(false).from_reader(&filled[..]).records() {
        let row = row.map_err(|e| format(e.to_string()))?;
        let fields = row.iter().map(|text| field(text).into_owned());
        writer.write_record(fields).map_err(|e| format(e.to_string()))?;
    }
    String::from_utf8(bytes(writer)?).map_err(|e| format(e.to_string()))
}

/// A number as the columns have it; empty when there is none.
pub fn number(x: Option<f64>) -> String {
    x.map(|x| format!("{x:.9}")).unwrap_or_default()
}

/// A median and the ends of its interval as the columns have them.
pub fn estimate(e: Option<Estimate>) -> [String; 3] {
    [number(e.map(|e| e.median)), number(e.map(|e| e.low)), number(e.map(|e| e.high))]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fields_are_defused_and_numbers_stay() {
        let rows = [["=1+1", "-2.5", "a\n::b"], ["plain, \"text\"", "", "-2+3"]];
        let text = written(|writer| rows.iter().try_for_each(|row| writer.write_record(row)));
        assert_eq!(text.unwrap(), "'=1+1,-2.5,a\\n::b\n\"plain, \"\"text\"\"\",,'-2+3\n");
    }
}
