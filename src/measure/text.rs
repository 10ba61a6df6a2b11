//! Readings as a table for people.

use super::Reading;

/// One line a reading under a line of headings; columns as wide as they need to be.
pub fn table(readings: &[Reading]) -> String {
    let head = ["sensor", "quantity", "R", "G", "B", "unit", "luminous", "unit"].map(str::to_owned);
    let mut rows = vec![head];
    rows.extend(readings.iter().map(|r| {
        let [red, green, blue] = [0, 1, 2].map(|c| with_interval(r.value[c], r.half_width[c]));
        let luminous = with_interval(r.luminous, r.luminous_half_width);
        let (unit, luminous_unit) = (r.unit.to_owned(), r.luminous_unit.to_owned());
        [r.name.clone(), r.quantity.to_owned(), red, green, blue, unit, luminous, luminous_unit]
    }));
    let width = |column: usize| rows.iter().map(|r| r[column].chars().count()).max().unwrap_or(0);
    let widths: Vec<usize> = (0..8).map(width).collect();
    let line = |row: &[String; 8]| {
        let cells: Vec<String> = row.iter().zip(&widths).map(|(cell, &w)| format!("{cell:<w$}")).collect();
        cells.join("  ").trim_end().to_owned() + "\n"
    };
    rows.iter().map(line).collect()
}

/// `3.14159 ± 0.00012`: two digits of the half width, and the value to the same place.
fn with_interval(value: f64, half_width: f64) -> String {
    if !(value.is_finite() && half_width.is_finite()) {
        return format!("{value} ± {half_width}");
    }
    if half_width == 0.0 {
        return format!("{value} ± 0");
    }
    // The place of the second digit of the half width, after it is rounded to two.
    let exponent = format!("{half_width:.1e}").split_once('e').and_then(|(_, e)| e.parse::<i32>().ok()).unwrap_or(0);
    if (-9..=6).contains(&exponent) {
        let places = (1 - exponent).max(0) as usize;
        format!("{value:.places$} ± {half_width:.places$}")
    } else {
        let digits = (value.abs().max(half_width).log10().floor() as i32 - exponent + 1).clamp(1, 15) as usize;
        format!("{value:.digits$e} ± {half_width:.1e}")
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use super::*;

    #[test]
    fn values_end_where_their_interval_does() {
        for (value, half_width, text) in [
            (PI, 0.000123, "3.14159 ± 0.00012"),
            (PI, 0.000996, "3.1416 ± 0.0010"),
            (63.66198, 1.2, "63.7 ± 1.2"),
            (12345.678, 321.0, "12346 ± 321"),
            (0.0, 0.0, "0 ± 0"),
            (1.5e-12, 2.0e-14, "1.500e-12 ± 2.0e-14"),
            (f64::NAN, 1.0, "NaN ± 1"),
        ] {
            assert_eq!(with_interval(value, half_width), text);
        }
    }
}
