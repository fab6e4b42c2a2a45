//! Settings of rays, which hold for all rows of a run: `--set rays.offset=none`.

use renderer::RaySettings;
use renderer::ray_offset::OffsetRule;

use crate::plan::error::PlanError;

/// Name that `--set` takes instead of a structure.
pub const NAME: &str = "rays";

/// Values of `rays.offset`: how rays are kept off the surfaces they leave. Of those with a number,
/// `fixed` is that of Havran and Sixta (1999).
pub const RULES: [(&str, OffsetRule); 5] = [
    ("none", OffsetRule::None),
    ("fixed", OffsetRule::Fixed(0.01)),
    ("scene-relative", OffsetRule::SceneRelative),
    ("ulp-wise", OffsetRule::UlpWise),
    ("error-bound", OffsetRule::ErrorBound(4.0)),
];

/// Takes the settings of rays out of those of structures and makes them.
pub fn apply(overrides: &[String], settings: &mut RaySettings) -> Result<Vec<String>, PlanError> {
    let mut others = Vec::new();
    for text in overrides {
        let Some(rest) = text.strip_prefix(NAME).and_then(|rest| rest.strip_prefix('.')) else {
            others.push(text.clone());
            continue;
        };
        let malformed = |expected| PlanError::Malformed { text: text.clone(), expected };
        let (name, value) =
            rest.split_once('=').ok_or_else(|| malformed("rays.offset=RULE, like error-bound"))?;
        if name != "offset" {
            return Err(malformed("rays.offset=RULE: rays have no other setting"));
        }
        let rule = RULES.iter().find(|(rule, _)| *rule == value);
        let valid = RULES.map(|(rule, _)| rule);
        let (_, rule) = rule.ok_or_else(|| PlanError::unknown("offset", value, valid))?;
        settings.offset = *rule;
    }
    Ok(others)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn applied(texts: &[&str]) -> Result<(Vec<String>, OffsetRule), String> {
        let texts: Vec<String> = texts.iter().map(|t| (*t).to_owned()).collect();
        let mut settings = RaySettings::default();
        let others = apply(&texts, &mut settings).map_err(|e| e.to_string())?;
        Ok((others, settings.offset))
    }

    #[test]
    fn settings_of_rays_and_structures_are_distinguished() {
        let (others, rule) = applied(&["rays.offset=none", "uniform-grid.density=4"]).unwrap();
        assert_eq!(
            (others.as_slice(), rule),
            (&["uniform-grid.density=4".into()][..], OffsetRule::None)
        );
        assert_eq!(applied(&[]).unwrap().1, OffsetRule::default());
    }

    #[test]
    fn the_default_rule_is_among_those_that_can_be_named() {
        assert!(RULES.iter().any(|(_, rule)| *rule == OffsetRule::default()));
    }

    #[test]
    fn errors_name_what_is_valid() {
        let error = applied(&["rays.offset=ulpwise"]).unwrap_err();
        assert!(error.contains("did you mean 'ulp-wise'?") && error.contains("fixed"), "{error}");
        assert!(applied(&["rays.offset"]).is_err() && applied(&["rays.epsilon=1"]).is_err());
    }
}
