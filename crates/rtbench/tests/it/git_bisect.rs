//! The lines of docs/ci.md that find a commit with `git bisect`, as they stand there: a repository
//! whose commits say how `rtbench check` would end.

use std::os::unix::fs::PermissionsExt;
use std::path::Path;
use std::process::Command;

use crate::common::Folder;

/// Ends with what stands in the plugin: as `rtbench check` of a commit would.
const STUB: &str = "#!/bin/sh\nexit \"$(cat ./mine.so)\"\n";

fn shell(folder: &str, script: &str) -> (bool, String) {
    let path = format!("{folder}/bin:{}", std::env::var("PATH").unwrap());
    let ended = Command::new("sh")
        .args(["-ec", script])
        .current_dir(format!("{folder}/repository"))
        .env("PATH", path)
        .output()
        .unwrap();
    let said = [ended.stdout, ended.stderr].concat();
    (ended.status.success(), String::from_utf8_lossy(&said).into_owned())
}

/// A repository with a commit for each code of `rtbench check`; none is one that cannot be built.
fn repository(codes: &[Option<u8>]) -> Folder {
    let folder = Folder::new();
    let path = folder.path();
    for name in ["bin", "repository"] {
        std::fs::create_dir(Path::new(&path).join(name)).unwrap();
    }
    let stub = Path::new(&path).join("bin/rtbench");
    std::fs::write(&stub, STUB).unwrap();
    std::fs::set_permissions(&stub, std::fs::Permissions::from_mode(0o755)).unwrap();
    let who = "git -c user.name=n -c user.email=e@example.org";
    let mut script = "git init -q; printf mine.so > .gitignore".to_owned();
    for (i, code) in codes.iter().enumerate() {
        let rule = code.map_or("false".to_owned(), |code| format!("printf {code} > mine.so"));
        script += &format!(
            "\nprintf '# {i}\\nmine.so: Makefile\\n\\t{rule}\\n' > Makefile
             git add -A; {who} commit -qm 'change {i}'; git tag c{i}"
        );
    }
    let (is_made, said) = shell(&path, &script);
    assert!(is_made, "{said}");
    folder
}

/// The block of the chapter, its commits replaced.
fn documented(last: usize) -> String {
    let chapter = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/ci.md");
    let text = std::fs::read_to_string(chapter).unwrap();
    let start = text.find("git bisect start").unwrap();
    let block = text[start..].split("```").next().unwrap();
    block.replace("BAD GOOD", &format!("c{last} c0"))
}

#[test]
fn the_documented_lines_find_the_planted_commit() {
    // inconclusive at 2, not built at 4, wrong hits at 5: skipped
    let codes = [0, 0, 5, 0, 1, 4, 0, 3, 3].map(Some);
    let mut codes = codes.to_vec();
    codes[4] = None;
    let folder = repository(&codes);
    let (is_found, said) = shell(&folder.path(), &documented(8));
    assert!(is_found, "{said}");
    let first = said.lines().find(|line| line.ends_with("is the first bad commit"));
    let (_, planted) = shell(&folder.path(), "git rev-parse c7");
    assert!(first.is_some_and(|line| line.starts_with(planted.trim())), "{said}");
    // a commit that is uncertain beside the slow one is not accused
    codes[6] = Some(5);
    let folder = repository(&codes);
    let (_, said) = shell(&folder.path(), &documented(8));
    assert!(said.contains("first bad commit could be any of"), "{said}");
}
