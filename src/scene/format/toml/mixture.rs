//! `type = "mix"`: a material made of others, named before it. Mixtures of mixtures become one list of surfaces with shares.

use super::Builder;
use super::material::plain;
use super::table::Table;
use crate::bsdf::MODELS;
use crate::scene::{Alpha, Error, Material, Part, Value};

/// Surfaces of one mixture; each has its lobe in the kernel.
const MAX_PARTS: usize = 8;

impl<'a> Builder<'a> {
    /// The mixture of a table with `materials` and either `factor` (the share of the second of two) or `weights`.
    pub fn mixture(&self, table: &Table<'a>, name: &str) -> Result<Material, Error> {
        let names = table.texts("materials")?.ok_or_else(|| table.missing("materials"))?;
        if names.len() < 2 {
            return Err(table.error("materials", "must name two or more; a mixture of one is that material"));
        }
        let shares = self.shares(table, names.len())?;
        let mut parts = Vec::new();
        let mut interiors = Vec::new();
        for (name, share) in names.into_iter().zip(shares) {
            let index = self.named(&self.materials, table, "materials", name)?;
            let material = &self.scene.materials[index];
            if material.emits() || !matches!(material.alpha, Alpha::Opaque) || material.normal_map.is_some() {
                let reason =
                    format!("mix \"{name}\", which has emission, alpha or a normal map; give them to the mixture");
                return Err(table.error("materials", reason));
            }
            interiors.extend(material.interior);
            for (surface, inner) in material.surfaces().iter().zip(shares_of(material)) {
                let inputs = surface.inputs.to_vec();
                parts.push(Part { bsdf: surface.bsdf, inputs, share: times(share.clone(), inner) });
            }
        }
        if parts.len() > MAX_PARTS {
            return Err(table.error("materials", format!("come to {} surfaces, more than {MAX_PARTS}", parts.len())));
        }
        if interiors.windows(2).any(|i| i[0] != i[1]) {
            return Err(table.error("materials", "absorb differently inside; there is one medium behind a surface"));
        }
        let is_wall = |p: &&Part| MODELS[p.bsdf].keyword.starts_with("thin_");
        let is_boundary = |p: &&Part| MODELS[p.bsdf].keyword == "dielectric";
        if parts.iter().any(|p| is_wall(&p)) && parts.iter().any(|p| is_boundary(&p)) {
            return Err(table.error("materials", "mix a thin wall with the boundary of a volume; keep one of the two"));
        }
        let mut material = plain(name, parts[0].bsdf);
        material.inputs.clone_from(&parts[0].inputs);
        material.interior = interiors.first().copied();
        material.parts = parts;
        Ok(material)
    }

    fn shares(&self, table: &Table<'a>, count: usize) -> Result<Vec<Value>, Error> {
        match (table.get("factor"), table.get("weights")) {
            (Some(_), Some(_)) => Err(table.error("weights", "stands beside `factor`; keep one of the two")),
            (None, None) => Err(table.missing("factor")),
            (Some(_), None) if count != 2 => Err(table.error("factor", "is between two `materials`; use `weights`")),
            (Some(item), None) => {
                let value = self.value(table, "factor", item)?;
                if let Value::Constant(c) = &value
                    && !(0.0..=1.0).contains(&c[0])
                {
                    return Err(table.error("factor", "must lie from 0 to 1"));
                }
                Ok(vec![Value::Rest(Box::new(value.clone())), Value::Share(Box::new(value))])
            }
            (None, Some(item)) => {
                let weights = table.list_of("weights", item)?;
                let sum: f64 = weights.iter().sum();
                if weights.len() != count
                    || weights.iter().any(|w| w.is_nan() || *w < 0.0)
                    || !(sum > 0.0 && sum.is_finite())
                {
                    return Err(table.error("weights", "must be one number >= 0 a material, not all of them 0"));
                }
                Ok(weights.iter().map(|w| Value::scalar(w / sum)).collect())
            }
        }
    }
}

fn shares_of(material: &Material) -> Vec<Value> {
    if material.parts.is_empty() {
        return vec![Value::scalar(1.0)];
    }
    material.parts.iter().map(|p| p.share.clone()).collect()
}

fn times(a: Value, b: Value) -> Value {
    match (&a, &b) {
        (Value::Constant(x), Value::Constant(y)) => Value::scalar(x[0] * y[0]),
        (_, Value::Constant(y)) if y[0] == 1.0 => a,
        _ => Value::Multiply(Box::new(a), Box::new(b)),
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::super::parse;
    use crate::scene::{Scene, Value};

    const PARTS: &str = "[[material]]\nname = \"a\"\n[[material]]\nname = \"b\"\ntype = \"plastic\"\n\
                         [[material]]\nname = \"lit\"\nemission = 1\n[[material]]\nname = \"m\"\ntype = \"mix\"\n";

    fn read(mixture: &str) -> Result<Scene, String> {
        parse(&format!("{PARTS}{mixture}"), Path::new("test.toml")).map_err(|e| e.to_string())
    }

    #[test]
    fn shares_of_nested_mixtures_multiply_and_add_to_one() {
        let nested = "materials = [\"a\", \"b\"]\nweights = [1, 3]\n\
                      [[material]]\nname = \"n\"\ntype = \"mix\"\nmaterials = [\"m\", \"a\"]\nweights = [1, 1]\n";
        let scene = read(nested).unwrap();
        let shares: Vec<f64> = scene.materials[4]
            .parts
            .iter()
            .map(|p| match &p.share {
                Value::Constant(c) => c[0],
                other => panic!("{other:?}"),
            })
            .collect();
        assert_eq!(shares, [0.125, 0.375, 0.5]);
    }

    #[test]
    fn what_cannot_be_mixed_is_said() {
        for (text, wanted) in [
            ("", "has no `materials`; add it"),
            ("materials = [\"a\", \"b\"]\n", "has no `factor`; add it"),
            ("materials = [\"a\"]\nweights = [1]\n", "must name two or more"),
            ("materials = []\nweights = []\n", "must name two or more"),
            ("materials = [\"a\", \"c\"]\nfactor = 0.5\n", "is \"c\", which the file does not define"),
            ("materials = [\"a\", \"m\"]\nfactor = 0.5\n", "is \"m\", which the file does not define"),
            ("materials = [\"a\", \"b\", \"a\"]\nfactor = 0.5\n", "is between two `materials`; use `weights`"),
            ("materials = [\"a\", \"b\"]\nfactor = 1.5\n", "must lie from 0 to 1"),
            ("materials = [\"a\", \"b\"]\nweights = [0, 0]\n", "not all of them 0"),
            ("materials = [\"a\", \"b\"]\nweights = [1, -1]\n", "one number >= 0 a material"),
            ("materials = [\"a\", \"lit\"]\nfactor = 0.5\n", "which has emission, alpha or a normal map"),
            ("materials = [\"a\", \"b\"]\nfactor = 0.5\nalbedo = 1\n", "unknown key `albedo`"),
            ("materials = [\"a\", 1]\nfactor = 0.5\n", "must be a list of strings"),
        ] {
            let message = read(text).expect_err(text);
            assert!(message.contains(wanted), "{text}: {message}");
        }
        let plain = parse("[[material]]\nname = \"a\"\nfactor = 1\n", Path::new("test.toml")).unwrap_err().to_string();
        assert!(plain.contains("is for type = \"mix\" only"), "{plain}");
    }
}
