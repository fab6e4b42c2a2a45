//! Camera, lights and materials of PBRT files, as far as scenes here have them.

use glam::{DMat4, DVec3};

use crate::error::{LoadError, shortened};
use crate::pbrt::params::Params;
use crate::scene::{Camera, Light, Material, NO_HIGHLIGHT, Rgb, Scene};
use crate::tray_racing::sun_position;

/// A light before its colour is scaled.
#[derive(Debug, Clone, Copy)]
pub(super) struct LightEntry {
    /// Its place, or the direction of its parallel rays.
    place: DVec3,
    is_distant: bool,
    color: Rgb,
}

/// `Camera`: the transform so far leads from the world to the camera.
pub(super) fn camera(params: &Params, from_world: DMat4) -> Result<Camera, LoadError> {
    let to_world = from_world.inverse();
    let from = to_world.transform_point3(DVec3::ZERO);
    let camera = Camera {
        from,
        at: from + to_world.transform_vector3(DVec3::Z).normalize_or_zero(),
        up: to_world.transform_vector3(DVec3::Y),
        angle: params.number("fov", 90.0)?,
        ..Camera::default()
    };
    camera.check(|| params.place())?;
    Ok(camera)
}

/// What [`camera`] does not take from a `Camera`, in words.
pub(super) fn left_out_of_camera(kind: &str, params: &Params) -> Result<Vec<String>, LoadError> {
    let parameters = [
        ("screenwindow", params.has("screenwindow")),
        ("frameaspectratio", params.has("frameaspectratio")),
        ("lensradius", params.number("lensradius", 0.0)? != 0.0),
    ];
    let set = parameters.into_iter().filter(|(_, is_set)| *is_set);
    let mut all: Vec<String> =
        set.map(|(name, _)| format!("parameters {name} of cameras left out")).collect();
    if kind != "perspective" {
        all.push(format!("cameras {} taken as perspective", shortened(kind)));
    }
    Ok(all)
}

/// `LightSource`; none for kinds that scenes here do not have.
pub(super) fn light(
    kind: &str,
    params: &Params,
    transform: DMat4,
) -> Result<Option<LightEntry>, LoadError> {
    let scale = params.number("scale", 1.0)?.max(0.0);
    let from = DVec3::from_array(params.vector("from", [0.0; 3])?);
    let (name, place) = match kind {
        "point" | "spot" => ("I", transform.transform_point3(from)),
        "distant" => {
            let to = DVec3::from_array(params.vector("to", [0.0, 0.0, 1.0])?);
            ("L", transform.transform_vector3(to - from).normalize_or_zero())
        }
        _ => return Ok(None),
    };
    let color = params.rgb(name)?.unwrap_or([1.0; 3]);
    let color = color.map(|share| (share * scale).max(0.0));
    Ok(Some(LightEntry { place, is_distant: kind == "distant", color }))
}

/// Adds lights to a scene whose shapes are all there; the strongest gets intensity 1, because
/// lights here do not fall off.
pub(super) fn add_lights(lights: &[LightEntry], scene: &mut Scene) {
    let shares = lights.iter().flat_map(|light| light.color);
    let strongest = shares.fold(0.0, f64::max);
    let bounds = scene.bounds();
    for light in lights {
        let position =
            if light.is_distant { sun_position(&bounds, light.place) } else { light.place };
        if !position.is_finite() {
            continue;
        }
        let color = (strongest > 0.0).then(|| light.color.map(|share| share / strongest));
        scene.lights.push(Light::point(position, color));
    }
}

/// `Material` or `MakeNamedMaterial`.
pub(super) fn material(name: &str, kind: &str, params: &Params) -> Result<Material, LoadError> {
    let plain = Material { name: name.to_owned(), ..Material::default() };
    let colored =
        |color: Option<Rgb>| Material { color: color.unwrap_or([0.5; 3]), ..plain.clone() };
    Ok(match kind {
        // of version 3
        "matte" | "plastic" | "uber" | "substrate" | "translucent" | "kdsubsurface" => {
            colored(params.rgb("Kd")?)
        }
        "disney" => colored(params.rgb("color")?),
        "diffuse" | "coateddiffuse" | "diffusetransmission" => colored(params.rgb("reflectance")?),
        "conductor" | "coatedconductor" | "metal" | "mirror" => {
            let name = if kind == "mirror" { "Kr" } else { "reflectance" };
            let color = params.rgb(name)?.unwrap_or([1.0; 3]);
            Material { color, diffuse: 0.2, specular: 0.8, shine: NO_HIGHLIGHT, ..plain }
        }
        "dielectric" | "thindielectric" | "glass" => {
            let eta = match kind {
                "thindielectric" => 1.0,
                // of version 3, which has both names
                "glass" => params.number("eta", params.number("index", 1.5)?)?,
                _ => params.number("eta", 1.5)?,
            };
            Material {
                color: [1.0; 3],
                diffuse: 0.0,
                specular: 0.1,
                shine: NO_HIGHLIGHT,
                transmittance: 0.9,
                refraction_index: if eta > 0.0 { eta } else { 1.0 },
                ..plain
            }
        }
        _ => plain,
    })
}
