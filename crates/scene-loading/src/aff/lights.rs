//! Lights and current materials of AFF files.

use crate::aff::read::Reader;
use crate::error::{FilePlace, LoadError};
use crate::limits::{self, MAX_LIGHTS, MAX_MATERIALS};
use crate::nff::tokens::Words;
use crate::scene::{Light, Material};

impl Reader<'_> {
    pub fn light(&mut self, words: &mut Words<'_>, place: FilePlace) -> Result<(), LoadError> {
        let position = words.vector("light position")?;
        let color = if words.peek().is_some_and(|word| word.looks_numeric()) {
            Some(words.vector("light colour")?.to_array())
        } else {
            None
        };
        self.world.lights.push((self.branch, Light::Point { position, color }));
        limits::check(self.world.lights.len(), MAX_LIGHTS, "the number of lights", || place)
    }

    pub fn material(&mut self, material: Material, place: FilePlace) -> Result<(), LoadError> {
        self.material = Some(self.world.rest.push_material(material));
        let count = self.world.rest.materials.len();
        limits::check(count, MAX_MATERIALS, "the number of materials", || place)
    }

    /// The current material, or a grey one where a primitive comes before the first.
    pub fn current_material(&mut self) -> u32 {
        let scene = &mut self.world.rest;
        *self.material.get_or_insert_with(|| scene.push_material(Material::default()))
    }
}
