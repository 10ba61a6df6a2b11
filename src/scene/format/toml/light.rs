//! `[[light]]`: point, spot and directional lights; and what photometric and radiometric keys mean, here and on shapes.
//!
//! A number in W, W/sr or W/m2 is a luminance-weighted one: with `color` or `temperature_k` the light keeps its luminous flux, 683 lm
//! a watt of luminance, whatever its colour; a triple is taken channel by channel. Photometric keys are numbers over 683.

use glam::DVec3;

use super::table::{Item, Table};
use super::{Builder, keys};
use crate::light::Lamp;
use crate::light::directional::Directional;
use crate::light::point::{Point, SOLID_ANGLE};
use crate::light::spot::{Falloff, Spot, one_minus_cos};
use crate::light::sun::Sun;
use crate::math::special::luminance;
use crate::math::spectrum::{LUMEN_PER_WATT, blackbody_rgb};
use crate::scene::{Error, Light, MAX_RADIANCE, Mesh, Shape, Value};

/// A way to say how strong a light is: its key, whether it is photometric, and what divides it.
pub struct Measure(pub &'static str, pub bool, pub f64);

impl<'a> Builder<'a> {
    pub fn light(&mut self, item: &'a Item<'a>) -> Result<(), Error> {
        let kind = item.get_ref().get("type").and_then(|t| t.get_ref().as_str()).unwrap_or("").to_string();
        let section = match kind.as_str() {
            "point" => &keys::POINT,
            "spot" => &keys::SPOT,
            "directional" => &keys::DIRECTIONAL,
            _ => {
                let at = item.get_ref().get("type").map_or(item.span(), |t| t.span());
                let hint = "add type = \"point\", \"spot\" or \"directional\"";
                return Err(self.source.error(at, format!("a [[light]] without a known type; {hint}")));
            }
        };
        let table = Table::open(self.source, item, &[&keys::LIGHT, section], &[])?;
        let color = color(&table)?;
        let lamp = match kind.as_str() {
            "point" => {
                Lamp::Point(Point { position: position(&table)?, intensity: intensity(&table, SOLID_ANGLE, color)? })
            }
            "spot" => {
                let position = position(&table)?;
                let axis = direction(&table, Some(position))?;
                let falloff = falloff(&table)?;
                Lamp::Spot(Spot {
                    position,
                    axis,
                    falloff,
                    intensity: intensity(&table, falloff.solid_angle(), color)?,
                })
            }
            _ => directional(&table, color)?,
        };
        let name = table.text("name")?.unwrap_or(&kind).to_string();
        let group = super::group::group(&table)?;
        self.scene.lights.push(Light { name, lamp, group });
        Ok(())
    }
}

fn position(table: &Table<'_>) -> Result<DVec3, Error> {
    table.numbers::<3>("position")?.map(DVec3::from).ok_or_else(|| table.missing("position"))
}

/// The way the light goes.
fn direction(table: &Table<'_>, from: Option<DVec3>) -> Result<DVec3, Error> {
    let given = table.numbers::<3>("direction")?.map(DVec3::from);
    let target = if from.is_some() { table.numbers::<3>("target")?.map(DVec3::from) } else { None };
    let (key, v) = match (given, target, from) {
        (Some(_), Some(_), _) => return Err(table.error("target", "stands beside `direction`; keep one of the two")),
        (_, Some(target), Some(from)) => ("target", target - from),
        (Some(direction), ..) => ("direction", direction),
        _ => return Err(table.missing("direction")),
    };
    v.try_normalize().ok_or_else(|| {
        let reason =
            if key == "target" { "is where the light stands; move one of the two" } else { "must not be zero" };
        table.error(key, reason)
    })
}

fn intensity(table: &Table<'_>, solid_angle: f64, color: Option<DVec3>) -> Result<DVec3, Error> {
    let measures = [
        Measure("power", false, solid_angle),
        Measure("power_lm", true, solid_angle),
        Measure("intensity", false, 1.0),
        Measure("intensity_cd", true, 1.0),
    ];
    strength(table, &measures, color)?.ok_or_else(|| table.missing("power` or `intensity"))
}

fn directional(table: &Table<'_>, color: Option<DVec3>) -> Result<Lamp, Error> {
    let to_light = -direction(table, None)?;
    let measures = [Measure("irradiance", false, 1.0), Measure("irradiance_lx", true, 1.0)];
    let irradiance = strength(table, &measures, color)?.ok_or_else(|| table.missing("irradiance"))?;
    match table.number("angular_diameter_deg")?.unwrap_or(0.0) {
        0.0 => Ok(Lamp::Directional(Directional { to_light, irradiance })),
        d if d > 0.0 && d <= 180.0 => Ok(Lamp::Sun(Sun { to_light, irradiance, half_angle_rad: 0.5 * d.to_radians() })),
        _ => Err(table.error("angular_diameter_deg", "must lie from 0 to 180 degrees")),
    }
}

fn falloff(table: &Table<'_>) -> Result<Falloff, Error> {
    let kind = table.text("falloff")?.unwrap_or("smooth");
    for (key, owners) in
        [("cone_deg", &["hard", "smooth"][..]), ("inner_cone_deg", &["smooth"]), ("exponent", &["cosine"])]
    {
        if table.get(key).is_some() && !owners.contains(&kind) {
            return Err(table.error(key, format!("is no key of falloff = \"{kind}\"; remove it")));
        }
    }
    let cone = || {
        let degrees = table.number("cone_deg")?.ok_or_else(|| table.missing("cone_deg"))?;
        let is_cone = degrees > 0.0 && degrees <= 180.0;
        if is_cone { Ok(degrees) } else { Err(table.error("cone_deg", "must be above 0 and not above 180 degrees")) }
    };
    match kind {
        "hard" => Ok(Falloff::Hard { cone_h: one_minus_cos(cone()?.to_radians()) }),
        "smooth" => {
            let (outer, inner) = (cone()?, table.number("inner_cone_deg")?.unwrap_or(0.0));
            if !(0.0..outer).contains(&inner) {
                return Err(table.error("inner_cone_deg", "must be at least 0 and below `cone_deg`"));
            }
            let [inner_h, outer_h] = [inner, outer].map(|a| one_minus_cos(a.to_radians()));
            Ok(Falloff::Smooth { inner_h, outer_h })
        }
        "cosine" => match table.number("exponent")?.unwrap_or(1.0) {
            exponent if (0.0..=1e4).contains(&exponent) => Ok(Falloff::Cosine { exponent }),
            _ => Err(table.error("exponent", "must lie from 0 to 10000")),
        },
        _ => Err(table.error("falloff", "must be \"hard\", \"cosine\" or \"smooth\"")),
    }
}

/// The colour of luminance 1 that `color` or `temperature_k` name.
fn color(table: &Table<'_>) -> Result<Option<DVec3>, Error> {
    match (table.numbers::<3>("color")?.map(DVec3::from), table.number("temperature_k")?) {
        (Some(_), Some(_)) => Err(table.error("temperature_k", "stands beside `color`; keep one of the two")),
        (Some(c), None) if c.min_element() < 0.0 || luminance(c) <= 0.0 => {
            Err(table.error("color", "must not be negative or black"))
        }
        (Some(c), None) => Ok(Some(c / luminance(c))),
        (None, Some(t)) if (500.0..=1e5).contains(&t) => Ok(Some(blackbody_rgb(t))),
        (None, Some(_)) => Err(table.error("temperature_k", "must lie from 500 to 100000 K")),
        (None, None) => Ok(None),
    }
}

/// What the one key of `measures` in the table says, over its divisor; None where there is none. `color` has luminance 1.
pub fn strength(table: &Table<'_>, measures: &[Measure], color: Option<DVec3>) -> Result<Option<DVec3>, Error> {
    let mut given = measures.iter().filter(|m| table.get(m.0).is_some());
    let Some(Measure(key, is_photometric, divisor)) = given.next() else { return Ok(None) };
    if let Some(other) = given.next() {
        return Err(table.error(other.0, format!("stands beside `{key}`; keep one of the two")));
    }
    let is_triple = table.get(key).is_some_and(|item| item.get_ref().is_array());
    if is_triple && *is_photometric {
        return Err(table.error(key, "must be a number; `color` gives its colour"));
    }
    if is_triple && color.is_some() {
        return Err(
            table.error(key, "has a colour of its own; write one number, or leave `color` and `temperature_k` out")
        );
    }
    let value = DVec3::from(table.splat::<3>(key)?.unwrap_or_default());
    if value.min_element() < 0.0 {
        return Err(table.error(key, "must not be negative"));
    }
    let per_watt = if *is_photometric { LUMEN_PER_WATT } else { 1.0 };
    let strength = value * color.unwrap_or(DVec3::ONE) / (per_watt * divisor);
    // A divisor of 0 is a shape without area, which the caller tells.
    if *divisor > 0.0 && strength.max_element() > MAX_RADIANCE {
        let most = strength.max_element();
        return Err(table
            .error(key, format!("comes to {most:.3e} in W, sr and m2, and {MAX_RADIANCE:e} is the most; lower it")));
    }
    Ok(Some(strength))
}

/// The keys that `emission_of_power` reads stand there.
pub fn asks_for_power(table: &Table<'_>) -> bool {
    ["power", "power_lm"].iter().any(|key| table.get(key).is_some())
}

/// Emission that gives a whole lamp of this area the power that `table` asks for, in the colour of its material's own emission.
pub fn emission_of_power(
    table: &Table<'_>,
    own: Option<&Value>,
    area: f64,
    sides: f64,
) -> Result<Option<Value>, Error> {
    let measure = std::f64::consts::PI * area * sides;
    let measures = [Measure("power", false, measure), Measure("power_lm", true, measure)];
    let Some(key) = measures.iter().map(|m| m.0).find(|key| table.get(key).is_some()) else { return Ok(None) };
    let is_triple = table.get(key).is_some_and(|item| item.get_ref().is_array());
    let color = match own {
        None => None,
        Some(Value::Constant(_)) if is_triple => None,
        Some(Value::Constant(c)) if luminance(DVec3::new(c[0], c[1], c[2])) <= 0.0 => {
            let reason =
                "scales the emission of its material, which is black; give that a colour, or write three numbers here";
            return Err(table.error(key, reason));
        }
        Some(Value::Constant(c)) => Some(DVec3::new(c[0], c[1], c[2]) / luminance(DVec3::new(c[0], c[1], c[2]))),
        Some(_) => {
            let reason = "needs an emission that is the same all over, and the material's comes from a texture; scale that instead";
            return Err(table.error(key, reason));
        }
    };
    let radiance = strength(table, &measures, color)?.filter(|_| area > 0.0 && area.is_finite());
    let radiance = radiance.ok_or_else(|| table.error(key, "is asked of a shape without area"))?;
    Ok(Some(Value::rgb(radiance.x, radiance.y, radiance.z)))
}

/// Area of a placed shape, m2.
pub fn area(shape: Shape, to_world: &glam::DAffine3, meshes: &[Mesh]) -> f64 {
    let m = &to_world.matrix3;
    match shape {
        Shape::Sphere => 4.0 * std::f64::consts::PI * m.x_axis.length_squared(),
        Shape::Disc => std::f64::consts::PI * m.x_axis.cross(m.y_axis).length(),
        Shape::Rectangle => 4.0 * m.x_axis.cross(m.y_axis).length(),
        Shape::Mesh(mesh) => {
            let mesh = &meshes[mesh];
            let at = |i: u32| *m * DVec3::from(mesh.positions[i as usize].map(f64::from));
            mesh.triangles.iter().map(|t| 0.5 * (at(t[1]) - at(t[0])).cross(at(t[2]) - at(t[0])).length()).sum()
        }
    }
}

#[cfg(test)]
#[path = "light_tests.rs"]
mod tests;
