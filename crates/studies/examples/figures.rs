//! How many of the figures of 1999 come out, table by table: `cargo run --release -p studies
//! --example figures [STRUCTURE,... [SCENE,...]]`; all of them take 20 minutes. The search for
//! their rules is logged in `results/figures/`.

use std::collections::BTreeMap;

use studies::reproduce::published::{SCENES, figures};
use studies::reproduce::verdict::Verdict;
use studies::reproduce::{reproduce_scene, structures};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let asked: Vec<String> = std::env::args().skip(1).collect();
    let all = [structures(), SCENES.to_vec()];
    let chosen = |n: usize| match asked.get(n) {
        Some(names) => names.split(',').collect(),
        None => all[n].clone(),
    };
    let figures = figures()?;
    let mut table: BTreeMap<(String, String), [usize; 4]> = BTreeMap::new();
    println!("scene,structure,params,counter,published,ours,verdict");
    for scene in chosen(1) {
        for row in reproduce_scene(scene, &chosen(0), &figures)? {
            let column = match row.verdict {
                Verdict::Exact => 0,
                Verdict::Within => 1,
                Verdict::KnownReason(_) => 2,
                Verdict::Unexplained => 3,
            };
            table.entry((row.structure.clone(), scene.to_owned())).or_default()[column] += 1;
            let (structure, params, counter) = (row.structure, row.params, row.counter);
            let (published, ours, verdict) = (row.published, row.ours, row.verdict);
            println!("{scene},{structure},{params},{counter},{published},{ours},{verdict}");
        }
    }
    println!("\nstructure,scene,exact,within tolerance,known reason,unexplained");
    for ((structure, scene), [exact, within, known, unexplained]) in table {
        println!("{structure},{scene},{exact},{within},{known},{unexplained}");
    }
    Ok(())
}
