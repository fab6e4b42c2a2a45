//! `rtbench list`: what there is, made from the registries.

use std::io::{self, Write};

use accel_core::params::ParamSpec;
use accel_core::structure::StructureInfo;
use accel_core::structures::COMMON;
use renderer::RayKind;
use renderer::tracers::{TRACERS, TracerInfo};
use scene_loading::animation::ANIMATED;
use serde_json::{Value, json};

use crate::args::{Format, ListArgs, ListSubject};
use crate::context::Context;
use crate::error::{Error, SUCCESS};
use measurement::plan::error::chosen;
use measurement::scenes::{SceneSet, titles};
use presentation::json;
use presentation::text::Screen;
use studies::accuracy::axes::AXES;

pub fn run(context: &mut Context<'_>, args: &ListArgs) -> Result<u8, Error> {
    let (singular, value): (_, Vec<Value>) = match args.what {
        ListSubject::Structures => {
            let all = context.registry.iter().map(|e| structure(e.info, COMMON));
            ("structure", all.collect())
        }
        ListSubject::Occluders => {
            ("occluder", context.occluders.iter().map(|e| structure(e.info, &[])).collect())
        }
        ListSubject::Tracers => ("tracer", TRACERS.iter().map(|t| tracer(t)).collect()),
        ListSubject::Scenes => {
            let entry = |(name, summary)| json!({"name": name, "summary": summary});
            ("scene", titles(&context.scenes.catalogue()?).map(entry).collect())
        }
        ListSubject::Animations => {
            let all = ANIMATED.iter().map(|e| {
                json!({"name": e.name, "summary": e.summary, "frames": e.frames,
                       "default_size": e.default_size, "primitives": (e.count)(e.default_size)})
            });
            ("animation", all.collect())
        }
        ListSubject::Sets => {
            let entry = |set: &SceneSet| json!({"name": set.name, "scenes": set.scenes});
            ("set", context.scenes.catalogue()?.sets().map(entry).collect())
        }
        ListSubject::Rays => {
            let all = RayKind::ALL.iter().map(|k| {
                let question = if k.is_occlusion() { "occlusion" } else { "closest hit" };
                json!({"name": k.name(), "summary": k.summary(), "question": question})
            });
            ("kind of rays", all.collect())
        }
        ListSubject::Axes => {
            let all = AXES.iter().map(|axis| {
                json!({"name": axis.name, "summary": axis.summary, "paper": axis.paper,
                       "metric": axis.metric, "reference": axis.reference,
                       "setting": axis.setting, "default_scenes": axis.scenes})
            });
            ("axis", all.collect())
        }
    };
    let value =
        chosen(singular, &args.names, &value, |item| item["name"].as_str().unwrap_or_default())?;
    let is_asked = |name: &str| args.names.is_empty() || args.names.iter().any(|n| n == name);
    let screen = context.plain_screen();
    let out = &mut *context.out;
    match args.format {
        Format::Json => out.write_all(json::written(&value)?.as_bytes())?,
        Format::Text => match args.what {
            ListSubject::Structures => {
                let mut asked = context.registry.iter().filter(|e| is_asked(e.info.name));
                asked.try_for_each(|e| write_structure(out, screen, e.info))?;
                writeln!(out, "every structure:")?;
                COMMON.iter().try_for_each(|p| write_param(out, screen, p))?;
            }
            ListSubject::Occluders => {
                let mut asked = context.occluders.iter().filter(|e| is_asked(e.info.name));
                asked.try_for_each(|e| write_structure(out, screen, e.info))?;
            }
            ListSubject::Tracers => {
                let mut asked = TRACERS.iter().filter(|info| is_asked(info.name));
                asked.try_for_each(|info| write_tracer(out, screen, info))?;
            }
            _ => write_names(out, screen, &value)?,
        },
    }
    Ok(SUCCESS)
}

fn text(item: &Value, key: &str) -> String {
    item[key].as_str().unwrap_or_default().to_owned()
}

fn tracer(info: &TracerInfo) -> Value {
    json!({"name": info.name, "summary": info.summary, "paper": info.paper,
           "assumptions": info.assumptions, "deviations": info.deviations,
           "refuses": info.refuses})
}

fn write_tracer(out: &mut dyn Write, screen: Screen, info: &TracerInfo) -> io::Result<()> {
    screen.write_line(out, &format!("{}: {}", info.name, info.summary))?;
    screen.write_item(out, &format!("  paper:       {}", info.paper), 15)?;
    screen.write_item(out, &format!("  assumptions: {}", info.assumptions), 15)?;
    screen.write_item(out, &format!("  deviations:  {}", info.deviations), 15)?;
    screen.write_item(out, &format!("  refuses:     {}", info.refuses), 15)?;
    writeln!(out)
}

fn structure(info: &StructureInfo, common: &[ParamSpec]) -> Value {
    let params = info.params.iter().chain(common).map(|p| {
        json!({"name": p.name, "summary": p.summary, "default": p.default,
               "valid": p.kind.to_string()})
    });
    json!({"name": info.name, "summary": info.summary, "paper": info.paper,
           "deviations": info.deviations, "params": params.collect::<Vec<_>>(),
           "variants": info.variants, "sampled": info.sampled})
}

fn write_structure(out: &mut dyn Write, screen: Screen, info: &StructureInfo) -> io::Result<()> {
    screen.write_line(out, &format!("{}: {}", info.name, info.summary))?;
    screen.write_item(out, &format!("  paper:      {}", info.paper), 15)?;
    screen.write_item(out, &format!("  deviations: {}", info.deviations), 15)?;
    info.params.iter().try_for_each(|p| write_param(out, screen, p))?;
    for variant in info.variants.iter().filter(|v| !v.is_empty()) {
        screen.write_item(out, &format!("  variant: {variant}"), 4)?;
    }
    if info.sampled {
        writeln!(out, "  timed on a sample of the rays")?;
    }
    writeln!(out)
}

fn write_param(out: &mut dyn Write, screen: Screen, p: &ParamSpec) -> io::Result<()> {
    let text = format!("  {} = {}: {}; {}", p.name, p.default, p.summary, p.kind);
    screen.write_item(out, &text, 4)
}

/// A name a line, with its summary or its members.
fn write_names(out: &mut dyn Write, screen: Screen, items: &[Value]) -> io::Result<()> {
    let width = items.iter().map(|i| text(i, "name").chars().count()).max().unwrap_or(0);
    for item in items {
        let members = item["scenes"]
            .as_array()
            .map(|all| all.iter().filter_map(Value::as_str).collect::<Vec<_>>().join(", "));
        let about = members.unwrap_or_else(|| text(item, "summary"));
        let line = format!("{:<width$}  {about}", text(item, "name"));
        screen.write_item(out, &line, width + 2)?;
    }
    Ok(())
}
