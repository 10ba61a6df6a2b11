//! The record of a render.

use steradian::film::slot::BLOCK_SAMPLES;
use steradian::film::source::DeviceInfo;
use steradian::integrator::Settings;
use steradian::output::part::keyword;
use steradian::output::record::{self, Record, Stages};
use steradian::render::bands::Totals;
use steradian::scene;

use super::Args;

/// The run's record; what it measures of time is filled in as the stages end.
pub fn make(
    args: &Args,
    film_of_scene: &scene::Film,
    settings: &Settings,
    totals: &Totals,
    device: &DeviceInfo,
    seconds: Stages,
    notes: Vec<String>,
) -> Record {
    let mut record = Record {
        program: concat!("steradian ", env!("CARGO_PKG_VERSION")).into(),
        command: std::env::args().collect::<Vec<_>>().join(" "),
        scene: args.scene.scene.display().to_string(),
        width: film_of_scene.width,
        height: film_of_scene.height,
        crop: film_of_scene.crop,
        filter: Some(film_of_scene.filter),
        seed: settings.seed,
        integrator: keyword(settings.integrator),
        estimator: keyword(settings.estimator),
        sampler: keyword(settings.sampler),
        max_depth: settings.max_depth,
        spp: match totals.spread {
            Some(_) => totals.samples / film_of_scene.window().pixel_count() as u64,
            None => u64::from(totals.min_block_count * BLOCK_SAMPLES),
        },
        adaptive: totals.spread,
        stopped_by: totals.stopped_by.name().into(),
        wall_s: 0.0,
        seconds,
        relmse_est: totals.error,
        relmse_est_exposure: totals.whole.map(|e| e.relmse_exposure),
        relmse_est_heavy_tails: totals.is_heavy_tailed,
        relmse_est_trimmed: totals.whole.map(|e| e.relmse_trimmed),
        peak_host_bytes: record::peak_host_bytes(),
        peak_device_bytes: device.peak_bytes,
        film_bytes: totals.film_bytes as u64,
        device: device.name.clone(),
        device_kind: device.kind.clone(),
        driver: device.driver.clone(),
        kernel_hash: device.kernel_hash.clone(),
        ledger: totals.ledger.clone(),
        notes,
        ..Record::default()
    };
    record.set_rates(totals.samples, totals.rays);
    record
}
