//! A reduced failure as text, and as files for a bug report: an OBJ, its rays, and a C program that
//! asks a plugin over `rtbench.h`.

use std::fmt::Write;

use accel_core::Hit;
use glam::DVec3;

use super::shrink::ReducedFailure;
use measurement::rays::exactness::rounding;
use measurement::rays::text::{hexadecimal, line};
use measurement::settings::Precision;

/// The C program; words in capitals are replaced.
const PROGRAM: &str = include_str!("reproducer.c");

impl ReducedFailure {
    /// A name for its files: letters, digits and hyphens.
    pub fn name(&self) -> String {
        let round = self.replay.round;
        let name = format!("{} {} {}", self.replay.subject, round.case.id, round.precision.name());
        let plain = |c: char| if c.is_ascii_alphanumeric() { c } else { '-' };
        name.chars().map(plain).collect()
    }

    /// Its files: their endings and what is in them.
    pub fn files(&self) -> [(&'static str, String); 3] {
        [("obj", self.obj()), ("rays", self.ray_file()), ("c", self.program())]
    }

    /// Printed text: exact numbers, the answer and the right one.
    pub fn text(&self) -> String {
        let mut text = self.heading();
        for (i, corners) in self.triangles.iter().enumerate() {
            let corners = corners.map(|p| point(p, " ")).join(", ");
            let _ = write!(text, "\n  triangle {i}: {corners}");
        }
        for ray in &self.rays {
            let (from, along) = (point(ray.origin, " "), point(ray.direction, " "));
            let [t_min, t_max] = [ray.t_min, ray.t_max].map(hexadecimal);
            let _ = write!(text, "\n  ray: from {from} along {along} in [{t_min}, {t_max}]");
        }
        let _ = write!(text, "\n  {}", self.what);
        text
    }

    fn heading(&self) -> String {
        let [triangles, rays] = self.from;
        format!(
            "{}: {triangles} triangles and {rays} rays reduced to {} and {}",
            self.replay,
            self.triangles.len(),
            self.rays.len()
        )
    }

    /// Decimal numbers that are read as the same bits.
    fn obj(&self) -> String {
        let mut text = format!("# {}\n", self.heading());
        for p in self.triangles.as_flattened() {
            let _ = writeln!(text, "v {:e} {:e} {:e}", p.x, p.y, p.z);
        }
        for i in 0..self.triangles.len() {
            let _ = writeln!(text, "f {} {} {}", 3 * i + 1, 3 * i + 2, 3 * i + 3);
        }
        text
    }

    fn ray_file(&self) -> String {
        let lines: Vec<String> = self.rays.iter().map(line).collect();
        format!("# {}\n# origin, t_min, direction, t_max\n{}\n", self.what, lines.join("\n"))
    }

    fn program(&self) -> String {
        let triangle = |corners: &[DVec3; 3]| {
            format!("    {{{}}},\n", corners.map(|p| point(p, ", ")).join(",  "))
        };
        let c = |x: f64| match hexadecimal(x) {
            text if text.ends_with("inf") => text.replace("inf", "INFINITY"),
            text => text,
        };
        let ray = |ray: &accel_core::Ray<f64>| {
            let [origin, direction] = [ray.origin, ray.direction].map(|p| point(p, ", "));
            format!("    {{{{{origin}}}, {}, {{{direction}}}, {}}},\n", c(ray.t_min), c(ray.t_max))
        };
        let (hits, blocked) = &self.right;
        let hit = |hit: &Hit<f64>| {
            if hit.is_hit() {
                format!("    {{.t = {}, .id = {}}},\n", c(hit.t), hit.id)
            } else {
                "    {.t = 0, .id = RTBENCH_MISS},\n".to_owned()
            }
        };
        let settings = self.replay.subject.split_whitespace().skip(1);
        let settings = settings.filter_map(|s| s.split_once('='));
        let settings = settings.map(|(name, value)| format!("    {{\"{name}\", \"{value}\"}},\n"));
        let blocked: Vec<String> = blocked.iter().map(|b| u8::from(*b).to_string()).collect();
        let (suffix, number, bit, rounding) = match self.replay.round.precision {
            Precision::F32 => ("", "float", "F32", rounding::<f32>()),
            Precision::F64 => ("_f64", "double", "F64", rounding::<f64>()),
        };
        let words = [
            ("HEADING", self.heading()),
            ("WHAT", self.what.clone()),
            ("TRIANGLES", self.triangles.iter().map(triangle).collect()),
            ("RAYS", self.rays.iter().map(ray).collect()),
            ("HITS", hits.iter().map(hit).collect()),
            ("BLOCKED", blocked.join(", ")),
            ("SETTINGS", settings.collect()),
            ("ROUNDING", c(rounding)),
            ("SUFFIX", suffix.to_owned()),
            ("NUMBER", number.to_owned()),
            ("BIT", bit.to_owned()),
        ];
        words.iter().fold(PROGRAM.to_owned(), |text, (word, by)| {
            text.replace(&format!("@{word}@"), by.trim_end_matches('\n'))
        })
    }
}

fn point(p: DVec3, between: &str) -> String {
    p.to_array().map(hexadecimal).join(between)
}
