//! `rtbench bisect`: which commit made a row slower.

use std::path::PathBuf;

use crate::args::BisectArgs;
use crate::bisect::{
    BisectError, BisectRow, Chosen, Found, Judge, Judged, Recipe, Trees, Verdict, between, search,
};
use crate::context::Context;
use crate::error::Error;
use crate::gate::GateError;
use crate::gate::thresholds::Thresholds;
use crate::git::{Commit, Git, short};
use crate::report::utc;
use measurement::system::program_copy::ProgramCopy;
use measurement::system::progress::Progress;
use presentation::outside::line;

/// The program that `cargo build --release` leaves.
const OWN: &str = "target/release/rtbench";

/// Finds the commit, a line for each that was asked, and prints it with its neighbours.
///
/// # Errors
/// [`Error`] for commits that are not known or not built, and a bad one that is not slow.
pub fn run(
    context: &mut Context<'_>,
    args: &BisectArgs,
    configured: Thresholds,
) -> Result<(), Error> {
    let time = args.time_threshold.unwrap_or(configured.time);
    let thresholds = Thresholds { time, ..configured }.checked().map_err(GateError::from)?;
    let chosen = chosen(args)?;
    let git = Git::at(&args.repository).map_err(BisectError::from)?;
    let commit = |name: &str| git.commit(name).map_err(BisectError::from);
    let (good, bad) = (commit(&args.good)?, commit(&args.bad)?);
    let mut commits = between(&git, &good, &bad)?;
    commits.insert(0, good.clone());
    let recipe = Recipe {
        build: args.build.clone(),
        binary: args.binary.clone().unwrap_or_else(own_program),
    };
    let temporary = context.environment.temporary.clone().unwrap_or_else(std::env::temp_dir);
    let trees = Trees::new(&git, &recipe, &good, &temporary)?;
    let progress = Progress::new(context.shows_progress(), commits.len() as u64, None);
    progress.message(format!("building {}", short(&good.id)));
    let unbuilt = |commit: &Commit, why| BisectError::Unbuilt { commit: short(&commit.id), why };
    let program = trees.program(&good)?.map_err(|why| unbuilt(&good, why))?;
    let judge = Judge {
        good: program.path(),
        chosen: &chosen,
        thresholds,
        rounds: args.rounds,
        seed: args.seed,
        clock: context.clock,
    };
    let mut known: Vec<Option<Judged>> = vec![None; commits.len()];
    let mut ask = |place: usize| -> Result<Verdict, Error> {
        let Some(commit) = commits.get(place) else { return Ok(Verdict::Skip) };
        let judged = judged(&trees, &judge, commit, &progress)?;
        let verdict = judged.verdict;
        progress.step(context.clock.now());
        let said = format!("{:7} {} {}", verdict.name(), described(commit), judged.why);
        writeln!(context.out, "{}", line(said.trim_end()))?;
        context.out.flush()?;
        if let Some(own) = known.get_mut(place) {
            *own = Some(judged);
        }
        Ok(verdict)
    };
    let last = commits.len() - 1;
    let is_bad = ask(last)? == Verdict::Bad;
    let found = if is_bad { Some(search(last, &mut ask)?) } else { None };
    progress.finish();
    let Some(found) = found else {
        let found = known.pop().flatten().map_or(String::new(), |judged| judged.why);
        let [good, bad] = [&good, &bad].map(|commit| short(&commit.id));
        return Err(BisectError::NotSlower { good, bad, found }.into());
    };
    for text in conclusion(&commits, &known, &found) {
        writeln!(context.out, "{}", line(&text))?;
    }
    context.out.flush()?;
    Ok(())
}

/// What is measured.
fn chosen(args: &BisectArgs) -> Result<Chosen, BisectError> {
    if args.binary.is_some() {
        return Ok(Chosen::All(args.rows.clone()));
    }
    let rows = args.rows.iter().map(|text| BisectRow::parse(&text.to_string_lossy()));
    Ok(Chosen::Rows(rows.collect::<Result<_, _>>()?))
}

fn own_program() -> PathBuf {
    PathBuf::from(OWN).with_extension(std::env::consts::EXE_EXTENSION)
}

/// Builds a commit and measures it in turns with the good one.
fn judged(
    trees: &Trees<'_>,
    judge: &Judge<'_>,
    commit: &Commit,
    progress: &Progress,
) -> Result<Judged, BisectError> {
    progress.message(format!("building {}", short(&commit.id)));
    let skipped = |why| Ok(Judged { verdict: Verdict::Skip, why });
    let program = match trees.program(commit)? {
        Ok(program) => program,
        Err(why) => return skipped(why),
    };
    progress.message(format!("measuring {}", short(&commit.id)));
    let copy = ProgramCopy::of(program.path(), trees.temporary())?;
    judge.judge(program.path(), copy.path(), progress)
}

/// `8c1f2e 2026-11-20 subject:`
fn described(commit: &Commit) -> String {
    let day: String = utc(commit.unix_s).chars().take(10).collect();
    format!("{} {day} {}:", short(&commit.id), commit.subject)
}

/// The commit, or those that it is one of; and how its neighbours are.
fn conclusion(commits: &[Commit], known: &[Option<Judged>], found: &Found) -> Vec<String> {
    let said = |place: usize| {
        let why = match known.get(place).and_then(Option::as_ref) {
            Some(judged) => judged.why.as_str(),
            None if place == 0 => "all ratios are to it",
            None => "not measured",
        };
        commits.get(place).map(|commit| format!("{} {why}", described(commit)))
    };
    let name = |place: usize| commits.get(place).map_or(String::new(), |c| short(&c.id));
    let mut lines = vec![match found.skipped.is_empty() {
        true => format!("{} is the first slow commit", name(found.bad)),
        false => {
            let candidates = found.skipped.iter().chain([&found.bad]).map(|place| name(*place));
            let candidates: Vec<String> = candidates.collect();
            format!("The first slow commit is one of {}", candidates.join(", "))
        }
    }];
    let after = found.bad + 1;
    for (head, place) in [("before", found.good), ("it", found.bad), ("after", after)] {
        lines.extend(said(place).map(|said| format!("  {head}: {said}")));
    }
    lines
}
