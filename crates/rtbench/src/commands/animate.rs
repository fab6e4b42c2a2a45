//! `rtbench animate`: measure structures over the frames of a scene that moves, print, export,
//! plot.

use std::path::Path;

use renderer::Image;
use scene_loading::{Scene, ViewOptions, animation};

use crate::args::AnimateArgs;
use crate::commands::render::{image_of, structure};
use crate::context::Context;
use crate::error::{Error, SUCCESS, WRONG_HITS};
use measurement::plan::rows::Row;
use measurement::settings::Precision;
use measurement::system::files::write_text;
use measurement::system::pools::Pools;
use measurement::system::progress::Progress;
use presentation::json;
use studies::animate::measure::measure;
use studies::animate::record::AnimationRecord;
use studies::animate::{Animate, report};
use studies::error::UnsavedImage;

/// The files of `-o`.
const NAMES: [&str; 5] = ["animation.json", "frames.csv", "animate.md", "animate.svg", "strip.png"];

/// Pictures in a strip at most, and pixels of a side of each.
const PICTURES: (u32, u32) = (8, 160);

pub fn run(context: &mut Context<'_>, args: &AnimateArgs, view: &ViewOptions) -> Result<u8, Error> {
    let mut scene = animation::open(&args.scene)?;
    let name = scene.name().to_owned();
    let (measuring, of) = (args.measuring.settings(), (&*name, scene.frames()));
    let animate = Animate::new(args.frames, &args.structures, measuring, of, context.registry)?;
    context.warn_of_instructions();
    let _created = context.created_folder(args.output.as_ref(), &NAMES)?;
    let [first, last] = animate.frames;
    let start = context.clock.now();
    let mut record = new_record(context, &animate);
    let strip = || Strip::new(&animate, structure(context.registry, None)?);
    let mut strip = args.output.as_ref().map(|_| strip()).transpose()?;
    let progress = Progress::new(context.shows_progress(), u64::from(last - first) + 1, None);
    let clock = context.clock;
    let shown = (clock, &progress);
    let (mut unwritten, mut too_fine) = (None, None);
    let load = |number: u32| {
        let mut scene = scene.frame(number)?;
        view.apply(&mut scene)?;
        if animate.plan.precision == Precision::F32 && too_fine.is_none() {
            too_fine.clone_from(&scene.fine_detail);
        }
        if let Some(strip) = &mut strip {
            strip.see(number, &scene);
        }
        Ok(scene)
    };
    let watch = |record: &mut AnimationRecord| {
        record.took_s = clock.seconds_since(start);
        if let Some(folder) = &args.output {
            unwritten = write_all(folder, record).err();
        }
    };
    let measured = match animate.plan.precision {
        Precision::F32 => measure::<f32>(&animate, load, shown, &mut record, watch),
        Precision::F64 => measure::<f64>(&animate, load, shown, &mut record, watch),
    };
    progress.finish();
    if let Some(warning) = too_fine {
        context.warn(format_args!("{name}: {warning}"));
    }
    // what was finished is shown, whatever ended it
    record.complete = measured.is_ok();
    let screen = context.screen();
    if !record.frames.is_empty() {
        for table in report::tables(&record) {
            screen.write_fitted(context.out, &table, &report::FIRST)?;
            writeln!(context.out)?;
        }
        screen.write_notes(context.out, report::GLOSSARY)?;
    }
    if let Some(folder) = &args.output {
        unwritten = write_all(folder, &record).err().or(unwritten);
        if let Some(strip) = strip {
            strip.save(&folder.join(NAMES[4]))?;
        }
    }
    measured?;
    if let Some(error) = unwritten {
        return Err(error);
    }
    let is_wrong = record.lanes.iter().any(|lane| lane.mismatches > 0 && !lane.is_timed());
    Ok(if is_wrong { WRONG_HITS } else { SUCCESS })
}

fn new_record(context: &Context<'_>, animate: &Animate<'_>) -> AnimationRecord {
    AnimationRecord {
        tool: context.world.tool.clone(),
        command_line: context.command_line.clone(),
        machine: (context.world.machine)(),
        compiler: context.world.compiler.clone(),
        scene: animate.scene.clone(),
        rounds: animate.rounds,
        seed: animate.plan.seed,
        resolution: animate.plan.settings.resolution,
        precision: animate.plan.precision.name().into(),
        kinds: animate.plan.kinds.iter().map(|kind| kind.name().into()).collect(),
        ..AnimationRecord::default()
    }
}

/// Everything so far, so that a killed run keeps what it finished.
fn write_all(folder: &Path, record: &AnimationRecord) -> Result<(), Error> {
    let write = |name: &str, text: String| write_text(&folder.join(name), &text);
    let [json_name, frames, markdown, svg, _] = NAMES;
    write(json_name, json::written(record)?)?;
    write(frames, report::frames(record)?)?;
    write(markdown, report::to_markdown(record))?;
    Ok(write(svg, report::to_svg(record))?)
}

/// Pictures of some frames, one beside the other.
struct Strip<'r> {
    row: Row<'r>,
    wanted: Vec<u32>,
    pictures: Vec<Image>,
    pools: Pools,
}

impl<'r> Strip<'r> {
    fn new(animate: &Animate<'_>, row: Row<'r>) -> Result<Self, Error> {
        let [first, last] = animate.frames;
        let (most, _) = PICTURES;
        let count = (last - first + 1).min(most);
        let at = |i: u32| first + i * (last - first) / count.saturating_sub(1).max(1);
        let wanted = (0..count).map(at).collect();
        Ok(Self { row, wanted, pictures: Vec::new(), pools: Pools::new(1)? })
    }

    fn see(&mut self, number: u32, scene: &Scene) {
        if self.wanted.contains(&number) {
            let (row, (_, size)) = (&self.row, PICTURES);
            self.pictures.extend(self.pools.helper.install(|| image_of(scene, row, size)));
        }
    }

    fn save(&self, path: &Path) -> Result<(), Error> {
        let (_, size) = PICTURES;
        let width = size * self.pictures.len() as u32;
        let rows = (0..size as usize).flat_map(|y| {
            let line = move |image: &'_ Image| {
                let begin = y * size as usize;
                image.pixels.get(begin..begin + size as usize).unwrap_or_default().to_vec()
            };
            self.pictures.iter().flat_map(line)
        });
        let strip = Image { width, height: size, pixels: rows.collect() };
        if width == 0 {
            return Ok(());
        }
        let saved = strip.save_png(path);
        saved.map_err(|source| UnsavedImage { path: path.into(), source }.into())
    }
}
