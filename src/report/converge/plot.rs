//! The study's plots as SVG text: error against seconds and samples, log-log with a guide of slope -1; FLIP; time to a quality.

use plotters::coord::Shift;
use plotters::prelude::*;

use super::curves::{Point, Summary};

const SIZE: (u32, u32) = (760, 460);
/// Colour-blind safe (Okabe and Ito 2008).
const COLORS: [RGBColor; 7] = [
    RGBColor(0, 114, 178),
    RGBColor(213, 94, 0),
    RGBColor(0, 158, 115),
    RGBColor(204, 121, 167),
    RGBColor(230, 159, 0),
    RGBColor(86, 180, 233),
    RGBColor(0, 0, 0),
];

type Failure = Box<dyn std::error::Error + Send + Sync>;

/// One value of a point with its band.
pub struct Axis {
    pub title: &'static str,
    pub of: fn(&Point) -> [f64; 3],
}

pub const RELMSE: Axis = Axis { title: "relMSE", of: |p| [p.relmse, p.relmse_low, p.relmse_high] };
pub const FLIP: Axis = Axis { title: "mean FLIP", of: |p| [p.flip, p.flip_low, p.flip_high] };
pub const SECONDS: (&str, fn(&Point) -> f64) = ("seconds, set-up included", |p| p.seconds);
pub const SPP: (&str, fn(&Point) -> f64) = ("samples a pixel", |p| p.spp);

pub fn color_of(variant: usize) -> RGBColor {
    COLORS[variant % COLORS.len()]
}

/// Median lines with bands from the least to the largest replicate. None where there is nothing above 0 to draw.
pub fn curves(
    title: &str,
    summaries: &[Summary],
    x: (&str, fn(&Point) -> f64),
    y: &Axis,
) -> Result<Option<String>, Failure> {
    let points = || summaries.iter().flat_map(|s| &s.curve);
    let positive = |values: &mut dyn Iterator<Item = f64>| {
        let kept: Vec<f64> = values.filter(|v| v.is_finite() && *v > 0.0).collect();
        let low = kept.iter().copied().fold(f64::INFINITY, f64::min);
        let high = kept.iter().copied().fold(0.0, f64::max);
        (low <= high && high > 0.0).then_some((low / 1.3, high * 1.3))
    };
    let xs = positive(&mut points().map(x.1));
    let ys = positive(&mut points().flat_map(|p| (y.of)(p)));
    let (Some(xs), Some(ys)) = (xs, ys) else { return Ok(None) };
    let mut text = String::new();
    {
        let root = SVGBackend::with_string(&mut text, SIZE).into_drawing_area();
        root.fill(&WHITE)?;
        let mut chart = ChartBuilder::on(&root)
            .caption(title, ("sans-serif", 17))
            .margin(12)
            .x_label_area_size(42)
            .y_label_area_size(72)
            .build_cartesian_2d((xs.0..xs.1).log_scale(), (ys.0..ys.1).log_scale())?;
        chart
            .configure_mesh()
            .x_desc(x.0)
            .y_desc(y.title)
            .x_label_formatter(&|v| short(*v))
            .y_label_formatter(&|v| short(*v))
            .light_line_style(RGBColor(238, 238, 238))
            .draw()?;
        for (i, s) in summaries.iter().enumerate() {
            let color = color_of(i);
            let line: Vec<(f64, [f64; 3])> =
                s.curve.iter().map(|p| ((x.1)(p), (y.of)(p))).filter(|p| p.1[0] > 0.0).collect();
            let floor = |v: f64| v.max(ys.0);
            let upper = line.iter().map(|p| (p.0, floor(p.1[2])));
            let lower = line.iter().rev().map(|p| (p.0, floor(p.1[1])));
            chart
                .draw_series(std::iter::once(Polygon::new(upper.chain(lower).collect::<Vec<_>>(), color.mix(0.15))))?;
            chart
                .draw_series(LineSeries::new(line.iter().map(|p| (p.0, floor(p.1[0]))), color.stroke_width(2)))?
                .label(&s.variant)
                .legend(move |(x, y)| PathElement::new([(x, y), (x + 18, y)], color.stroke_width(2)));
            chart.draw_series(line.iter().map(|p| Circle::new((p.0, floor(p.1[0])), 3, color.filled())))?;
        }
        if let Some(guide) = guide(summaries, x.1, y, ys) {
            let gray = RGBColor(130, 130, 130);
            chart
                .draw_series(LineSeries::new(guide, gray.stroke_width(1)))?
                .label("slope -1")
                .legend(move |(x, y)| PathElement::new([(x, y), (x + 18, y)], gray));
        }
        chart
            .configure_series_labels()
            .border_style(RGBColor(200, 200, 200))
            .background_style(WHITE.mix(0.8))
            .draw()?;
        root.present()?;
    }
    Ok(Some(text))
}

/// A line of slope -1 from the first curve's first point, inside the plot. FLIP has no such law.
fn guide(summaries: &[Summary], x: fn(&Point) -> f64, y: &Axis, ys: (f64, f64)) -> Option<[(f64, f64); 2]> {
    let curve = &summaries.first()?.curve;
    let (first, last) = (curve.first()?, curve.last()?);
    if y.title != RELMSE.title || x(last) <= x(first) {
        return None;
    }
    let top = (y.of)(first)[0];
    let end = x(last).min(x(first) * top / ys.0);
    Some([(x(first), top), (end, top * x(first) / end)])
}

/// Seconds to each relMSE as bars, log scale; lighter where extrapolated.
pub fn qualities(title: &str, summaries: &[Summary]) -> Result<Option<String>, Failure> {
    let all = || summaries.iter().flat_map(|s| &s.qualities);
    let low = all().map(|q| q.seconds).fold(f64::INFINITY, f64::min) / 2.0;
    let high = all().map(|q| q.seconds).fold(0.0, f64::max) * 1.5;
    if !(low.is_finite() && high > low) {
        return Ok(None);
    }
    let mut wanted: Vec<f64> = all().map(|q| q.relmse).collect();
    wanted.sort_by(|a, b| b.total_cmp(a));
    wanted.dedup();
    let mut text = String::new();
    {
        let root: DrawingArea<SVGBackend, Shift> = SVGBackend::with_string(&mut text, SIZE).into_drawing_area();
        root.fill(&WHITE)?;
        let names: Vec<String> = wanted.iter().map(|w| format!("relMSE {}", short(*w))).collect();
        let mut chart = ChartBuilder::on(&root)
            .caption(title, ("sans-serif", 17))
            .margin(12)
            .x_label_area_size(42)
            .y_label_area_size(72)
            .build_cartesian_2d(0.0..wanted.len() as f64, (low..high).log_scale())?;
        chart
            .configure_mesh()
            .disable_x_mesh()
            .x_labels(wanted.len() * 2 + 1)
            .x_label_formatter(&|v| {
                let at = v.floor();
                if (v - at - 0.5).abs() < 0.01 {
                    names.get(at as usize).cloned().unwrap_or_default()
                } else {
                    String::new()
                }
            })
            .y_desc("seconds, set-up included")
            .y_label_formatter(&|v| short(*v))
            .draw()?;
        let width = 0.8 / summaries.len() as f64;
        for (i, s) in summaries.iter().enumerate() {
            let color = color_of(i);
            let bar = |q: &super::curves::Quality| {
                let group = wanted.iter().position(|w| *w == q.relmse).unwrap_or(0) as f64;
                let left = group + 0.1 + width * i as f64;
                let style = if q.is_extrapolated { color.mix(0.35).filled() } else { color.filled() };
                Rectangle::new([(left, low), (left + 0.92 * width, q.seconds)], style)
            };
            chart
                .draw_series(s.qualities.iter().map(bar))?
                .label(&s.variant)
                .legend(move |(x, y)| Rectangle::new([(x, y - 5), (x + 12, y + 5)], color.filled()));
        }
        chart
            .configure_series_labels()
            .position(SeriesLabelPosition::UpperLeft)
            .border_style(RGBColor(200, 200, 200))
            .background_style(WHITE.mix(0.8))
            .draw()?;
        root.present()?;
    }
    Ok(Some(text))
}

/// 0.001, 3, 1e6.
fn short(v: f64) -> String {
    if (1e-3..1e5).contains(&v) { format!("{}", (v * 1e6).round() / 1e6) } else { format!("{v:.0e}") }
}
