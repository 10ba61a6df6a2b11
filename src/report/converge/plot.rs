//! The study's plots as SVG text: error against seconds and samples, log-log with a guide of slope -1; FLIP; time to a quality.

use plotters::prelude::*;

use super::curves::{Point, Quality, Summary};
use crate::report::panels::{self, Failure, Frame, Line, Panel, canvas, color_of, short};

const SIZE: (u32, u32) = (760, 460);
/// Of a panel of the overview.
const SMALL: (u32, u32) = (430, 330);
const COLUMNS: usize = 3;

/// One value of a point with its band.
pub struct Axis {
    pub title: &'static str,
    pub of: fn(&Point) -> [f64; 3],
    /// Slope of the guide; FLIP has no such law.
    pub slope: Option<f64>,
}

/// What curves run over.
pub struct Over {
    pub title: &'static str,
    pub of: fn(&Point) -> f64,
    /// Where a curve could begin at the earliest.
    pub from: fn(&Summary) -> Option<f64>,
}

pub const RELMSE: Axis = Axis { title: "relMSE", of: |p| [p.relmse, p.relmse_low, p.relmse_high], slope: Some(-1.0) };
pub const FLIP: Axis = Axis { title: "mean FLIP", of: |p| [p.flip, p.flip_low, p.flip_high], slope: None };
pub const SECONDS: Over =
    Over { title: "seconds; ticks: set-up ends", of: |p| p.seconds, from: |s| Some(s.setup_s).filter(|t| *t > 0.0) };
pub const SPP: Over = Over { title: "samples a pixel", of: |p| p.spp, from: |_| None };

fn panel(title: &str, summaries: &[Summary], x: &Over, y: &Axis) -> Panel {
    let line = |s: &Summary| Line {
        name: s.variant.clone(),
        points: s.curve.iter().map(|p| ((x.of)(p), (y.of)(p))).collect(),
        mark: (x.from)(s),
    };
    Panel { title: title.to_owned(), lines: summaries.iter().map(line).collect(), guide: y.slope }
}

/// Median lines with bands from the least to the largest replicate. None where there is nothing above 0 to draw.
pub fn curves(
    title: &str,
    summaries: &[Summary],
    x: &Over,
    y: &Axis,
    foot: &[String],
) -> Result<Option<String>, Failure> {
    let frame = Frame { x: x.title, y: y.title, size: SIZE, columns: 1, foot };
    panels::draw(&[panel(title, summaries, x, y)], &frame)
}

/// Error against time, a panel a scene.
pub fn overview(scenes: &[(String, Vec<Summary>)], foot: &[String]) -> Result<Option<String>, Failure> {
    let all: Vec<Panel> = scenes.iter().map(|(name, s)| panel(name, s, &SECONDS, &RELMSE)).collect();
    panels::draw(&all, &Frame { x: SECONDS.title, y: RELMSE.title, size: SMALL, columns: COLUMNS, foot })
}

/// Seconds to each relMSE as bars, log scale; lighter where extrapolated.
pub fn qualities(title: &str, summaries: &[Summary], foot: &[String]) -> Result<Option<String>, Failure> {
    let all = || summaries.iter().flat_map(|s| &s.qualities);
    let low = all().map(|q| q.seconds).fold(f64::INFINITY, f64::min) / 2.0;
    let high = all().map(|q| q.seconds).fold(0.0, f64::max) * 1.5;
    if !(low.is_finite() && high > low) {
        return Ok(None);
    }
    let mut wanted: Vec<f64> = all().map(|q| q.relmse).collect();
    wanted.sort_by(|a, b| b.total_cmp(a));
    wanted.dedup();
    let names: Vec<String> = wanted.iter().map(|w| format!("relMSE {}", short(*w))).collect();
    canvas(SIZE, foot, |root| {
        let mut chart = ChartBuilder::on(root)
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
            let bar = |q: &Quality| {
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
        Ok(())
    })
    .map(Some)
}
