//! `rtbench compare`: two or more runs side by side.

use regex_lite::Regex;

use crate::args::{CompareArgs, CompareFormat};
use crate::comparison::{
    self, CompareError, Comparison, ComparisonSettings, NamedRun, default_metrics, renamed, tables,
};
use crate::context::Context;
use crate::error::{Error, SUCCESS};
use measurement::record::file;
use measurement::record::metrics::{self, METRICS};
use presentation::json;

/// Prints. What changed is no failure: `rtbench check` is the gate.
pub fn run(context: &mut Context<'_>, args: &CompareArgs) -> Result<u8, Error> {
    let choice = choice(args)?;
    let mut runs =
        args.results.iter().map(|path| file::read(path)).collect::<Result<Vec<_>, _>>()?;
    let mut matched = Vec::new();
    if let Some((old, others)) = runs.split_first_mut() {
        for text in &args.matches {
            matched.push(renamed::matched(text, old, others)?);
        }
        matched.iter().for_each(|renamed| renamed.apply(old));
    }
    let paths: Vec<String> = args.results.iter().map(|p| p.display().to_string()).collect();
    let letters: Vec<String> = (0..runs.len()).map(letter).collect();
    let all = letters.iter().zip(&paths).zip(&runs);
    let mut named = all.map(|((letter, path), run)| NamedRun { letter, path, run });
    let mut comparisons = Vec::new();
    if let Some(old) = named.next() {
        for new in named {
            comparisons.push(comparison::compare(old, new, &choice)?);
        }
    }
    for comparison in &mut comparisons {
        warn_of_comparison(context, comparison);
        comparison.notes.extend(matched.iter().map(ToString::to_string));
    }
    let screen = context.screen();
    match args.format {
        CompareFormat::Text => tables::write(context.out, &comparisons, screen)?,
        CompareFormat::Markdown => write!(context.out, "{}", tables::to_markdown(&comparisons))?,
        CompareFormat::Csv => write!(context.out, "{}", tables::to_csv(&comparisons)?)?,
        CompareFormat::Json => write!(context.out, "{}", json::written(&comparisons)?)?,
    }
    Ok(SUCCESS)
}

fn choice(args: &CompareArgs) -> Result<ComparisonSettings, Error> {
    let filter = |text: &String| {
        let error = |message| CompareError::Filter { filter: text.clone(), message };
        Regex::new(text).map_err(|e| error(e.to_string()))
    };
    let metrics = match &args.metrics[..] {
        [] => default_metrics(),
        names if names.iter().any(|name| name == "all") => METRICS.iter().collect(),
        names => names.iter().map(|name| metrics::named(name)).collect::<Result<_, _>>()?,
    };
    Ok(ComparisonSettings {
        metrics,
        shows_equal: !args.metrics.is_empty(),
        filter: args.filter.as_ref().map(filter).transpose()?,
        margin: args.margin,
        threshold: args.threshold,
        is_forced: args.force,
    })
}

/// `A`, `B`, ..., `Z`, `AA`, ...
fn letter(place: usize) -> String {
    let last = char::from(b'A' + (place % 26) as u8);
    match place / 26 {
        0 => last.to_string(),
        more => letter(more - 1) + &last.to_string(),
    }
}

/// Warns on standard error, as the output may go to a file.
fn warn_of_comparison(context: &mut Context<'_>, comparison: &Comparison) {
    for note in &comparison.notes {
        context.warn(note);
    }
    for row in &comparison.answers_changed {
        context.warn(format_args!(
            "ANSWERS CHANGED: {row}: {} and {} hit differently for the same rays; `rtbench \
             verify` tells which is right",
            comparison.old.letter, comparison.new.letter
        ));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn letters_continue_after_z() {
        assert_eq!([0, 25, 26, 27, 52].map(letter), ["A", "Z", "AA", "AB", "BA"]);
    }
}
