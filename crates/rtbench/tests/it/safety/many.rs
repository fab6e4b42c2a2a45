//! Very many rows: what is written grows with them, not with their pairs.

use measurement::record::made_up;

use crate::common::run;

/// A table of all pairs of 2,000 rows was 138 MB; of 100,000 it would have been 300 GB.
#[test]
fn the_report_of_many_rows_grows_with_them() {
    let folder = tempfile::tempdir().unwrap();
    let size = |rows: usize| {
        let names: Vec<String> = (0..rows).map(|i| format!("row-{i}")).collect();
        let rows: Vec<(&str, &[f64])> =
            names.iter().map(|name| (&**name, &[1.0, 1.1, 1.2][..])).collect();
        let record = made_up::run(&[("many", &rows)]);
        let path = folder.path().join(format!("{}.json", rows.len()));
        std::fs::write(&path, serde_json::to_string(&record).unwrap()).unwrap();
        let ended = run(&format!("report {} -o -", path.display()));
        assert_eq!(ended.code, 0, "{}", ended.err);
        assert_eq!(rows.len() > 200, ended.out.contains("of every pair are left out"));
        ended.out.len()
    };
    let (some, many) = (size(400), size(4000));
    assert!(many < 11 * some, "{some} bytes of 400 rows, {many} of 4000");
    assert!(size(200) > size(100), "pairs are shown");
}
