//! rtbench command line.
mod reproduce;
fn main() {
    let figures = reproduce::published::figures().unwrap();
    for scene in reproduce::published::SCENES {
        let t = std::time::Instant::now();
        for r in reproduce::reproduce_scene(scene, &reproduce::STRUCTURES, &figures).unwrap() {
            println!(
                "{:8} {:11} {:11} {:15} {:>10} {:>12.3} {:.4} {}",
                r.scene, r.structure, r.params, r.counter, r.published, r.ours, r.ratio, r.verdict
            );
        }
        eprintln!("{scene} {:?}", t.elapsed());
    }
}
