//! Rows of shaders/core/{frame,warp}.glsl.

use glam::{DVec2, DVec3};

use super::inputs::Inputs;
use super::probe::{EPS, Probe};
use crate::math::{frame::Frame, warp};

const ROUND: &str = "one vector: the scale is its length";

fn v(x: &[f64]) -> DVec3 {
    DVec3::new(x[0], x[1], x[2])
}

fn units(r: &mut Inputs) -> [f32; 2] {
    [r.unit(), r.unit()]
}

/// A direction, its numbers from the upper half.
fn upper(r: &mut Inputs) -> [f32; 3] {
    r.upper_direction()
}

fn cone(r: &mut Inputs) -> [f32; 3] {
    [r.unit(), r.unit(), r.log(1e-12, 2.0)]
}

/// 1 - cos of a cone and a direction within it, as rounded numbers.
fn in_cone(r: &mut Inputs) -> [f32; 4] {
    let [u, w, h] = cone(r);
    let d = warp::uniform_cone([f64::from(u), f64::from(w)], f64::from(h));
    [d.x as f32, d.y as f32, d.z as f32, h]
}

fn disk(r: &mut Inputs) -> [f32; 2] {
    let d = warp::concentric_disk([f64::from(r.unit()), f64::from(r.unit())]);
    [d.x as f32, d.y as f32]
}

/// Numbers of the unit square that came back, where turns of 0 and 1 are the same: worst distance over `allowed`.
fn came_back(y: &[f32], wanted: [f64; 2], allowed: f64) -> f64 {
    let turn = (f64::from(y[1]) - wanted[1]).abs();
    let inside = y.iter().all(|&u| (0.0..1.0).contains(&u));
    if inside { (f64::from(y[0]) - wanted[0]).abs().max(turn.min(1.0 - turn)) / allowed } else { f64::INFINITY }
}

pub fn probes() -> Vec<Probe> {
    let mut rows = directions();
    rows.extend(densities());
    rows.extend(inverses());
    rows.extend(frames());
    rows
}

fn directions() -> Vec<Probe> {
    let three = |call: &str| format!("vec3 d = {call}; y0 = d.x; y1 = d.y; y2 = d.z;");
    vec![
        Probe::real("concentric_disk", "vec2 d = concentric_disk(vec2(x0, x1)); y0 = d.x; y1 = d.y;", units, |u| {
            warp::concentric_disk(u).to_array()
        })
        .vector()
        .within(-1.0, 1.0)
        .because(ROUND),
        Probe::real("cosine_hemisphere", &three("cosine_hemisphere(vec2(x0, x1))"), units, |u| {
            // 1 - r^2 from the square, as the direction's own z cancels in f64 too.
            let r = (2.0 * u[0] - 1.0).abs().max((2.0 * u[1] - 1.0).abs());
            let d = warp::cosine_hemisphere(u);
            [d.x, d.y, ((1.0 - r) * (1.0 + r)).max(0.0).sqrt()]
        })
        .vector()
        .because(ROUND),
        Probe::real("cosine_hemisphere z", "y0 = cosine_hemisphere(vec2(x0, x1)).z;", units, |u| {
            let r = (2.0 * u[0] - 1.0).abs().max((2.0 * u[1] - 1.0).abs());
            [((1.0 - r) * (1.0 + r)).max(0.0).sqrt()]
        })
        .within(0.0, 1.0)
        .because("relative down to grazing"),
        Probe::real("uniform_hemisphere", &three("uniform_hemisphere(vec2(x0, x1))"), units, |u| {
            warp::uniform_hemisphere(u).to_array()
        })
        .vector()
        .because(ROUND),
        Probe::real("uniform_sphere", &three("uniform_sphere(vec2(x0, x1))"), units, |u| {
            warp::uniform_sphere(u).to_array()
        })
        .vector()
        .because(ROUND),
        Probe::real("uniform_cone", &three("uniform_cone(vec2(x0, x1), x2)"), cone, |[a, b, h]| {
            warp::uniform_cone([a, b], h).to_array()
        })
        .vector()
        .because(ROUND),
        Probe::real(
            "uniform_cone radius",
            "vec3 d = uniform_cone(vec2(x0, x1), x2); y0 = d.x; y1 = d.y;",
            cone,
            |[a, b, h]| warp::uniform_cone([a, b], h).truncate().to_array(),
        )
        .vector()
        .because("relative to the radius: a cone of 1e-12 keeps its shape"),
        Probe::real(
            "uniform_triangle",
            "vec2 b = uniform_triangle(vec2(x0, x1)); y0 = b.x; y1 = b.y;",
            units,
            warp::uniform_triangle,
        )
        .within(0.0, 1.0),
    ]
}

fn densities() -> Vec<Probe> {
    vec![
        Probe::real(
            "cosine_hemisphere_pdf",
            "y0 = cosine_hemisphere_pdf(x0);",
            |r| [r.range(-1.0, 1.0)],
            |[c]| [warp::cosine_hemisphere_pdf(c)],
        )
        .within(0.0, 1.0),
        Probe::real(
            "uniform_hemisphere_pdf",
            "y0 = uniform_hemisphere_pdf(x0);",
            |r| [r.range(-1.0, 1.0)],
            |[c]| [warp::uniform_hemisphere_pdf(c)],
        ),
        Probe::real(
            "uniform_sphere_pdf",
            "y0 = uniform_sphere_pdf();",
            |r| [r.unit()],
            |_| [warp::uniform_sphere_pdf()],
        ),
        Probe::real(
            "uniform_cone_pdf",
            "y0 = uniform_cone_pdf(x0);",
            |r| [r.log(1e-30, 2.0)],
            |[h]| [warp::uniform_cone_pdf(h)],
        ),
    ]
}

fn inverses() -> Vec<Probe> {
    // A rounded direction says where its number was only as finely as its own last bit: 16 eps of the square.
    let why = "16 eps of the square; the turn is free at the pole, where 4 eps / radius is added";
    let judged = |name: &str, glsl: &str, generate: fn(&mut Inputs) -> [f32; 3], back: fn(DVec3) -> [f64; 2]| {
        Probe::judged(name, glsl, 2, generate, move |x, y| {
            let d = DVec3::new(f64::from(x[0]), f64::from(x[1]), f64::from(x[2]));
            let radius = d.truncate().length();
            if radius == 0.0 {
                return 0.0;
            }
            let wanted = back(d / d.length());
            came_back(y, wanted.map(|u| u.clamp(0.0, 1.0)), 16.0 * EPS + 4.0 * EPS / radius)
        })
        .because(why)
    };
    let two = |call: &str| format!("vec2 u = {call}; y0 = u.x; y1 = u.y;");
    let disk_back = |y: &[f32], d: DVec2| {
        let wanted = warp::concentric_disk_inverse(d);
        (f64::from(y[0]) - wanted[0]).abs().max((f64::from(y[1]) - wanted[1]).abs()) / (8.0 * EPS)
    };
    vec![
        Probe::judged(
            "concentric_disk_inverse",
            &two("concentric_disk_inverse(vec2(x0, x1))"),
            2,
            disk,
            move |x, y| disk_back(y, DVec2::new(f64::from(x[0]), f64::from(x[1]))),
        )
        .because("8 eps of the square"),
        Probe::judged(
            "cosine_hemisphere_inverse",
            &two("cosine_hemisphere_inverse(vec3(x0, x1, x2))"),
            2,
            upper,
            move |x, y| disk_back(y, DVec2::new(f64::from(x[0]), f64::from(x[1]))),
        )
        .because("8 eps of the square"),
        judged(
            "uniform_hemisphere_inverse",
            &two("min(uniform_hemisphere_inverse(vec3(x0, x1, x2)), vec2(ONE_MINUS_EPS))"),
            upper,
            warp::uniform_hemisphere_inverse,
        ),
        judged(
            "uniform_sphere_inverse",
            &two("min(uniform_sphere_inverse(vec3(x0, x1, x2)), vec2(ONE_MINUS_EPS))"),
            |r| r.direction(),
            warp::uniform_sphere_inverse,
        ),
        Probe::judged(
            "uniform_cone_inverse",
            &two("uniform_cone_inverse(vec3(x0, x1, x2), x3)"),
            2,
            in_cone,
            |x, y| {
                let [a, b, c, h] = [x[0], x[1], x[2], x[3]].map(f64::from);
                let d = DVec3::new(a, b, c);
                let radius = d.truncate().length();
                // Below the equator the height comes from z, whose rounding is eps of 1.
                let blur = if c > 0.0 { 8.0 * EPS } else { 8.0 * EPS / h };
                if radius == 0.0 {
                    return 0.0;
                }
                let mut wanted = warp::uniform_cone_inverse(d, h);
                wanted[0] = wanted[0].min(1.0);
                came_back(y, wanted, blur + if radius < 1e-3 && c < 0.0 { 4.0 * EPS / radius } else { 8.0 * EPS })
            },
        )
        .because("8 eps of the square (8 eps / h below the equator)"),
        Probe::real(
            "uniform_triangle_inverse",
            "vec2 u = uniform_triangle_inverse(vec2(x0, x1)); y0 = u.x; y1 = u.y;",
            |r| {
                let u = units(r).map(f64::from);
                warp::uniform_triangle(u).map(|b| b as f32)
            },
            warp::uniform_triangle_inverse,
        ),
    ]
}

/// Nine numbers of a frame: how far from orthonormal and right-handed, and n from the given one.
fn frame_error(y: &[f32], n: DVec3) -> f64 {
    let column = |i: usize| DVec3::new(f64::from(y[3 * i]), f64::from(y[3 * i + 1]), f64::from(y[3 * i + 2]));
    let (t, b, z) = (column(0), column(1), column(2));
    // The given normal is itself a unit vector to one rounding only.
    let units = [t, b].iter().fold(0.0f64, |a, c| a.max((c.length() - 1.0).abs()));
    let dots = t.dot(b).abs().max(b.dot(z).abs()).max(z.dot(t).abs());
    let hand = (t.cross(b) - z).length();
    units.max(dots).max(hand).max((z - n).length())
}

fn frames() -> Vec<Probe> {
    let nine = |call: &str| {
        format!(
            "Frame f = {call}; y0 = f.t.x; y1 = f.t.y; y2 = f.t.z; y3 = f.b.x; y4 = f.b.y; y5 = f.b.z; \
             y6 = f.n.x; y7 = f.n.y; y8 = f.n.z;"
        )
    };
    let tangent_rows: [(&str, fn(&mut Inputs) -> [f32; 6]); 2] = [
        ("frame_from_tangent", |r| {
            let (n, t) = (r.direction(), r.direction());
            let size = r.log(1e-10, 1e10);
            [n[0], n[1], n[2], t[0] * size, t[1] * size, t[2] * size]
        }),
        ("frame_from_tangent special", |r| {
            let n = r.direction();
            let t = if r.once_in(2) { n.map(|c| c * 3.0) } else { [r.any_float(), r.any_float(), r.any_float()] };
            [n[0], n[1], n[2], t[0], t[1], t[2]]
        }),
    ];
    let mut rows = vec![
        Probe::real(
            "frame_from_normal",
            &nine("frame_from_normal(vec3(x0, x1, x2))"),
            |r| r.direction(),
            |n| {
                let f = Frame::from_normal(v(&n));
                let (t, b) = (f.t, f.b);
                [t.x, t.y, t.z, b.x, b.y, b.z, n[0], n[1], n[2]]
            },
        )
        .vector()
        .k(8.0)
        .because(ROUND),
        Probe::judged(
            "frame_from_normal axes",
            &nine("frame_from_normal(vec3(x0, x1, x2))"),
            9,
            |r| r.direction(),
            |x, y| frame_error(y, DVec3::new(f64::from(x[0]), f64::from(x[1]), f64::from(x[2]))) / (8.0 * EPS),
        )
        .because("orthonormal and right-handed to 8 eps"),
    ];
    for (name, generate) in tangent_rows {
        rows.push(
            Probe::judged(
                name,
                &nine("frame_from_tangent(vec3(x0, x1, x2), vec3(x3, x4, x5))"),
                9,
                generate,
                |x, y| {
                    let x: Vec<f64> = x.iter().map(|&c| f64::from(c)).collect();
                    let (n, tangent) = (v(&x[..3]), v(&x[3..]));
                    let orthonormal = frame_error(y, n) / (12.0 * EPS);
                    let t = DVec3::new(f64::from(y[0]), f64::from(y[1]), f64::from(y[2]));
                    // Direction of the axis where the tangent says it clearly; at the threshold either frame is right.
                    let across = tangent.reject_from(n).length() / tangent.length();
                    let is_clear = tangent.is_finite() && across > 1e-3 && (1e-30..1e30).contains(&tangent.length());
                    let off = if is_clear {
                        t.cross(tangent).dot(n).abs() / tangent.length() / (across * 16.0 * EPS / across.min(1.0))
                    } else {
                        0.0
                    };
                    orthonormal.max(off)
                },
            )
            .because("orthonormal to 12 eps; x axis in the plane of n and tangent to 16 eps"),
        );
    }
    rows.push(
        Probe::real(
            "to_local, to_world",
            "Frame f = frame_from_normal(vec3(x0, x1, x2)); vec3 a = to_local(f, vec3(x3, x4, x5)); \
             vec3 b = to_world(f, vec3(x3, x4, x5)); y0 = a.x; y1 = a.y; y2 = a.z; y3 = b.x; y4 = b.y; y5 = b.z;",
            |r| {
                let (n, d) = (r.direction(), r.direction());
                [n[0], n[1], n[2], d[0], d[1], d[2]]
            },
            |x| {
                let f = Frame::from_normal(v(&x[..3]));
                let (a, b) = (f.to_local(v(&x[3..])), f.to_world(v(&x[3..])));
                [a.x, a.y, a.z, b.x, b.y, b.z]
            },
        )
        .vector()
        .k(8.0)
        .because(ROUND),
    );
    rows
}
