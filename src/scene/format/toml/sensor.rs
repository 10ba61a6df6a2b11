//! `[[sensor]]`: what `measure` measures.

use std::collections::HashSet;

use glam::DVec3;

use super::table::{Table, nearest};
use super::{Builder, keys};
use crate::camera::surface_area;
use crate::scene::{Error, Place, Quantity, Sensor, SurfaceMeter};

/// Keys and the types that have them.
const OWN: &[(&str, &[&str])] = &[
    ("position", &["radiance", "irradiance"]),
    ("direction", &["radiance"]),
    ("normal", &["irradiance"]),
    ("shape", &["irradiance", "flux"]),
    ("side", &["irradiance", "flux"]),
    ("light", &["irradiance", "flux"]),
];

impl<'a> Builder<'a> {
    /// After the shapes and their patches: sensors name shapes.
    pub fn sensors(&mut self, top: &Table<'a>) -> Result<(), Error> {
        let mut names = HashSet::new();
        for item in top.tables("sensor")? {
            let table = Table::open(self.source, item, &[&keys::SENSOR], &[])?;
            let sensor = self.sensor(&table)?;
            if !names.insert(sensor.name.clone()) {
                return Err(
                    table.error("name", format!("\"{}\" is taken by another sensor; choose another", sensor.name))
                );
            }
            self.scene.sensors.push(sensor);
        }
        Ok(())
    }

    fn sensor(&self, table: &Table<'a>) -> Result<Sensor, Error> {
        let kind = table.text("type")?.ok_or_else(|| table.missing("type"))?;
        if !["radiance", "irradiance", "flux"].contains(&kind) {
            return Err(table.error("type", "must be \"radiance\", \"irradiance\" or \"flux\""));
        }
        for (key, kinds) in OWN {
            if table.get(key).is_some() && !kinds.contains(&kind) {
                return Err(table.error(key, format!("is no key of a sensor of type \"{kind}\"; remove it")));
            }
        }
        let name = table.text("name")?.ok_or_else(|| table.missing("name"))?.to_owned();
        let (quantity, place) = match kind {
            "radiance" => {
                let direction = unit(table, "direction")?;
                (Quantity::Radiance, Place::Ray { position: position(table)?, direction })
            }
            "irradiance" if table.get("shape").is_none() => {
                for key in ["side", "light"] {
                    if table.get(key).is_some() {
                        return Err(
                            table.error(key, "needs `shape`; a point measures what arrives on its normal's side")
                        );
                    }
                }
                let normal = unit(table, "normal")?;
                (Quantity::Irradiance, Place::Point { position: position(table)?, normal })
            }
            _ => {
                let place = self.surface(table)?;
                let is_leaving = matches!(place, Place::Surface { is_leaving: true, .. });
                let of_area = if is_leaving { Quantity::Exitance } else { Quantity::Irradiance };
                (if kind == "flux" { Quantity::Flux } else { of_area }, place)
            }
        };
        Ok(Sensor { name, quantity, place })
    }

    fn surface(&self, table: &Table<'a>) -> Result<Place, Error> {
        for key in ["position", "normal"] {
            if table.get(key).is_some() {
                return Err(table.error(key, "stands beside `shape`; keep one of the two"));
            }
        }
        let name = table.text("shape")?.ok_or_else(|| table.missing("shape"))?;
        let instances = &self.scene.instances;
        let shapes: Vec<usize> = (0..instances.len()).filter(|&i| instances[i].name == name).collect();
        if shapes.is_empty() {
            let hint = nearest(name, instances.iter().map(|i| i.name.as_str()));
            return Err(table.error("shape", format!("is \"{name}\", and no shape has that name; {hint}")));
        }
        let area = surface_area(&self.scene, &shapes);
        if !(area > 0.0 && area.is_finite()) {
            return Err(
                table.error("shape", format!("is \"{name}\", whose area is {area} m2; name one that has an area"))
            );
        }
        let is = |key, [first, second]: [&str; 2]| match table.text(key)? {
            None => Ok(false),
            Some(word) if word == first => Ok(false),
            Some(word) if word == second => Ok(true),
            Some(_) => Err(table.error(key, format!("must be \"{first}\" or \"{second}\""))),
        };
        let is_back = is("side", ["front", "back"])?;
        let is_leaving = is("light", ["arriving", "leaving"])?;
        Ok(Place::Surface { meter: SurfaceMeter { shapes, is_back }, is_leaving })
    }
}

fn position(table: &Table<'_>) -> Result<DVec3, Error> {
    table.numbers::<3>("position")?.map(DVec3::from).ok_or_else(|| table.missing("position"))
}

fn unit(table: &Table<'_>, key: &str) -> Result<DVec3, Error> {
    let v = DVec3::from(table.numbers::<3>(key)?.ok_or_else(|| table.missing(key))?);
    // By the largest component first: squares of tiny or huge lengths leave f64's range.
    let largest = v.abs().max_element();
    (v / largest).try_normalize().ok_or_else(|| table.error(key, "must not be zero"))
}
