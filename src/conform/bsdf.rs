//! Gates 3 and 4 for surface models: one row a model below, everything else follows from it.
//!
//! A row lists parameter sweeps; their cases go through `properties` (gate 4, f64: chi-square, mass of the pdf, weight,
//! reciprocity, furnace, edge inputs) and through the device rows (gate 3 against f64, furnace by sampling).
//! To add a model: one row.

pub mod chart;
mod device;
mod gltf;
mod parts;
pub mod properties;

pub use device::furnace_rows;

use glam::DVec3;

use super::probe::Probe;
use crate::bsdf::{Bsdf, MODELS, Model, Params};

/// What a sweep promises about the light that leaves when light arrives from everywhere.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Furnace {
    /// All of it: within [0.99, 1.001].
    Unity,
    /// Not more than arrives, to 1.001.
    AtMostOne,
    /// Not more than this: the albedo that layers go by is an approximation.
    AtMost(f64),
    /// Nothing; the documentation says why.
    Exempt,
}

/// Every combination of the listed values; a colour input gets the value in all channels.
pub struct Sweep {
    pub furnace: Furnace,
    /// Input whose value is the index of a refracting boundary: radiance beyond it is scaled by its square.
    pub refracts_by: Option<&'static str>,
    /// One list for each of the model's inputs, in its order.
    pub values: &'static [&'static [f64]],
}

/// Where the device's inputs are drawn from, edges included.
#[derive(Clone, Copy, Debug)]
pub enum Domain {
    /// [0, 1], often 0 or 1.
    Unit,
    /// [0, 1] clear of the smooth threshold, on which side of it f32 and f64 may fall differently.
    Roughness,
    /// As `Roughness`, or -1: the same as the other axis.
    RoughnessY,
    /// Index of a coat: [1, 3].
    Coat,
    /// 0.3 to 3 and 1, 1 +- 1e-7, 1 +- 1e-3.
    Index,
    /// Real or imaginary part of a metal's index: [0, 8].
    Metal,
    /// 0 or 1.
    Switch,
    /// [-7, 7] radian.
    Turn,
    /// 0, or as `Unit`.
    Off,
    /// 0, or as `Roughness`.
    RoughnessOff,
}

/// What the gates know of a model.
pub struct Row {
    pub keyword: &'static str,
    /// One for each of the model's inputs.
    pub domains: &'static [Domain],
    /// K of gate 3 for `eval` and `pdf`, and for `sample`. 64: ten to twenty roundings through D's fourth power. More for
    /// samples, whose inputs are further back: a grazing facet's cosines are differences (256), refraction follows with two
    /// more, and the albedo table holds 1e-7 absolute while a weight near the horizon is as small as 1e-4 (1024).
    pub k: [f64; 2],
    /// Helpers that the two rows reach.
    pub covers: &'static [&'static str],
    pub sweeps: &'static [Sweep],
}

/// Widths from smooth to rough; 0.0317 is just above the smooth threshold (alpha 1e-3), 0.0316 just below.
const ROUGHNESS: &[f64] = &[0.0, 0.0316, 0.0317, 0.1, 0.2, 0.35, 0.6, 1.0];

pub const ROWS: &[Row] = &[
    Row {
        keyword: "lambert",
        domains: &[Domain::Unit],
        k: [4.0, 4.0],
        covers: &["bsdf_sample_none"],
        sweeps: &[Sweep { furnace: Furnace::Unity, refracts_by: None, values: &[&[1.0]] }],
    },
    Row {
        keyword: "conductor",
        domains: &[Domain::Metal, Domain::Metal, Domain::Roughness, Domain::RoughnessY, Domain::Switch],
        k: [64.0, 256.0],
        covers: &["conductor_deficit", "conductor_value", "conductor_eval_pdf"],
        sweeps: &[
            // eta = 0 reflects everything: what is missing is masking alone.
            Sweep { furnace: Furnace::Unity, refracts_by: None, values: &[&[0.0], &[1.0], ROUGHNESS, &[-1.0], &[1.0]] },
            Sweep {
                furnace: Furnace::AtMostOne,
                refracts_by: None,
                values: &[&[0.0], &[1.0], &[0.0317, 0.3, 1.0], &[-1.0], &[0.0]],
            },
            Sweep {
                furnace: Furnace::AtMostOne,
                refracts_by: None,
                values: &[&[0.0], &[1.0], &[0.15, 0.6, 1.0], &[0.1, 0.4, 0.9], &[0.0, 1.0]],
            },
            Sweep {
                furnace: Furnace::AtMostOne,
                refracts_by: None,
                values: &[&[0.2, 1.5], &[0.0, 3.9], &[0.1, 0.8], &[-1.0], &[1.0]],
            },
        ],
    },
    Row {
        keyword: "dielectric",
        domains: &[Domain::Index, Domain::Roughness, Domain::RoughnessY, Domain::Switch],
        k: [64.0, 1024.0],
        covers: &[
            "dielectric_deficits",
            "dielectric_lost",
            "dielectric_value",
            "dielectric_value_between",
            "dielectric_eval_pdf",
            "dielectric_multiple",
        ],
        sweeps: &[
            Sweep {
                furnace: Furnace::AtMostOne,
                refracts_by: Some("eta"),
                values: &[&[1.5, 0.7, 1.0, 1.2, 2.4], &[0.0, 0.0317, 0.5, 1.0], &[-1.0], &[0.0]],
            },
            Sweep {
                furnace: Furnace::Unity,
                refracts_by: Some("eta"),
                values: &[&[1.333, 1.5], &[0.0317, 0.15, 0.35, 0.6, 1.0], &[-1.0], &[1.0]],
            },
            Sweep {
                furnace: Furnace::AtMostOne,
                refracts_by: Some("eta"),
                values: &[&[0.7, 1.2, 2.4], &[0.15, 0.5, 1.0], &[-1.0], &[1.0]],
            },
            Sweep {
                furnace: Furnace::AtMostOne,
                refracts_by: Some("eta"),
                values: &[&[1.5], &[0.3], &[0.1, 0.9], &[0.0, 1.0]],
            },
        ],
    },
    Row {
        keyword: "thin_dielectric",
        domains: &[Domain::Index, Domain::Unit],
        k: [16.0, 16.0],
        covers: &[],
        sweeps: &[
            Sweep { furnace: Furnace::Unity, refracts_by: None, values: &[&[1.0, 1.5, 2.4, 0.7], &[1.0]] },
            Sweep { furnace: Furnace::AtMostOne, refracts_by: None, values: &[&[1.5], &[0.0, 0.5]] },
        ],
    },
    Row {
        // base_color, metallic, roughness, ior, transmission, thin, khronos_mix, compensation, specular, specular_color,
        // anisotropy, anisotropy_rotation, anisotropy_direction, clearcoat, clearcoat_roughness
        keyword: "gltf",
        domains: &[
            Domain::Unit,
            Domain::Unit,
            Domain::Roughness,
            Domain::Index,
            Domain::Unit,
            Domain::Switch,
            Domain::Switch,
            Domain::Switch,
            Domain::Unit,
            Domain::Unit,
            Domain::Off,
            Domain::Turn,
            Domain::Unit,
            Domain::Off,
            Domain::RoughnessOff,
        ],
        k: [64.0, 1024.0],
        covers: &[
            "gltf_mean",
            "gltf_albedo_at",
            "gltf_left",
            "gltf_outgoing",
            "gltf_facet",
            "gltf_cosine_lobe",
            "gltf_masking",
            "gltf_value",
            "gltf_eval_pdf",
            "gltf_direction",
            "gltf_turned",
            "gltf_turned_back",
        ],
        sweeps: gltf::SWEEPS,
    },
    Row {
        keyword: "rough_diffuse",
        domains: &[Domain::Unit, Domain::Unit],
        k: [32.0, 32.0],
        covers: &["rough_diffuse_lost", "rough_diffuse_uniform"],
        sweeps: &[
            Sweep { furnace: Furnace::Unity, refracts_by: None, values: &[&[1.0], &[0.0, 0.1, 0.5, 1.0]] },
            Sweep { furnace: Furnace::AtMostOne, refracts_by: None, values: &[&[0.0, 0.5], &[0.3, 1.0]] },
        ],
    },
    Row {
        keyword: "plastic",
        domains: &[Domain::Unit, Domain::Roughness, Domain::Coat],
        k: [64.0, 256.0],
        covers: &["plastic_shares", "plastic_value", "plastic_eval_pdf"],
        sweeps: &[
            Sweep { furnace: Furnace::Unity, refracts_by: None, values: &[&[1.0], ROUGHNESS, &[1.0, 1.5, 2.5]] },
            Sweep { furnace: Furnace::AtMostOne, refracts_by: None, values: &[&[0.0, 0.5], &[0.0, 0.3], &[1.5]] },
        ],
    },
];

/// Probe rows of gate 3: the functions that models share, then each model.
pub fn probes() -> Vec<Probe> {
    parts::probes().into_iter().chain(ROWS.iter().flat_map(device::probes)).collect()
}

/// A model at one set of parameters.
pub struct Case {
    pub model: &'static Model,
    pub label: String,
    pub inputs: Vec<DVec3>,
    pub params: Params,
    pub furnace: Furnace,
    pub transmits: bool,
    /// Index beyond over index here, 1 where nothing is refracted.
    pub eta: f64,
}

impl Case {
    pub fn bsdf(&self) -> &dyn Bsdf {
        self.params.bsdf()
    }
}

/// All cases of a row.
///
/// # Panics
/// When a row does not fit its model; `rows_fit_the_models` is the test of that.
pub fn cases(row: &Row) -> Vec<Case> {
    let index = MODELS.iter().position(|m| m.keyword == row.keyword).expect("a row names a model");
    let model = &MODELS[index];
    let mut all = Vec::new();
    for sweep in row.sweeps {
        assert_eq!(sweep.values.len(), model.inputs.len(), "{}: one list of values an input", row.keyword);
        let count: usize = sweep.values.iter().map(|v| v.len()).product();
        for mut n in 0..count {
            let mut inputs = Vec::new();
            let mut label = row.keyword.to_owned();
            let mut eta = 1.0;
            for (values, input) in sweep.values.iter().zip(model.inputs) {
                let value = values[n % values.len()];
                n /= values.len();
                inputs.push(DVec3::splat(value));
                label += &format!(" {}={value}", input.name);
                if sweep.refracts_by == Some(input.name) {
                    eta = value;
                }
            }
            let params = Params::from_inputs(index, &inputs);
            let transmits = model.transmits_when(|name| {
                model.inputs.iter().zip(&inputs).any(|(input, value)| input.name == name && value.max_element() > 0.0)
            });
            all.push(Case { model, label, inputs, params, furnace: sweep.furnace, transmits, eta });
        }
    }
    all
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_fit_the_models() {
        let named: Vec<&str> = ROWS.iter().map(|r| r.keyword).collect();
        let models: Vec<&str> = MODELS.iter().map(|m| m.keyword).collect();
        assert_eq!(named, models, "one row a model, in the order of the list");
        for (row, model) in ROWS.iter().zip(MODELS) {
            assert!(!cases(row).is_empty());
            assert_eq!(row.domains.len(), model.inputs.len(), "{}: one domain an input", row.keyword);
        }
    }
}
