//! Fresnel reflectance for unpolarised light, f64, as the textbooks write it (Born and Wolf 1999, 1.5.2 and 14.2).
//! shaders/bsdf/fresnel.glsl rearranges the same equations against cancellation in f32; gate 3 compares the two.

use glam::DVec3;

/// Reflectance of a smooth interface and the cosine on the other side (0 under total reflection).
/// `cos_o` in [0,1]; `eta` = index on the other side / index on this side, > 0.
pub fn dielectric(cos_o: f64, eta: f64) -> (f64, f64) {
    // 1 - sin_t^2 by Snell's law; 1 - cos_o^2 would lose a grazing cosine where eta = 1.
    let cos2_t = ((eta - 1.0) * (eta + 1.0) + cos_o * cos_o) / (eta * eta);
    if cos2_t <= 0.0 {
        return (1.0, 0.0);
    }
    let cos_t = cos2_t.sqrt();
    let r_parallel = (eta * cos_o - cos_t) / (eta * cos_o + cos_t);
    let r_perpendicular = (cos_o - eta * cos_t) / (cos_o + eta * cos_t);
    (0.5 * (r_parallel * r_parallel + r_perpendicular * r_perpendicular), cos_t)
}

/// 1 - reflectance of `dielectric`, with the digits it has at grazing incidence.
pub fn dielectric_transmittance(cos_o: f64, eta: f64) -> f64 {
    let (f, cos_t) = dielectric(cos_o, eta);
    if f >= 1.0 {
        return 0.0;
    }
    let (perpendicular, parallel) = (cos_o + eta * cos_t, eta * cos_o + cos_t);
    2.0 * cos_o * eta * cos_t * (perpendicular.powi(-2) + parallel.powi(-2))
}

/// Hemispherical average 2 int F mu dmu of a dielectric of index n >= 1 seen from outside, fitted by Kulla and Conty 2017.
pub fn dielectric_average(n: f64) -> f64 {
    (n - 1.0) / (4.085_67 + 1.000_71 * n)
}

/// Reflectance of a conductor of index eta - ik (relative to vacuum) in one channel, by complex arithmetic.
pub fn conductor_channel(cos_o: f64, eta: f64, k: f64) -> f64 {
    // n^2 cos_t' = sqrt(n^2 - sin^2) is the only complex square root needed.
    let (re, im) = (eta * eta - k * k - (1.0 - cos_o * cos_o), 2.0 * eta * k);
    let (a, b) = complex_sqrt(re, im);
    let perpendicular = complex_ratio2((cos_o - a, -b), (cos_o + a, b));
    let (n2_re, n2_im) = (eta * eta - k * k, 2.0 * eta * k);
    let parallel = complex_ratio2((n2_re * cos_o - a, n2_im * cos_o - b), (n2_re * cos_o + a, n2_im * cos_o + b));
    0.5 * (perpendicular + parallel)
}

pub fn conductor(cos_o: f64, eta: DVec3, k: DVec3) -> DVec3 {
    DVec3::from_array(std::array::from_fn(|c| conductor_channel(cos_o, eta[c], k[c])))
}

/// Schlick 1994, eq. 15, with f90 = 1.
pub fn schlick(cos_o: f64, f0: DVec3) -> DVec3 {
    f0 + (DVec3::ONE - f0) * (1.0 - cos_o.clamp(0.0, 1.0)).powi(5)
}

/// Hemispherical average 2 int F(mu) mu dmu of a conductor through the fit of Lazanyi and Szirmay-Kalos 2005 that is exact at
/// cos = 1 and cos = 1/7: F = F0 + (1-F0)(1-mu)^5 - a mu (1-mu)^6, whose average is F0 + (1-F0)/21 - a/126.
/// Off the true average by at most 0.05 over eta in 0.05..4, k in 1..8 (test below).
pub fn conductor_average(eta: DVec3, k: DVec3) -> DVec3 {
    let f0 = conductor(1.0, eta, k);
    let f82 = conductor(1.0 / 7.0, eta, k);
    let a = (schlick(1.0 / 7.0, f0) - f82) * (7.0 * (7.0_f64 / 6.0).powi(6));
    (f0 + (DVec3::ONE - f0) / 21.0 - a / 126.0).clamp(DVec3::ZERO, DVec3::ONE)
}

/// Principal square root of re + i im, im >= 0.
fn complex_sqrt(re: f64, im: f64) -> (f64, f64) {
    let modulus = re.hypot(im);
    let larger = (0.5 * (modulus + re.abs())).sqrt();
    let smaller = if larger > 0.0 { 0.5 * im / larger } else { 0.0 };
    if re >= 0.0 { (larger, smaller) } else { (smaller, larger) }
}

/// |z/w|^2; 1 for 0/0, the limit at grazing incidence.
fn complex_ratio2(z: (f64, f64), w: (f64, f64)) -> f64 {
    let denominator = w.0 * w.0 + w.1 * w.1;
    if denominator > 0.0 { (z.0 * z.0 + z.1 * z.1) / denominator } else { 1.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_conductor_without_absorption_is_a_dielectric() {
        for eta in [1.0, 1.2, 1.5, 2.4] {
            for i in 0..=100 {
                let c = i as f64 / 100.0;
                let (d, m) = (dielectric(c, eta).0, conductor_channel(c, eta, 0.0));
                assert!((d - m).abs() < 1e-7, "eta {eta} cos {c}: dielectric {d}, conductor {m}");
            }
        }
    }

    #[test]
    fn the_conductor_average_is_within_its_stated_error() {
        let mut worst = (0.0, 0.0, 0.0);
        for i in 1..=80 {
            for j in 10..=80 {
                let (eta, k) = (0.05 * i as f64, 0.1 * j as f64);
                let n = 400;
                let f = |m: f64| conductor_channel(m, eta, k);
                let sum = (0..n).map(|s| (s as f64 + 0.5) / n as f64).map(|m| 2.0 * f(m) * m / n as f64);
                let exact: f64 = sum.sum();
                let error = (conductor_average(DVec3::splat(eta), DVec3::splat(k)).x - exact).abs();
                if error > worst.0 {
                    worst = (error, eta, k);
                }
            }
        }
        println!("conductor average: worst error {:.4} at eta {:.2} k {:.2}", worst.0, worst.1, worst.2);
        assert!(worst.0 < 0.05, "worst error {worst:?}");
    }
}
