//! A variant: the settings and the device of a run, from words joined by `+`, such as `mis+independent` or `bsdf+everything`.

use crate::integrator::{Estimator, IntegratorKind, SamplerKind, Settings};

/// One way to render the scene.
#[derive(Clone, Debug)]
pub struct Variant {
    /// As it was asked for.
    pub name: String,
    /// Seed 0; a replicate sets its own.
    pub settings: Settings,
    /// The kernel with everything compiled in.
    pub everything: bool,
    /// More samples where the error is; spp are those of a pixel on average.
    pub adaptive: bool,
    /// Instead of the command's device.
    pub device: Option<String>,
}

impl Variant {
    /// Words change `base`: an estimator, a sampler, an integrator, `everything`, `specialised`, `adaptive`, `cpu`, `device=NAME`. The error
    /// names the word and the ones there are.
    pub fn parse(name: &str, base: &Settings) -> Result<Self, String> {
        let mut v = Self { name: name.to_owned(), settings: *base, everything: false, adaptive: false, device: None };
        let mut kinds = Vec::new();
        for word in name.split('+') {
            let kind = kind(word);
            if let Some((_, other)) = kinds.iter().find(|(k, _)| *k == kind) {
                return Err(format!("the variant '{name}' has '{other}' and '{word}', and takes one of them"));
            }
            kinds.push((kind, word));
            if let Some(estimator) = of::<Estimator>(word) {
                v.settings.estimator = estimator;
            } else if let Some(sampler) = of::<SamplerKind>(word) {
                v.settings.sampler = sampler;
            } else if let Some(integrator) = of::<IntegratorKind>(word) {
                v.settings.integrator = integrator;
            } else if let Some(device) = word.strip_prefix("device=") {
                v.device = Some(device.to_owned());
            } else {
                match word {
                    "everything" => v.everything = true,
                    "adaptive" => v.adaptive = true,
                    "specialised" => v.everything = false,
                    "cpu" => v.device = Some("cpu".to_owned()),
                    _ => return Err(format!("'{word}' in the variant '{name}' is none of {}", words().join(", "))),
                }
            }
        }
        Ok(v)
    }
}

/// What a word chooses; a variant has one word of each. A switch is a kind of its own.
fn kind(word: &str) -> &str {
    match word {
        _ if of::<Estimator>(word).is_some() => "estimator",
        _ if of::<SamplerKind>(word).is_some() => "sampler",
        _ if of::<IntegratorKind>(word).is_some() => "integrator",
        _ if word == "cpu" || word.starts_with("device=") => "device",
        "everything" | "specialised" => "kernel",
        _ => word,
    }
}

fn of<T: clap::ValueEnum>(word: &str) -> Option<T> {
    T::from_str(word, false).ok()
}

/// Every word there is.
fn words() -> Vec<String> {
    fn names<T: clap::ValueEnum>() -> Vec<String> {
        T::value_variants().iter().filter_map(|v| Some(v.to_possible_value()?.get_name().to_owned())).collect()
    }
    let mut all = names::<Estimator>();
    all.extend(names::<SamplerKind>());
    all.extend(names::<IntegratorKind>());
    all.extend(["everything", "specialised", "adaptive", "cpu", "device=NAME"].map(str::to_owned));
    all
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_change_the_settings() {
        let v = Variant::parse("bsdf+independent+everything+device=llvm", &Settings::default()).unwrap();
        assert_eq!((v.settings.estimator, v.settings.sampler), (Estimator::Bsdf, SamplerKind::Independent));
        assert!(!v.adaptive && Variant::parse("mis+adaptive", &Settings::default()).unwrap().adaptive);
        assert!(v.everything && v.device.as_deref() == Some("llvm"));
        for twice in ["bsdf+light", "mis+sobol+independent", "cpu+device=llvm", "mis+adaptive+adaptive"] {
            let wrong = Variant::parse(twice, &Settings::default()).unwrap_err();
            assert!(wrong.contains(twice) && wrong.contains("takes one"), "{wrong}");
        }
        let wrong = Variant::parse("mis+soboll", &Settings::default()).unwrap_err();
        assert!(wrong.contains("'soboll'") && wrong.contains("sobol, independent"), "{wrong}");
    }
}
