//! `copies` and `copies_file` of shapes and models: the same thing in many places.
//!
//! A copy's transform comes after the shape's or model's own. Meshes are shared, so that a million copies are a million transforms and
//! one mesh; what the renderer makes of that stands in `prepare::instances`.

use glam::{DAffine3, DMat3, DVec3};

use super::table::Table;
use super::transform::{is_invertible, placed_by, transform};
use super::{Builder, keys};
use crate::scene::Error;

/// Why a placement does not do.
pub type Check<'c> = &'c dyn Fn(&DAffine3) -> Result<(), &'static str>;

impl<'a> Builder<'a> {
    /// One transform a copy; the identity alone when the table asks for none. Errors, those of `check` too, name the copy or the line.
    pub fn copies(&self, table: &Table<'a>, check: Check<'_>) -> Result<Vec<DAffine3>, Error> {
        match (table.get("copies").is_some(), table.text("copies_file")?) {
            (false, None) => Ok(vec![DAffine3::IDENTITY]),
            (true, Some(_)) => Err(table.error("copies_file", "stands beside `copies`; keep one of the two")),
            (true, None) => {
                let items = table.tables("copies")?;
                if items.is_empty() {
                    return Err(
                        table.error("copies", "holds no copy; write { translate = [x, y, z] }, or leave it out")
                    );
                }
                let copy = |item| {
                    let copy = Table::open(self.source, item, &[&keys::COPY], &[])?;
                    let to_world = transform(&copy)?;
                    check(&to_world).map_err(|reason| copy.error(placed_by(&copy), reason))?;
                    Ok(to_world)
                };
                items.into_iter().map(copy).collect()
            }
            (false, Some(file)) => {
                let unusable = |reason: String| table.error("copies_file", format!("cannot be used: {reason}"));
                let path = self.path(table, "copies_file", file)?;
                let bytes = crate::scene::format::read_bytes(&path).map_err(|e| unusable(e.to_string()))?;
                let text = std::str::from_utf8(&bytes)
                    .map_err(|e| unusable(format!("byte {} of {file} is no UTF-8 text", e.valid_up_to())))?;
                parse(text, check).map_err(|(line, reason)| unusable(format!("{file} line {line} {reason}")))
            }
        }
    }
}

/// Lines of 12 numbers: the upper three rows of the matrix. Empty lines and those that begin with # are passed over.
fn parse(text: &str, check: Check<'_>) -> Result<Vec<DAffine3>, (usize, String)> {
    let mut copies = Vec::new();
    for (number, line) in (1..).zip(text.lines()) {
        let line = line.trim();
        if line.is_empty() || line.starts_with('#') {
            continue;
        }
        let fail = |reason: String| Err((number, reason));
        let mut m = [0.0; 12];
        let mut count = 0;
        for word in line.split(|c: char| c == ',' || c.is_whitespace()).filter(|w| !w.is_empty()) {
            match word.parse::<f64>() {
                Ok(x) if x.is_finite() => {
                    if count < 12 {
                        m[count] = x;
                    }
                    count += 1;
                }
                _ => return fail(format!("has \"{word}\" where a finite number should stand")),
            }
        }
        if count != 12 {
            return fail(format!("has {count} numbers; write 12, three rows of a matrix of four columns"));
        }
        let column = |c: usize| DVec3::new(m[c], m[c + 4], m[c + 8]);
        let copy = DAffine3 { matrix3: DMat3::from_cols(column(0), column(1), column(2)), translation: column(3) };
        if !is_invertible(&copy.matrix3) {
            return fail("has no inverse (an axis has length 0, or two fall together); make it invertible".to_owned());
        }
        if let Err(reason) = check(&copy) {
            return fail(reason.to_owned());
        }
        copies.push(copy);
    }
    if copies.is_empty() {
        return Err((1, "and all others hold no copy; write 12 numbers a line".to_owned()));
    }
    Ok(copies)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_are_matrices_and_bad_ones_are_named() {
        let good = "# x y z t\n1 0 0 5, 0 2 0 6, 0 0 -3 7\n\n0 1 0 0 1 0 0 0 0 0 1 0\n";
        let copies = parse(good, &|_| Ok(())).unwrap();
        assert_eq!(copies.len(), 2);
        assert_eq!(copies[0].transform_point3(DVec3::ONE), DVec3::new(6.0, 8.0, 4.0));
        let reason = |text: &str| parse(text, &|_| Ok(())).unwrap_err();
        assert_eq!(reason("1 0 0 5 0 2 0 6 0 0 -3 7\n1 2 3").0, 2);
        assert!(reason("1 2 3").1.contains("has 3 numbers"));
        assert!(reason("nan 0 0 5 0 2 0 6 0 0 -3 7").1.contains("\"nan\""));
        assert!(reason("1 0 0 5 0 0 0 6 0 0 1 7").1.contains("no inverse"));
        assert!(reason("# none").1.contains("no copy"));
    }
}
