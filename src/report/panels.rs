//! Plots with logarithmic axes as SVG text: one panel or a grid of them, lines with bands, and what they were made by below.

use plotters::coord::Shift;
use plotters::prelude::*;

pub type Failure = Box<dyn std::error::Error + Send + Sync>;

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
const GRAY: RGBColor = RGBColor(130, 130, 130);
/// Height of a line below the plots, and least width of a plot that has some, pixels.
const FOOT: u32 = 14;
const FOOT_WIDTH: u32 = 760;

pub fn color_of(index: usize) -> RGBColor {
    COLORS[index % COLORS.len()]
}

pub struct Line {
    pub name: String,
    /// x, and y with the ends of its band; what is not above 0 is left out.
    pub points: Vec<(f64, [f64; 3])>,
    /// A tick at the lower edge, such as where set-up ends.
    pub mark: Option<f64>,
}

pub struct Panel {
    pub title: String,
    pub lines: Vec<Line>,
    /// Slope of a guide through the first point.
    pub guide: Option<f64>,
}

pub struct Frame<'a> {
    pub x: &'a str,
    pub y: &'a str,
    /// Of one panel.
    pub size: (u32, u32),
    pub columns: usize,
    /// Lines below the plots.
    pub foot: &'a [String],
}

/// None where no panel has anything above 0 to draw.
pub fn draw(panels: &[Panel], frame: &Frame) -> Result<Option<String>, Failure> {
    let drawn: Vec<&Panel> = panels.iter().filter(|p| ranges(p).is_some()).collect();
    if drawn.is_empty() {
        return Ok(None);
    }
    let columns = frame.columns.clamp(1, drawn.len());
    let rows = drawn.len().div_ceil(columns);
    // What stands below needs the width of two.
    let size = (frame.size.0 * columns as u32, frame.size.1 * rows as u32);
    let size = if frame.foot.is_empty() { size } else { (size.0.max(FOOT_WIDTH), size.1) };
    canvas(size, frame.foot, |root| {
        let names = |panel: &Panel| panel.lines.iter().map(|line| line.name.clone()).collect::<Vec<_>>();
        for (i, (cell, panel)) in root.split_evenly((rows, columns)).iter().zip(&drawn).enumerate() {
            draw_panel(cell, panel, frame, i == 0 || names(panel) != names(drawn[0]))?;
        }
        Ok(())
    })
    .map(Some)
}

/// An SVG of `size` and a foot.
pub fn canvas(
    size: (u32, u32),
    foot: &[String],
    paint: impl FnOnce(&DrawingArea<SVGBackend, Shift>) -> Result<(), Failure>,
) -> Result<String, Failure> {
    let mut text = String::new();
    {
        let whole = (size.0, size.1 + FOOT * foot.len() as u32 + if foot.is_empty() { 0 } else { 6 });
        let root = SVGBackend::with_string(&mut text, whole).into_drawing_area();
        root.fill(&WHITE)?;
        let (top, bottom) = root.split_vertically(size.1);
        paint(&top)?;
        for (i, line) in foot.iter().enumerate() {
            let style = ("sans-serif", 10).into_font().color(&GRAY);
            bottom.draw(&Text::new(line.as_str(), (12, (FOOT * i as u32) as i32), style))?;
        }
        root.present()?;
    }
    Ok(text)
}

fn draw_panel(
    area: &DrawingArea<SVGBackend, Shift>,
    panel: &Panel,
    frame: &Frame,
    has_legend: bool,
) -> Result<(), Failure> {
    let Some((xs, ys)) = ranges(panel) else { return Ok(()) };
    let mut chart = ChartBuilder::on(area)
        .caption(&panel.title, ("sans-serif", 16))
        .margin(10)
        .x_label_area_size(40)
        .y_label_area_size(64)
        .build_cartesian_2d((xs.0..xs.1).log_scale(), (ys.0..ys.1).log_scale())?;
    chart
        .configure_mesh()
        .x_desc(frame.x)
        .y_desc(frame.y)
        .x_label_formatter(&|v| short(*v))
        .y_label_formatter(&|v| short(*v))
        .light_line_style(RGBColor(238, 238, 238))
        .draw()?;
    let floor = |v: f64| v.max(ys.0);
    for (i, line) in panel.lines.iter().enumerate() {
        let color = color_of(i);
        let points: Vec<_> = line.points.iter().filter(|p| p.1[0] > 0.0).collect();
        let upper = points.iter().map(|p| (p.0, floor(p.1[2])));
        let lower = points.iter().rev().map(|p| (p.0, floor(p.1[1])));
        chart.draw_series(std::iter::once(Polygon::new(upper.chain(lower).collect::<Vec<_>>(), color.mix(0.15))))?;
        chart
            .draw_series(LineSeries::new(points.iter().map(|p| (p.0, floor(p.1[0]))), color.stroke_width(2)))?
            .label(&line.name)
            .legend(move |(x, y)| PathElement::new([(x, y), (x + 18, y)], color.stroke_width(2)));
        chart.draw_series(points.iter().map(|p| Circle::new((p.0, floor(p.1[0])), 2, color.filled())))?;
        if let Some(x) = line.mark {
            let top = ys.0 * (ys.1 / ys.0).powf(0.05);
            chart.draw_series(std::iter::once(PathElement::new([(x, ys.0), (x, top)], color.stroke_width(2))))?;
        }
    }
    if let Some(ends) = panel.guide.and_then(|slope| guide(panel, slope, ys)) {
        chart
            .draw_series(LineSeries::new(ends, GRAY.stroke_width(1)))?
            .label(format!("slope {}", panel.guide.unwrap_or_default()))
            .legend(|(x, y)| PathElement::new([(x, y), (x + 18, y)], GRAY));
    }
    if has_legend {
        // Errors fall: the lower left is empty, but for the ticks.
        chart
            .configure_series_labels()
            .position(SeriesLabelPosition::LowerLeft)
            .margin(14)
            .border_style(RGBColor(200, 200, 200))
            .background_style(WHITE.mix(0.8))
            .draw()?;
    }
    Ok(())
}

type Range = (f64, f64);

fn ranges(panel: &Panel) -> Option<(Range, Range)> {
    let of = |values: &mut dyn Iterator<Item = f64>| {
        let kept: Vec<f64> = values.filter(|v| v.is_finite() && *v > 0.0).collect();
        let low = kept.iter().copied().fold(f64::INFINITY, f64::min);
        let high = kept.iter().copied().fold(0.0, f64::max);
        (low <= high && high > 0.0).then_some((low / 1.3, high * 1.3))
    };
    let points = || panel.lines.iter().flat_map(|l| &l.points).filter(|p| p.1[0] > 0.0);
    let xs = of(&mut points().map(|p| p.0).chain(panel.lines.iter().filter_map(|l| l.mark)));
    let ys = of(&mut points().flat_map(|p| p.1));
    xs.zip(ys)
}

/// From the first line's first point, inside the plot.
fn guide(panel: &Panel, slope: f64, ys: Range) -> Option<[(f64, f64); 2]> {
    let points = &panel.lines.first()?.points;
    let (first, last) = (points.first()?, points.last()?);
    let top = first.1[0];
    if !(last.0 > first.0 && top > 0.0 && slope < 0.0) {
        return None;
    }
    let end = last.0.min(first.0 * (ys.0 / top).powf(1.0 / slope));
    Some([(first.0, top), (end, top * (end / first.0).powf(slope))])
}

/// 0.001, 3, 1e6.
pub fn short(v: f64) -> String {
    if (1e-3..1e5).contains(&v) { format!("{}", (v * 1e6).round() / 1e6) } else { format!("{v:.0e}") }
}
