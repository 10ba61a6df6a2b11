//! The study as a table of Markdown: what a README shows below the plot.

use std::fmt::Write as _;

use super::curves::{Interval, Summary};

/// The quality whose time the table tells.
const QUALITY: f64 = 1e-2;

/// One row a scene and variant.
pub fn markdown(scenes: &[(String, Vec<Summary>)]) -> String {
    let mut text = String::from(
        "| scene | variant | spp at the end | relMSE at the end, median [least, largest] | FLIP | s to relMSE 0.01 | exponent in spp | bias² | own estimate / error |\n\
         |---|---|---|---|---|---|---|---|---|\n",
    );
    let with = |i: Option<Interval>, f: &dyn Fn(f64) -> String| {
        i.map_or("-".to_owned(), |i| format!("{} [{}, {}]", f(i.value), f(i.low), f(i.high)))
    };
    for (scene, summaries) in scenes {
        for s in summaries {
            let end = &s.at_budget;
            let time = s.qualities.iter().find(|q| q.relmse == QUALITY);
            let time =
                time.map_or("-".into(), |q| format!("{}{:.2}", if q.is_extrapolated { "~" } else { "" }, q.seconds));
            let figures = format!("{:.2e} [{:.2e}, {:.2e}]", end.relmse, end.relmse_low, end.relmse_high);
            let relmse = end.relmse_words(figures);
            let _ = writeln!(
                text,
                "| {scene} | {} | {} | {relmse} | {:.4} | {time} | {} | {} | {} |",
                s.variant,
                end.spp,
                end.flip,
                with(s.exponent, &|v| format!("{v:.2}")),
                with(s.bias_squared, &|v| format!("{v:.0e}")),
                s.estimate_ratio.map_or("-".into(), |v| format!("{v:.2}")),
            );
        }
    }
    text
}
