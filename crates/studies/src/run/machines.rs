//! Tables of a run on several machines.

use measurement::record::label;
use measurement::record::machines::{MachineRatio, MachinesRecord};
use presentation::csv::{estimate, written};
use presentation::json::FormatError;
use presentation::markdown::push_table;
use presentation::numbers;
use presentation::table::{Cell, Style, Table, dash};

/// The means over all scenes: rows and quantities down, machines across, and the range over these.
pub fn table(record: &MachinesRecord) -> Table {
    let mut header = vec!["structure", "of", "mean", "range over machines", "most/least"];
    let names = ["1", "2", "3", "4", "5", "6", "7", "8"];
    // more machines are in the files
    header.extend(names.iter().take(record.machines.len()));
    let rows = record.ratios.iter().filter(|ratio| ratio.scene.is_none()).map(|ratio| {
        let text = format!("{} to {}", numbers::short(ratio.least), numbers::short(ratio.most));
        let style = if ratio.is_apart { Style::Bad } else { Style::Plain };
        let mut cells: Vec<Cell> = vec![
            label(&ratio.structure, &ratio.settings).into(),
            ratio.quantity.clone().into(),
            numbers::short(ratio.mean).into(),
            Cell { text, style },
            format!("{:.2}", ratio.most / ratio.least).into(),
        ];
        let of = |e: &Option<_>| e.as_ref().map_or_else(dash, |e| numbers::ratio(e).into());
        cells.extend(ratio.of_machines.iter().take(names.len()).map(of));
        cells
    });
    Table {
        title: format!("{} machines: ratios to {}", record.machines.len(), record.reference),
        header,
        rows: rows.collect(),
        notes: notes(record),
    }
}

/// Describes the machines, and how often they matter.
fn notes(record: &MachinesRecord) -> Vec<String> {
    let machine = |(i, run): (usize, &measurement::record::machines::MachineRun)| {
        let cpu = run.machine.cpu.as_deref().unwrap_or("unknown processor");
        let processes = match run.processes {
            1 => "one process".to_owned(),
            n => format!("{n} processes"),
        };
        let measurement::record::Machine { threads, os, .. } = &run.machine;
        format!("{}: {cpu}, {threads} threads, {os}, {processes}.", i + 1)
    };
    let mut notes: Vec<String> = record.machines.iter().enumerate().map(machine).collect();
    let of_scenes = || record.ratios.iter().filter(|ratio| ratio.scene.is_some());
    let apart = of_scenes().filter(|ratio| ratio.is_apart).count();
    notes.push(format!(
        "Of {} ratios of scenes, {apart} differ significantly between two machines (corrected \
         for the number of tests): trust only their range.",
        of_scenes().count()
    ));
    if let Some(needed) = record.rounds_needed {
        notes.push(format!(
            "No ratio of a scene can differ significantly with so few rounds in one process: run --rounds {needed}, or \
             --processes 3."
        ));
    }
    for [one, other] in record.perhaps_one() {
        notes.push(format!(
            "{one} and {other} may be the same machine: their records show no difference."
        ));
    }
    notes
}

pub fn markdown(record: &MachinesRecord) -> Result<String, FormatError> {
    let mut text = "# rtbench: one run on several machines\n\n".to_owned();
    push_table(&mut text, &table(record));
    Ok(text)
}

/// One row a ratio; means over all scenes have none.
pub fn csv(record: &MachinesRecord) -> Result<String, FormatError> {
    written(|writer| {
        let mut header: Vec<String> =
            ["scene", "structure", "settings", "quantity", "mean", "least", "most", "apart"]
                .map(str::to_owned)
                .into();
        for machine in 1..=record.machines.len() {
            header.extend(["", "_low", "_high"].map(|end| format!("machine_{machine}{end}")));
        }
        writer.write_record(header)?;
        for ratio in &record.ratios {
            let MachineRatio { scene, structure, settings, quantity, mean, least, most, .. } =
                ratio;
            let mut fields = vec![
                scene.clone().unwrap_or_default(),
                structure.clone(),
                settings.clone(),
                quantity.clone(),
            ];
            fields.extend([mean, least, most].map(f64::to_string));
            fields.push(ratio.is_apart.to_string());
            fields.extend(ratio.of_machines.iter().flat_map(|e| estimate(*e)));
            writer.write_record(fields)?;
        }
        Ok(())
    })
}
