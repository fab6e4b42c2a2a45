//! Writes scenes as NFF text (E. Haines' Neutral File Format, `NFF.TXT` of SPD 3.14), numbers as C's
//! `printf("%g")` prints them: six significant digits.

use std::fmt::{self, Write as _};
use std::io;

use glam::DVec3;

use crate::scene::{Light, Material, Primitive, Scene, Shape};

/// Writes the scene as NFF, numbers with six significant digits ([`PrintfG`]).
///
/// The order is background, view, lights, primitives; a primitive of another material than the
/// one before it is preceded by that material's `f` line. So the text of an SPD scene is that of
/// the distributed file (but for the sign of zero). Triangles are written as polygons of three
/// vertices. NFF has no place for names and warnings, nor for materials that nothing is made of.
pub fn write_nff(scene: &Scene, out: &mut impl io::Write) -> io::Result<()> {
    let mut out = io::BufWriter::new(out);
    write_head(scene, &mut out)?;
    let mut current = None;
    for primitive in &scene.primitives {
        if current.replace(primitive.material) != Some(primitive.material)
            && let Some(material) = scene.materials.get(primitive.material as usize)
        {
            write_material(material, &mut out)?;
        }
        write_primitive(scene, primitive, &mut out)?;
    }
    io::Write::flush(&mut out)
}

fn write_head(scene: &Scene, out: &mut impl io::Write) -> io::Result<()> {
    let camera = &scene.camera;
    writeln!(out, "b {}", Numbers(&scene.background))?;
    writeln!(out, "v")?;
    writeln!(out, "from {}", vector(&camera.from))?;
    writeln!(out, "at {}", vector(&camera.at))?;
    writeln!(out, "up {}", vector(&camera.up))?;
    writeln!(out, "angle {}", PrintfG(camera.angle))?;
    writeln!(out, "hither {}", PrintfG(camera.hither))?;
    writeln!(out, "resolution {} {}", camera.resolution[0], camera.resolution[1])?;
    // NFF knows neither extents nor lenses nor motion
    for light in &scene.lights {
        write!(out, "l {}", vector(&light.position()))?;
        if let Some(color) = light.color() {
            write!(out, " {}", Numbers(&color))?;
        }
        writeln!(out)?;
    }
    Ok(())
}

fn write_material(material: &Material, out: &mut impl io::Write) -> io::Result<()> {
    let shares = [
        material.diffuse,
        material.specular,
        material.shine,
        material.transmittance,
        material.refraction_index,
    ];
    writeln!(out, "f {} {}", Numbers(&material.color), Numbers(&shares))
}

fn write_primitive(
    scene: &Scene,
    primitive: &Primitive,
    out: &mut impl io::Write,
) -> io::Result<()> {
    match primitive.shape {
        Shape::Sphere(i) => {
            let sphere = scene.spheres[i as usize];
            writeln!(out, "s {} {}", vector(&sphere.center), PrintfG(sphere.radius))
        }
        Shape::Cone(i) => {
            let cone = scene.cones[i as usize];
            let (base, apex) = (vector(&cone.base), vector(&cone.apex));
            let radii = [cone.base_radius, cone.apex_radius].map(PrintfG);
            writeln!(out, "c {base} {} {apex} {}", radii[0], radii[1])
        }
        Shape::Polygon { first, count } => {
            let outline = &scene.vertices[first as usize..][..count as usize];
            writeln!(out, "p {count}")?;
            outline.iter().try_for_each(|p| writeln!(out, "{}", vector(p)))
        }
        Shape::Triangle { v } => {
            writeln!(out, "p 3")?;
            v.iter().try_for_each(|&i| writeln!(out, "{}", vector(&scene.vertices[i as usize])))
        }
        Shape::Patch { v, n } => {
            writeln!(out, "pp 3")?;
            v.iter().zip(n).try_for_each(|(&v, n)| {
                let (v, n) = (&scene.vertices[v as usize], &scene.normals[n as usize]);
                writeln!(out, "{} {}", vector(v), vector(n))
            })
        }
    }
}

fn vector(v: &DVec3) -> Numbers<'_> {
    Numbers(v.as_ref())
}

/// Numbers with blanks between them.
struct Numbers<'a>(&'a [f64]);

impl fmt::Display for Numbers<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (i, &x) in self.0.iter().enumerate() {
            let space = if i == 0 { "" } else { " " };
            write!(f, "{space}{}", PrintfG(x))?;
        }
        Ok(())
    }
}

/// Displays a number as C's `printf("%g")` does, except that negative zero is `0`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PrintfG(pub f64);

impl PrintfG {
    /// The number that is printed: rounded to six significant decimal digits.
    pub fn value(self) -> f64 {
        match self.scientific() {
            // The text is a number in Rust's own notation; adding 0 makes -0 plain.
            Some(text) => text.parse().unwrap_or(self.0) + 0.0,
            None => self.0,
        }
    }

    /// `d.ddddde<exponent>`; `None` for infinities and NaN.
    fn scientific(self) -> Option<String> {
        self.0.is_finite().then(|| format!("{:.5e}", self.0))
    }
}

impl fmt::Display for PrintfG {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.0 == 0.0 {
            return f.write_char('0');
        }
        let text = self.scientific();
        let Some((mantissa, exponent)) = text.as_deref().and_then(|text| text.split_once('e'))
        else {
            return write!(f, "{}", self.0);
        };
        let exponent: i32 = exponent.parse().map_err(|_| fmt::Error)?;
        let (sign, mantissa) = match mantissa.strip_prefix('-') {
            Some(rest) => ("-", rest),
            None => ("", mantissa),
        };
        f.write_str(sign)?;
        let (lead, rest) = mantissa.split_at(1);
        let rest = rest.trim_end_matches('0').trim_start_matches('.');
        match exponent {
            0..6 => {
                // The point moves right, past digits or past zeros that stand for them.
                let whole = exponent as usize;
                let (before, after) = rest.split_at(whole.min(rest.len()));
                write!(f, "{lead}{before:0<whole$}")?;
                if after.is_empty() { Ok(()) } else { write!(f, ".{after}") }
            }
            -4..0 => {
                let zeros = (-exponent - 1) as usize;
                write!(f, "0.{:0<zeros$}{lead}{rest}", "")
            }
            _ => {
                let point = if rest.is_empty() { "" } else { "." };
                let sign = if exponent < 0 { '-' } else { '+' };
                write!(f, "{lead}{point}{rest}e{sign}{:02}", exponent.unsigned_abs())
            }
        }
    }
}

/// Rounds every number of the scene - coordinates, radii, normals, colours, shares, exponents,
/// view - to what C's `printf("%g")` prints (six significant digits), as if it had been written to
/// an NFF file and read again.
pub fn round_to_printed(scene: &mut Scene) {
    let camera = &mut scene.camera;
    round_vectors([&mut camera.from, &mut camera.at, &mut camera.up]);
    round([&mut camera.angle, &mut camera.hither]);
    round(&mut scene.background);
    for light in &mut scene.lights {
        let (Light::Point { position, color } | Light::Disc { position, color, .. }) = light;
        round_vectors([position]);
        round(color.iter_mut().flatten());
    }
    for material in &mut scene.materials {
        round(&mut material.color);
        round([
            &mut material.diffuse,
            &mut material.specular,
            &mut material.shine,
            &mut material.transmittance,
            &mut material.refraction_index,
        ]);
    }
    round_vectors(scene.vertices.iter_mut().chain(&mut scene.normals));
    for sphere in &mut scene.spheres {
        round_vectors([&mut sphere.center]);
        round([&mut sphere.radius]);
    }
    for cone in &mut scene.cones {
        round_vectors([&mut cone.base, &mut cone.apex]);
        round([&mut cone.base_radius, &mut cone.apex_radius]);
    }
}

fn round_vectors<'a>(vectors: impl IntoIterator<Item = &'a mut DVec3>) {
    for vector in vectors {
        *vector = vector.map(|x| PrintfG(x).value());
    }
}

fn round<'a>(numbers: impl IntoIterator<Item = &'a mut f64>) {
    for number in numbers {
        *number = PrintfG(*number).value();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn prints_as_c_does() {
        // Right-hand sides are what glibc's printf("%g") gives.
        for (x, text) in [
            (0.0, "0"),
            (-0.0, "0"),
            (1.0, "1"),
            (-12.5, "-12.5"),
            (100_000.0, "100000"),
            (999_999.5, "1e+06"),
            (999_999.4, "999999"),
            (1_234_567.0, "1.23457e+06"),
            (120.0, "120"),
            (0.1 + 0.2, "0.3"),
            (0.0001, "0.0001"),
            (0.000123456789, "0.000123457"),
            (0.00001, "1e-05"),
            (-1.110223e-16, "-1.11022e-16"),
            (2.5e-300, "2.5e-300"),
            (1.0 / 3.0, "0.333333"),
            (20.905, "20.905"),
            (f64::INFINITY, "inf"),
        ] {
            assert_eq!(PrintfG(x).to_string(), text, "{x:?}");
            assert_eq!(PrintfG(x).value(), text.parse::<f64>().unwrap(), "{x:?}");
        }
        assert!(PrintfG(f64::NAN).value().is_nan());
        assert!(PrintfG(-0.0).value().is_sign_positive());
    }
}
