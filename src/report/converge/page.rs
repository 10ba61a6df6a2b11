//! The study's folder: `runs.csv`, `summary.json`, `table.md`, SVGs with one of all scenes (`overview.svg`), equal-time strips, and
//! `index.html`, which holds all of it and needs no network. Each figure carries what it was made by.

use std::fmt::Write as _;
use std::path::Path;

use base64::Engine;
use base64::prelude::BASE64_STANDARD;
use serde::Serialize;

use super::curves::{self, Interval, Summary};
use super::{Study, plot, table};
use crate::error::Error;
use crate::film::source::DeviceInfo;
use crate::metric::{error, flip};
use crate::output::image::{self, Picture};
use crate::output::write_atomically;
pub use crate::report::provenance::Provenance;
use crate::report::sheet;

#[derive(Serialize)]
struct SceneSummary<'a> {
    scene: &'a str,
    width: u32,
    height: u32,
    budget_s: f64,
    reference: &'a str,
    reference_spp: Option<u64>,
    /// Expected relMSE of the reference itself, subtracted from every figure.
    reference_noise: Option<f64>,
    warnings: Vec<String>,
    variants: Vec<Summary>,
}

/// Writes the folder of `studies`; it exists.
pub fn write(folder: &Path, studies: &[Study], provenance: &Provenance) -> Result<(), Error> {
    let mut page = head(provenance);
    let mut scenes = Vec::new();
    let mut all = Vec::new();
    for study in studies {
        let summaries = curves::summaries(study);
        let warnings = warnings(study, &summaries);
        let foot = provenance.lines(&device_of(&summaries), &seeds_of(&summaries), "runs.csv");
        scene_part(folder, &mut page, study, &summaries, &warnings, &foot)?;
        all.push((study.scene.clone(), summaries.clone()));
        scenes.push(SceneSummary {
            scene: &study.scene,
            width: study.reference.picture.width,
            height: study.reference.picture.height,
            budget_s: study.plan.budget_s,
            reference: &study.reference.source,
            reference_spp: study.reference.spp,
            reference_noise: study.reference.noise,
            warnings,
            variants: summaries,
        });
    }
    page += "</main></body></html>\n";
    let at = |name: &str| folder.join(name);
    let every: Vec<Summary> = all.iter().flat_map(|(_, s)| s.iter().cloned()).collect();
    let (device, seeds) = (device_of(&every), seeds_of(&every));
    let drawn = plot::overview(&all, &provenance.lines(&device, &seeds, "runs.csv"));
    if let Some(svg) = drawn.map_err(|e| Error::file(at("overview.svg"), format!("cannot draw the plot: {e}")))? {
        write_atomically(&at("overview.svg"), svg.as_bytes())?;
    }
    let text = table::markdown(&all) + "\n" + &provenance.markdown(&device, &seeds, "runs.csv");
    write_atomically(&at("table.md"), text.as_bytes())?;
    write_atomically(&at("runs.csv"), csv(studies).as_bytes())?;
    let json = serde_json::json!({ "provenance": provenance, "scenes": scenes });
    let json = serde_json::to_string_pretty(&json).map_err(|e| Error::file(at("summary.json"), e.to_string()))?;
    write_atomically(&at("summary.json"), (json + "\n").as_bytes())?;
    write_atomically(&at("index.html"), page.as_bytes())
}

/// Of the first variant; others may name their own (`device=`), which summary.json tells.
fn device_of(summaries: &[Summary]) -> DeviceInfo {
    summaries.first().map_or(DeviceInfo::default(), |s| DeviceInfo {
        name: s.device.clone(),
        driver: s.driver.clone(),
        ..DeviceInfo::default()
    })
}

/// "1 to 5": replicates count up.
fn seeds_of(summaries: &[Summary]) -> String {
    let seeds = || summaries.iter().flat_map(|s| s.seeds.iter().copied());
    match (seeds().min(), seeds().max()) {
        (Some(low), Some(high)) if low < high => format!("{low} to {high}"),
        (Some(low), _) => low.to_string(),
        _ => "none".into(),
    }
}

/// One line a snapshot.
pub fn csv(studies: &[Study]) -> String {
    let mut text = String::from(
        "scene,variant,repeat,seed,spp,seconds,setup_s,relmse,relmse_exposure,relmse_trimmed,rmse,bias,flip,flip_hdr,\
         relmse_est,relmse_est_low,relmse_est_high,reference_noise\n",
    );
    for study in studies {
        let noise = study.reference.noise.map_or(String::new(), |n| format!("{n:.6e}"));
        for run in &study.runs {
            for s in &run.snapshots {
                let e = &s.errors;
                let estimate = s.estimate.map_or(",,".to_owned(), |f| {
                    format!("{:.6e},{:.6e},{:.6e}", f.relmse.value, f.relmse.low, f.relmse.high)
                });
                let _ = writeln!(
                    text,
                    "{},{},{},{},{},{:.4},{:.4},{:.6e},{:.6e},{:.6e},{:.6e},{:.6e},{:.6},{:.6},{estimate},{noise}",
                    study.scene,
                    study.plan.variants[run.variant].name,
                    run.repeat,
                    run.seed,
                    s.spp,
                    s.seconds,
                    run.setup_s,
                    e.relmse,
                    e.relmse_exposure,
                    e.relmse_trimmed,
                    e.rmse,
                    e.bias,
                    e.flip,
                    e.flip_hdr,
                );
            }
        }
    }
    text
}

/// What a reader must know before believing the figures.
fn warnings(study: &Study, summaries: &[Summary]) -> Vec<String> {
    let mut list = Vec::new();
    match study.reference.noise {
        None => list.push("the reference's own noise is not known and is part of every error".to_owned()),
        Some(noise) => {
            for s in summaries.iter().filter(|s| noise > 0.1 * s.at_budget.relmse) {
                list.push(format!(
                    "{}: the reference's noise ({noise:.1e}) is more than a tenth of the error at the end ({:.1e}): its curve \
                     bottoms out there; take a reference of more samples",
                    s.variant, s.at_budget.relmse
                ));
            }
        }
    }
    let longest = summaries.iter().map(|s| s.at_budget.spp).fold(0.0, f64::max);
    if let Some(spp) = study.reference.spp
        && (spp as f64) < super::reference::FACTOR * longest
    {
        list.push(format!(
            "the reference has {spp} spp, less than {} times the longest run's {longest}",
            super::reference::FACTOR
        ));
    }
    for s in summaries.iter().filter(|s| s.repeats < study.plan.repeats as usize) {
        list.push(format!("{}: {} of {} replicates were finished", s.variant, s.repeats, study.plan.repeats));
    }
    list
}

fn head(p: &Provenance) -> String {
    format!(
        "<!doctype html><html lang=\"en\"><head><meta charset=\"utf-8\"><meta name=\"viewport\" content=\"width=device-width\">\
         <title>error against run time</title><style>\
         body{{font:15px/1.5 sans-serif;color:#222;margin:0}}main{{max-width:1600px;margin:auto;padding:1em}}\
         table{{border-collapse:collapse;margin:1em 0}}td,th{{border:1px solid #ccc;padding:.25em .6em;text-align:right}}\
         td:first-child,th:first-child{{text-align:left}}.plots{{display:flex;flex-wrap:wrap;gap:1em}}\
         .plots svg{{max-width:100%;height:auto;border:1px solid #eee}}.strip{{display:flex;flex-wrap:wrap;gap:1em}}\
         figure{{margin:0}}figcaption{{font-size:13px;max-width:260px}}img{{width:260px;image-rendering:pixelated;display:block}}\
         .warn{{color:#a33}}.small{{font-size:12px;color:#666;margin:0}}code{{background:#f3f3f3;padding:.1em .3em}}</style></head><body><main>\
         <h1>Error against run time</h1><p>Made by <code>{}</code><br>{} {} on {}, {}.</p>\
         <p>relMSE = mean of (x-r)&sup2;/(r&sup2;+0.01), the reference's own noise subtracted. Lines are medians over the \
         replicates, bands run from the least to the largest. The clock begins with the set-up and stops while an image is \
         judged.</p>\n",
        escape(&p.command),
        escape(&p.program),
        escape(&p.commit),
        escape(&p.machine),
        escape(&p.date)
    )
}

fn scene_part(
    folder: &Path,
    page: &mut String,
    study: &Study,
    summaries: &[Summary],
    warnings: &[String],
    foot: &[String],
) -> Result<(), Error> {
    let scene = &study.scene;
    let r = &study.reference;
    let _ = write!(
        page,
        "<h2>{}</h2><p>{}x{}, {} s a run, {} replicates. Reference: {}, {} spp, own relMSE {}.</p>",
        escape(scene),
        r.picture.width,
        r.picture.height,
        study.plan.budget_s,
        study.plan.repeats,
        escape(&r.source),
        r.spp.map_or("unknown".into(), |s| s.to_string()),
        r.noise.map_or("unknown".into(), |n| format!("{n:.1e}"))
    );
    for s in summaries {
        let _ = write!(
            page,
            "<p class=\"small\">{}: {}, {}, kernel {}, seeds {:?}</p>",
            escape(&s.variant),
            escape(&s.device),
            escape(&s.driver),
            s.kernel_hash.get(..12).unwrap_or("of the CPU"),
            s.seeds
        );
    }
    for warning in warnings {
        let _ = write!(page, "<p class=\"warn\">{}</p>", escape(warning));
    }
    *page += &table(summaries);
    *page += "<div class=\"plots\">";
    let drawn = [
        (
            "relmse-seconds",
            plot::curves(&format!("{scene}: error against time"), summaries, &plot::SECONDS, &plot::RELMSE, foot),
        ),
        (
            "relmse-spp",
            plot::curves(&format!("{scene}: error against samples"), summaries, &plot::SPP, &plot::RELMSE, foot),
        ),
        (
            "flip-seconds",
            plot::curves(&format!("{scene}: FLIP against time"), summaries, &plot::SECONDS, &plot::FLIP, foot),
        ),
        ("time-to-quality", plot::qualities(&format!("{scene}: time to a quality"), summaries, foot)),
    ];
    for (name, svg) in drawn {
        let path = folder.join(format!("{scene}-{name}.svg"));
        if let Some(svg) = svg.map_err(|e| Error::file(&path, format!("cannot draw the plot: {e}")))? {
            write_atomically(&path, svg.as_bytes())?;
            *page += &svg;
        }
    }
    *page += "</div><h3>Equal time</h3><div class=\"strip\">";
    *page += &figure(&r.picture, "reference")?;
    for (i, s) in summaries.iter().enumerate() {
        let picture = &study.pictures[i];
        let end = &s.at_budget;
        let caption = format!(
            "{}: {} spp in {:.2} s, relMSE {:.2e}, FLIP {:.3}",
            s.variant, end.spp, end.seconds, end.relmse, end.flip
        );
        *page += &figure(picture, &caption)?;
        *page += &error_map(picture, &r.picture, &format!("{}: FLIP map", s.variant))?;
    }
    *page += "</div>\n";
    strip(folder, study, summaries.len())
}

/// `SCENE-equal-time.png`: the reference and each variant at the end of the budget, and below each its FLIP map.
fn strip(folder: &Path, study: &Study, count: usize) -> Result<(), Error> {
    let reference = &study.reference.picture;
    let size = reference.pixels.len();
    let ends: Vec<&Picture> = study.pictures.iter().take(count).filter(|p| p.pixels.len() == size).collect();
    let map = |picture: &&Picture| Picture {
        pixels: flip::ldr(&picture.pixels, &reference.pixels, reference.width as usize)
            .iter()
            .map(|e| error::map_color(*e).map(|byte| image::srgb_decode(f32::from(byte) / 255.0)))
            .collect(),
        ..**picture
    };
    let black = Picture { pixels: vec![[0.0; 3]; size], ..*reference };
    let cells: Vec<Picture> = std::iter::once(reference.clone())
        .chain(ends.iter().map(|p| (*p).clone()))
        .chain(std::iter::once(black))
        .chain(ends.iter().map(map))
        .collect();
    let (width, height, bytes) = sheet::lay_out(&cells, 1 + ends.len());
    let path = folder.join(format!("{}-equal-time.png", study.scene));
    write_atomically(&path, &image::png_bytes(width, height, &bytes)?)
}

fn table(summaries: &[Summary]) -> String {
    let with = |i: Option<Interval>, f: &dyn Fn(f64) -> String| {
        i.map_or("-".to_owned(), |i| format!("{} [{}, {}]", f(i.value), f(i.low), f(i.high)))
    };
    let mut text = String::from(
        "<table><tr><th>variant</th><th>set-up s</th><th>Msamples/s</th><th>spp at the end</th><th>relMSE at the end</th>\
         <th>FLIP</th><th>exponent in spp</th><th>own estimate / error</th><th>bias&sup2; (in relMSE)</th>\
         <th>variance</th><th>bias of the mean</th>",
    );
    for q in curves::QUALITIES {
        let _ = write!(text, "<th>s to {q:.0e}</th>");
    }
    text += "</tr>";
    for s in summaries {
        let relmse = s.at_budget.relmse_words(format!("{:.2e}", s.at_budget.relmse));
        let _ = write!(
            text,
            "<tr><td>{}</td><td>{:.2}</td><td>{:.3}</td><td>{}</td><td>{relmse}</td><td>{:.4}</td><td>{}</td><td>{}</td><td>{}</td>\
             <td>{}</td><td>{}</td>",
            escape(&s.variant),
            s.setup_s,
            s.throughput_MSps,
            s.at_budget.spp,
            s.at_budget.flip,
            with(s.exponent, &|v| format!("{v:.2}")),
            s.estimate_ratio.map_or("-".into(), |v| format!("{v:.2}")),
            with(s.bias_squared, &|v| format!("{v:.1e}")),
            s.variance.map_or("-".into(), |v| format!("{v:.1e}")),
            with(s.mean_bias, &|v| format!("{:.3} %", 100.0 * v)),
        );
        for q in curves::QUALITIES {
            let found = s.qualities.iter().find(|x| x.relmse == q);
            let cell =
                found.map_or("-".into(), |x| format!("{}{:.2}", if x.is_extrapolated { "~" } else { "" }, x.seconds));
            let _ = write!(text, "<td>{cell}</td>");
        }
        text += "</tr>";
    }
    text + "</table><p>~: beyond the last snapshot, by the fitted exponent.</p>"
}

fn figure(picture: &Picture, caption: &str) -> Result<String, Error> {
    let bytes: Vec<u8> =
        picture.pixels.iter().flatten().map(|&v| (image::srgb_encode(v) * 255.0 + 0.5) as u8).collect();
    embedded(picture.width, picture.height, &bytes, caption)
}

fn error_map(picture: &Picture, reference: &Picture, caption: &str) -> Result<String, Error> {
    if picture.pixels.len() != reference.pixels.len() || picture.pixels.is_empty() {
        return Ok(String::new());
    }
    let errors = flip::ldr(&picture.pixels, &reference.pixels, picture.width as usize);
    let bytes: Vec<u8> = errors.iter().flat_map(|e| error::map_color(*e)).collect();
    embedded(picture.width, picture.height, &bytes, caption)
}

fn embedded(width: u32, height: u32, bytes: &[u8], caption: &str) -> Result<String, Error> {
    if bytes.is_empty() {
        return Ok(String::new());
    }
    let png = image::png_bytes(width, height, bytes)?;
    let data = BASE64_STANDARD.encode(png);
    let caption = escape(caption);
    Ok(format!(
        "<figure><img alt=\"{caption}\" src=\"data:image/png;base64,{data}\"><figcaption>{caption}</figcaption></figure>"
    ))
}

fn escape(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}
