//! Profiles of turned things: pieces of smooth curve in the half plane (radius, height), joined at sharp edges.
//!
//! Points go with the outside on their right: up along an outer wall, down along an inner one. A piece is a centripetal
//! Catmull-Rom curve (Catmull and Rom 1974; Barry and Goldman 1988; Yuksel 2011) through its points.

use glam::DVec2;

/// A point of a profile with its outward normal and its place along the whole, 0 to 1.
#[derive(Clone, Copy, Debug)]
pub struct Point {
    pub position: DVec2,
    pub normal: DVec2,
    pub v: f64,
}

#[derive(Default)]
pub struct Profile {
    pieces: Vec<Vec<(DVec2, DVec2)>>,
}

impl Profile {
    pub fn new() -> Self {
        Self::default()
    }

    /// A smooth piece through (radius, height) `points`, `steps` vertices a span.
    pub fn curve(mut self, points: &[(f64, f64)], steps: usize) -> Self {
        let p: Vec<DVec2> = points.iter().map(|&(r, y)| DVec2::new(r, y)).collect();
        let last = p.len() - 1;
        let at = |i: isize| match i {
            // Ends are mirrored, which gives a natural first and last tangent.
            i if i < 0 => 2.0 * p[0] - p[1],
            i if i as usize > last => 2.0 * p[last] - p[last - 1],
            i => p[i as usize],
        };
        let mut piece: Vec<DVec2> = Vec::new();
        for span in 0..last as isize {
            let corners = [at(span - 1), at(span), at(span + 1), at(span + 2)];
            piece.extend((0..steps).map(|k| catmull_rom(corners, k as f64 / steps as f64)));
        }
        piece.push(p[last]);
        // On the axis a turned curve is flat or a tip; mirrored neighbours make its normal vertical.
        let tangent = |i: usize| {
            let before = if i == 0 { mirrored_start(&piece) } else { piece[i - 1] };
            let after = if i + 1 == piece.len() { mirrored_end(&piece) } else { piece[i + 1] };
            (after - before).normalize_or(DVec2::X)
        };
        self.pieces.push((0..piece.len()).map(|i| (piece[i], tangent(i).perp() * -1.0)).collect());
        self
    }

    /// A straight piece.
    pub fn line(self, from: (f64, f64), to: (f64, f64)) -> Self {
        self.curve(&[from, to], 1)
    }

    pub fn pieces(&self) -> Vec<Vec<Point>> {
        let length = |piece: &Vec<(DVec2, DVec2)>| -> f64 { piece.windows(2).map(|w| w[0].0.distance(w[1].0)).sum() };
        let total: f64 = self.pieces.iter().map(length).sum();
        let mut gone = 0.0;
        let mut pieces = Vec::new();
        for piece in &self.pieces {
            let mut points: Vec<Point> = Vec::new();
            for (i, &(position, normal)) in piece.iter().enumerate() {
                gone += if i == 0 { 0.0 } else { position.distance(piece[i - 1].0) };
                points.push(Point { position, normal, v: gone / total });
            }
            pieces.push(points);
        }
        pieces
    }
}

fn mirrored_start(piece: &[DVec2]) -> DVec2 {
    if piece[0].x == 0.0 && piece.len() > 2 { DVec2::new(-piece[1].x, piece[1].y) } else { 2.0 * piece[0] - piece[1] }
}

fn mirrored_end(piece: &[DVec2]) -> DVec2 {
    let (last, before) = (piece[piece.len() - 1], piece[piece.len() - 2]);
    if last.x == 0.0 && piece.len() > 2 { DVec2::new(-before.x, before.y) } else { 2.0 * last - before }
}

/// Centripetal Catmull-Rom between p[1] and p[2] by the pyramid of Barry and Goldman.
fn catmull_rom(p: [DVec2; 4], t: f64) -> DVec2 {
    let mut knots = [0.0; 4];
    for i in 1..4 {
        knots[i] = knots[i - 1] + p[i].distance(p[i - 1]).sqrt().max(1e-9);
    }
    let t = knots[1] + t * (knots[2] - knots[1]);
    let mix = |a: DVec2, b: DVec2, from: usize, to: usize| a.lerp(b, (t - knots[from]) / (knots[to] - knots[from]));
    let a = [mix(p[0], p[1], 0, 1), mix(p[1], p[2], 1, 2), mix(p[2], p[3], 2, 3)];
    let b = [mix(a[0], a[1], 0, 2), mix(a[1], a[2], 1, 3)];
    mix(b[0], b[1], 1, 2)
}
