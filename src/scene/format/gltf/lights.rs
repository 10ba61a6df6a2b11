//! KHR_lights_punctual: point and spot lights in candela, directional ones in lux, all shining along the node's -z.
//!
//! Photometric numbers are divided by 683, as exporters multiply them. A node's scale changes no light. `range` is a hint for
//! renderers that cut lights off: light here falls with the square of the distance, and a file that sets it is told so.

use glam::DVec3;

use super::buffers::File;
use super::document::PunctualLight;
use super::nodes::{self, Placed};
use crate::light::Lamp;
use crate::light::directional::Directional;
use crate::light::point::Point;
use crate::light::spot::{Falloff, Spot, one_minus_cos};
use crate::math::spectrum::LUMEN_PER_WATT;
use crate::scene::{Error, Light, MAX_RADIANCE};

/// The light that a node carries.
pub fn read(file: &File<'_>, index: usize, placed: &Placed, notes: &mut Vec<String>) -> Result<Light, Error> {
    let place = nodes::place(file, placed.node);
    let lights = file.document.extensions.lights.as_ref().map(|l| l.lights.as_slice()).unwrap_or_default();
    let light = file.at(lights, index, "light", &place)?;
    let fail = |reason: String| file.error(format!("light {index}"), reason);
    let color = DVec3::from(light.color);
    let is_strength = |x: f64| x.is_finite() && x >= 0.0;
    if !color.to_array().into_iter().chain([light.intensity]).all(is_strength) {
        return Err(fail("its colour and intensity must be numbers not below 0; correct them".into()));
    }
    if color.max_element() * light.intensity / LUMEN_PER_WATT > MAX_RADIANCE {
        let reason = format!("its intensity over 683 comes to more than {MAX_RADIANCE:e}; lower it");
        return Err(fail(reason));
    }
    notes
        .push("lights in candela and lux are divided by 683 lm/W; light_scale of [[model]] makes them brighter".into());
    if light.range.is_some() {
        notes.push("`range` of lights is not used: their light falls with the square of the distance".into());
    }
    let strength = color * (light.intensity / LUMEN_PER_WATT);
    let position = placed.to_world.translation;
    let axis = || {
        let axis = (placed.to_world.matrix3 * DVec3::NEG_Z).try_normalize();
        axis.ok_or_else(|| file.error(place.clone(), "its light has no direction (a scale of 0); give it a size"))
    };
    let lamp = match light.r#type.as_str() {
        "point" => Lamp::Point(Point { position, intensity: strength }),
        "directional" => Lamp::Directional(Directional { to_light: -axis()?, irradiance: strength }),
        "spot" => {
            let falloff = falloff(light).map_err(|reason| fail(reason.into()))?;
            Lamp::Spot(Spot { position, axis: axis()?, intensity: strength, falloff })
        }
        other => return Err(fail(format!("type \"{other}\" is not point, spot or directional; correct it"))),
    };
    Ok(Light { name: light.name.clone().unwrap_or_else(|| placed.path.clone()), lamp, group: None })
}

/// The specification's inner and outer cone; the same angle twice is the hard cone that their limit is.
fn falloff(light: &PunctualLight) -> Result<Falloff, &'static str> {
    let (inner, outer) =
        light.spot.as_ref().map_or((0.0, std::f64::consts::FRAC_PI_4), |s| (s.inner_cone_angle, s.outer_cone_angle));
    // The limit is pi/2 as f32 wrote it.
    if !(inner >= 0.0 && inner <= outer && outer > 0.0 && outer < 1.570_797) {
        return Err("its cone must have 0 <= inner angle < outer angle <= pi/2; correct it");
    }
    let [inner_h, outer_h] = [inner, outer].map(one_minus_cos);
    Ok(if inner_h < outer_h { Falloff::Smooth { inner_h, outer_h } } else { Falloff::Hard { cone_h: outer_h } })
}
