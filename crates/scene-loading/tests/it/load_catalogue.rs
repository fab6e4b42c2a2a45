//! Scene files, sets, the catalogue, packages and the checks of loaded scenes.

use std::path::{Path, PathBuf};

use glam::DVec3;
use scene_loading::fetch::{PackageAsset, Places};
use scene_loading::info::{SceneInfo, validate};
use scene_loading::scene_file::{SceneFile, Source};
use scene_loading::scene_set::SceneSet;
use scene_loading::{Light, LoadError, Material, SceneCatalogue, SceneRef, Shape};

const OBJ: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl red\nf 1 2 3\n";

fn scene_json(source: &str, more: &str) -> String {
    format!(
        "{{\n  \"name\": \"a\", \"title\": \"t\", \"why\": \"w\",\n  \"source\": {source}{more}\n}}"
    )
}

fn parse(text: &str) -> Result<SceneFile, LoadError> {
    SceneFile::parse(Path::new("dir/a.json"), text)
}

fn names(names: &[&str]) -> Vec<String> {
    names.iter().map(|n| n.to_string()).collect()
}

/// The scene of that name.
fn named(catalogue: &SceneCatalogue, name: &str) -> SceneRef {
    catalogue.resolve(&names(&[name])).unwrap().remove(0)
}

fn nowhere() -> Places {
    Places { cargo_home: None, cache: None }
}

/// A folder with `a.json` and the OBJ file that it may refer to.
fn folder(json: &str) -> (tempfile::TempDir, SceneCatalogue) {
    let (folder, path) = crate::folder(&[("a.json", json), ("x.obj", OBJ)]);
    let mut catalogue = SceneCatalogue::embedded().unwrap();
    catalogue.add_folder(&path).unwrap();
    (folder, catalogue)
}

#[test]
fn embedded_scenes_and_sets_are_valid_and_resolve() {
    let catalogue = SceneCatalogue::embedded().unwrap();
    let scenes: Vec<&str> = catalogue.scenes().map(|s| s.name.as_str()).collect();
    let (effects, others): (Vec<&str>, Vec<&str>) =
        scenes.iter().partition(|name| name.starts_with("effect-"));
    assert_eq!(
        others,
        ["balls-tess", "gears-tess", "gears8-tess", "kitchen", "pavilion", "sponza", "tree-tess"]
    );
    assert_eq!(effects.len(), 12);
    for scene in catalogue.scenes() {
        assert!(scene.why.ends_with('.') && scene.licence.is_some(), "{}", scene.name);
    }
    let sets: Vec<&str> = catalogue.sets().map(|s| s.name.as_str()).collect();
    assert_eq!(sets, ["effects", "real", "small", "spd", "speed"]);
    for set in catalogue.sets() {
        assert_eq!(
            catalogue.resolve(std::slice::from_ref(&set.name)).unwrap().len(),
            set.scenes.len()
        );
    }
    // What is embedded is all there is.
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes");
    let mut again = SceneCatalogue::default();
    again.add_folder(&folder).unwrap();
    assert_eq!(again.scenes().count(), scenes.len());
    assert_eq!(again.sets().count(), sets.len());
}

#[test]
fn the_pavilion_loads_from_the_program_alone() {
    let catalogue = SceneCatalogue::embedded().unwrap();
    let scene = named(&catalogue, "pavilion");
    let loaded = scene.load_from(&nowhere()).unwrap();
    assert!(loaded.scene.is_triangles_only());
    assert_eq!(loaded.scene.name, "pavilion");
    assert_eq!(loaded.scene.lights.len(), 2);
    assert!(loaded.scene.warnings.is_empty(), "{:?}", loaded.scene.warnings);
    assert_eq!(validate(&loaded.scene), []);
    let info = SceneInfo::of(&loaded.scene);
    assert!(matches!(info.kinds[4], ("patches", 5_000..50_000)), "{info}");
    assert_eq!(loaded.sha256, "967a2830a229843ec8cd0c52db6aff239b935844c0c920b62acdedd83253673b");
    assert!(loaded.licence.unwrap().starts_with("CC0"));
    assert_eq!(scene.fetch().unwrap(), None);
}

#[test]
fn names_resolve_in_order_and_once() {
    let catalogue = SceneCatalogue::embedded().unwrap();
    let scenes = catalogue.resolve(&names(&["kitchen", "balls:5", "real", "balls:5"])).unwrap();
    let found: Vec<&str> = scenes.iter().map(|s| s.name.as_str()).collect();
    assert_eq!(found, ["kitchen", "balls:5", "sponza", "pavilion"]);
    assert!(scenes[0].description().is_some() && scenes[1].description().is_none());
}

#[test]
fn unknown_names_list_the_valid_ones_and_suggest() {
    let catalogue = SceneCatalogue::embedded().unwrap();
    for (name, nearest) in
        [("bals:5", "balls"), ("Kitchen", "kitchen"), ("spnoza", "sponza"), ("smal", "small")]
    {
        let error = catalogue.resolve(&names(&[name])).unwrap_err();
        assert!(matches!(error, LoadError::UnknownScene { .. }));
        let text = error.to_string();
        assert!(text.contains(&format!("did you mean `{nearest}`")), "{text}");
        assert!(text.contains("pavilion") && text.contains("spd") && text.contains(".nff.gz"));
    }
    let error = catalogue.resolve(&names(&["completely-else"])).unwrap_err();
    assert!(!error.to_string().contains("did you mean"), "{error}");
}

#[test]
fn paths_resolve_by_their_ending() {
    let (folder, catalogue) = folder(&scene_json(r#"{"file": "x.obj"}"#, ""));
    let obj = folder.path().join("x.obj");
    let json = folder.path().join("a.json");
    let text = |path: &PathBuf| path.to_str().unwrap().to_string();
    let scenes = catalogue.resolve(&[text(&obj), text(&json), "a".into()]).unwrap();
    assert_eq!(scenes.iter().map(|s| s.name.as_str()).collect::<Vec<_>>(), ["x", "a"]);
    for scene in &scenes {
        assert_eq!(scene.load_from(&nowhere()).unwrap().scene.primitives.len(), 1);
    }
    let missing = text(&folder.path().join("lost.obj"));
    let error = catalogue.resolve(&[missing]).unwrap_err();
    assert!(matches!(error, LoadError::Io { .. }) && error.to_string().contains("lost.obj"));
    let odd = folder.path().join("x.fbx");
    std::fs::write(&odd, "fbx").unwrap();
    let error = catalogue.resolve(&[text(&odd)]).unwrap_err();
    assert!(matches!(error, LoadError::UnknownFormat { .. }));
    assert!(error.to_string().contains(".obj.zst"), "{error}");
}

#[test]
fn a_scene_file_adds_what_its_source_lacks() {
    let (_folder, catalogue) = folder(&scene_json(
        r#"{"file": "x.obj"}"#,
        r#", "camera": {"from": [0,0,5], "at": [0,0,0], "up": [0,1,0], "angle": 30, "resolution": [64, 32]},
            "lights": [{"position": [1,2,3]}, {"position": [0,0,9], "color": [1,0.5,0]}],
            "background": [0.1, 0.2, 0.3], "licence": "CC0-1.0", "effects": {},
            "materials": {"red": {"color": [1,0,0], "specular": 0.25}}"#,
    ));
    let loaded = named(&catalogue, "a").load_from(&nowhere()).unwrap();
    let scene = &loaded.scene;
    assert_eq!((scene.camera.from, scene.camera.angle), (DVec3::Z * 5.0, 30.0));
    assert_eq!(scene.camera.resolution, [64, 32]);
    assert_eq!(scene.lights.len(), 2);
    let color = Some([1.0, 0.5, 0.0]);
    assert_eq!(scene.lights[1], Light::point(DVec3::Z * 9.0, color));
    assert_eq!(scene.background, [0.1, 0.2, 0.3]);
    let red = Material {
        name: "red".into(),
        color: [1.0, 0.0, 0.0],
        specular: 0.25,
        ..Material::default()
    };
    assert_eq!(scene.materials, [red]);
    assert_eq!(loaded.licence.as_deref(), Some("CC0-1.0"));
}

#[test]
fn faults_of_scene_files_have_line_and_column() {
    for (text, line, says) in [
        (
            scene_json(r#"{"file": "x.obj"}"#, ",\n  \"effects\": {\"fog\": 1}"),
            4,
            "unknown field `fog`",
        ),
        (scene_json(r#"{"file": "x.obj"}"#, ",\n\n  \"colour\": 1"), 5, "unknown field `colour`"),
        (scene_json(r#"{"url": "x.obj"}"#, ""), 3, "unknown variant `url`"),
        (scene_json(r#"{"file": "x.obj"}"#, ",\n  \"background\": [1, 2]"), 4, "length"),
        (scene_json(r#"{"file": "x.obj"}"#, ",\n  \"background\": [1, 1e400, 2]"), 4, "range"),
        ("{\n  \"name\": \"a\"\n}".to_string(), 3, "missing field"),
        ("{\n  \"name\": ".to_string(), 2, "EOF"),
        (String::new(), 1, "EOF"),
    ] {
        let error = parse(&text).expect_err(&text);
        let LoadError::Json { column, .. } = &error else { panic!("{error}") };
        let message = error.to_string();
        assert!(message.starts_with(&format!("dir/a.json:{line}:{column}: ")), "{message}");
        assert!(message.contains(says) && !message.contains("at line"), "{message}");
    }
}

#[test]
fn scene_files_that_make_no_sense() {
    let file = r#"{"file": "x.obj"}"#;
    let asset = |name: &str, version: &str, path: &str| {
        format!(r#"{{"crate": {{"name": "{name}", "version": "{version}", "path": "{path}"}}}}"#)
    };
    let hash = format!(r#", "sha256": "{}""#, "0".repeat(64));
    let camera = r#", "camera": {"from": [0,0,0], "at": [0,0,0], "up": [0,1,0], "angle": 30}"#;
    for text in [
        scene_json(file, r#", "sha256": "12""#),
        scene_json(file, r#", "tessellate": {"resolution": 0}"#),
        scene_json(file, camera),
        scene_json(&asset("obvhs", "0.4.0", "a.obj"), ""),
        scene_json(&asset("obvhs", "0.4.0", "../a.obj"), &hash),
        scene_json(&asset("obvhs", "*", "a.obj"), &hash),
        scene_json(&asset(r#"x = \"1\"\n"#, "0.4.0", "a.obj"), &hash),
        scene_json(file, "").replace("\"a\"", "\"b\""),
    ] {
        let error = parse(&text).expect_err(&text);
        let typed = matches!(error, LoadError::Syntax { .. } | LoadError::OutOfRange { .. });
        assert!(typed && error.to_string().starts_with("dir/a.json: "), "{error}");
    }
    assert!(parse(&scene_json(&asset("obvhs", "0.4.0", "a.obj"), &hash)).is_ok());
    assert_eq!(
        parse(&scene_json(r#"{"spd": "balls:4"}"#, "")).unwrap().source,
        Source::Spd("balls:4".into())
    );

    let (_folder, catalogue) = folder(&scene_json(file, r#", "materials": {"green": {}}"#));
    let error = named(&catalogue, "a").load_from(&nowhere()).unwrap_err();
    assert!(error.to_string().contains("`green`") && error.to_string().contains("red"), "{error}");
}

#[test]
fn a_wrong_hash_is_an_error() {
    let more = format!(r#", "sha256": "{}""#, "0".repeat(64));
    let (_folder, catalogue) = folder(&scene_json(r#"{"file": "x.obj"}"#, &more));
    let error = named(&catalogue, "a").load_from(&nowhere()).unwrap_err();
    assert!(matches!(error, LoadError::HashMismatch { .. }), "{error}");
    assert!(error.to_string().contains("x.obj"), "{error}");
}

#[test]
fn sets_are_checked() {
    let parse = |text: &str| SceneSet::parse(Path::new("sets/s.json"), text);
    assert!(parse(r#"{"name": "s", "title": "t", "scenes": ["balls"]}"#).is_ok());
    let error = parse("{\"name\": \"s\",\n\"scene\": []}").unwrap_err();
    assert!(error.to_string().starts_with("sets/s.json:2:"), "{error}");
    assert!(matches!(
        parse(r#"{"name": "s", "title": "t", "scenes": []}"#),
        Err(LoadError::Syntax { .. })
    ));
    assert!(parse(r#"{"name": "x", "title": "t", "scenes": ["balls"]}"#).is_err());
}

#[test]
fn packages_are_found_in_cargo_and_copied_to_the_cache() {
    let media = "cargo/registry/src/index-1/some-1.2.3/media";
    let (_folder, path) = crate::folder(&[
        (&*format!("{media}/a.obj"), OBJ),
        (&*format!("{media}/a.mtl"), "newmtl red\nKd 1 0 0\n"),
    ]);
    let package = path.join(media);
    let mut places =
        Places { cargo_home: Some(path.join("cargo")), cache: Some(path.join("cache")) };
    let asset = |version: &str| PackageAsset {
        name: "some".into(),
        version: version.into(),
        path: "media/a.obj".into(),
    };
    assert_eq!(places.locate(&asset("1.2.3")), Some(package.join("a.obj")));
    assert_eq!(places.locate(&asset("1.2.4")), None);
    let cached = places.fetch(&asset("1.2.3")).unwrap();
    assert_eq!(cached, path.join("cache/some-1.2.3/media/a.obj"));
    assert!(cached.with_extension("mtl").is_file());
    // Cargo's copy is no longer needed.
    places.cargo_home = None;
    assert_eq!(places.locate(&asset("1.2.3")), Some(cached));
    let bad = PackageAsset { path: "../x".into(), ..asset("1.2.3") };
    assert!(places.fetch(&bad).is_err());
}

#[test]
fn warnings_about_a_package_do_not_say_where_it_lies() {
    let obj = "mtllib lost.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\nf 1 2 2\n";
    let hash = "3e27fb8680c098f697a4db54b9831691e26c13d59783f61ae2f5644ab3214034";
    let (_cache, cache) = crate::folder(&[("some-1.2.3/media/a.obj", obj)]);
    let source = r#"{"crate": {"name": "some", "version": "1.2.3", "path": "media/a.obj"}}"#;
    let (_folder, catalogue) = folder(&scene_json(source, &format!(r#", "sha256": "{hash}""#)));
    let places = Places { cargo_home: None, cache: Some(cache) };
    let loaded = named(&catalogue, "a").load_from(&places).unwrap();
    assert_eq!(loaded.source, "some 1.2.3: media/a.obj");
    assert_eq!(
        crate::warnings(&loaded.scene),
        [
            "some 1.2.3: media/a.obj:1: material file some 1.2.3: media/lost.mtl is missing",
            "some 1.2.3: media/a.obj: 1 faces without area left out (first: line 6)",
            "no lights: added one at the eye; set others with --light X,Y,Z or a scene file"
        ]
    );
}

#[test]
fn a_package_that_is_not_there_says_how_to_get_it() {
    let catalogue = SceneCatalogue::embedded().unwrap();
    for name in ["kitchen", "sponza"] {
        let error = named(&catalogue, name).load_from(&nowhere()).unwrap_err();
        assert!(matches!(error, LoadError::NotFetched { .. }), "{error}");
        let command = format!("rtbench scenes fetch {name}");
        assert!(error.to_string().contains(&command), "{error}");
    }
}

/// Loads the scenes of packages where these are on the machine; elsewhere there is nothing to do.
#[test]
fn fetched_scenes_load() {
    let catalogue = SceneCatalogue::embedded().unwrap();
    // kitchen as when it was read by tobj; sponza has quads, cut by ears of our own since
    let hashes = [
        "2b40301d63dcf14ebc8e31b44699e5838a7dced10a0acf3b13909496e92e00e7",
        "22c3d62c7c1c5df8c3fbcf93f902b22d06c1bd93334a14072f227990474d50cf",
    ];
    let scenes = catalogue.resolve(&names(&["kitchen", "sponza"])).unwrap();
    for (scene, hash) in scenes.iter().zip(hashes) {
        match scene.load() {
            Ok(loaded) => {
                assert_eq!(loaded.sha256, hash, "{}", scene.name);
                assert!(loaded.scene.is_triangles_only());
                assert!(loaded.scene.primitives.len() > 50_000);
                assert_eq!(validate(&loaded.scene), []);
            }
            Err(LoadError::NotFetched { .. }) => {}
            Err(error) => panic!("{error}"),
        }
    }
}

#[test]
fn validation_finds_planted_faults() {
    let catalogue = SceneCatalogue::embedded().unwrap();
    let good = named(&catalogue, "pavilion").load().unwrap().scene;
    type Plant = fn(&mut scene_loading::Scene);
    let plants: [(&str, Plant); 9] = [
        ("material that does not exist", |s| s.primitives[5].material = 99),
        ("do not exist", |s| s.primitives[5].shape = Shape::Sphere(0)),
        ("do not exist", |s| s.primitives[5].shape = Shape::Polygon { first: u32::MAX, count: 9 }),
        ("not finite", |s| s.vertices[7].x = f64::NAN),
        ("without area", |s| s.primitives[5].shape = Shape::Triangle { v: [1, 1, 2] }),
        ("off their plane", |s| {
            let corners = [DVec3::ZERO, DVec3::X, DVec3::ONE, DVec3::Y];
            s.push_polygon(0, &corners);
        }),
        ("normals of length 0", |s| s.normals[3] = DVec3::ZERO),
        ("no lights", |s| s.lights.clear()),
        ("camera angle", |s| s.camera.angle = 360.0),
    ];
    for (says, plant) in plants {
        let mut scene = good.clone();
        plant(&mut scene);
        let warnings = validate(&scene);
        assert!(warnings.iter().any(|w| w.0.contains(says)), "{says}: {warnings:?}");
        let _ = SceneInfo::of(&scene).to_string();
    }
}
