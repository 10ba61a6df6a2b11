//! Reports: what `inspect` and `bench` print.

pub mod bench_instances;
pub mod bench_rays;
pub mod converge;
pub mod inspect;
pub mod samples;
pub mod sheet;
pub mod specialise;
