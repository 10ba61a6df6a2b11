//! Closed forms of lights without a surface: point, spot, directional, the sun; and of their units.

use std::f64::consts::PI;

use glam::DVec3;

use super::{Known, camera, floor_at, lambert, material, narrow, place, sphere_at};
use crate::light::Lamp;
use crate::light::directional::Directional;
use crate::light::point::Point;
use crate::light::spot::{Falloff, Spot, one_minus_cos};
use crate::light::sun::Sun;
use crate::scene::*;

const ALBEDO: DVec3 = DVec3::new(0.7, 0.5, 0.3);

/// A Lambert floor seen at the origin.
fn floor(name: &str, lamps: &[Lamp]) -> Scene {
    let mut scene = narrow(name, DVec3::new(0.0, 1.0, 0.5), DVec3::ZERO);
    place(&mut scene, "floor", Shape::Rectangle, floor_at(DVec3::ZERO, 10.0), lambert(ALBEDO));
    scene.lights = lamps.iter().map(|&lamp| Light { name: name.to_owned(), lamp, group: None }).collect();
    scene
}

fn under(theta_deg: f64) -> DVec3 {
    let theta = theta_deg.to_radians();
    DVec3::new(theta.sin(), theta.cos(), 0.0)
}

/// Point lamp of intensity I at distance d under the angle theta: E = I cos(theta)/d^2.
pub fn point_lamp() -> Known {
    let (intensity, distance) = (DVec3::new(10.0, 8.0, 4.0), 2.5);
    let lamp = Lamp::Point(Point { position: distance * under(50.0), intensity });
    let irradiance = intensity * 50f64.to_radians().cos() / (distance * distance);
    Known {
        name: "point lamp",
        about: "E = I cos(theta)/d^2",
        scene: floor("point-lamp", &[lamp]),
        radiance: ALBEDO * irradiance / PI,
    }
}

/// A black ball whose surface is 1 mm behind the lamp hides nothing: the shadow ray ends at the lamp.
pub fn point_before_a_ball() -> Known {
    let mut known = point_lamp();
    known.scene.name = "point-before-a-ball".to_owned();
    place(&mut known.scene, "ball", Shape::Sphere, sphere_at(2.601 * under(50.0), 0.1), lambert(DVec3::ZERO));
    Known { name: "point before a ball", about: "what is behind a lamp does not hide it", ..known }
}

/// 800 lm from a point: 800/(4 pi) = 63.66 cd, at 2 m 15.92 lx; radiance is photometric over 683.
pub fn lumen_lamp() -> Known {
    let intensity = DVec3::splat(800.0 / 683.0 / (4.0 * PI));
    let lamp = Lamp::Point(Point { position: DVec3::Y * 2.0, intensity });
    Known {
        name: "lumen lamp",
        about: "800 lm: 63.66 cd, 15.92 lx at 2 m",
        scene: floor("lumen-lamp", &[lamp]),
        radiance: ALBEDO * (63.661_977_236_758_13 / 4.0 / 683.0 / PI),
    }
}

/// A point lamp and a uniform sky: what has no size beside what has one.
pub fn point_under_sky() -> Known {
    let (intensity, sky) = (DVec3::new(6.0, 8.0, 10.0), DVec3::new(0.5, 0.4, 0.6));
    let lamp = Lamp::Point(Point { position: 2.0 * under(30.0), intensity });
    let mut scene = floor("point-under-sky", &[lamp]);
    scene.sky = Some(Sky { radiance: SkyRadiance::Uniform(sky), rotation_rad: 0.0, scale: 1.0 });
    let irradiance = intensity * 30f64.to_radians().cos() / 4.0 + PI * sky;
    Known { name: "point under sky", about: "E = I cos(theta)/d^2 + pi L", scene, radiance: ALBEDO * irradiance / PI }
}

/// A point lamp, the floor and the camera inside an absorbing ball: e^(-a d) along both edges. What the ball's wall, 50 m away,
/// sends back is below e^-20.
pub fn point_in_medium() -> Known {
    let absorption = DVec3::new(0.5, 1.0, 0.2);
    let (intensity, distance) = (DVec3::splat(10.0), 2.0);
    let lamp = Lamp::Point(Point { position: distance * under(20.0), intensity });
    let mut scene = floor("point-in-medium", &[lamp]);
    let mut glass = material("dielectric", &[("eta", Value::scalar(1.3))]);
    glass.interior = Some(Medium { absorption });
    place(&mut scene, "ball", Shape::Sphere, sphere_at(DVec3::ZERO, 50.0), glass);
    let length = distance + DVec3::new(0.0, 1.0, 0.5).length();
    let through = (-absorption * length).exp();
    Known {
        name: "point in medium",
        about: "E = I cos(theta)/d^2, e^(-a d) to the lamp and to the camera",
        scene,
        radiance: ALBEDO * intensity * 20f64.to_radians().cos() / (distance * distance * PI) * through,
    }
}

/// Directional light of perpendicular irradiance E under the angle theta: L = rho E cos(theta)/pi.
pub fn directional() -> Known {
    let irradiance = DVec3::new(3.0, 2.0, 1.0);
    let lamp = Lamp::Directional(Directional { to_light: under(40.0), irradiance });
    Known {
        name: "directional",
        about: "L = rho E cos(theta)/pi",
        scene: floor("directional", &[lamp]),
        radiance: ALBEDO * irradiance * 40f64.to_radians().cos() / PI,
    }
}

fn sun_of(half_angle_deg: f64) -> (Lamp, DVec3) {
    let irradiance = DVec3::new(3.0, 2.0, 1.0);
    let half_angle_rad = half_angle_deg.to_radians();
    (Lamp::Sun(Sun { to_light: under(40.0), irradiance, half_angle_rad }), irradiance)
}

/// A disc wholly above the horizon gives E cos(theta) whatever its size: here 40 degrees across, beside a lamp straight above.
pub fn wide_sun() -> Known {
    let (lamp, irradiance) = sun_of(20.0);
    let point = Lamp::Point(Point { position: DVec3::Y, intensity: irradiance });
    Known {
        name: "wide sun",
        about: "a disc of 40 degrees and a point lamp: L = rho (E cos(theta) + I/d^2)/pi",
        scene: floor("wide-sun", &[lamp, point]),
        radiance: ALBEDO * irradiance * (40f64.to_radians().cos() + 1.0) / PI,
    }
}

/// The Sun's 0.533 degrees, beside a lamp as strong as itself.
pub fn sun() -> Known {
    let (lamp, irradiance) = sun_of(0.2665);
    let point = Lamp::Point(Point { position: DVec3::Y, intensity: irradiance });
    Known {
        name: "sun",
        about: "a disc of 0.533 degrees and a point lamp: L = rho (E cos(theta) + I/d^2)/pi",
        scene: floor("sun", &[lamp, point]),
        radiance: ALBEDO * irradiance * (40f64.to_radians().cos() + 1.0) / PI,
    }
}

/// Looking at the sun: L = E/(pi sin^2(a)).
pub fn sun_seen() -> Known {
    let (lamp, irradiance) = sun_of(0.2665);
    let mut scene = floor("sun-seen", &[lamp]);
    scene.camera = camera(DVec3::Y, DVec3::Y + under(40.0), 0.002);
    Known {
        name: "sun seen",
        about: "L = E/(pi sin^2(a)), a = 0.2665 degrees",
        scene,
        radiance: irradiance / (PI * 0.2665f64.to_radians().sin().powi(2)),
    }
}

/// Three spots: inside the hard cone I/d^2; halfway between the cosines of a smooth one a quarter of it; cos^3 of the third's axis.
pub fn spots() -> Known {
    let intensity = DVec3::new(5.0, 6.0, 7.0);
    let h = |deg: f64| one_minus_cos(deg.to_radians());
    // Straight above, so that the floor's cosine is 1; axes tilted by 25 degrees in different directions.
    let spot = |falloff, axis: DVec3| Lamp::Spot(Spot { position: DVec3::Y * 2.0, axis: -axis, intensity, falloff });
    let tilt = 25f64.to_radians();
    let (x, z) = (under(25.0), DVec3::new(0.0, tilt.cos(), tilt.sin()));
    let middle = Falloff::Smooth { inner_h: 0.5 * h(25.0), outer_h: 1.5 * h(25.0) };
    let lamps = [
        spot(Falloff::Hard { cone_h: h(25.5) }, x),
        spot(middle, z),
        spot(Falloff::Cosine { exponent: 3.0 }, -z + 2.0 * DVec3::Y * tilt.cos()),
    ];
    let share = 1.0 + 0.25 + tilt.cos().powi(3);
    Known {
        name: "spots",
        about: "inside a hard cone 1, midway of a smooth one 1/4, cos^3",
        scene: floor("spots", &lamps),
        radiance: ALBEDO * intensity * share / (4.0 * PI),
    }
}

/// Outside the cones of a hard and a smooth spot there is only the point lamp's light.
pub fn spots_aside() -> Known {
    let intensity = DVec3::new(5.0, 6.0, 7.0);
    let h = |deg: f64| one_minus_cos(deg.to_radians());
    let spot = |falloff| Lamp::Spot(Spot { position: DVec3::Y * 2.0, axis: -under(25.0), intensity, falloff });
    let lamps = [
        spot(Falloff::Hard { cone_h: h(24.5) }),
        spot(Falloff::Smooth { inner_h: h(10.0), outer_h: h(24.5) }),
        Lamp::Point(Point { position: DVec3::Y * 2.0, intensity }),
    ];
    Known {
        name: "spots aside",
        about: "outside their cones spots give nothing",
        scene: floor("spots-aside", &lamps),
        radiance: ALBEDO * intensity / (4.0 * PI),
    }
}

/// All of them.
pub fn all() -> Vec<Known> {
    vec![
        point_lamp(),
        point_before_a_ball(),
        lumen_lamp(),
        point_under_sky(),
        point_in_medium(),
        directional(),
        wide_sun(),
        sun(),
        sun_seen(),
        spots(),
        spots_aside(),
    ]
}
