//! Placement keys shared by shapes and models: scaled, then turned, then moved; or a whole matrix.

use glam::{DAffine3, DMat3, DVec3};

use super::table::Table;
use crate::scene::Error;

/// Object to world from `scale`, `rotate_deg`, `rotate_axis`, `translate`, or from `matrix`.
pub fn transform(table: &Table<'_>) -> Result<DAffine3, Error> {
    let result = match table.numbers::<16>("matrix")? {
        Some(m) => {
            if let Some(key) =
                ["scale", "rotate_deg", "rotate_axis", "translate"].iter().find(|k| table.get(k).is_some())
            {
                return Err(table.error(key, "stands beside `matrix`; keep one of the two"));
            }
            if m[12..] != [0.0, 0.0, 0.0, 1.0] {
                return Err(table.error("matrix", "must end in 0, 0, 0, 1: it is written row by row"));
            }
            let row = |i: usize| DVec3::new(m[i], m[i + 1], m[i + 2]);
            DAffine3 {
                matrix3: DMat3::from_cols(row(0), row(4), row(8)).transpose(),
                translation: DVec3::new(m[3], m[7], m[11]),
            }
        }
        None => {
            let scale = DVec3::from(table.splat::<3>("scale")?.unwrap_or([1.0; 3]));
            let translation = DVec3::from(table.numbers::<3>("translate")?.unwrap_or([0.0; 3]));
            DAffine3 { matrix3: rotation(table)? * DMat3::from_diagonal(scale), translation }
        }
    };
    // Flat or non-finite placements have no inverse: normals, and rays in object space, would not exist.
    if result.is_finite() && is_invertible(&result.matrix3) {
        return Ok(result);
    }
    Err(table.error(
        placed_by(table),
        "gives a transform without an inverse (an axis has length 0, or two fall together); make it invertible",
    ))
}

/// The key that an unusable placement is told at.
pub fn placed_by(table: &Table<'_>) -> &'static str {
    if table.get("matrix").is_some() { "matrix" } else { "scale" }
}

fn rotation(table: &Table<'_>) -> Result<DMat3, Error> {
    let Some(axis) = table.numbers::<3>("rotate_axis")? else {
        let angles = match table.get("rotate_deg") {
            Some(item) if !item.get_ref().is_array() => {
                if table.number("rotate_deg")? == Some(0.0) {
                    return Ok(DMat3::IDENTITY);
                }
                return Err(table.error("rotate_deg", "is one number, so it needs `rotate_axis`; or write [x, y, z]"));
            }
            _ => table.numbers::<3>("rotate_deg")?.unwrap_or([0.0; 3]),
        };
        let [x, y, z] = angles.map(f64::to_radians);
        return Ok(DMat3::from_rotation_z(z) * DMat3::from_rotation_y(y) * DMat3::from_rotation_x(x));
    };
    let axis = DVec3::from(axis).try_normalize().ok_or_else(|| table.error("rotate_axis", "must not be zero"))?;
    let angle = table.number("rotate_deg")?.ok_or_else(|| table.missing("rotate_deg"))?;
    Ok(DMat3::from_axis_angle(axis, angle.to_radians()))
}

/// False when the columns span no volume to f64: the determinant against the product of the columns' lengths.
pub fn is_invertible(m: &DMat3) -> bool {
    let lengths = m.x_axis.length() * m.y_axis.length() * m.z_axis.length();
    lengths > 0.0 && (m.determinant() / lengths).abs() > 1e-12
}
