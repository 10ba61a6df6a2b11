//! `[camera]`: where it stands and which rays it collects.

use glam::{DAffine3, DMat3, DVec3};

use super::table::Table;
use super::{Builder, keys};
use crate::scene::{Camera, Error, Projection};

/// Keys that only some types have.
const OWN: &[(&str, &[&str])] = &[
    ("fov_y_deg", &["perspective", "thin_lens"]),
    ("lens_radius", &["thin_lens"]),
    ("f_number", &["thin_lens"]),
    ("focal_length_mm", &["thin_lens"]),
    ("focus_distance", &["thin_lens"]),
    ("height", &["orthographic"]),
];

impl<'a> Builder<'a> {
    pub fn camera(&mut self, top: &Table<'a>) -> Result<(), Error> {
        let Some(item) = top.get("camera") else { return Ok(()) };
        let table = Table::open(self.source, item, &[&keys::CAMERA], &[])?;
        let kind = table.text("type")?.unwrap_or("perspective");
        for (key, kinds) in OWN {
            if table.get(key).is_some() && !kinds.contains(&kind) {
                return Err(table.error(key, format!("is no key of a camera of type \"{kind}\"; remove it")));
            }
        }
        let vector = |key| Ok::<_, Error>(table.numbers::<3>(key)?.map(DVec3::from));
        let (position, target, up) = (vector("position")?, vector("target")?, vector("up")?);
        let is_placed = position.is_some();
        if !is_placed && (target.is_some() || up.is_some() || kind == "panorama") {
            return Err(table.missing("position"));
        }
        let target = target.unwrap_or(DVec3::ZERO);
        let distance = position.map(|p| p.distance(target));
        let projection = match kind {
            "perspective" => Projection::Perspective { fov_y_rad: fov(&table)? },
            "thin_lens" => thin_lens(&table, distance)?,
            "orthographic" => {
                let height = above_zero(&table, "height")?;
                // 0 is filled in when the bounds are framed.
                let half_height = 0.5 * height.unwrap_or(if is_placed { 2.0 } else { 0.0 });
                Projection::Orthographic { half_width: 0.0, half_height }
            }
            "panorama" => Projection::Panorama,
            _ => {
                let known = "must be \"perspective\", \"thin_lens\", \"orthographic\" or \"panorama\"";
                return Err(table.error("type", known));
            }
        };
        let to_world = match position {
            Some(position) => look(&table, position, target, up.unwrap_or(DVec3::Y))?,
            None => DAffine3::IDENTITY,
        };
        self.scene.camera = Camera { to_world, projection, is_placed };
        Ok(())
    }
}

fn look(table: &Table<'_>, position: DVec3, target: DVec3, up: DVec3) -> Result<DAffine3, Error> {
    let back = (position - target).normalize_or_zero();
    let right = up.normalize_or_zero().cross(back);
    if back == DVec3::ZERO {
        return Err(table.error("target", "is where the camera stands; move one of the two"));
    }
    if right.length() < 1e-9 {
        return Err(table.error("up", "points along the view; choose another"));
    }
    let right = right.normalize();
    Ok(DAffine3 { matrix3: DMat3::from_cols(right, back.cross(right), back), translation: position })
}

fn fov(table: &Table<'_>) -> Result<f64, Error> {
    let degrees = table.number("fov_y_deg")?.unwrap_or(40.0);
    if !(degrees > 0.0 && degrees < 180.0) {
        return Err(table.error("fov_y_deg", "must be above 0 and below 180 degrees"));
    }
    Ok(degrees.to_radians())
}

/// `distance`: to the target, where the camera is placed.
fn thin_lens(table: &Table<'_>, distance: Option<f64>) -> Result<Projection, Error> {
    let radius = table.number("lens_radius")?;
    let (f_number, focal_length_mm) = (above_zero(table, "f_number")?, above_zero(table, "focal_length_mm")?);
    if radius.is_some_and(|r| r < 0.0) {
        return Err(table.error("lens_radius", "must not be negative"));
    }
    let lens_radius = match (radius, f_number, focal_length_mm) {
        (Some(_), Some(_), _) => {
            return Err(table.error("f_number", "stands beside `lens_radius`; keep one of the two"));
        }
        (Some(_), _, Some(_)) => return Err(table.error("focal_length_mm", "goes with `f_number` only; remove it")),
        (Some(radius), None, None) => radius,
        // The entrance pupil of a lens of focal length f at f-number N has the diameter f/N.
        (None, Some(number), Some(focal)) => 0.5e-3 * focal / number,
        (None, Some(_), None) => return Err(table.missing("focal_length_mm` for its `f_number")),
        (None, None, Some(_)) => return Err(table.missing("f_number` for its `focal_length_mm")),
        (None, None, None) => 0.0,
    };
    let focus_distance = above_zero(table, "focus_distance")?.or(distance);
    Ok(Projection::ThinLens { fov_y_rad: fov(table)?, lens_radius, focus_distance })
}

fn above_zero(table: &Table<'_>, key: &str) -> Result<Option<f64>, Error> {
    match table.number(key)? {
        Some(x) if x <= 0.0 => Err(table.error(key, "must be above 0")),
        other => Ok(other),
    }
}
