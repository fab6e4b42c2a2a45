//! Effects on the command line: plans, images, costs, heat maps.

use crate::common::{Folder, run, run_stepping};

#[test]
fn plans_name_what_calls_for_each_effect() {
    let ended = run("render effect-gloss --plan");
    assert_eq!((ended.code, ended.err.as_str()), (0, ""));
    let line = |name: &str| ended.out.lines().find(|l| l.starts_with(name)).expect(name).to_owned();
    assert!(line("glossy reflection").contains("1 mirror with a roughness"));
    assert!(line("hard shadows").contains("1 light without a radius"));
    for absent in ["soft shadows", "mirror", "refraction", "depth of field", "motion", "super"] {
        let line = line(absent);
        assert!(line.contains(" 0  nothing"), "{line}");
    }
    // dials of effects that are not called for change nothing; the others do
    assert_eq!(run("render effect-gloss --plan --samples focal=64").out, ended.out);
    assert_ne!(run("render effect-gloss --plan --samples glossy=64").out, ended.out);
    assert!(
        run("render effect-gloss --plan --samples supersamples=4")
            .out
            .contains("the command line asks")
    );
}

#[test]
fn images_are_png_or_exr() {
    let folder = Folder::new();
    for (ending, magic) in
        [("png", &b"\x89PNG"[..]), ("exr", b"\x76\x2f\x31\x01"), ("EXR", b"\x76")]
    {
        let path = format!("{}/image.{ending}", folder.path());
        let ended = run(&format!("render effect-all --size 8 -o {path}"));
        assert_eq!((ended.code, ended.out.as_str()), (0, ""), "{}", ended.err);
        assert!(std::fs::read(&path).unwrap().starts_with(magic), "{path}");
    }
    let same = |threads: u32| {
        let path = format!("{}/{threads}.exr", folder.path());
        run(&format!("render effect-all --size 16 -j {threads} -o {path}"));
        std::fs::read(path).unwrap()
    };
    assert!(same(1) == same(3));
}

#[test]
fn invalid_options_of_render_are_usage_errors() {
    let folder = Folder::new();
    for (arguments, said) in [
        (format!("render effect-all -o {}/image.jpg", folder.path()), ".png or .exr"),
        ("render effect-all".to_owned(), "--output"),
        ("render effect-all --plan --samples supersamples=0".to_owned(), "--samples"),
        ("render effect-all --plan --samples shadow=70000".to_owned(), "--samples"),
        ("render effect-all --plan --depth 0".to_owned(), "--depth"),
        (
            "render effect-all --plan --samples glossy=65536,shadow=65536".to_owned(),
            "at most 4194304",
        ),
        ("render effect-al --plan".to_owned(), "did you mean `effect-all`?"),
        ("cost effects".to_owned(), "one scene"),
        ("cost nothing".to_owned(), "unknown scene"),
        ("cost effect-all -s nothing".to_owned(), "unknown structure"),
    ] {
        let ended = run(&arguments);
        assert_eq!(ended.code, 2, "{arguments}: {}", ended.err);
        assert!(ended.err.contains(said), "{arguments}: {}", ended.err);
    }
}

#[test]
fn cost_switches_on_one_factor_after_the_other_and_draws_maps() {
    let folder = Folder::new();
    let maps = format!("{}/maps", folder.path());
    // a clock on which every image takes a millisecond
    let ended = run_stepping(&format!("cost effect-all --size 16 --heat-maps {maps}"));
    let wrote = format!("wrote {maps}: heat maps tests.svg, steps.svg, time.svg\n");
    assert_eq!((ended.code, ended.err), (0, wrote));
    let mut rows = ended.out.lines().skip(2);
    for factor in [
        "pixels x primitives  256 x 13",
        "ray tree",
        "shadow rays",
        "shadow samples",
        "glossy samples",
        "temporal samples",
        "focal samples",
        "supersamples",
    ] {
        // what does not fit in a row goes on below it
        let row = rows.find(|row| row.starts_with(&factor[..8])).unwrap_or_default();
        assert!(row.contains(" 1.00 "), "{factor}: {row}");
    }
    assert!(rows.any(|row| row.starts_with("times from lattice and pavilion")));
    assert!(ended.out.contains("predicted over measured"));
    for map in ["tests.svg", "steps.svg", "time.svg"] {
        assert!(std::fs::read(format!("{maps}/{map}")).unwrap().starts_with(b"<svg "), "{map}");
    }
}
