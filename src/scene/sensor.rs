//! What a scene wants measured (`measure`): meters for radiance along a ray, irradiance at a point or over a surface, flux through it.

use glam::{DAffine3, DMat3, DVec3};

use super::{Camera, Projection, Scene, SurfaceMeter};

/// One meter.
#[derive(Clone, Debug)]
pub struct Sensor {
    pub name: String,
    pub quantity: Quantity,
    pub place: Place,
}

/// What is measured, with its units in radiometry and photometry.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Quantity {
    Radiance,
    /// Arriving at a surface.
    Irradiance,
    /// Leaving it.
    Exitance,
    /// Over the whole surface, either way.
    Flux,
}

impl Quantity {
    pub fn name(self) -> &'static str {
        match self {
            Self::Radiance => "radiance",
            Self::Irradiance => "irradiance",
            Self::Exitance => "exitance",
            Self::Flux => "flux",
        }
    }

    /// Of the RGB values, and of the luminous value.
    pub fn units(self) -> (&'static str, &'static str) {
        match self {
            Self::Radiance => ("W/(m2 sr)", "nt"),
            Self::Irradiance => ("W/m2", "lx"),
            Self::Exitance => ("W/m2", "lm/m2"),
            Self::Flux => ("W", "lm"),
        }
    }
}

/// Where a meter stands.
#[derive(Clone, Debug, PartialEq)]
pub enum Place {
    /// Looks from `position` along the unit `direction`.
    Ray {
        position: DVec3,
        direction: DVec3,
    },
    /// A small patch with a unit normal.
    Point {
        position: DVec3,
        normal: DVec3,
    },
    Surface {
        meter: SurfaceMeter,
        is_leaving: bool,
    },
}

impl Sensor {
    /// The camera that is this meter.
    pub fn camera(&self, scene: &Scene) -> Camera {
        let at = |position: DVec3, forward: DVec3| {
            let right = forward.any_orthonormal_vector();
            DAffine3 { matrix3: DMat3::from_cols(right, right.cross(forward), -forward), translation: position }
        };
        let (to_world, projection) = match &self.place {
            Place::Ray { position, direction } => (at(*position, *direction), Projection::MeterRay),
            Place::Point { position, normal } => (at(*position, *normal), Projection::MeterPoint),
            Place::Surface { meter, is_leaving } => {
                let to_world = at(crate::camera::surface_anchor(scene, meter), DVec3::NEG_Z);
                let projection =
                    if *is_leaving { Projection::MeterLeaving } else { Projection::MeterSurface }(meter.clone());
                (to_world, projection)
            }
        };
        Camera { to_world, projection, is_placed: true }
    }

    /// Area of the surface it stands on, m2, one side.
    pub fn area_m2(&self, scene: &Scene) -> Option<f64> {
        match &self.place {
            Place::Surface { meter, .. } => Some(crate::camera::surface_area(scene, &meter.shapes)),
            _ => None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_camera_looks_along_the_normal() {
        for normal in [DVec3::X, DVec3::NEG_Y, DVec3::new(0.6, 0.0, -0.8)] {
            let place = Place::Point { position: DVec3::ONE, normal };
            let sensor = Sensor { name: String::new(), quantity: Quantity::Irradiance, place };
            let m = sensor.camera(&Scene::default()).to_world;
            assert!((m.matrix3 * DVec3::NEG_Z - normal).length() < 1e-12, "{normal}");
            assert!((m.matrix3.determinant() - 1.0).abs() < 1e-12);
            assert_eq!(m.translation, DVec3::ONE);
        }
    }
}
