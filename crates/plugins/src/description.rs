//! Description of a plugin, copied out of its memory and validated.

use std::ffi::{CStr, c_char};

use accel_core::params::{ParamKind, ParamSpec};
use serde::{Deserialize, Serialize};

use crate::abi;

const MOST_SETTINGS: u32 = 256;

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Description {
    pub name: String,
    pub version: String,
    pub summary: String,
    /// It has a query of its own for shadow rays.
    pub has_occlusion: bool,
    /// It has several rays in flight.
    pub answers_batches: bool,
    /// Its own triangle test decides; else rtbench's.
    pub has_own_test: bool,
    /// It computes on a device: calls are timed by time of day, and have whole batches.
    #[serde(default)]
    pub on_device: bool,
    pub has_f64: bool,
    /// Settings that users can change.
    pub settings: Vec<SettingDescription>,
}

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct SettingDescription {
    pub name: String,
    pub summary: String,
    pub initial: String,
    pub kind: SettingKind,
}

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub enum SettingKind {
    Integer(u64, u64),
    /// Numbers of a closed range.
    Real(f64, f64),
    /// One of these words.
    Choice(Vec<String>),
}

impl Description {
    /// Reads and validates a description.
    ///
    /// # Safety
    /// `plugin` is what a plugin of our version describes: its strings end, its arrays are as long
    /// as it says.
    pub(crate) unsafe fn read(plugin: &abi::Plugin) -> Result<Self, String> {
        if plugin.answers & abi::TRIANGLES_F32 == 0 {
            return Err("it does not answer closest hits with triangles in f32 \
                        (RTBENCH_TRIANGLES_F32)"
                .into());
        }
        let has_occlusion = plugin.answers & abi::OCCLUSION != 0;
        let has_f64 = plugin.answers & abi::TRIANGLES_F64 != 0;
        match missing(&plugin.in_f32, has_occlusion) {
            Some("occluded") => {
                let why = "it answers RTBENCH_OCCLUSION, but its function 'occluded' is NULL";
                return Err(why.into());
            }
            Some(name) => return Err(format!("its function '{name}' is NULL")),
            None => {}
        }
        if let Some(name) = missing(&plugin.in_f64, has_occlusion).filter(|_| has_f64) {
            let why = "it answers RTBENCH_TRIANGLES_F64, but its function";
            return Err(format!("{why} '{name}_f64' is NULL"));
        }
        if plugin.query > abi::BATCH {
            return Err(format!("its query is {}, neither one ray nor batch", plugin.query));
        }
        if plugin.test > abi::HOST_TEST {
            return Err(format!("its test is {}, neither its own nor the host's", plugin.test));
        }
        let count = plugin.settings_count;
        if count > MOST_SETTINGS || count > 0 && plugin.settings.is_null() {
            return Err(format!("it declares {count} settings: too many, or `settings` is NULL"));
        }
        let settings = (0..count as usize).map(|i| {
            // SAFETY: the array has that many, by the contract
            unsafe { SettingDescription::read(&*plugin.settings.add(i)) }
        });
        // SAFETY: strings, by the contract
        let (name, version, summary) = unsafe {
            (
                identifier(plugin.name, "name")?,
                text(plugin.version, "version")?,
                text(plugin.summary, "summary")?,
            )
        };
        Ok(Self {
            name,
            version,
            summary,
            has_occlusion,
            answers_batches: plugin.query == abi::BATCH,
            has_own_test: plugin.test != abi::HOST_TEST,
            on_device: plugin.answers & abi::DEVICE != 0,
            has_f64,
            settings: settings.collect::<Result<_, _>>()?,
        })
    }
}

/// The first function that must be there and is not.
fn missing<T: abi::Real>(
    functions: &abi::Functions<T>,
    has_occlusion: bool,
) -> Option<&'static str> {
    let all = [
        ("build", functions.build.is_some()),
        ("closest", functions.closest.is_some()),
        ("occluded", functions.occluded.is_some() || !has_occlusion),
        ("destroy", functions.destroy.is_some()),
    ];
    all.into_iter().find_map(|(name, is_there)| (!is_there).then_some(name))
}

impl SettingDescription {
    /// # Safety
    /// As [`Description::read`].
    unsafe fn read(setting: &abi::Setting) -> Result<Self, String> {
        // SAFETY: strings, by the contract
        let name = unsafe { identifier(setting.name, "name of a setting")? };
        let of = |what: &str| format!("{what} of its setting '{name}'");
        // SAFETY: likewise
        let (summary, initial) = unsafe {
            (text(setting.summary, &of("summary"))?, text(setting.initial, &of("default"))?)
        };
        let (min, max) = (setting.min, setting.max);
        let has_range = min.is_finite() && max.is_finite() && min <= max;
        let kind = match setting.kind {
            abi::INTEGER if has_range && min >= 0.0 => SettingKind::Integer(min as u64, max as u64),
            abi::REAL if has_range => SettingKind::Real(min, max),
            abi::CHOICE => {
                // SAFETY: likewise
                let words = unsafe { text(setting.words, &of("words"))? };
                let words: Vec<String> = words.split_whitespace().map(str::to_owned).collect();
                if words.is_empty() {
                    return Err(format!("the {} are none", of("words")));
                }
                SettingKind::Choice(words)
            }
            abi::INTEGER | abi::REAL => {
                return Err(format!("the {} is {min} to {max}", of("range")));
            }
            other => return Err(format!("the {} is {other}", of("kind"))),
        };
        Ok(Self { name, summary, initial, kind })
    }

    /// The same for a registry, which lives as long as the program.
    pub(crate) fn leaked(&self) -> ParamSpec {
        let kind = match &self.kind {
            SettingKind::Integer(min, max) => ParamKind::Integer { min: *min, max: *max },
            SettingKind::Real(min, max) => ParamKind::Real { min: *min, max: *max },
            SettingKind::Choice(words) => {
                let words: Vec<&'static str> = words.iter().map(|word| leak(word)).collect();
                ParamKind::Choice(Vec::leak(words))
            }
        };
        ParamSpec {
            name: leak(&self.name),
            summary: leak(&self.summary),
            default: leak(&self.initial),
            kind,
        }
    }
}

/// A text that lives as long as the program: of what is said once by each plugin.
pub(crate) fn leak(text: &str) -> &'static str {
    String::leak(text.to_owned())
}

/// # Safety
/// `text` is NULL or a string that ends.
unsafe fn text(text: *const c_char, what: &str) -> Result<String, String> {
    if text.is_null() {
        return Err(format!("the {what} is NULL"));
    }
    // SAFETY: by the contract
    let text = unsafe { CStr::from_ptr(text) };
    text.to_str().map(str::to_owned).map_err(|_| format!("the {what} is not valid UTF-8"))
}

/// # Safety
/// As [`text`].
unsafe fn identifier(pointer: *const c_char, what: &str) -> Result<String, String> {
    // SAFETY: by the contract
    let text = unsafe { text(pointer, what)? };
    let is_plain = |c: char| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '-';
    if text.is_empty() || text.len() > 64 || !text.chars().all(is_plain) || text == "all" {
        return Err(format!("the {what} is '{text}'; expected 1 to 64 of a-z, 0-9 and hyphens"));
    }
    Ok(text)
}

#[cfg(test)]
mod tests {
    use super::*;

    unsafe extern "C" fn build<T: abi::Real>(
        _: *const abi::Scene<T>,
        _: *mut *mut std::ffi::c_void,
        _: *mut c_char,
        _: usize,
    ) -> std::ffi::c_int {
        0
    }
    unsafe extern "C" fn closest<T: abi::Real>(
        _: *mut std::ffi::c_void,
        _: *const abi::Ray<T>,
        _: *mut abi::Hit<T>,
        _: usize,
    ) {
    }
    unsafe extern "C" fn occluded(
        _: *mut std::ffi::c_void,
        _: *const abi::Ray,
        _: *mut u8,
        _: usize,
    ) {
    }
    unsafe extern "C" fn destroy(_: *mut std::ffi::c_void) {}

    fn functions<T: abi::Real>() -> abi::Functions<T> {
        abi::Functions {
            build: Some(build),
            closest: Some(closest),
            destroy: Some(destroy),
            ..abi::Functions::NONE
        }
    }

    fn plugin(settings: &[abi::Setting]) -> abi::Plugin {
        abi::Plugin {
            abi_version: abi::VERSION,
            size: size_of::<abi::Plugin>() as u32,
            name: c"mine-2".as_ptr(),
            version: c"1".as_ptr(),
            summary: c"a test".as_ptr(),
            answers: abi::TRIANGLES_F32,
            query: 0,
            test: 0,
            settings_count: settings.len() as u32,
            settings: settings.as_ptr(),
            in_f32: functions(),
            in_f64: functions(),
        }
    }

    fn setting(kind: u32, min: f64, max: f64, words: *const c_char) -> abi::Setting {
        let [name, summary, initial] = [c"leaf", c"size", c"4"].map(CStr::as_ptr);
        abi::Setting { name, summary, initial, kind, min, max, words }
    }

    fn read(plugin: &abi::Plugin) -> Result<Description, String> {
        // SAFETY: literals above
        unsafe { Description::read(plugin) }
    }

    #[test]
    fn descriptions_are_copied() {
        let settings = [
            setting(abi::INTEGER, 1.0, 8.0, std::ptr::null()),
            setting(abi::CHOICE, 0.0, 0.0, c"a  b".as_ptr()),
        ];
        let said = read(&plugin(&settings)).unwrap();
        assert_eq!((said.name.as_str(), said.has_own_test), ("mine-2", true));
        assert!(!said.has_f64 && !said.on_device);
        let other = abi::Plugin { answers: abi::TRIANGLES_F32 | abi::DEVICE, ..plugin(&[]) };
        assert!(read(&other).unwrap().on_device);
        let both = abi::Plugin { answers: abi::TRIANGLES_F32 | abi::TRIANGLES_F64, ..plugin(&[]) };
        assert!(read(&both).unwrap().has_f64);
        assert_eq!(said.settings[0].kind, SettingKind::Integer(1, 8));
        assert_eq!(said.settings[1].kind, SettingKind::Choice(vec!["a".into(), "b".into()]));
    }

    #[test]
    fn invalid_descriptions_are_named() {
        type Change = fn(&mut abi::Plugin);
        let planted: [(Change, &str); 10] = [
            (|p| p.answers = abi::OCCLUSION, "triangles in f32"),
            (|p| p.answers |= abi::OCCLUSION, "'occluded' is NULL"),
            (|p| p.in_f32.closest = None, "its function 'closest' is NULL"),
            (
                |p| (p.answers, p.in_f64.closest) = (5, None),
                "it answers RTBENCH_TRIANGLES_F64, but its function 'closest_f64' is NULL",
            ),
            (|p| (p.answers, p.in_f64.destroy) = (5, None), "'destroy_f64' is NULL"),
            (
                |p| {
                    p.answers = 7;
                    p.in_f32.occluded = Some(occluded);
                },
                "RTBENCH_TRIANGLES_F64, but its function 'occluded_f64' is NULL",
            ),
            (|p| p.name = std::ptr::null(), "name is NULL"),
            (|p| p.name = c"My BVH".as_ptr(), "hyphens"),
            (|p| p.query = 7, "neither one ray nor batch"),
            (|p| p.settings_count = 1_000_000, "1000000 settings"),
        ];
        for (change, said) in planted {
            let mut bad = plugin(&[]);
            change(&mut bad);
            let error = read(&bad).unwrap_err();
            assert!(error.contains(said), "{error}");
        }
        let ranges = [
            setting(abi::REAL, 2.0, 1.0, std::ptr::null()),
            setting(abi::INTEGER, -1.0, 1.0, std::ptr::null()),
            setting(abi::CHOICE, 0.0, 0.0, c" ".as_ptr()),
            setting(9, 0.0, 1.0, std::ptr::null()),
        ];
        for range in ranges {
            assert!(read(&plugin(&[range])).unwrap_err().contains("'leaf'"));
        }
    }
}
